//! A picture as PNG.

use crate::render::Picture;
use std::io::Write;

impl Picture {
    /// Writes it as PNG.
    ///
    /// # Errors
    /// Those of `out`; a picture without pixels or of more than 2³² in one direction.
    pub fn write_png(&self, out: impl Write) -> Result<(), png::EncodingError> {
        let side = |length: usize| u32::try_from(length).map_err(|_| png::EncodingError::LimitsExceeded);
        let mut encoder = png::Encoder::new(out, side(self.width)?, side(self.height)?);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()
    }
}

//! Walks the pixels, on all cores.

use crate::camera::{Camera, Lens, bounds, subject};
use crate::light::{Light, Seed};
use crate::palette::{self, Coloring};
use crate::stage::Stage;
use ishigaki::Vec3;
use ishigaki_recording::{Frame, Scene};

/// How a picture is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Style {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Samples along each side of a pixel: its square in all.
    pub samples: u32,
    /// Where the eye stands; `None`: where it sees all that moves.
    pub camera: Option<Camera>,
    /// What colors say.
    pub coloring: Coloring,
    /// Draws the contacts of the frame as arrows, as long as their impulses say.
    pub contacts: bool,
}

impl Default for Style {
    fn default() -> Self {
        Self { width: 1280, height: 720, samples: 4, camera: None, coloring: Coloring::Name, contacts: false }
    }
}

/// Rows of pixels from the top, three bytes each: red, green, blue (sRGB).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// `3 × width × height`.
    pub rgb: Vec<u8>,
}

/// Draws a frame of a scene. The same input gives the same picture, on any number of cores.
pub fn render(scene: &Scene, frame: &Frame, style: &Style) -> Picture {
    let (width, height) = (style.width.max(1), style.height.max(1));
    let aspect = width as f32 / height as f32;
    let camera = style.camera.unwrap_or_else(|| Camera::framing(scene, frame, aspect));
    let lens = Lens::new(camera, scene.up, aspect);
    let points = subject(scene, frame);
    let size = size_of(&points);
    let arrows = style.contacts.then_some(0.16 * size);
    let stage = Stage::new(scene, frame, style.coloring, arrows).without_curtains(scene, frame, camera.eye);
    let light = Light::new(&lens, scene.up, size, (camera.target - camera.eye).length(), lens.pixel(height));
    let canvas = Canvas { stage, light, lens, width, height, side: style.samples.clamp(1, 16) };

    let mut rgb = vec![0; 3 * width * height];
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    // Bands of rows in turn: some parts of a picture are more work than others.
    let mut shares: Vec<Vec<(usize, &mut [u8])>> = (0..cores).map(|_| Vec::new()).collect();
    for (y, row) in rgb.chunks_exact_mut(3 * width).enumerate() {
        shares[y % cores].push((y, row));
    }
    std::thread::scope(|scope| {
        for share in shares {
            scope.spawn(|| share.into_iter().for_each(|(y, row)| canvas.draw_row(y, row)));
        }
    });
    Picture { width, height, rgb }
}

struct Canvas {
    stage: Stage,
    light: Light,
    lens: Lens,
    width: usize,
    height: usize,
    side: u32,
}

impl Canvas {
    fn draw_row(&self, y: usize, row: &mut [u8]) {
        for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
            let light = self.pixel(x, y);
            pixel.copy_from_slice(&light.to_array().map(palette::byte));
        }
    }

    /// The mean of samples on a grid that is shaken a little.
    fn pixel(&self, x: usize, y: usize) -> Vec3 {
        let number = (y * self.width + x) as u32;
        let shift = (palette::fraction(2 * number), palette::fraction(2 * number + 1));
        let (side, samples) = (self.side, self.side * self.side);
        let mut sum = Vec3::ZERO;
        for sample in 0..samples {
            let seed = Seed { shift, sample, samples };
            let jitter = |k: u32| palette::fraction(number.wrapping_mul(2 * samples).wrapping_add(2 * sample + k));
            let at = |pixel: usize, cell: u32, k: u32, of: usize| {
                (pixel as f32 + (cell as f32 + jitter(k)) / side as f32) / of as f32
            };
            let (u, v) = (at(x, sample % side, 0, self.width), at(y, sample / side, 1, self.height));
            sum += self.light.along(&self.stage, self.lens.eye, self.lens.direction(u, v), seed);
        }
        sum / samples as f32
    }
}

/// Diagonal of the box around points, m.
fn size_of(points: &[Vec3]) -> f32 {
    let (least, greatest) = bounds(points);
    let size = (greatest - least).length();
    if size.is_finite() { size.max(1e-3) } else { 1.0 }
}

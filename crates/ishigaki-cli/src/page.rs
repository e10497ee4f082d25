//! The built page: its files, and the replay page with a recording inside. `web/FORMAT.md` says what they agree on.

use crate::failure::{At, Failure};
use crate::output::AtomicFile;
use base64::engine::GeneralPurpose;
use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::{self, Write};
use std::path::Path;

/// `(path under web/dist, content)`; empty if the page was not there when this program was built.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page_files.rs"));

/// The replay page.
pub const REPLAY: &str = "replay.html";
/// The live page.
pub const LIVE: &str = "index.html";
/// Where a recording goes.
const PLACEHOLDER: &[u8] = b"@ISHIGAKI_RECORDING@";

/// A file of the page by its path.
pub fn file(name: &str) -> Option<&'static [u8]> {
    FILES.iter().find(|(path, _)| *path == name).map(|&(_, content)| content)
}

/// The same, or what to do.
pub fn file_or_advice(name: &str) -> Result<&'static [u8], Failure> {
    let advice = "this program was built without its web page: run `just web` in the repository (it needs npm), \
                  then build again; `ishigaki picture` needs no page";
    file(name).ok_or_else(|| Failure::input(advice))
}

/// The type of a file, by its ending.
pub fn mime(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or("") {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" => "application/json",
        "wasm" => "application/wasm",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "md" | "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

/// Writes the replay page with the recording that is written to it: in pieces, never as a whole in memory.
pub struct PageFile {
    encoder: GzEncoder<EncoderWriter<'static, GeneralPurpose, AtomicFile>>,
    /// What follows the recording.
    rest: &'static [u8],
}

impl PageFile {
    /// Writes what comes before the recording.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let (start, rest) = split(file_or_advice(REPLAY)?).map_err(Failure::other)?;
        let mut file = AtomicFile::create(path)?;
        file.write_all(start).other_at(path.display())?;
        let encoder = GzEncoder::new(EncoderWriter::new(file, &STANDARD), Compression::default());
        Ok(Self { encoder, rest })
    }

    /// Ends the recording and the page, and gives the file its name.
    pub fn commit(self) -> Result<(), Failure> {
        let mut file = self.encoder.finish().and_then(|mut base64| base64.finish()).other_at("the page")?;
        file.write_all(self.rest).other_at(file.path().display())?;
        file.commit()
    }
}

impl Write for PageFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.encoder.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        // A flush in the middle of a stream would only make it longer.
        Ok(())
    }
}

/// A page before and after its only placeholder.
fn split(page: &[u8]) -> Result<(&[u8], &[u8]), &'static str> {
    let mut places = page.windows(PLACEHOLDER.len()).enumerate().filter(|(_, window)| *window == PLACEHOLDER);
    match (places.next(), places.next()) {
        (Some((at, _)), None) => Ok((&page[..at], &page[at + PLACEHOLDER.len()..])),
        _ => Err("the built replay page has not exactly one place for a recording: build it again with `just web`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_exactly_one_place_for_a_recording() {
        assert_eq!(split(b"<a>@ISHIGAKI_RECORDING@</a>"), Ok((&b"<a>"[..], &b"</a>"[..])));
        assert!(split(b"<a></a>").is_err());
        assert!(split(b"@ISHIGAKI_RECORDING@@ISHIGAKI_RECORDING@").is_err());
    }

    #[test]
    fn an_embedded_page_keeps_to_the_agreement() {
        // Nothing to test where the page has not been built.
        let Some(page) = file(REPLAY) else { return };
        split(page).unwrap();
        assert!(file(LIVE).is_some(), "both pages are built together");
    }
}

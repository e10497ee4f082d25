//! The recordings that a run makes (`--record`, `--html`), and those that a command reads.

use crate::failure::{At, Failure};
use crate::number;
use crate::output::AtomicFile;
use crate::page::PageFile;
use clap::Args;
use ishigaki::World;
use ishigaki_recording::{About, Camera, Recorder, Recording};
use ishigaki_scenes::file::CameraFile;
use std::path::{Path, PathBuf};

#[derive(Args)]
pub struct Recordings {
    /// Record the run, for `ishigaki view` and `ishigaki picture`.
    #[arg(long, value_name = "FILE.ishi")]
    pub record: Option<PathBuf>,
    /// Record the run into one web page that plays offline in any browser.
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
    /// Record only every Nth step (and the last).
    #[arg(long, value_name = "N", default_value = "1", value_parser = number::steps, allow_hyphen_values = true)]
    record_every: u64,
    /// Record the contacts too: points, normals, impulses.
    #[arg(long)]
    record_contacts: bool,
}

/// The recordings while they are made.
pub struct Films {
    file: Option<Recorder<AtomicFile>>,
    page: Option<Recorder<PageFile>>,
}

impl Recordings {
    /// Starts them with the world as it stands.
    pub fn start(&self, world: &World, name: &str, dt: f32, camera: Option<CameraFile>) -> Result<Films, Failure> {
        if self.record.is_none() && self.html.is_none() && (self.record_every != 1 || self.record_contacts) {
            return Err(Failure::input("--record-every and --record-contacts need --record or --html"));
        }
        let about = About {
            name: name.into(),
            dt,
            every: self.record_every,
            contacts: self.record_contacts,
            camera: camera.map(|c| Camera { position: c.position, target: c.target }),
        };
        let file = match &self.record {
            Some(path) => Some(Recorder::new(AtomicFile::create(path)?, world, &about).other_at(path.display())?),
            None => None,
        };
        let page = match &self.html {
            Some(path) => Some(Recorder::new(PageFile::create(path)?, world, &about).other_at(path.display())?),
            None => None,
        };
        Ok(Films { file, page })
    }
}

impl Films {
    /// To be called after every step.
    pub fn step(&mut self, world: &World) -> Result<(), Failure> {
        if let Some(file) = &mut self.file {
            file.step(world).other_at("--record")?;
        }
        if let Some(page) = &mut self.page {
            page.step(world).other_at("--html")?;
        }
        Ok(())
    }

    /// Completes the files and gives them their names.
    pub fn commit(self, world: &World) -> Result<(), Failure> {
        if let Some(file) = self.file {
            file.finish(world).other_at("--record")?.commit()?;
        }
        if let Some(page) = self.page {
            page.finish(world).other_at("--html")?.commit()?;
        }
        Ok(())
    }
}

/// The bytes of a file.
pub fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    let shown = path.display();
    if path.is_dir() {
        return Err(Failure::input(format!("{shown}: is a directory; name a recording in it")));
    }
    std::fs::read(path)
        .map_err(|e| Failure::input(format!("{shown}: {e}; `ishigaki run SCENE --record FILE.ishi` makes a recording")))
}

/// A whole, sound recording.
pub fn parse<'a>(bytes: &'a [u8], path: &Path) -> Result<Recording<'a>, Failure> {
    Recording::read(bytes).input_at(path.display())
}

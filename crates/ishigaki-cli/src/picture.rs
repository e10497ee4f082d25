//! `ishigaki picture`: draws a frame of a recording, without a browser or a display.

use crate::failure::{At, Failure};
use crate::output::AtomicFile;
use crate::recordings;
use clap::Args;
use ishigaki::Vec3;
use ishigaki_picture::{Camera, Coloring, Style, render};
use ishigaki_recording::Scene;
use std::path::PathBuf;

/// Larger pictures are a slip of the pen: 16,384 × 16,384 already takes hours.
const LARGEST_SIDE: usize = 16_384;

#[derive(Args)]
pub struct Picture {
    /// A recording made by `ishigaki run SCENE --record`.
    #[arg(value_name = "FILE.ishi")]
    recording: PathBuf,
    /// Which frame, from 0; default: the last.
    #[arg(long, value_name = "N", conflicts_with = "time")]
    frame: Option<usize>,
    /// The frame at this time of the run, s.
    #[arg(long, value_name = "S")]
    time: Option<f64>,
    /// The file to write.
    #[arg(long, value_name = "FILE.png")]
    png: PathBuf,
    /// Pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1280x720", value_parser = size)]
    size: (usize, usize),
    /// Where the eye is and what it looks at, m; `scene`: as the scene suggests; `auto`: all that moves fills the picture.
    #[arg(long, value_name = "X,Y,Z:X,Y,Z", default_value = "auto", value_parser = viewpoint, allow_hyphen_values = true)]
    camera: Viewpoint,
    /// What colors say: name, height, island or state.
    #[arg(long, value_name = "WHAT", default_value = "name", value_parser = coloring)]
    color: Coloring,
    /// Draw the contacts as arrows of their impulses; the run needs --record-contacts.
    #[arg(long)]
    contacts: bool,
    /// Samples along each side of a pixel, 1 to 16: smoother and slower.
    #[arg(long, value_name = "N", default_value = "4", value_parser = clap::value_parser!(u32).range(1..=16))]
    samples: u32,
}

impl Picture {
    pub fn execute(&self) -> Result<(), Failure> {
        let shown = self.recording.display();
        let bytes = recordings::read(&self.recording)?;
        let recording = recordings::parse(&bytes, &self.recording)?;
        let last = recording.len() - 1;
        let at = self.frame.unwrap_or_else(|| match self.time {
            // The last frame that is not after it.
            Some(time) => {
                (0..=last).rev().find(|&i| recording.measures(i).is_some_and(|m| m.time <= time + 1e-9)).unwrap_or(0)
            }
            None => last,
        });
        let Some(frame) = recording.frame(at) else {
            return Err(Failure::input(format!("--frame {at}: the frames of {shown} are 0 to {last}")));
        };
        let scene = recording.scene();
        if self.contacts && !scene.contacts {
            let advice =
                "no contacts are in it; record it with `ishigaki run SCENE --record FILE.ishi --record-contacts`";
            return Err(Failure::input(format!("--contacts: {shown}: {advice}")));
        }
        let style = Style {
            width: self.size.0,
            height: self.size.1,
            samples: self.samples,
            camera: self.camera.in_scene(scene),
            coloring: self.color,
            contacts: self.contacts,
        };
        let mut file = AtomicFile::create(&self.png)?;
        render(scene, &frame, &style).write_png(&mut file).other_at(self.png.display())?;
        file.commit()
    }
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let side = |text: &str| text.parse().ok().filter(|side| (1..=LARGEST_SIDE).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| side(width).zip(side(height)));
    sides.ok_or_else(|| format!("must be WIDTHxHEIGHT in pixels, each 1 to {LARGEST_SIDE}, such as 1280x720"))
}

/// What `--camera` says.
#[derive(Clone, Copy)]
enum Viewpoint {
    Auto,
    Scene,
    At(Camera),
}

impl Viewpoint {
    fn in_scene(self, scene: &Scene) -> Option<Camera> {
        match self {
            Self::Auto => None,
            Self::Scene => scene.camera.map(|hint| Camera { eye: hint.position, target: hint.target }),
            Self::At(camera) => Some(camera),
        }
    }
}

fn viewpoint(text: &str) -> Result<Viewpoint, String> {
    match text {
        "auto" => Ok(Viewpoint::Auto),
        "scene" => Ok(Viewpoint::Scene),
        _ => camera(text).map(Viewpoint::At),
    }
}

fn camera(text: &str) -> Result<Camera, String> {
    let point = |text: &str| {
        let numbers: Option<Vec<f32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
        let point = Vec3::from_array(<[f32; 3]>::try_from(numbers?).ok()?);
        point.is_finite().then_some(point)
    };
    let points = text.split_once(':').and_then(|(eye, target)| point(eye).zip(point(target)));
    match points {
        Some((eye, target)) if eye != target => Ok(Camera { eye, target }),
        _ => Err("must be auto, scene, or the eye and another point that it looks at, such as 4,2,6:0,1,0".into()),
    }
}

fn coloring(text: &str) -> Result<Coloring, String> {
    let known = Coloring::ALL.into_iter().find(|(name, _)| *name == text);
    known.map(|(_, coloring)| coloring).ok_or_else(|| "must be name, height, island or state".into())
}

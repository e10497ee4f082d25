//! Runs the built program in a folder of its own.

#![allow(dead_code, reason = "each test binary uses its part")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A box that falls on a ball on the ground, beside a door: contacts, friction, a joint.
pub const SMALL: &str = r#"{
  "name": "small",
  "steps": 30,
  "bodies": [
    { "name": "ground", "kind": "fixed", "shapes": [{ "geometry": { "half_space": {} } }] },
    { "name": "ball", "position": [0, 0.5, 0], "shapes": [{ "geometry": { "ball": { "radius": 0.5 } } }] },
    { "name": "box, \"tilted\"", "position": [0.1, 1.8, 0], "angular_velocity": [0.3, 0.2, 1],
      "shapes": [{ "geometry": { "cuboid": { "half_extents": [0.4, 0.3, 0.5] } } }] },
    { "name": "door", "position": [4, 2, 0], "shapes": [{ "geometry": { "cuboid": { "half_extents": [0.5, 1, 0.05] } } }] }
  ],
  "joints": [
    { "body_a": "ground", "body_b": "door", "kind": { "hinge": {} },
      "frame": { "world": { "position": [3.5, 2, 0], "axis": [0, 0, 1] } } }
  ]
}"#;

/// A folder that starts empty and goes with the test.
pub struct Folder(PathBuf);

impl Folder {
    pub fn new(test: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
        let _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub fn with_small(test: &str) -> Self {
        let folder = Self::new(test);
        folder.write("small.json", SMALL);
        folder
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.0.join(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap()
    }

    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Names of all files in it, hidden ones too.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_ishigaki"));
        command.args(arguments).current_dir(&self.0).stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs to success; gives stdout.
    pub fn ok(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments:?}: {}\n{}", output.status, stderr(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    pub fn json(&self, arguments: &[&str]) -> serde_json::Value {
        serde_json::from_str(&self.ok(arguments)).unwrap()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

//! Files that are never half-written, and a stdout that may close early.

use crate::failure::{At, Failure};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file that appears under its name only when it is complete.
///
/// It grows under a temporary name in the same folder; `commit` renames it, dropping it without `commit`
/// removes it. A device or a pipe is written directly: it cannot be replaced by a file.
pub struct AtomicFile {
    path: PathBuf,
    /// `None` for devices and pipes.
    temporary: Option<PathBuf>,
    file: BufWriter<File>,
}

impl AtomicFile {
    /// Fails at once if the file cannot be written: better than after a long run.
    pub fn create(path: &Path) -> Result<Self, Failure> {
        let shown = path.display();
        // Through a symbolic link: what it points to is replaced, not the link.
        let path = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if path.is_dir() {
            return Err(Failure::input(format!("{shown}: is a directory; name a file in it")));
        }
        if path.exists() && !path.is_file() {
            let file = OpenOptions::new().write(true).open(&path).input_at(&shown)?;
            return Ok(Self { path, temporary: None, file: BufWriter::new(file) });
        }
        let Some(name) = path.file_name() else {
            return Err(Failure::input(format!("{shown}: names no file")));
        };
        let mut hidden = std::ffi::OsString::from(".");
        hidden.push(name);
        hidden.push(format!(".{}.tmp", std::process::id()));
        let temporary = path.with_file_name(hidden);
        let file = File::create(&temporary)
            .map_err(|e| Failure::input(format!("{shown}: cannot be written: {e}; does its folder exist?")))?;
        Ok(Self { path, temporary: Some(temporary), file: BufWriter::new(file) })
    }

    /// Flushes everything to the disk and gives the file its name.
    pub fn commit(mut self) -> Result<(), Failure> {
        self.finish().other_at(self.path.display())
    }

    fn finish(&mut self) -> io::Result<()> {
        self.file.flush()?;
        if let Some(temporary) = &self.temporary {
            self.file.get_ref().sync_all()?;
            fs::rename(temporary, &self.path)?;
            self.temporary = None;
        }
        Ok(())
    }

    /// For messages.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            // Nothing better can be done if this fails: the program is already failing.
            let _ = fs::remove_file(temporary);
        }
    }
}

/// Writes a result to stdout. A reader that has seen enough (`| head`) is no failure.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
    match written {
        Err(e) if e.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other.other_at("stdout"),
    }
}

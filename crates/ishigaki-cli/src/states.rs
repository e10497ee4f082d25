//! The table of states: one line per body and recorded step.

use crate::failure::{At, Failure};
use crate::output::AtomicFile;
use ishigaki::World;
use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;

/// Columns: p is the origin of the body (m), q its rotation, v the velocity of its center (m/s), w in rad/s, world.
const HEADER: &str = "step,time,body,name,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz";

/// Writes every `every`th state of a world as comma-separated values.
pub struct StateTable {
    file: AtomicFile,
    every: u64,
}

impl StateTable {
    pub fn create(path: &Path, every: u64) -> Result<Self, Failure> {
        let mut file = AtomicFile::create(path)?;
        writeln!(file, "{HEADER}").other_at(path.display())?;
        Ok(Self { file, every })
    }

    /// Records the state after `done` steps of this run, if it is its turn.
    pub fn record(&mut self, done: u64, world: &World) -> Result<(), Failure> {
        if !done.is_multiple_of(self.every) {
            return Ok(());
        }
        write_states(&mut self.file, world).other_at(self.file.path().display())
    }

    pub fn commit(self) -> Result<(), Failure> {
        self.file.commit()
    }
}

fn write_states(out: &mut impl Write, world: &World) -> io::Result<()> {
    for (handle, body) in world.bodies() {
        write!(out, "{},{:?},{},{}", world.step_count(), world.time(), handle.index(), quoted(body.name()))?;
        let (p, q) = (body.position(), body.rotation());
        let (v, w) = (body.velocity(), body.angular_velocity());
        // `{:?}` gives the shortest digits that read back as the same number.
        for value in [p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z] {
            write!(out, ",{value:?}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// A name as one field: quoted where it must be (RFC 4180).
fn quoted(name: &str) -> Cow<'_, str> {
    if name.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", name.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_one_field() {
        assert_eq!(quoted("brick 3"), "brick 3");
        assert_eq!(quoted("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}

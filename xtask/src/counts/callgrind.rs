//! Running callgrind, and reading what its own reader prints.

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Where counting begins and ends.
const STEP: &str = "*World*::step_with";

/// Instructions of a run.
pub struct Profile {
    /// All within `World::step`.
    pub total: u64,
    /// By function, with those of what it calls.
    functions: Vec<(String, u64)>,
}

impl Profile {
    /// Of the functions whose path ends so. Generic ones have the same path for all their types.
    pub fn inclusive(&self, end: &str) -> u64 {
        self.functions.iter().filter(|(path, _)| path.ends_with(end)).map(|(_, count)| count).sum()
    }

    /// From the lines of `callgrind_annotate`: `1,234 (5.6%)  file:function [object]`.
    fn parse(text: &str) -> Option<Self> {
        let mut profile = Self { total: 0, functions: Vec::new() };
        for line in text.lines() {
            let Some((count, rest)) = line.trim_start().split_once(' ') else { continue };
            let Ok(count) = count.replace(',', "").parse() else { continue };
            if rest.ends_with("PROGRAM TOTALS") {
                profile.total = count;
            } else if let Some((_, function)) = rest.split_once(':') {
                profile.functions.push((path(function), count));
            }
        }
        (profile.total > 0).then_some(profile)
    }
}

/// `a::<impl b::C>::d [object]` and `<b::C>::d [object]`, as compilers of different years name a method, as `b::C::d`
/// at their ends.
fn path(function: &str) -> String {
    let name = function.rsplit_once(" [").map_or(function, |(name, _)| name);
    format!("::{}", name.replace("<impl ", "").replace(['<', '>'], ""))
}

/// Runs a program; `file` is where callgrind writes.
pub fn run(program: &Path, arguments: &[&str], file: &Path) -> Result<Profile, String> {
    let mut valgrind = Command::new("valgrind");
    valgrind.args(["--tool=callgrind", &format!("--toggle-collect={STEP}")]);
    valgrind.arg(format!("--callgrind-out-file={}", file.display())).arg(program).args(arguments);
    succeed(valgrind.stdin(Stdio::null()))?;
    let mut reader = Command::new("callgrind_annotate");
    let output = succeed(reader.args(["--inclusive=yes", "--threshold=100"]).arg(file))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Profile::parse(&text).ok_or_else(|| format!("{}: nothing was counted in {STEP}", file.display()))
}

fn succeed(command: &mut Command) -> Result<Output, String> {
    let output = command.output().map_err(|e| format!("cannot start {:?}: {e}", command.get_program()))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if output.status.success() { Ok(output) } else { Err(format!("{command:?}: {}\n{said}", output.status)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_to_name_a_method_are_read() {
        let text = "\
--------------
1,300 (100.0%)  PROGRAM TOTALS

Ir                    file:function
1,200 (92.3%)  ???:ishigaki::solve::<impl ishigaki::world::World>::solve [/bin/ishigaki]
   30 ( 2.3%)  ???:<ishigaki::world::World>::solve [/bin/ishigaki]
   20 ( 1.5%)  ???:<ishigaki::world::World>::unsolve [/bin/ishigaki]
    4 ( 0.3%)  ./string/memcpy.S:memcpy [/lib/libc.so]";
        let profile = Profile::parse(text).unwrap();
        assert_eq!(
            (profile.total, profile.inclusive("::World::solve"), profile.inclusive("::memcpy")),
            (1300, 1230, 4)
        );
    }

    #[test]
    fn a_run_without_a_step_is_no_profile() {
        assert!(Profile::parse("0 (100.0%)  PROGRAM TOTALS\n").is_none());
    }
}

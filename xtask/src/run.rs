//! Running cargo.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::Instant;

/// The repository, as cargo says at run time: clones that share a target folder share this program too.
pub fn root() -> PathBuf {
    let here = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    let here = Path::new(&here);
    here.parent().unwrap_or(here).to_path_buf()
}

/// Where cargo builds.
pub fn target_directory() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// `cargo ARGUMENTS` in the repository; `toolchain` as in `cargo +nightly`.
pub fn cargo(toolchain: Option<&str>, arguments: &[&str]) -> Command {
    // Cargo names itself to its children, but that cargo takes no `+nightly`: only the one on the path does.
    let own = std::env::var_os("CARGO").filter(|_| toolchain.is_none());
    let mut command = Command::new(own.unwrap_or_else(|| "cargo".into()));
    if let Some(toolchain) = toolchain {
        command.arg(format!("+{toolchain}"));
        for variable in ["CARGO", "RUSTC", "RUSTDOC", "RUSTUP_TOOLCHAIN"] {
            command.env_remove(variable);
        }
    }
    command.args(arguments).current_dir(root());
    command
}

/// The program `name`, built through the integration test `test` of its package, which needs it. With these packages and a
/// test, dependencies have the features that they have for `cargo test --workspace`; `cargo build --package` would ask for
/// fewer, and so compile nearly all of them a second time.
pub fn program(name: &str, test: &str) -> Result<PathBuf, String> {
    let arguments = ["test", "--quiet", "--workspace", "--no-run", "--test", test];
    execute(&format!("program {name}"), &mut cargo(None, &arguments))?;
    Ok(target_directory().join("debug").join(format!("{name}{}", std::env::consts::EXE_SUFFIX)))
}

/// Runs a command to its end, says how long it took.
pub fn execute(title: &str, command: &mut Command) -> Result<(), String> {
    eprintln!("── {title}");
    let start = now();
    let status = command.status().map_err(|e| format!("{title}: cannot start {:?}: {e}", command.get_program()))?;
    report(title, status, start)
}

/// The same beside other commands, which leave a core idle here and there; what it says comes in one piece at its end.
pub fn execute_beside(title: &'static str, mut command: Command) -> JoinHandle<Result<(), String>> {
    eprintln!("── {title}: begins beside what follows");
    std::thread::spawn(move || {
        let start = now();
        let output = command.stdin(Stdio::null()).output();
        let output = output.map_err(|e| format!("{title}: cannot start {:?}: {e}", command.get_program()))?;
        let [built, tested] = [&output.stderr, &output.stdout].map(|bytes| String::from_utf8_lossy(bytes));
        eprint!("── {title}\n{built}{tested}");
        report(title, output.status, start)
    })
}

fn report(title: &str, status: ExitStatus, start: Instant) -> Result<(), String> {
    let word = if status.success() { "ok" } else { "FAILED" };
    eprintln!("── {title}: {word} after {:.1} s", start.elapsed().as_secs_f64());
    if status.success() { Ok(()) } else { Err(format!("{title}: {status}")) }
}

#[expect(clippy::disallowed_methods, reason = "the ban is the engine's; chores may say how long they took")]
fn now() -> Instant {
    Instant::now()
}

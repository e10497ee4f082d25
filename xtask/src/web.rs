//! `cargo xtask web`: the engine as wasm, its JavaScript side, then the page in `web/dist`.
//!
//! The JavaScript side is written by wasm-bindgen's own library, of the version in `Cargo.lock`: there is no second
//! program to install and to keep in step. It is large, so it is behind a feature and this program calls itself.

use crate::run::{cargo, execute, program, root, target_directory};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

const TRIPLE: &str = "wasm32-unknown-unknown";

/// Builds all of the page.
pub fn build() -> Result<(), String> {
    if let Some(why) = missing() {
        return Err(format!("the page cannot be built: {why}"));
    }
    wasm()?;
    let web = root().join("web");
    if is_older(&web.join("node_modules/.package-lock.json"), &web.join("package-lock.json")) {
        execute("npm ci", npm(&["ci", "--no-audit", "--no-fund", "--loglevel=error"]).current_dir(&web))?;
    }
    execute("npm run build", npm(&["run", "--silent", "build"]).current_dir(&web))?;
    // Cargo watches the files that it was told of, and the page was not there when the command line was built last.
    let script = root().join("crates/ishigaki-cli/build.rs");
    let touched = fs::File::options().append(true).open(&script).and_then(|file| file.set_modified(now()));
    touched.map_err(|e| format!("{}: {e}", script.display()))
}

/// The page in a real browser, and the bits of the engine in it against those of the native program.
pub fn test() -> Result<(), String> {
    let native = program("ishigaki", "run")?;
    let mut tests = npm(&["test", "--silent"]);
    execute("web", tests.env("ISHIGAKI_BIN", native).current_dir(root().join("web")))
}

/// Why the page cannot be tested, or `None`.
pub fn browser_missing() -> Option<String> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let usual = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].map(PathBuf::from);
    if named.into_iter().chain(usual).any(|path| path.exists()) {
        return None;
    }
    Some("no Chromium: `apt-get install chromium`, or name one in CHROMIUM".into())
}

fn now() -> std::time::SystemTime {
    std::time::SystemTime::now()
}

/// The engine, and the module that loads it, into `web/generated`.
fn wasm() -> Result<(), String> {
    let mut compile = cargo(None, &["build", "--profile", "web", "--target", TRIPLE, "--package", "ishigaki-web"]);
    // Every browser of the last years has 128-bit SIMD.
    compile.env("RUSTFLAGS", "-C target-feature=+simd128");
    execute("wasm", &mut compile)?;
    let wasm = target_directory().join(TRIPLE).join("web/ishigaki_web.wasm");
    let generated = root().join("web/generated");
    let mut command = cargo(None, &["run", "--quiet", "--package", "xtask", "--features", "bindgen", "--", "bindgen"]);
    execute("bindings", command.arg(wasm).arg(generated))
}

/// `cargo xtask bindgen WASM FOLDER`, in the program that has the library.
#[cfg(feature = "bindgen")]
pub fn bindgen(wasm: &str, folder: &str) -> Result<(), String> {
    let mut bindgen = wasm_bindgen_cli_support::Bindgen::new();
    let made =
        bindgen.input_path(wasm).out_name("ishigaki").web(true).and_then(|b| b.typescript(true).generate(folder));
    made.map_err(|e| format!("{wasm}: {e:#}"))
}

/// What the page cannot be built without, and how to get it; or `None`.
pub fn missing() -> Option<String> {
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).current_dir(root()).output().ok()?;
    let sysroot = PathBuf::from(String::from_utf8_lossy(&sysroot.stdout).trim());
    if !sysroot.join("lib/rustlib").join(TRIPLE).exists() {
        return Some(format!("no wasm target: `rustup target add {TRIPLE}`"));
    }
    let answers = npm(&["--version"]).stdout(Stdio::null()).stderr(Stdio::null()).status();
    if answers.is_ok_and(|status| status.success()) { None } else { Some("no npm: install Node.js 20 or later".into()) }
}

/// npm with arguments; on Windows it is a script.
pub fn npm(arguments: &[&str]) -> Command {
    let mut command = Command::new(if cfg!(windows) { "npm.cmd" } else { "npm" });
    command.args(arguments);
    command
}

/// Whether `made` is missing or older than `source`.
fn is_older(made: &std::path::Path, source: &std::path::Path) -> bool {
    let time = |path: &std::path::Path| fs::metadata(path).and_then(|m| m.modified());
    match (time(made), time(source)) {
        (Ok(made), Ok(source)) => made < source,
        _ => true,
    }
}

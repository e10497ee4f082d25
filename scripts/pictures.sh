#!/usr/bin/env bash
# Draws the pictures of the README again: docs/pictures/*. Usage: bash scripts/pictures.sh
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --quiet --package ishigaki-cli
ishigaki=${CARGO_TARGET_DIR:-target}/release/ishigaki
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# draw NAME SCENE STEPS [RUN OPTIONS] -- [PICTURE OPTIONS]
draw() {
  local name=$1 scene=$2 steps=$3 run=()
  shift 3
  while [[ $1 != -- ]]; do run+=("$1"); shift; done
  shift
  "$ishigaki" run "$scene" --steps "$steps" --quiet --record "$work/$name.ishi" --record-every "$steps" \
    --record-contacts "${run[@]}" >"$work/$name.txt"
  "$ishigaki" picture "$work/$name.ishi" --png "docs/pictures/$name.png" --size 800x450 --samples 5 "$@"
  echo "docs/pictures/$name.png"
}

draw arch arch 120 --set rest.sleep.enabled=false --set rest.aggressive_sleep.enabled=false -- --contacts
draw pile pile 240 -- --color name
draw card_house card_house 300 -- --color name

# Plots of experiments, as they are in the book.
for name in euler-vs-angular-momentum friction-box-vs-disk weight-feeling; do
  "$ishigaki" experiment "$name" --out "$work/plots" --quiet
  cp "$work/plots/$name.svg" docs/pictures/
  echo "docs/pictures/$name.svg"
done

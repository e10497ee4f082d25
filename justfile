# Thin names for the real commands; nothing here does more than they do.

default:
    @just --list

# The wall, as in the README.
wall:
    cargo run --release -- run wall

# Every test there is.
test:
    cargo xtask test

# The browser page into web/dist: the engine as wasm, the live testbed, the replay player.
web:
    cargo xtask web

# The book into book/book, with all experiments.
book *options:
    bash scripts/book.sh {{options}}

# What CI checks before the tests.
lint:
    cargo fmt --all --check
    cargo clippy --workspace --all-targets -- -D warnings
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

fuzz seconds="30" seed="1":
    cargo xtask fuzz --seed {{seed}} --seconds {{seconds}}

# What CI runs, from setup to the fuzz run.
ci:
    bash .ci/run

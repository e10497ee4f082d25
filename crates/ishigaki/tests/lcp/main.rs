//! The laboratory against oracles that know nothing of it, and against the engine. TALK C.

mod classics;

mod oracle;
mod oracles;
mod problems;

//! The laboratory against oracles that know nothing of it, and against the engine. TALK C.

mod classics;
mod export;
mod friction;
mod friction_contact;
mod oracle;
mod oracles;
mod problems;

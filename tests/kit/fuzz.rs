//! What `tests/fuzz` runs on bytes by chance: plain functions that panic if something is wrong.
//!
//! They are here, and not in the targets, so that they are compiled and tried with everything else
//! (`tests/fuzz.rs`), on any compiler.

mod bytes;
mod extract;
mod files;

pub use extract::extract;
pub use files::{mesh_file, volume_file};

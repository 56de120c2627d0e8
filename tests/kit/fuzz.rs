//! What `tests/fuzz` runs on bytes by chance: plain functions that panic if something is wrong.
//!
//! They are here, and not in the targets, so that they are compiled and tried with everything else
//! (`tests/fuzz.rs`), on any compiler.

mod bytes;
mod extract;
mod files;
mod made;
pub mod promises;

pub use extract::{extract, pieces, refine};
pub use files::{mesh_file, volume_file};

/// What is done with bytes by chance.
pub type Target = fn(&[u8]);

/// The target of a name.
pub fn target(name: &str) -> Option<Target> {
    let all: [(&str, Target); 5] = [
        ("extract", extract),
        ("refine", refine),
        ("pieces", pieces),
        ("volume_file", volume_file),
        ("mesh_file", mesh_file),
    ];
    all.into_iter().find(|(own, _)| *own == name).map(|(_, target)| target)
}

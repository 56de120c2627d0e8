//! Which files a command reads and writes, so that none of them takes the place of another.

use crate::fault::UsageError;
use isokit::io::Output;
use std::path::{Path, PathBuf};

/// Endings of headers and of the files that usually hold what these describe.
const PARTS: [(&str, &[&str]); 5] = [
    ("nhdr", &["raw", "raw.gz"]),
    ("mhd", &["raw", "zraw"]),
    ("hdr", &["img", "img.gz"]),
    ("gltf", &["bin"]),
    ("obj", &["mtl"]),
];

/// The files that are known so far, and who named them.
#[derive(Clone, Debug)]
pub(super) struct Places(Vec<Named>);

#[derive(Clone, Debug)]
struct Named {
    by: &'static str,
    path: PathBuf,
    /// Where it lies, links followed: the same for all names of a file.
    place: PathBuf,
}

impl Places {
    /// The input. Nothing is opened yet; a file beside a header, of the name that its data usually has,
    /// is taken for its data.
    pub(super) fn of_input(path: &Path) -> Self {
        let mut places = Self(vec![]);
        places.read("the input", path);
        places
    }

    /// Adds a file that is read too, be it the input again, with its data.
    pub(super) fn read(&mut self, by: &'static str, path: &Path) {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let parts = PARTS.iter().filter(|(header, _)| *header == ending);
        let parts = parts.flat_map(|(_, parts)| *parts).map(|part| path.with_extension(part));
        let parts = parts.filter(|part| part.is_file());
        self.0.extend([path.to_owned()].into_iter().chain(parts).map(|path| Named::new(by, &path)));
    }

    /// Adds a file that will be written, and says by which option.
    pub(super) fn add(&mut self, by: &'static str, path: &Path) -> Result<(), UsageError> {
        let new = Named::new(by, path);
        if let Some(old) = self.0.iter().find(|old| old.place == new.place) {
            let (old_by, old, new) = (old.by, old.path.display(), path.display());
            return Err(UsageError(format!(
                "{old_by} ({old}) and {by} ({new}) are the same file: choose another name for {by}"
            )));
        }
        self.0.push(new);
        Ok(())
    }
}

impl Named {
    fn new(by: &'static str, path: &Path) -> Self {
        Self { by, path: path.to_owned(), place: Output::place(path) }
    }
}

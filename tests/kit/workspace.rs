//! The files of this project, and its manifests as far as the house rules ask.

use std::{
    fs,
    path::{Path, PathBuf},
};

/// The project's folder.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the workspace")
}

/// A file of the project.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Its path from the project's folder on, with `/` between the parts.
    pub name: String,
    /// What it says.
    pub text: String,
}

/// Every text file whose name ends so; build output and hidden folders aside.
///
/// # Panics
///
/// If one cannot be read.
pub fn files(ending: &str) -> Vec<SourceFile> {
    let paths =
        paths_below(root()).into_iter().filter(|path| path.to_string_lossy().ends_with(ending));
    let mut files: Vec<SourceFile> = paths
        .map(|path| SourceFile {
            name: name_of(&path),
            text: fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display())),
        })
        .collect();
    files.sort_by(|a, b| a.name.cmp(&b.name));
    assert!(!files.is_empty(), "no file ends in {ending}");
    files
}

/// The files in a folder and all below it, hidden ones and build output aside.
///
/// # Panics
///
/// If a folder cannot be read.
pub fn paths_below(folder: &Path) -> Vec<PathBuf> {
    let (mut found, mut left) = (vec![], vec![folder.to_path_buf()]);
    while let Some(folder) = left.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let is_output = name.starts_with('.')
                || ["target", "__pycache__", "node_modules"].contains(&name.as_str());
            match path.is_dir() {
                true if !is_output => left.push(path),
                false if !name.starts_with('.') => found.push(path),
                _ => {}
            }
        }
    }
    found
}

fn name_of(path: &Path) -> String {
    let inner = path.strip_prefix(root()).unwrap_or(path);
    inner.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// A manifest as sections of lines. It understands the plain TOML that this project writes.
#[derive(Clone, Debug)]
pub struct Manifest<'a> {
    sections: Vec<(&'a str, Vec<&'a str>)>,
}

impl<'a> Manifest<'a> {
    /// Cuts a manifest into its sections, empty lines and lines of comment aside.
    pub fn parse(text: &'a str) -> Self {
        let mut sections = vec![("", vec![])];
        for line in text.lines().map(str::trim) {
            match line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
                Some(name) => sections.push((name, vec![])),
                None if line.is_empty() || line.starts_with('#') => {}
                None => sections.last_mut().expect("one at least").1.push(line),
            }
        }
        Self { sections }
    }

    /// The lines of a section; none if there is no such section.
    pub fn section(&self, name: &str) -> Vec<&'a str> {
        let named = self.sections.iter().filter(|(section, _)| *section == name);
        named.flat_map(|(_, lines)| lines).copied().collect()
    }

    /// The name of the package.
    pub fn name(&self) -> Option<&'a str> {
        let value = |line: &&'a str| line.strip_prefix("name = \"")?.strip_suffix('"');
        self.section("package").iter().find_map(value)
    }

    /// What it imports, in whichever of the ways a dependency can be written.
    pub fn imports(&self) -> Vec<&'a str> {
        const KINDS: [&str; 3] = ["dependencies", "dev-dependencies", "build-dependencies"];
        let mut imports = vec![];
        for (section, lines) in &self.sections {
            let section = section.rsplit_once("'.").map_or(*section, |(_, kind)| kind);
            for kind in KINDS {
                if section == kind {
                    let names = lines.iter().filter_map(|line| line.split(['.', '=', ' ']).next());
                    imports.extend(names.map(|name| name.trim_matches('"')));
                } else if let Some(name) =
                    section.strip_prefix(kind).and_then(|s| s.strip_prefix('.'))
                {
                    imports.push(name);
                }
            }
        }
        imports
    }
}

#[cfg(test)]
mod tests {
    use super::Manifest;

    const MANIFEST: &str = r#"
# what it is
[package]
name = "isokit-volume"
license.workspace = true

[dependencies]
# the ground
isokit-geom.workspace = true
isokit-job = { workspace = true, features = ["x"] }
glam = "0.34" # plain

[dev-dependencies.proptest]
workspace = true

[target.'cfg(unix)'.dependencies]
libc = "0.2"

[lints]
workspace = true
"#;

    #[test]
    fn a_dependency_is_seen_however_it_is_written() {
        let imports = Manifest::parse(MANIFEST).imports();
        assert_eq!(imports, ["isokit-geom", "isokit-job", "glam", "proptest", "libc"]);
    }

    #[test]
    fn sections_are_told_apart() {
        let manifest = Manifest::parse(MANIFEST);
        assert_eq!(manifest.name(), Some("isokit-volume"));
        assert_eq!(manifest.section("lints"), ["workspace = true"]);
        assert_eq!(manifest.section("lints.rust"), [""; 0]);
    }
}

//! Names of surfaces, as files and OBJ can bear them.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

/// Longer file names than this some systems refuse; there is room left for a folder's prefix and ending.
const LONGEST: usize = 120;

/// A name without what ends a word or a line, or joins lines; never empty.
pub(super) fn word(name: &str) -> String {
    let is_apart = |c: char| c.is_whitespace() || c.is_control() || c == '\\';
    let word: String = name.trim().chars().map(|c| if is_apart(c) { '_' } else { c }).collect();
    if word.is_empty() { "surface".to_owned() } else { word }
}

/// A name on one line: what would break the line is a blank.
pub(super) fn line(name: &str) -> String {
    name.chars().map(|c| if c.is_control() || is_line_end(c) { ' ' } else { c }).collect()
}

fn is_line_end(c: char) -> bool {
    matches!(c, '\u{2028}' | '\u{2029}')
}

/// A name with letters, digits, `-`, `_` and `.` only.
fn file_word(name: &str) -> String {
    let is_safe = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.');
    let mut safe: String = word(name).chars().map(|c| if is_safe(c) { c } else { '_' }).collect();
    while safe.len() > LONGEST {
        safe.pop();
    }
    safe
}

/// The names made different from each other, by a number at the end. Letters are compared without case,
/// as some file systems do.
pub(super) fn distinct(names: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut taken = HashSet::new();
    let mut free = |name: &str| taken.insert(name.to_lowercase());
    let one = |name: String| {
        if free(&name) {
            return name;
        }
        let numbered = (2..).map(|number: u64| format!("{name}_{number}"));
        numbered.into_iter().find(|name| free(name)).unwrap_or(name)
    };
    names.into_iter().map(one).collect()
}

/// `head.ply` and names of surfaces: `head_skin.ply`, `head_bone.ply`, …
pub(super) fn beside<'a>(path: &Path, names: impl IntoIterator<Item = &'a str>) -> Vec<PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let names = distinct(names.into_iter().map(file_word));
    names.iter().map(|name| path.with_file_name(format!("{stem}_{name}.{ending}"))).collect()
}

#[cfg(test)]
mod tests {
    use super::{beside, distinct, word};
    use std::path::{Path, PathBuf};

    #[test]
    fn words_have_no_blanks_and_are_never_empty() {
        assert_eq!(word(" left  lung\n2 "), "left__lung_2");
        assert_eq!(word(" \t"), "surface");
        assert_eq!(word("Knochen/größer"), "Knochen/größer");
    }

    #[test]
    fn same_names_get_numbers() {
        let names = ["a", "A", "a_2", "a"].map(String::from);
        assert_eq!(distinct(names), ["a", "A_2", "a_2_2", "a_3"]);
    }

    #[test]
    fn files_stand_beside_the_one_asked_for() {
        let found = beside(Path::new("out/head.v1.ply"), ["skin", "../bone", "skin"]);
        let expected =
            ["out/head.v1_skin.ply", "out/head.v1_.._bone.ply", "out/head.v1_skin_2.ply"];
        assert_eq!(found, expected.map(PathBuf::from));
    }
}

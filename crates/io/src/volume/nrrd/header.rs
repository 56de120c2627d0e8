//! The lines of the header.

use super::super::files::DataFiles;
use crate::{
    Format, ReadFault,
    bytes::Bytes,
    text::{Field, Lines, shown},
};
use std::path::Path;

/// Fields by name, and the files that hold the samples where they are elsewhere.
pub(super) struct Header {
    fields: Vec<Field>,
    /// With the field that names them, and the number of axes per file where it is given.
    pub(super) files: Option<(DataFiles, Field, Option<usize>)>,
    /// Bytes up to the end of the blank line.
    pub(super) bytes: u64,
    /// Lines, for what is missing.
    lines: u64,
}

impl Header {
    pub(super) fn read(bytes: Bytes, path: &Path) -> Result<Self, ReadFault> {
        let mut lines = Lines::new(Format::Nrrd, bytes);
        let magic = lines.next()?.unwrap_or_default();
        if !matches!(magic.trim_end().strip_prefix("NRRD000"), Some("1" | "2" | "3" | "4" | "5")) {
            return Err(lines.broken("NRRD0001 to NRRD0005", shown(&magic)));
        }
        let (mut fields, mut files): (Vec<Field>, _) = (vec![], None);
        while let Some(line) = lines.next()? {
            if line.is_empty() {
                break;
            }
            if line.starts_with('#') {
                continue;
            }
            let Some(mut field) = lines.field(&line, ':') else {
                return Err(lines.broken("a field (name: value)", shown(&line)));
            };
            // `name:=value` is a pair of the user's, not a field.
            if field.value.starts_with('=') {
                continue;
            }
            field.name = known_as(field.name);
            if fields.iter().any(|earlier| earlier.name == field.name) {
                return Err(field.broken_as("each field once", format!("{} again", field.name)));
            }
            if field.name == "data file" {
                let (found, axes) = DataFiles::parse(&field, path, &mut lines)?;
                files = Some((found, field.clone(), axes));
            }
            fields.push(field);
        }
        Ok(Self { fields, files, bytes: lines.position(), lines: lines.line() })
    }

    pub(super) fn get(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// A field that no NRRD lacks.
    pub(super) fn need(&self, name: &'static str) -> Result<&Field, ReadFault> {
        self.get(name).ok_or_else(|| {
            let end = Field {
                format: Format::Nrrd,
                line: self.lines,
                name: name.to_owned(),
                value: String::new(),
            };
            end.broken_as(format!("the field {name:?}"), "the end of the header".into())
        })
    }
}

/// One name for a field that has several.
fn known_as(name: String) -> String {
    let known = match name.as_str() {
        "datafile" => "data file",
        "lineskip" => "line skip",
        "byteskip" => "byte skip",
        _ => return name,
    };
    known.to_owned()
}

/// Words in quotes.
pub(super) fn quoted(field: &Field) -> Result<Vec<String>, ReadFault> {
    let mut words = vec![];
    let mut rest = field.value.trim();
    while !rest.is_empty() {
        let word = rest.strip_prefix('"').and_then(|rest| rest.split_once('"'));
        let (word, after) = word.ok_or_else(|| field.broken("words in quotes"))?;
        words.push(word.trim().to_owned());
        rest = after.trim_start();
    }
    Ok(words)
}

/// Vectors in parentheses, `none` for an axis that has no direction. Components after the third, such
/// as time, are left out; components that are not there are 0.
pub(super) fn vectors(field: &Field) -> Result<Vec<Option<[f64; 3]>>, ReadFault> {
    const EXPECTED: &str = "vectors like (1,0,0), or none";
    let mut vectors = vec![];
    let mut rest = field.value.trim();
    while !rest.is_empty() {
        if let Some(after) = rest.strip_prefix("none").or_else(|| rest.strip_prefix("???")) {
            vectors.push(None);
            rest = after.trim_start();
            continue;
        }
        let vector = rest.strip_prefix('(').and_then(|rest| rest.split_once(')'));
        let (vector, after) = vector.ok_or_else(|| field.broken(EXPECTED))?;
        let components = vector.split(',').map(|number| number.trim().parse::<f64>());
        let components: Result<Vec<_>, _> = components.collect();
        let components = components.map_err(|_| field.broken(EXPECTED))?;
        let component = |k: usize| components.get(k).copied().unwrap_or(0.0);
        vectors.push(Some(std::array::from_fn(component)));
        rest = after.trim_start();
    }
    Ok(vectors)
}

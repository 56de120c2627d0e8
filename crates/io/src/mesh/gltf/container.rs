//! The two parts of a file: JSON, and in GLB a buffer behind it.

use super::mark;
use crate::{Format, Place, ReadFault, mesh::input::MeshFile};
use gltf_json::Root;

/// The content of a file.
pub(super) struct Container<'a> {
    pub(super) root: Root,
    /// The buffer inside the file, if there is one.
    pub(super) bin: Option<&'a [u8]>,
}

impl<'a> Container<'a> {
    pub(super) fn open(file: MeshFile<'a>) -> Result<Self, ReadFault> {
        let (json, start, bin) = match file.format {
            Format::Glb => split(file)?,
            _ => {
                let json = file.bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(file.bytes);
                (json, 0, None)
            }
        };
        let root = Root::from_slice(json).map_err(|error| {
            let line = Place::Line(error.line() as u64);
            let place = if start == 0 { line } else { Place::Byte(start + error.column() as u64) };
            file.broken(place, "JSON of glTF 2.0", error.to_string())
        })?;
        let version = &root.asset.version;
        if !version.starts_with("2.") {
            return Err(file.unsupported(Place::Byte(start), format!("glTF {version}")));
        }
        Ok(Self { root, bin })
    }
}

/// The JSON, where it starts, and the buffer.
type Parts<'a> = (&'a [u8], u64, Option<&'a [u8]>);

/// The parts of a GLB.
fn split(file: MeshFile<'_>) -> Result<Parts<'_>, ReadFault> {
    let held = file.bytes.len() as u64;
    if word(file.bytes, 0) != Some(mark::MAGIC) {
        return Err(file.broken(Place::Byte(0), "\"glTF\"", "something else"));
    }
    let [version, length] = [4, 8].map(|at| word(file.bytes, at).unwrap_or(0));
    if version != mark::VERSION {
        return Err(file.unsupported(Place::Byte(4), format!("GLB version {version}")));
    }
    if u64::from(length) > held || u64::from(length) < mark::HEADER {
        return Err(file.truncated("GLB", length.into(), held));
    }
    let all = &file.bytes[..length as usize];
    let (json, next) = chunk(file, all, mark::HEADER, mark::JSON)?;
    let json =
        json.ok_or_else(|| file.broken(Place::Byte(mark::HEADER), "a chunk of JSON", "none"))?;
    let bin = if next < u64::from(length) { chunk(file, all, next, mark::BIN)?.0 } else { None };
    Ok((json, mark::HEADER + mark::CHUNK, bin))
}

/// The content of the chunk at a place, if it is of this kind, and where the next one begins.
fn chunk<'a>(
    file: MeshFile<'_>,
    all: &'a [u8],
    at: u64,
    kind: u32,
) -> Result<(Option<&'a [u8]>, u64), ReadFault> {
    let start = at as usize;
    let (Some(length), Some(found)) = (word(all, start), word(all, start + 4)) else {
        return Err(file.broken(Place::Byte(at), "a chunk of 8 bytes or more", "the end"));
    };
    let (start, end) = (at + mark::CHUNK, at + mark::CHUNK + u64::from(length));
    let content = all.get(start as usize..end as usize);
    let content = content.ok_or_else(|| {
        file.truncated("a chunk", length.into(), (all.len() as u64).saturating_sub(start))
    })?;
    Ok(((found == kind).then_some(content), end))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    let word = bytes.get(at..at + 4)?;
    Some(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
}

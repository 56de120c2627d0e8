//! What a file will be, from counts and bounds: all sizes are known, and within the format's limits, before
//! the first byte.

use super::{
    content::Bounds,
    document::{Content, document},
    layout::{self, Shape, layout},
    mark,
};
use crate::{
    Format, Output, WriteError, WriteFault,
    mesh::{MeshContext, Written, outline::Outline},
};
use isokit_mesh::Counts;
use std::{
    io::Write,
    path::{Path, PathBuf},
};

/// A surface as it will stand in the buffer; one without triangles will not.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) outline: Outline,
    pub(super) bounds: Bounds,
    /// Whether a vertex lets through what is behind it.
    pub(super) is_translucent: bool,
}

/// What will be written.
pub(super) struct Plan {
    json: Vec<u8>,
    /// Bytes of the buffer.
    pub(super) buffer: u64,
}

/// Goes on if surfaces of these sizes can fit, before anything is done that takes time.
pub(in crate::mesh) fn check<'a>(
    format: Format,
    outlines: impl IntoIterator<Item = &'a Outline>,
) -> Result<(), WriteFault> {
    // With JSON of no size at all.
    let shapes = outlines.into_iter().filter(is_seen).map(shape);
    layout::check(format, 0, layout(shapes).1)
}

/// Whether there is something to see.
pub(super) fn is_seen(outline: &&Outline) -> bool {
    outline.counts.triangles > 0
}

fn shape(outline: &Outline) -> Shape {
    let Outline { counts, has_normals, has_colors, has_values, .. } = *outline;
    let Counts { vertices, triangles } = counts;
    Shape { vertices, triangles, has_normals, has_colors, has_values }
}

impl Plan {
    /// The plan of a GLB, or with a URI of a buffer beside it, of a glTF.
    pub(super) fn new(
        parts: &[Part],
        context: &MeshContext,
        uri: Option<String>,
    ) -> Result<Self, WriteFault> {
        let format = if uri.is_some() { Format::Gltf } else { Format::Glb };
        let seen = parts.iter().map(|part| &part.outline).filter(is_seen);
        let (blocks, buffer) = layout(seen.map(shape));
        let mut blocks = blocks.into_iter();
        let node = |part: &'_ Part| {
            let blocks = if is_seen(&&part.outline) { blocks.next() } else { None };
            blocks.map(|blocks| Content {
                blocks,
                bounds: part.bounds,
                is_translucent: part.is_translucent,
            })
        };
        let contents: Vec<_> = parts.iter().map(node).collect();
        let heads = parts.iter().map(|part| &part.outline.head);
        let nodes: Vec<_> = heads.zip(contents).collect();
        let root = document(&nodes, context, (buffer, uri));
        let json = root.to_vec().map_err(|error| WriteFault::Caller(error.to_string().into()))?;
        layout::check(format, json.len() as u64, buffer)?;
        Ok(Self { json, buffer })
    }

    /// All that comes before the buffer in a GLB.
    pub(super) fn glb_head(&self) -> Vec<u8> {
        let json = layout::padded(self.json.len() as u64);
        let total = layout::glb_bytes(self.json.len() as u64, self.buffer);
        // The plan is within 32 bits.
        let word = |word: u64| (word as u32).to_le_bytes();
        let mut head = [mark::MAGIC.into(), mark::VERSION.into(), total, json, mark::JSON.into()]
            .map(word)
            .concat();
        head.extend_from_slice(&self.json);
        head.extend_from_slice(&b"   "[..json as usize - self.json.len()]);
        if self.buffer > 0 {
            head.extend([self.buffer, mark::BIN.into()].map(word).as_flattened());
        }
        head
    }
}

/// The buffer of a glTF at `path`, and how the JSON names it.
pub(super) struct Bin {
    pub(super) path: PathBuf,
    pub(super) uri: String,
}

impl Bin {
    pub(super) fn beside(path: &Path) -> Self {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{stem}.bin");
        Self { path: path.with_file_name(&name), uri: encoded(&name) }
    }

    /// Writes the JSON to its file and what `put` puts to that of the buffer, which gets its name first.
    pub(super) fn finish(
        self,
        mut json: Output,
        plan: &Plan,
        put: impl FnOnce(&mut Output) -> Result<(), WriteFault>,
        written: &mut Written,
    ) -> Result<(), WriteError> {
        let path = json.path().to_owned();
        // All the way, so that no buffer appears if there is no room for the JSON.
        let whole = json.write_all(&plan.json).and_then(|()| json.flush());
        whole.map_err(|error| WriteFault::Io(error).at(&path))?;
        if plan.buffer > 0 {
            let mut out = Output::create(&self.path)?;
            put(&mut out).map_err(|fault| fault.at(&self.path))?;
            out.finish()?;
            written.files.push(self.path);
        }
        json.finish()?;
        written.files.push(path);
        Ok(())
    }
}

/// A file name as a URI may hold it (RFC 3986).
fn encoded(name: &str) -> String {
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-._~".contains(&byte);
    let one = |byte: u8| {
        if is_plain(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }
    };
    name.bytes().map(one).collect()
}

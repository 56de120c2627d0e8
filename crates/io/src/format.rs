//! What a file is: by its content first, then by its name.

use crate::{ReadError, ReadFault, bytes::Bytes};
use std::{fmt, io::Read, path::Path};

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Format {
    /// NIfTI-1 and NIfTI-2, one file or a pair.
    Nifti,
    /// Nearly Raw Raster Data, attached or detached header.
    Nrrd,
    /// MetaImage, one file or header and data.
    MetaImage,
    /// NumPy's array file.
    Npy,
    /// Samples and nothing else.
    Raw,
    /// glTF 2.0 in one binary file.
    Glb,
    /// glTF 2.0 as JSON with its buffers beside it.
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// The Stanford polygon format.
    Ply,
    /// Stereolithography.
    Stl,
}

impl Format {
    /// Short and lower-case, as reports name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Nifti => "nifti",
            Self::Nrrd => "nrrd",
            Self::MetaImage => "metaimage",
            Self::Npy => "npy",
            Self::Raw => "raw",
            Self::Glb => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
        }
    }

    /// Whether such a file holds a volume; the others hold a mesh.
    pub const fn is_volume(self) -> bool {
        matches!(self, Self::Nifti | Self::Nrrd | Self::MetaImage | Self::Npy | Self::Raw)
    }

    /// The format that the first bytes of a file show, any gzip or bzip2 taken off. A kilobyte is
    /// enough. `None` also for formats without a mark of their own: raw, OBJ, most binary STL.
    pub fn of_content(head: &[u8]) -> Option<Self> {
        const MARKS: [(&[u8], Format); 6] = [
            (b"NRRD000", Format::Nrrd),
            (b"\x93NUMPY", Format::Npy),
            (b"glTF", Format::Glb),
            (b"ply\n", Format::Ply),
            (b"ply\r", Format::Ply),
            (b"solid", Format::Stl),
        ];
        let marked = MARKS.into_iter().find(|(mark, _)| head.starts_with(mark));
        let shaped = || match () {
            () if is_nifti(head) => Some(Self::Nifti),
            () if is_metaimage(head) => Some(Self::MetaImage),
            () if is_gltf(head) => Some(Self::Gltf),
            () => None,
        };
        marked.map(|(_, format)| format).or_else(shaped)
    }

    /// The format that a name ends in; `.gz` or `.bz2` after it is ignored.
    pub fn of_name(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
        let name = [".gz", ".bz2"].into_iter().find_map(|end| name.strip_suffix(end));
        let name = name.map_or_else(|| path.to_path_buf(), Into::into);
        match name.extension()?.to_string_lossy().to_ascii_lowercase().as_str() {
            "nii" | "hdr" | "img" => Some(Self::Nifti),
            "nrrd" | "nhdr" => Some(Self::Nrrd),
            "mha" | "mhd" => Some(Self::MetaImage),
            "npy" => Some(Self::Npy),
            "raw" => Some(Self::Raw),
            "glb" => Some(Self::Glb),
            "gltf" => Some(Self::Gltf),
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            _ => None,
        }
    }
}

/// What the file at `path` is: by its content where that tells, else by its name.
///
/// # Errors
///
/// If the file cannot be opened, or if neither tells.
pub fn detect(path: &Path) -> Result<Format, ReadError> {
    /// The longest binary header, and some lines of any text header.
    const HEAD: u64 = 4096;
    let mut head = vec![];
    let bytes = Bytes::open(path)?;
    let stl_bytes = bytes.exactly_left().unwrap_or(0);
    // What is wrong with the rest, the format's own reader finds and can name.
    let _ = bytes.take(HEAD).read_to_end(&mut head);
    let by_size = is_binary_stl(&head, stl_bytes).then_some(Format::Stl);
    let found = Format::of_content(&head).or(by_size).or_else(|| Format::of_name(path));
    let unknown = "neither content nor name tells the format; known are NIfTI, NRRD, MetaImage, \
                   NPY, raw (with sizes and sample type), GLB, glTF, OBJ, PLY and STL";
    found.ok_or_else(|| ReadFault::Caller(unknown.into()).at(path))
}

/// Size field and magic of NIfTI; for Analyze 7.5, which has no magic, a sound number of axes.
fn is_nifti(head: &[u8]) -> bool {
    let is = |at: usize, mark: &[u8]| head.get(at..at + mark.len()) == Some(mark);
    let axes = |low: usize, high: usize| {
        head.len() >= 348 && head[high] == 0 && (1..=7).contains(&head[low])
    };
    let one = is(344, b"n+1\0") || is(344, b"ni1\0");
    let two = is(4, b"n+2\0") || is(4, b"ni2\0");
    let little = (is(0, &348_i32.to_le_bytes()) && (one || axes(40, 41)))
        || (is(0, &540_i32.to_le_bytes()) && two);
    let big = (is(0, &348_i32.to_be_bytes()) && (one || axes(41, 40)))
        || (is(0, &540_i32.to_be_bytes()) && two);
    little || big
}

/// Lines `Key = Value`, among them one of the two keys that every MetaImage starts with.
fn is_metaimage(head: &[u8]) -> bool {
    let key = |line: &[u8]| {
        let end = line.iter().position(|&byte| byte == b'=')?;
        Some(line[..end].trim_ascii().to_ascii_lowercase())
    };
    let mut keys = head.split(|&byte| byte == b'\n').map_while(key);
    keys.any(|key| key == b"objecttype" || key == b"ndims")
}

/// JSON that speaks of an asset.
fn is_gltf(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    text.trim_start_matches('\u{feff}').trim_start().starts_with('{') && text.contains("\"asset\"")
}

/// 80 bytes of anything, a count, and just as many triangles of 50 bytes.
fn is_binary_stl(head: &[u8], file_bytes: u64) -> bool {
    let count = head.get(80..84).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    count.is_some_and(|count| 84 + 50 * u64::from(count) == file_bytes)
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nifti => "NIfTI",
            Self::Nrrd => "NRRD",
            Self::MetaImage => "MetaImage",
            Self::Npy => "NPY",
            Self::Raw => "raw",
            Self::Glb => "GLB",
            Self::Gltf => "glTF",
            Self::Obj => "OBJ",
            Self::Ply => "PLY",
            Self::Stl => "STL",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Format, detect};
    use std::{fs, path::Path};

    #[test]
    fn a_name_tells_with_and_without_compression() {
        let of = |name: &str| Format::of_name(Path::new(name));
        assert_eq!(of("a/b.nii"), Some(Format::Nifti));
        assert_eq!(of("a/b.NII.GZ"), Some(Format::Nifti));
        assert_eq!(of("x.seg.nrrd"), Some(Format::Nrrd));
        assert_eq!(of("head.raw.bz2"), Some(Format::Raw));
        assert_eq!(of("cow.obj"), Some(Format::Obj));
        assert_eq!(of("no_extension"), None);
        assert_eq!(of("readme.txt"), None);
    }

    #[test]
    fn content_wins_over_the_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wrong.stl");
        fs::write(&path, "NRRD0004\ntype: short\n\n").unwrap();
        assert_eq!(detect(&path).unwrap(), Format::Nrrd);
        fs::write(&path, "Comment = x\r\nNDims = 3\r\n").unwrap();
        assert_eq!(detect(&path).unwrap(), Format::MetaImage);
        fs::write(&path, "  {\"asset\": {\"version\": \"2.0\"}}").unwrap();
        assert_eq!(detect(&path).unwrap(), Format::Gltf);
    }

    #[test]
    fn a_binary_stl_is_told_by_its_size() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part");
        let mut bytes = vec![0; 84 + 100];
        bytes[80] = 2;
        fs::write(&path, &bytes).unwrap();
        assert_eq!(detect(&path).unwrap(), Format::Stl);
        bytes.pop();
        fs::write(&path, &bytes).unwrap();
        let error = detect(&path).unwrap_err().to_string();
        assert!(error.contains("part: neither content nor name tells the format"), "{error}");
    }
}

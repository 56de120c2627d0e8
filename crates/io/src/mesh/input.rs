//! Reading a mesh: the format found, the file brought to memory, the rest left to the format's own reader.
//!
//! A mesh file is read whole, under the job's limit, before it is understood. So what a header announces
//! is checked against bytes that are there, and no memory is taken on its word.

use super::{gltf, obj, ply, stl};
use crate::{Format, Place, ReadError, ReadFault, bytes::Bytes, detect};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_mesh::Surface;
use std::{
    borrow::Cow,
    path::{Component, Path, PathBuf},
};

/// A mesh file as it is in memory: z up, in its own unit.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MeshInput {
    /// What it holds; in glTF one for each primitive, in OBJ one for each object.
    pub surfaces: Vec<Surface>,
    /// What it is.
    pub format: Format,
    /// The unit of its coordinates. For glTF that another program wrote, metre.
    pub unit: Unit,
    /// Which way its axes point.
    pub space: Space,
    /// What was assumed, changed or left out, a sentence each.
    pub notes: Vec<String>,
}

/// Reads a mesh: GLB, glTF, OBJ, PLY or STL, whichever the content shows or else the name says. One layer
/// of gzip or bzip2 is taken off.
///
/// Vertices are those of the file, in its order; STL, which has none, gets one for each place. Polygons
/// become fans of triangles. Coordinates that are not finite are kept, indices that name no vertex are not.
///
/// # Errors
///
/// If the file cannot be read, breaks its format, uses what is not supported or is larger than allowed, or
/// if the job is cancelled.
pub fn read_mesh(path: &Path, job: &Job) -> Result<MeshInput, ReadError> {
    let format = detect(path)?;
    let bytes = load(path, job)?;
    understand(MeshFile { path, format, bytes: &bytes, job })
}

/// Reads a file that is in memory.
pub(super) fn understand(file: MeshFile<'_>) -> Result<MeshInput, ReadError> {
    let at = |fault: ReadFault| fault.at(file.path);
    match file.format {
        Format::Glb | Format::Gltf => gltf::read(file),
        Format::Obj => obj::read(file).map_err(at),
        Format::Ply => ply::read(file).map_err(at),
        Format::Stl => stl::read(file).map_err(at),
        format => Err(at(ReadFault::Caller(format!("{format} holds a volume, not a mesh").into()))),
    }
}

/// Bytes read between two looks at the cancel token.
const PIECE: usize = 1 << 22;

/// All bytes of a file, unpacked.
pub(super) fn load(path: &Path, job: &Job) -> Result<Vec<u8>, ReadError> {
    let source = Bytes::open(path)?;
    drain(source, job).map_err(|fault| fault.at(path))
}

fn drain(mut source: Bytes, job: &Job) -> Result<Vec<u8>, ReadFault> {
    let exactly = source.exactly_left().unwrap_or(0);
    job.progress.begin("read", exactly);
    let mut bytes = job.limits.vec("the file", Some(exactly))?;
    loop {
        job.check()?;
        let start = bytes.len();
        let room = match (exactly as usize).saturating_sub(start) {
            // Unpacked bytes come as they come.
            0 => PIECE,
            left => PIECE.min(left),
        };
        bytes.resize(start + room, 0);
        let count = source.read_up_to(&mut bytes[start..])?;
        bytes.truncate(start + count);
        job.limits.allow("the file", Some(bytes.len() as u64), 1)?;
        job.progress.advance(count as u64);
        if count < room || bytes.len() as u64 == exactly {
            return Ok(bytes);
        }
    }
}

/// A file that is being understood.
#[derive(Clone, Copy)]
pub(super) struct MeshFile<'a> {
    pub(super) path: &'a Path,
    pub(super) format: Format,
    pub(super) bytes: &'a [u8],
    pub(super) job: &'a Job,
}

impl MeshFile<'_> {
    /// The file breaks its format.
    pub(super) fn broken(
        self,
        place: Place,
        expected: impl Into<Cow<'static, str>>,
        found: impl Into<String>,
    ) -> ReadFault {
        let (expected, found) = (expected.into(), found.into());
        ReadFault::Broken { format: self.format, place, expected, found }
    }

    /// The file is lawful, but cannot be read.
    pub(super) fn unsupported(
        self,
        place: Place,
        feature: impl Into<Cow<'static, str>>,
    ) -> ReadFault {
        ReadFault::Unsupported { format: self.format, place, feature: feature.into() }
    }

    /// The file ends before what it announces.
    pub(super) fn truncated(self, what: &'static str, announced: u64, held: u64) -> ReadFault {
        ReadFault::Truncated { format: self.format, what, announced, held }
    }

    /// The job may have been cancelled; looked at only now and then.
    pub(super) fn pace(self, count: usize) -> Result<(), ReadFault> {
        const PAUSE: usize = 1 << 16;
        if count.is_multiple_of(PAUSE) { Ok(self.job.check()?) } else { Ok(()) }
    }

    /// What a surface is called that the file gives no name.
    pub(super) fn stem(self) -> String {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        stem.strip_suffix(&format!(".{}", self.format.name())).unwrap_or(&stem).to_owned()
    }

    /// The place of a file that this one refers to: in its own folder or below, nowhere else.
    pub(super) fn sibling(self, name: &str) -> Option<PathBuf> {
        let name = Path::new(name);
        let is_below = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        let is_sound = name.file_name().is_some() && name.components().all(is_below);
        is_sound.then(|| self.path.with_file_name("").join(name))
    }
}

/// The note on a file that does not say how long a coordinate of 1 is.
pub(super) const NO_UNIT: &str = "the file does not name its unit";

/// Whether a part of a colour is not from 0 to 1, by more than rounding, or is no number.
pub(super) fn is_beyond(part: f64) -> bool {
    const ROUNDING: f64 = 1e-3;
    !(-ROUNDING..=1.0 + ROUNDING).contains(&part)
}

/// The note on so many vertices with such a part; none if there are none.
pub(super) fn beyond(count: usize) -> Option<String> {
    let vertices = if count == 1 { "vertex has a colour" } else { "vertices have colours" };
    (count > 0)
        .then(|| format!("{count} {vertices} with numbers that are not from 0 to 1; cut to that"))
}

/// The note on surfaces of these names, whose materials have a texture; none if there are none.
pub(super) fn textured(names: &[String]) -> Option<String> {
    let (first, more) = names.split_first()?;
    Some(match more.len() {
        0 => format!("the texture of surface {first:?} is not read, only the colours beside it"),
        more => format!(
            "the textures of surface {first:?} and {more} more are not read, only the colours beside them"
        ),
    })
}

/// The triangles of a polygon, all from its first corner.
pub(super) fn fan<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 3]> {
    let pairs = corners.get(1..).unwrap_or_default().windows(2);
    pairs.map(|pair| [corners[0], pair[0], pair[1]])
}

#[cfg(test)]
mod tests {
    use super::{MeshFile, fan, read_mesh};
    use crate::Format;
    use isokit_job::{Job, Limits};
    use std::{fs, path::Path};

    #[test]
    fn a_polygon_becomes_a_fan() {
        assert_eq!(fan(&[7, 8, 9, 5]).collect::<Vec<_>>(), [[7, 8, 9], [7, 9, 5]]);
        assert_eq!(fan(&[1, 2]).count() + fan::<u32>(&[]).count(), 0);
    }

    #[test]
    fn only_files_in_the_same_folder_are_followed() {
        let (path, job) = (Path::new("in/a.gltf"), Job::default());
        let file = MeshFile { path, format: Format::Gltf, bytes: &[], job: &job };
        assert_eq!(file.sibling("b/c.bin"), Some("in/b/c.bin".into()));
        for name in ["../c.bin", "/etc/passwd", "b/../../c", "", "."] {
            assert_eq!(file.sibling(name), None, "{name}");
        }
    }

    #[test]
    fn a_volume_is_no_mesh_and_a_limit_holds() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        fs::write(&path, "NRRD0004\n").unwrap();
        let error = read_mesh(&path, &Job::default()).unwrap_err().to_string();
        assert!(error.ends_with("a.obj: NRRD holds a volume, not a mesh"), "{error}");
        fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        let job = Job { limits: Limits { bytes: 20 }, ..Job::default() };
        let error = read_mesh(&path, &job).unwrap_err().to_string();
        assert!(error.ends_with("the file needs 32 bytes, the limit is 20"), "{error}");
        assert!(read_mesh(&path, &Job::default()).is_ok());
    }
}

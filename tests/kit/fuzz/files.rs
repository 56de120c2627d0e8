//! Files of any content: a volume, a mesh or an error, and no more memory than allowed.

use isokit::{
    for_any,
    io::{Format, VolumeOptions, open_colors, open_volume, read_mesh, read_volume},
    job::{Job, Limits},
    volume::{Sample, SlabSource, Volume},
};
use std::{
    env, fs,
    path::{Path, PathBuf},
    process, thread,
};

/// Bytes that one file may make us take.
const LIMIT: u64 = 1 << 20;

/// Endings of volumes that are not told by their content.
const VOLUMES: [&str; 4] = ["nii", "nhdr", "mhd", "npy"];

/// Endings of meshes.
const MESHES: [&str; 4] = ["obj", "stl", "ply", "gltf"];

fn limited() -> Job {
    Job { limits: Limits { bytes: LIMIT }, ..Job::default() }
}

/// Reads the bytes as a volume, as a whole and slice by slice, and as colours.
///
/// # Panics
///
/// If the volume is larger than allowed, if it is another slice by slice, or if an error says nothing.
pub fn volume_file(bytes: &[u8]) {
    let file = Written::new(bytes, &VOLUMES);
    let path = file.path();
    let (options, job) = (VolumeOptions::default(), limited());
    match read_volume(&path, &options, &job) {
        Ok(read) => {
            let size = read.volume.grid().count() * read.volume.dtype().bytes() as u64;
            assert!(size <= LIMIT, "{size} bytes");
            let file = open_volume(&path, &options, &job).expect("it was read");
            if file.has_slices() {
                for_any!(&read.volume, volume => assert_slices(volume, &path));
            }
        }
        Err(error) => assert_tells(&error.to_string()),
    }
    colors_in(&path);
}

/// Reads a file as colours, if it says that it is of some.
fn colors_in(path: &Path) {
    match open_colors(path, &limited()) {
        Ok(None) => {}
        Ok(Some(file)) => match file.collect(&limited()) {
            Ok(colors) => {
                let count = colors.grid().count() * colors.channels().count() as u64;
                assert!(count <= LIMIT && colors.samples().len() as u64 == count, "{count} bytes");
            }
            Err(error) => assert_tells(&error.to_string()),
        },
        Err(error) => assert_tells(&error.to_string()),
    }
}

/// The slices of the file are those of the volume.
fn assert_slices<T: Sample>(volume: &Volume<T>, path: &Path) {
    let file = open_volume(path, &VolumeOptions::default(), &limited()).expect("it was read");
    let mut source = file.into_source::<T>().expect("of the same type");
    let slice = volume.grid().slice_count() as usize;
    let mut found = vec![T::default(); slice];
    for expected in volume.samples().chunks_exact(slice) {
        source.fill(&mut found).expect("it was read");
        let bits = |samples: &[T]| -> Vec<u64> {
            samples.iter().map(|sample| sample.to_f64().to_bits()).collect()
        };
        assert!(bits(&found) == bits(expected), "{:?}", volume.grid());
    }
}

/// Reads the bytes as a mesh.
///
/// # Panics
///
/// If a triangle names a vertex that is not there, or if an error says nothing.
pub fn mesh_file(bytes: &[u8]) {
    let file = Written::new(bytes, &MESHES);
    let path = file.path();
    match read_mesh(&path, &limited()) {
        Ok(read) => {
            for mesh in read.surfaces.iter().map(|surface| &surface.mesh) {
                let count = mesh.positions.len();
                assert!(mesh.triangles.iter().flatten().all(|&v| (v as usize) < count));
                assert!(mesh.normals.as_ref().is_none_or(|normals| normals.len() == count));
            }
        }
        Err(error) => assert_tells(&error.to_string()),
    }
}

fn assert_tells(error: &str) {
    assert!((10..4000).contains(&error.len()), "{error}");
}

/// Bytes in a file, alone in a folder that goes when this is dropped.
struct Written {
    folder: PathBuf,
    name: String,
}

impl Written {
    /// With an ending that the length picks where the bytes do not tell what they are.
    fn new(bytes: &[u8], endings: &[&str]) -> Self {
        let thread = format!("{:?}", thread::current().id());
        let thread = thread.replace(|c: char| !c.is_alphanumeric(), "");
        let folder = env::temp_dir().join(format!("isokit-fuzz-{}-{thread}", process::id()));
        let ending = match Format::of_content(bytes) {
            Some(format) => format.name(),
            None => endings[bytes.len() % endings.len()],
        };
        let written = Self { folder, name: format!("file.{ending}") };
        fs::create_dir_all(&written.folder).expect("a folder for one file");
        fs::write(written.path(), bytes).expect("a small file");
        written
    }

    fn path(&self) -> PathBuf {
        self.folder.join(&self.name)
    }
}

impl Drop for Written {
    fn drop(&mut self) {
        // Nothing depends on it.
        let _ = fs::remove_dir_all(&self.folder);
    }
}

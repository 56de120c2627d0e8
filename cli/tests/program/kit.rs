//! A folder with volumes in it, and the program run in there.

use isokit::{
    geom::{Affine, Frame, Space, Unit},
    io::{MeshInput, read_mesh, write_volume},
    job::Job,
    mesh::{Topology, topology},
    volume::{Grid, Volume},
};
use isokit_cli::{Exit, run};
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// A folder of its own for each test.
pub(crate) struct Folder(tempfile::TempDir);

/// What a run of the program left.
pub(crate) struct Ran {
    pub(crate) exit: Exit,
    pub(crate) out: Vec<u8>,
    pub(crate) err: String,
}

/// Samples along x, y, z of every volume here.
pub(crate) const DIMS: [usize; 3] = [16, 14, 12];

/// Distances between them.
pub(crate) const SPACING: [f64; 3] = [1.0, 2.0, 1.5];

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    /// With the volume `ball.nii`: see [`ball`].
    pub(crate) fn with_ball() -> Self {
        let folder = Self::new();
        folder.volume("ball.nii", Space::Ras, ball);
        folder
    }

    /// Writes a volume in millimetres.
    pub(crate) fn volume(&self, name: &str, space: Space, value: impl Fn([usize; 3]) -> f32) {
        self.volume_spaced(name, SPACING, space, value);
    }

    /// The same with other distances, of which some may be negative.
    pub(crate) fn volume_spaced(
        &self,
        name: &str,
        spacing: [f64; 3],
        space: Space,
        value: impl Fn([usize; 3]) -> f32,
    ) {
        let index_to_world = Affine::axis_aligned(spacing, [10.0, 20.0, 30.0]).unwrap();
        let frame = Frame { index_to_world, unit: Unit::Millimetre, space };
        let [nx, ny, nz] = DIMS;
        let grid = Grid::new(DIMS.map(|n| n as u64), frame).unwrap();
        let point = |n: usize| [n % nx, n / nx % ny, n / nx / ny];
        let samples = (0..nx * ny * nz).map(|n| value(point(n))).collect();
        let volume = Volume::new(grid, samples).unwrap();
        write_volume(&self.path(name), &volume.into(), &Job::default()).unwrap();
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The names of all files, in order.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs a command line. A word with a dot in front of letters, such as `ball.nii` or `sub/a.ply`, is
    /// a file of this folder; so is the word after `to`, without it.
    #[track_caller]
    pub(crate) fn run(&self, line: &str) -> Ran {
        let is_file = |word: &&str| {
            let ending = Path::new(word).extension().unwrap_or_default().to_string_lossy();
            ending.starts_with(char::is_alphabetic) && !word.contains(':')
        };
        let words = line.split_whitespace().map(|word| match is_file(&word) {
            true => self.path(word).into_os_string(),
            false => word.into(),
        });
        let (mut out, mut err) = (vec![], vec![]);
        let exit = run(["isokit".into()].into_iter().chain(words), &mut out, &mut err);
        Ran { exit, out, err: String::from_utf8(err).unwrap() }
    }

    /// Runs a command line that must succeed.
    #[track_caller]
    pub(crate) fn done(&self, line: &str) -> Ran {
        let ran = self.run(line);
        assert_eq!(ran.exit, Exit::Done, "{line}: {}", ran.err);
        ran
    }

    /// Reads a mesh with the library.
    #[track_caller]
    pub(crate) fn mesh(&self, name: &str) -> MeshInput {
        read_mesh(&self.path(name), &Job::default()).unwrap()
    }

    /// What the first surface of a mesh file is.
    #[track_caller]
    pub(crate) fn topology(&self, name: &str) -> Topology {
        topology(&self.mesh(name).surfaces[0].mesh, &Job::default()).unwrap()
    }

    #[track_caller]
    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_str(&fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }
}

impl Ran {
    #[track_caller]
    pub(crate) fn text(&self) -> &str {
        str::from_utf8(&self.out).unwrap()
    }

    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.out).unwrap()
    }
}

/// A ball around the middle of the lattice: 100 at its centre, 50 at 4 mm from it, below 0 beyond 8 mm.
pub(crate) fn ball(ijk: [usize; 3]) -> f32 {
    let middle = |axis: usize| (DIMS[axis] - 1) as f64 / 2.0;
    let offset = |axis: usize| (ijk[axis] as f64 - middle(axis)) * SPACING[axis];
    let radius = (0..3).map(|axis| offset(axis).powi(2)).sum::<f64>().sqrt();
    (100.0 - 12.5 * radius) as f32
}

/// The middle of the lattice in the world.
pub(crate) const CENTRE: [f64; 3] = [17.5, 33.0, 38.25];

/// The middle between the least and the greatest coordinates of a mesh.
pub(crate) fn middle(topology: &Topology) -> [f64; 3] {
    let bounds = topology.measure.bounds.unwrap();
    std::array::from_fn(|axis| bounds.min[axis].midpoint(bounds.max[axis]))
}

#[track_caller]
pub(crate) fn assert_near(found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    let is_near = (0..3).all(|axis| (found[axis] - expected[axis]).abs() <= tolerance);
    assert!(is_near, "{found:?} is not {expected:?}");
}

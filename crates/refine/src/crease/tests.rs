//! Solids with edges have them, and what is round has none.

use crate::{
    Isosurface, RefineError, RefineOptions, Refined,
    kit::{FAR, lost},
    refine,
};
use isokit_field::{Jet, ScalarField, Slope};
use isokit_geom::{
    Aabb, Affine, Frame,
    vector::{Vector, cross, dot, length},
};
use isokit_job::{Job, Threads};
use isokit_marching_cubes::{Diagonals, ExtractOptions, extract};
use isokit_mesh::{TriMesh, topology};
use isokit_volume::{Grid, Volume};
use std::{
    num::NonZeroUsize,
    sync::atomic::{AtomicUsize, Ordering},
};

const N: usize = 24;
const MIDDLE: Vector = [11.3, 11.6, 11.45];

/// A box about [`MIDDLE`], turned, with round edges if `round` is above 0; the distance, positive inside.
struct Block {
    axes: [Vector; 3],
    half: Vector,
    round: f64,
    /// Where its first sample is in the world.
    origin: Vector,
}

impl Block {
    fn new(about: Vector, degrees: f64, half: Vector, round: f64) -> Self {
        let long = length(about);
        let [x, y, z] = about.map(|c| c / long);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let turned = |v: Vector| {
            let (across, along) = (cross([x, y, z], v), dot([x, y, z], v) * (1.0 - cos));
            [0, 1, 2].map(|k| cos * v[k] + sin * across[k] + along * [x, y, z][k])
        };
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(turned);
        Self { axes, half, round, origin: [0.0; 3] }
    }

    /// Between its axes, how far beside the faces of the box within; and the signs.
    fn beside(&self, at: Vector) -> (Vector, Vector) {
        let from = [0, 1, 2].map(|k| at[k] - MIDDLE[k]);
        let own = self.axes.map(|axis| dot(axis, from));
        let beside = [0, 1, 2].map(|k| own[k].abs() - (self.half[k] - self.round));
        (beside, own.map(f64::signum))
    }
}

impl ScalarField for Block {
    fn dims(&self) -> [usize; 3] {
        [N; 3]
    }

    fn index_to_world(&self) -> Affine {
        Affine::axis_aligned([1.0; 3], self.origin).unwrap()
    }

    fn value(&self, ijk: Vector) -> f64 {
        let (beside, _) = self.beside(ijk);
        let most = beside.into_iter().fold(f64::NEG_INFINITY, f64::max);
        self.round - length(beside.map(|c| c.max(0.0))) - most.min(0.0)
    }

    fn slope(&self, ijk: Vector) -> Slope {
        let (beside, signs) = self.beside(ijk);
        let most = beside.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let out = beside.map(|c| c.max(0.0));
        let own = match most > 0.0 {
            true => [0, 1, 2].map(|k| -signs[k] * out[k] / length(out)),
            false => {
                let k = (0..3).find(|&k| beside[k] == most).unwrap();
                let mut own = [0.0; 3];
                own[k] = -signs[k];
                own
            }
        };
        let gradient = [0, 1, 2].map(|k| (0..3).map(|n| own[n] * self.axes[n][k]).sum());
        Slope { value: self.value(ijk), gradient }
    }

    fn jet(&self, ijk: Vector) -> Jet {
        let Slope { value, gradient } = self.slope(ijk);
        Jet { value, gradient, hessian: [[0.0; 3]; 3] }
    }
}

/// The surface as it is extracted from samples.
fn plain(field: &dyn ScalarField) -> TriMesh {
    extracted(field, Diagonals::Table)
}

fn extracted(field: &dyn ScalarField, diagonals: Diagonals) -> TriMesh {
    let at = |n: usize| [n % N, n / N % N, n / N / N].map(|c| c as f64);
    let samples = (0..N * N * N).map(|n| field.value(at(n)) as f32).collect();
    let frame = Frame { index_to_world: field.index_to_world(), ..Frame::default() };
    let volume = Volume::new(Grid::new([N as u64; 3], frame).unwrap(), samples).unwrap();
    let options = ExtractOptions::DEFAULT.with_diagonals(diagonals);
    extract(&volume.view(), 0.0, &options, &Job::default()).unwrap()
}

fn creased(field: &dyn ScalarField, job: &Job) -> (TriMesh, Refined) {
    let mut mesh = plain(field);
    let found = crease_in(&mut mesh, field, job);
    (mesh, found)
}

fn crease_in(mesh: &mut TriMesh, field: &dyn ScalarField, job: &Job) -> Refined {
    let options = RefineOptions::DEFAULT.with_creases(30.0);
    refine(mesh, &Isosurface { field, iso: 0.0 }, &options, job).unwrap()
}

/// Blocks that lie along the lattice, across it, and any way.
fn blocks(round: f64) -> Vec<Block> {
    let turns = [
        ([1.0, 0.0, 0.0], 0.0),
        ([0.0, 0.0, 1.0], 45.0),
        ([1.0, 2.0, 3.0], 25.0),
        ([-3.0, 1.0, 0.5], 70.0),
        ([1.0, 1.0, 1.0], 60.0),
    ];
    turns.map(|(about, degrees)| Block::new(about, degrees, [6.2, 5.1, 3.7], round)).into()
}

#[test]
fn a_block_has_the_edges_of_a_block() {
    for block in blocks(0.0) {
        let job = Job::default();
        let (mesh, found) = creased(&block, &job);
        let known = topology(&mesh, &job).unwrap();
        assert_eq!(known.shortfalls(), [""; 0]);
        let exact = 8.0 * 6.2 * 5.1 * 3.7;
        let area = 8.0 * (6.2 * 5.1 + 5.1 * 3.7 + 3.7 * 6.2);
        let before = topology(&plain(&block), &job).unwrap().measure;
        let [was, is] = [before, known.measure].map(|m| (m.volume / exact - 1.0).abs());
        assert!(is < 1e-3 * was, "{is:e} of {was:e}");
        let [was, is] = [before, known.measure].map(|m| (m.area / area - 1.0).abs());
        assert!(is < 1e-3 * was, "{is:e} of {was:e}");
        assert!(found.creased > 100, "{found:?}");
        for place in mesh.positions.iter() {
            assert!(block.value(place).abs() < 1e-4, "{place:?}");
        }
    }
}

#[test]
fn more_blocks_are_whole_where_diagonals_were_fitted() {
    let mut state = 9_u64;
    let mut chance = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let (half, exact) = ([6.2, 5.1, 3.7], 8.0 * 6.2 * 5.1 * 3.7);
    let (mut whole, mut errors) = ([0; 2], [0.0; 2]);
    for _ in 0..240 {
        let about = [(); 3].map(|()| chance());
        let block = Block::new(about, 180.0 * chance(), half, 0.0);
        for (n, diagonals) in [Diagonals::Table, Diagonals::Fitted].into_iter().enumerate() {
            let (mut mesh, job) = (extracted(&block, diagonals), Job::default());
            crease_in(&mut mesh, &block, &job);
            let known = topology(&mesh, &job).unwrap();
            assert_eq!(known.shortfalls(), [""; 0]);
            let error = (known.measure.volume / exact - 1.0).abs();
            whole[n] += usize::from(error < 1e-5);
            errors[n] += error;
        }
    }
    assert!(whole[1] > whole[0] && whole[0] > 200, "{whole:?}");
    assert!(errors[1] < 0.6 * errors[0], "{errors:?}");
}

#[test]
fn far_away_in_a_file_of_another_unit_nothing_is_in_one_place_or_flat_that_is_not_here() {
    // Searched for, up to a million, with one look at the file left out at a time: a flat triangle or another vertex where a
    // vertex was brought onto the surface, a flat triangle at a corner, and a corner where a vertex is.
    let rare = [3_361, 91_938, 710_962, 49_441];
    let mut unscaled = [0, 0];
    for n in (0..40).chain(rare) {
        // The file's step is up to twice the one here.
        let scale = [1e-3, 1.0025e-3, 0.0254, 0.3][n as usize % 4];
        let turn = f64::from(n);
        let about = [turn.sin(), turn.cos(), 0.3];
        let block = Block::new(about, 13.0 * turn, [6.2, 5.1, [3.7, 0.7][n as usize / 4 % 2]], 0.0);
        // No farther than where f32 still tells a 64th.
        let block = Block { origin: FAR.map(|c| c + 0.37 * turn % 5000.0), ..block };
        let surface = Isosurface { field: &block, iso: 0.0 };
        let lost = |options: RefineOptions| {
            let mut mesh = plain(&block);
            let found = refine(&mut mesh, &surface, &options, &Job::default()).unwrap();
            assert!(found.creased > 100, "{found:?}");
            lost(&mesh, scale)
        };
        let options = RefineOptions::DEFAULT.with_creases(30.0);
        assert_eq!(lost(options.with_file_scale(Some(scale))), [0, 0], "{n}, {scale}");
        let found = lost(options);
        unscaled = [unscaled[0] + found[0], unscaled[1] + found[1]];
    }
    assert!(unscaled != [0, 0], "it shows nothing");
}

#[test]
fn what_is_round_has_no_crease() {
    for block in blocks(1.0) {
        let (mesh, found) = creased(&block, &Job::default());
        assert_eq!((found.creased, mesh.triangles), (0, plain(&block).triangles));
    }
}

#[test]
fn normals_beside_creases_are_those_of_faces() {
    for block in blocks(0.0) {
        let mut mesh = plain(&block);
        let held = mesh.positions.len();
        mesh.normals = Some(vec![[0.0, 0.0, 1.0]; held]);
        let options = RefineOptions::DEFAULT.with_creases(30.0);
        let surface = Isosurface { field: &block, iso: 0.0 };
        refine(&mut mesh, &surface, &options, &Job::default()).unwrap();
        let normals = mesh.normals.unwrap();
        assert_eq!(normals.len(), mesh.positions.len());
        for (v, normal) in normals.into_iter().enumerate() {
            let normal = normal.map(f64::from);
            assert!((length(normal) - 1.0).abs() < 1e-6);
            // Of two faces or three, the mean.
            let nearest = block.axes.map(|axis| dot(axis, normal).abs());
            let nearest = nearest.into_iter().fold(0.0, f64::max);
            let expected = if v < held { 1.0 - 1e-6 } else { (1.0_f64 / 3.0).sqrt() - 1e-6 };
            assert!(nearest >= expected, "{v}: {normal:?}");
        }
    }
}

#[test]
fn any_number_of_threads_makes_the_same_edges() {
    for block in blocks(0.0) {
        let threads = |n| Threads::new(NonZeroUsize::new(n).unwrap()).unwrap();
        let job = |n| Job { threads: threads(n), ..Job::default() };
        let [one, seven] = [1, 7].map(|n| creased(&block, &job(n)));
        assert!(one == seven);
    }
}

#[test]
fn angles_that_are_none_are_refused() {
    let block = &blocks(0.0)[0];
    for degrees in [0.0, 180.0, -1.0, f64::NAN] {
        let options = RefineOptions::DEFAULT.with_creases(degrees);
        let surface = Isosurface { field: block, iso: 0.0 };
        let found = refine(&mut plain(block), &surface, &options, &Job::default());
        assert!(matches!(found, Err(RefineError::Options(_))), "{degrees}");
    }
}

/// A field that knows itself within a box, and is asked for nothing beyond it.
struct Parted<'a> {
    field: &'a Block,
    inside: Option<Aabb>,
    asked: &'a AtomicUsize,
}

fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    (0..3).all(|k| outer.min[k] <= inner.min[k] && inner.max[k] <= outer.max[k])
}

impl ScalarField for Parted<'_> {
    fn dims(&self) -> [usize; 3] {
        self.field.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.field.index_to_world()
    }

    fn value(&self, ijk: Vector) -> f64 {
        self.slope(ijk).value
    }

    fn slope(&self, ijk: Vector) -> Slope {
        if let Some(inside) = self.inside {
            assert!(holds(&inside, &Aabb { min: ijk, max: ijk }), "{ijk:?} of {inside:?}");
            self.asked.fetch_add(1, Ordering::Relaxed);
        }
        self.field.slope(ijk)
    }

    fn jet(&self, ijk: Vector) -> Jet {
        self.field.jet(ijk)
    }

    fn within(&self, ijk: Aabb) -> Option<Box<dyn ScalarField + '_>> {
        assert!(self.inside.is_none_or(|inside| holds(&inside, &ijk)), "{ijk:?}");
        Some(Box::new(Parted { inside: Some(ijk), ..*self }))
    }
}

#[test]
fn fields_of_bricks_are_asked_only_within_them_and_say_what_the_whole_one_says() {
    for block in blocks(0.0).iter().chain(&blocks(1.5)) {
        let asked = AtomicUsize::new(0);
        let parted = Parted { field: block, inside: None, asked: &asked };
        let (found, expected) =
            (creased(&parted, &Job::default()), creased(block, &Job::default()));
        assert!(found == expected);
        assert!(
            asked.into_inner() > found.0.positions.len(),
            "bricks are asked about all vertices"
        );
    }
}

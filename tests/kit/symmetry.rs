//! Copies of a volume that are turned or mirrored, and what their surfaces must have in common.

use crate::{
    check::{Census, sides_of},
    modes::modes_some_fitted,
};
use isokit::{
    geom::Frame,
    job::Job,
    marching_cubes::{Diagonals, ExtractOptions, extract_into},
    mesh::{Precision, TriMesh},
    volume::{Grid, Sample, View, Volume},
};
use std::{array::from_fn, collections::BTreeMap};

/// One of the 48 ways to lay a cube onto itself. Axis `k` of the copy is `axes[k]` of the volume, backwards
/// where `flips[k]`.
#[derive(Clone, Copy, Debug)]
pub struct Symmetry {
    /// Which axis of the volume each of the copy is.
    pub axes: [usize; 3],
    /// Which axes of the copy run backwards.
    pub flips: [bool; 3],
}

impl Symmetry {
    /// What leaves all as it is.
    pub const NONE: Self = Self { axes: [0, 1, 2], flips: [false; 3] };

    /// Each once.
    pub fn all() -> Vec<Self> {
        let axes = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];
        let flips = (0..8).map(|bits| from_fn(|k| bits >> k & 1 == 1));
        flips.flat_map(|flips| axes.map(|axes| Self { axes, flips })).collect()
    }

    /// Whether right hands become left hands.
    pub fn mirrors(self) -> bool {
        let is_odd = (0..3).all(|k| self.axes[k] != (self.axes[(k + 1) % 3] + 2) % 3);
        is_odd ^ (self.flips.iter().filter(|&&flip| flip).count() % 2 == 1)
    }

    /// The copy, as a view of the same samples.
    pub fn copy<T: Sample>(self, volume: &Volume<T>) -> View<'_, T> {
        let dims = volume.grid().dims();
        let steps = [1, dims[0], dims[0] * dims[1]].map(|step| step as isize);
        let sign = |k: usize| if self.flips[k] { -1 } else { 1 };
        let strides = from_fn(|k| sign(k) * steps[self.axes[k]]);
        let last = |k: usize| (dims[self.axes[k]] as isize - 1) * steps[self.axes[k]];
        let first: isize = (0..3).filter(|&k| self.flips[k]).map(last).sum();
        let grid = Grid::new(self.axes.map(|axis| dims[axis]), Frame::default()).unwrap();
        View::strided(volume.samples(), first as usize, strides, &grid).unwrap()
    }

    /// Where a place in the copy lies in the volume.
    pub fn back(self, place: [f64; 3], dims: [u64; 3]) -> [f64; 3] {
        let mut there = [0.0; 3];
        for (k, axis) in self.axes.into_iter().enumerate() {
            let last = (dims[axis] - 1) as f64;
            there[axis] = if self.flips[k] { last - place[k] } else { place[k] };
        }
        there
    }

    /// Where a direction in the copy points to in the volume.
    fn turned_back(self, direction: [f32; 3]) -> [f32; 3] {
        let mut there = [0.0; 3];
        for (k, axis) in self.axes.into_iter().enumerate() {
            there[axis] = if self.flips[k] { -direction[k] } else { direction[k] };
        }
        there
    }
}

/// A lattice edge by twice the coordinates of its middle.
pub type Edge = [i64; 3];

/// What a vertex is on or in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Seat {
    /// On a lattice edge.
    On(Edge),
    /// Within a cell, the vertex of this number.
    Within(usize),
}

/// A cell by its first corner, and a side in it along which it meets another cell.
pub type Rim = ([i64; 3], [Seat; 2]);

/// Where vertices sit that are no samples: on an edge one coordinate is not a whole number, in a cell none is.
///
/// # Panics
///
/// If a vertex is on a sample or within a face.
pub fn seats(places: &[[f64; 3]]) -> Vec<Seat> {
    let seat = |(n, place): (usize, &[f64; 3])| {
        let edge = place.map(|c| c.floor() as i64 + c.ceil() as i64);
        match edge.iter().filter(|c| *c % 2 != 0).count() {
            1 => Seat::On(edge),
            3 => Seat::Within(n),
            _ => panic!("{place:?} is on no edge and in no cell"),
        }
    };
    places.iter().enumerate().map(seat).collect()
}

/// The cell of a triangle, by its first corner. The triangle lies in it and never in a face, so its middle is within.
pub fn cell_of(corners: [[f64; 3]; 3]) -> [i64; 3] {
    from_fn(|k| (corners.iter().map(|p| p[k]).sum::<f64>() / 3.0).floor() as i64)
}

/// The loops of all cells, as their directed sides, in order. Two triangles of a cell that share a side cancel it.
pub fn rims(places: &[[f64; 3]], triangles: &[[u32; 3]], turned: bool) -> Vec<Rim> {
    let seats = seats(places);
    let cell = |[a, b, c]: &[u32; 3]| cell_of([*a, *b, *c].map(|v| places[v as usize]));
    let mut of_cells: Vec<_> =
        triangles.iter().map(|triangle| (cell(triangle), *triangle)).collect();
    of_cells.sort_by_key(|(cell, _)| *cell);
    let (mut rims, mut own) = (vec![], vec![]);
    for of_cell in of_cells.chunk_by(|(one, _), (other, _)| one == other) {
        for &(_, [a, b, c]) in of_cell {
            for [a, b] in sides_of(if turned { [a, c, b] } else { [a, b, c] }) {
                match own.iter().position(|&side| side == [b, a]) {
                    Some(at) => drop(own.swap_remove(at)),
                    None => own.push([a, b]),
                }
            }
        }
        let seats = own.drain(..).map(|side| side.map(|v| seats[v as usize]));
        rims.extend(seats.map(|side| (of_cell[0].0, side)));
    }
    assert!(rims.iter().all(|(_, side)| side.iter().all(|seat| matches!(seat, Seat::On(_)))));
    rims.sort_unstable();
    rims
}

/// What there is of each of the vertices on lattice edges, by these: places, or normals.
fn by_edge<A: Copy>(places: &[[f64; 3]], of_each: &[A]) -> BTreeMap<Seat, A> {
    let all = seats(places).into_iter().zip(of_each.iter().copied());
    let (on, within): (Vec<_>, Vec<_>) = all.partition(|(seat, _)| matches!(seat, Seat::On(_)));
    let found = BTreeMap::from_iter(on);
    assert_eq!(found.len() + within.len(), places.len(), "an edge is cut twice");
    found
}

/// What the copies of a volume are compared with.
struct Original<'a, T: Sample> {
    volume: &'a Volume<T>,
    iso: f64,
    options: ExtractOptions,
    tells_normals: bool,
    surface: Common,
}

/// What copies have in common, laid back onto the volume.
struct Common {
    loops: Vec<Rim>,
    edges: BTreeMap<Seat, [f64; 3]>,
    normals: BTreeMap<Seat, [f32; 3]>,
    shape: (usize, i64),
}

impl<'a, T: Sample> Original<'a, T> {
    fn of(volume: &'a Volume<T>, iso: f64, options: &ExtractOptions, tells_normals: bool) -> Self {
        let options = options.clone().with_precision(Some(Precision::F64));
        let surface = Common::of(Symmetry::NONE, volume, iso, (&options, tells_normals));
        Self { volume, iso, options, tells_normals, surface }
    }

    /// Asserts that a copy has the same cut edges, loops, pieces and Euler characteristic, and vertices on edges at the
    /// same places but for rounding; and as nearly the same normals, if samples tell them clearly.
    #[track_caller]
    fn assert_alike(&self, symmetry: Symmetry) {
        let (here, options) = (&self.surface, &self.options);
        let copy = Common::of(symmetry, self.volume, self.iso, (options, self.tells_normals));
        assert!(copy.edges.keys().eq(here.edges.keys()), "other edges, {symmetry:?}, {options:?}");
        // Half a step of f64 each, and another half where it was turned back.
        let longest = self.volume.grid().dims().into_iter().max().unwrap_or(1);
        let least = longest.next_power_of_two() as f64 * 2_f64.powi(-52);
        for (place, there) in copy.edges.values().zip(here.edges.values()) {
            let off = (0..3).map(|k| (place[k] - there[k]).abs()).fold(0.0, f64::max);
            assert!(off <= least, "{off:e} off at {there:?}, {symmetry:?}, {options:?}");
        }
        let same_seats = copy.normals.keys().eq(here.normals.keys());
        assert!(same_seats && here.normals.is_empty() != self.tells_normals, "a normal each");
        for (normal, there) in copy.normals.values().zip(here.normals.values()) {
            let off = (0..3).map(|k| (normal[k] - there[k]).abs()).fold(0.0, f32::max);
            assert!(off <= 1e-5, "{normal:?}, not {there:?}, {symmetry:?}, {options:?}");
        }
        assert!(copy.loops == here.loops, "other loops, {symmetry:?}, {options:?}");
        assert_eq!(copy.shape, here.shape, "{symmetry:?}, {options:?}");
    }
}

impl Common {
    fn of<T: Sample>(
        symmetry: Symmetry,
        volume: &Volume<T>,
        iso: f64,
        (options, tells_normals): (&ExtractOptions, bool),
    ) -> Self {
        let (view, dims) = (symmetry.copy(volume), volume.grid().dims());
        let has_normals = tells_normals || options.diagonals == Diagonals::Fitted;
        let mut mesh = if has_normals { TriMesh::with_normals() } else { TriMesh::default() };
        extract_into(&view, iso, options, &mut mesh.refill(), &Job::default()).unwrap();
        let places: Vec<_> = mesh.positions.iter().map(|p| symmetry.back(p, dims)).collect();
        let normals = mesh.normals.as_ref().filter(|_| tells_normals).map(|normals| {
            by_edge(&places, &normals.iter().map(|&n| symmetry.turned_back(n)).collect::<Vec<_>>())
        });
        Self {
            loops: rims(&places, &mesh.triangles, symmetry.mirrors()),
            edges: by_edge(&places, &places),
            normals: normals.unwrap_or_default(),
            shape: Census::shape(&mesh),
        }
    }
}

/// Asserts that all 48 copies have the same surface in each mode. Gives on how many edges at least vertices were compared.
#[track_caller]
pub fn assert_symmetric<T: Sample>(volume: &Volume<T>, iso: f64, tells_normals: bool) -> usize {
    let mut least = usize::MAX;
    for options in modes_some_fitted() {
        let original = Original::of(volume, iso, &options, tells_normals);
        for symmetry in Symmetry::all() {
            original.assert_alike(symmetry);
        }
        least = least.min(original.surface.edges.len());
    }
    least
}

/// The same with each copy in one mode of each topology, and each mode in six copies, which have one order of axes each: in
/// which, follows from the samples, so that over a list of volumes other copies and modes meet. Normals are not compared.
#[track_caller]
pub fn assert_symmetric_in_turn<T: Sample>(volume: &Volume<T>, iso: f64) {
    let modes = modes_some_fitted();
    let turns = modes.len() / 2;
    let bits = volume.samples().iter().map(|sample| sample.to_f64().to_bits());
    let first = bits.fold(iso.to_bits(), |sum, bits| sum.rotate_left(5) ^ bits) as usize % turns;
    for (n, options) in modes.iter().enumerate() {
        let original = Original::of(volume, iso, options, false);
        for (copy, symmetry) in Symmetry::all().into_iter().enumerate() {
            let (flips, axes) = (copy / 6, copy % 6);
            if (flips + axes + first) % turns == n % turns {
                original.assert_alike(symmetry);
            }
        }
    }
}

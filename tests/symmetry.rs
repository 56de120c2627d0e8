//! Copies of a volume that are turned, mirrored, negated or scaled have the surface turned, mirrored,
//! seen from its other side, or the same.
//!
//! Nothing here knows where a surface should be: the extractor is compared with itself.

use isokit::{
    geom::{Affine, Frame},
    job::Job,
    marching_cubes::{
        Boundary, Degenerate, ExtractOptions, Gradient, Placement, Topology, extract,
    },
    mesh::{Precision, TriMesh},
    volume::{Dtype, Grid, Sample, View, Volume},
};
use isokit_tests::{
    chance::Chance,
    check::{Census, sides_of},
    fields, hard,
    modes::modes,
};
use std::{array::from_fn, collections::BTreeMap};

/// One of the 48 ways to lay a cube onto itself. Axis `k` of the copy is `axes[k]` of the volume, backwards
/// where `flips[k]`.
#[derive(Clone, Copy, Debug)]
struct Symmetry {
    axes: [usize; 3],
    flips: [bool; 3],
}

impl Symmetry {
    fn all() -> Vec<Self> {
        let axes = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];
        let flips = (0..8).map(|bits| from_fn(|k| bits >> k & 1 == 1));
        flips.flat_map(|flips| axes.map(|axes| Self { axes, flips })).collect()
    }

    /// Whether right hands become left hands.
    fn mirrors(self) -> bool {
        let is_odd = (0..3).all(|k| self.axes[k] != (self.axes[(k + 1) % 3] + 2) % 3);
        is_odd ^ (self.flips.iter().filter(|&&flip| flip).count() % 2 == 1)
    }

    /// The copy, as a view of the same samples.
    fn copy<T: Sample>(self, volume: &Volume<T>) -> View<'_, T> {
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
    fn back(self, place: [f64; 3], dims: [u64; 3]) -> [f64; 3] {
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
type Edge = [i64; 3];

/// What a vertex is on or in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Seat {
    On(Edge),
    /// Within a cell, the vertex of this number.
    Within(usize),
}

/// A cell by its first corner, and a side in it along which it meets another cell.
type Rim = ([i64; 3], [Seat; 2]);

/// Where vertices sit that are no samples: on an edge one coordinate is not a whole number, in a cell none is.
fn seats(places: &[[f64; 3]]) -> Vec<Seat> {
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

/// The loops of all cells, as their directed sides. Counts, so that nothing is there twice.
fn rims(places: &[[f64; 3]], triangles: &[[u32; 3]], turned: bool) -> BTreeMap<Rim, i64> {
    let (mut rims, seats) = (BTreeMap::new(), seats(places));
    for &[a, b, c] in triangles {
        let corners = [a, b, c].map(|v| places[v as usize]);
        // A triangle lies in its cell and never in a face, so its middle is within.
        let cell = from_fn(|k| (corners.iter().map(|p| p[k]).sum::<f64>() / 3.0).floor() as i64);
        for [a, b] in sides_of(if turned { [a, c, b] } else { [a, b, c] }) {
            let [a, b] = [a, b].map(|v| seats[v as usize]);
            *rims.entry((cell, [a, b])).or_insert(0) += 1;
            *rims.entry((cell, [b, a])).or_insert(0) -= 1;
        }
    }
    rims.retain(|_, count| *count != 0);
    assert!(rims.keys().all(|(_, side)| side.iter().all(|seat| matches!(seat, Seat::On(_)))));
    rims
}

/// What there is of each of the vertices on lattice edges, by these: places, or normals.
fn by_edge<A: Copy>(places: &[[f64; 3]], of_each: &[A]) -> BTreeMap<Seat, A> {
    let all = seats(places).into_iter().zip(of_each.iter().copied());
    let found: BTreeMap<_, _> = all.filter(|(seat, _)| matches!(seat, Seat::On(_))).collect();
    let within = seats(places).iter().filter(|seat| matches!(seat, Seat::Within(_))).count();
    assert_eq!(found.len() + within, places.len(), "an edge is cut twice");
    found
}

fn made<T: Sample>(dims: [u64; 3], mut sample: impl FnMut([u64; 3]) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Frame::default()).unwrap();
    let at = |n: u64| sample([n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]]);
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

fn chance(dims: [u64; 3], seed: u64) -> Volume<f32> {
    let mut chance = Chance::new(seed);
    made(dims, |_| (chance.unit() * 2.0 - 1.0) as f32)
}

fn mesh<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) -> TriMesh {
    extract(view, iso, options, &Job::default()).unwrap()
}

/// Pieces and Euler characteristic.
fn shape(mesh: &TriMesh) -> (usize, i64) {
    let census = Census::of(mesh);
    (census.components, census.euler)
}

/// Asserts that each copy has the same cut edges, loops, pieces and Euler characteristic, and vertices on
/// edges at the same places but for rounding; and as nearly the same normals, if samples tell them clearly.
#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64, tells_normals: bool) {
    let dims = volume.grid().dims();
    for options in modes() {
        let options = options.with_precision(Some(Precision::F64));
        let expected = mesh(&volume.view(), iso, &options);
        let places: Vec<_> = expected.positions.iter().collect();
        let loops = rims(&places, &expected.triangles, false);
        let edges = by_edge(&places, &places);
        assert!(edges.len() > 50);
        let normals = by_edge(&places, &expected.normals.clone().expect("the default has some"));
        for symmetry in Symmetry::all() {
            let found = mesh(&symmetry.copy(volume), iso, &options);
            let places: Vec<_> = found.positions.iter().map(|p| symmetry.back(p, dims)).collect();
            let copied = by_edge(&places, &places);
            assert!(copied.keys().eq(edges.keys()), "other edges, {symmetry:?}, {options:?}");
            for (place, there) in copied.values().zip(edges.values()) {
                let off = (0..3).map(|k| (place[k] - there[k]).abs()).fold(0.0, f64::max);
                // A step of f64 at 16; each of the two is half a step off, and half of one where it was turned back.
                assert!(off <= 2_f64.powi(-48), "{off:e} off at {there:?}, {symmetry:?}");
            }
            let copied = found.normals.clone().expect("as before");
            let copied: Vec<_> = copied.into_iter().map(|n| symmetry.turned_back(n)).collect();
            let copied = by_edge(&places, &copied);
            for (edge, normal) in copied.iter().filter(|_| tells_normals) {
                let there = normals[edge];
                let off = (0..3).map(|k| (normal[k] - there[k]).abs()).fold(0.0, f32::max);
                assert!(off <= 1e-5, "{normal:?}, not {there:?}, {symmetry:?}, {options:?}");
            }
            let copied = rims(&places, &found.triangles, symmetry.mirrors());
            assert!(copied == loops, "other loops, {symmetry:?}, {options:?}");
            assert_eq!(shape(&found), shape(&expected), "{symmetry:?}, {options:?}");
        }
    }
}

#[test]
fn there_are_forty_eight_symmetries_and_half_of_them_mirror() {
    let all = Symmetry::all();
    assert_eq!((all.len(), all.iter().filter(|one| one.mirrors()).count()), (48, 24));
    let plain = made([2, 3, 4], |[i, j, k]| (i + 10 * j + 100 * k) as i16);
    let mut copies: Vec<Vec<i16>> = vec![];
    for symmetry in all {
        let copy = symmetry.copy(&plain);
        let [nx, ny, nz] = copy.dims();
        let points = (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / nx / ny]);
        let of = |ijk: [usize; 3]| {
            let [i, j, k] = symmetry.back(ijk.map(|i| i as f64), [2, 3, 4]);
            assert_eq!(copy.value(ijk), i + 10.0 * j + 100.0 * k);
            copy.stored(ijk)
        };
        copies.push(points.map(of).collect());
    }
    copies.sort();
    copies.dedup();
    assert_eq!(copies.len(), 48);
}

#[test]
fn a_smooth_shape_in_forty_eight_copies() {
    let torus = fields::torus(0.6, 0.25);
    check(&made([14, 13, 12], |ijk| torus(ijk.map(|i| i as f64 / 6.5 - 1.0)) as f32), 0.0, true);
}

#[test]
fn chance_in_forty_eight_copies() {
    for seed in 0..4 {
        check(&chance([7, 6, 5], seed), 0.1, true);
    }
}

#[test]
fn samples_on_the_isovalue_in_forty_eight_copies() {
    for seed in 0..4 {
        let mut chance = Chance::new(seed);
        // Differences of so few numbers cancel: then rounding says where a normal points.
        check(&made([5, 7, 6], |_| chance.below(5) as i8 - 2), 0.0, false);
    }
}

/// The isovalue and what is next to it, the greatest and the least there is, and what is no number.
#[test]
fn extremes_in_forty_eight_copies() {
    for seed in 0..2 {
        let mut chance = Chance::new(seed);
        let mut any = |dtype| {
            let hard = hard::values(dtype, 1.0);
            let all = (0..7 * 5 * 6).map(|_| hard[chance.below(hard.len() as u64) as usize]);
            all.collect::<Vec<_>>()
        };
        let at = |[i, j, k]: [u64; 3]| (i + 7 * (j + 5 * k)) as usize;
        let (single, double, whole) = (any(Dtype::F32), any(Dtype::F64), any(Dtype::I32));
        check(&made([7, 5, 6], |ijk| single[at(ijk)] as f32), 1.0, false);
        check(&made([7, 5, 6], |ijk| double[at(ijk)]), 1.0, false);
        check(&made([7, 5, 6], |ijk| whole[at(ijk)] as i32), 1.0, false);
    }
}

/// The share of an edge is seen by laying its middle on 0, where f32 has steps finer than any other place. (In f64 one would
/// see how its sum with the place of the edge was rounded.)
#[test]
fn an_edge_is_cut_in_the_same_share_to_the_bit() {
    same_shares(&chance([3, 4, 3], 9), Placement::Linear);
    same_shares(&chance([4, 3, 5], 9), Placement::Cubic);
    same_shares(&chance([7, 2, 3], 9), Placement::Quintic);
}

#[track_caller]
fn same_shares(volume: &Volume<f32>, placement: Placement) {
    let dims = volume.grid().dims();
    let exact = ExtractOptions::DEFAULT.with_boundary(Boundary::Open).with_placement(placement);
    let exact = exact.with_degenerate(Degenerate::Exact);
    let shares = |symmetry: Symmetry| {
        let copy = symmetry.copy(volume);
        let mut shares: BTreeMap<Seat, u64> = BTreeMap::new();
        for (n, place) in mesh(&copy, 0.05, &exact).positions.iter().enumerate() {
            let [Seat::On(edge)] = seats(&[place])[..] else { panic!("{place:?} is on no edge") };
            let axis = (0..3).find(|&k| edge[k] % 2 != 0).unwrap();
            let origin = edge.map(|c| c as f64 / -2.0);
            let index_to_world = Affine::axis_aligned([1.0; 3], origin).unwrap();
            let placed = copy.with_frame(Frame { index_to_world, ..Frame::default() });
            let share = mesh(&placed, 0.05, &exact).positions.iter().nth(n).unwrap()[axis];
            let share = if symmetry.flips[axis] { -share } else { share };
            let seat = seats(&[symmetry.back(place, dims)])[0];
            shares.insert(seat, (share + 0.0).to_bits());
        }
        shares
    };
    let expected = shares(Symmetry { axes: [0, 1, 2], flips: [false; 3] });
    assert!(expected.len() > 25, "{} edges show little", expected.len());
    for symmetry in Symmetry::all() {
        assert_eq!(shares(symmetry), expected, "{symmetry:?}");
    }
}

/// The surfaces of a volume and of its negative, which has no ties.
#[track_caller]
fn both_sides(volume: &Volume<f32>, iso: f64, options: ExtractOptions) -> [TriMesh; 2] {
    assert!(volume.samples().iter().all(|&sample| f64::from(sample) != iso), "a tie");
    let dims = volume.grid().dims();
    let negated = made(dims, |ijk| -volume.view().stored(ijk.map(|i| i as usize)));
    let options = options.with_boundary(Boundary::Open);
    let sides = [(volume, iso), (&negated, -iso)];
    sides.map(|(volume, iso)| mesh(&volume.view(), iso, &options))
}

#[test]
fn a_negated_volume_has_the_same_vertices_and_turned_normals() {
    let mut odd = Chance::new(3);
    let odd = made([6; 3], |_| 2.0 * odd.below(6) as f32 - 5.0);
    let ways = [
        (Placement::Linear, Gradient::Central),
        (Placement::Quintic, Gradient::Central),
        (Placement::Quintic, Gradient::Matching),
    ];
    for ((volume, iso), (placement, gradient)) in [(&odd, 0.0), (&chance([6, 5, 7], 4), 0.125)]
        .into_iter()
        .flat_map(|one| ways.map(|way| (one, way)))
    {
        for degenerate in [Degenerate::Never, Degenerate::Exact] {
            let options = ExtractOptions::DEFAULT.with_topology(Topology::Table);
            let options = options.with_placement(placement).with_gradient(gradient);
            let [there, back] = both_sides(volume, iso, options.with_degenerate(degenerate));
            assert!(there.positions.len() > 100 && there.positions == back.positions);
            let normals = |mesh: &TriMesh| mesh.normals.clone().expect("the default has normals");
            let turned: Vec<_> = normals(&back).iter().map(|normal| normal.map(|c| -c)).collect();
            assert!(normals(&there) == turned, "{placement:?}, {gradient:?}");
        }
    }
}

/// The loops of two meshes, one of which has its other side out.
#[track_caller]
fn assert_turned(there: &TriMesh, back: &TriMesh) {
    let loops = |mesh: &TriMesh, turned| {
        rims(&mesh.positions.iter().collect::<Vec<_>>(), &mesh.triangles, turned)
    };
    assert!(there.triangles.len() > 100 && loops(there, false) == loops(back, true));
    assert_eq!(shape(there), shape(back));
}

/// On an ambiguous face the table keeps the inside apart, and negation changes what is inside: here is no such
/// face.
#[test]
fn a_negated_smooth_shape_is_the_same_surface_seen_from_the_other_side() {
    let torus = fields::torus(0.6, 0.25);
    let torus = made([16; 3], |ijk| torus(ijk.map(|i| i as f64 / 7.5 - 1.0)) as f32);
    for topology in [Topology::Table, Topology::Trilinear] {
        let options = ExtractOptions::DEFAULT.with_topology(topology);
        let [there, back] = both_sides(&torus, 0.01, options);
        assert_turned(&there, &back);
        assert!(Census::of(&there).volume > 0.0 && Census::of(&back).volume < 0.0);
    }
}

#[test]
fn negated_chance_is_the_same_trilinear_surface_seen_from_the_other_side() {
    for seed in 0..20 {
        let options = ExtractOptions::DEFAULT.with_topology(Topology::Trilinear);
        let [there, back] = both_sides(&chance([6, 7, 5], seed), 0.125, options);
        assert_turned(&there, &back);
    }
}

#[test]
fn chance_times_a_power_of_two_gives_the_same_bytes() {
    let volume = chance([9, 8, 7], 11);
    for options in modes() {
        let expected = mesh(&volume.view(), 0.125, &options);
        for power in [-90, -1, 1, 90] {
            let factor = 2_f32.powi(power);
            let scaled =
                made([9, 8, 7], |ijk| volume.view().stored(ijk.map(|i| i as usize)) * factor);
            let found = mesh(&scaled.view(), 0.125 * f64::from(factor), &options);
            assert_eq!(found, expected, "times 2 to the {power}");
        }
    }
}

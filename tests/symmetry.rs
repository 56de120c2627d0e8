//! Copies of a volume that are turned, mirrored, negated or scaled have the surface turned, mirrored,
//! seen from its other side, or the same.
//!
//! Nothing here knows where a surface should be: the extractor is compared with itself.

use isokit::{
    geom::{Affine, Frame},
    job::Job,
    marching_cubes::{
        Boundary, Degenerate, Diagonals, ExtractOptions, Gradient, Placement, Topology, extract,
    },
    mesh::TriMesh,
    volume::{Dtype, Sample, View, Volume},
};
use isokit_tests::{
    chance::Chance,
    check::Census,
    fields, hard,
    modes::modes_some_fitted,
    symmetry::{Seat, Symmetry, assert_symmetric, rims, seats},
    volumes::{made, noise},
};
use std::collections::BTreeMap;

fn mesh<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) -> TriMesh {
    extract(view, iso, options, &Job::default()).unwrap()
}

/// All 48 copies in all modes, of a volume whose surface cuts some edges.
#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64, tells_normals: bool) {
    let compared = assert_symmetric(volume, iso, tells_normals);
    assert!(compared > 50, "{compared} edges show little");
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
        check(&noise([7, 6, 5], seed), 0.1, true);
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
    same_shares(&noise([3, 4, 3], 9), Placement::Linear);
    same_shares(&noise([4, 3, 5], 9), Placement::Cubic);
    same_shares(&noise([7, 2, 3], 9), Placement::Quintic);
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
    let expected = shares(Symmetry::NONE);
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
        (Placement::Cubic, Gradient::Matching),
        (Placement::Quintic, Gradient::Central),
        (Placement::Quintic, Gradient::Matching),
    ];
    for ((volume, iso), (placement, gradient)) in [(&odd, 0.0), (&noise([6, 5, 7], 4), 0.125)]
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
    assert_eq!(Census::shape(there), Census::shape(back));
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
    let trilinear = ExtractOptions::DEFAULT.with_topology(Topology::Trilinear);
    for (seed, diagonals) in (0..20).zip([Diagonals::Table, Diagonals::Fitted].into_iter().cycle())
    {
        let options = trilinear.clone().with_diagonals(diagonals);
        let [there, back] = both_sides(&noise([6, 7, 5], seed), 0.125, options);
        assert_turned(&there, &back);
    }
}

#[test]
fn chance_times_a_power_of_two_gives_the_same_bytes() {
    let volume = noise([9, 8, 7], 11);
    for options in modes_some_fitted() {
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

//! Volumes on which extractors break: ties, extremes, gaps, odd sizes, odd lattices.
//!
//! Each must come out as the reference says, closed and open, with vertices kept apart and not: closed,
//! two-manifold, every vertex in its edge and used, every number finite, no triangle flat unless asked for.

use isokit::{
    geom::{Affine, Frame},
    job::{Job, Limits},
    marching_cubes::{Boundary, Degenerate, ExtractOptions, Nan, Topology, extract},
    mesh::TriMesh,
    volume::{Grid, Sample, View, Volume},
};
use isokit_tests::{
    chance::Chance,
    check::{Census, assert_closed},
    fields::{self, Field},
    oracle::assert_as_defined,
    reference::Surface,
};

/// All options under which the surface must be as it is defined.
fn options() -> Vec<ExtractOptions> {
    let mut all = vec![];
    for boundary in [Boundary::Closed, Boundary::Open] {
        for degenerate in [Degenerate::Never, Degenerate::Exact] {
            let options = ExtractOptions::DEFAULT.with_boundary(boundary);
            all.push(options.with_degenerate(degenerate));
        }
    }
    all
}

/// Asserts all that must hold. Gives the closed surface.
#[track_caller]
fn check<T: Sample>(volume: &Volume<T>, iso: f64) -> Surface {
    let surfaces = options().into_iter().map(|options| {
        let (_, surface) = assert_as_defined(&volume.view(), iso, &options);
        assert!(options.boundary == Boundary::Open || surface.boundary_sides == 0);
        let trilinear = options.clone().with_topology(Topology::Trilinear);
        let census = Census::of(&mesh(volume, iso, &trilinear));
        assert_eq!(census.faults_of_topology(), 0, "{trilinear:?}: {census:?}");
        assert!(options.degenerate == Degenerate::Exact || census.faults() == 0, "{census:?}");
        assert!(options.boundary == Boundary::Open || census.boundary_sides == 0, "{census:?}");
        surface
    });
    surfaces.collect::<Vec<_>>()[0]
}

fn made<T: Sample>(dims: [u64; 3], mut sample: impl FnMut([u64; 3]) -> T) -> Volume<T> {
    let grid = Grid::new(dims, Frame::default()).unwrap();
    let at = |n: u64| sample([n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]]);
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

fn sampled(field: &Field, points: u64) -> Volume<f64> {
    made([points; 3], |ijk| field(ijk.map(|i| i as f64 * 2.0 / (points - 1) as f64 - 1.0)))
}

fn mesh<T: Sample>(volume: &Volume<T>, iso: f64, options: &ExtractOptions) -> TriMesh {
    extract(&volume.view(), iso, options, &Job::default()).unwrap()
}

#[test]
fn samples_all_on_the_isovalue_are_a_box_closed_and_nothing_open() {
    let flat = made([4, 5, 6], |_| 7_u16);
    assert_eq!((check(&flat, 7.0).components, check(&flat, 7.0).euler), (1, 2));
    let open = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
    assert!(mesh(&flat, 7.0, &open).triangles.is_empty());
}

#[test]
fn one_sample_on_the_isovalue_is_a_small_octahedron_and_a_point_if_exact() {
    let one = made([3, 3, 3], |ijk| if ijk == [1; 3] { 0.0_f32 } else { -1.0 });
    assert_eq!(check(&one, 0.0).triangles, 8);
    let exact = mesh(&one, 0.0, &ExtractOptions::DEFAULT.with_degenerate(Degenerate::Exact));
    assert!(exact.positions.iter().all(|position| position == [1.0; 3]));
}

#[test]
fn a_checkerboard_cuts_every_edge() {
    let points = 9;
    let board =
        made([points; 3], |[i, j, k]| if (i + j + k).is_multiple_of(2) { 1_i8 } else { -1 });
    check(&board, 0.0);
    let open = mesh(&board, 0.0, &ExtractOptions::DEFAULT.with_boundary(Boundary::Open));
    assert_eq!(open.positions.len() as u64, 3 * points * points * (points - 1));
    assert_eq!(open.triangles.len() as u64, 4 * (points - 1).pow(3));
}

#[test]
fn bytes_by_chance_between_two_and_on_one() {
    let mut chance = Chance::new(1);
    let noise = made([14, 13, 12], |_| chance.bits() as u8);
    assert_ne!(check(&noise, 127.5), check(&noise, 128.5));
    assert_eq!(check(&noise, 127.5), check(&noise, 128.0), "no byte is between");
}

#[test]
fn isovalues_at_and_beyond_the_ends_of_the_range() {
    let mut chance = Chance::new(2);
    let noise = made([6, 5, 7], |_| chance.below(9) as i32 - 4);
    let all = check(&noise, -4.0);
    assert_eq!(all, check(&noise, -5.0));
    assert_eq!((all.components, all.euler), (1, 2));
    assert!(check(&noise, 4.0).components > 1);
    assert_eq!(check(&noise, 5.0), Surface::default());
}

#[test]
fn minus_zero_is_zero() {
    let with = |zero: f32| made([3, 3, 3], move |ijk| if ijk == [1; 3] { zero } else { -1.0 });
    for iso in [0.0, -0.0] {
        let options = ExtractOptions::DEFAULT;
        assert_eq!(mesh(&with(0.0), iso, &options), mesh(&with(-0.0), iso, &options));
        assert_eq!(check(&with(-0.0), iso).triangles, 8);
    }
}

#[test]
fn the_greatest_and_the_least_number_side_by_side() {
    let board = |ijk: [u64; 3]| (ijk[0] + ijk[1] / 2 + ijk[2]).is_multiple_of(2);
    check(&made([6, 6, 6], |ijk| if board(ijk) { i32::MAX } else { i32::MIN }), 0.0);
    check(&made([6, 6, 6], |ijk| if board(ijk) { f32::MAX } else { f32::MIN }), 0.0);
    check(&made([6, 6, 6], |ijk| if board(ijk) { f32::MAX } else { f32::MIN }), -3e38);
    check(&made([6, 6, 6], |ijk| if board(ijk) { f64::MAX } else { f64::MIN }), 1e308);
}

#[test]
fn the_smallest_numbers_there_are() {
    let mut chance = Chance::new(3);
    let denormal = |chance: &mut Chance| f32::from_bits(chance.below(4) as u32);
    let volume = made([7, 7, 7], |_| denormal(&mut chance));
    assert!(check(&volume, 1e-45).components > 0);
    assert_eq!(check(&volume, 1e-45), check(&volume, f64::from(f32::from_bits(1))));
    assert!(check(&made([7, 7, 7], |_| f64::from_bits(chance.below(4))), 5e-324).components > 0);
}

#[test]
fn a_little_noise_on_a_large_number() {
    let mut chance = Chance::new(4);
    let volume = made([9, 9, 9], |_| (1e6 + chance.unit()) as f32);
    check(&volume, 1_000_000.5);
    check(&volume, 1_000_000.49);
}

#[test]
fn a_field_times_a_power_of_two_gives_the_same_bytes() {
    let gyroid = sampled(&fields::gyroid(1.5), 17);
    let scaled = |power: i32| {
        made([17; 3], |ijk| gyroid.view().value(ijk.map(|i| i as usize)) * 2_f64.powi(power))
    };
    for options in options() {
        let expected = mesh(&gyroid, 0.125, &options);
        for power in [-100, 100] {
            let found = mesh(&scaled(power), 0.125 * 2_f64.powi(power), &options);
            assert_eq!(found, expected, "times 2 to the {power}");
        }
    }
}

#[test]
fn samples_without_a_value() {
    let sphere = fields::sphere(0.7);
    let at = |ijk: [u64; 3]| sphere(ijk.map(|i| i as f64 / 6.0 - 1.0)) as f32;
    let mut chance = Chance::new(5);
    let holes: [Volume<f32>; 4] = [
        made([13; 3], |ijk| if ijk == [6, 6, 2] { f32::NAN } else { at(ijk) }),
        made([13; 3], |ijk| if ijk[2] == 5 { f32::NAN } else { at(ijk) }),
        made([13; 3], |ijk| if chance.below(2) == 0 { f32::NAN } else { at(ijk) }),
        made([13; 3], |_| f32::NAN),
    ];
    for volume in &holes {
        check(volume, 0.0);
        for options in options() {
            assert_as_defined(&volume.view(), 0.0, &options.with_nan(Nan::Mask));
        }
    }
    assert_eq!(check(&holes[1], 0.0).components, 2, "a slice without values cuts the ball in two");
    assert_eq!(check(&holes[3], 0.0), Surface::default());
}

#[test]
fn infinite_samples() {
    let infinite = [f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0, 1.0];
    let mut chance = Chance::new(6);
    check(&made([8; 3], |_| infinite[chance.below(5) as usize]), 0.0);
    check(&made([8; 3], |_| f64::from(infinite[chance.below(2) as usize])), 1.5);
}

#[test]
fn lattices_that_are_stretched_tiny_mirrored_or_turned() {
    let mut volume = sampled(&fields::torus(0.6, 0.25), 16);
    let square = 0.5_f64.sqrt();
    let frames = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1e6]],
        [[1e-12, 0.0, 0.0], [0.0, 1e-12, 0.0], [0.0, 0.0, 1e-12]],
        [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]],
        [[square, square, 0.0], [-square, square, 0.0], [0.0, 0.0, 1.0]],
        [[1.0, 0.0, 0.0], [0.9, 1.0, 0.0], [0.0, -3.0, 1.0]],
    ];
    for columns in frames {
        let index_to_world = Affine::new(columns, [0.0; 3]).unwrap();
        volume.set_frame(Frame { index_to_world, ..Frame::default() });
        assert_eq!(check(&volume, 0.0).euler, 0);
        let census = assert_closed(&mesh(&volume, 0.0, &ExtractOptions::DEFAULT));
        assert!(census.volume > 0.0, "outwards, {columns:?}");
    }
}

#[test]
fn sizes_of_one_of_two_and_around_a_word() {
    let mut chance = Chance::new(7);
    let sizes = [[1, 1, 1], [1, 5, 4], [5, 1, 4], [5, 4, 1], [1, 1, 9], [2, 2, 2], [7, 11, 13]];
    let words = [63, 64, 65, 127, 128, 129].map(|nx| [nx, 3, 2]);
    for dims in sizes.into_iter().chain(words).chain([[4097, 2, 3]]) {
        check(&made(dims, |_| chance.below(5) as i8 - 2), 0.0);
    }
}

#[test]
fn a_surface_through_the_border_is_closed_by_caps() {
    let sphere = sampled(&fields::sphere(1.1), 15);
    let closed = check(&sphere, 0.0);
    assert_eq!((closed.components, closed.euler), (1, 2));
    let (_, open) = assert_as_defined(&sphere.view(), 0.0, &options()[2]);
    assert!(open.boundary_sides > 0 && open.euler < 0, "six holes: {open:?}");
}

#[test]
fn a_sheet_one_sample_thick_has_two_sides() {
    let sheet = made([9, 9, 9], |[i, j, k]| i16::from(k == 4 && i % 8 != 0 && j % 8 != 0));
    let surface = check(&sheet, 1.0);
    assert_eq!((surface.components, surface.euler), (1, 2));
    let thin = sampled(&fields::plate(1e-9), 17);
    assert_eq!(check(&thin, 0.0).euler, 2);
}

#[test]
fn balls_that_touch_in_a_point_between_samples_or_on_one() {
    for points in [16, 17, 20, 21] {
        let balls = sampled(&fields::touching_spheres(0.5), points);
        assert!(check(&balls, 0.0).components <= 2, "{points}");
    }
}

/// scikit-image 8109: 18 triangles, two of them twice, since the saddle of the middle face is 0.
#[test]
fn two_ambiguous_cells_that_share_a_face_do_not_double_a_triangle() {
    let samples = vec![13, -1, -1, -7, -1, 1, 7, -7, 15, -9, -3, -1];
    let grid = Grid::new([2, 2, 3], Frame::default()).unwrap();
    check(&Volume::new(grid, samples).unwrap(), 0.0);
}

/// scikit-image 8116: two cells answer differently for a common face that has a sample on the isovalue.
#[test]
fn two_cells_agree_on_a_face_with_samples_on_the_isovalue() {
    for seed in 0..500 {
        let mut chance = Chance::new(seed);
        check(&made([2, 2, 3], |_| chance.below(3) as i8 - 1), 0.0);
    }
}

#[test]
fn big_endian_samples_swapped_once_and_views_that_run_backwards() {
    let mut chance = Chance::new(8);
    let swapped = made([6, 7, 8], |_| (chance.bits() as i16).swap_bytes());
    let volume =
        made([6, 7, 8], |ijk| Sample::swap_bytes(swapped.view().stored(ijk.map(|i| i as usize))));
    let back = View::strided(volume.samples(), 335, [-1, -6, -42], volume.grid()).unwrap();
    let gaps = Grid::new([3, 7, 4], Frame::default()).unwrap();
    let gaps = View::strided(volume.samples(), 1, [2, 6, 84], &gaps).unwrap();
    for options in options() {
        for iso in [0.0, 1000.5] {
            assert_as_defined(&back, iso, &options);
            assert_as_defined(&gaps, iso, &options);
        }
    }
}

#[test]
fn a_large_volume_that_is_all_inside_costs_its_signs_and_no_more() {
    // One sample stands for all: a stride of 0.
    let grid = Grid::new([512; 3], Frame::default()).unwrap();
    let view = View::strided(&[1.0_f32], 0, [0; 3], &grid).unwrap();
    let bit_each = 512 * 512 * 512 / 8;
    let job = Job { limits: Limits { bytes: bit_each + bit_each / 4 }, ..Job::default() };
    let open = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
    let mesh = extract(&view, 0.5, &open, &job).unwrap();
    assert_eq!(mesh, TriMesh::with_normals());
}

#[test]
fn any_bits_at_all() {
    for seed in 0..20 {
        let mut chance = Chance::new(seed);
        check(&made([7, 6, 5], |_| f32::from_bits(chance.bits() as u32)), 0.0);
        let iso = f64::from(f32::from_bits(chance.bits() as u32));
        let volume = made([5, 6, 7], |_| f64::from_bits(chance.bits()));
        check(&volume, if iso.is_finite() { iso } else { 1.0 });
    }
}

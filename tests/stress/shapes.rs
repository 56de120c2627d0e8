//! Sizes, shapes and layouts on which extractors break: items 15 to 19, 23 and 24 of the list.

use crate::{check, check_view, options, sampled};
use isokit::{
    geom::Frame,
    job::{Job, Limits},
    marching_cubes::{Boundary, ExtractOptions, extract},
    mesh::TriMesh,
    volume::{Grid, Sample, View},
};
use isokit_tests::{chance::Chance, fields, oracle::assert_as_defined, volumes::made};

#[test]
fn sizes_of_one_of_two_and_around_a_word() {
    let mut chance = Chance::new(7);
    let sizes = [[1, 1, 1], [1, 5, 4], [5, 1, 4], [5, 4, 1], [1, 1, 9], [2, 2, 2], [7, 11, 13]];
    let words = [63, 64, 65, 127, 128, 129].map(|nx| [nx, 3, 2]);
    for dims in sizes.into_iter().chain(words) {
        check(&made(dims, |_| chance.below(5) as i8 - 2), 0.0);
    }
}

#[test]
fn rows_that_are_long() {
    let mut chance = Chance::new(16);
    check(&made([4097, 2, 3], |_| chance.below(5) as i8 - 2), 0.0);
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
        if points % 2 == 1 {
            let middle = [points as usize / 2; 3];
            assert_eq!(balls.view().value(middle), 0.0, "they touch on a sample");
        }
        let joined = check(&balls, 0.0);
        assert_eq!((joined.components, joined.euler), (1, 2), "{points}: the inside joins");
        let apart = check(&balls, 0.2);
        assert_eq!((apart.components, apart.euler), (2, 4), "{points}: two balls");
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
    for iso in [0.0, 1000.5] {
        assert_ne!(check_view(&back, iso), check_view(&gaps, iso));
        assert_eq!(check_view(&back, iso).triangles, check(&volume, iso).triangles);
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

//! Saddles on the isovalue: items 20 to 22 of the list. That trilinear topology is right there is certified in
//! `tests/trilinear.rs`.

use crate::check;
use isokit::{
    geom::Frame,
    job::Job,
    marching_cubes::{Boundary, ExtractOptions, Topology, extract_into},
    mesh::TriMesh,
    volume::{Grid, Volume},
};
use isokit_tests::{chance::Chance, volumes::made};

/// Checks each cell alone, and all of them in a row, apart, in samples that are all `between`. Gives how many
/// of the cells alone are singular, which trilinear topology counts.
#[track_caller]
fn check_cells(cells: &[[i32; 8]]) -> u64 {
    let mut singular = 0;
    for cell in cells {
        let alone = made([2; 3], |[i, j, k]| cell[(i + 2 * j + 4 * k) as usize]);
        check(&alone, 0.0);
        let open = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
        let open = open.with_topology(Topology::Trilinear);
        let mut mesh = TriMesh::default();
        let sink = &mut mesh.refill();
        singular +=
            extract_into(&alone.view(), 0.0, &open, sink, &Job::default()).unwrap().singular_cells;
    }
    for between in [-1, 1] {
        let row = made([3 * cells.len() as u64 + 1, 4, 4], |[i, j, k]| {
            let inner = i % 3 > 0 && (1..3).contains(&j) && (1..3).contains(&k);
            let corner = || (i % 3 - 1) + 2 * (j - 1) + 4 * (k - 1);
            if inner { cells[(i / 3) as usize][corner() as usize] } else { between }
        });
        check(&row, 0.0);
    }
    singular
}

/// The saddle of a face is at AC − BD over a sum, with A, B, C, D around it: here it is the isovalue on the
/// three faces that meet at a corner.
#[test]
fn faces_whose_saddle_is_on_the_isovalue() {
    let mut chance = Chance::new(9);
    let cells: [[i32; 8]; 40] = std::array::from_fn(|n| {
        let a = 1 << chance.below(3);
        let [b, c, d] = [(); 3].map(|()| a * (1 + chance.below(8) as i32));
        let far = chance.below(121) as i32 - 60;
        let cell = [a, -b, -c, b * c / a, -d, b * d / a, c * d / a, far];
        for [low, x, y, both] in [[0, 1, 2, 3], [0, 1, 4, 5], [0, 2, 4, 6]] {
            assert_eq!(cell[low] * cell[both] - cell[x] * cell[y], 0);
        }
        let turn = chance.below(8) as usize;
        let sign = if n % 2 == 0 { 1 } else { -1 };
        std::array::from_fn(|corner| sign * cell[corner ^ turn])
    });
    assert_eq!(check_cells(&cells), 40, "each");
}

/// XYZ has a triple saddle of value 0 at 0; XYZ − X − Y − Z + 2 one of value 0 at (1, 1, 1).
#[test]
fn cells_whose_saddle_is_on_the_isovalue() {
    let cell = |[low, high]: [i32; 2], field: fn(i32, i32, i32) -> i32| {
        let at = |corner: usize, axis: usize| [low, high][corner >> axis & 1];
        std::array::from_fn(|corner| field(at(corner, 0), at(corner, 1), at(corner, 2)))
    };
    let triple = |low, high| cell([low, high], |x, y, z| x * y * z);
    let single = |low, high| cell([low, high], |x, y, z| x * y * z - x - y - z + 2);
    let mut cells: Vec<[i32; 8]> = vec![];
    for low in [-3, -2, -1] {
        cells.extend([1, 2, 5].map(|high| triple(low, high)));
        cells.extend([2, 3, 4].map(|high| single(low + 1, high)));
    }
    cells.extend(cells.clone().iter().map(|cell| cell.map(|sample| -sample)));
    assert!(check_cells(&cells) >= 18, "the triple ones at least");
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
    for seed in 0..100 {
        let mut chance = Chance::new(seed);
        check(&made([2, 2, 3], |_| chance.below(3) as i8 - 1), 0.0);
    }
}

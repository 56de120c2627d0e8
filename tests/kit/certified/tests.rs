//! The oracle against what is known, and against brute force.

use super::{cell, enclosed, volume};
use crate::chance::Chance;

#[test]
fn every_patch_parts_the_cell_once_more_and_reaches_its_edges() {
    let mut chance = Chance::new(1);
    for _ in 0..2000 {
        let found = cell([(); 8].map(|()| chance.bits() as i64 >> 23)).unwrap();
        assert_eq!(found.patches.len() + 1, found.regions.len());
        assert!(found.patches.iter().all(|patch| patch.edges.len() > 2));
    }
}

/// scikit-image 8109: the saddle of the middle face is 0.
#[test]
fn the_two_cells_with_a_singular_face_between_them_are_one_ball() {
    let (dims, samples) = ([2, 2, 3], [13, -1, -1, -7, -1, 1, 7, -7, 15, -9, -3, -1]);
    assert_eq!(volume(dims, &samples), Some(vec![1, 1]));
    let (dims, samples) = enclosed(dims, &samples);
    assert_eq!(volume(dims, &samples), Some(vec![2]));
}

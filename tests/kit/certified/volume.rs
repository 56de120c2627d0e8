//! The topology of a whole trilinear surface, from that of its cells.
//!
//! Patches of neighbouring cells meet in the arcs on their common faces, and these in the points on cut
//! lattice edges. So the Euler characteristic is that of all patches, less one for each arc, plus one for
//! each point. Every lattice face beside a cut edge has one end of an arc there: half an arc, whichever way
//! the arcs of an ambiguous face lead, so a piece's arcs are counted at its edges.

use super::{cell, pieces::Pieces};
use isokit::geom::cube::{Corner, Edge};
use std::collections::BTreeMap;

/// The Euler characteristic of each connected piece of the surface in a lattice of samples, x fastest, less
/// the isovalue, in ascending order. The surface ends where the lattice does. None if a cell is undecided.
///
/// # Panics
///
/// If there are not as many samples as `dims` says.
pub fn volume(dims: [usize; 3], samples: &[i64]) -> Option<Vec<i64>> {
    assert_eq!(samples.len(), dims.iter().product::<usize>(), "one sample for each point");
    let steps = [1, dims[0], dims[0] * dims[1]];
    let mut pieces = Pieces::new(3 * samples.len());
    let mut twice: Vec<(usize, i64)> = vec![];
    for low in points(dims.map(|n| n.saturating_sub(1))) {
        let number = |corner: Corner| -> usize {
            (0..3).map(|axis| (low[axis] + corner.offset()[axis]) * steps[axis]).sum()
        };
        let corners = std::array::from_fn(|k| samples[number(Corner::new(k as u8))]);
        for patch in cell(corners)?.patches {
            let edges = patch.edges.iter().map(|&e| Edge::new(e as u8));
            let edges: Vec<usize> =
                edges.map(|edge| 3 * number(edge.ends()[0]) + edge.axis()).collect();
            twice.push((edges[0], 2 * patch.euler));
            edges.iter().for_each(|&edge| pieces.join(edges[0], edge));
        }
    }
    if dims.iter().all(|&n| n > 1) {
        for (n, point) in points(dims).enumerate() {
            for axis in (0..3).filter(|&axis| point[axis] + 1 < dims[axis]) {
                if (samples[n] >= 0) != (samples[n + steps[axis]] >= 0) {
                    let others = (0..3).filter(|&other| other != axis);
                    let faces = others.map(|other| {
                        i64::from(point[other] > 0) + i64::from(point[other] + 1 < dims[other])
                    });
                    twice.push((3 * n + axis, 2 - faces.sum::<i64>()));
                }
            }
        }
    }
    let mut eulers: BTreeMap<usize, i64> = BTreeMap::new();
    for (edge, count) in twice {
        *eulers.entry(pieces.root(edge)).or_default() += count;
    }
    let mut eulers: Vec<i64> = eulers.into_values().map(|twice| twice / 2).collect();
    eulers.sort_unstable();
    Some(eulers)
}

/// The same samples with a layer of outside ones all around, so that the surface is closed. In a cell between
/// samples and such a layer the field falls monotonically from what it is on the samples' face, wherever it
/// is inside, so the topology is the same for every value below 0.
pub fn enclosed(dims: [usize; 3], samples: &[i64]) -> ([usize; 3], Vec<i64>) {
    let larger = dims.map(|n| n + 2);
    let held = points(larger).map(|point| {
        let held = (0..3).all(|axis| (1..=dims[axis]).contains(&point[axis]));
        let [x, y, z] = point;
        if held { samples[x - 1 + dims[0] * (y - 1 + dims[1] * (z - 1))] } else { -1 }
    });
    (larger, held.collect())
}

/// The points of a lattice, x fastest.
fn points([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
}

#[cfg(test)]
mod tests {
    use super::{cell, enclosed, points, volume};
    use crate::{certified::random, chance::Chance};

    /// The samples that a field has on a lattice around the origin, so many points to either side.
    fn sampled(reach: i64, field: impl Fn([i64; 3]) -> i64) -> ([usize; 3], Vec<i64>) {
        let dims = [2 * reach as usize + 1; 3];
        (dims, points(dims).map(|point| field(point.map(|x| x as i64 - reach))).collect())
    }

    fn by_chance(dims: [usize; 3], reach: i64, chance: &mut Chance) -> Vec<i64> {
        points(dims).map(|_| random(reach, chance)[0]).collect()
    }

    /// The same field on a lattice twice as fine, times 8.
    fn refined(dims: [usize; 3], samples: &[i64]) -> ([usize; 3], Vec<i64>) {
        let finer = dims.map(|n| 2 * n - 1);
        let sample = |[x, y, z]: [usize; 3]| samples[x + dims[0] * (y + dims[1] * z)];
        let value = |point: [usize; 3]| {
            let ends = |axis: usize| [point[axis] / 2, point[axis].div_ceil(2)];
            let corner = |k: usize| std::array::from_fn(|axis| ends(axis)[k >> axis & 1]);
            (0..8).map(|k| sample(corner(k))).sum()
        };
        (finer, points(finer).map(value).collect())
    }

    #[test]
    fn a_ball_is_a_sphere_and_a_ring_is_a_torus() {
        let square = |[x, y, z]: [i64; 3]| x * x + y * y + z * z;
        let (dims, ball) = sampled(4, |xyz| 10 - square(xyz));
        assert_eq!(volume(dims, &ball), Some(vec![2]));
        let ring = |[x, y, z]: [i64; 3]| {
            let sum = square([x, y, z]) + 9 - 2;
            4 * 9 * (x * x + y * y) - sum * sum
        };
        let (dims, ring) = sampled(5, ring);
        assert_eq!(volume(dims, &ring), Some(vec![0]));
        let (dims, shell) = sampled(4, |xyz| (square(xyz) - 3) * (12 - square(xyz)));
        assert_eq!(volume(dims, &shell), Some(vec![2, 2]));
    }

    #[test]
    fn a_surface_ends_at_the_border_unless_it_is_enclosed() {
        let (dims, plane) = sampled(2, |[x, y, z]| x + 2 * y + 3 * z);
        assert_eq!(volume(dims, &plane), Some(vec![1]));
        let (dims, closed) = enclosed(dims, &plane);
        assert_eq!(volume(dims, &closed), Some(vec![2]));
        let (dims, closed) = enclosed([2, 1, 1], &[5, 7]);
        assert_eq!((dims, volume(dims, &closed)), ([4, 3, 3], Some(vec![2])));
        for dims in [[0, 3, 3], [3, 1, 3]] {
            let samples: Vec<i64> =
                (0..dims.iter().product::<usize>() as i64).map(|n| 2 - n).collect();
            assert_eq!(volume(dims, &samples), Some(vec![]), "no cell, no surface");
        }
    }

    #[test]
    fn what_is_beyond_the_border_may_be_any_outside_value() {
        let mut chance = Chance::new(1);
        for reach in [3, 1000].repeat(20) {
            let dims = [3, 4, 2];
            let (larger, low) = enclosed(dims, &by_chance(dims, reach, &mut chance));
            let is_guard =
                |point: [usize; 3]| (0..3).any(|t| [0, larger[t] - 1].contains(&point[t]));
            let guards: Vec<bool> = points(larger).map(is_guard).collect();
            let lower = low.iter().zip(guards).map(|(&v, guard)| if guard { -1 << 40 } else { v });
            assert_eq!(volume(larger, &low), volume(larger, &lower.collect::<Vec<_>>()));
        }
    }

    #[test]
    fn a_finer_lattice_holds_the_same_surface() {
        let mut chance = Chance::new(2);
        for reach in [2, 3, 1 << 36].repeat(15) {
            let dims = [4, 3, 5];
            let samples = by_chance(dims, reach, &mut chance);
            let expected = volume(dims, &samples);
            assert!(expected.is_some(), "{samples:?}");
            let (dims, samples) = refined(dims, &samples);
            assert_eq!(volume(dims, &samples), expected);
        }
    }

    #[test]
    fn pieces_add_up_to_patches_less_arcs_and_points() {
        let mut chance = Chance::new(3);
        for reach in [3, 1 << 40].repeat(10) {
            let dims = [5, 4, 6];
            let samples = by_chance(dims, reach, &mut chance);
            let inside = |point: [usize; 3]| samples[point[0] + 5 * (point[1] + 4 * point[2])] >= 0;
            let mut euler = 0;
            // Each cell, face and edge: the axes it extends along, from its lowest point.
            for axes in 1..8 {
                let extends = |axis: usize| axes >> axis & 1;
                for low in points(std::array::from_fn(|axis| dims[axis] - extends(axis))) {
                    let at = |k: usize| std::array::from_fn(|t| low[t] + (k >> t & 1));
                    let corners: Vec<usize> = (0..8).filter(|k| k & !axes == 0).collect();
                    let ends = |k: usize| (0..3).map(move |t| k ^ 1 << t);
                    let signs: Vec<bool> = corners.iter().map(|&k| inside(at(k))).collect();
                    let cuts = corners.iter().flat_map(|&k| ends(k).map(move |end| (k, end)));
                    let cuts = cuts.filter(|&(k, end)| k < end && end & !axes == 0);
                    let cuts = cuts.filter(|&(k, end)| inside(at(k)) != inside(at(end))).count();
                    euler += match signs.len() {
                        2 => cuts as i64,
                        4 => -(cuts as i64) / 2,
                        _ => {
                            let value = |k: usize| {
                                let [x, y, z] = at(k);
                                samples[x + 5 * (y + 4 * z)]
                            };
                            let patches = cell(std::array::from_fn(value)).unwrap().patches;
                            patches.iter().map(|patch| patch.euler).sum()
                        }
                    };
                }
            }
            assert_eq!(volume(dims, &samples).unwrap().iter().sum::<i64>(), euler);
        }
    }

    #[test]
    fn a_closed_surface_has_pieces_of_even_characteristic() {
        let mut chance = Chance::new(4);
        let mut handles = 0;
        for reach in [2, 3, 1000].repeat(7) {
            let (dims, samples) = enclosed([7; 3], &by_chance([7; 3], reach, &mut chance));
            let eulers = volume(dims, &samples).expect("it is decided");
            assert!(eulers.iter().all(|euler| euler % 2 == 0 && *euler <= 2), "{eulers:?}");
            handles += eulers.iter().map(|euler| 1 - euler / 2).sum::<i64>();
        }
        assert!(handles > 100, "{handles}");
    }
}

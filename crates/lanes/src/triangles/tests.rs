//! Every level against cell by cell.

use super::{CaseTable, FirstVertices, triangles_at};
use crate::{BitRows, Level, Word, words_of_rows};
use std::{
    collections::BTreeMap,
    panic::{AssertUnwindSafe, catch_unwind},
};

struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
        self.0 ^ self.0 >> 31
    }

    /// A table that uses the cut edges of each case in any order.
    fn table(&mut self) -> CaseTable {
        let mut table = CaseTable { counts: [0; 256], edges: [[0; 16]; 256] };
        for case in 1..255_usize {
            let inside = |k: usize| case >> k & 1 == 1;
            let cut = |e: usize| {
                let (t, n) = (e / 4, e % 4);
                let [u, v] = [[1, 2], [0, 2], [0, 1]][t];
                let low = (n & 1) << u | (n >> 1) << v;
                inside(low) != inside(low | 1 << t)
            };
            let cut: Vec<u8> = (0..12).filter(|&e| cut(e)).map(|e| e as u8).collect();
            table.counts[case] = 1 + (self.next() % 5) as u8;
            for edge in &mut table.edges[case][..3 * usize::from(table.counts[case])] {
                *edge = cut[self.next() as usize % cut.len()];
            }
        }
        table
    }

    fn row(&mut self, points: usize) -> Vec<u64> {
        let mut row: Vec<u64> = (0..points.div_ceil(64)).map(|_| self.next()).collect();
        if !points.is_multiple_of(64) {
            row[points / 64] &= (1 << (points % 64)) - 1;
        }
        row
    }
}

#[test]
fn every_level_agrees_with_the_definition_and_writes_nothing_else() {
    let mut chance = Chance(3);
    let table = chance.table();
    let mut words = vec![];
    for points in 2..=200_usize {
        let [low, high] = [(); 2].map(|()| [(); 4].map(|()| chance.row(points)));
        let flat = [low.concat(), high.concat()];
        let bits = BitRows::new(&flat[0], Some(&flat[1]), points);
        words_of_rows(&bits, 0..4, &mut words);
        let first = |row: usize| {
            let n = 100_000 * row as u32;
            FirstVertices {
                x: [5, 1000, 2000, 3000].map(|x| n + x),
                y: [n + 4000, n + 5000],
                z: [n + 6000, n + 7000],
            }
        };
        // No cell starts in the last row.
        let expected: Vec<_> = (0..3)
            .flat_map(|y| {
                let rows = [&low[y][..], &low[y + 1], &high[y], &high[y + 1]];
                by_definition(rows, points, first(y), &table)
            })
            .collect();
        for &level in Level::available() {
            let mut out = vec![[u32::MAX; 3]; expected.len() + 9];
            let (room, behind) = out.split_at_mut(expected.len());
            assert_eq!(triangles_at(level, &words, first, &table, room), expected.len());
            assert_eq!(room, expected, "{level}, {points} points");
            assert_eq!(behind, [[u32::MAX; 3]; 9]);
        }
    }
}

#[test]
fn cells_that_are_taken_out_count_and_room_that_is_too_small_is_refused() {
    let mut chance = Chance(5);
    let table = chance.table();
    let mut words = vec![];
    for density in 0..6 {
        let mut word = || (0..density).fold(chance.next(), |w, _| w & chance.next());
        let rows: Vec<u64> = (0..24).map(|_| word()).collect();
        let bits = BitRows::new(&rows[..12], Some(&rows[12..]), 192);
        words_of_rows(&bits, 0..4, &mut words);
        words.iter_mut().for_each(|word| word.active &= chance.next());
        let of = |word: &Word| -> usize {
            let active = (0..64).filter(|&i| word.active >> i & 1 == 1);
            active.map(|i| usize::from(table.counts[usize::from(word.case(i))])).sum()
        };
        let count: usize = words.iter().map(of).sum();
        let first = |row: usize| {
            // Those of row 0 wrap.
            let n = (row as u32).wrapping_sub(1).wrapping_mul(20);
            FirstVertices { x: [n; 4], y: [n; 2], z: [n; 2] }
        };
        let mut usual = None;
        for (&level, more) in Level::available().iter().flat_map(|l| [0, 1, 9].map(|n| (l, n))) {
            let mut out = vec![[7; 3]; count + more];
            assert_eq!(triangles_at(level, &words, first, &table, &mut out), count, "{level}");
            out.truncate(count);
            assert!(*usual.get_or_insert_with(|| out.clone()) == out, "{level}");
        }
        for &level in if count > 0 { Level::available() } else { &[] } {
            let mut small = vec![[7; 3]; count - 1];
            let fill = || triangles_at(level, &words, first, &table, &mut small);
            assert!(catch_unwind(AssertUnwindSafe(fill)).is_err(), "{level}");
        }
    }
}

/// Cell by cell, with a map for the numbers.
fn by_definition(
    rows: [&[u64]; 4],
    points: usize,
    first: FirstVertices,
    table: &CaseTable,
) -> Vec<[u32; 3]> {
    let inside = |k: usize, i: usize| {
        let i = i + (k & 1);
        rows[k >> 1][i / 64] >> (i % 64) & 1 == 1
    };
    let mut next = first;
    let mut numbers = BTreeMap::new();
    for i in 0..points {
        let mut number = |edge: usize, ends: [usize; 2], next: &mut u32| {
            if inside(ends[0], i) != inside(ends[1], i) {
                numbers.insert((edge, i), *next);
                *next += 1;
            }
        };
        if i + 1 < points {
            (0..4).for_each(|n| number(n, [2 * n, 2 * n + 1], &mut next.x[n]));
        }
        (0..2).for_each(|n| number(4 + 2 * n, [4 * n, 4 * n + 2], &mut next.y[n]));
        (0..2).for_each(|n| number(8 + 2 * n, [2 * n, 2 * n + 4], &mut next.z[n]));
    }
    let mut triangles = vec![];
    for i in 0..points - 1 {
        let case: usize = (0..8).map(|k| usize::from(inside(k, i)) << k).sum();
        let edges = table.edges[case].as_chunks::<3>().0;
        for edges in &edges[..usize::from(table.counts[case])] {
            // An odd edge along y or z is the even one of the next cell.
            let name = |e: usize| if e < 4 { (e, i) } else { (e & !1, i + (e & 1)) };
            triangles.push(edges.map(|e| numbers[&name(e.into())]));
        }
    }
    triangles
}

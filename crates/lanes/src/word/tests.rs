//! Words against the corners of single cells.

use super::{BitRows, Word, cases::add_cases_at, words_of_rows_at};
use crate::Level;

/// Each mask by its definition, from the corners of single cells, for all rows and for some.
fn check(low: &[u64], high: Option<&[u64]>, points: usize) {
    let bits = BitRows::new(low, high, points);
    let rows = bits.rows();
    for level in Level::available() {
        let mut words = vec![Word::default()];
        words_of_rows_at(*level, &bits, 0..rows, &mut words);
        for (y, i) in (0..rows).flat_map(|y| (0..points).map(move |i| (y, i))) {
            check_cell(&words, [low, high.unwrap_or(low)], [y, rows], [i, points], high.is_some());
        }
        assert!(words.is_sorted_by_key(|word| (word.row, word.first)), "in order");
        let crossed = |word: &&Word, cell: &u32| word.active >> cell & 1 == 1;
        let cells = |word| (0..64).filter(move |cell| crossed(&word, cell));
        let cases = words.iter().flat_map(|word| cells(word).map(|cell| word.case(cell)));
        let mut found = vec![7];
        add_cases_at(*level, &words, &mut found);
        assert!(found[1..].iter().copied().eq(cases), "{level}");
        let mut some = vec![];
        words_of_rows_at(*level, &bits, rows / 3..rows - rows / 3, &mut some);
        words.retain(|word| (rows / 3..rows - rows / 3).contains(&word.row));
        assert_eq!(some, words, "{level}");
    }
}

fn check_cell(
    words: &[Word],
    slices: [&[u64]; 2],
    [y, rows]: [usize; 2],
    [i, points]: [usize; 2],
    has_layer: bool,
) {
    let per_row = points.div_ceil(64);
    let word = words.iter().find(|word| word.row == y && word.first == i / 64 * 64);
    let word = word.copied().unwrap_or_default();
    let is_cell = i + 1 < points;
    let inside = |k: usize| {
        let (i, y) = (i + (k & 1), (y + (k >> 1 & 1)).min(rows - 1));
        i < points && slices[k >> 2][y * per_row + i / 64] >> (i % 64) & 1 == 1
    };
    let bit = |mask: u64| mask >> (i % 64) & 1 == 1;
    for n in 0..4 {
        let differ = is_cell && inside(2 * n) != inside(2 * n + 1);
        // Where nothing else is there to see, of the neighbours' edges nothing is told.
        assert!(bit(word.cuts[n]) == differ || word == Word::default() && n > 0, "x {n}");
    }
    assert_eq!(bit(word.cuts[4]), inside(0) != inside(2), "y of {i}, {y}");
    assert_eq!(bit(word.cuts[6]), inside(0) != inside(4), "z of {i}, {y}");
    let case: u32 = (0..8).map(|k| u32::from(inside(k)) << k).sum();
    let active = is_cell && case != 0 && case != 255 && has_layer && y + 1 < rows;
    assert_eq!(bit(word.active), active, "active {i}, {y}");
    if active {
        assert_eq!(bit(word.cuts[5]), inside(4) != inside(6), "y of {i}, {y}");
        assert_eq!(bit(word.cuts[7]), inside(2) != inside(6), "z of {i}, {y}");
        assert_eq!(u32::from(word.case(i as u32 % 64)), case, "case {i}, {y}");
    }
}

#[test]
fn words_agree_with_the_definition_on_every_short_row() {
    for points in 1..=4 {
        for bits in 0..1_u64 << (4 * points) {
            let row = |r: usize| bits >> (r * points) & ((1 << points) - 1);
            check(&[row(0), row(1)], Some(&[row(2), row(3)]), points);
        }
    }
}

#[test]
fn words_agree_with_the_definition_across_words_and_rows() {
    let mut state = 1_u64;
    let mut chance = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
        state ^ state >> 29
    };
    let often = [3, 63_usize, 64, 65, 127, 128, 129, 190, 300, 512, 513, 600, 1500, 3000].repeat(8);
    for points in (1..=200).chain(often) {
        let words = points.div_ceil(64);
        let rows = 1 + chance() as usize % 12;
        let tail = if points % 64 == 0 { u64::MAX } else { (1 << (points % 64)) - 1 };
        // Rows that are mostly alike, full or empty, so that blank words occur.
        let base: Vec<u64> = (0..words).map(|_| [0, u64::MAX][chance() as usize % 2]).collect();
        let mut slice = || -> Vec<u64> {
            let mut row = |_| {
                let odd = chance();
                let mut row = base.clone();
                if odd % 3 == 0 {
                    row[odd as usize / 3 % words] = chance();
                }
                row[words - 1] &= tail;
                row
            };
            (0..rows).flat_map(&mut row).collect()
        };
        let (low, high) = (slice(), slice());
        check(&low, Some(&high), points);
        check(&low, None, points);
    }
}

#[test]
fn one_odd_point_is_seen_wherever_it_is() {
    for points in [1_usize, 63, 64, 65, 200, 256, 300, 520] {
        let (rows, words) = (3, points.div_ceil(64));
        let places = (0..points).filter(|i| [0, 1, 63].contains(&(i % 64)) || i + 1 == points);
        let places = places.flat_map(|i| (0..2 * rows).map(move |row| (i, row)));
        for ((i, row), is_inside) in places.flat_map(|place| [(place, false), (place, true)]) {
            let tail = u64::MAX >> (64 * words - points);
            let of_row = |w: usize| if w + 1 == words { tail } else { u64::MAX };
            let all = (0..2 * rows * words).map(|n| if is_inside { 0 } else { of_row(n % words) });
            let mut all: Vec<u64> = all.collect();
            all[row * words + i / 64] ^= 1 << (i % 64);
            let (low, high) = all.split_at(rows * words);
            check(low, Some(high), points);
        }
    }
}

#[test]
fn open_words_are_those_with_a_cell_of_a_code_that_leaves_something_open() {
    // Both the inside and the outside hang together along edges, or the code is open.
    let is_open = |code: usize| {
        let pieces = |inside: usize| {
            let own = |k: usize| code >> k & 1 == inside;
            let mut name: [usize; 8] = std::array::from_fn(|k| k);
            for _ in 0..8 {
                for (k, axis) in (0..8).flat_map(|k| (0..3).map(move |axis| (k, axis))) {
                    if own(k) && own(k ^ 1 << axis) {
                        name[k] = name[k].min(name[k ^ 1 << axis]);
                    }
                }
            }
            (0..8).filter(|&k| own(k) && name[k] == k).count()
        };
        pieces(0) > 1 || pieces(1) > 1
    };
    let mut state = 11_u64;
    let mut chance = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
        state ^ state >> 31
    };
    for points in [1_usize, 2, 63, 64, 65, 130, 600] {
        for kind in 0..3 {
            let words = points.div_ceil(64);
            let mut slice = || -> Vec<u64> {
                let last = |n: usize| n % words == words - 1 && points % 64 > 0;
                let mask = |n: usize| if last(n) { (1 << (points % 64)) - 1 } else { u64::MAX };
                let mut word = || if kind == 0 { chance() } else { chance() & chance() & chance() };
                (0..5 * words)
                    .map(|n| if kind == 2 && n % 3 > 0 { 0 } else { word() } & mask(n))
                    .collect()
            };
            let (low, high) = (slice(), slice());
            let bits = BitRows::new(&low, Some(&high), points);
            let (mut all, mut found) = (vec![], vec![]);
            words_of_rows_at(Level::Portable, &bits, 0..5, &mut all);
            for word in &all {
                let open = (0..64).filter(|&n| word.active >> n & 1 == 1);
                let open = open.filter(|&n| is_open(usize::from(word.case(n))));
                assert_eq!(word.open(), open.fold(0, |mask, n| mask | 1 << n));
            }
            all.retain(|word| word.open() != 0);
            all.iter_mut().for_each(|word| (word.cuts, word.active) = ([0; 8], word.open()));
            for &level in Level::available() {
                super::open_words_of_rows_at(level, &bits, 0..5, &mut found);
                assert_eq!(found, all, "{level}, {points} points");
            }
        }
    }
}

#[test]
fn no_rows_have_no_words() {
    let bits = BitRows::new(&[], Some(&[]), 100);
    for level in Level::available() {
        let mut words = vec![Word::default()];
        words_of_rows_at(*level, &bits, 0..0, &mut words);
        assert_eq!(words, [], "{level}");
    }
}

//! How many vertices and triangles there are between two slices, where nobody asks which row makes them.

use crate::{Level, euler::triangles};

/// Vertices and triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// On cut edges: those along x and y of the lower slice, and those from it to the upper one.
    pub vertices: u64,
    /// In the cells between the slices.
    pub triangles: u64,
}

/// Adds up what lies between two slices; of a last slice, above which is nothing, what lies in it.
///
/// A slice is rows of so many words `per_row`, and one word more whose bits mean nothing. Bits beyond a row's
/// last point are 0. `cells` has the words of a slice, without the one more, with a bit for each
/// point of a row but the last.
///
/// # Panics
///
/// If there are no rows, they have no words, or the slices or `cells` are not of one size.
pub fn totals(low: &[u64], high: Option<&[u64]>, cells: &[u64], per_row: usize) -> Totals {
    totals_at(Level::current(), low, high, cells, per_row)
}

fn totals_at(
    level: Level,
    low: &[u64],
    high: Option<&[u64]>,
    cells: &[u64],
    per_row: usize,
) -> Totals {
    let last = cells.len().checked_sub(per_row).expect("a slice has rows");
    let upper = high.unwrap_or(low);
    assert_eq!([low.len(), upper.len()], [cells.len() + 1; 2], "slices of one size");
    let rows = [&low[..=last], &low[per_row..], &upper[..=last], &upper[per_row..]];
    let mut sum = sum(level, rows, &cells[..last]);
    // After the last row there are no cells; with itself as the next it has no edges to it either.
    let [low, upper] = [&low[last..], &upper[last..]];
    sum.vertices += self::sum(level, [low, low, upper, upper], &cells[last..]).vertices;
    if high.is_none() {
        sum.triangles = 0;
    }
    sum
}

/// What the rows at y, z = 00, 10, 01, 11 own: each has one word more than there are words of cells.
#[inline(always)]
fn sum(level: Level, rows: [&[u64]; 4], cells: &[u64]) -> Totals {
    match level {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512 => {
            level.assert_available();
            // SAFETY: the machine has the level, asserted above; the function asks nothing else.
            unsafe { sum_avx512(rows, cells) }
        }
        #[cfg(target_arch = "x86_64")]
        Level::Avx2 => {
            level.assert_available();
            // SAFETY: as above.
            unsafe { sum_avx2(rows, cells) }
        }
        _ => sum_plain(rows, cells),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn sum_avx2(rows: [&[u64]; 4], cells: &[u64]) -> Totals {
    sum_plain(rows, cells)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(
    enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
)]
fn sum_avx512(rows: [&[u64]; 4], cells: &[u64]) -> Totals {
    sum_plain(rows, cells)
}

/// The one loop for all levels, which the compiler makes as wide as it may.
#[inline(always)]
fn sum_plain(rows: [&[u64]; 4], cells: &[u64]) -> Totals {
    let n = cells.len();
    let [a, b, c, d] = rows.map(|row| &row[..n]);
    let [a_next, b_next, c_next, d_next] = rows.map(|row| &row[1..=n]);
    let mut sum = Totals::default();
    for i in 0..n {
        let along_x = |row: &[u64], next: &[u64]| [row[i], row[i] >> 1 | next[i] << 63];
        let [a, b] = [along_x(a, a_next), along_x(b, b_next)];
        let [c, d] = [along_x(c, c_next), along_x(d, d_next)];
        let edges = [(a[0] ^ a[1]) & cells[i], a[0] ^ b[0], a[0] ^ c[0]];
        sum.vertices += edges.iter().map(|bits| u64::from(bits.count_ones())).sum::<u64>();
        let digits = triangles([a, b, c, d]).map(|bits| (bits & cells[i]).count_ones());
        sum.triangles += u64::from(digits[0]) + 2 * u64::from(digits[1]) + 4 * u64::from(digits[2]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::{Totals, totals_at};
    use crate::{BitRows, Level, RowCounts, count_rows};

    #[test]
    fn every_level_agrees_with_the_counts_of_rows() {
        let mut state = 11_u64;
        let mut chance = || {
            state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(1);
            state ^ state >> 29
        };
        for points in (1..=140_usize).chain([511, 512, 513, 700]) {
            let per_row = points.div_ceil(64);
            for rows in [1, 2, 3, 8] {
                let mut slice = |dense: bool| -> Vec<u64> {
                    let mut word = |n: usize| {
                        let word = if dense { chance() } else { chance() | chance() | chance() };
                        let is_cut = n % per_row == per_row - 1 && !points.is_multiple_of(64);
                        if is_cut { word & ((1 << (points % 64)) - 1) } else { word }
                    };
                    (0..per_row * rows).map(&mut word).collect()
                };
                let [low, high] = [slice(points % 2 == 0), slice(points % 3 == 0)];
                let cells: Vec<u64> = (0..per_row * rows)
                    .map(|n| match n % per_row == per_row - 1 {
                        true => (1 << ((points - 1) % 64)) - 1,
                        false => u64::MAX,
                    })
                    .collect();
                for high in [None, Some(&high)] {
                    let bits = BitRows::new(&low, high.map(|high| &high[..]), points);
                    let mut counts = vec![RowCounts::default(); rows];
                    count_rows(&bits, 0..rows, &mut counts);
                    let expected = counts.iter().fold(Totals::default(), |sum, row| Totals {
                        vertices: sum.vertices + u64::from(row.x + row.y + row.z),
                        triangles: sum.triangles + u64::from(row.triangles),
                    });
                    // The one word more may be anything.
                    let [low, high] = [Some(&low), high].map(|slice| {
                        slice.map(|slice| [&slice[..], &[0x5A5A_0F0F_3333_9999]].concat())
                    });
                    let low = low.expect("a lower slice");
                    for &level in Level::available() {
                        let found = totals_at(level, &low, high.as_deref(), &cells, per_row);
                        assert_eq!(found, expected, "{level}, {points} points, {rows} rows");
                    }
                }
            }
        }
    }
}

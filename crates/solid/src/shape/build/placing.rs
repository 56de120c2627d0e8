//! Where copies of a shape are, and how it is turned: matrices row by row, and shifts.

use super::super::Array;

pub(crate) const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

impl Array {
    pub(super) fn count(&self) -> u64 {
        match *self {
            Self::Grid { count, .. } => {
                count.iter().fold(1, |all, &n| u64::saturating_mul(all, n.into()))
            }
            Self::Linear { count, .. } | Self::Polar { count, .. } => count.into(),
        }
    }

    /// The turn, row by row, and then the shift, of each copy.
    pub(crate) fn copies(&self) -> Vec<([[f64; 3]; 3], [f64; 3])> {
        let start =
            |count: u32, center: bool| if center { -0.5 * (f64::from(count) - 1.0) } else { 0.0 };
        match *self {
            Self::Linear { count, step, center } => {
                let from = start(count, center);
                let shift = |n: u32| step.map(|c| c * (f64::from(n) + from));
                (0..count).map(|n| (IDENTITY, shift(n))).collect()
            }
            Self::Grid { count, step, center } => {
                let from = count.map(|n| start(n, center));
                let along = |axis: usize, n: u32| step[axis] * (f64::from(n) + from[axis]);
                let mut copies = vec![];
                for k in 0..count[2] {
                    for j in 0..count[1] {
                        let shift = |i| [along(0, i), along(1, j), along(2, k)];
                        copies.extend((0..count[0]).map(|i| (IDENTITY, shift(i))));
                    }
                }
                copies
            }
            Self::Polar { count, axis, turn } => {
                let turned = |n: u32| {
                    let mut degrees = [0.0; 3];
                    degrees[usize::from(axis.min(2))] = turn * f64::from(n);
                    (rotation(degrees), [0.0; 3])
                };
                (0..count).map(turned).collect()
            }
        }
    }
}

pub(super) fn transposed(rows: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| rows[j][i]))
}

/// The mirror image in the plane across a direction that is one long.
pub(crate) fn reflection(n: [f64; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(u8::from(i == j)) - 2.0 * n[i] * n[j]))
}

/// The least factor: by so much at least lengths grow.
pub(crate) fn least(by: [f64; 3]) -> f64 {
    by.into_iter().fold(f64::INFINITY, f64::min)
}

/// The rotation about x, then y, then z, row by row. Exact for quarter turns.
pub(crate) fn rotation(degrees: [f64; 3]) -> [[f64; 3]; 3] {
    let mut all = IDENTITY;
    for (axis, degrees) in degrees.into_iter().enumerate() {
        let [c, s] = turn(degrees);
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut own = IDENTITY;
        (own[i][i], own[i][j], own[j][i], own[j][j]) = (c, -s, s, c);
        let entry = |row: usize, k: usize| (0..3).map(|n| own[row][n] * all[n][k]).sum();
        all = [0, 1, 2].map(|row| [0, 1, 2].map(|k| entry(row, k)));
    }
    all
}

/// Cosine and sine of an angle.
fn turn(degrees: f64) -> [f64; 2] {
    let within = degrees % 360.0;
    let quarters = (within / 90.0).round();
    let rest = (within - 90.0 * quarters).to_radians();
    let (c, s) = (libm::cos(rest), libm::sin(rest));
    match (quarters as i32).rem_euclid(4) {
        0 => [c, s],
        1 => [-s, c],
        2 => [-c, -s],
        _ => [s, -c],
    }
}

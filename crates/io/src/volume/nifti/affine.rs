//! Where the samples are: one of the three methods of `nifti1.h`.

use super::{
    super::place::{EXPECTED, completed},
    header::Header,
};
use crate::ReadFault;
use isokit_geom::{Affine, Space};

/// From samples to the world, and whether that world is known.
pub(super) fn of(header: &Header<'_>) -> Result<(Affine, Space), ReadFault> {
    let [qform_code, sform_code] = header.codes();
    let (at, columns, origin, space) = match () {
        () if sform_code > 0 => sform(header),
        () if qform_code > 0 => qform(header),
        () => {
            let columns = diagonal(spacing(header));
            (header.layout.pixdim, columns, [0.0; 3], Space::Unknown)
        }
    };
    let columns = completed(columns);
    let affine = Affine::new(columns, origin);
    let affine = affine.map_err(|error| header.broken(at, EXPECTED, error.to_string()))?;
    Ok((affine, space))
}

type Found = (usize, [Option<[f64; 3]>; 3], [f64; 3], Space);

/// Method 3: three rows of a matrix.
fn sform(header: &Header<'_>) -> Found {
    let at = header.layout.srow;
    let entry = |row: usize, column: usize| header.real(at, 4 * row + column);
    let column = |column: usize| std::array::from_fn(|row| entry(row, column));
    let columns = std::array::from_fn(|axis| {
        let found: [f64; 3] = column(axis);
        // An axis that the file does not have needs no direction.
        (is_there(header, axis) || found != [0.0; 3]).then_some(found)
    });
    (at, columns, column(3), Space::Ras)
}

/// Method 2: a rotation as unit quaternion, spacings, and the handedness in `pixdim[0]`.
fn qform(header: &Header<'_>) -> Found {
    let at = header.layout.quatern;
    let [mut b, mut c, mut d] = [0, 1, 2].map(|n| header.real(at, n));
    let square = b * b + c * c + d * d;
    let mut a = (1.0 - square).max(0.0).sqrt();
    if 1.0 - square < 1e-7 {
        // Rounded up to a half turn: a is 0 and the rest is brought to length 1.
        let length = square.sqrt();
        (a, b, c, d) = (0.0, b / length, c / length, d / length);
    }
    let rotation = [
        [a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)],
        [2.0 * (b * c - a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d + a * b)],
        [2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a + d * d - b * b - c * c],
    ];
    let handedness = if header.real(header.layout.pixdim, 0) < 0.0 { -1.0 } else { 1.0 };
    let spacing = spacing(header);
    let columns = std::array::from_fn(|axis| {
        let sign = if axis == 2 { handedness } else { 1.0 };
        spacing[axis].map(|step| rotation[axis].map(|entry| entry * step * sign))
    });
    (at, columns, [3, 4, 5].map(|n| header.real(at, n)), Space::Ras)
}

/// Distances between samples; they count without sign. `None` for an axis that the file lacks.
fn spacing(header: &Header<'_>) -> [Option<f64>; 3] {
    std::array::from_fn(|axis| {
        let step = header.real(header.layout.pixdim, axis + 1).abs();
        (is_there(header, axis) || (step > 0.0 && step.is_finite())).then_some(step)
    })
}

/// Method 1, and the oldest: spacings.
fn diagonal(spacing: [Option<f64>; 3]) -> [Option<[f64; 3]>; 3] {
    std::array::from_fn(|axis| {
        let column = |step| std::array::from_fn(|k| if k == axis { step } else { 0.0 });
        spacing[axis].map(column)
    })
}

fn is_there(header: &Header<'_>, axis: usize) -> bool {
    (axis as i64) < header.size(0)
}

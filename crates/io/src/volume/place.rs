//! Where samples are in the world: what the file says, and what the caller says instead.

use super::VolumeOptions;
use crate::ReadFault;
use isokit_geom::{Affine, AffineError, Frame, Space, Unit};

/// The frame of a volume.
///
/// A spacing from the caller keeps the directions of the file's axes. Where the file's map is unusable
/// it replaces the map, and nobody can say any more which way the axes point.
pub(super) fn frame(
    (affine, unit, space): (Result<Affine, ReadFault>, Unit, Space),
    has_geometry: bool,
    options: &VolumeOptions,
    notes: &mut Vec<String>,
) -> Result<Frame, ReadFault> {
    let found = Frame { index_to_world: Affine::IDENTITY, unit, space };
    let Some(spacing) = options.spacing else {
        return moved(Frame { index_to_world: affine?, ..found }, has_geometry, options, notes);
    };
    if !spacing.iter().all(|&step| step > 0.0) {
        let fault = format!("spacing {} given; each must be above 0", listed(spacing));
        return Err(ReadFault::Caller(fault.into()));
    }
    let frame = match affine {
        Ok(affine) => {
            let old = affine.spacing();
            if has_geometry && old != spacing {
                notes.push(format!("spacing {} given, not {}", listed(spacing), listed(old)));
            }
            let columns = std::array::from_fn(|axis| {
                affine.columns()[axis].map(|step| step / old[axis] * spacing[axis])
            });
            let index_to_world = Affine::new(columns, affine.origin()).map_err(unusable)?;
            Frame { index_to_world, ..found }
        }
        Err(fault) => {
            notes.push(format!("spacing {} given; axes as stored, since {fault}", listed(spacing)));
            let index_to_world = Affine::axis_aligned(spacing, [0.0; 3]).map_err(unusable)?;
            Frame { index_to_world, space: Space::Unknown, ..found }
        }
    };
    moved(frame, has_geometry, options, notes)
}

/// The frame with the caller's origin.
fn moved(
    frame: Frame,
    has_geometry: bool,
    options: &VolumeOptions,
    notes: &mut Vec<String>,
) -> Result<Frame, ReadFault> {
    let Some(origin) = options.origin else { return Ok(frame) };
    let old = frame.index_to_world.origin();
    if has_geometry && old != origin {
        notes.push(format!("origin {} given, not {}", listed(origin), listed(old)));
    }
    let index_to_world = frame.index_to_world.with_origin(origin).map_err(unusable)?;
    Ok(Frame { index_to_world, ..frame })
}

fn unusable(error: AffineError) -> ReadFault {
    ReadFault::Caller(format!("spacing and origin given make no map to the world: {error}").into())
}

fn listed(numbers: [f64; 3]) -> String {
    numbers.map(|number| number.to_string()).join(",")
}

/// What a map from samples to the world is called in messages about a file without a usable one.
pub(super) const EXPECTED: &str = "a usable map from samples to the world (--spacing overrides it)";

/// Axes of length 1 at right angles to the known ones, for axes that a file does not have.
pub(super) fn completed(columns: [Option<[f64; 3]>; 3]) -> [[f64; 3]; 3] {
    let missing = columns.iter().filter(|column| column.is_none()).count();
    let unit = |axis: usize| std::array::from_fn(|k| f64::from(u8::from(k == axis)));
    if missing == 3 {
        return [unit(0), unit(1), unit(2)];
    }
    let mut columns = columns;
    while let Some(axis) = columns.iter().position(Option::is_none) {
        let next = |step: usize| columns[(axis + step) % 3];
        let column = match (next(1), next(2)) {
            (Some(a), Some(b)) => normal(a, b),
            // One axis alone: a second at right angles to it and to the world's axis it is least along.
            (Some(a), None) | (None, Some(a)) => {
                let least = (0..3).min_by(|&i, &j| a[i].abs().total_cmp(&a[j].abs()));
                normal(a, unit(least.unwrap_or(0)))
            }
            (None, None) => unit(axis),
        };
        columns[axis] = Some(column);
    }
    columns.map(|column| column.unwrap_or_default())
}

/// Length 1 at right angles to both; 0 or NaN, which no map takes, if they have one direction.
fn normal(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    let (a, b) = (shrunk(a), shrunk(b));
    let cross: [f64; 3] = std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    });
    let length = cross.iter().map(|c| c * c).sum::<f64>().sqrt();
    cross.map(|c| c / length)
}

/// The same direction, the largest component 1, so that products neither overflow nor vanish.
fn shrunk(v: [f64; 3]) -> [f64; 3] {
    let largest = v.iter().fold(0.0, |largest: f64, c| largest.max(c.abs()));
    v.map(|c| c / largest)
}

#[cfg(test)]
mod tests {
    use super::{completed, frame};
    use crate::{ReadFault, VolumeOptions};
    use isokit_geom::{Affine, Space, Unit};

    fn oblique() -> Affine {
        let columns = [[0.0, 2.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.0, 5.0]];
        Affine::new(columns, [1.0, 2.0, 3.0]).unwrap()
    }

    #[test]
    fn a_spacing_keeps_directions_and_says_what_it_overrides() {
        let options = VolumeOptions { spacing: Some([1.0, 1.0, 3.0]), ..Default::default() };
        let mut notes = vec![];
        let found = (Ok(oblique()), Unit::Millimetre, Space::Ras);
        let frame = frame(found, true, &options, &mut notes).unwrap();
        let columns = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 3.0]];
        assert_eq!(frame.index_to_world.columns(), columns);
        assert_eq!(frame.space, Space::Ras);
        assert_eq!(notes, ["spacing 1,1,3 given, not 2,2,5"]);
    }

    #[test]
    fn a_spacing_takes_the_place_of_an_unusable_map() {
        let bogus = || Err(ReadFault::Caller("bogus".into()));
        let mut notes = vec![];
        let found = || (bogus(), Unit::Millimetre, Space::Ras);
        assert!(frame(found(), true, &VolumeOptions::default(), &mut notes).is_err());
        let (spacing, origin) = (Some([1.0, 2.0, 3.0]), Some([7.0; 3]));
        let options = VolumeOptions { spacing, origin, ..Default::default() };
        let frame = frame(found(), true, &options, &mut notes).unwrap();
        assert_eq!(frame.index_to_world.point([1.0; 3]), [8.0, 9.0, 10.0]);
        assert_eq!((frame.space, frame.unit), (Space::Unknown, Unit::Millimetre));
    }

    #[test]
    fn no_spacing_of_0_is_taken() {
        for spacing in [[0.0, 1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, f64::NAN]] {
            let options = VolumeOptions { spacing: Some(spacing), ..Default::default() };
            let found = (Ok(oblique()), Unit::Unknown, Space::Unknown);
            assert!(frame(found, false, &options, &mut vec![]).is_err(), "{spacing:?}");
        }
    }

    #[test]
    fn missing_axes_stand_at_right_angles() {
        let (x, y, z) = ([2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(completed([None; 3]), [[1.0, 0.0, 0.0], y, z]);
        assert_eq!(completed([Some(x), Some(y), None]), [x, y, z]);
        let columns = completed([None, Some([1e200, 1e200, 0.0]), None]);
        assert!(Affine::new(columns.map(|c| c.map(|k| k / k.abs().max(1.0))), [0.0; 3]).is_ok());
        let flat = completed([Some(x), Some(x), None]);
        assert!(Affine::new(flat, [0.0; 3]).is_err());
    }
}

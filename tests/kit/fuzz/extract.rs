//! A small volume of any type, any samples and any options: the surface must be what is promised, also divided and balanced,
//! and the same from parts of the volume.

use super::{made::Made, promises};
use isokit::{
    for_any,
    refine::{RefineOptions, Subdivision},
};

/// Makes a volume, an isovalue and options of the bytes, extracts, and looks at the mesh.
///
/// # Panics
///
/// If [`promises::surface`] finds something wrong.
pub fn extract(bytes: &[u8]) {
    let Made { volume, iso, options, .. } = Made::of(bytes, [9; 3]);
    for_any!(&volume, volume => promises::surface(&volume.view(), iso, &options));
}

/// The same, divided and balanced in ways that the bytes say.
///
/// # Panics
///
/// If [`promises::refined`] finds something wrong.
pub fn refine(bytes: &[u8]) {
    let Made { volume, iso, options, choice } = Made::of(bytes, [7; 3]);
    let subdivision = match choice / 2 % 6 {
        0 => Subdivision::None,
        1 => Subdivision::Levels(1),
        2 => Subdivision::Levels(2),
        n => Subdivision::MaxError([0.3, 0.05, 0.01][usize::from(n) - 3]),
    };
    let refine = RefineOptions::DEFAULT.with_subdivision(subdivision);
    promises::refined(&volume, iso, &options, &refine.with_balance(choice.is_multiple_of(2)));
}

/// The same from few slices at a time, with bricks, beside another isovalue, and on two threads.
///
/// # Panics
///
/// If [`promises::pieces`] finds something wrong.
pub fn pieces(bytes: &[u8]) {
    let Made { volume, iso, options, choice } = Made::of(bytes, [70, 18, 18]);
    for_any!(&volume, volume => promises::pieces(&volume.view(), iso, &options, choice.into()));
}

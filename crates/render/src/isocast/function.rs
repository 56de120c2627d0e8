//! What is between the samples of a cell, and along a ray through it.

use super::{cell::Cubic, nonic::Nonic};
use crate::Interpolant;
use isokit_geom::vector::Vector;
use isokit_lanes::Threshold;
use isokit_volume::Sample;

/// What is between the samples of a cell.
pub(super) enum Function<T> {
    /// By its corners.
    Trilinear([T; 8]),
    /// Of samples around it too, in that cell: from which value to which it may be.
    Cubic([usize; 3], [f64; 2]),
}

/// The same along a ray.
pub(super) enum Line {
    Cubic(Cubic),
    Nonic(Nonic),
}

/// What was found of cells that are cubic: rays side by side go through the same ones.
pub(super) struct Kept {
    reaches: Vec<(usize, Option<[f64; 2]>)>,
    points: Vec<(usize, [[[f64; 4]; 4]; 4])>,
}

/// As many cells as rays beside each other go through, and as hold surfaces there; powers of two.
const REACHES: usize = 1 << 12;
const POINTS: usize = 1 << 9;

impl Kept {
    /// Nothing yet; there will be nothing where cells are not cubic.
    pub(super) fn for_rays_through(cubics: bool) -> Self {
        let (reaches, points) = if cubics { (REACHES, POINTS) } else { (0, 0) };
        let none = (usize::MAX, [[[0.0; 4]; 4]; 4]);
        Self { reaches: vec![(usize::MAX, None); reaches], points: vec![none; points] }
    }
}

/// The number of a cell, and where it is kept among so many.
fn place<T: Sample>(field: &Interpolant<'_, T>, [x, y, z]: [usize; 3], many: usize) -> [usize; 2] {
    let [nx, ny, _] = field.linear.view().dims();
    let number = x + nx * (y + ny * z);
    // Neighbours are far from each other (Knuth 1998, "The art of computer programming", volume 3, section 6.4).
    let mixed = (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    [number, mixed as usize & (many - 1)]
}

impl<T: Sample> Function<T> {
    pub(super) fn of(field: &Interpolant<'_, T>, cell: [usize; 3], kept: &mut Kept) -> Self {
        let trilinear = || Self::Trilinear(field.linear.view().cell(cell));
        if !field.is_cubic() {
            return trilinear();
        }
        let [number, at] = place(field, cell, REACHES);
        let (known, reach) = &mut kept.reaches[at];
        if *known != number {
            (*known, *reach) = (number, field.reach_of_cubic(cell));
        }
        reach.map_or_else(trilinear, |reach| Self::Cubic(cell, reach))
    }

    /// Whether all of the cell is inside of a surface, or nothing of it; none where that cannot be said.
    pub(super) fn is_inside(&self, (iso, threshold): (f64, Threshold<T>)) -> Option<bool> {
        let (is_none, is_all) = match self {
            Self::Trilinear(corners) => {
                let inside = corners.iter().filter(|&&sample| threshold.is_inside(sample)).count();
                (inside == 0, inside == corners.len())
            }
            Self::Cubic(_, [least, greatest]) => (*greatest < iso, *least >= iso),
        };
        (is_none || is_all).then_some(is_all)
    }

    /// What it is on the way between two places in the cell, from 0 to 1 along each axis.
    pub(super) fn between(
        &self,
        field: &Interpolant<'_, T>,
        kept: &mut Kept,
        [from, to]: [Vector; 2],
    ) -> Line {
        match self {
            Self::Trilinear(corners) => {
                let scaling = field.linear.view().scaling();
                let corners = corners.map(|sample| scaling.value(sample.to_f64()));
                Line::Cubic(Cubic::between(corners, from, to))
            }
            Self::Cubic(cell, _) => {
                let [number, at] = place(field, *cell, POINTS);
                let (known, points) = &mut kept.points[at];
                if *known != number {
                    (*known, *points) = (number, field.control_points(*cell));
                }
                Line::Nonic(Nonic::between(points, from, to))
            }
        }
    }
}

impl Line {
    pub(super) fn crossings(&self, iso: f64, is_inside: bool, meet: impl FnMut(f64)) -> bool {
        match self {
            Self::Cubic(cubic) => cubic.crossings(iso, is_inside, meet),
            Self::Nonic(nonic) => nonic.crossings(iso, is_inside, meet),
        }
    }
}

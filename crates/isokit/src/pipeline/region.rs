//! Which part of the samples is looked at.

use isokit_geom::Aabb;
use isokit_volume::Grid;
use std::{ops::Range, str::FromStr};

/// A part of a volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Region {
    /// All of it.
    #[default]
    Whole,
    /// Samples along x, y, z; the upper ends are not included.
    Samples([Span<u64>; 3]),
    /// A box in world space. All samples that the surface inside it depends on are taken, and no more
    /// than a box of samples has to: an oblique volume keeps some that lie outside.
    World([Span<f64>; 3]),
}

/// From one end to the other along an axis; an end that is not given is that of the volume.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span<T> {
    /// The lower end.
    pub from: Option<T>,
    /// The upper end.
    pub to: Option<T>,
}

/// A part that the volume does not have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegionError {
    /// A range of samples that is empty or leads out of the volume.
    #[error(
        "samples {}:{} of the {} axis, which has {size}: a part needs 0 <= from < to <= {size}",
        range.start, range.end, ["x", "y", "z"][*axis]
    )]
    Samples {
        /// 0, 1 or 2 for x, y, z.
        axis: usize,
        /// What was asked for.
        range: Range<u64>,
        /// Samples along the axis.
        size: u64,
    },
    /// A part that the lattice has, and of which samples were not read.
    #[error("samples {part:?} along x, y, z: of the file only {read:?} were read")]
    Unread {
        /// What was asked for.
        part: [Range<usize>; 3],
        /// What is there.
        read: [Range<usize>; 3],
    },
    /// A box in which the volume has no sample.
    #[error(
        "the box lies outside of the volume, which reaches from {:?} to {:?}", bounds.min, bounds.max
    )]
    World {
        /// Where the volume is.
        bounds: Aabb,
    },
}

impl Region {
    /// The samples of the part.
    ///
    /// # Errors
    ///
    /// If the part is empty or leads out of the volume.
    pub fn samples(&self, grid: &Grid) -> Result<[Range<u64>; 3], RegionError> {
        match self {
            Self::Whole => Ok(grid.dims().map(|n| 0..n)),
            Self::Samples(spans) => in_samples(spans, grid.dims()),
            Self::World(spans) => {
                in_world(spans, grid).ok_or(RegionError::World { bounds: grid.bounds() })
            }
        }
    }
}

fn in_samples(spans: &[Span<u64>; 3], dims: [u64; 3]) -> Result<[Range<u64>; 3], RegionError> {
    let range = |axis: usize| spans[axis].from.unwrap_or(0)..spans[axis].to.unwrap_or(dims[axis]);
    let ranges = [range(0), range(1), range(2)];
    for (axis, range) in ranges.iter().enumerate() {
        let size = dims[axis];
        if range.is_empty() || range.end > size {
            return Err(RegionError::Samples { axis, range: range.clone(), size });
        }
    }
    Ok(ranges)
}

/// The box of samples around the part of the world box in which the volume is.
fn in_world(spans: &[Span<f64>; 3], grid: &Grid) -> Option<[Range<u64>; 3]> {
    /// Rounding of a coordinate must not add a layer of samples, in sample distances.
    const ROUNDING: f64 = 1e-6;
    let bounds = grid.bounds();
    let min =
        std::array::from_fn(|k| spans[k].from.map_or(bounds.min[k], |c| c.max(bounds.min[k])));
    let max = std::array::from_fn(|k| spans[k].to.map_or(bounds.max[k], |c| c.min(bounds.max[k])));
    let is_inside_out = (0..3).any(|k: usize| min[k] > max[k]);
    let corners = Aabb { min, max }.corners();
    let around = Aabb::around(corners.map(|xyz| grid.frame.index_to_world.inverse_point(xyz)))?;
    let range = |k: usize| {
        let last = (grid.dims()[k] - 1) as f64;
        let from = (around.min[k] + ROUNDING).floor().max(0.0);
        let to = (around.max[k] - ROUNDING).ceil().min(last);
        from as u64..if from <= to { to as u64 + 1 } else { 0 }
    };
    let ranges = [range(0), range(1), range(2)];
    (!is_inside_out && ranges.iter().all(|range| !range.is_empty())).then_some(ranges)
}

/// Not three ranges.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected three ranges x0:x1,y0:y1,z0:z1 of {numbers} (an end may be left out), found {found:?}"
)]
pub struct ParseRegionError {
    numbers: &'static str,
    found: String,
}

impl Region {
    /// `x0:x1,y0:y1,z0:z1` in samples.
    ///
    /// # Errors
    ///
    /// If the text is none such.
    pub fn parse_samples(text: &str) -> Result<Self, ParseRegionError> {
        spans(text, |_: &u64| true)
            .map(Self::Samples)
            .ok_or_else(|| ParseRegionError { numbers: "whole numbers", found: text.to_owned() })
    }

    /// `x0:x1,y0:y1,z0:z1` in world units.
    ///
    /// # Errors
    ///
    /// If the text is none such.
    pub fn parse_world(text: &str) -> Result<Self, ParseRegionError> {
        spans(text, |number: &f64| number.is_finite())
            .map(Self::World)
            .ok_or_else(|| ParseRegionError { numbers: "numbers", found: text.to_owned() })
    }
}

fn spans<T: FromStr + Copy>(text: &str, is_sound: impl Fn(&T) -> bool) -> Option<[Span<T>; 3]> {
    let end = |text: &str| match text {
        "" => Some(None),
        number => number.parse().ok().filter(&is_sound).map(Some),
    };
    let span = |text: &str| {
        let (from, to) = text.split_once(':')?;
        Some(Span { from: end(from)?, to: end(to)? })
    };
    let spans: Option<Vec<Span<T>>> = text.split(',').map(span).collect();
    spans?.try_into().ok()
}

#[cfg(test)]
mod tests;

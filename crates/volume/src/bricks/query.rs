//! Which bricks an isovalue concerns.

use super::{BrickGrid, Bricks};
use crate::Sample;
use isokit_lanes::{Extent, Side, Threshold};

/// On which side of a threshold each brick is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sides {
    /// How the lattice is cut.
    pub grid: BrickGrid,
    /// A side for each brick, x fastest.
    pub of_brick: Vec<Side>,
}

impl<T: Sample> Bricks<T> {
    /// Looks at every brick. The answer is exact: a brick whose samples are all on one side is said to be
    /// there.
    pub fn sides(&self, threshold: Threshold<T>) -> Sides {
        let of_brick = self.extents.iter().map(|extent| extent.side(threshold)).collect();
        Sides { grid: self.grid, of_brick }
    }

    /// The share of bricks that a surface of one of the thresholds goes through, from 0 to 1.
    pub fn active_share(&self, thresholds: &[Threshold<T>]) -> f64 {
        let is_active = |extent: &&Extent<T>| {
            thresholds.iter().any(|&threshold| extent.side(threshold) == Side::Both)
        };
        self.extents.iter().filter(is_active).count() as f64 / self.extents.len() as f64
    }

    /// Whether a sample is NaN.
    pub fn has_nan(&self) -> bool {
        self.extents.iter().any(|extent| extent.has_nan)
    }
}

impl Sides {
    /// Bricks that have samples on both sides: those that the surface goes through.
    pub fn active(&self) -> usize {
        self.of_brick.iter().filter(|&&side| side == Side::Both).count()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Bricks, Grid, Scaling, Volume};
    use isokit_job::Job;
    use isokit_lanes::Side::{Both, Inside, Outside};

    /// Three bricks along x: 0 to 64, 64 to 128, 128 to 149.
    fn ramp(scaling: Scaling) -> (Volume<u8>, Bricks<u8>) {
        let grid = Grid::new([150, 1, 1], Default::default()).unwrap();
        let volume = Volume::new(grid, (0..150).collect()).unwrap().with_scaling(scaling);
        let bricks = Bricks::of(&volume.view(), &Job::default()).unwrap();
        (volume, bricks)
    }

    #[test]
    fn the_share_counts_a_brick_once_for_several_values() {
        let (_, bricks) = ramp(Scaling::IDENTITY);
        let share = |isos: &[f64]| {
            let each = isos.iter().map(|&iso| Scaling::IDENTITY.threshold(iso));
            bricks.active_share(&each.collect::<Vec<_>>())
        };
        assert_eq!(share(&[]), 0.0);
        assert_eq!(share(&[-1e9, 1e9]), 0.0);
        assert_eq!(share(&[10.0, 11.0, 12.5]), 1.0 / 3.0);
        assert_eq!(share(&[10.0, 70.0, 140.0]), 1.0);
    }

    #[test]
    fn a_brick_is_active_if_its_least_is_below_and_its_greatest_is_not() {
        let (_, bricks) = ramp(Scaling::IDENTITY);
        let of = |iso: f64| bricks.sides(Scaling::IDENTITY.threshold(iso)).of_brick;
        assert_eq!(of(64.0), [Both, Inside, Inside]);
        assert_eq!(of(64.1), [Outside, Both, Inside]);
        assert_eq!(of(128.0), [Outside, Both, Inside]);
        assert_eq!(of(149.0), [Outside, Outside, Both]);
        assert_eq!(of(0.0), [Inside; 3]);
        assert_eq!(of(-1e9), [Inside; 3]);
        assert_eq!(of(149.5), [Outside; 3]);
        assert_eq!(of(1e9), [Outside; 3]);
        assert_eq!(bricks.sides(Scaling::IDENTITY.threshold(64.0)).active(), 1);
    }

    #[test]
    fn samples_that_fall_where_their_meaning_rises_are_asked_as_meant() {
        let scaling = Scaling::new(-2.0, 10.0).unwrap();
        let (_, bricks) = ramp(scaling);
        assert_eq!(bricks.sides(scaling.threshold(10.0 - 128.0)).of_brick, [Inside, Both, Outside]);
        assert_eq!(
            bricks.sides(scaling.threshold(10.0 - 127.9)).of_brick,
            [Both, Outside, Outside]
        );
    }
}

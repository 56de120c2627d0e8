//! Straight lines from the eye through points of a picture, sixteen at a time, and where they go through a box.
//!
//! There is one text for all levels, and no fused multiply-add, so the bits are the same. What it is worth is measured by
//! `scripts/bench_render`.

use crate::{
    LINES, Level,
    wide::{Float, Task, Wide, run_at},
};

/// How a picture is looked at.
#[derive(Clone, Copy, Debug)]
pub struct Sight {
    /// Where lines begin in the middle of the picture, in the space of the box.
    pub from: [f64; 3],
    /// What a point adds that is 1 to the right and 1 up, and what leads ahead, in the space of the box.
    pub axes: [[f64; 3]; 3],
    /// The same in a space in which they are 1 long and across each other.
    pub units: [[f64; 3]; 3],
    /// Whether all lines begin at one place and part, instead of lying side by side.
    pub is_perspective: bool,
    /// The box reaches from 0 to here.
    pub last: [f64; 3],
}

/// Lines of sight, and where they go through a box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Sighted {
    /// Where each begins, along x, y, z.
    pub origins: [[f64; LINES]; 3],
    /// Where each leads, along x, y, z: as far as is 1 in the space in which axes are 1 long.
    pub directions: [[f64; LINES]; 3],
    /// The same there.
    pub towards: [[f64; LINES]; 3],
    /// How far it is from one whole number to the next along x, y, z: without end, upwards, where it does not move.
    pub paces: [[f64; LINES]; 3],
    /// How far it is into the box and out of it; from 0 on. A line beside the box is in it at no distance: it is out
    /// before it is in.
    pub near: [f64; LINES],
    /// See `near`.
    pub far: [f64; LINES],
}

impl Sight {
    /// The lines through points that are so far to the right of the middle of the picture, and up.
    #[inline]
    pub fn lines(&self, points: [&[f64; LINES]; 2], sighted: &mut Sighted) {
        self.lines_at(Level::current(), points, sighted);
    }

    fn lines_at(&self, level: Level, points: [&[f64; LINES]; 2], sighted: &mut Sighted) {
        run_at(level, Trace { sight: self, points, sighted });
    }
}

struct Trace<'b> {
    sight: &'b Sight,
    points: [&'b [f64; LINES]; 2],
    sighted: &'b mut Sighted,
}

impl Task for Trace<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { sight: Sight { from, axes, units, is_perspective, last }, points, sighted } =
            self;
        let (zero, one, endless) = (wide.f64(0.0), wide.f64(1.0), wide.f64(f64::INFINITY));
        let (right, up) = (wide.load_f64(points[0]), wide.load_f64(points[1]));
        let shorter = match is_perspective {
            true => one / (one + right * right + up * up).sqrt(),
            false => one,
        };
        let (mut near, mut far) = (zero, endless);
        for k in 0..3 {
            let aside = right * wide.f64(axes[0][k]) + up * wide.f64(axes[1][k]);
            let beside = right * wide.f64(units[0][k]) + up * wide.f64(units[1][k]);
            let (mut origin, mut direction) = (wide.f64(from[k]), wide.f64(axes[2][k]));
            let mut towards = wide.f64(units[2][k]);
            if *is_perspective {
                direction = (direction + aside) * shorter;
                towards = (towards + beside) * shorter;
            } else {
                origin = origin + aside;
            }
            let moves = direction.less(zero) | zero.less(direction);
            let is_beside = origin.less(zero) | wide.f64(last[k]).less(origin);
            let pace = wide.select_f64(moves, one / direction, endless);
            let (a, b) = ((zero - origin) * pace, (wide.f64(last[k]) - origin) * pace);
            // In the box all along, or never.
            let still = wide.select_f64(is_beside, endless, near);
            near = wide.select_f64(moves, a.min(b).max(near), still);
            far = wide.select_f64(moves, a.max(b).min(far), far);
            wide.store_f64(origin, &mut sighted.origins[k]);
            wide.store_f64(direction, &mut sighted.directions[k]);
            wide.store_f64(towards, &mut sighted.towards[k]);
            wide.store_f64(pace, &mut sighted.paces[k]);
        }
        wide.store_f64(near, &mut sighted.near);
        wide.store_f64(far, &mut sighted.far);
    }
}

#[cfg(test)]
mod tests {
    use super::{Sight, Sighted};
    use crate::{LINES, Level, vertices::tests::Chance};

    /// Small whole numbers and fractions of them, so that lines lie in faces of the box and along its edges.
    fn number(chance: &mut Chance) -> f64 {
        f64::from(chance.below(17)) / 4.0 - 2.0
    }

    #[test]
    fn lines_are_in_the_box_between_their_two_distances_and_every_level_finds_them_alike() {
        let mut chance = Chance(3);
        let (mut inside, mut beside) = (0, 0);
        for round in 0..400 {
            let axes = [(); 3].map(|()| [(); 3].map(|()| number(&mut chance)));
            let sight = Sight {
                from: [(); 3].map(|()| 4.0 * number(&mut chance)),
                axes,
                units: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                is_perspective: round % 2 == 0,
                last: [(); 3].map(|()| f64::from(chance.below(9) + 1)),
            };
            let points = [(); 2].map(|()| [(); LINES].map(|()| number(&mut chance)));
            let lines = |level| {
                let mut sighted = Sighted::default();
                sight.lines_at(level, points.each_ref(), &mut sighted);
                sighted
            };
            let plain = lines(Level::Portable);
            for &level in Level::available() {
                assert_eq!(lines(level), plain, "{level}");
            }
            for n in 0..LINES {
                let ([right, up], of) =
                    (points.map(|p| p[n]), |all: &[[f64; LINES]; 3]| all.map(|c| c[n]));
                let (origin, direction, towards) =
                    (of(&plain.origins), of(&plain.directions), of(&plain.towards));
                let aside = [0, 1, 2].map(|k| right * axes[0][k] + up * axes[1][k]);
                let shorter = match sight.is_perspective {
                    true => 1.0 / (1.0 + right * right + up * up).sqrt(),
                    false => 1.0,
                };
                for k in 0..3 {
                    let (from, to) = match sight.is_perspective {
                        true => (sight.from[k], (axes[2][k] + aside[k]) * shorter),
                        false => (sight.from[k] + aside[k], axes[2][k]),
                    };
                    assert_eq!((origin[k], direction[k]), (from, to));
                    let pace = if to == 0.0 { f64::INFINITY } else { 1.0 / to };
                    assert_eq!(plain.paces[k][n], pace);
                }
                let expected = match sight.is_perspective {
                    true => [right * shorter, up * shorter, shorter],
                    false => [0.0, 0.0, 1.0],
                };
                assert_eq!(towards, expected);
                let (near, far) = (plain.near[n], plain.far[n]);
                let is_in = |distance: f64, slack: f64| {
                    (0..3).all(|k| {
                        let at = origin[k] + distance * direction[k];
                        (-slack..=sight.last[k] + slack).contains(&at)
                    })
                };
                if direction == [0.0; 3] {
                    assert_eq!(near == f64::INFINITY, !is_in(0.0, 0.0));
                    continue;
                }
                // Everywhere between, and nowhere else.
                for step in 0..200 {
                    let distance = f64::from(step) / 7.0;
                    if distance > near + 1e-9 && distance < far - 1e-9 {
                        assert!(is_in(distance, 1e-9), "{distance} of {near} to {far}");
                        inside += 1;
                    } else if distance < near - 1e-9 || distance > far + 1e-9 {
                        assert!(!is_in(distance, -1e-9), "{distance} beside {near} to {far}");
                        beside += 1;
                    }
                }
            }
        }
        assert!(inside > 1000 && beside > 1000, "{inside}, {beside}");
    }
}

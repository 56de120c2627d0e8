//! What is between samples on the cubics of Catmull & Rom.
//!
//! Along each axis a value is on the cubic through the two nearest samples that rises at each as from its one neighbour
//! to the other; in space on the tensor product of three such cubics, of 4³ samples (Catmull & Rom 1974, "A class of local
//! interpolating splines"). A gradient is that of this function. Both are sums of differences of samples, so that where
//! all are equal nothing rises.

use super::{Between, Cells, Facing, Found, LINES, Lines, Table};
use crate::{
    Lane, Level,
    wide::{Exact, Float, Mask, Task, Wide},
};

impl<T: Lane> Between<'_, T> {
    /// As [`look`](Self::look), on cubics. The bits of those wanted of which nothing was found, because they are near the
    /// border or not all samples around are finite: they are for [`Found::put`].
    ///
    /// # Panics
    ///
    /// If the table has no part, or 2²⁴ or more.
    #[inline]
    pub fn look_cubic(
        &self,
        places: (&Lines, &[f64; LINES]),
        wanted: u16,
        table: &Table<'_>,
        facing: Option<&Facing>,
        found: &mut Found,
    ) -> u16 {
        self.look_cubic_at(Level::current(), places, wanted, table, facing, found)
    }

    pub(super) fn look_cubic_at(
        &self,
        level: Level,
        (lines, steps): (&Lines, &[f64; LINES]),
        wanted: u16,
        table: &Table<'_>,
        facing: Option<&Facing>,
        found: &mut Found,
    ) -> u16 {
        table.check();
        let mut left = wanted;
        let (between, left_out) = (*self, &mut left);
        match facing {
            None => T::look_cubic(
                level,
                Look::<T, false> {
                    between,
                    lines,
                    steps,
                    table,
                    facing: &Facing::default(),
                    found,
                    left: left_out,
                },
            ),
            Some(facing) => T::look_cubic_facing(
                level,
                Look::<T, true> { between, lines, steps, table, facing, found, left: left_out },
            ),
        }
        left
    }
}

pub struct Look<'b, 'a, T, const WITH_GRADIENT: bool> {
    between: Between<'a, T>,
    lines: &'b Lines,
    steps: &'b [f64; LINES],
    table: &'b Table<'b>,
    facing: &'b Facing,
    found: &'b mut Found,
    /// The bits of those wanted; then of those that are left.
    left: &'b mut u16,
}

impl<T: Lane, const WITH_GRADIENT: bool> Task for Look<'_, '_, T, WITH_GRADIENT> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { between, lines, steps, table, facing, found, left } = self;
        let wanted = *left;
        let cells = between.cells(wide, lines, steps);
        // All samples around have both neighbours along y and z.
        let inner = between.inner(wide, &cells, [1, 2, 2]);
        (found.seen, found.bent, found.odd) = (0, 0, 0);
        if inner & wanted == 0 {
            return;
        }
        // SAFETY: the cells of `inner` are so far from the border, asked there, and so near.
        let (stored, gradient) = unsafe { between.cubic::<W, WITH_GRADIENT>(wide, &cells, inner) };
        let is_finite = stored.abs().less(wide.f32(f32::INFINITY)).bits();
        let answered = wanted & inner & is_finite;
        *left = wanted & !answered;
        found.look_up(wide, table, stored, answered);
        if WITH_GRADIENT && found.seen != 0 {
            found.odd = found.seen & !found.face(wide, facing, gradient);
        }
    }
}

impl<T: Lane> Between<'_, T> {
    /// What is stored at places in cells, and the gradients there over two samples, if they are wanted.
    ///
    /// # Safety
    ///
    /// The cells of `inner` must have a cell on both sides along x and two along y and z, and [`Samples::is_near`] must
    /// hold for all slices.
    ///
    /// [`Samples::is_near`]: crate::Samples::is_near
    #[inline(always)]
    unsafe fn cubic<W: Wide, const WITH_GRADIENT: bool>(
        &self,
        wide: W,
        cells: &Cells<W>,
        inner: u16,
    ) -> (W::F32, [W::F32; 3]) {
        let numbers = self.numbers(wide, cells, inner);
        let [to_x, to_y, to_z] = self.samples.strides();
        let [x, y, z] = [
            Cubic::at(wide, cells.part[0]),
            Cubic::at(wide, cells.part[1]),
            Cubic::at(wide, cells.part[2]),
        ];
        let zero = wide.f32(0.0);
        // Of each slice its value and how it rises along x and y.
        let (mut values, mut along_x, mut along_y) = ([zero; 4], [zero; 4], [zero; 4]);
        for k in 0..4 {
            let below = self.samples.first() - to_x - to_y + (k as i64 - 1) * to_z;
            let from = [below, below + to_y, below + 2 * to_y, below + 3 * to_y];
            // SAFETY: they are samples around inner cells, which have both neighbours along y and z.
            let found = unsafe { wide.four_along_x(&self.samples, from, numbers) };
            let (mut rows, mut rises) = ([zero; 4], [zero; 4]);
            for (j, [a, b, c, d]) in found.into_iter().enumerate() {
                let row = [
                    T::Exact::to_f32(wide, a),
                    T::Exact::to_f32(wide, b),
                    T::Exact::to_f32(wide, c),
                    T::Exact::to_f32(wide, d),
                ];
                rows[j] = x.value(row);
                if WITH_GRADIENT {
                    rises[j] = x.rise(row);
                }
            }
            values[k] = y.value(rows);
            if WITH_GRADIENT {
                along_x[k] = y.value(rises);
                along_y[k] = y.rise(rows);
            }
        }
        let gradient = match WITH_GRADIENT {
            true => [z.value(along_x), z.value(along_y), z.rise(values)],
            false => [zero; 3],
        };
        (z.value(values), gradient)
    }
}

/// The weights of the differences between four samples in line: for the value, and for how it rises over two samples.
#[derive(Clone, Copy)]
struct Cubic<F> {
    value: [F; 3],
    rise: [F; 3],
}

impl<F: Float> Cubic<F> {
    /// At so much of the way between the inner two.
    #[inline(always)]
    fn at<W: Wide<F32 = F>>(wide: W, t: F) -> Self {
        let (half, one, two) = (wide.f32(0.5), wide.f32(1.0), wide.f32(2.0));
        let (three, four, six) = (wide.f32(3.0), wide.f32(4.0), wide.f32(6.0));
        let (left, by_half) = (one - t, half * t);
        let value = [
            by_half * left * left,
            by_half * (one + t * (three - two * t)),
            by_half * t * (t - one),
        ];
        let rise = [one + t * (three * t - four), one + six * t * left, t * (three * t - two)];
        Self { value, rise }
    }

    #[inline(always)]
    fn value(&self, row: [F; 4]) -> F {
        row[1] + sum(row, self.value)
    }

    #[inline(always)]
    fn rise(&self, row: [F; 4]) -> F {
        sum(row, self.rise)
    }
}

/// The sum of weighted differences between neighbours.
#[inline(always)]
fn sum<F: Float>([a, b, c, d]: [F; 4], [low, middle, high]: [F; 3]) -> F {
    (b - a) * low + (c - b) * middle + (d - c) * high
}

#[cfg(test)]
mod tests {
    use super::super::{BENT, Between, Facing, Found, LINES, Lines, SEEN, Table, tests::lines};
    use crate::{Lane, Level, Samples, vertices::tests::Chance};

    /// The weights of four samples in line as the books have them, and their derivatives.
    fn weights(t: f64) -> [[f64; 4]; 2] {
        let value = [
            t * (t * (2.0 - t) - 1.0),
            t * t * (3.0 * t - 5.0) + 2.0,
            t * (t * (4.0 - 3.0 * t) + 1.0),
            t * t * (t - 1.0),
        ];
        let rise = [
            t * (4.0 - 3.0 * t) - 1.0,
            t * (9.0 * t - 10.0),
            t * (8.0 - 9.0 * t) + 1.0,
            t * (3.0 * t - 2.0),
        ];
        [value, rise].map(|all| all.map(|weight| 0.5 * weight))
    }

    /// The value and the gradient at a place in f64, and the greatest sample of those that count; none near the border.
    fn plainly(
        at: impl Fn([i64; 3]) -> f64,
        dims: [usize; 3],
        (lines, steps): &(Lines, [f64; LINES]),
        n: usize,
    ) -> Option<([f64; 4], f64)> {
        let mut low = [0; 3];
        let mut along = [[[0.0; 4]; 2]; 3];
        for k in 0..3 {
            let last = dims[k] as f64 - 1.0;
            let place = lines.start[k][n] + steps[n] * lines.step[k][n];
            let place = if place > 0.0 { place.min(last) } else { 0.0 };
            low[k] = place.floor().min(last - 1.0) as i64;
            along[k] = weights(f64::from((place - low[k] as f64) as f32));
        }
        let is_inner =
            |k: usize, margin: i64| low[k] >= margin && low[k] + 1 + margin < dims[k] as i64;
        if !(is_inner(0, 1) && is_inner(1, 2) && is_inner(2, 2)) {
            return None;
        }
        let (mut sums, mut most) = ([0.0; 4], 0.0_f64);
        for n in 0..64 {
            let [i, j, k] = [n % 4, n / 4 % 4, n / 16];
            let sample = at([0, 1, 2].map(|axis| low[axis] + [i, j, k][axis] as i64 - 1));
            most = most.max(sample.abs());
            for (order, sum) in sums.iter_mut().enumerate() {
                let weight = |axis: usize, n: usize| along[axis][usize::from(order == axis + 1)][n];
                *sum += sample * weight(0, i) * weight(1, j) * weight(2, k);
            }
        }
        sums.iter().all(|sum| sum.is_finite()).then_some((sums, most))
    }

    fn check<T: Lane>(sample: fn(&mut Chance) -> T) {
        let mut chance = Chance(11);
        let marks = [SEEN, BENT, SEEN | BENT, SEEN, 0];
        let table = Table { slope: 1.0, intercept: 0.0, base: -60.0, scale: 0.02, marks: &marks };
        let covectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut answered = 0;
        for dims in [[19, 18, 17], [4, 6, 6], [2, 9, 3], [12, 17, 9]] {
            let all: Vec<T> = (0..dims.iter().product()).map(|_| sample(&mut chance)).collect();
            let [nx, ny, nz] = dims.map(|n: usize| n as isize);
            for (first, strides) in
                [(0, [1, nx, nx * ny]), (all.len() - 1, [-1, -nx, -nx * ny]), (0, [ny * nz, nz, 1])]
            {
                let samples = Samples::new(&all, first, strides, dims).unwrap();
                let between = Between::new(samples).unwrap();
                let at = |ijk: [i64; 3]| -> f64 {
                    let along = |k: usize| ijk[k] as isize * strides[k];
                    all[first.checked_add_signed(along(0) + along(1) + along(2)).unwrap()].into()
                };
                for _ in 0..60 {
                    let towards = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                    let axis = chance.below(3) as usize;
                    let facing = Facing { covectors, towards: towards[axis].map(|c| [c; LINES]) };
                    let (places, wanted) = (lines(&mut chance, dims), chance.next() as u16);
                    let look = |level, facing| {
                        let mut found = Found::default();
                        let places = (&places.0, &places.1);
                        let left = between
                            .look_cubic_at(level, places, wanted, &table, facing, &mut found);
                        (left, found)
                    };
                    let (left, plain) = look(Level::Portable, Some(&facing));
                    assert_eq!(left & !wanted, 0);
                    for n in (0..LINES).filter(|n| wanted >> n & 1 == 1) {
                        let expected = plainly(at, dims, &places, n);
                        assert_eq!(left >> n & 1 == 1, expected.is_none(), "{:?}", expected);
                        let Some(([value, gradient @ ..], most)) = expected else { continue };
                        answered += 1;
                        let off = (f64::from(plain.values[n]) - value).abs();
                        assert!(off <= 3e-6 * most, "{} for {value}", plain.values[n]);
                        let one_by_one = {
                            let mut found = Found::default();
                            found.put(n, plain.values[n], &table, false);
                            found
                        };
                        let of = |found: &Found| {
                            let bits = [found.seen, found.bent].map(|bits| bits >> n & 1);
                            (found.parts[n], found.shares[n], bits)
                        };
                        assert_eq!(of(&plain), of(&one_by_one));
                        if plain.seen & !plain.odd & 1 << n != 0 {
                            // Over two samples.
                            let long = 2.0 * gradient.iter().map(|c| c * c).sum::<f64>().sqrt();
                            let slack = 2e-5 * most;
                            assert!((f64::from(plain.slopes[n]) - long).abs() <= slack);
                            let cosine = (2.0 * gradient[axis] / long).abs();
                            let off = (f64::from(plain.cosines[n]) - cosine).abs();
                            assert!(off <= 2.0 * slack / long, "{} for {cosine}", plain.cosines[n]);
                        }
                    }
                    let bits = |(left, found): &(u16, Found), with_gradient: bool| {
                        let Found { values, parts, shares, cosines, slopes, seen, bent, odd } =
                            found;
                        let is_answered = |n: &usize| wanted & !left & 1 << n != 0;
                        let values = (0..LINES).filter(is_answered).map(|n| {
                            let is_known = with_gradient && seen & !odd & 1 << n != 0;
                            let faced = is_known.then(|| [cosines[n], slopes[n]].map(f32::to_bits));
                            ([values[n], shares[n]].map(f32::to_bits), parts[n], faced)
                        });
                        (
                            *left,
                            *seen,
                            *bent,
                            with_gradient.then_some(*odd),
                            values.collect::<Vec<_>>(),
                        )
                    };
                    for &level in Level::available() {
                        let (lit, dark) = (look(level, Some(&facing)), look(level, None));
                        let plainly = (left, plain);
                        assert_eq!(bits(&lit, true), bits(&plainly, true), "{level}");
                        assert_eq!(bits(&dark, false), bits(&plainly, false), "{level}");
                        assert_eq!(dark.1.odd, 0);
                    }
                }
            }
        }
        assert!(answered > 200, "{answered}");
    }

    #[test]
    fn every_level_finds_what_is_on_cubics_between_samples_of_every_type() {
        check::<u8>(|chance| chance.next() as u8);
        check::<i8>(|chance| chance.next() as i8);
        check::<u16>(|chance| chance.next() as u16);
        check::<i16>(|chance| chance.next() as i16);
        check::<u32>(|chance| chance.next() as u32);
        check::<i32>(|chance| chance.next() as i32);
        check::<f32>(|chance| match chance.below(400) {
            0 => f32::NAN,
            1 => f32::INFINITY,
            _ => chance.below(1000) as f32 / 7.0 - 50.0,
        });
        check::<f64>(|chance| f64::from(chance.below(100_000)) / 7.0 - 50.0);
    }

    #[test]
    fn where_all_samples_are_equal_nothing_rises() {
        let samples = Samples::new(&[0.1_f32; 4096], 0, [1, 16, 256], [16; 3]).unwrap();
        let table = Table { slope: 1.0, intercept: 0.0, base: 0.0, scale: 1.0, marks: &[SEEN] };
        let mut chance = Chance(3);
        let between = Between::new(samples).unwrap();
        let facing = Facing { covectors: [[1.0; 3]; 3], ..Facing::default() };
        for &level in Level::available() {
            let mut answered = 0;
            for _ in 0..20 {
                let (lines, steps) = lines(&mut chance, [16; 3]);
                let (mut found, places) = (Found::default(), (&lines, &steps));
                let faced = Some(&facing);
                let left =
                    between.look_cubic_at(level, places, u16::MAX, &table, faced, &mut found);
                for n in (0..LINES).filter(|n| left >> n & 1 == 0) {
                    assert_eq!((found.values[n], found.slopes[n]), (0.1, 0.0), "{level}");
                    answered += 1;
                }
            }
            assert!(answered > 10, "{answered}");
        }
    }
}

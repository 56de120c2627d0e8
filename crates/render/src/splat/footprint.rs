//! How much of a sample there is along a line: integrals of its kernel.

/// The radius of the kernel, in samples, and how wide its bell is: wide enough that the sums of kernels hardly waver
/// from sample to sample, and as narrow as that allows.
pub(super) const RADIUS: f64 = 1.8;
const WIDTH: f64 = 0.6;

/// Levels of the distance across sheets, and of the squares of distances along them.
const LEVELS: usize = 96;
const SQUARES: usize = 512;

/// The kernel around a sample: a Gaussian bell that ends where hardly anything is left of it.
pub(super) fn kernel([x, y, z]: [f64; 3]) -> f64 {
    let square = x * x + y * y + z * z;
    if square < RADIUS * RADIUS { (-square / (2.0 * WIDTH * WIDTH)).exp() } else { 0.0 }
}

/// The integral of a kernel along a line that is taken to be so long.
pub(super) fn line_integral(
    kernel: impl Fn([f64; 3]) -> f64,
    (from, to): ([f64; 3], [f64; 3]),
    long: f64,
) -> f64 {
    /// With so many parts nothing that is looked up shows the rest.
    const PARTS: u32 = 64;
    let at = |n: u32| {
        let share = (f64::from(n) + 0.5) / f64::from(PARTS);
        kernel(std::array::from_fn(|k| from[k] + (to[k] - from[k]) * share))
    };
    (0..PARTS).map(at).sum::<f64>() * long / f64::from(PARTS)
}

/// What a sample gives to places in the space of its kernel, where it is round: the mean of the kernel across a sheet, at
/// each distance from the sheet's middle, and each from the line through the sample across the sheet.
#[derive(Clone, Debug)]
pub(super) struct Footprint {
    /// By levels, then by squares.
    table: Vec<f32>,
    /// How far from the middle of a sheet a sample may be to count.
    reach: f64,
    /// Half of a sheet.
    half: f64,
    levels_per: f64,
    squares_per: f64,
}

/// What one sample gives to a sheet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section<'a> {
    /// By squares of the distance along the sheet.
    weights: &'a [f32; SQUARES],
    /// Up to which distance along the sheet there is something.
    pub(super) radius: f64,
}

impl Section<'_> {
    /// The weight that is nearest to a number of [squares](Footprint::squares_per).
    #[inline(always)]
    pub(super) fn weight(&self, squares: f32) -> f32 {
        // The last bits of the sum are the nearest whole number: quicker than asking for it. Nothing is in the last square.
        const WHOLE: f32 = (1 << 23) as f32;
        self.weights[(squares.min((SQUARES - 1) as f32) + WHOLE).to_bits() as usize % SQUARES]
    }
}

impl Footprint {
    /// For sheets of such a thickness, in samples.
    pub(super) fn new(thickness: f64) -> Self {
        let half = 0.5 * thickness;
        let reach = RADIUS + half;
        let levels_per = LEVELS as f64 / reach;
        // The last square is that of the radius.
        let squares_per = (SQUARES - 1) as f64 / (RADIUS * RADIUS);
        let entry = |n: usize| {
            // In the middle of a level, which is as near as it can be to all that is looked up there.
            let level = ((n / SQUARES) as f64 + 0.5) / levels_per;
            let square = (n % SQUARES) as f64 / squares_per;
            let end = |t: f64| [square.sqrt(), 0.0, t];
            line_integral(kernel, (end(level - half), end(level + half)), 1.0) as f32
        };
        let table = (0..LEVELS * SQUARES).map(entry).collect();
        Self { table, reach, half, levels_per, squares_per }
    }

    /// Squares of distances to places in [`Section::weights`].
    pub(super) fn squares_per(&self) -> f64 {
        self.squares_per
    }

    /// What a sample gives to a sheet from whose middle it is so far; nothing if that is too far.
    #[inline(always)]
    pub(super) fn section(&self, away: f64) -> Option<Section<'_>> {
        let away = away.abs();
        // Not where it is NaN either.
        if away.partial_cmp(&self.reach) != Some(std::cmp::Ordering::Less) {
            return None;
        }
        let level = ((away * self.levels_per) as usize).min(LEVELS - 1);
        let nearest = (away - self.half).max(0.0);
        let weights = self.table.as_chunks().0.get(level)?;
        Some(Section { weights, radius: (RADIUS * RADIUS - nearest * nearest).sqrt() })
    }

    /// The sum of what all samples of a lattice give to a place, on the mean.
    pub(super) fn sum(&self) -> f64 {
        // The integral over all space, a sample each of whose cells has the volume 1.
        let bell = (2.0 * std::f64::consts::PI).sqrt() * WIDTH;
        bell.powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::{Footprint, RADIUS, kernel, line_integral};
    use isokit_geom::vector::{cross, length};

    /// A box of such edges around 0.
    fn brick(h: [f64; 3]) -> impl Fn([f64; 3]) -> f64 {
        move |place| f64::from(u8::from((0..3).all(|k| place[k].abs() <= 0.5 * h[k])))
    }

    #[test]
    fn the_footprint_of_a_box_is_a_hexagon_that_holds_its_volume() {
        for (h, d) in [([1.0, 1.0, 1.0], [0.48, 0.6, 0.64]), ([1.0, 0.7, 2.0], [0.6, 0.0, 0.8])] {
            let across = cross(d, [0.0, 1.0, 0.3]);
            let u = across.map(|c| c / length(across));
            let v = cross(d, u);
            let (n, reach) = (160, 1.6);
            let (mut area, mut volume) = (0.0, 0.0);
            for number in 0..n * n {
                let [x, y] = [number % n, number / n]
                    .map(|i| reach * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0));
                let end = |t: f64| std::array::from_fn(|k| x * u[k] + y * v[k] + t * d[k]);
                let found = line_integral(brick(h), (end(-reach), end(reach)), 2.0 * reach);
                let pixel = (2.0 * reach / f64::from(n)).powi(2);
                area += if found > 0.0 { pixel } else { 0.0 };
                volume += found * pixel;
            }
            let expected = h[0] * h[1] * d[2] + h[1] * h[2] * d[0] + h[2] * h[0] * d[1];
            assert!((area / expected - 1.0).abs() < 0.03, "{area} for {expected}");
            let expected: f64 = h.iter().product();
            assert!((volume / expected - 1.0).abs() < 0.005, "{volume} for {expected}");
        }
    }

    #[test]
    fn sections_are_means_of_the_kernel_across_sheets() {
        for thickness in [0.1, 0.5, 1.3] {
            let footprint = Footprint::new(thickness);
            for n in 0..400 {
                let (away, b) = (f64::from(n % 20) / 8.0, f64::from(n / 20) / 10.0);
                let expected: f64 = (0..1000)
                    .map(|i| (f64::from(i) + 0.5) / 1000.0 - 0.5)
                    .map(|share| kernel([b, 0.0, away + share * thickness]) / 1000.0)
                    .sum();
                let found = footprint.section(away).filter(|section| b < section.radius);
                let place = (b * b * footprint.squares_per()) as f32;
                let found = found.map_or(0.0, |section| section.weight(place).into());
                assert!((expected - found).abs() < 0.03, "{away}, {b}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn kernels_add_up_to_nearly_the_same_everywhere() {
        let sum = Footprint::new(0.5).sum();
        for n in 0..100 {
            let place = [n % 10, n / 10, n % 7].map(|c| f64::from(c) / 10.0);
            let cells =
                (0..6 * 6 * 6).map(|n| [n % 6, n / 6 % 6, n / 36].map(|c| f64::from(c) - 2.0));
            let found: f64 = cells.map(|at| kernel([0, 1, 2].map(|k| place[k] - at[k]))).sum();
            assert!((found / sum - 1.0).abs() < 0.08, "{place:?}: {found} for {sum}");
        }
        assert!(kernel([RADIUS, 0.0, 0.0]) == 0.0 && kernel([1.7, 0.0, 0.0]) < 0.02);
    }
}

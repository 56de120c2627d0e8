//! What samples of one byte add to the surfaces at all isovalues, value by value.
//!
//! A sum over the edges that a surface crosses grows, from one isovalue to the next, by what each edge adds at its lower
//! end, and shrinks by the same at its higher end. So it is enough to know, for each value, the sum over all samples of
//! that value and all their edges, each with the sign of its rise away from the sample: an outflow. Of the rises
//! themselves that is the Laplacian. All are whole numbers, so that no order of adding them matters, and what an edge
//! adds at one end it takes at the other to the last bit.
//!
//! For the area an edge counts for the part of the surface's normal that is along it. Normals are those of central
//! differences at samples ([`Neighbours::normals`]); that of an edge is the mean of its ends, but for a factor that is the
//! same for all. Strips whose samples and neighbours are all equal add nothing, and no more is done with them.
//!
//! Rows are padded: a strip is before the first sample, and another after the last strip that has samples. What is beside
//! the first and the last sample is their copy.

mod tables;

use crate::{
    Level,
    wide::{Task, Wide, run_at},
};
use tables::{Tables, enter};

/// Samples of a strip.
pub const STRIP: usize = 32;

/// The greatest share of an edge: of one that is along the normal.
pub const WHOLE: i16 = 1 << 12;

/// What samples of a value add.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outflow {
    /// How many there are.
    pub samples: u64,
    /// Their neighbours that are greater, less those that are less.
    pub crossings: i64,
    /// How far neighbours along x, y and z are above them; or those along all axes in the first number, if no one asked for
    /// them apart.
    pub rises: [i64; 3],
    /// Shares of edges to neighbours that are greater, less those of edges to neighbours that are less.
    pub shares: i64,
}

impl Outflow {
    /// That of these samples and others.
    pub fn with(self, other: Self) -> Self {
        let rises = std::array::from_fn(|k| self.rises[k] + other.rises[k]);
        Self {
            samples: self.samples + other.samples,
            crossings: self.crossings + other.crossings,
            rises,
            shares: self.shares + other.shares,
        }
    }

    /// That of the same samples, if what is greater were less.
    pub fn reversed(self) -> Self {
        let Self { samples, crossings, rises, shares } = self;
        Self { samples, crossings: -crossings, rises: rises.map(|rise| -rise), shares: -shares }
    }
}

/// A padded row, and those beside it along y and z, which are the same row where there is no other.
#[derive(Clone, Copy, Debug)]
pub struct Neighbours<'a> {
    /// The row.
    pub own: &'a [u8],
    /// Those below it along y and z.
    pub low: [&'a [u8]; 2],
    /// Those above it along y and z.
    pub high: [&'a [u8]; 2],
}

impl Neighbours<'_> {
    /// Normals at the `count` samples of a row: the gradient over its length, times half of [`WHOLE`] and the scale's
    /// weights; 0 where the gradient is. And which strips are even: all samples and neighbours equal.
    ///
    /// # Panics
    ///
    /// If a row is too short for as many strips as `is_even` has, or those for so many samples.
    pub fn normals(self, scale: &Scale, count: usize, out: [&mut [i16]; 3], is_even: &mut [bool]) {
        run_at(Level::current(), Normals { rows: self, scale, count, out, is_even });
    }
}

/// What differences between the neighbours of a sample count for.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// In the square of the gradient's length, along x, y and z: 1 at most.
    pub weights: [f32; 3],
    /// By how much they are too short, along y and z: 2 at a border, else 1.
    pub times: [f32; 2],
}

struct Normals<'a> {
    rows: Neighbours<'a>,
    scale: &'a Scale,
    count: usize,
    out: [&'a mut [i16]; 3],
    is_even: &'a mut [bool],
}

impl Task for Normals<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, _: W) {
        let Self { rows: Neighbours { own, low, high }, scale, count, out, is_even } = self;
        let (strips, is_plain) = (is_even.len(), scale.is_plain());
        let [left, middle, right] =
            [STRIP - 1, STRIP, STRIP + 1].map(|first| cut(own, first, strips));
        let [below_y, below_z] = low.map(|row| cut(row, STRIP, strips));
        let [above_y, above_z] = high.map(|row| cut(row, STRIP, strips));
        let [out_x, out_y, out_z] = out;
        {
            let all_x = &mut out_x[STRIP..].as_chunks_mut::<STRIP>().0[..strips];
            let all_y = &mut out_y[STRIP..].as_chunks_mut::<STRIP>().0[..strips];
            let all_z = &mut out_z[STRIP..].as_chunks_mut::<STRIP>().0[..strips];
            for n in 0..strips {
                let (middle, left, right) = (&middle[n], &left[n], &right[n]);
                let (y0, y1, z0, z1) = (&below_y[n], &above_y[n], &below_z[n], &above_z[n]);
                let mut differ = [0; STRIP];
                for i in 0..STRIP {
                    let v = middle[i];
                    differ[i] = (left[i] ^ v)
                        | (right[i] ^ v)
                        | (y0[i] ^ v)
                        | (y1[i] ^ v)
                        | (z0[i] ^ v)
                        | (z1[i] ^ v);
                }
                is_even[n] = differ == [0; STRIP];
                let (out_x, out_y, out_z) = (&mut all_x[n], &mut all_y[n], &mut all_z[n]);
                if is_even[n] {
                    *out_x = [0; STRIP];
                    *out_y = [0; STRIP];
                    *out_z = [0; STRIP];
                    continue;
                }
                let rises =
                    |i: usize| [rise(left[i], right[i]), rise(y0[i], y1[i]), rise(z0[i], z1[i])];
                if is_plain {
                    for i in 0..STRIP {
                        [out_x[i], out_y[i], out_z[i]] = unit_normal(rises(i));
                    }
                } else {
                    for i in 0..STRIP {
                        [out_x[i], out_y[i], out_z[i]] = scale.normal(rises(i));
                    }
                }
            }
        }
        let ends = [STRIP, STRIP + count - 1];
        // Those of even strips are 0 already.
        for at in ends.into_iter().filter(|at| !is_even[at / STRIP - 1]) {
            let [y, z] = [0, 1].map(|axis| rise(low[axis][at], high[axis][at]));
            let rises = [2.0 * rise(own[at - 1], own[at + 1]), y, z];
            [out_x[at], out_y[at], out_z[at]] = scale.normal(rises);
        }
    }
}

/// So many strips of a padded row, from a sample on.
#[inline(always)]
fn cut<T>(row: &[T], first: usize, strips: usize) -> &[[T; STRIP]] {
    &row[first..].as_chunks().0[..strips]
}

/// How much greater a sample is than another.
#[inline(always)]
fn rise(a: u8, b: u8) -> f32 {
    f32::from(i16::from(b) - i16::from(a))
}

impl Scale {
    /// Whether neighbours are alike along all axes.
    fn is_plain(&self) -> bool {
        self.weights == [1.0; 3] && self.times == [1.0; 2]
    }

    #[inline(always)]
    fn normal(&self, [x, y, z]: [f32; 3]) -> [i16; 3] {
        let [wx, wy, wz] = self.weights;
        let [y, z] = [y * self.times[0], z * self.times[1]];
        let along = [x * wx, y * wy, z * wz];
        whole(along, along[0] * x + along[1] * y + along[2] * z)
    }
}

#[inline(always)]
fn unit_normal([x, y, z]: [f32; 3]) -> [i16; 3] {
    whole([x, y, z], x * x + y * y + z * z)
}

/// One over the square root, by a guess at its bits and a step towards it (Kadlec 2010, "Improving the fast inverse
/// square root"): within 0.07 %, with both signs alike, which is less than samples of a byte are rounded by. Of 0 it is
/// some great number.
#[inline(always)]
fn whole(along: [f32; 3], square: f32) -> [i16; 3] {
    let guess = f32::from_bits(0x5F1F_FFF9 - (square.to_bits() >> 1));
    let better = guess * (2.389_244_6 - square * (guess * guess));
    let inverse = better * (0.703_952_25 * 0.5 * WHOLE as f32);
    // Not `map`, which would be compiled for itself, without wider registers.
    let [x, y, z] = along;
    let near = |along: f32| (along * inverse + NEAREST).to_bits() as i16;
    [near(x), near(y), near(z)]
}

/// What makes the low bits of a small number those of the nearest whole one.
const NEAREST: f32 = 1.5 * (1 << 23) as f32;

/// Samples that may be added before sums of 32 bits are emptied.
const MOST_PENDING: usize = 60_000;

/// An edge counts for two normals of half of [`WHOLE`], and a little for rounding.
const _: () = assert!((MOST_PENDING + STRIP) * 6 * (WHOLE as usize + 2) < i32::MAX as usize);
const _: () = assert!(6 * (WHOLE as usize + 2) < i16::MAX as usize);

/// Sums by value.
#[derive(Clone, Debug)]
pub struct Outflows {
    tables: Tables,
    pending: usize,
    even: Box<[u64; 256]>,
    sums: Box<[Outflow; 256]>,
}

/// Normals along x at a row, along y at it and the rows beside it, along z at it and the rows below and above.
#[derive(Clone, Copy, Debug)]
pub struct RowNormals<'a> {
    /// At the row.
    pub own: [&'a [i16]; 3],
    /// Along y and z, at those below it.
    pub low: [&'a [i16]; 2],
    /// Along y and z, at those above it.
    pub high: [&'a [i16]; 2],
}

impl Outflows {
    /// Nothing yet. If rises are not to be apart, those along all axes are added up in the first of [`Outflow::rises`]: so an
    /// entry is half as long.
    pub fn new(rises_are_apart: bool) -> Self {
        Self {
            tables: Tables::new(rises_are_apart),
            pending: 0,
            even: Box::new([0; 256]),
            sums: Box::new([Outflow::default(); 256]),
        }
    }

    /// Adds a row of `count` samples.
    ///
    /// # Panics
    ///
    /// If a row is too short for as many strips as `is_even` has, or those are more than the samples have.
    pub fn add(
        &mut self,
        rows: Neighbours<'_>,
        normals: RowNormals<'_>,
        is_even: &[bool],
        count: usize,
    ) {
        run_at(Level::current(), Add { sums: self, rows, normals, is_even, count });
    }

    /// Adds samples of a value whose neighbours all have it too.
    pub fn add_even(&mut self, value: u8, samples: usize) {
        self.even[value as usize] += samples as u64;
    }

    fn flush(&mut self) {
        self.pending = 0;
        for (value, sum) in self.sums.iter_mut().enumerate() {
            sum.samples += std::mem::take(&mut self.even[value]);
            *sum = self.tables.take(value).into_iter().fold(*sum, Outflow::with);
        }
    }

    /// What all rows have added, by value.
    pub fn sums(mut self) -> Box<[Outflow; 256]> {
        self.flush();
        self.sums
    }
}

struct Add<'a> {
    sums: &'a mut Outflows,
    rows: Neighbours<'a>,
    normals: RowNormals<'a>,
    is_even: &'a [bool],
    count: usize,
}

impl Task for Add<'_> {
    #[inline(always)]
    fn run<W: Wide>(self, _: W) {
        let Self { sums, rows: Neighbours { own, low, high }, normals, is_even, count } = self;
        let strips = is_even.len();
        let around = |first| cut(own, first, strips);
        let [left, middle, right] = [STRIP - 1, STRIP, STRIP + 1].map(around);
        let [below_y, below_z] = low.map(|row| cut(row, STRIP, strips));
        let [above_y, above_z] = high.map(|row| cut(row, STRIP, strips));
        let along_x = |first| cut(normals.own[0], first, strips);
        let [x_left, x, x_right] = [STRIP - 1, STRIP, STRIP + 1].map(along_x);
        let [_, y, z] = normals.own.map(|row| cut(row, STRIP, strips));
        let [y_low, z_low] = normals.low.map(|row| cut(row, STRIP, strips));
        let [y_high, z_high] = normals.high.map(|row| cut(row, STRIP, strips));
        for n in 0..strips {
            let here = STRIP.min(count - STRIP * n);
            let middle = &middle[n];
            if is_even[n] {
                sums.even[middle[0] as usize] += here as u64;
                continue;
            }
            let sides =
                [[&left[n], &right[n]], [&below_y[n], &above_y[n]], [&below_z[n], &above_z[n]]];
            let along = [&x[n], &y[n], &z[n]];
            let ends =
                [[&x_left[n], &x_right[n]], [&y_low[n], &y_high[n]], [&z_low[n], &z_high[n]]];
            let (mut shares, mut crossings) = ([0_i16; STRIP], [0_i8; STRIP]);
            let mut rises = [[0_i16; STRIP]; 3];
            // One plain loop after another, of which each becomes vector code.
            for axis in 0..3 {
                let ([a, b], [p, q], own) = (sides[axis], ends[axis], along[axis]);
                for i in 0..STRIP {
                    crossings[i] += i8::from(a[i] > middle[i]) - i8::from(a[i] < middle[i]);
                    crossings[i] += i8::from(b[i] > middle[i]) - i8::from(b[i] < middle[i]);
                }
                for i in 0..STRIP {
                    shares[i] += (own[i] + q[i]) & -i16::from(b[i] != middle[i]);
                    shares[i] -= (own[i] + p[i]) & -i16::from(a[i] != middle[i]);
                }
                for i in 0..STRIP {
                    rises[axis][i] = i16::from(a[i]) + i16::from(b[i]) - 2 * i16::from(middle[i]);
                }
            }
            let values = &middle[..here];
            match &mut sums.tables {
                Tables::Apart(table) => enter(table, values, |i| {
                    let [x, y, z] = [rises[0][i], rises[1][i], rises[2][i]];
                    [shares[i], i16::from(crossings[i]), x, y, z, 1, 0, 0]
                }),
                Tables::Together(table) => enter(table, values, |i| {
                    let rise = rises[0][i] + rises[1][i] + rises[2][i];
                    [shares[i], i16::from(crossings[i]), rise, 1]
                }),
            }
            sums.pending += here;
            if sums.pending > MOST_PENDING {
                sums.flush();
            }
        }
    }
}

#[cfg(test)]
mod tests;

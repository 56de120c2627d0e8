//! What is found between samples: values, looked up in a table, and how gradients face.

use super::LINES;
use crate::wide::{BATCH, Float, Mask, Wide};

/// What values are looked up in: a table of parts that are equally wide.
#[derive(Clone, Copy, Debug)]
pub struct Table<'a> {
    /// What a stored sample means: `slope · sample + intercept`.
    pub slope: f32,
    /// See `slope`.
    pub intercept: f32,
    /// The value at which the first part begins.
    pub base: f32,
    /// Parts per value.
    pub scale: f32,
    /// Of each part [`SEEN`], [`BENT`], both, or 0. What is beyond all parts is as in the nearest.
    pub marks: &'a [u8],
}

/// The mark of a part in which something can be seen.
pub const SEEN: u8 = 1;

/// The mark of a part in which what is seen does not change linearly.
pub const BENT: u8 = 2;

/// How gradients face lines.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Facing {
    /// Where each line leads in the world, along x, y, z: one long.
    pub towards: [[f32; LINES]; 3],
    /// What takes a gradient in index space to the world, but for its length, as columns. No number is above 1.
    pub covectors: [[f32; 3]; 3],
}

/// What was found on each line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Found {
    /// The values.
    pub values: [f32; LINES],
    /// The parts of the table that they are in.
    pub parts: [u32; LINES],
    /// How far in it, from 0 to 1.
    pub shares: [f32; LINES],
    /// The cosines between lines and gradients, without their signs, where something is seen and not odd.
    pub cosines: [f32; LINES],
    /// How long gradients are there, as they are in the world by [`Facing::covectors`], for differences over two samples.
    pub slopes: [f32; LINES],
    /// The bits of those where something can be seen: that are not NaN, and in such a part.
    pub seen: u16,
    /// The bits of those of them that are in a part with the mark [`BENT`].
    pub bent: u16,
    /// The bits of those of which no cosine was found: at the border, or where the gradient is NaN, or too large or
    /// small to square.
    pub odd: u16,
}

/// Squares of gradients in f32 of which no digit is lost.
pub(super) const TAME: std::ops::Range<f32> = 1e-30..1e30;

impl Table<'_> {
    /// # Panics
    ///
    /// If there is no part, or 2²⁴ or more.
    pub(super) fn check(&self) {
        let parts = self.marks.len();
        assert!((1..1 << 24).contains(&parts), "a table with {parts} parts");
    }
}

impl Found {
    /// Puts in a value that was found elsewhere, and what the table has for it. If gradients are wanted, this one is odd.
    ///
    /// # Panics
    ///
    /// If there is no such line, or the table has no part.
    pub fn put(&mut self, n: usize, value: f32, table: &Table<'_>, with_gradient: bool) {
        let parts = table.marks.len();
        let place = ((value - table.base) * table.scale).max(0.0).min(parts as f32);
        let part = (place as usize).min(parts - 1);
        (self.values[n], self.parts[n]) = (value, part as u32);
        self.shares[n] = place - part as f32;
        let bit = |is_so: bool| u16::from(is_so) << n;
        let seen = bit(table.marks[part] & SEEN != 0 && !value.is_nan());
        self.seen = self.seen & !bit(true) | seen;
        self.bent = self.bent & !bit(true) | seen & bit(table.marks[part] & BENT != 0);
        self.odd = self.odd & !bit(true) | seen & bit(with_gradient);
    }

    /// The values of stored samples, and what the table has for them.
    #[inline(always)]
    pub(super) fn look_up<W: Wide>(
        &mut self,
        wide: W,
        table: &Table<'_>,
        stored: W::F32,
        wanted: u16,
    ) {
        let (zero, one) = (wide.f32(0.0), wide.f32(1.0));
        let value = stored * wide.f32(table.slope) + wide.f32(table.intercept);
        let place = (value - wide.f32(table.base)) * wide.f32(table.scale);
        // What is NaN is in the first part.
        let last = table.marks.len() - 1;
        let place = place.max(zero).min(wide.f32(table.marks.len() as f32));
        let part = wide.truncate_f32(place.min(wide.f32(last as f32)));
        wide.store_f32(value, &mut self.values);
        wide.store_f32(place - wide.u32_to_f32(part), &mut self.shares);
        self.parts = wide.store(part);
        let is_number = (value.less(one) | zero.less(value)).bits();
        let mut marks = [0; BATCH];
        for (mark, &part) in marks.iter_mut().zip(&self.parts) {
            *mark = table.marks[(part as usize).min(last)];
        }
        self.seen = bits(marks, SEEN) & is_number & wanted;
        self.bent = bits(marks, BENT) & self.seen;
    }

    /// The cosines of gradients and how long they are; the bits of those that are found.
    #[inline(always)]
    pub(super) fn face<W: Wide>(&mut self, wide: W, facing: &Facing, gradient: [W::F32; 3]) -> u16 {
        let (mut square, mut along) = (wide.f32(0.0), wide.f32(0.0));
        for k in 0..3 {
            let [x, y, z] = &facing.covectors;
            let x_y = wide.f32(x[k]) * gradient[0] + wide.f32(y[k]) * gradient[1];
            let world = x_y + wide.f32(z[k]) * gradient[2];
            square = square + world * world;
            along = along + world * wide.load_f32(&facing.towards[k]);
        }
        let long = square.sqrt();
        let cosine = (along / long).abs().min(wide.f32(1.0));
        wide.store_f32(cosine, &mut self.cosines);
        wide.store_f32(long, &mut self.slopes);
        let is_tame = square.less(wide.f32(TAME.end)) & !square.less(wide.f32(TAME.start));
        is_tame.bits()
    }
}

/// The bits of those that have a mark.
#[inline(always)]
fn bits(marks: [u8; BATCH], mark: u8) -> u16 {
    const ONES: u64 = 0x0101_0101_0101_0101;
    // Moves the lowest bits of eight bytes to the highest byte, where none is added to another.
    const GATHER: u64 = 0x0102_0408_1020_4080;
    let all = u128::from_le_bytes(marks) >> mark.trailing_zeros();
    let low = (all as u64 & ONES).wrapping_mul(GATHER) >> 56;
    let high = ((all >> 64) as u64 & ONES).wrapping_mul(GATHER) >> 56;
    (low | high << 8) as u16
}

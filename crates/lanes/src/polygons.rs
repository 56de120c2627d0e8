//! Which way to cut polygons into triangles, sixteen polygons at a time.
//!
//! Of each the ways to cut it are weighed by how much normals turn along their diagonals, and those are left out of which a
//! triangle looks away. The choice has one text for all levels, and no fused multiply-add, so it is the same. Corners are
//! gathered in one of two ways, with the same subtraction.

use crate::{
    Level,
    wide::{BATCH, Float, Task, Wide, run_at},
};

mod gather;
#[cfg(test)]
mod tests;

/// Polygons that are looked at together.
pub const POLYGONS: usize = BATCH;

/// The most corners that a polygon has.
pub const CORNERS: usize = 7;

/// The most diagonals that one has.
pub const DIAGONALS: usize = CORNERS * (CORNERS - 3) / 2;

/// The most triples of corners that one has.
pub const TRIPLES: usize = CORNERS * (CORNERS - 1) * (CORNERS - 2) / 6;

/// The most ways to cut one.
pub const WAYS: usize = 42;

/// Polygons of `N` corners, four to [`CORNERS`], counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Polygons<const N: usize> {
    /// Of each corner how far it is from the first, along x, y and z, of all polygons.
    pub places: [[[f32; POLYGONS]; 3]; N],
    /// The normals of the corners, outward, one long.
    pub normals: [[[f32; POLYGONS]; 3]; N],
}

/// Ways that polygons may not be cut in: way `w` of polygon `p` is bit `31 - w % 32` of number `[w / 32][p]`.
pub type Forbidden = [[u32; POLYGONS]; 2];

/// A way to cut a polygon of `N` corners.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Way {
    /// The numbers of its `N − 3` [`diagonals`]; the rest is not looked at.
    pub diagonals: [u8; CORNERS - 3],
    /// The numbers of its `N − 2` triangles among the [`triples`]; the rest is not looked at.
    pub triangles: [u8; CORNERS - 2],
}

/// The diagonals of a polygon of `N` corners, as pairs of these, in order; the rest is 0.
pub const fn diagonals<const N: usize>() -> [[usize; 2]; DIAGONALS] {
    let (mut all, mut count, mut a) = ([[0; 2]; DIAGONALS], 0, 0);
    while a < N {
        let mut b = a + 2;
        while b < N && b - a < N - 1 {
            all[count] = [a, b];
            count += 1;
            b += 1;
        }
        a += 1;
    }
    all
}

/// All triples of the corners of a polygon of `N`, in order; the rest is 0.
pub const fn triples<const N: usize>() -> [[usize; 3]; TRIPLES] {
    let (mut all, mut count, mut a) = ([[0; 3]; TRIPLES], 0, 0);
    while a < N {
        let mut b = a + 1;
        while b < N {
            let mut c = b + 1;
            while c < N {
                all[count] = [a, b, c];
                count += 1;
                c += 1;
            }
            b += 1;
        }
        a += 1;
    }
    all
}

impl<const N: usize> Default for Polygons<N> {
    fn default() -> Self {
        Self { places: [[[0.0; POLYGONS]; 3]; N], normals: [[[0.0; POLYGONS]; 3]; N] }
    }
}

impl<const N: usize> Polygons<N> {
    /// Of each polygon the number of the way whose diagonals have the least sum of squares of (n₁ − n₀) · (p₁ − p₀), p and n being
    /// places and normals of their ends, among the `ways` that are not `forbidden` and of which each triangle looks where the
    /// normals of all corners together do, by more than rounding; `own` where none has less than that.
    ///
    /// Where `mirrors` is set the corners are clockwise.
    ///
    /// # Panics
    ///
    /// If there are more than [`WAYS`], or one names more than there is of anything.
    /// With other than four to seven corners it does not compile.
    pub fn best(
        &self,
        (ways, forbidden): (&[Way], &Forbidden),
        own: &[u32; POLYGONS],
        mirrors: bool,
    ) -> [u32; POLYGONS] {
        self.best_at(Level::current(), (ways, forbidden), own, mirrors)
    }

    fn best_at(
        &self,
        level: Level,
        (ways, forbidden): (&[Way], &Forbidden),
        own: &[u32; POLYGONS],
        mirrors: bool,
    ) -> [u32; POLYGONS] {
        const { assert!(4 <= N && N <= CORNERS, "four to seven corners") };
        assert!(ways.len() <= WAYS, "{} ways", ways.len());
        let mut best = *own;
        let choice = Choice { polygons: self, ways, forbidden, mirrors, best: &mut best };
        match N {
            4 => run_at(level, Choose::<N, 2, 4>(choice)),
            5 => run_at(level, Choose::<N, 5, 10>(choice)),
            6 => run_at(level, Choose::<N, 9, 20>(choice)),
            _ => run_at(level, Choose::<N, DIAGONALS, TRIPLES>(choice)),
        }
        best
    }
}

/// The share of N times the squares of all distances from the first corner that is surely more than rounding.
const LEAST: f32 = 1.0 / 65536.0;

/// What there is to choose from.
struct Choice<'a, const N: usize> {
    polygons: &'a Polygons<N>,
    ways: &'a [Way],
    forbidden: &'a Forbidden,
    mirrors: bool,
    /// At first the polygons' own ways.
    best: &'a mut [u32; POLYGONS],
}

/// The choice, for polygons of `N` corners with `D` diagonals and `T` triples of corners.
struct Choose<'a, const N: usize, const D: usize, const T: usize>(Choice<'a, N>);

impl<const N: usize, const D: usize, const T: usize> Task for Choose<'_, N, D, T> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Choice { polygons, ways, forbidden, mirrors, best: found } = self.0;
        let places = loaded(wide, &polygons.places);
        let normals = loaded(wide, &polygons.normals);
        let zero = wide.f32(0.0);
        let mut squares = [zero; D];
        for (square, [a, b]) in squares.iter_mut().zip(const { diagonals::<N>() }) {
            let bend =
                dot::<W>(minus::<W>(places[b], places[a]), minus::<W>(normals[b], normals[a]));
            *square = bend * bend;
        }
        let is_sound: [W::Mask; T] = sound(wide, &places, &normals, mirrors);
        let own = wide.load(found);
        let (mut least, mut best) = (zero, own);
        for (n, way) in ways.iter().enumerate() {
            let is_own = wide.equal(own, wide.u32(n as u32));
            least = wide.select_f32(is_own, sum::<W, N, D>(&squares, way), least);
        }
        let mut bits = wide.load(&forbidden[0]);
        for (n, way) in ways.iter().enumerate() {
            let sum = sum::<W, N, D>(&squares, way);
            if n == u32::BITS as usize {
                bits = wide.load(&forbidden[1]);
            }
            // What is not a number is not less.
            let mut is_better = sum.less(least) & wide.less(bits, wide.u32(1 << 31));
            bits = bits + bits;
            for &triangle in &way.triangles[..N - 2] {
                is_better = is_better & is_sound[usize::from(triangle)];
            }
            least = wide.select_f32(is_better, sum, least);
            best = wide.select(is_better, wide.u32(n as u32), best);
        }
        *found = wide.store(best);
    }
}

/// What is weighed of a way.
#[inline(always)]
fn sum<W: Wide, const N: usize, const D: usize>(squares: &[W::F32; D], way: &Way) -> W::F32 {
    let mut sum = squares[usize::from(way.diagonals[0])];
    for &diagonal in &way.diagonals[1..N - 3] {
        sum = sum + squares[usize::from(diagonal)];
    }
    sum
}

/// Where each triple of corners makes a triangle that looks as all normals together do.
#[inline(always)]
fn sound<W: Wide, const N: usize, const T: usize>(
    wide: W,
    places: &[[W::F32; 3]; N],
    normals: &[[W::F32; 3]; N],
    mirrors: bool,
) -> [W::Mask; T] {
    let zero = wide.f32(0.0);
    let (mut mean, mut size) = ([zero; 3], zero);
    for corner in 0..N {
        for k in 0..3 {
            mean[k] = mean[k] + normals[corner][k];
        }
        size = size + dot::<W>(places[corner], places[corner]);
    }
    if mirrors {
        mean = minus::<W>([zero; 3], mean);
    }
    // The product of three vectors: a · (b × m).
    let mut across = [[zero; 3]; N];
    for corner in 0..N {
        let ([x, y, z], [u, v, w]) = (places[corner], mean);
        across[corner] = [y * w - z * v, z * u - x * w, x * v - y * u];
    }
    let least = size * wide.f32(LEAST * N as f32);
    let mut is_sound = [wide.mask(0); T];
    for (is_sound, [a, b, c]) in is_sound.iter_mut().zip(const { triples::<N>() }) {
        let area = dot::<W>(minus::<W>(places[b], places[a]), minus::<W>(across[c], across[a]));
        *is_sound = least.less(area);
    }
    is_sound
}

#[inline(always)]
fn loaded<W: Wide, const N: usize>(
    wide: W,
    numbers: &[[[f32; POLYGONS]; 3]; N],
) -> [[W::F32; 3]; N] {
    let mut found = [[wide.f32(0.0); 3]; N];
    for corner in 0..N {
        for k in 0..3 {
            found[corner][k] = wide.load_f32(&numbers[corner][k]);
        }
    }
    found
}

#[inline(always)]
fn minus<W: Wide>(a: [W::F32; 3], b: [W::F32; 3]) -> [W::F32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<W: Wide>(a: [W::F32; 3], b: [W::F32; 3]) -> W::F32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

//! Where an edge is crossed, and the normal there.
//!
//! With α and β the values at the two ends less the isovalue, linear interpolation crosses the edge at
//! δ = ((α + β) / 2) / (α − β) from its middle, in edge lengths. Seen from the other end the same numbers
//! give the same δ with the other sign, to the last bit, so mirrored volumes give mirrored vertices.
//! Everything is f64 until the position is whole; then it is rounded once.
//!
//! [`Placement::Cubic`] and [`Placement::Quintic`] look at more samples on the line of the edge
//! (`curved`), and cross the polynomial through them (`curve`), where that is fit to be crossed: for coordinates of f32 in
//! f32, to a part of the edge that those tell apart only near the origin. Elsewhere a vertex is
//! that of linear interpolation. Normals are made from central differences at both ends of the edge, or, of
//! [`Gradient::Matching`], from those of the curve's order, which need no more than finite samples.

mod curve;
mod curved;

use crate::{ExtractOptions, Gradient, Placement};
use isokit_lanes::{Coordinate, Curve, Edges, Field, Samples, Vertices, Word, vertices};
use isokit_volume::{Sample, View, differences};

/// The range of a gradient's greatest part within which its square neither overflows nor vanishes.
const TAME: std::ops::Range<f64> = 1e-120..1e120;

/// A cut edge of the lattice.
#[derive(Clone, Copy, Debug)]
struct Cut {
    axis: usize,
    /// The lower end in index space; a guard's index may be −1.
    low: [f64; 3],
    /// The samples at the lower and the upper end; none where a guard is.
    ends: [Option<[usize; 3]>; 2],
    values: [Option<f64>; 2],
    /// The crossing, in edge lengths from the middle of the edge.
    delta: f64,
}

/// What a vertex depends on, beside its edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placer<'a, T> {
    view: View<'a, T>,
    samples: Option<Samples<'a, T>>,
    field: Field,
    placement: Placement,
    gradient: Gradient,
    /// The unit normals where values fall along each axis, and where they rise.
    along: [[[f32; 3]; 2]; 3],
}

impl<'a, T: Sample> Placer<'a, T> {
    /// `margin` is the least distance that a vertex keeps from both ends of its edge, in edge lengths.
    /// `first_slice` is the number of the view's first slice in the volume that the frame is of.
    pub(crate) fn new(view: View<'a, T>, iso: f64, margin: f64, first_slice: f64) -> Self {
        let affine = view.frame().index_to_world;
        let field = Field {
            iso,
            slope: view.scaling().slope(),
            intercept: view.scaling().intercept(),
            reach: 0.5 - margin,
            columns: affine.columns(),
            origin: affine.origin(),
            first_slice,
            covectors: affine.covector_columns(),
        };
        let (placement, gradient) = (Placement::Linear, Gradient::Central);
        let along = [[[0.0; 3]; 2]; 3];
        let mut placer = Self { samples: view.samples(), view, field, placement, gradient, along };
        placer.along = std::array::from_fn(|axis| {
            [-1.0, 1.0].map(|rise| {
                let gradient = std::array::from_fn(|k| if k == axis { rise } else { 0.0 });
                // An axis has a direction, since the frame can be inverted.
                placer.outward(gradient).unwrap_or([0.0, 0.0, 1.0])
            })
        });
        placer
    }

    /// The same with the placement and the gradient of `options`.
    pub(crate) fn with_options(self, options: &ExtractOptions) -> Self {
        let ExtractOptions { placement, gradient, .. } = *options;
        Self { placement, gradient, ..self }
    }

    /// Places the vertices of edges. Edges between samples go to the kernel of the placement; those to a guard, and
    /// others that the kernel calls odd, are placed one by one.
    pub(crate) fn place<C: Coordinate>(
        &self,
        edges: &Edges,
        positions: &mut [[C; 3]],
        mut normals: Option<&mut [[f32; 3]]>,
        odd: &mut Vec<u32>,
    ) {
        odd.clear();
        match &self.samples {
            Some(samples) => {
                let normals = normals.as_deref_mut();
                let out = Vertices { positions: &mut *positions, normals, odd: &mut *odd };
                match self.placement {
                    Placement::Linear => vertices(samples, &self.field, edges, out),
                    Placement::Cubic => self.place_curved(samples, Curve::Cubic, edges, out),
                    Placement::Quintic => self.place_curved(samples, Curve::Quintic, edges, out),
                }
            }
            None => odd.extend(0..edges.len() as u32),
        }
        for n in odd.iter().map(|&n| n as usize) {
            let (axis, low) = edges.get(n);
            if let Some((position, normal)) = self.cap(axis, low) {
                positions[n] = position;
                if let Some(normals) = &mut normals {
                    normals[n] = normal;
                }
                continue;
            }
            let cut = self.cut_as_placed::<C>(axis, low);
            positions[n] = self.position(&cut);
            if let Some(normals) = &mut normals {
                normals[n] = self.normal(&cut);
            }
        }
    }

    /// The vertex of an edge to a guard, and its normal, which leads to the guard: what
    /// [`cut`](Self::cut) and [`central_normal`](Self::central_normal) say too, but not so soon. All vertices of
    /// caps are such. (The ends of a window of slices, which are no ends of the volume, make no vertices.)
    fn cap<C: Coordinate>(&self, axis: usize, low: [u32; 3]) -> Option<([C; 3], [f32; 3])> {
        let is_lower = low[axis] == u32::MAX;
        if !is_lower && low[axis] as usize + 1 != self.view.dims()[axis] {
            return None;
        }
        let delta = if is_lower { self.field.reach } else { -self.field.reach };
        let position = self.position_on_edge(axis, self.ijk(low), delta);
        Some((position, self.along[axis][usize::from(is_lower)]))
    }

    /// Says that vertices on the edges of `words`, where bit 0 of word 0 of row 0 is sample `first`, will soon be
    /// placed. Asked for are samples of the farthest slice that they look at: nearer ones were looked at before.
    #[inline(always)]
    pub(crate) fn expect(&self, [x, y, z]: [u32; 3], words: &[Word]) {
        if let Some(samples) = &self.samples {
            let cut = |word: &Word| word.owned().into_iter().fold(0, |all, cuts| all | cuts);
            samples.prefetch([x, y, z.wrapping_add(self.slices_ahead())], words, cut);
        }
    }

    /// How many slices beyond the lower ends of edges the farthest sample is that their vertices may look at.
    #[inline(always)]
    fn slices_ahead(&self) -> u32 {
        let pairs = self.placement.pairs() as u32;
        match self.gradient {
            Gradient::Central => pairs.max(2),
            Gradient::Matching => pairs + 1,
        }
    }

    /// The cut of the edge along `axis` whose lower end is the sample `low`, or the guard before the
    /// first, whose number is one below 0 and wraps.
    fn cut(&self, axis: usize, low: [u32; 3]) -> Cut {
        let place = self.ijk(low);
        // The guard stays beyond every size, and one above it is 0.
        let low = low.map(|i| i as i32 as isize as usize);
        let mut high = low;
        high[axis] = high[axis].wrapping_add(1);
        let size = self.view.dims()[axis];
        let ends = [low, high].map(|ijk| (ijk[axis] < size).then_some(ijk));
        let values = ends.map(|end| end.map(|ijk| self.view.value(ijk)));
        let delta = delta(values, self.field.iso).clamp(-self.field.reach, self.field.reach);
        Cut { axis, low: place, ends, values, delta }
    }

    /// The cut of that edge where the placement has it, for coordinates of a type.
    fn cut_as_placed<C: Coordinate>(&self, axis: usize, low: [u32; 3]) -> Cut {
        let straight = self.cut(axis, low);
        match self.placement {
            Placement::Linear => straight,
            Placement::Cubic | Placement::Quintic => {
                self.curved::<C>(&straight).unwrap_or(straight)
            }
        }
    }

    /// The sample `low` in index space, or the guard whose number wraps.
    fn ijk(&self, low: [u32; 3]) -> [f64; 3] {
        let mut ijk = low.map(|i| f64::from(i as i32));
        ijk[2] += self.field.first_slice;
        ijk
    }

    /// Where the edge along `axis` from `low` is crossed, in edge lengths from there. The ends are numbered
    /// as those of [`Edges`].
    pub(crate) fn crossing<C: Coordinate>(&self, axis: usize, low: [u32; 3]) -> f64 {
        0.5 + self.cut_as_placed::<C>(axis, low).delta
    }

    /// A place in world space, in cell sizes from `low`, which may be a wrapped −1.
    pub(crate) fn position_in_cell<C: Coordinate>(&self, low: [u32; 3], place: [f64; 3]) -> [C; 3] {
        let ijk = self.ijk(low);
        self.field.world(std::array::from_fn(|axis| ijk[axis] + place[axis])).map(C::round)
    }

    /// The position of a cut in world space.
    fn position<C: Coordinate>(&self, cut: &Cut) -> [C; 3] {
        self.position_on_edge(cut.axis, cut.low, cut.delta)
    }

    /// The position so far from the middle of the edge along `axis` from `low` in index space.
    fn position_on_edge<C: Coordinate>(&self, axis: usize, low: [f64; 3], delta: f64) -> [C; 3] {
        let mut ijk = low;
        ijk[axis] = ijk[axis] + 0.5 + delta;
        self.field.world(ijk).map(C::round)
    }

    /// The unit normal at a cut: of the placement's order if that is asked for, and where the samples tell none,
    /// from central differences.
    fn normal(&self, cut: &Cut) -> [f32; 3] {
        let matching = match (self.gradient, self.placement) {
            (Gradient::Central, _) | (_, Placement::Linear) => None,
            (Gradient::Matching, Placement::Cubic) => self.curved_normal::<2>(cut),
            (Gradient::Matching, Placement::Quintic) => self.curved_normal::<3>(cut),
        };
        matching.unwrap_or_else(|| self.central_normal(cut))
    }

    /// The unit normal from central differences: against the gradient, which is interpolated between the ends.
    ///
    /// Where the samples tell no gradient, at a guard or where all differences cancel, the value is still
    /// known to fall along the edge, and that direction stands in.
    fn central_normal(&self, cut: &Cut) -> [f32; 3] {
        self.by_differences(cut).unwrap_or_else(|| {
            let falls = cut.values[0].is_some_and(|low| low >= self.field.iso);
            self.along[cut.axis][usize::from(!falls)]
        })
    }

    /// The normal as the kernel makes it, from differences of samples that are first brought into its
    /// range by a power of two: so a field has the same normals at any scale, to the last bit.
    fn by_differences(&self, cut: &Cut) -> Option<[f32; 3]> {
        let [Some(low), Some(high)] = cut.ends else { return None };
        let share = match cut.values.map(|value| value.is_some_and(f64::is_finite)) {
            [true, false] => 0.0,
            [false, true] => 1.0,
            _ => (0.5 + cut.delta) as f32,
        };
        // Half of the kernel's at most; a power of two is no matter.
        let ends = [low, high].map(|end| differences(&self.view, end));
        let most = ends.as_flattened().iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        let scale = to_unit(most);
        let [low, high] = ends.map(|end| end.map(|part| (part * scale) as f32));
        let mix = |axis: usize| low[axis] * (1.0 - share) + high[axis] * share;
        let (mixed, d) = ([mix(0), mix(1), mix(2)], self.field.directions());
        let along = |k: usize| d[0][k] * mixed[0] + d[1][k] * mixed[1] + d[2][k] * mixed[2];
        let world = [along(0), along(1), along(2)];
        let most = world.iter().fold(0.0_f32, |most, part| most.max(part.abs()));
        if most == 0.0 {
            return None;
        }
        let scale = to_unit(most.into());
        let [x, y, z] = world.map(|part| (f64::from(part) * scale) as f32);
        let outward = -1.0 / (x * x + y * y + z * z).sqrt();
        Some([x * outward, y * outward, z * outward])
    }

    /// The direction in world space against a gradient in index space. None for a gradient of zero.
    pub(crate) fn outward(&self, gradient: [f64; 3]) -> Option<[f32; 3]> {
        let world = self.world_gradient(gradient);
        if TAME.contains(&greatest(world)) {
            return Some(against(world));
        }
        // Divided by its greatest part first, so that no square overflows or vanishes.
        let world = self.world_gradient(gradient.map(|part| part / greatest(gradient)));
        let longest = greatest(world);
        (longest > 0.0).then(|| against(world.map(|part| part / longest)))
    }

    /// The gradient in world space of a gradient in index space.
    fn world_gradient(&self, gradient: [f64; 3]) -> [f64; 3] {
        let columns = &self.field.covectors;
        let along = |k: usize, axis: usize| columns[axis][k] * gradient[axis];
        std::array::from_fn(|k| along(k, 0) + along(k, 1) + along(k, 2))
    }
}

/// The power of two by which a number becomes one from 1 to 2, for any but the greatest and the least.
fn to_unit(number: f64) -> f64 {
    let exponent = (number.to_bits() >> 52 & 0x7FF) as i32 - 1023;
    2.0_f64.powi(-exponent.clamp(-1000, 1000))
}

/// The unit vector against `v`, whose square is neither 0 nor infinite.
fn against(v: [f64; 3]) -> [f32; 3] {
    let outward = -1.0 / (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|part| (part * outward) as f32)
}

/// The crossing between two values, in edge lengths from the middle of the edge, from −½ to ½.
///
/// Next to a guard it is at the sample, next to a value that is not finite at the finite one, between two
/// that are not in the middle.
fn delta(values: [Option<f64>; 2], iso: f64) -> f64 {
    match values {
        [Some(low), Some(high)] if low.is_finite() && high.is_finite() => {
            let (a, b) = (low - iso, high - iso);
            // Only f64 values near the greatest overflow; a quarter of them does not.
            let (a, b) = match (a - b).is_finite() {
                true => (a, b),
                false => (low * 0.25 - iso * 0.25, high * 0.25 - iso * 0.25),
            };
            // Halved last: half of the least value there is would be lost.
            (a + b) / (a - b) * 0.5
        }
        [Some(low), Some(high)] if low.is_finite() || high.is_finite() => {
            if low.is_finite() {
                -0.5
            } else {
                0.5
            }
        }
        [Some(_), Some(_)] => 0.0,
        [None, _] => 0.5,
        [_, None] => -0.5,
    }
}

fn greatest(v: [f64; 3]) -> f64 {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

#[cfg(test)]
mod tests;

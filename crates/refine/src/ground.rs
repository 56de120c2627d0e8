//! The surface in the world: which way it lies from a point, and where the volume ends.
//!
//! Where a surface meets the border of its volume it has a rim, and where the border is closed a cap beyond
//! it. A cap is no isosurface: its vertices lie a little beyond the border samples, and stay. A rim stays in
//! its plane.

use isokit_field::ScalarField;
use isokit_geom::{
    Affine,
    vector::{Vector, dot, normal, sub},
};
use isokit_mesh::{Precision, is_degenerate};

use crate::root::root;

/// Where the surface leaves a border flatter than this, as a cosine, it is too far away along the border.
pub(crate) const FLATTEST: f64 = 0.25;

/// The surface where a field has a value.
#[derive(Clone, Copy)]
pub struct Isosurface<'a> {
    /// The field, which says where it lies in the world.
    pub field: &'a dyn ScalarField,
    /// The value.
    pub iso: f64,
}

/// A point of the volume, and which of its borders it is on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub(crate) ijk: Vector,
    /// Along each axis, −1 on the lower border, 1 on the upper, else 0.
    border: [i8; 3],
    /// Whether it is beyond a border.
    pub(crate) is_beyond: bool,
}

impl Spot {
    /// The axes across whose border it is.
    pub(crate) fn held(&self) -> [bool; 3] {
        self.border.map(|side| side != 0)
    }

    /// The axes across whose border this one and the other are, on the same side.
    pub(crate) fn held_with(&self, other: &Self) -> [bool; 3] {
        let same = |k: usize| self.border[k] != 0 && self.border[k] == other.border[k];
        [same(0), same(1), same(2)]
    }
}

/// A direction in the world, and how fast the value rises that way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ascent {
    pub(crate) direction: Vector,
    /// Per world unit; above 0.
    pub(crate) steepness: f64,
}

/// An isosurface in the frame of its field.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'a> {
    surface: Isosurface<'a>,
    affine: Affine,
    /// What takes a gradient in index space to the world, as columns; its transpose takes displacements back.
    covectors: [Vector; 3],
    /// The index of the last sample along each axis.
    last: Vector,
    /// How far a position may be off because it was rounded, in samples.
    rounding: f64,
    /// What no world vector is shorter than that is a sample long.
    least_stretch: f64,
    /// See [`unit`](Self::unit).
    unit: f64,
    /// What a file multiplies positions by before it rounds them to f32, if it does.
    file_scale: Option<f64>,
}

impl<'a> Ground<'a> {
    /// For a mesh whose positions are kept in `precision`.
    pub(crate) fn new(surface: Isosurface<'a>, precision: Precision) -> Self {
        let affine = surface.field.index_to_world();
        let last = surface.field.dims().map(|n| n.saturating_sub(1) as f64);
        let corner = |k: usize| {
            affine.point(std::array::from_fn(|axis| (k >> axis & 1) as f64 * last[axis]))
        };
        let corners = (0..8).flat_map(corner);
        let reach = corners.fold(0.0_f64, |reach, c| reach.max(c.abs()));
        let step = match precision {
            Precision::F32 => f64::from((reach as f32).next_up()) - f64::from(reach as f32),
            Precision::F64 => reach.next_up() - reach,
        };
        // A vertex beyond the border is there by four steps or more; one on it is off by less than one.
        let least_stretch = affine.least_stretch();
        let rounding = 2.0 * step / least_stretch;
        let covectors = affine.covector_columns();
        let longest = |ijk: Vector| affine.vector(ijk).iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let sides = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(longest);
        let exponent = sides.iter().fold(0.0_f64, |most, side| most.max(*side)).log2().floor();
        let most = match precision {
            Precision::F32 => 120.0, // its inverse is a number in f32 too
            Precision::F64 => 1000.0,
        };
        let unit = exponent.clamp(-most, most).exp2();
        Self { surface, affine, covectors, last, rounding, least_stretch, unit, file_scale: None }
    }

    /// The same for a mesh of f32 that a file will hold scaled: see
    /// [`RefineOptions::file_scale`](crate::RefineOptions::file_scale).
    pub(crate) fn with_file_scale(self, scale: Option<f64>) -> Self {
        Self { file_scale: scale, ..self }
    }

    /// Whether f32 holds the farthest position multiplied by `scale` without a loss of digits.
    pub(crate) fn fits(&self, scale: f64) -> bool {
        // What has this step is between these.
        let [least, most] = [23, 24].map(|n| (self.step() * f64::from(1 << n) * scale) as f32);
        least.is_normal() && most.is_finite()
    }

    /// The step of f32 at the farthest position, which is a cell's length from the origin at least.
    fn step(&self) -> f64 {
        let of_cell = self.unit / f64::from(1 << 23);
        of_cell.max(0.5 * self.rounding * self.least_stretch)
    }

    /// A position as the file will hold it; itself, if that is as it is.
    #[inline]
    pub(crate) fn in_file(&self, place: Vector) -> Vector {
        let Some(scale) = self.file_scale else { return place };
        place.map(|c| f64::from((c * scale) as f32))
    }

    /// No position is farther than this from where the file has it, in [units](Self::unit).
    pub(crate) fn way_in_file(&self) -> f32 {
        // Along each axis by half a step of the file's f32, of which a step here is half at least.
        let most = 2.0 * self.step() / self.unit;
        self.file_scale.map_or(0.0, |_| most as f32)
    }

    /// Whether a triangle is flat, or does not look where `before` does; here, or in the file.
    #[inline]
    pub(crate) fn is_spoiled(&self, corners: [Vector; 3], before: Vector) -> bool {
        let in_file = || is_spoiled(corners.map(|corner| self.in_file(corner)), before);
        is_spoiled(corners, before) || self.file_scale.is_some() && in_file()
    }

    /// Whether, by the field, each of some triangles looks outward at all its corners, and what they come of, `before`, did at
    /// one; and none is flat, here or in the file.
    pub(crate) fn look_outward(
        &self,
        before: Vector,
        mut triangles: impl Iterator<Item = [Vector; 3]>,
    ) -> bool {
        let mut did_before = false;
        let do_now = triangles.all(|corners| {
            let kept = [corners, corners.map(|corner| self.in_file(corner))];
            let ways = kept.map(normal);
            let is_outward = corners.into_iter().all(|corner| {
                let spot = self.spot(corner);
                let ascent = self.ascent(self.field().slope(spot.ijk).gradient, [false; 3]);
                let Some(ascent) = ascent.filter(|_| !spot.is_beyond) else { return false };
                let leads_out = |way: Vector| dot(way, ascent.direction) < 0.0;
                did_before |= leads_out(before);
                ways.into_iter().all(leads_out)
            });
            is_outward && !kept.into_iter().any(is_degenerate)
        });
        do_now && did_before
    }

    /// A power of two that is about as long as a cell.
    pub(crate) fn unit(&self) -> f64 {
        self.unit
    }

    #[inline]
    pub(crate) fn spot(&self, xyz: Vector) -> Spot {
        let from = sub(xyz, self.affine.origin());
        let ijk = self.covectors.map(|row| dot(row, from));
        let is_beyond = |k: usize| ijk[k] < -self.rounding || ijk[k] > self.last[k] + self.rounding;
        let border = std::array::from_fn(|k| match ijk[k] {
            low if low <= self.rounding => -1,
            high if high >= self.last[k] - self.rounding => 1,
            _ => 0,
        });
        Spot { ijk, border, is_beyond: (0..3).any(is_beyond) }
    }

    /// Whether a point is on no side of a border that it is not held to, not even by rounding.
    #[inline]
    pub(crate) fn is_within(&self, xyz: Vector, held: [bool; 3]) -> bool {
        self.beyond(xyz, held) == [false; 3]
    }

    /// Across which borders that it is not held to a point is, be it by rounding.
    #[inline]
    fn beyond(&self, xyz: Vector, held: [bool; 3]) -> [bool; 3] {
        let ijk = self.spot(xyz).ijk;
        std::array::from_fn(|k| !held[k] && !(0.0..=self.last[k]).contains(&ijk[k]))
    }

    /// Whether it is a sample or more from every border.
    pub(crate) fn is_inner(&self, spot: &Spot) -> bool {
        (0..3).all(|k| (1.0..=self.last[k] - 1.0).contains(&spot.ijk[k]))
    }

    /// What no world vector is shorter than that is a sample long.
    pub(crate) fn least_stretch(&self) -> f64 {
        self.least_stretch
    }

    /// Whether a way in the world is no longer than from one sample to the next.
    pub(crate) fn is_short(&self, way: f64) -> bool {
        way.abs() <= self.least_stretch
    }

    /// The field.
    pub(crate) fn field(&self) -> &'a dyn ScalarField {
        self.surface.field
    }

    /// The same, asked through another field that has the same values.
    pub(crate) fn through<'b>(&self, field: &'b dyn ScalarField) -> Ground<'b>
    where
        'a: 'b,
    {
        Ground { surface: Isosurface { field, iso: self.surface.iso }, ..*self }
    }

    /// The value of the surface.
    pub(crate) fn iso(&self) -> f64 {
        self.surface.iso
    }

    /// A displacement in index space.
    pub(crate) fn displacement_ijk(&self, world: Vector) -> Vector {
        self.covectors.map(|row| dot(row, world))
    }

    /// Which way the value rises fastest, among those along the borders that are held. None where it rises
    /// nowhere, or nobody knows.
    pub(crate) fn ascent(&self, gradient: Vector, held: [bool; 3]) -> Option<Ascent> {
        /// Below this part of what it was, what is left of a gradient is rounding.
        const NOISE: f64 = 1e-12;
        let greatest = gradient.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        if !(greatest > 0.0 && gradient.iter().all(|part| part.is_finite())) {
            return None;
        }
        let [x, y, z] = [0, 1, 2].map(|k| self.covectors[k].map(|c| c * (gradient[k] / greatest)));
        let whole: Vector = std::array::from_fn(|k| x[k] + y[k] + z[k]);
        let rest = self.within_borders(whole, held);
        let length = dot(rest, rest).sqrt();
        let is_direction = length > NOISE * dot(whole, whole).sqrt() && length.is_finite();
        let direction = rest.map(|c| c / length);
        is_direction.then_some(Ascent { direction, steepness: length * greatest })
    }

    /// What is left of a vector in the world along the borders that are held.
    pub(crate) fn within_borders(&self, whole: Vector, held: [bool; 3]) -> Vector {
        let (mut rest, mut walls) = (whole, vec![]);
        for axis in (0..3).filter(|&axis| held[axis]) {
            let mut wall = self.covectors[axis];
            walls.iter().for_each(|&other| wall = without(wall, other));
            let length = dot(wall, wall).sqrt();
            let wall = wall.map(|c| c / length);
            rest = without(rest, wall);
            walls.push(wall);
        }
        rest
    }

    /// The point of the surface along its gradient from `start`, not farther than half a cell, and along the borders that are
    /// held.
    pub(crate) fn projected(&self, start: Vector, held: [bool; 3]) -> Option<Vector> {
        let (end, _) = self.foot(start, held, (f64::INFINITY, 0.5))?;
        self.is_within(end, held).then_some(end)
    }

    /// The same, not farther than `reach` in the world and a cell; but where that point is across a border, the point along the
    /// gradient in the plane through `start` that is parallel to the border. Chords across crests as sharp as a cell leave them
    /// by more than half of it.
    pub(crate) fn projected_beside_borders(
        &self,
        start: Vector,
        held: [bool; 3],
        reach: f64,
    ) -> Option<Vector> {
        let (mut end, straight) = self.foot(start, held, (reach, 1.0))?;
        let mut along = held;
        loop {
            let beyond = self.beyond(end, along);
            if beyond == [false; 3] {
                return Some(end);
            }
            along = std::array::from_fn(|k| along[k] || beyond[k]);
            if along == [true; 3] || !self.is_within(start, held) {
                return None;
            }
            let (next, way) = self.foot(start, along, (reach, 1.0))?;
            if dot(straight, way) < FLATTEST {
                return None;
            }
            end = next;
        }
    }

    /// Where the surface is along the gradient, as far as borders are held, be it outside of the volume; and which way it
    /// rises. Not farther than `reach` in the world, and so many cells along any axis.
    fn foot(
        &self,
        start: Vector,
        held: [bool; 3],
        (reach, cells): (f64, f64),
    ) -> Option<(Vector, Vector)> {
        let spot = self.spot(start);
        if spot.is_beyond {
            return None;
        }
        let field = self.surface.field;
        let ascent = self.ascent(field.slope(spot.ijk).gradient, held)?;
        let along = self.displacement_ijk(ascent.direction);
        let most = along.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
        let value = |t: f64| {
            field.value(std::array::from_fn(|k| spot.ijk[k] + t * along[k])) - self.surface.iso
        };
        let t = root(value, ascent.steepness, reach.min(cells / most))?;
        let end = std::array::from_fn(|k| start[k] + t * ascent.direction[k]);
        Some((end, ascent.direction))
    }
}

/// The part of `v` across the unit vector `wall`.
fn without(v: Vector, wall: Vector) -> Vector {
    let along = dot(v, wall);
    std::array::from_fn(|k| v[k] - along * wall[k])
}

/// Whether a triangle is flat, or does not look where `before` does.
pub(crate) fn is_spoiled(corners: [Vector; 3], before: Vector) -> bool {
    // False where a number is NaN.
    let looks_alike = dot(normal(corners), before) > 0.0;
    !looks_alike || is_degenerate(corners)
}

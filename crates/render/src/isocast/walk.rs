//! One ray, cell by cell.

use super::{
    Isosurface, Traced,
    function::{Function, Kept},
};
use crate::{Cap, Gathered, Interpolant, Paint, Ray, gather::OPAQUE, shading::Shading};
use isokit_geom::vector::Vector;
use isokit_lanes::{Side, Threshold};
use isokit_volume::{Sample, Sides};

/// All that rays have in common.
#[derive(Clone, Copy)]
pub(super) struct Walk<'a, T> {
    pub(super) field: Interpolant<'a, T>,
    pub(super) surfaces: &'a [Isosurface<'a>],
    pub(super) thresholds: &'a [Threshold<T>],
    /// On which side of each surface bricks are.
    pub(super) sides: Option<&'a [Sides]>,
    pub(super) caps: &'a [Cap<'a>],
    pub(super) shading: &'a Shading<'a>,
}

/// What is known of a ray on its way.
pub(super) struct Known {
    /// Within which surfaces it is.
    is_inside: Vec<bool>,
    /// What it meets in a cell.
    met: Vec<Met>,
    /// What it meets of caps, from the farthest on.
    caps: Vec<(f64, Gathered)>,
    gathered: Gathered,
    /// Of cells that it, or one beside it, went through.
    kept: Kept,
}

/// A surface that is met.
#[derive(Clone, Copy, Debug)]
struct Met {
    /// How far away.
    far: f64,
    surface: usize,
    /// The axis across which the volume ends there, if it does.
    border: Option<usize>,
}

impl<T: Sample> Walk<'_, T> {
    pub(super) fn begin(&self) -> Known {
        let is_inside = vec![false; self.surfaces.len()];
        let kept = Kept::for_rays_through(self.field.is_cubic());
        Known { is_inside, met: vec![], caps: vec![], gathered: Gathered::NOTHING, kept }
    }

    /// What a ray gathers.
    pub(super) fn along(&self, ray: &Ray, known: &mut Known, traced: &mut Traced) -> Gathered {
        known.gathered = Gathered::NOTHING;
        self.meet_caps(ray, known);
        // Without a surface there is nothing on the way.
        let way = self.field.interval(ray).filter(|_| !self.surfaces.is_empty());
        if let Some([near, far]) = way {
            self.through([near, far], ray, known, traced);
        }
        self.gather_caps(f64::INFINITY, known);
        known.gathered
    }

    /// From where a ray comes into the volume to where it leaves it, or nothing more is seen.
    fn through(&self, [near, far]: [f64; 2], ray: &Ray, known: &mut Known, traced: &mut Traced) {
        let affine = self.field.linear.affine();
        let origin = affine.inverse_point(ray.origin);
        let direction = affine.inverse_vector(ray.direction);
        let at = |t: f64| -> Vector { std::array::from_fn(|k| origin[k] + t * direction[k]) };
        let last = self.field.linear.view().dims().map(|n| n - 2);
        let within = |k: usize, c: f64| (c as usize).min(last[k]); // what is below 0 becomes 0
        let mut cell: [usize; 3] = std::array::from_fn(|k| within(k, at(near)[k]));
        let mut t = near;
        // A camera in the volume is where it is; a ray from beyond comes from outside.
        let value = self.field.at(ray.origin).filter(|_| near == 0.0);
        for (is_inside, surface) in known.is_inside.iter_mut().zip(self.surfaces) {
            *is_inside = value.is_some_and(|value| value >= surface.iso);
        }
        let mut border = (near > 0.0).then(|| self.border(at(near)));
        loop {
            known.met.clear();
            // The box in which nothing changes: a brick, or else a cell.
            let passed = self.passed(cell, (t, border), known);
            let ends: [[usize; 2]; 3] = passed.unwrap_or_else(|| cell.map(|low| [low, low + 1]));
            let leaves = |k: usize| match direction[k] {
                d if d > 0.0 => (ends[k][1] as f64 - origin[k]) / d,
                d if d < 0.0 => (ends[k][0] as f64 - origin[k]) / d,
                _ => f64::INFINITY,
            };
            let all = [leaves(0), leaves(1), leaves(2)];
            let axis = (1..3).fold(0, |least, k| if all[k] < all[least] { k } else { least });
            let next = all[axis].clamp(t, far);
            match passed {
                Some(_) => traced.bricks_passed += 1,
                None => {
                    traced.cells += 1;
                    self.meet(cell, (t, at(t)), (next, at(next)), border, known);
                }
            }
            if !self.gather(ray, known, traced) {
                return;
            }
            border = None;
            t = next;
            // To the next box: across one axis, and on the others to where the ray is, but not back.
            let is_up = direction[axis] > 0.0;
            if all[axis] >= far
                || (is_up && ends[axis][1] > last[axis])
                || (!is_up && ends[axis][0] == 0)
            {
                break;
            }
            let place = at(t);
            for k in 0..3 {
                let low = match (k == axis, direction[k] > 0.0) {
                    (true, true) => ends[k][1],
                    (true, false) => ends[k][0] - 1,
                    (false, true) => within(k, place[k]).max(cell[k]),
                    (false, false) => within(k, place[k]).min(cell[k]),
                };
                // On the other axes it is still in the box.
                cell[k] = if k == axis { low } else { low.clamp(ends[k][0], ends[k][1] - 1) };
            }
        }
        // What is beyond the volume is outside.
        known.met.clear();
        let border = Some(self.border(at(far)));
        let met = (0..self.surfaces.len()).filter(|&surface| known.is_inside[surface]);
        known.met.extend(met.map(|surface| Met { far, surface, border }));
        self.gather(ray, known, traced);
    }

    /// The brick of a cell, if no surface goes through it.
    fn passed(
        &self,
        cell: [usize; 3],
        (far, border): (f64, Option<usize>),
        known: &mut Known,
    ) -> Option<[[usize; 2]; 3]> {
        let sides = self.sides?;
        let grid = sides.first()?.grid;
        let brick: [usize; 3] = std::array::from_fn(|axis| grid.brick_of(axis, cell[axis]));
        let number = grid.number(brick);
        if sides.iter().any(|sides| sides.of_brick[number] == Side::Both) {
            return None;
        }
        for (surface, sides) in sides.iter().enumerate() {
            let is_inside = sides.of_brick[number] == Side::Inside;
            if is_inside != known.is_inside[surface] {
                known.met.push(Met { far, surface, border });
                known.is_inside[surface] = is_inside;
            }
        }
        Some(std::array::from_fn(|axis| {
            let samples = grid.samples(axis, brick[axis]);
            [*samples.start(), *samples.end()]
        }))
    }

    /// Finds what a ray meets in a cell, between two distances and places.
    fn meet(
        &self,
        cell: [usize; 3],
        (near, from): (f64, Vector),
        (far, to): (f64, Vector),
        border: Option<usize>,
        known: &mut Known,
    ) {
        let function = Function::of(&self.field, cell, &mut known.kept);
        let mut line = None;
        for (surface, &threshold) in self.thresholds.iter().enumerate() {
            let iso = self.surfaces[surface].iso;
            let whole = function.is_inside((iso, threshold));
            let is_inside = &mut known.is_inside[surface];
            let met = &mut known.met;
            if border.is_some() || whole.is_some() {
                // The whole cell, or where the ray comes into the volume.
                let begins = whole.unwrap_or_else(|| self.field.at_index(from) >= iso);
                if begins != *is_inside {
                    met.push(Met { far: near, surface, border });
                    *is_inside = begins;
                }
            }
            if whole.is_some() {
                continue;
            }
            let line = line.get_or_insert_with(|| {
                let local = |place: Vector| -> Vector {
                    std::array::from_fn(|k| (place[k] - cell[k] as f64).clamp(0.0, 1.0))
                };
                function.between(&self.field, &mut known.kept, [local(from), local(to)])
            });
            *is_inside = line.crossings(iso, *is_inside, |share| {
                met.push(Met { far: near + share * (far - near), surface, border: None });
            });
        }
    }

    /// Gathers what was met, in order. Whether more can be seen.
    fn gather(&self, ray: &Ray, known: &mut Known, traced: &mut Traced) -> bool {
        known.met.sort_by(|a, b| a.far.total_cmp(&b.far));
        for n in 0..known.met.len() {
            let met = known.met[n];
            self.gather_caps(met.far, known);
            let place = std::array::from_fn(|k| ray.origin[k] + met.far * ray.direction[k]);
            let Isosurface { paint, opacity, clips, .. } = self.surfaces[met.surface];
            if known.gathered.opacity >= OPAQUE {
                return false;
            }
            if !clips.iter().all(|clip| clip.keeps(place)) {
                continue;
            }
            traced.lit += 1;
            let color = || match paint {
                Paint::Plain(color) => color,
                Paint::Solid(color) => color(place),
                Paint::Vertices(_) => [1.0; 3], // there are none
            };
            let normal = || match met.border {
                Some(axis) => self.field.linear.across(axis),
                None => self.field.gradient(self.field.linear.affine().inverse_point(place)),
            };
            let color = self.shading.color(color, normal, place, ray.direction);
            let opacity = self.shading.opacity(opacity);
            known.gathered = known.gathered.over(Gathered::new(color, opacity));
        }
        known.gathered.opacity < OPAQUE
    }

    fn meet_caps(&self, ray: &Ray, known: &mut Known) {
        known.caps.clear();
        known.caps.extend(self.caps.iter().filter_map(|cap| {
            let (far, look) = cap.along(ray)?;
            let place = std::array::from_fn(|k| ray.origin[k] + far * ray.direction[k]);
            Some((far, self.shading.cap(look, cap.half.normal(), place, ray.direction)))
        }));
        known.caps.sort_by(|a, b| b.0.total_cmp(&a.0));
    }

    /// Gathers the caps up to a distance.
    fn gather_caps(&self, far: f64, known: &mut Known) {
        while let Some((_, look)) = known.caps.pop_if(|(cap, _)| *cap <= far) {
            known.gathered = known.gathered.over(look);
        }
    }

    /// The axis across which the volume ends nearest to a place.
    fn border(&self, place: Vector) -> usize {
        let last = self.field.linear.view().dims().map(|n| n as f64 - 1.0);
        let away = |k: usize| place[k].abs().min((last[k] - place[k]).abs());
        (1..3).fold(0, |least, k| if away(k) < away(least) { k } else { least })
    }
}

//! A box around a shape: from the tree, before there is a lattice.

use super::{Array, Combination, Shape, ShapeFault, build};
use isokit_geom::{Aabb, vector};
use std::collections::BTreeMap;

pub(super) const EVERYWHERE: Aabb = Aabb { min: [f64::NEG_INFINITY; 3], max: [f64::INFINITY; 3] };
const NOWHERE: Aabb = Aabb { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };

/// Finds boxes; remembers those of parts.
pub(super) struct Extents<'m> {
    parts: &'m BTreeMap<String, Shape>,
    known: BTreeMap<(&'m str, u64), Aabb>,
    /// Shapes within each other just now, and shapes and copies looked at so far.
    depth: usize,
    looks: usize,
}

impl<'m> Extents<'m> {
    pub(super) fn new(parts: &'m BTreeMap<String, Shape>) -> Self {
        Self { parts, known: BTreeMap::new(), depth: 0, looks: 0 }
    }

    /// A box outside of which no value is `-grow` or more, of a shape that was [built](build). It may go on for ever along
    /// an axis, and is empty where nothing is left.
    ///
    /// Offsets and blends are not added to a box, but asked for in the shapes that they are made of: the corner of an
    /// intersection moves out farther than its faces.
    ///
    /// # Errors
    ///
    /// If shapes are nested too deep, or there are too many: parts are looked at once for each offset that they are in.
    pub(super) fn of(&mut self, shape: &'m Shape, grow: f64) -> Result<Aabb, ShapeFault> {
        self.depth += 1;
        if self.depth > build::MOST_DEEP {
            return Err(ShapeFault::TooDeep);
        }
        self.look(1)?;
        let found = match shape {
            Shape::Sphere { radius } => around_origin([*radius; 3], grow),
            Shape::Box { size, .. } => around_origin(size.map(|c| 0.5 * c), grow),
            Shape::Cylinder { radius, height, .. } => {
                around_origin([*radius, *radius, 0.5 * height], grow)
            }
            Shape::Cone { radius, top, height } => {
                let widest = radius.max(*top);
                around_origin([widest, widest, 0.5 * height], grow)
            }
            Shape::Torus { radius, tube } => {
                around_origin([radius + tube, radius + tube, *tube], grow)
            }
            Shape::Capsule { from, to, radius } => {
                let line = Aabb { min: *from, max: *from }.with(*to);
                grown(line, radius + grow)
            }
            Shape::Plane { normal, at } => half_space(*normal, at + grow),
            Shape::Periodic { .. } | Shape::Formula(_) => EVERYWHERE,
            Shape::Part(name) => self.part(name, grow)?,
            Shape::Combined { how, of, blend } => self.combined(*how, of, *blend, grow)?,
            Shape::Offset { of, by } => self.of(of, grow + by)?,
            Shape::Shell { of, .. } => self.of(of, grow)?,
            Shape::Scaled { of, by } => {
                let own = self.of(of, grow / build::least(*by))?;
                let scaled = |c: [f64; 3]| [0, 1, 2].map(|k| c[k] * by[k]);
                Aabb { min: scaled(own.min), max: scaled(own.max) }
            }
            Shape::Mirrored { of, normal } => {
                let n = vector::unit(*normal).unwrap_or([0.0; 3]);
                mapped(self.of(of, grow)?, build::reflection(n), [0.0; 3])
            }
            Shape::Rotated { of, degrees } => {
                mapped(self.of(of, grow)?, build::rotation(*degrees), [0.0; 3])
            }
            Shape::Moved { of, by } => mapped(self.of(of, grow)?, build::IDENTITY, *by),
            Shape::Repeated { of, array } => self.repeated(of, array, grow)?,
        };
        self.depth -= 1;
        Ok(found)
    }

    fn look(&mut self, more: usize) -> Result<(), ShapeFault> {
        self.looks = self.looks.saturating_add(more);
        if self.looks > build::MOST_LOOKS { Err(ShapeFault::TooLarge) } else { Ok(()) }
    }

    fn part(&mut self, name: &'m str, grow: f64) -> Result<Aabb, ShapeFault> {
        let key = (name, grow.to_bits());
        if let Some(&known) = self.known.get(&key) {
            return Ok(known);
        }
        let Some(shape) = self.parts.get(name) else { return Ok(EVERYWHERE) };
        let found = self.of(shape, grow)?;
        self.known.insert(key, found);
        Ok(found)
    }

    fn combined(
        &mut self,
        how: Combination,
        of: &'m [Shape],
        blend: f64,
        grow: f64,
    ) -> Result<Aabb, ShapeFault> {
        match how {
            Combination::Union => {
                let grow = grow + 0.25 * blend * (of.len() as f64 - 1.0);
                of.iter().try_fold(NOWHERE, |all, shape| Ok(both(all, self.of(shape, grow)?)))
            }
            Combination::Intersection => {
                of.iter().try_fold(EVERYWHERE, |all, shape| Ok(common(all, self.of(shape, grow)?)))
            }
            Combination::Difference => of.first().map_or(Ok(NOWHERE), |shape| self.of(shape, grow)),
        }
    }

    fn repeated(&mut self, of: &'m Shape, array: &Array, grow: f64) -> Result<Aabb, ShapeFault> {
        let own = self.of(of, grow)?;
        let copies = array.copies();
        self.look(copies.len())?;
        Ok(copies.iter().fold(NOWHERE, |all, (rows, by)| both(all, mapped(own, *rows, *by))))
    }
}

fn is_empty(own: Aabb) -> bool {
    (0..3).any(|axis| own.min[axis] > own.max[axis])
}

fn grown(own: Aabb, by: f64) -> Aabb {
    let grown = Aabb { min: own.min.map(|c| c - by), max: own.max.map(|c| c + by) };
    if is_empty(grown) { NOWHERE } else { grown }
}

fn around_origin(half: [f64; 3], grow: f64) -> Aabb {
    grown(Aabb { min: half.map(|c| -c), max: half }, grow)
}

fn both(a: Aabb, b: Aabb) -> Aabb {
    match (is_empty(a), is_empty(b)) {
        (true, _) => b,
        (_, true) => a,
        _ => a.with(b.min).with(b.max),
    }
}

fn common(a: Aabb, b: Aabb) -> Aabb {
    let found = Aabb {
        min: [0, 1, 2].map(|k| a.min[k].max(b.min[k])),
        max: [0, 1, 2].map(|k| a.max[k].min(b.max[k])),
    };
    if is_empty(found) { NOWHERE } else { found }
}

/// Where n · p is at most `at`: bounded if the plane is across an axis.
fn half_space(normal: [f64; 3], at: f64) -> Aabb {
    let n = vector::unit(normal).unwrap_or([0.0; 3]);
    let mut found = EVERYWHERE;
    for (axis, along) in n.into_iter().enumerate() {
        match along {
            1.0 => found.max[axis] = at,
            -1.0 => found.min[axis] = -at,
            _ => {}
        }
    }
    found
}

/// The box around the image of a box.
fn mapped(own: Aabb, rows: [[f64; 3]; 3], by: [f64; 3]) -> Aabb {
    if is_empty(own) {
        return NOWHERE;
    }
    let mut found = Aabb { min: by, max: by };
    for (axis, row) in rows.iter().enumerate() {
        // What is infinite stays so, and does not spread along axes that it has nothing to do with.
        for (k, &factor) in row.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            let (a, b) = (factor * own.min[k], factor * own.max[k]);
            found.min[axis] += a.min(b);
            found.max[axis] += a.max(b);
        }
    }
    found
}

//! A shape as files write it.
//!
//! One key of a table says what it is; others, what is done with it, always in the order of [`Table`], whatever order they
//! stand in. Who wants another order writes a union of one around it.

use super::{Array, Combination, PeriodicSurface, Shape};
use crate::Formula;
use serde::{
    Deserialize, Deserializer,
    de::{self, MapAccess, Visitor, value::MapAccessDeserializer},
};
use std::fmt;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Table {
    // One of these.
    sphere: Option<Sphere>,
    r#box: Option<Cuboid>,
    cylinder: Option<Cylinder>,
    cone: Option<Cone>,
    torus: Option<Torus>,
    capsule: Option<Capsule>,
    plane: Option<Plane>,
    gyroid: Option<Periodic>,
    schwarz_p: Option<Periodic>,
    schwarz_d: Option<Periodic>,
    neovius: Option<Periodic>,
    iwp: Option<Periodic>,
    formula: Option<Formula>,
    part: Option<String>,
    union: Option<Vec<Operand>>,
    intersection: Option<Vec<Operand>>,
    difference: Option<Vec<Operand>>,
    // With the last three.
    blend: Option<f64>,
    // Any of these, in this order.
    offset: Option<f64>,
    shell: Option<f64>,
    scale: Option<Factors>,
    mirror: Option<Direction>,
    rotate: Option<Turns>,
    r#move: Option<[f64; 3]>,
    array: Option<ArrayTable>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Sphere {
    radius: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cuboid {
    size: [f64; 3],
    #[serde(default)]
    round: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cylinder {
    radius: f64,
    height: f64,
    #[serde(default)]
    round: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cone {
    radius: f64,
    #[serde(default)]
    top: f64,
    height: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Torus {
    radius: f64,
    tube: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Capsule {
    from: [f64; 3],
    to: [f64; 3],
    radius: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Plane {
    normal: Direction,
    #[serde(default)]
    at: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Periodic {
    cell: f64,
    thickness: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "expected a factor, or three for x, y, z")]
enum Factors {
    One(f64),
    Each([f64; 3]),
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "expected \"x\", \"y\", \"z\" or three numbers")]
enum Direction {
    Along(AxisWord),
    Vector([f64; 3]),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum AxisWord {
    X,
    Y,
    Z,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct Turns {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ArrayTable {
    count: Counts,
    step: Option<[f64; 3]>,
    #[serde(default)]
    center: bool,
    about: Option<AxisWord>,
    turn: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged, expecting = "expected a whole number, or three for x, y, z")]
enum Counts {
    One(u32),
    Each([u32; 3]),
}

/// A shape within another one: a table, or the name of a part.
#[derive(Debug)]
struct Operand(Shape);

impl<'de> Deserialize<'de> for Operand {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Operand;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a shape in { }, or the name of a part")
            }

            fn visit_str<E: de::Error>(self, name: &str) -> Result<Operand, E> {
                Ok(Operand(Shape::Part(name.to_owned())))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Operand, A::Error> {
                Shape::deserialize(MapAccessDeserializer::new(map)).map(Operand)
            }
        }
        deserializer.deserialize_any(Either)
    }
}

impl TryFrom<Table> for Shape {
    type Error = String;

    fn try_from(table: Table) -> Result<Self, String> {
        let blend = table.blend;
        let combined = |how: Combination| {
            move |of: Vec<Operand>| {
                let of = of.into_iter().map(|operand| operand.0).collect();
                Shape::Combined { how, of, blend: blend.unwrap_or(0.0) }
            }
        };
        let periodic = |surface: PeriodicSurface| {
            move |Periodic { cell, thickness }| Shape::Periodic { surface, cell, thickness }
        };
        let is_combined =
            table.union.is_some() || table.intersection.is_some() || table.difference.is_some();
        let kinds = [
            ("sphere", table.sphere.map(|Sphere { radius }| Shape::Sphere { radius })),
            ("box", table.r#box.map(|Cuboid { size, round }| Shape::Box { size, round })),
            ("cylinder", table.cylinder.map(Into::into)),
            ("cone", table.cone.map(Into::into)),
            ("torus", table.torus.map(|Torus { radius, tube }| Shape::Torus { radius, tube })),
            ("capsule", table.capsule.map(Into::into)),
            ("plane", table.plane.map(Into::into)),
            ("gyroid", table.gyroid.map(periodic(PeriodicSurface::Gyroid))),
            ("schwarz_p", table.schwarz_p.map(periodic(PeriodicSurface::SchwarzP))),
            ("schwarz_d", table.schwarz_d.map(periodic(PeriodicSurface::SchwarzD))),
            ("neovius", table.neovius.map(periodic(PeriodicSurface::Neovius))),
            ("iwp", table.iwp.map(periodic(PeriodicSurface::Iwp))),
            ("formula", table.formula.map(Shape::Formula)),
            ("part", table.part.map(Shape::Part)),
            ("union", table.union.map(combined(Combination::Union))),
            ("intersection", table.intersection.map(combined(Combination::Intersection))),
            ("difference", table.difference.map(combined(Combination::Difference))),
        ];
        let names = kinds.each_ref().map(|(name, _)| *name).join(", ");
        let mut given = kinds.into_iter().filter_map(|(name, shape)| Some((name, shape?)));
        let (name, mut shape) =
            given.next().ok_or_else(|| format!("this is no shape yet: expected one of {names}"))?;
        if let Some((other, _)) = given.next() {
            return Err(format!("{name} and {other} are two shapes: put them into a union"));
        }
        if blend.is_some() && !is_combined {
            return Err("blend is for union, intersection and difference".into());
        }
        if let Some(by) = table.offset {
            shape = Shape::Offset { of: shape.into(), by };
        }
        if let Some(thickness) = table.shell {
            shape = Shape::Shell { of: shape.into(), thickness };
        }
        if let Some(factors) = table.scale {
            let by = match factors {
                Factors::One(factor) => [factor; 3],
                Factors::Each(factors) => factors,
            };
            shape = Shape::Scaled { of: shape.into(), by };
        }
        if let Some(normal) = table.mirror {
            shape = Shape::Mirrored { of: shape.into(), normal: normal.vector() };
        }
        if let Some(Turns { x, y, z }) = table.rotate {
            shape = shape.rotated([x, y, z]);
        }
        if let Some(by) = table.r#move {
            shape = shape.moved(by);
        }
        match table.array {
            Some(array) => Ok(shape.repeated(array.try_into()?)),
            None => Ok(shape),
        }
    }
}

impl From<Cylinder> for Shape {
    fn from(Cylinder { radius, height, round }: Cylinder) -> Self {
        Self::Cylinder { radius, height, round }
    }
}

impl From<Cone> for Shape {
    fn from(Cone { radius, top, height }: Cone) -> Self {
        Self::Cone { radius, top, height }
    }
}

impl From<Capsule> for Shape {
    fn from(Capsule { from, to, radius }: Capsule) -> Self {
        Self::Capsule { from, to, radius }
    }
}

impl From<Plane> for Shape {
    fn from(Plane { normal, at }: Plane) -> Self {
        Self::Plane { normal: normal.vector(), at }
    }
}

impl Direction {
    fn vector(self) -> [f64; 3] {
        match self {
            Self::Along(AxisWord::X) => [1.0, 0.0, 0.0],
            Self::Along(AxisWord::Y) => [0.0, 1.0, 0.0],
            Self::Along(AxisWord::Z) => [0.0, 0.0, 1.0],
            Self::Vector(vector) => vector,
        }
    }
}

impl TryFrom<ArrayTable> for Array {
    type Error = String;

    fn try_from(table: ArrayTable) -> Result<Self, String> {
        let ArrayTable { count, step, center, about, turn } = table;
        match (count, step, about) {
            (Counts::One(count), None, Some(axis)) if !center => {
                let turn = turn.unwrap_or(360.0 / f64::from(count.max(1)));
                Ok(Self::Polar { count, axis: axis as u8, turn })
            }
            (_, None, Some(_)) => Err("an array about an axis has one count, and no center".into()),
            (_, Some(_), Some(_)) => Err("an array has step or about, not both".into()),
            (_, _, None) if turn.is_some() => Err("turn is for an array about an axis".into()),
            (Counts::One(count), Some(step), None) => Ok(Self::Linear { count, step, center }),
            (Counts::Each(count), Some(step), None) => Ok(Self::Grid { count, step, center }),
            (_, None, None) => Err("an array needs step = [x, y, z], or about = \"z\"".into()),
        }
    }
}

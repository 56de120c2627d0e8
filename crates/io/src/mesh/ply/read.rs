//! Reads PLY: vertices and faces are kept, all other elements and properties passed over.

use super::{
    COLORS, VALUE,
    header::{Element, Header, Number, Property},
    values::Values,
};
use crate::{
    Place, ReadFault,
    mesh::input::{MeshFile, MeshInput, NO_UNIT, beyond as beyond_note, fan, is_beyond},
};
use isokit_geom::Unit;
use isokit_mesh::{Attributes, Positions, Rgba, Surface, TriMesh};

/// Reads the one surface of a file.
pub(in crate::mesh) fn read(file: MeshFile<'_>) -> Result<MeshInput, ReadFault> {
    let header = Header::read(file)?;
    let mut values = Values::new(file, &header);
    let (mut vertices, mut faces) = (None, Faces::default());
    for element in header.elements.iter().filter(|element| !element.properties.is_empty()) {
        values.expect(element)?;
        match element.name.as_str() {
            "vertex" if vertices.is_none() => {
                vertices = Some(Vertices::read(file, &mut values, element)?);
            }
            "face" => faces.read(file, &mut values, element)?,
            "tristrips" if element.count > 0 => {
                return Err(file.unsupported(element.place, "triangle strips"));
            }
            _ => skip(file, &mut values, element)?,
        }
    }
    let end = Place::Line(header.lines);
    let nothing = || file.broken(end, "an element named vertex", "none");
    let Vertices { positions, normals, attributes, beyond } = vertices.ok_or_else(nothing)?;
    faces.check(file, positions.len())?;
    let facts = header.facts;
    let unnamed = || if facts.is_ours { String::new() } else { file.stem() };
    let surface = Surface {
        name: facts.name.clone().unwrap_or_else(unnamed),
        color: facts.color,
        iso: facts.iso,
        mesh: TriMesh { positions, normals, triangles: faces.triangles, attributes },
    };
    let no_unit = (facts.unit == Unit::Unknown).then(|| NO_UNIT.to_owned());
    let notes = beyond_note(beyond).into_iter().chain(no_unit).collect();
    let (format, unit, space) = (file.format, facts.unit, facts.space);
    Ok(MeshInput { surfaces: vec![surface], format, unit, space, notes })
}

struct Vertices {
    positions: Positions,
    normals: Option<Vec<[f32; 3]>>,
    attributes: Attributes,
    /// How many have a colour with a part that is not from 0 to 1.
    beyond: usize,
}

impl Vertices {
    fn read(
        file: MeshFile<'_>,
        values: &mut Values<'_>,
        element: &Element,
    ) -> Result<Self, ReadFault> {
        const NAMES: [&str; 11] = {
            let ([r, g, b, a], value) = (COLORS, VALUE);
            ["x", "y", "z", "nx", "ny", "nz", r, g, b, a, value]
        };
        // Which coordinate each property is, if any.
        let slot = |property: &Property| {
            let is_list = property.length.is_some();
            NAMES.iter().position(|name| !is_list && *name == property.name)
        };
        let slots: Vec<_> = element.properties.iter().map(slot).collect();
        let has = |slot| slots.contains(&Some(slot));
        if let Some(missing) = (0..3).find(|&slot| !has(slot)) {
            let found = format!("no {}", NAMES[missing]);
            return Err(file.broken(element.place, "vertices with x, y and z", found));
        }
        let has_normals = (3..6).all(has);
        let (has_colors, has_values) = ((6..9).all(has), has(10));
        let is_double = element.properties.iter().zip(&slots).any(|(property, slot)| {
            property.number == Number::F64 && slot.is_some_and(|slot| slot < 3)
        });
        let limits = &file.job.limits;
        let count = Some(element.count);
        let (mut narrow, mut wide) = (vec![], vec![]);
        match is_double {
            true => wide = limits.vec("vertices", count)?,
            false => narrow = limits.vec("vertices", count)?,
        }
        let mut normals = limits.vec("normals", count.filter(|_| has_normals).or(Some(0)))?;
        let mut colors = limits.vec("colours", count.filter(|_| has_colors).or(Some(0)))?;
        let mut numbers = limits.vec("values", count.filter(|_| has_values).or(Some(0)))?;
        let mut beyond = 0;
        for number in 0..element.count as usize {
            file.pace(number)?;
            let mut vertex = [0.0; 11];
            vertex[9] = 1.0; // opaque, if nobody says
            for (property, slot) in element.properties.iter().zip(&slots) {
                match slot {
                    Some(slot @ 6..10) => {
                        vertex[*slot] = part(values.next(property.number)?, property.number);
                    }
                    Some(slot) => vertex[*slot] = values.next(property.number)?,
                    None => skip_one(values, property)?,
                }
            }
            let [x, y, z, nx, ny, nz, r, g, b, a, value] = vertex;
            if has_colors {
                let parts = [r, g, b, a];
                beyond += usize::from(parts.into_iter().any(is_beyond));
                // What is beyond a byte becomes the nearest, and no number 0.
                colors.push(Rgba(parts.map(|part| (part * 255.0).round() as u8)));
            }
            if has_values {
                numbers.push(value as f32);
            }
            match is_double {
                true => wide.push([x, y, z]),
                false => narrow.push([x, y, z].map(|c| c as f32)),
            }
            if has_normals {
                normals.push([nx, ny, nz].map(|c| c as f32));
            }
        }
        let positions = if is_double { Positions::F64(wide) } else { Positions::F32(narrow) };
        let attributes = Attributes {
            values: has_values.then_some(numbers),
            colors: has_colors.then_some(colors),
        };
        Ok(Self { positions, normals: has_normals.then_some(normals), attributes, beyond })
    }
}

/// A part of a colour, from 0 to 1: whole numbers are a part of the range of as many bytes.
fn part(number: f64, kind: Number) -> f64 {
    let whole = match kind {
        Number::I8 | Number::U8 => 255.0,
        Number::I16 | Number::U16 => f64::from(u16::MAX),
        Number::I32 | Number::U32 => f64::from(u32::MAX),
        Number::F32 | Number::F64 => 1.0,
    };
    number / whole
}

#[derive(Default)]
struct Faces {
    triangles: Vec<[u32; 3]>,
    /// The greatest index, and the face that names it.
    greatest: Option<(u64, u64)>,
}

impl Faces {
    fn read(
        &mut self,
        file: MeshFile<'_>,
        values: &mut Values<'_>,
        element: &Element,
    ) -> Result<(), ReadFault> {
        let is_corners = |property: &Property| {
            property.length.is_some()
                && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
        };
        let Some(corners) = element.properties.iter().position(is_corners) else {
            return match element.count {
                0 => Ok(()),
                _ => Err(file.broken(element.place, "a list named vertex_indices", "none")),
            };
        };
        self.triangles = file.job.limits.vec("triangles", Some(element.count))?;
        let mut polygon = vec![];
        for number in 0..element.count {
            file.pace(number as usize)?;
            for (k, property) in element.properties.iter().enumerate() {
                match property.length {
                    Some(length) if k == corners => {
                        self.corners(values, [length, property.number], number, &mut polygon)?;
                    }
                    _ => skip_one(values, property)?,
                }
            }
            file.job.limits.allow("triangles", Some(self.triangles.len() as u64), 12)?;
            self.triangles.extend(fan(&polygon));
        }
        Ok(())
    }

    fn corners(
        &mut self,
        values: &mut Values<'_>,
        [length, index]: [Number; 2],
        face: u64,
        polygon: &mut Vec<u32>,
    ) -> Result<(), ReadFault> {
        let count = values.next_index(length)?;
        if count < 3 {
            return Err(values.broken("a face of at least 3 corners", count.to_string()));
        }
        if count > values.left() as u64 {
            return Err(values.broken("so many corners", count.to_string()));
        }
        polygon.clear();
        for _ in 0..count {
            let corner = values.next_index(index)?;
            self.greatest = self.greatest.max(Some((corner, face)));
            // One that is too great is refused by `check`.
            polygon.push(u32::try_from(corner).unwrap_or(u32::MAX));
        }
        Ok(())
    }

    /// Goes on if every index names a vertex.
    fn check(&self, file: MeshFile<'_>, vertices: usize) -> Result<(), ReadFault> {
        match self.greatest {
            Some((index, face)) if index >= vertices as u64 => {
                let expected = format!("vertices below {vertices}");
                Err(file.broken(Place::Item("face", face), expected, index.to_string()))
            }
            _ => Ok(()),
        }
    }
}

fn skip(file: MeshFile<'_>, values: &mut Values<'_>, element: &Element) -> Result<(), ReadFault> {
    for number in 0..element.count {
        file.pace(number as usize)?;
        element.properties.iter().try_for_each(|property| skip_one(values, property))?;
    }
    Ok(())
}

fn skip_one(values: &mut Values<'_>, property: &Property) -> Result<(), ReadFault> {
    let count = property.length.map_or(Ok(1), |length| values.next_index(length))?;
    // Every number takes bytes, so this ends with the file.
    (0..count).try_for_each(|_| values.next(property.number).map(drop))
}

//! Reads OBJ: positions, normals, polygons, objects and the names of materials. Texture coordinates,
//! groups, lines, points and curves are passed over.
//!
//! The crate `tobj` is our oracle in tests and not our reader: it knows no lines to name in an error,
//! panics on some broken files, and gives every group and every change of material vertices of its own,
//! which tears the surface.

use super::{
    material::{self, Material},
    object::{Corner, Object},
    write::IS_F64,
};
use crate::{
    Place, ReadFault,
    mesh::{
        NEUTRAL,
        axes::z_up,
        facts::Facts,
        input::{MeshFile, MeshInput, NO_UNIT, beyond, fan, is_beyond, load, textured},
    },
    text::shown,
};
use isokit_geom::Unit;
use isokit_mesh::{Rgba, Surface};
use std::{borrow::Cow, collections::HashMap};

/// Reads all objects of a file; where it names none, all is one.
pub(in crate::mesh) fn read(file: MeshFile<'_>) -> Result<MeshInput, ReadFault> {
    let text = String::from_utf8_lossy(file.bytes);
    let mut content = Content { objects: vec![Object::default()], ..Content::default() };
    for (number, statement) in statements(&text).enumerate() {
        file.pace(number)?;
        content.take(file, statement)?;
    }
    content.check(file)?;
    let mut notes: Vec<_> = beyond(content.beyond).into_iter().collect();
    let Content { positions, colors: painted, normals, objects, facts, libraries, .. } = content;
    let library = materials(file, &libraries, &mut notes);
    let counts = [positions.len(), normals.len()];
    // What stands before the first `o` is an object only if it has faces.
    let is_one = objects.len() == 1 && !positions.is_empty();
    let is_object = |object: &&Object| is_one || object.name.is_some() || !object.faces.is_empty();
    let ends = objects.iter().skip(1).map(|next| next.first_vertex).chain([counts[0]]);
    let ends: Vec<_> = ends.collect();
    let (mut surfaces, mut with_texture) = (vec![], vec![]);
    for (object, end) in objects.iter().zip(ends).filter(|(object, _)| is_object(object)) {
        let own = object.first_vertex..end;
        let material = object.material.as_ref().and_then(|name| library.get(name));
        let Material { color, has_texture } = material.copied().unwrap_or_default();
        let is_plain = facts.is_ours && object.color.is_none() && color == Some(NEUTRAL);
        let color = color.filter(|_| !is_plain).or(object.color);
        let (vertices, plain) = ((&positions[..], &painted[..]), color.unwrap_or(NEUTRAL));
        let (mesh, has_split) =
            object.mesh(own, vertices, &normals, facts.is_ours, plain, file.job)?;
        let name = object.name.clone().unwrap_or_else(|| file.stem());
        if has_split {
            notes.push(format!("{name}: normals differ within a vertex; left out"));
        }
        if has_texture && mesh.attributes.colors.is_none() {
            with_texture.push(name.clone());
        }
        surfaces.push(Surface { name, color, iso: object.iso, mesh });
    }
    notes.extend(textured(&with_texture));
    if !facts.is_ours {
        notes.push("OBJ does not say which axis is up; y is taken to be".to_owned());
    }
    if facts.unit == Unit::Unknown {
        notes.push(NO_UNIT.to_owned());
    }
    let (format, unit, space) = (file.format, facts.unit, facts.space);
    Ok(MeshInput { surfaces, format, unit, space, notes })
}

/// The materials of all libraries that are there.
fn materials(
    file: MeshFile<'_>,
    libraries: &[String],
    notes: &mut Vec<String>,
) -> HashMap<String, Material> {
    let mut materials = HashMap::new();
    for library in libraries {
        let found = file.sibling(library).and_then(|path| load(&path, file.job).ok());
        let Some(bytes) = found else {
            notes.push(format!("materials {library:?} are not there; read without colours"));
            continue;
        };
        let text = String::from_utf8_lossy(&bytes);
        let named = material::materials(&text).into_iter();
        materials.extend(named.map(|(name, material)| (name.to_owned(), material)));
    }
    materials
}

/// A line with its number; one that ends with `\` goes on in the next, if it is no remark.
type Statement<'a> = (u64, Cow<'a, str>);

fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = (1..).zip(text.lines());
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let mut statement = Cow::Borrowed(line);
        while let Some(part) = statement.strip_suffix('\\').filter(|part| !is_remark(part)) {
            let next = lines.next().map_or("", |(_, line)| line);
            statement = Cow::Owned(format!("{part} {next}"));
        }
        Some((number, statement))
    })
}

fn is_remark(line: &str) -> bool {
    line.trim_start().starts_with('#')
}

/// What was read so far.
#[derive(Default)]
struct Content {
    /// In z up; f64 until it is clear whether that is needed.
    positions: Vec<[f64; 3]>,
    /// As many as vertices up to the last that has one.
    colors: Vec<Option<Rgba>>,
    /// How many of them have a part that is not from 0 to 1.
    beyond: usize,
    normals: Vec<[f32; 3]>,
    objects: Vec<Object>,
    facts: Facts,
    libraries: Vec<String>,
    /// The greatest index of a position and of a normal, and the line that names it.
    greatest: [Option<(u32, u64)>; 2],
    /// Whether anything was said at all.
    has_any: bool,
}

impl Content {
    fn take(&mut self, file: MeshFile<'_>, (line, text): Statement<'_>) -> Result<(), ReadFault> {
        let text = text.trim();
        let broken = |expected| file.broken(Place::Line(line), expected, shown(text));
        if let Some(remark) = text.strip_prefix('#') {
            self.remark(remark.trim());
            return Ok(());
        }
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        let rest = rest.trim();
        match keyword {
            "v" => {
                let is_f32 = self.facts.is_ours && !self.object().is_f64;
                let xyz = numbers(rest, |word| match is_f32 {
                    // Not by way of f64, which would round twice.
                    true => word.parse::<f32>().ok().map(f64::from),
                    false => word.parse().ok(),
                });
                self.positions.push(z_up(xyz.ok_or_else(|| broken("three coordinates"))?));
                if let Some(parts) = color(rest) {
                    let [r, g, b] = parts.map(|part| (part * 255.0).round() as u8);
                    self.colors.resize(self.positions.len() - 1, None);
                    self.colors.push(Some(Rgba([r, g, b, u8::MAX])));
                    self.beyond += usize::from(parts.into_iter().any(is_beyond));
                }
            }
            "vn" => {
                let xyz = numbers(rest, |word| word.parse::<f32>().ok());
                self.normals.push(z_up(xyz.ok_or_else(|| broken("three coordinates"))?));
            }
            "f" => self.face(file, line, rest)?,
            "o" => self.begin(rest),
            "usemtl" => {
                let object = self.object();
                object.material.get_or_insert_with(|| rest.to_owned());
            }
            "mtllib" => self.libraries.push(rest.to_owned()),
            _ => return Ok(()),
        }
        self.has_any = true;
        Ok(())
    }

    fn object(&mut self) -> &mut Object {
        self.objects.last_mut().expect("there is one from the start, and none is taken away")
    }

    fn remark(&mut self, text: &str) {
        self.facts.take_line(text);
        if text == IS_F64 {
            self.object().is_f64 = true;
        }
    }

    /// Begins an object. What remarks said just before is of this one.
    fn begin(&mut self, name: &str) {
        let said = self.facts.name.take();
        let unnamed = || if self.facts.is_ours { String::new() } else { name.to_owned() };
        self.objects.push(Object {
            name: Some(said.unwrap_or_else(unnamed)),
            iso: self.facts.iso.take(),
            color: self.facts.color.take(),
            first_vertex: self.positions.len(),
            ..Object::default()
        });
    }

    fn face(&mut self, file: MeshFile<'_>, line: u64, text: &str) -> Result<(), ReadFault> {
        let broken = |expected| file.broken(Place::Line(line), expected, shown(text));
        let corner = |word| {
            let corner = self.corner(word);
            corner.ok_or_else(|| broken("corners as v, v/vt, v//vn or v/vt/vn"))
        };
        let polygon = text.split_whitespace().map(corner).collect::<Result<Vec<_>, _>>()?;
        if polygon.len() < 3 {
            return Err(broken("a face of at least 3 corners"));
        }
        for corner in &polygon {
            for (greatest, index) in self.greatest.iter_mut().zip([corner.vertex, corner.normal]) {
                let is_greater = greatest.is_none_or(|(most, _)| index > most);
                if index != Corner::NONE && is_greater {
                    *greatest = Some((index, line));
                }
            }
        }
        let faces = &mut self.object().faces;
        let bytes = size_of::<[Corner; 3]>();
        file.job.limits.allow("triangles", Some((faces.len() + polygon.len()) as u64), bytes)?;
        faces.extend(fan(&polygon));
        Ok(())
    }

    /// A corner; indices count from 1, or backwards from −1 for what came last.
    fn corner(&self, word: &str) -> Option<Corner> {
        let index = |word: &str, count: usize| -> Option<u32> {
            let number: i64 = word.parse().ok()?;
            let index = match number {
                1.. => number - 1,
                0 => return None,
                _ => (count as i64).checked_add(number)?,
            };
            u32::try_from(index).ok().filter(|&index| index != Corner::NONE)
        };
        let mut words = word.split('/');
        let vertex = index(words.next()?, self.positions.len())?;
        let _texture = words.next();
        let normal = match words.next() {
            None | Some("") => Corner::NONE,
            Some(word) => index(word, self.normals.len())?,
        };
        words.next().is_none().then_some(Corner { vertex, normal })
    }

    /// Goes on if every index names something, and if this is an OBJ at all.
    fn check(&self, file: MeshFile<'_>) -> Result<(), ReadFault> {
        if !self.has_any && !self.facts.is_ours {
            let place = Place::Byte(file.bytes.len() as u64);
            return Err(file.broken(place, "a vertex, a face or an object", "none"));
        }
        let counts = [("vertices", self.positions.len()), ("normals", self.normals.len())];
        for ((what, count), greatest) in counts.into_iter().zip(self.greatest) {
            if let Some((index, line)) = greatest.filter(|&(index, _)| index as usize >= count) {
                let expected = format!("{what} 1 to {count}");
                let found = (u64::from(index) + 1).to_string();
                return Err(file.broken(Place::Line(line), expected, found));
            }
        }
        Ok(())
    }
}

/// The colour behind the coordinates of a vertex: three numbers from 0 to 1.
fn color(text: &str) -> Option<[f64; 3]> {
    let mut words = text.split_whitespace().skip(3);
    let mut part = || words.next()?.parse::<f64>().ok().filter(|part| part.is_finite());
    let parts = [part()?, part()?, part()?];
    // Seven numbers are a weight and a colour, and nobody writes them.
    words.next().is_none().then_some(parts)
}

/// The first three numbers; a weight or a colour may follow.
fn numbers<T>(text: &str, parse: impl Fn(&str) -> Option<T>) -> Option<[T; 3]> {
    let mut words = text.split_whitespace();
    let mut number = || parse(words.next()?);
    Some([number()?, number()?, number()?])
}

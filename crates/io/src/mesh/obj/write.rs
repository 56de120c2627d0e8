//! Writes OBJ.

use super::material;
use crate::{
    Output, WriteError, WriteFault,
    mesh::{
        MeshContext, Written,
        axes::{Y_UP, y_up},
        facts, name,
        outline::Outline,
        stream::Stream,
    },
};
use isokit_job::Job;
use isokit_mesh::{Positions, Precision, Rgba, Surface};
use std::{
    fmt::Display,
    io::Write,
    path::{Path, PathBuf},
};

/// The remark that positions are f64; without it they are f32.
pub(super) const IS_F64: &str = "PRECISION=f64";

/// Writes all surfaces at `path` and their materials beside it. The materials get their name first.
pub(in crate::mesh) fn write_with_materials(
    path: &Path,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteError> {
    let library = Library::beside(path, &outlines(surfaces));
    let mut object = Output::create(path)?;
    put_all(&mut object, surfaces, context, Some(&library), job).map_err(|fault| fault.at(path))?;
    library.finish(object, written)
}

/// Writes all surfaces without materials.
pub(in crate::mesh) fn write(
    out: &mut dyn Write,
    surfaces: &[Surface],
    context: &MeshContext,
    job: &Job,
) -> Result<(), WriteFault> {
    put_all(out, surfaces, context, None, job)
}

fn outlines(surfaces: &[Surface]) -> Vec<Outline> {
    surfaces.iter().map(Outline::from).collect()
}

/// The materials of an OBJ, in a file beside it.
pub(super) struct Library {
    path: PathBuf,
    text: String,
}

impl Library {
    /// The materials of some surfaces for the OBJ at `path`.
    pub(super) fn beside(path: &Path, outlines: &[Outline]) -> Self {
        let text = material::text(outlines.iter().map(|outline| &outline.head), &names(outlines));
        Self { path: path.with_extension("mtl"), text }
    }

    /// Writes the materials and gives them and the OBJ, which is whole, their names.
    pub(super) fn finish(
        self,
        mut object: Output,
        written: &mut Written,
    ) -> Result<(), WriteError> {
        let Self { path, text } = self;
        let object_path = object.path().to_owned();
        // All the way, so that no materials appear if there is no room for the OBJ.
        object.flush().map_err(|error| WriteFault::Io(error).at(&object_path))?;
        let mut materials = Output::create(&path)?;
        materials.write_all(text.as_bytes()).map_err(|error| WriteFault::Io(error).at(&path))?;
        materials.finish()?;
        object.finish()?;
        written.files.extend([path, object_path]);
        Ok(())
    }
}

/// What objects and materials are called: one word each, no two the same.
fn names(outlines: &[Outline]) -> Vec<String> {
    name::distinct(outlines.iter().map(|outline| name::word(&outline.head.name)))
}

fn put_all(
    out: &mut dyn Write,
    surfaces: &[Surface],
    context: &MeshContext,
    library: Option<&Library>,
    job: &Job,
) -> Result<(), WriteFault> {
    let outlines = outlines(surfaces);
    let items = outlines
        .iter()
        .map(|outline| outline.counts.vertices + outline.normals() + outline.counts.triangles);
    job.progress.begin("write", items.sum());
    let mut stream = Stream::new(out, job);
    stream.put(head(context, library).as_bytes());
    for (surface, title) in surfaces.iter().zip(titles(&outlines, library)) {
        stream.put(title.text.as_bytes());
        let mesh = &surface.mesh;
        match &mesh.attributes.colors {
            Some(colors) => put_colored(&mut stream, &mesh.positions, colors)?,
            None => put_vertices(&mut stream, &mesh.positions)?,
        }
        put_normals(&mut stream, mesh.normals.as_deref().unwrap_or_default())?;
        put_faces(&mut stream, &mesh.triangles, title.first)?;
    }
    stream.finish()
}

/// What stands before a surface, and how its faces count.
pub(super) struct Title {
    pub(super) text: String,
    pub(super) first: First,
}

/// The numbers of a surface's first vertex and first normal.
#[derive(Clone, Copy)]
pub(super) struct First {
    vertex: u64,
    /// `None` if it has no normals.
    normal: Option<u64>,
}

/// All that comes before the first surface.
pub(super) fn head(context: &MeshContext, library: Option<&Library>) -> String {
    let mut text = remarks(&facts::of_file(context)) + &remarks(&[format!("AXES={Y_UP}")]);
    if let Some(library) = library {
        let name = library.path.file_name().unwrap_or_default().to_string_lossy();
        text += &format!("mtllib {}\n", name::line(&name));
    }
    text
}

/// What stands before each surface.
pub(super) fn titles(outlines: &[Outline], library: Option<&Library>) -> Vec<Title> {
    let (mut vertex, mut normal) = (1, 1);
    let title = |(outline, name): (&Outline, String)| {
        let mut text = remarks(&facts::of_surface(&outline.head)) + &format!("o {name}\n");
        if library.is_some() {
            text += &format!("usemtl {name}\n");
        }
        if outline.precision == Precision::F64 {
            text += &remarks(&[IS_F64.to_owned()]);
        }
        let first = First { vertex, normal: outline.has_normals.then_some(normal) };
        vertex += outline.counts.vertices;
        normal += outline.normals();
        Title { text, first }
    };
    outlines.iter().zip(names(outlines)).map(title).collect()
}

fn remarks(lines: &[String]) -> String {
    let remark = |line: &String| {
        // A line that ends with `\` goes on in the next.
        let end = if line.ends_with('\\') { " \n" } else { "\n" };
        format!("# {line}{end}")
    };
    lines.iter().map(remark).collect()
}

pub(super) fn put_vertices(
    stream: &mut Stream<'_>,
    positions: &Positions,
) -> Result<(), WriteFault> {
    match positions {
        Positions::F32(all) => stream.items(all, |bytes, &xyz| put(bytes, "v", y_up(xyz))),
        Positions::F64(all) => stream.items(all, |bytes, &xyz| put(bytes, "v", y_up(xyz))),
    }
}

/// Puts vertices with colours behind them, from 0 to 1 in sRGB, as most readers take them; there is no opacity.
fn put_colored(
    stream: &mut Stream<'_>,
    positions: &Positions,
    colors: &[Rgba],
) -> Result<(), WriteFault> {
    stream.items(0..positions.len(), |bytes, vertex| {
        match positions {
            Positions::F32(all) => put(bytes, "v", y_up(all[vertex])),
            Positions::F64(all) => put(bytes, "v", y_up(all[vertex])),
        }
        bytes.pop(); // the end of the line, which is not yet there
        let Rgba([r, g, b, _]) = colors[vertex];
        let [r, g, b] = [r, g, b].map(|byte| f32::from(byte) / 255.0);
        // Writing to memory does not fail.
        let _ = writeln!(bytes, " {r} {g} {b}");
    })
}

pub(super) fn put_normals(stream: &mut Stream<'_>, normals: &[[f32; 3]]) -> Result<(), WriteFault> {
    stream.items(normals, |bytes, &xyz| put(bytes, "vn", y_up(xyz)))
}

/// Puts triangles of a surface.
pub(super) fn put_faces(
    stream: &mut Stream<'_>,
    triangles: &[[u32; 3]],
    First { vertex, normal }: First,
) -> Result<(), WriteFault> {
    match normal {
        None => stream.items(triangles, |bytes, corners| {
            bytes.push(b'f');
            for &corner in corners {
                bytes.push(b' ');
                put_number(bytes, vertex + u64::from(corner));
            }
            bytes.push(b'\n');
        }),
        Some(normal) => stream.items(triangles, |bytes, corners| {
            bytes.push(b'f');
            for &corner in corners {
                bytes.push(b' ');
                put_number(bytes, vertex + u64::from(corner));
                bytes.extend(b"//");
                put_number(bytes, normal + u64::from(corner));
            }
            bytes.push(b'\n');
        }),
    }
}

/// Puts a keyword and three numbers.
fn put(bytes: &mut Vec<u8>, keyword: &str, [x, y, z]: [impl Display; 3]) {
    // Writing to memory does not fail.
    let _ = writeln!(bytes, "{keyword} {x} {y} {z}");
}

/// Puts a whole number: four times as fast as `write!`.
fn put_number(bytes: &mut Vec<u8>, mut number: u64) {
    let mut digits = [0; 20];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            break;
        }
    }
    bytes.extend_from_slice(&digits[start..]);
}

#[cfg(test)]
mod tests {
    use super::put_number;

    #[test]
    fn whole_numbers_are_written_as_anybody_would() {
        for number in [0, 7, 10, 987_654_321, u64::MAX] {
            let mut bytes = vec![];
            put_number(&mut bytes, number);
            assert_eq!(bytes, number.to_string().as_bytes());
        }
    }
}

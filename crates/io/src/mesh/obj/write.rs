//! Writes OBJ.

use super::material;
use crate::{
    Output, WriteError, WriteFault,
    mesh::{
        MeshContext, Written,
        axes::{Y_UP, y_up},
        facts, name,
        stream::Stream,
    },
};
use isokit_job::Job;
use isokit_mesh::{Positions, Precision, Surface};
use std::{fmt::Display, io::Write, path::Path};

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
    let mtl = path.with_extension("mtl");
    let library = mtl.file_name().unwrap_or_default().to_string_lossy();
    let mut object = Output::create(path)?;
    put_all(&mut object, surfaces, context, Some(&library), job).map_err(|fault| fault.at(path))?;
    let mut materials = Output::create(&mtl)?;
    let text = material::text(surfaces, &names(surfaces));
    materials.write_all(text.as_bytes()).map_err(|error| WriteFault::Io(error).at(&mtl))?;
    materials.finish()?;
    object.finish()?;
    written.files.extend([mtl, path.to_owned()]);
    Ok(())
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

/// What objects and materials are called: one word each, no two the same.
fn names(surfaces: &[Surface]) -> Vec<String> {
    name::distinct(surfaces.iter().map(|surface| name::word(&surface.name)))
}

fn put_all(
    out: &mut dyn Write,
    surfaces: &[Surface],
    context: &MeshContext,
    library: Option<&str>,
    job: &Job,
) -> Result<(), WriteFault> {
    let items = surfaces.iter().map(|surface| {
        let counts = surface.mesh.counts();
        let normals = if surface.mesh.normals.is_some() { counts.vertices } else { 0 };
        counts.vertices + normals + counts.triangles
    });
    job.progress.begin("write", items.sum());
    let mut stream = Stream::new(out, job);
    remarks(&mut stream, &facts::of_file(context));
    remarks(&mut stream, &[format!("AXES={Y_UP}")]);
    if let Some(library) = library {
        stream.put(format!("mtllib {}\n", name::line(library)).as_bytes());
    }
    let (mut vertices, mut normals) = (1, 1);
    for (surface, name) in surfaces.iter().zip(names(surfaces)) {
        remarks(&mut stream, &facts::of_surface(&surface.into()));
        stream.put(format!("o {name}\n").as_bytes());
        if library.is_some() {
            stream.put(format!("usemtl {name}\n").as_bytes());
        }
        put_surface(&mut stream, surface, [vertices, normals])?;
        vertices += surface.mesh.positions.len() as u64;
        normals += surface.mesh.normals.as_ref().map_or(0, Vec::len) as u64;
    }
    stream.finish()
}

fn remarks(stream: &mut Stream<'_>, lines: &[String]) {
    for line in lines {
        // A line that ends with `\` goes on in the next.
        let end = if line.ends_with('\\') { " \n" } else { "\n" };
        stream.put(format!("# {line}{end}").as_bytes());
    }
}

/// Puts a surface whose first vertex and first normal have these numbers.
fn put_surface(
    stream: &mut Stream<'_>,
    surface: &Surface,
    [vertex, normal]: [u64; 2],
) -> Result<(), WriteFault> {
    let mesh = &surface.mesh;
    if mesh.positions.precision() == Precision::F64 {
        remarks(stream, &[IS_F64.to_owned()]);
    }
    match &mesh.positions {
        Positions::F32(all) => stream.items(all, |bytes, &xyz| put(bytes, "v", y_up(xyz)))?,
        Positions::F64(all) => stream.items(all, |bytes, &xyz| put(bytes, "v", y_up(xyz)))?,
    }
    let triangles = mesh.triangles.iter();
    match &mesh.normals {
        None => stream.items(triangles, |bytes, corners| {
            bytes.push(b'f');
            for &corner in corners {
                bytes.push(b' ');
                put_number(bytes, vertex + u64::from(corner));
            }
            bytes.push(b'\n');
        }),
        Some(normals) => {
            stream.items(normals, |bytes, &xyz| put(bytes, "vn", y_up(xyz)))?;
            stream.items(triangles, |bytes, corners| {
                bytes.push(b'f');
                for &corner in corners {
                    bytes.push(b' ');
                    put_number(bytes, vertex + u64::from(corner));
                    bytes.extend(b"//");
                    put_number(bytes, normal + u64::from(corner));
                }
                bytes.push(b'\n');
            })
        }
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

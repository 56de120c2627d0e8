//! Whether surfaces can be written at all.

use crate::WriteFault;
use isokit_mesh::{Attributes, Counts, Surface, TriMesh};

/// Goes on if every index names a vertex and every vertex has a normal, a value, a colour, or none has.
///
/// An extractor's or reader's mesh always passes; one made by hand may not, and no writer can go on then.
pub(super) fn check(surfaces: &[Surface]) -> Result<(), WriteFault> {
    surfaces.iter().try_for_each(|surface| {
        let flaw = flaw(&surface.mesh);
        flaw.map_or(Ok(()), |flaw| Err(fault(&surface.name, &flaw)))
    })
}

/// The caller's fault: what is wrong with a surface.
pub(super) fn fault(name: &str, flaw: &str) -> WriteFault {
    WriteFault::Caller(format!("surface {name:?}: {flaw}").into())
}

/// What is wrong if triangles name vertices up to `needed`.
pub(super) fn too_few(counts: Counts, needed: u32) -> Option<String> {
    let Counts { vertices, triangles } = counts;
    let is_short = triangles > 0 && u64::from(needed) >= vertices;
    is_short.then(|| format!("a triangle names vertex {needed} of {vertices}"))
}

/// The greatest number that these triangles and those before name.
pub(super) fn needed(before: u32, triangles: &[[u32; 3]]) -> u32 {
    triangles.iter().fold(before, |most, triangle| triangle.iter().fold(most, |g, &v| g.max(v)))
}

fn flaw(mesh: &TriMesh) -> Option<String> {
    let vertices = mesh.positions.len();
    let normals = mesh.normals.as_ref().map_or(vertices, Vec::len);
    if normals != vertices {
        return Some(format!("{vertices} vertices have {normals} normals"));
    }
    let Attributes { values, colors } = &mesh.attributes;
    let lengths =
        [("values", values.as_ref().map(Vec::len)), ("colours", colors.as_ref().map(Vec::len))];
    let is_wrong = |(_, length): &(&str, Option<usize>)| length.is_some_and(|n| n != vertices);
    if let Some((what, Some(length))) = lengths.into_iter().find(is_wrong) {
        return Some(format!("{vertices} vertices have {length} {what}"));
    }
    too_few(mesh.counts(), needed(0, &mesh.triangles))
}

#[cfg(test)]
mod tests {
    use super::check;
    use isokit_mesh::{Attributes, Positions, Surface, TriMesh};

    #[test]
    fn what_names_no_vertex_is_refused() {
        let positions = Positions::F32(vec![[0.0; 3]; 3]);
        let mesh = |corner| TriMesh {
            positions: positions.clone(),
            triangles: vec![[0, 1, corner]],
            ..TriMesh::default()
        };
        let surface = |mesh| [Surface { name: "a".into(), mesh, ..Surface::default() }];
        assert!(check(&surface(mesh(2))).is_ok());
        let error = check(&surface(mesh(3))).unwrap_err().to_string();
        assert_eq!(error, r#"surface "a": a triangle names vertex 3 of 3"#);
        let normals = Some(vec![[0.0, 0.0, 1.0]; 2]);
        assert!(check(&surface(TriMesh { normals, ..mesh(2) })).is_err());
        let attributes = Attributes { values: Some(vec![0.0]), colors: None };
        let error = check(&surface(TriMesh { attributes, ..mesh(2) })).unwrap_err().to_string();
        assert_eq!(error, r#"surface "a": 3 vertices have 1 values"#);
    }
}

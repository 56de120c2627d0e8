//! Whether surfaces can be written at all.

use crate::WriteFault;
use isokit_mesh::{Surface, TriMesh};

/// Goes on if every index names a vertex and every vertex has a normal or none has.
///
/// An extractor's or reader's mesh always passes; one made by hand may not, and no writer can go on then.
pub(super) fn check(surfaces: &[Surface]) -> Result<(), WriteFault> {
    surfaces.iter().try_for_each(|surface| {
        let fault = fault(&surface.mesh);
        fault.map_or(Ok(()), |fault| {
            Err(WriteFault::Caller(format!("surface {:?}: {fault}", surface.name).into()))
        })
    })
}

fn fault(mesh: &TriMesh) -> Option<String> {
    let vertices = mesh.positions.len();
    let normals = mesh.normals.as_ref().map_or(vertices, Vec::len);
    if normals != vertices {
        return Some(format!("{vertices} vertices have {normals} normals"));
    }
    let greatest =
        |greatest: u32, triangle: &[u32; 3]| triangle.iter().fold(greatest, |g, &v| g.max(v));
    let needed = mesh.triangles.iter().fold(0, greatest);
    let is_short = !mesh.triangles.is_empty() && needed as usize >= vertices;
    is_short.then(|| format!("a triangle names vertex {needed} of {vertices}"))
}

#[cfg(test)]
mod tests {
    use super::check;
    use isokit_mesh::{Positions, Surface, TriMesh};

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
    }
}

//! What glTF files say: ours as the crate `gltf` reads them, and those of others.

mod foreign;

use crate::{
    Format, MeshContext,
    mesh::kit::{context, read_back, surface, torus, written},
};
use gltf::{Gltf, material::AlphaMode};
use isokit_geom::Unit;
use isokit_job::Job;
use isokit_mesh::{Positions, Rgba, Surface, TriMesh};

fn open(surfaces: &[Surface], context: &MeshContext) -> Gltf {
    Gltf::from_slice(&written(Format::Glb, surfaces, context).0).unwrap()
}

/// The surface of one triangle.
fn triangle(positions: Positions) -> Surface {
    let mesh = TriMesh { positions, triangles: vec![[0, 1, 2]], ..TriMesh::default() };
    Surface { name: "one".into(), mesh, ..Surface::default() }
}

/// The positions of the first surface as the file has them.
fn stored(surface: &Surface, context: &MeshContext) -> Vec<[f32; 3]> {
    let glb = open(std::slice::from_ref(surface), context);
    let primitive = glb.meshes().next().unwrap().primitives().next().unwrap();
    primitive.reader(|_| glb.blob.as_deref()).read_positions().unwrap().collect()
}

#[test]
fn each_surface_is_a_node_a_mesh_and_a_material() {
    let bone = Surface { name: "bone".into(), mesh: torus(5), ..Surface::default() };
    let none = Surface { name: "none".into(), ..Surface::default() };
    let glb = open(&[surface(6), bone, none], &context());
    let nodes: Vec<_> =
        glb.nodes().map(|node| (node.name().unwrap(), node.mesh().is_some())).collect();
    assert_eq!(nodes, [("skin", true), ("bone", true), ("none", false)]);
    let material = |k: usize| {
        let material = glb.materials().nth(k).unwrap();
        (material.name().unwrap(), material.alpha_mode(), material.double_sided())
    };
    assert_eq!(material(0), ("skin", AlphaMode::Blend, false));
    assert_eq!(material(1), ("bone", AlphaMode::Opaque, true));
    assert_eq!((glb.materials().len(), glb.meshes().len()), (2, 2));
    let color = glb.materials().next().unwrap().pbr_metallic_roughness().base_color_factor();
    assert_eq!(color, surface(6).color.unwrap().to_linear());
}

#[test]
fn a_translucent_vertex_makes_the_material_blend() {
    for (opacity, mode) in [(254, AlphaMode::Blend), (255, AlphaMode::Opaque)] {
        let mut surface = Surface { color: None, ..surface(3) };
        let mut colors = vec![Rgba([9, 8, 7, 255]); 9];
        colors[4].0[3] = opacity;
        surface.mesh.attributes.colors = Some(colors.clone());
        let bytes = written(Format::Glb, &[surface], &context()).0;
        let glb = Gltf::from_slice(&bytes).unwrap();
        assert_eq!(glb.materials().next().unwrap().alpha_mode(), mode);
        let found = &read_back(Format::Glb, bytes).surfaces[0];
        assert_eq!((&found.mesh.attributes.colors, found.color), (&Some(colors), None));
    }
}

#[test]
fn bounds_are_exactly_those_of_what_is_written() {
    let glb = open(&[surface(7)], &context());
    let accessor = glb.accessors().next().unwrap();
    let stored = stored(&surface(7), &context());
    for (bound, fold) in
        [(accessor.min(), f32::min as fn(f32, f32) -> f32), (accessor.max(), f32::max)]
    {
        let bound: Vec<f32> = serde_json::from_value(bound.unwrap()).unwrap();
        for k in 0..3 {
            assert_eq!(bound[k], stored.iter().map(|xyz| xyz[k]).reduce(fold).unwrap());
        }
    }
}

#[test]
fn coordinates_are_metres_with_y_up() {
    let surface = triangle(Positions::F32(vec![[1.0, 2.0, 3.0], [0.0; 3], [0.0; 3]]));
    for (unit, gltf_unit, metres) in [
        (Unit::Millimetre, None, 1e-3),
        (Unit::Unknown, None, 1.0),
        (Unit::Angstrom, Some(Unit::Metre), 1.0),
        (Unit::Unknown, Some(Unit::Centimetre), 1e-2),
        (Unit::Millimetre, Some(Unit::Unknown), 1.0),
    ] {
        let context = MeshContext { unit, gltf_unit, ..context() };
        let expected = [1.0, 3.0, -2.0].map(|c: f64| (c * metres) as f32);
        assert_eq!(stored(&surface, &context)[0], expected, "{unit:?} {gltf_unit:?}");
        let scale = Some(metres).filter(|&metres| metres != 1.0);
        assert_eq!([Format::Glb, Format::Gltf].map(|f| context.file_scale(f)), [scale; 2]);
        assert_eq!(
            [Format::Obj, Format::Ply, Format::Stl].map(|f| context.file_scale(f)),
            [None; 3]
        );
        let input = read_back(
            Format::Glb,
            written(Format::Glb, std::slice::from_ref(&surface), &context).0,
        );
        assert_eq!(input.unit, unit);
        let found = input.surfaces[0].mesh.positions.get(0);
        assert!(found.iter().zip([1.0, 2.0, 3.0]).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}

#[test]
fn the_file_says_what_was_done() {
    let glb = open(&[surface(3)], &context());
    let asset = &glb.document.as_json().asset;
    assert_eq!(asset.generator.as_deref(), Some(concat!("isokit ", env!("CARGO_PKG_VERSION"))));
    assert_eq!(
        asset.extras.as_ref().unwrap().get(),
        r#"{"axes":"y up: (x, z, -y) of the source, whose z is up","command":"isokit extract head.nii -o head.glb","metres_per_unit":0.001,"space":"RAS","unit":"mm"}"#
    );
    assert!(glb.extensions_required().next().is_none());
}

#[test]
fn all_is_aligned_and_says_what_it_is_for() {
    let (bytes, _) = written(Format::Glb, &[surface(5), surface(3)], &context());
    assert_eq!(bytes.len() % 4, 0);
    let glb = Gltf::from_slice(&bytes).unwrap();
    for view in glb.views() {
        assert_eq!(view.offset() % 4, 0);
        assert!(view.target().is_some());
    }
    assert_eq!(glb.buffers().next().unwrap().length(), glb.blob.as_ref().unwrap().len());
}

#[test]
fn normals_have_length_one_or_are_left_out() {
    let mut long = surface(4);
    long.mesh.normals.iter_mut().flatten().flatten().for_each(|c| *c *= 3.0);
    let (bytes, report) = written(Format::Glb, &[long], &context());
    assert_eq!(report.warnings, [""; 0]);
    for normal in read_back(Format::Glb, bytes).surfaces[0].mesh.normals.as_ref().unwrap() {
        assert!((normal.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-6, "{normal:?}");
    }
    for wrong in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
        let mut surface = surface(4);
        surface.mesh.normals.as_mut().unwrap()[5] = wrong;
        let (bytes, report) = written(Format::Glb, &[surface], &context());
        assert!(report.warnings[0].contains("the normal of vertex 5 is"), "{:?}", report.warnings);
        assert_eq!(read_back(Format::Glb, bytes).surfaces[0].mesh.normals, None);
    }
}

#[test]
fn coordinates_that_gltf_cannot_hold_are_refused() {
    for wrong in [f64::NAN, f64::INFINITY, 1e300] {
        let surface = triangle(Positions::F64(vec![[0.0; 3], [0.0, wrong, 0.0], [0.0; 3]]));
        let written =
            crate::write_mesh_to(&mut vec![], Format::Glb, &[surface], &context(), &Job::default());
        let error = written.unwrap_err().to_string();
        assert!(error.starts_with(r#"surface "one": vertex 1 is at [0.0, "#), "{error}");
    }
}

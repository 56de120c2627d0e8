//! Meshes of chance, with names of chance, in every format.

use super::corners;
use crate::{
    Format, MeshContext,
    mesh::{
        kit::{read_back, written},
        name,
    },
};
use isokit_geom::{Space, Unit};
use isokit_mesh::{Attributes, Positions, Rgba, Surface, TriMesh};
use proptest::{collection::vec, option, prelude::*};
use std::slice::from_ref;

/// Coordinates of any size, each a number of its precision.
fn positions(count: usize) -> impl Strategy<Value = Positions> {
    let narrow = vec(prop::array::uniform3(prop::num::f32::NORMAL | prop::num::f32::ZERO), count);
    let wide = vec(prop::array::uniform3(-1e9..1e9), count);
    prop_oneof![narrow.prop_map(Positions::F32), wide.prop_map(Positions::F64)]
}

fn mesh() -> impl Strategy<Value = TriMesh> {
    (3_usize..20).prop_flat_map(|count| {
        let normal = prop::array::uniform3(-1.0_f32..1.0);
        let normals = option::of(vec(normal, count));
        let corners = prop::array::uniform3(0..count as u32);
        let parts = (positions(count), normals, vec(corners, 1..30), attributes(count));
        parts.prop_map(|(positions, normals, triangles, attributes)| TriMesh {
            positions,
            normals,
            triangles,
            attributes,
        })
    })
}

fn attributes(count: usize) -> impl Strategy<Value = Attributes> {
    let values = option::of(vec(prop::num::f32::NORMAL | prop::num::f32::ZERO, count));
    let colors = option::of(vec(any::<[u8; 4]>().prop_map(Rgba), count));
    (values, colors).prop_map(|(values, colors)| Attributes { values, colors })
}

fn surface() -> impl Strategy<Value = Surface> {
    let color = option::of(any::<[u8; 4]>().prop_map(Rgba));
    let iso = option::of(prop::num::f64::NORMAL);
    (any::<String>(), color, iso, mesh()).prop_map(|(name, color, iso, mesh)| Surface {
        name,
        color,
        iso,
        mesh,
    })
}

fn context() -> impl Strategy<Value = MeshContext> {
    let unit = prop::sample::select(Unit::ALL.map(|(unit, _)| unit).to_vec());
    let space = prop::sample::select(vec![Space::Unknown, Space::Ras, Space::Lps]);
    (unit, space, any::<String>()).prop_map(|(unit, space, command)| MeshContext {
        unit,
        space,
        command,
        gltf_unit: None,
    })
}

/// Of a name, what a line can hold.
fn line(surface: &Surface) -> String {
    name::line(&surface.name).trim().to_owned()
}

/// Without what glTF's metres in f32 cannot hold: that is refused, or rounded to 0.
fn tamed(mut surface: Surface, context: &MeshContext) -> Surface {
    let metres = context.unit.metres().unwrap_or(1.0);
    let fits = |c: f64| (1e-30..1e30).contains(&(c * metres).abs());
    match &mut surface.mesh.positions {
        Positions::F32(all) => {
            all.as_flattened_mut()
                .iter_mut()
                .filter(|c| !fits((**c).into()))
                .for_each(|c| *c = 0.0);
        }
        Positions::F64(all) => {
            all.as_flattened_mut().iter_mut().filter(|c| !fits(**c)).for_each(|c| *c = 0.0);
        }
    }
    surface
}

proptest! {
    #[test]
    fn ply_keeps_everything(surface in surface(), context in context()) {
        let input = read_back(Format::Ply, written(Format::Ply, from_ref(&surface), &context).0);
        prop_assert_eq!((input.unit, input.space), (context.unit, context.space));
        let expected = Surface { name: line(&surface), ..surface };
        prop_assert_eq!(&input.surfaces, &[expected]);
    }

    #[test]
    fn obj_keeps_all_but_normals_that_nobody_shows(
        surfaces in vec(surface(), 1..4),
        context in context(),
    ) {
        let input = read_back(Format::Obj, written(Format::Obj, &surfaces, &context).0);
        prop_assert_eq!((input.unit, input.space), (context.unit, context.space));
        prop_assert_eq!(input.surfaces.len(), surfaces.len());
        for (found, surface) in input.surfaces.iter().zip(surfaces) {
            prop_assert_eq!(&found.mesh.positions, &surface.mesh.positions);
            prop_assert_eq!(&found.mesh.triangles, &surface.mesh.triangles);
            prop_assert_eq!(found.mesh.normals.is_some(), surface.mesh.normals.is_some());
            let opaque = |Rgba([r, g, b, _]): Rgba| Rgba([r, g, b, 255]);
            let colors = surface.mesh.attributes.colors.clone();
            let colors = colors.map(|all| all.into_iter().map(opaque).collect());
            prop_assert_eq!(&found.mesh.attributes, &Attributes { values: None, colors });
            prop_assert_eq!(&found.name, &line(&surface));
            prop_assert_eq!((found.color, found.iso), (surface.color, surface.iso));
        }
    }

    #[test]
    fn stl_keeps_every_corner_as_f32(surface in surface(), context in context()) {
        let input = read_back(Format::Stl, written(Format::Stl, from_ref(&surface), &context).0);
        prop_assert_eq!((input.unit, input.space), (context.unit, context.space));
        let narrow = |corners: [[f64; 3]; 3]| corners.map(|xyz| xyz.map(|c| c as f32));
        let found: Vec<_> = corners(&input.surfaces[0].mesh).into_iter().map(narrow).collect();
        let expected: Vec<_> = corners(&surface.mesh).into_iter().map(narrow).collect();
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn glb_keeps_all_but_a_rounding(surfaces in vec(surface(), 1..4), context in context()) {
        let surfaces: Vec<_> = surfaces.into_iter().map(|s| tamed(s, &context)).collect();
        let bytes = written(Format::Glb, &surfaces, &context).0;
        gltf::Gltf::from_slice(&bytes).expect("the validation of the crate `gltf`");
        let input = read_back(Format::Glb, bytes);
        prop_assert_eq!((input.unit, input.space), (context.unit, context.space));
        for (found, surface) in input.surfaces.iter().zip(surfaces) {
            prop_assert_eq!(&found.name, &surface.name);
            prop_assert_eq!(&found.mesh.triangles, &surface.mesh.triangles);
            prop_assert_eq!(found.iso, surface.iso);
            prop_assert_eq!(&found.mesh.attributes, &surface.mesh.attributes);
            let pairs = found.mesh.positions.iter().zip(surface.mesh.positions.iter());
            for (found, expected) in pairs.flat_map(|(a, b)| a.into_iter().zip(b)) {
                prop_assert!((found - expected).abs() <= expected.abs() * 2.0 * f64::from(f32::EPSILON));
            }
        }
    }
}

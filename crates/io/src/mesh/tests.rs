//! What holds for every format.

mod broken;
mod chance;
mod files;
mod spool;

use super::kit::{STREAMS, context, read_back, surface, written};
use crate::Format;
use isokit_geom::{Space, Unit};
use isokit_mesh::{Surface, TriMesh};
use std::slice::from_ref;

/// The corners of all triangles, which is what all formats keep.
pub(super) fn corners(mesh: &TriMesh) -> Vec<[[f64; 3]; 3]> {
    mesh.triangles.iter().map(|&triangle| mesh.corners(triangle)).collect()
}

#[track_caller]
pub(super) fn assert_near(found: &TriMesh, expected: &TriMesh, tolerance: f64) {
    assert_eq!(found.counts(), expected.counts());
    for (found, expected) in corners(found).iter().zip(corners(expected)) {
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() <= tolerance, "{found} is not {expected}");
        }
    }
}

#[test]
fn a_surface_is_read_back_where_it_was_and_as_what_it_was() {
    for format in STREAMS {
        let surface = surface(12);
        let input = read_back(format, written(format, from_ref(&surface), &context()).0);
        assert_eq!(input.format, format);
        assert_eq!((input.unit, input.space), (Unit::Millimetre, Space::Ras), "{format}");
        let [found] = &input.surfaces[..] else { panic!("{format}: {:?}", input.surfaces) };
        assert_near(&found.mesh, &surface.mesh, if format == Format::Glb { 1e-5 } else { 0.0 });
        assert_eq!((&found.name, found.iso), (&surface.name, surface.iso), "{format}");
        if format != Format::Stl {
            assert_eq!(found.color, surface.color, "{format}");
            assert_eq!(found.mesh.normals, surface.mesh.normals, "{format}");
            assert_eq!(found.mesh.triangles, surface.mesh.triangles, "{format}");
        }
    }
}

#[test]
fn the_same_surfaces_give_the_same_bytes() {
    for format in STREAMS {
        let surfaces = [surface(9)];
        let [first, second] = [(); 2].map(|()| written(format, &surfaces, &context()).0);
        assert_eq!(first, second, "{format}");
    }
}

#[test]
fn an_empty_surface_is_a_result() {
    for format in STREAMS {
        let empty = Surface { name: "none".to_owned(), iso: Some(9e9), ..Surface::default() };
        let (bytes, report) = written(format, from_ref(&empty), &context());
        assert_eq!(report.warnings, [""; 0], "{format}");
        assert_eq!(read_back(format, bytes).surfaces, [empty], "{format}");
    }
}

#[test]
fn no_surface_is_a_file_all_the_same() {
    for (format, count) in STREAMS.into_iter().zip([0, 0, 1, 1]) {
        let bytes = written(format, &[], &context()).0;
        assert_eq!(read_back(format, bytes).surfaces.len(), count, "{format}");
    }
}

#[test]
fn a_surface_without_name_colour_or_normals_gets_none() {
    for format in STREAMS {
        let mut plain = Surface { mesh: surface(5).mesh, ..Surface::default() };
        plain.mesh.normals = None;
        let input = read_back(format, written(format, &[plain], &context()).0);
        let found = &input.surfaces[0];
        assert_eq!((found.name.as_str(), found.color, found.iso), ("", None, None), "{format}");
        assert_eq!(found.mesh.normals, None, "{format}");
    }
}

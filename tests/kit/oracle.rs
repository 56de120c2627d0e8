//! The extractor against the reference: every vertex, every cell, every invariant.

use crate::{
    check::{Census, sides_of},
    reference::{CutEdge, Loop, Signs, Surface},
};
use isokit::job::Job;
use isokit::marching_cubes::{Degenerate, ExtractOptions, Nan, extract_into};
use isokit::mesh::{Precision, TriMesh};
use isokit::volume::{Sample, View};
use std::collections::BTreeSet;

/// Extracts, and asserts that the mesh is the one that the reference describes. With
/// [`Degenerate::Never`] it must also be free of coinciding vertices and flat triangles.
#[track_caller]
pub fn assert_as_defined<T: Sample>(
    view: &View<'_, T>,
    iso: f64,
    options: &ExtractOptions,
) -> (TriMesh, Surface) {
    let mut mesh = TriMesh::with_normals();
    let said =
        extract_into(view, iso, options, &mut mesh.refill(), &Job::default()).expect("it extracts");
    let signs = Signs::of(view, iso, options);
    let (loops, surface) = (signs.loops(), signs.surface());

    let census = Census::of(&mesh);
    let found = Surface {
        components: census.components,
        euler: census.euler,
        boundary_sides: census.boundary_sides,
        pinched_vertices: census.pinched_vertices,
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
    };
    assert_eq!(found, surface, "{:?}, iso {iso}, {options:?}", view.dims());
    assert_eq!((said.counts, said.precision), (mesh.counts(), mesh.positions.precision()));
    let faults = match options.degenerate {
        Degenerate::Never => census.faults(),
        Degenerate::Exact => census.faults_of_topology(),
    };
    let lawful = if options.nan == Nan::Mask { surface.pinched_vertices } else { 0 };
    assert_eq!(faults, lawful, "{census:?}, {:?}, iso {iso}, {options:?}", view.dims());

    let margins = match options.degenerate {
        Degenerate::Never => 2_f64.powi(-10)..=2_f64.powi(-4),
        Degenerate::Exact => 0.0..=0.0,
    };
    assert!(margins.contains(&said.margin), "margin {}", said.margin);
    let edges: BTreeSet<CutEdge> = loops.iter().flatten().flatten().copied().collect();
    let edges: Vec<CutEdge> = edges.into_iter().collect();
    assert_vertices(&mesh, &edges, view, iso, said.margin);
    assert_cells(&mesh, &edges, &loops, view);
    (mesh, surface)
}

/// Vertex `n` lies where the `n`th cut edge is cut, to the rounding of its precision.
#[track_caller]
fn assert_vertices<T: Sample>(
    mesh: &TriMesh,
    edges: &[CutEdge],
    view: &View<'_, T>,
    iso: f64,
    margin: f64,
) {
    let reach = view.grid().bounds().reach();
    let step = match mesh.positions.precision() {
        Precision::F32 => 2_f64.powi(-24),
        Precision::F64 => 2_f64.powi(-53),
    };
    for (found, edge) in mesh.positions.iter().zip(edges) {
        let expected = edge.position(view, iso, margin);
        for (found, expected) in found.into_iter().zip(expected) {
            // Half a step of what is stored, and some of the f64 in which both are computed.
            let allowed = expected.abs() * step * 1.01 + reach * 2_f64.powi(-48);
            let off = (found - expected).abs();
            assert!(off <= allowed, "{found} for {expected} on {edge:?}, iso {iso}");
        }
    }
}

/// The triangles of each cell, cells x fastest, fill the loops of that cell and nothing else: the sides
/// that no other triangle of the cell shares are the cuts of its faces, in the same direction.
#[track_caller]
fn assert_cells<T: Sample>(
    mesh: &TriMesh,
    edges: &[CutEdge],
    loops: &[Vec<Loop>],
    view: &View<'_, T>,
) {
    let mirrors = view.frame().index_to_world.determinant() < 0.0;
    let mut triangles = mesh.triangles.iter();
    for patches in loops {
        let count = patches.iter().map(|ring| ring.len() - 2).sum();
        let sides: BTreeSet<[CutEdge; 2]> = triangles
            .by_ref()
            .take(count)
            .flat_map(|&triangle| sides_of(triangle))
            .map(|[a, b]| if mirrors { [b, a] } else { [a, b] })
            .map(|side| side.map(|v| edges[v as usize]))
            .collect();
        let rim = sides.iter().copied().filter(|&[a, b]| !sides.contains(&[b, a]));
        let cuts = patches.iter().flat_map(|ring| {
            ring.iter().enumerate().map(|(i, &a)| [a, ring[(i + 1) % ring.len()]])
        });
        assert_eq!(rim.collect::<BTreeSet<_>>(), cuts.collect(), "{:?}", view.dims());
    }
}

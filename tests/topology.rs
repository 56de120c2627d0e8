//! What the library finds out about a mesh is what plain counting finds: of surfaces as they are extracted,
//! and of the same with triangles lost, vertices merged and windings turned by chance.

use isokit::{
    geom::Frame,
    job::Job,
    marching_cubes::{Boundary, Degenerate, ExtractOptions, extract},
    mesh::{TriMesh, topology},
    volume::{Grid, Volume},
};
use isokit_tests::{chance::Chance, check::Census};

fn extracted(chance: &mut Chance, boundary: Boundary, degenerate: Degenerate) -> TriMesh {
    let grid = Grid::new([6, 5, 7], Frame::default()).unwrap();
    let samples = (0..grid.count()).map(|_| chance.below(7) as i8 - 3).collect();
    let volume = Volume::new(grid, samples).unwrap();
    let options = ExtractOptions::DEFAULT.with_boundary(boundary).with_degenerate(degenerate);
    extract(&volume.view(), 0.0, &options, &Job::default()).unwrap()
}

#[track_caller]
fn check(mesh: &TriMesh) -> Census {
    let (census, found) = (Census::of(mesh), topology(mesh, &Job::default()).unwrap());
    assert_eq!(found.euler(), census.euler);
    assert_eq!(found.unused_vertices, census.unused_vertices as u64);
    assert_eq!(found.boundary_edges, census.boundary_sides as u64);
    assert_eq!(found.nonmanifold_edges, census.overused_sides as u64);
    assert_eq!(found.degenerate_triangles, census.flat_triangles as u64);
    if census.turned_sides == 0 {
        assert_eq!(found.inconsistent_edges, 0);
        assert_eq!(found.nonmanifold_vertices, census.pinched_vertices as u64);
    }
    if census.pinched_vertices == 0 {
        assert_eq!(found.components.len(), census.components);
    }
    if census.boundary_sides + census.turned_sides == 0 {
        // An open surface has no volume; two ways of counting need not agree.
        let off = (found.measure.volume - census.volume).abs();
        assert!(off <= 1e-9 * found.measure.area, "{off}");
    }
    census
}

#[test]
fn of_extracted_surfaces() {
    let mut chance = Chance::new(1);
    for _ in 0..50 {
        for boundary in [Boundary::Closed, Boundary::Open] {
            check(&extracted(&mut chance, boundary, Degenerate::Never));
            check(&extracted(&mut chance, boundary, Degenerate::Exact));
        }
    }
}

#[test]
fn of_surfaces_that_lost_triangles() {
    let (mut chance, mut pinched) = (Chance::new(2), 0);
    for _ in 0..50 {
        let mut mesh = extracted(&mut chance, Boundary::Closed, Degenerate::Never);
        mesh.triangles.retain(|_| chance.below(5) > 0);
        pinched += check(&mesh).pinched_vertices;
    }
    assert!(pinched > 100, "{pinched}");
}

#[test]
fn of_surfaces_with_merged_vertices() {
    let (mut chance, mut overused) = (Chance::new(3), 0);
    for _ in 0..50 {
        let mut mesh = extracted(&mut chance, Boundary::Open, Degenerate::Never);
        for _ in 0..8 {
            let vertex = |chance: &mut Chance| chance.below(mesh.positions.len() as u64) as u32;
            let [kept, lost] = [vertex(&mut chance), vertex(&mut chance)];
            let corners = mesh.triangles.iter_mut().flatten().filter(|corner| **corner == lost);
            corners.for_each(|corner| *corner = kept);
        }
        mesh.triangles.retain(|[a, b, c]| a != b && b != c && c != a);
        overused += check(&mesh).overused_sides;
    }
    assert!(overused > 0);
}

#[test]
fn of_surfaces_with_turned_triangles() {
    let (mut chance, mut turned) = (Chance::new(4), 0);
    for _ in 0..50 {
        let mut mesh = extracted(&mut chance, Boundary::Closed, Degenerate::Never);
        mesh.triangles.iter_mut().filter(|_| chance.below(9) == 0).for_each(|t| t.swap(0, 1));
        let census = check(&mesh);
        let found = topology(&mesh, &Job::default()).unwrap();
        assert_eq!(found.inconsistent_edges, census.turned_sides as u64);
        turned += census.turned_sides;
    }
    assert!(turned > 1000, "{turned}");
}

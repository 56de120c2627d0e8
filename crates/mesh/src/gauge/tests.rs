//! Surfaces that pass by against the same in memory.

use super::{Gauge, Gauged};
use crate::{Counts, MeshSink, MeshSinks, Positions, PositionsMut, Precision, TriMesh, topology};
use isokit_job::Job;

/// Rings of `around` vertices, each joined with the next by squares; `holes` tells those left out.
fn tube(rings: u32, around: u32, holes: impl Fn(u32, u32) -> bool) -> TriMesh {
    let place = |ring: u32, step: u32| {
        let angle = f64::from(step) * std::f64::consts::TAU / f64::from(around);
        [angle.cos() as f32, angle.sin() as f32, 0.3 * ring as f32 + 5.0]
    };
    let mut mesh = TriMesh::default();
    let positions = (0..rings).flat_map(|ring| (0..around).map(move |step| place(ring, step)));
    mesh.positions = Positions::F32(positions.collect());
    for (ring, step) in (0..rings - 1).flat_map(|ring| (0..around).map(move |step| (ring, step))) {
        let name = |up: u32, on: u32| (ring + up) * around + (step + on) % around;
        if !holes(ring, step) {
            mesh.triangles.push([name(0, 0), name(0, 1), name(1, 0)]);
            mesh.triangles.push([name(0, 1), name(1, 1), name(1, 0)]);
        }
    }
    mesh
}

/// The mesh in pieces of so many rings.
fn gauged(mesh: &TriMesh, around: usize, rings: usize) -> (TriMesh, Gauge) {
    let mut copy = TriMesh::default();
    let mut sinks = Gauged::new(vec![copy.refill()], 1, &Job::default());
    let Positions::F32(all) = &mesh.positions else { panic!("made as f32") };
    for start in (0..all.len()).step_by(around * rings) {
        let end = all.len().min(start + around * rings);
        let own = |t: &&[u32; 3]| (start..end).contains(&(t[0].min(t[1]).min(t[2]) as usize));
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().filter(own).copied().collect();
        let counts = Counts { vertices: (end - start) as u64, triangles: triangles.len() as u64 };
        let mut sink = sinks.sink(0);
        let piece = sink.piece(counts, Precision::F32).unwrap();
        let PositionsMut::F32(room) = piece.positions else { panic!("asked for f32") };
        room.copy_from_slice(&all[start..end]);
        piece.triangles.copy_from_slice(&triangles);
    }
    let (sinks, mut gauges) = sinks.finish().unwrap();
    drop(sinks);
    (copy, gauges.remove(0))
}

#[track_caller]
fn check(mesh: &TriMesh, around: usize) {
    let expected = topology(mesh, &Job::default()).unwrap();
    for rings in [1, 2, 3, 7, 100] {
        let (copy, found) = gauged(mesh, around, rings);
        assert_eq!((copy.counts(), &copy.positions), (mesh.counts(), &mesh.positions));
        let edges = [found.edges, found.boundary_edges, found.nonmanifold_edges];
        let of = [expected.edges, expected.boundary_edges, expected.nonmanifold_edges];
        assert_eq!(edges, of, "{rings} rings");
        assert_eq!(found.inconsistent_edges, expected.inconsistent_edges);
        assert_eq!(found.degenerate_triangles, expected.degenerate_triangles);
        assert_eq!(found.components, expected.components.len() as u64, "{rings} rings");
        assert_eq!(found.euler(), expected.euler() + expected.unused_vertices as i64);
        let (found, expected) = (found.measure, expected.measure);
        assert_eq!(found.bounds, expected.bounds);
        assert!((found.area - expected.area).abs() < 1e-12 * expected.area);
        assert!((found.volume - expected.volume).abs() < 1e-12 * expected.area);
    }
}

#[test]
fn a_tube_is_what_it_is_in_memory_however_it_is_cut() {
    check(&tube(9, 8, |_, _| false), 8);
    check(&tube(30, 5, |ring, _| ring % 7 == 3), 5);
    check(&tube(40, 6, |ring, step| (ring * 5 + step * step * 3) % 4 == 1), 6);
    check(&tube(2, 3, |_, _| false), 3);
}

#[test]
fn parts_that_meet_late_are_one() {
    // Two legs that stand apart until the last ring joins them.
    check(&tube(20, 8, |ring, step| ring < 18 && step % 4 == 3), 8);
    check(&tube(20, 8, |ring, step| ring > 1 && step % 4 == 3), 8);
}

#[test]
fn faults_are_counted() {
    let mut mesh = tube(9, 8, |_, _| false);
    let turned = mesh.triangles[20];
    mesh.triangles[20] = [turned[1], turned[0], turned[2]];
    mesh.triangles.push([64, 65, 71]);
    let Positions::F32(all) = &mut mesh.positions else { panic!("made as f32") };
    all[13] = all[12];
    check(&mesh, 8);
}

//! Memory that is used again, lent, and given back.

use super::{Positions, TriMesh};
use crate::{Counts, MeshSink, Piece, PositionsMut, Precision};

fn fill(sink: &mut impl MeshSink<Error: std::fmt::Debug>, vertices: u64, value: f32) {
    let counts = Counts { vertices, triangles: 2 * vertices };
    let piece = sink.piece(counts, Precision::F32).unwrap();
    let PositionsMut::F32(positions) = piece.positions else { panic!("asked for f32") };
    positions.fill([value; 3]);
    piece.triangles.fill([value as u32; 3]);
    assert_eq!(piece.triangles.len() as u64, 2 * vertices);
}

#[test]
fn a_refilled_mesh_holds_the_new_content_alone_in_the_old_memory() {
    let mut mesh = TriMesh::with_normals();
    fill(&mut mesh.refill(), 9, 1.0);
    let memory = mesh.triangles.as_ptr();
    let mut refill = mesh.refill();
    fill(&mut refill, 2, 3.0);
    fill(&mut refill, 4, 5.0);
    drop(refill);
    assert_eq!(mesh.counts(), Counts { vertices: 6, triangles: 12 });
    assert_eq!((mesh.positions.get(1), mesh.positions.get(2)), ([3.0; 3], [5.0; 3]));
    assert_eq!(mesh.normals.as_ref().unwrap().len(), 6);
    assert_eq!(mesh.triangles.as_ptr(), memory);
    mesh.renew(Counts { vertices: 2, triangles: 12 }, Precision::F32);
    assert_eq!(mesh.counts(), Counts { vertices: 2, triangles: 12 });
    assert_eq!(mesh.triangles.as_ptr(), memory);
    drop(mesh.refill());
    assert_eq!(mesh.counts(), Counts::default());
}

#[test]
fn what_is_written_to_spare_memory_begins_the_next_piece_whatever_its_size() {
    for (before, after) in [(9, 4), (9, 9), (9, 700), (1, 100_000)] {
        let mut mesh = TriMesh::with_normals();
        let none = Counts::default();
        assert!(mesh.refill().spare(none, Precision::F32).is_none(), "it holds nothing");
        fill(&mut mesh.refill(), before, 1.0);
        let mut refill = mesh.refill();
        let spare = refill.spare(none, Precision::F32).unwrap();
        assert_eq!(spare.normals.map(|normals| normals.len() as u64), Some(before));
        spare.triangles[0] = [7; 3];
        let counts = Counts { vertices: after, triangles: 2 * after };
        let piece = refill.piece(counts, Precision::F32).unwrap();
        assert_eq!(piece.triangles[0], [7; 3]);
        let first = Counts { vertices: after - 1, triangles: 1 };
        let Piece { positions, triangles, .. } = piece.after(first);
        let PositionsMut::F32(positions) = positions else { panic!("asked for f32") };
        assert_eq!((positions.len(), triangles.len() as u64), (1, 2 * after - 1));
        drop(refill);
        assert_eq!(mesh.counts(), counts);
    }
    let mut other = TriMesh::with_normals();
    fill(&mut other.refill(), 5, 1.0);
    let mut refill = other.refill();
    let spare = refill.spare(Counts::default(), Precision::F64);
    assert!(spare.is_none(), "positions in another precision are forgotten");
}

#[test]
fn all_pieces_of_a_surface_can_be_gone_over_once_more() {
    let mut mesh = TriMesh::with_normals();
    fill(&mut mesh.refill(), 9, 1.0);
    let mut refill = mesh.refill();
    assert!(refill.held().is_some_and(|held| held.triangles.is_empty()), "nothing yet");
    fill(&mut refill, 2, 3.0);
    fill(&mut refill, 4, 5.0);
    let Piece { positions, normals, triangles } = refill.held().unwrap();
    let PositionsMut::F32(positions) = positions else { panic!("asked for f32") };
    assert_eq!((positions.len(), normals.map(|normals| normals.len())), (6, Some(6)));
    assert_eq!((triangles[3], triangles[4], triangles.len()), ([3; 3], [5; 3], 12));
    triangles[0] = [1; 3];
    drop(refill);
    assert_eq!((mesh.triangles[0], mesh.triangles.len()), ([1; 3], 12));
}

#[test]
fn a_mesh_that_was_emptied_keeps_its_memory() {
    let mut mesh = TriMesh::with_normals();
    fill(&mut mesh.refill(), 9, 1.0);
    let memory = mesh.triangles.as_ptr();
    drop(mesh.refill());
    let likely = Counts { vertices: 900, triangles: 900 };
    assert!(mesh.refill().spare(likely, Precision::F32).is_none(), "it holds nothing");
    fill(&mut mesh.refill(), 9, 1.0);
    assert_eq!(mesh.triangles.as_ptr(), memory);
}

#[test]
fn of_new_memory_for_what_is_likely_a_mesh_keeps_what_it_holds() {
    let likely = Counts { vertices: 5_000_000, triangles: 9_000_000 };
    for vertices in [0, 3, 70_000, 6_000_000] {
        let mut mesh = TriMesh::with_normals();
        let mut refill = mesh.refill();
        let spare = refill.spare(likely, Precision::F32).unwrap();
        assert_eq!(spare.triangles.len() as u64, likely.triangles);
        spare.triangles[..2].fill([7; 3]);
        let counts = Counts { vertices, triangles: 2 * vertices };
        let piece = refill.piece(counts, Precision::F32).unwrap();
        assert!(piece.triangles.iter().take(2).all(|&triangle| triangle == [7; 3]));
        drop(refill);
        assert_eq!(mesh.counts(), counts);
        let Positions::F32(positions) = &mesh.positions else { panic!("asked for f32") };
        let normals = mesh.normals.as_ref().unwrap();
        let held = [positions.capacity(), normals.capacity(), mesh.triangles.capacity()];
        assert_eq!(held.map(|held| held as u64), [vertices, vertices, 2 * vertices]);
    }
}

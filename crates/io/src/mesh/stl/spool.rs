//! STL of a surface that comes in pieces.
//!
//! A triangle is written as the places of its corners, so it waits until they have come: a piece's
//! triangles may name vertices of the piece before, of their own and of the next one. Older ones are
//! forgotten. A piece without vertices does not count, its triangles wait along.

use super::write::{head, put_facets, stored};
use crate::{
    Format, Output, WriteFault,
    mesh::{MeshContext, Written, outline::Outline, rounding::Tally, section::Section, sound},
};
use isokit_job::Job;
use isokit_mesh::{Precision, TriMesh};
use std::{
    io::{self, Write},
    ops::Range,
};

/// A surface that comes in pieces.
#[derive(Debug)]
pub(in crate::mesh) struct Spool {
    facets: Section,
    /// The places that are remembered, those of the last piece behind those of the one before.
    places: Vec<[f32; 3]>,
    /// The vertex that the first of them is.
    first: u64,
    /// How many of them are older than the last piece.
    older: usize,
    /// Triangles whose vertices have not all come.
    waiting: Vec<[u32; 3]>,
    tally: Tally,
}

impl Spool {
    pub(in crate::mesh) fn create(beside: &Output) -> io::Result<Self> {
        let facets = Section::create(beside)?;
        let (places, waiting, tally) = Default::default();
        Ok(Self { facets, places, first: 0, older: 0, waiting, tally })
    }

    /// Takes in the next piece.
    pub(in crate::mesh) fn take(
        &mut self,
        piece: &mut TriMesh,
        outline: &Outline,
        job: &Job,
    ) -> Result<(), WriteFault> {
        if !piece.positions.is_empty() {
            let held = self.places.len();
            self.places.extend(piece.positions.iter().map(stored));
            self.put_waiting(outline, job)?;
            self.places.drain(..self.older);
            self.first += self.older as u64;
            self.older = held - self.older;
        }
        self.waiting.extend_from_slice(&piece.triangles);
        if outline.precision == Precision::F64 {
            self.tally.take(&mut piece.positions, stored, |xyz| xyz, job)?;
        }
        Ok(())
    }

    pub(in crate::mesh) fn sections(&self) -> [&Section; 1] {
        [&self.facets]
    }

    /// What [`write`](super::write()) writes of the whole surface, of which every triangle names vertices
    /// that came.
    pub(in crate::mesh) fn finish(
        self,
        out: &mut Output,
        outline: &Outline,
        context: &MeshContext,
        job: &Job,
        written: &mut Written,
    ) -> Result<(), WriteFault> {
        if outline.precision == Precision::F64 {
            self.tally.loss().report(outline, Format::Stl, written);
        }
        out.write_all(&head(outline, context)?)?;
        self.facets.append_to(out, job)
    }

    /// Puts the triangles that were waiting.
    pub(in crate::mesh) fn put_waiting(
        &mut self,
        outline: &Outline,
        job: &Job,
    ) -> Result<(), WriteFault> {
        let known = self.first..self.first + self.places.len() as u64;
        let is_known = |vertex: &&u32| known.contains(&u64::from(**vertex));
        if let Some(vertex) = self.waiting.as_flattened().iter().find(|vertex| !is_known(vertex)) {
            return Err(sound::fault(&outline.head.name, &unknown(*vertex, &known)));
        }
        let place = |vertex: u32| self.places[(u64::from(vertex) - self.first) as usize];
        self.facets
            .add(job, |stream| put_facets(stream, &self.waiting, |triangle| triangle.map(place)))?;
        self.waiting.clear();
        Ok(())
    }
}

fn unknown(vertex: u32, known: &Range<u64>) -> String {
    format!(
        "a triangle names vertex {vertex} where only {} to {} are in memory; .ply takes it",
        known.start,
        known.end.saturating_sub(1)
    )
}

#[cfg(test)]
mod tests {
    use super::Spool;
    use crate::{Output, mesh::outline::Outline};
    use isokit_job::Job;
    use isokit_mesh::{Positions, TriMesh};

    #[test]
    fn any_number_of_pieces_takes_the_memory_of_three() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::create(&folder.path().join("a.stl")).unwrap();
        let mut spool = Spool::create(&output).unwrap();
        for piece in 0..100_u32 {
            let positions = Positions::F32(vec![[piece as f32; 3]; 10]);
            let triangles = vec![[10 * piece, 10 * piece + 1, 10 * piece + 10]; 20];
            let mut piece = TriMesh { positions, normals: None, triangles, ..TriMesh::default() };
            spool.take(&mut piece, &Outline::default(), &Job::default()).unwrap();
        }
        assert_eq!((spool.places.len(), spool.waiting.len()), (20, 20));
        assert!(spool.places.capacity() < 100 && spool.waiting.capacity() < 100);
        assert_eq!(spool.facets.bytes(), 99 * 20 * 50);
    }
}

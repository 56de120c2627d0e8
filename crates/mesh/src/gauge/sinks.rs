//! Sinks that gauge what they hand on.

use super::{Gauge, Passing};
use crate::{Counts, MeshSink, MeshSinks, Piece, Positions, PositionsMut, Precision, TriMesh};
use isokit_job::Job;

/// Hands surfaces on, piece by piece, and finds out what they are. Takes the memory of a piece for each
/// surface, and while one is looked at that of three more.
#[derive(Debug)]
pub struct Gauged<S> {
    sinks: S,
    surfaces: Vec<Held>,
    job: Job,
}

/// A surface and its last piece, which is handed on when the next is asked for.
#[derive(Debug)]
struct Held {
    passing: Passing,
    piece: TriMesh,
    is_filled: bool,
}

impl<S: MeshSinks> Gauged<S> {
    /// Gauges so many surfaces on their way to `sinks`, on the threads of a job.
    pub fn new(mut sinks: S, surfaces: usize, job: &Job) -> Self {
        let held = |surface: usize| {
            let has_normals = sinks.sink(surface).wants_normals();
            let piece = if has_normals { TriMesh::with_normals() } else { TriMesh::default() };
            Held { passing: Passing::default(), piece, is_filled: false }
        };
        let surfaces = (0..surfaces).map(held).collect();
        Self { sinks, surfaces, job: job.clone() }
    }

    /// The sinks, which have all of every surface now, and what the surfaces are.
    ///
    /// # Errors
    ///
    /// If a sink has no room.
    pub fn finish(mut self) -> Result<(S, Vec<Gauge>), S::Error> {
        for surface in 0..self.surfaces.len() {
            self.hand_on(surface)?;
        }
        let gauges = self.surfaces.into_iter().map(|held| held.passing.finish()).collect();
        Ok((self.sinks, gauges))
    }

    fn hand_on(&mut self, surface: usize) -> Result<(), S::Error> {
        let Held { passing, piece, is_filled } = &mut self.surfaces[surface];
        if !std::mem::take(is_filled) {
            return Ok(());
        }
        self.job.threads.run(|| passing.look(piece));
        let mut sink = self.sinks.sink(surface);
        let room = sink.piece(piece.counts(), piece.positions.precision())?;
        match (room.positions, &piece.positions) {
            (PositionsMut::F32(room), Positions::F32(all)) => room.copy_from_slice(all),
            (PositionsMut::F64(room), Positions::F64(all)) => room.copy_from_slice(all),
            _ => unreachable!("the precision was asked for"),
        }
        if let (Some(room), Some(all)) = (room.normals, &piece.normals) {
            room.copy_from_slice(all);
        }
        room.triangles.copy_from_slice(&piece.triangles);
        Ok(())
    }
}

/// Takes the pieces of one surface.
#[derive(Debug)]
pub struct GaugedSink<'a, S> {
    sinks: &'a mut Gauged<S>,
    surface: usize,
}

impl<S: MeshSinks> MeshSink for GaugedSink<'_, S> {
    type Error = S::Error;

    fn wants_normals(&self) -> bool {
        self.sinks.surfaces[self.surface].piece.normals.is_some()
    }

    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, S::Error> {
        self.sinks.hand_on(self.surface)?;
        let held = &mut self.sinks.surfaces[self.surface];
        held.is_filled = true;
        held.piece.truncate(counts);
        Ok(held.piece.room(Counts::default(), counts, precision))
    }
}

impl<S: MeshSinks + Send> MeshSinks for Gauged<S> {
    type Error = S::Error;
    type Sink<'a>
        = GaugedSink<'a, S>
    where
        S: 'a;

    fn sink(&mut self, surface: usize) -> GaugedSink<'_, S> {
        GaugedSink { sinks: self, surface }
    }
}

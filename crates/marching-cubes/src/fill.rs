//! From a layout to vertices and triangles: each slab of slices writes its own part of the output.

use crate::{
    case::{CASES, CASES_TURNED},
    layout::Layout,
    planes::Planes,
    vertex::Placement,
};
use isokit_job::{Cancelled, Job};
use isokit_lanes::{
    Coordinate, Edges, FirstVertices, Word, prefer_large_pages, provide, triangles,
};
use isokit_mesh::{Piece, PositionsMut};
use isokit_volume::Sample;
use rayon::prelude::*;

/// Which way round triangles go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Winding {
    /// As the table has them.
    Kept,
    /// The other way, since the frame mirrors.
    Turned,
}

/// What there is to fill, and from what.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fill<'a, T> {
    pub(crate) planes: &'a Planes,
    pub(crate) layout: &'a Layout,
    pub(crate) placement: Placement<'a, T>,
    pub(crate) winding: Winding,
}

/// The part of the output that is still to be written.
struct Room<'a, C> {
    positions: &'a mut [[C; 3]],
    normals: Option<&'a mut [[f32; 3]]>,
}

/// What a task needs beside its part of the output: memory that is used again for every slice.
#[derive(Default)]
struct Scratch {
    words: Vec<Word>,
    along_x_and_y: Queue,
    along_z: Queue,
}

/// Edges on their way to vertices.
#[derive(Default)]
struct Queue {
    edges: Edges,
    odd: Vec<u32>,
}

impl<T: Sample> Fill<'_, T> {
    /// Fills a piece that has exactly the layout's counts.
    pub(crate) fn piece(
        &self,
        piece: Piece<'_>,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<(), Cancelled> {
        let Piece { positions, mut normals, triangles } = piece;
        prefer_large_pages(triangles);
        if let Some(normals) = &mut normals {
            prefer_large_pages(normals);
        }
        match positions {
            PositionsMut::F32(positions) => {
                prefer_large_pages(positions);
                self.slabs(Room { positions, normals }, triangles, layers_per_task, job)
            }
            PositionsMut::F64(positions) => {
                prefer_large_pages(positions);
                self.slabs(Room { positions, normals }, triangles, layers_per_task, job)
            }
        }
    }

    fn slabs<C: Coordinate>(
        &self,
        mut room: Room<'_, C>,
        mut triangles: &mut [[u32; 3]],
        layers_per_task: usize,
        job: &Job,
    ) -> Result<(), Cancelled> {
        let slices = self.planes.lattice.points[2];
        let mut tasks = vec![];
        for first in (0..slices).step_by(layers_per_task) {
            let end = slices.min(first.saturating_add(layers_per_task));
            let [before, after] = [self.layout.slices[first], self.layout.slices[end]];
            let vertices = (after.vertices - before.vertices) as usize;
            let own = (after.triangles - before.triangles) as usize;
            tasks.push((first..end, room.split_off(vertices), split_off(&mut triangles, own)));
        }
        tasks.into_par_iter().try_for_each(|(slices, mut room, mut triangles)| {
            job.check()?;
            let mut scratch = Scratch::default();
            provide(triangles);
            provide(room.positions);
            if let Some(normals) = &mut room.normals {
                provide(normals);
            }
            for z in slices {
                self.slice(z, &mut room, &mut triangles, &mut scratch);
                job.progress.advance(1);
            }
            Ok(())
        })
    }

    /// A slice's vertices, those along x and y row by row and then those along z, and its triangles.
    fn slice<C: Coordinate>(
        &self,
        z: usize,
        room: &mut Room<'_, C>,
        triangles: &mut &mut [[u32; 3]],
        scratch: &mut Scratch,
    ) {
        let Scratch { words, along_x_and_y, along_z } = scratch;
        let [_, ny, nz] = self.planes.lattice.points;
        let first = self.layout.row(self.planes.lattice, 0, z);
        let end = self.layout.slices[z + 1].vertices as u32;
        let mut flat = room.split_off((first.z - first.x) as usize);
        let mut upright = room.split_off((end - first.z) as usize);
        along_x_and_y.edges.begin(self.sample(z));
        along_z.edges.begin(self.sample(z));
        for y in 0..ny {
            if self.layout.is_blank(self.planes.lattice, y, z) {
                continue;
            }
            self.layout.words_of_row(self.planes, [y, z], words);
            // The farthest neighbours of an edge to the next slice; all others were there before.
            self.placement.expect([0, y, z + 2].map(|n| self.sample(n)), words);
            self.edges(0, y, words, along_x_and_y, &mut flat);
            self.edges(1, y, words, along_x_and_y, &mut flat);
            self.edges(2, y, words, along_z, &mut upright);
            if y + 1 < ny && z + 1 < nz {
                let written = self.triangles([y, z], words, triangles);
                split_off(triangles, written);
            }
        }
        self.flush(along_x_and_y, &mut flat);
        self.flush(along_z, &mut upright);
    }

    /// The number of the sample at a lattice index. A guard before the first has −1, which wraps.
    #[inline(always)]
    fn sample(&self, point: usize) -> u32 {
        point.wrapping_sub(self.planes.lattice.guard) as u32
    }

    /// Sends the edges along one axis that a row owns and that are cut to their vertices.
    #[inline(always)]
    fn edges<C: Coordinate>(
        &self,
        axis: usize,
        y: usize,
        mut words: &[Word],
        queue: &mut Queue,
        room: &mut Room<'_, C>,
    ) {
        loop {
            let taken = queue.edges.push(axis, [self.sample(0), self.sample(y)], words);
            words = &words[taken..];
            if words.is_empty() {
                return;
            }
            self.flush(queue, room);
        }
    }

    /// Writes the vertices of the edges in a queue.
    fn flush<C: Coordinate>(&self, queue: &mut Queue, room: &mut Room<'_, C>) {
        let Queue { edges, odd } = queue;
        let Room { positions, normals } = room.split_off(edges.len());
        self.placement.place(edges, positions, normals, odd);
        edges.clear();
    }

    /// The triangles of the cells that start in a row, to the front of `out`.
    fn triangles(&self, [y, z]: [usize; 2], words: &[Word], out: &mut [[u32; 3]]) -> usize {
        let row = |dy: usize, dz: usize| self.layout.row(self.planes.lattice, y + dy, z + dz);
        let rows = [row(0, 0), row(1, 0), row(0, 1), row(1, 1)];
        let first = FirstVertices {
            x: rows.map(|row| row.x),
            y: [rows[0].y, rows[2].y],
            z: [rows[0].z, rows[1].z],
        };
        let table = match self.winding {
            Winding::Kept => &CASES,
            Winding::Turned => &CASES_TURNED,
        };
        triangles(words, first, table, out)
    }
}

impl<'a, C: Coordinate> Room<'a, C> {
    /// Takes room for the first so many vertices.
    fn split_off(&mut self, vertices: usize) -> Room<'a, C> {
        Room {
            positions: split_off(&mut self.positions, vertices),
            normals: self.normals.as_mut().map(|normals| split_off(normals, vertices)),
        }
    }
}

/// Takes the first so many.
fn split_off<'a, T>(all: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, rest) = std::mem::take(all).split_at_mut(count);
    *all = rest;
    first
}

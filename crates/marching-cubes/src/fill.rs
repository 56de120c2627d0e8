//! From a layout to vertices and triangles: each slab of slices writes its own part of the output.

use crate::{
    case::{CASES, CASES_TURNED},
    layout::Layout,
    planes::Planes,
    vertex::Placement,
};
use isokit_geom::Frame;
use isokit_job::{Cancelled, Job};
use isokit_lanes::{
    Coordinate, Edges, FirstVertices, Normals, Vertices, Word, prefer_large_pages, triangles,
};
use isokit_mesh::{Piece, PositionsMut};
use isokit_volume::Sample;
use rayon::prelude::*;
use std::ops::Range;

/// Which way round triangles go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Winding {
    /// As the table has them.
    Kept,
    /// The other way, since the frame mirrors.
    Turned,
}

impl Winding {
    /// The one that keeps triangles counter-clockwise in a frame.
    pub(crate) fn of(frame: &Frame) -> Self {
        match frame.index_to_world.determinant() < 0.0 {
            true => Self::Turned,
            false => Self::Kept,
        }
    }
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

/// Vertices on the way to their places, 16 at a time.
struct Stream<'a, C> {
    room: Room<'a, C>,
    edges: Edges,
    vertices: Vertices<C>,
}

impl<T: Sample> Fill<'_, T> {
    /// Fills a piece that has exactly the layout's counts for some slices.
    pub(crate) fn piece(
        &self,
        slices: Range<usize>,
        piece: Piece<'_>,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<(), Cancelled> {
        let tasks = (slices, layers_per_task);
        let Piece { positions, mut normals, triangles } = piece;
        prefer_large_pages(triangles);
        if let Some(normals) = &mut normals {
            prefer_large_pages(normals);
        }
        match positions {
            PositionsMut::F32(positions) => {
                prefer_large_pages(positions);
                self.slabs(tasks, Room { positions, normals }, triangles, job)
            }
            PositionsMut::F64(positions) => {
                prefer_large_pages(positions);
                self.slabs(tasks, Room { positions, normals }, triangles, job)
            }
        }
    }

    fn slabs<C: Coordinate>(
        &self,
        (slices, layers_per_task): (Range<usize>, usize),
        mut room: Room<'_, C>,
        mut triangles: &mut [[u32; 3]],
        job: &Job,
    ) -> Result<(), Cancelled> {
        let mut tasks = vec![];
        for first in slices.clone().step_by(layers_per_task) {
            let end = slices.end.min(first.saturating_add(layers_per_task));
            let [before, after] = [self.layout.slices[first], self.layout.slices[end]];
            let vertices = (after.vertices - before.vertices) as usize;
            let own = (after.triangles - before.triangles) as usize;
            tasks.push((first..end, room.split_off(vertices), split_off(&mut triangles, own)));
        }
        tasks.into_par_iter().try_for_each(|(slices, mut room, mut triangles)| {
            job.check()?;
            let mut words = vec![];
            for z in slices {
                self.slice(z, &mut room, &mut triangles, &mut words);
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
        words: &mut Vec<Word>,
    ) {
        let [_, ny, nz] = self.planes.lattice.points;
        let first = self.layout.row(self.planes.lattice, 0, z);
        let end = self.layout.slices[z + 1].vertices as u32;
        let mut along_x_and_y = Stream::new(room.split_off((first.z - first.x) as usize));
        let mut along_z = Stream::new(room.split_off((end - first.z) as usize));
        for y in 0..ny {
            if self.layout.is_blank(self.planes.lattice, y, z) {
                continue;
            }
            self.layout.words_of_row(self.planes, [y, z], words);
            self.edges(0, [y, z], words, &mut along_x_and_y);
            self.edges(1, [y, z], words, &mut along_x_and_y);
            self.edges(2, [y, z], words, &mut along_z);
            if y + 1 < ny && z + 1 < nz {
                let written = self.triangles([y, z], words, triangles);
                split_off(triangles, written);
            }
        }
        along_x_and_y.flush(&self.placement);
        along_z.flush(&self.placement);
    }

    /// Sends the edges along one axis that a row owns and that are cut to their vertices.
    #[inline(always)]
    fn edges<C: Coordinate>(
        &self,
        axis: usize,
        [y, z]: [usize; 2],
        words: &[Word],
        stream: &mut Stream<'_, C>,
    ) {
        // A guard before the first sample has the number −1, which wraps.
        let sample = |point: usize| point.wrapping_sub(self.planes.lattice.guard) as u32;
        let (y, z) = (sample(y), sample(z));
        for word in words {
            let first = sample(word.first);
            let mut cuts = word.owned()[axis];
            while cuts != 0 {
                let x = first.wrapping_add(cuts.trailing_zeros());
                cuts &= cuts - 1;
                if stream.edges.push(axis, [x, y, z]) {
                    stream.flush(&self.placement);
                }
            }
        }
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

impl<'a, C: Coordinate> Stream<'a, C> {
    fn new(room: Room<'a, C>) -> Self {
        Self { room, edges: Edges::default(), vertices: Vertices::default() }
    }

    /// Writes what is on the way.
    fn flush<T: Sample>(&mut self, placement: &Placement<'_, T>) {
        if self.edges.is_empty() {
            return;
        }
        let count = self.edges.len();
        let Room { positions, normals } = self.room.split_off(count);
        let wanted = if normals.is_some() { Normals::Gradient } else { Normals::None };
        placement.place(&self.edges, wanted, &mut self.vertices);
        positions.copy_from_slice(&self.vertices.positions[..count]);
        if let Some(normals) = normals {
            normals.copy_from_slice(&self.vertices.normals[..count]);
        }
        self.edges.clear();
    }
}

/// Takes the first so many.
fn split_off<'a, T>(all: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, rest) = std::mem::take(all).split_at_mut(count);
    *all = rest;
    first
}

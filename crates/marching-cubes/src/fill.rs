//! From a layout to vertices and triangles: each slab of slices writes its own part of the output.

use crate::{
    case::{CASES, CASES_TURNED},
    layout::{Layout, Row},
    planes::Planes,
    vertex::Placement,
};
use isokit_job::{Cancelled, Job};
use isokit_lanes::{Coordinate, FirstVertices, Word, triangles};
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

/// Memory that a task uses again for every row.
#[derive(Default)]
struct Scratch {
    words: Vec<Word>,
    x: Vec<u32>,
    odd: Vec<usize>,
}

impl<T: Sample> Fill<'_, T> {
    /// Fills a piece that has exactly the layout's counts.
    pub(crate) fn piece(
        &self,
        piece: Piece<'_>,
        layers_per_task: usize,
        job: &Job,
    ) -> Result<(), Cancelled> {
        let Piece { positions, normals, triangles } = piece;
        match positions {
            PositionsMut::F32(positions) => {
                self.slabs(Room { positions, normals }, triangles, layers_per_task, job)
            }
            PositionsMut::F64(positions) => {
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
        let [_, ny, nz] = self.planes.lattice.points;
        let row = |y: usize| self.layout.row(self.planes.lattice, y, z);
        let end_of_x_and_y = row(0).z;
        let end = Row { x: end_of_x_and_y, z: self.layout.slices[z + 1].vertices as u32, ..row(0) };
        let mut in_slice = room.split_off((end_of_x_and_y - row(0).x) as usize);
        for y in 0..ny {
            let own = row(y);
            let next = if y + 1 < ny { row(y + 1) } else { end };
            let along = [
                in_slice.split_off((own.y - own.x) as usize),
                in_slice.split_off((next.x - own.y) as usize),
                room.split_off((next.z - own.z) as usize),
            ];
            self.layout.words_of_row(self.planes, [y, z], &mut scratch.words);
            if scratch.words.is_empty() {
                continue;
            }
            for (axis, room) in along.into_iter().enumerate() {
                self.edges(axis, [y, z], room, scratch);
            }
            if y + 1 < ny && z + 1 < nz {
                let written = self.triangles([y, z], &scratch.words, triangles);
                split_off(triangles, written);
            }
        }
    }

    /// The vertices on the edges along one axis that a row owns.
    fn edges<C: Coordinate>(
        &self,
        axis: usize,
        [y, z]: [usize; 2],
        room: Room<'_, C>,
        Scratch { words, x, odd }: &mut Scratch,
    ) {
        x.clear();
        for word in &*words {
            let mut cuts = word.owned()[axis];
            while cuts != 0 {
                x.push(word.first as u32 + cuts.trailing_zeros());
                cuts &= cuts - 1;
            }
        }
        if !x.is_empty() {
            self.placement.row(axis, [y, z], x, room.positions, room.normals, odd);
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

/// Takes the first so many.
fn split_off<'a, T>(all: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, rest) = std::mem::take(all).split_at_mut(count);
    *all = rest;
    first
}

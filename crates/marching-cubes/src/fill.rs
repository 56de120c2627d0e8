//! From a layout to vertices and triangles: each slab of slices writes its own part of the output.

use crate::{
    case::{CASES, CASES_TURNED},
    diagonals::Cases,
    layout::Layout,
    planes::Planes,
    trilinear::{Filling, SpecialWriter, Values},
    vertex::Placer,
    winding::Winding,
};
use isokit_job::{Cancelled, Job, WorkWith};
use isokit_lanes::{
    BLOCK, Coordinate, Edges, FirstVertices, Word, add_cases, exactly, prefer_large_pages, provide,
    triangles,
};
use isokit_mesh::{Counts, Piece, PositionsMut};
use isokit_volume::Sample;
use rayon::prelude::*;
use std::{mem, ops::Range};

/// What there is to fill, and from what.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fill<'a, T> {
    pub(crate) planes: &'a Planes,
    pub(crate) layout: &'a Layout,
    pub(crate) placer: Placer<'a, T>,
    pub(crate) values: Values<'a, T>,
    pub(crate) winding: Winding,
    /// What cells were filled is written down there, if somebody wants to know.
    pub(crate) cases: Option<&'a Cases>,
}

/// Vertices and triangles that are still to be written.
pub(crate) struct Rest<'a, C> {
    pub(crate) positions: &'a mut [[C; 3]],
    pub(crate) normals: Option<&'a mut [[f32; 3]]>,
    pub(crate) triangles: &'a mut [[u32; 3]],
}

impl<'a, C> Rest<'a, C> {
    /// Whether there is room for so much.
    pub(crate) fn holds(&self, counts: Counts) -> bool {
        let normals = self.normals.as_ref().map_or(u64::MAX, |normals| normals.len() as u64);
        counts.vertices <= normals.min(self.positions.len() as u64)
            && counts.triangles <= self.triangles.len() as u64
    }

    /// Takes room for the first so many.
    pub(crate) fn split_off(&mut self, counts: Counts) -> Self {
        let vertices = counts.vertices as usize;
        Rest {
            positions: split_off(&mut self.positions, vertices),
            normals: self.normals.as_mut().map(|normals| split_off(normals, vertices)),
            triangles: split_off(&mut self.triangles, counts.triangles as usize),
        }
    }
}

/// Vertices that are still to be written.
pub(crate) struct Room<'a, C> {
    pub(crate) positions: &'a mut [[C; 3]],
    pub(crate) normals: Option<&'a mut [[f32; 3]]>,
}

/// Slices of more bytes are filled several at a time, in bands of rows. A gyroid in f32 with slices of 1024², which
/// take 4 MiB, takes 0.83 of the time so, with slices of 2 MiB 0.95 (EPYC of 2021, one thread, November 2026); slices
/// of 1 MiB gain nothing.
const LARGE: usize = 1 << 20;

/// Whether slices of so many samples along x and y are filled in bands.
pub(crate) fn are_large<T>([nx, ny]: [usize; 2]) -> bool {
    nx * ny * size_of::<T>() > LARGE
}

/// So many at a time, at most.
const TOGETHER: usize = 4;

/// Bytes of samples of one slice in a band.
const BAND: usize = 1 << 16;

/// Rows in a band, even if they are longer: those beside a band are looked at twice.
const LEAST: usize = 4;

/// What is not yet written of a slice.
struct Unfilled<'a, T, C> {
    flat: Room<'a, C>,
    upright: Room<'a, C>,
    triangles: &'a mut [[u32; 3]],
    special: Option<SpecialWriter<'a, T, C>>,
    /// The cases of the cells whose triangles are written, if somebody wants to know.
    cases: Vec<u8>,
}

/// Some slices, and their part of the output.
type Task<'a, C> = (Range<usize>, Room<'a, C>, &'a mut [[u32; 3]]);

/// What a task needs beside its part of the output: memory that is used again for every slice.
#[derive(Default)]
pub(crate) struct Scratch {
    words: Vec<Word>,
    /// Of each slice that is filled at a time: along x and y, and along z.
    queues: Vec<[Queue; 2]>,
}

/// Edges on their way to vertices.
#[derive(Default)]
struct Queue {
    edges: Edges,
    odd: Vec<u32>,
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
        let Piece { positions, normals, triangles } = in_large_pages(piece);
        match positions {
            PositionsMut::F32(positions) => {
                self.slabs(tasks, Room { positions, normals }, triangles, job)
            }
            PositionsMut::F64(positions) => {
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
            let [before, after] = [first, end].map(|z| self.layout.before(z));
            let vertices = (after.vertices - before.vertices) as usize;
            let own = (after.triangles - before.triangles) as usize;
            tasks.push((first..end, room.split_off(vertices), split_off(&mut triangles, own)));
        }
        let fill: WorkWith<'_, Scratch, _, _> = &|scratch, task: Task<'_, C>| {
            let (slices, mut room, mut triangles) = task;
            job.check()?;
            provide(triangles);
            room.provide();
            exactly(|| {
                let layers = self.planes.lattice.sampled(&slices);
                self.bands(slices, &mut room, &mut triangles, scratch);
                job.progress.advance(layers);
            });
            Ok(())
        };
        tasks.into_par_iter().try_for_each_init(Scratch::default, fill)
    }

    /// Fills some slices.
    pub(crate) fn some<C: Coordinate>(
        &self,
        slices: Range<usize>,
        rest: Rest<'_, C>,
        scratch: &mut Scratch,
    ) {
        let Rest { positions, normals, mut triangles } = rest;
        let mut room = Room { positions, normals };
        provide(triangles);
        room.provide();
        self.bands(slices, &mut room, &mut triangles, scratch);
    }

    /// Fills slices that lie one above another; where they are large, of several a band of rows, then the next band. A
    /// vertex looks at samples of four slices, and of a band those stay in the second cache.
    fn bands<'a, C: Coordinate>(
        &'a self,
        slices: Range<usize>,
        room: &mut Room<'a, C>,
        triangles: &mut &'a mut [[u32; 3]],
        scratch: &mut Scratch,
    ) {
        let [nx, ny, _] = self.planes.lattice.points;
        let row = nx * size_of::<T>();
        let (together, rows_of_band) = match are_large::<T>([nx, ny]) {
            true => (TOGETHER, (BAND / row).max(LEAST)),
            false => (1, ny),
        };
        let Scratch { words, queues } = scratch;
        let makes_some = |z: &usize| self.layout.before(*z) != self.layout.before(z + 1);
        let mut slices = slices.filter(makes_some).peekable();
        while slices.peek().is_some() {
            let begin = |z| (z, self.begin(z, room, triangles));
            let mut some: Vec<_> = slices.by_ref().take(together).map(begin).collect();
            queues.resize_with(queues.len().max(some.len()), Default::default);
            for ((z, _), queues) in some.iter().zip(&mut *queues) {
                queues.iter_mut().for_each(|queue| queue.edges.begin(self.sample(*z)));
            }
            for first in (0..ny).step_by(rows_of_band) {
                let rows = first..ny.min(first + rows_of_band);
                for ((z, left), queues) in some.iter_mut().zip(&mut *queues) {
                    self.band(*z, rows.clone(), left, (words, queues));
                }
            }
            for ((z, left), [along_x_and_y, along_z]) in some.iter_mut().zip(&mut *queues) {
                self.flush(along_x_and_y, &mut left.flat);
                self.flush(along_z, &mut left.upright);
                if let Some(cases) = self.cases {
                    cases.add(self.layout.before(*z).triangles, mem::take(&mut left.cases));
                }
            }
        }
    }

    /// Takes the room of a slice: for the vertices along x and y row by row, then those along z, then those in special
    /// cells; and for its triangles, the last of which are those of special cells.
    fn begin<'a, C: Coordinate>(
        &'a self,
        z: usize,
        room: &mut Room<'a, C>,
        triangles: &mut &'a mut [[u32; 3]],
    ) -> Unfilled<'a, T, C> {
        let first = self.layout.row(self.planes.lattice, 0, z);
        let first_inner = self.layout.first_inner(z);
        let cells = self.layout.special(z);
        let [before, after] = [z, z + 1].map(|z| self.layout.before(z));
        let flat = room.split_off((first.z - first.x) as usize);
        let upright = room.split_off((first_inner - first.z) as usize);
        let triangles = split_off(triangles, (after.triangles - before.triangles) as usize);
        let others = triangles.len() - cells.triangles as usize;
        let (triangles, special) = triangles.split_at_mut(others);
        let special = (!cells.all().is_empty()).then(|| SpecialWriter {
            cells: cells.all(),
            values: self.values,
            placer: &self.placer,
            winding: self.winding,
            z,
            next: first_inner,
            room: room.split_off(cells.vertices as usize),
            triangles: special,
            filling: Filling::default(),
        });
        Unfilled { flat, upright, triangles, special, cases: vec![] }
    }

    /// Fills what some rows of a slice make; the last vertices wait in the queues.
    fn band<C: Coordinate>(
        &self,
        z: usize,
        rows: Range<usize>,
        left: &mut Unfilled<'_, T, C>,
        (words, [along_x_and_y, along_z]): (&mut Vec<Word>, &mut [Queue; 2]),
    ) {
        let Unfilled { flat, upright, triangles, special, cases } = left;
        let rows_of_block = (BLOCK / self.planes.lattice.words).max(1);
        for y in rows.clone().step_by(rows_of_block) {
            let rows = y..rows.end.min(y + rows_of_block);
            if self.layout.are_blank(self.planes.lattice, rows.clone(), z) {
                continue;
            }
            self.layout.words(self.planes, rows, z, words);
            if let Some(special) = special {
                special.rows(words, |y| self.first_vertices(y, z));
            }
            if z + 1 < self.planes.lattice.points[2] {
                let written = self.triangles(z, words, triangles);
                split_off(triangles, written);
                if self.cases.is_some() {
                    add_cases(words, cases);
                }
            }
            match words.len() <= BLOCK {
                true => self.edges(&[0, 1], words, along_x_and_y, flat),
                false => {
                    // One long row: all edges along x come before those along y.
                    self.edges(&[0], words, along_x_and_y, flat);
                    self.edges(&[1], words, along_x_and_y, flat);
                }
            }
            self.edges(&[2], words, along_z, upright);
        }
    }

    /// The number of the sample at a lattice index. A guard before the first has −1, which wraps.
    #[inline(always)]
    fn sample(&self, point: usize) -> u32 {
        point.wrapping_sub(self.planes.lattice.guard) as u32
    }

    /// Sends the cut edges along some axes to their vertices.
    #[inline(always)]
    fn edges<C: Coordinate>(
        &self,
        axes: &[usize],
        words: &[Word],
        queue: &mut Queue,
        room: &mut Room<'_, C>,
    ) {
        for words in words.chunks(BLOCK) {
            if queue.edges.push(axes, [self.sample(0); 2], words) {
                self.flush(queue, room);
            }
        }
    }

    /// Writes the vertices of the edges in a queue.
    fn flush<C: Coordinate>(&self, queue: &mut Queue, room: &mut Room<'_, C>) {
        let Queue { edges, odd } = queue;
        let Room { positions, normals } = room.split_off(edges.len());
        self.placer.place(edges, positions, normals, odd);
        edges.clear();
    }

    /// The first vertices around a row of cells.
    #[inline(always)]
    fn first_vertices(&self, y: usize, z: usize) -> FirstVertices {
        let (lattice, last) = (self.planes.lattice, self.planes.lattice.points[1] - 1);
        // Where there is no next row there are no cells either.
        let row = |dy: usize, dz: usize| self.layout.row(lattice, (y + dy).min(last), z + dz);
        let rows = [row(0, 0), row(1, 0), row(0, 1), row(1, 1)];
        FirstVertices {
            x: [rows[0].x, rows[1].x, rows[2].x, rows[3].x],
            y: [rows[0].y, rows[2].y],
            z: [rows[0].z, rows[1].z],
        }
    }

    /// The triangles of the cells in `words`, to the front of `out`.
    fn triangles(&self, z: usize, words: &[Word], out: &mut [[u32; 3]]) -> usize {
        let mut left = words;
        let first = |y: usize| {
            // Meanwhile the farthest neighbours of edges to the next slice come from memory, a row at a time.
            let row = left.iter().take_while(|word| word.row <= y).count();
            self.placer.expect([0, 0, z].map(|n| self.sample(n)), &left[..row]);
            left = &left[row..];
            self.first_vertices(y, z)
        };
        let table = match self.winding {
            Winding::Kept => &CASES,
            Winding::Turned => &CASES_TURNED,
        };
        triangles(words, first, table, out)
    }
}

impl<'a, C: Coordinate> Room<'a, C> {
    /// Has the system provide its pages.
    fn provide(&mut self) {
        provide(self.positions);
        if let Some(normals) = &mut self.normals {
            provide(normals);
        }
    }

    /// Takes room for the first so many vertices.
    pub(crate) fn split_off(&mut self, vertices: usize) -> Room<'a, C> {
        Room {
            positions: split_off(&mut self.positions, vertices),
            normals: self.normals.as_mut().map(|normals| split_off(normals, vertices)),
        }
    }
}

/// The same room, under which the system is asked for large pages.
pub(crate) fn in_large_pages(mut piece: Piece<'_>) -> Piece<'_> {
    prefer_large_pages(piece.triangles);
    if let Some(normals) = &mut piece.normals {
        prefer_large_pages(normals);
    }
    match &mut piece.positions {
        PositionsMut::F32(positions) => prefer_large_pages(positions),
        PositionsMut::F64(positions) => prefer_large_pages(positions),
    }
    piece
}

/// Takes the first so many.
pub(crate) fn split_off<'a, T>(all: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, rest) = mem::take(all).split_at_mut(count);
    *all = rest;
    first
}

//! Which triangles are in which tile of the picture.

use super::{
    Drawn, Painted, RasterError,
    cut::cut,
    screen::{PARTS, Seen, Viewport},
    tile::TILE,
};
use isokit_geom::HalfSpace;
use isokit_job::{CHUNK, Job, Stopped, in_chunks};
use isokit_lanes::exactly;
use rayon::prelude::*;
use std::{
    ops::Range,
    sync::atomic::{AtomicU64, Ordering},
};

/// All triangles of a picture by tiles.
pub(super) struct Bins<'a> {
    surfaces: &'a [Painted<'a>],
    /// Which of them hide all behind them.
    opaque: Vec<bool>,
    /// The vertices of the surfaces that can be seen.
    vertices: Vec<Vec<Seen>>,
    /// The number of each surface's first triangle, and after the last one how many there are.
    first: Vec<u32>,
    /// Pieces of triangles that were cut.
    pieces: Vec<Piece>,
    /// Pixels of the picture from left to right, and from top to bottom.
    size: [usize; 2],
    tiles: [usize; 2],
    /// Which of them are asked for: without a word all.
    wanted: Option<Vec<bool>>,
    /// Where a tile's entries begin, and after the last one how many there are.
    starts: Vec<usize>,
    /// Numbers of triangles; beyond those, of pieces.
    entries: Vec<u32>,
}

/// What is in a tile: a triangle of a surface, or a piece of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) surface: usize,
    /// The triangle's number among all.
    pub(super) triangle: u32,
    pub(super) corners: [Seen; 3],
}

/// A piece of a triangle.
#[derive(Clone, Copy, Debug)]
struct Piece {
    of: u32,
    corners: [Seen; 3],
}

/// What a chunk of a surface's triangles comes to.
#[derive(Debug, Default)]
struct Found {
    /// Tiles, and triangles in them; a piece by its number in the chunk, from the number of all triangles on.
    entries: Vec<(u32, u32)>,
    pieces: Vec<Piece>,
    drawn: Drawn,
}

/// What a chunk may add before it asks whether there is room for it.
const MUCH: u64 = 1 << 20;

/// How much all chunks have found, and whether that is allowed.
struct Held<'a> {
    job: &'a Job,
    bytes: &'a AtomicU64,
}

impl Held<'_> {
    fn add(&self, bytes: u64) -> Result<u64, Stopped> {
        self.job.check()?;
        let all = self.bytes.fetch_add(bytes, Ordering::Relaxed) + bytes;
        self.job.limits.allow("triangles by tiles", Some(all), 1)?;
        Ok(bytes)
    }
}

impl Found {
    fn bytes(&self) -> u64 {
        (size_of_val(&self.entries[..]) + size_of_val(&self.pieces[..])) as u64
    }
}

impl<'a> Bins<'a> {
    /// Of the tiles that are `wanted`, or of all.
    pub(super) fn of(
        surfaces: &'a [Painted<'a>],
        view: &Viewport<'_>,
        wanted: Option<Vec<bool>>,
        job: &Job,
    ) -> Result<(Self, Drawn), RasterError> {
        let mut first = vec![0_u32];
        let mut total = 0;
        for surface in surfaces {
            total += surface.mesh.triangles.len() as u64;
            // Pieces are numbered after the triangles.
            first.push(u32::try_from(2 * total).map_err(|_| RasterError::Triangles(total))? / 2);
        }
        let (size, tiles) = (size_of_picture(view), tiles_of(view));
        let (vertices, starts, entries) = (vec![], vec![], vec![]);
        let (opaque, pieces) = (surfaces.iter().map(Painted::is_opaque).collect(), vec![]);
        let mut bins = Self {
            surfaces,
            opaque,
            vertices,
            first,
            pieces,
            size,
            tiles,
            wanted,
            starts,
            entries,
        };
        let mut drawn = Drawn::default();
        let (mut found, held) = (vec![], AtomicU64::new(0));
        for (number, surface) in surfaces.iter().enumerate() {
            let triangles = surface.mesh.triangles.len();
            // NaN is not above 0.
            if !matches!(surface.opacity, opacity if opacity > 0.0) {
                drawn.triangles_skipped += triangles as u64;
                bins.vertices.push(vec![]);
                continue;
            }
            let cuts = view.cuts(surface.clips);
            bins.vertices.push(vertices_of(surface, &cuts, view, job)?);
            job.progress.begin("sort", triangles as u64);
            let chunk = |range: Range<usize>| {
                exactly(|| bins.chunk((number, range), &cuts, view, &Held { job, bytes: &held }))
            };
            for chunk in in_chunks(triangles, job, chunk).map_err(Stopped::from)? {
                found.push(chunk?);
            }
        }
        for found in &found {
            drawn = drawn.with(found.drawn);
        }
        bins.fill(found, job)?;
        Ok((bins, drawn))
    }

    /// How many tiles there are, from left to right and from top to bottom.
    pub(super) fn tiles(&self) -> [usize; 2] {
        self.tiles
    }

    /// How many pixels of a tile are in the picture, from left to right and from top to bottom.
    pub(super) fn pixels(&self, tile: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|axis| (self.size[axis] - tile[axis] * TILE[axis]).min(TILE[axis]))
    }

    /// What is in a tile, in the order of surfaces and of their triangles.
    #[inline]
    pub(super) fn entries(&self, [column, row]: [usize; 2]) -> impl Iterator<Item = Entry> {
        let tile = row * self.tiles[0] + column;
        let entries = &self.entries[self.starts[tile]..self.starts[tile + 1]];
        entries.iter().map(|&entry| self.entry(entry))
    }

    /// What of it does not hide all behind it.
    #[inline]
    pub(super) fn translucent(&self, tile: [usize; 2]) -> impl Iterator<Item = Entry> {
        self.entries(tile).filter(|entry| !self.hides(entry.surface))
    }

    /// The surface of a triangle, and the triangle's number in its mesh.
    #[inline]
    pub(super) fn place(&self, triangle: u32) -> (usize, usize) {
        let surface = self.first.partition_point(|&first| first <= triangle) - 1;
        (surface, (triangle - self.first[surface]) as usize)
    }

    /// Whether a surface hides all behind it.
    #[inline]
    pub(super) fn hides(&self, surface: usize) -> bool {
        self.opaque[surface]
    }

    /// Whether a triangle does.
    #[inline]
    pub(super) fn is_opaque(&self, triangle: u32) -> bool {
        self.hides(self.place(triangle).0)
    }

    #[inline]
    fn entry(&self, entry: u32) -> Entry {
        match entry.checked_sub(self.first[self.surfaces.len()]) {
            None => {
                let (surface, number) = self.place(entry);
                let corners = self.surfaces[surface].mesh.triangles[number];
                let corners = corners.map(|vertex| self.vertices[surface][vertex as usize]);
                Entry { surface, triangle: entry, corners }
            }
            Some(piece) => {
                let Piece { of, corners } = self.pieces[piece as usize];
                Entry { surface: self.place(of).0, triangle: of, corners }
            }
        }
    }

    fn chunk(
        &self,
        (number, range): (usize, Range<usize>),
        cuts: &[HalfSpace],
        view: &Viewport<'_>,
        held: &Held<'_>,
    ) -> Result<Found, Stopped> {
        let (mesh, vertices) = (self.surfaces[number].mesh, &self.vertices[number]);
        let total = self.first[self.surfaces.len()];
        let mut found = Found::default();
        let (mut polygon, mut told) = (vec![], 0);
        for n in range {
            if found.bytes() - told >= MUCH {
                told += held.add(found.bytes() - told)?;
            }
            let (id, corners) = (self.first[number] + n as u32, mesh.triangles[n]);
            let seen = corners.map(|vertex| vertices.get(vertex as usize).copied());
            let mut is_seen = false;
            match seen {
                [Some(a), Some(b), Some(c)] if ![a, b, c].iter().any(|seen| seen.is_cut()) => {
                    is_seen = self.put(id, [a, b, c], &mut found.entries);
                }
                [Some(_), Some(_), Some(_)] => {
                    cut(mesh.corners(corners).map(|place| view.view(place)), cuts, &mut polygon);
                    for pair in polygon.windows(2).skip(1) {
                        let corners = [polygon[0], pair[0], pair[1]].map(|place| view.seen(place));
                        let entry = total + found.pieces.len() as u32;
                        if self.put(entry, corners, &mut found.entries) {
                            found.pieces.push(Piece { of: id, corners });
                            is_seen = true;
                        }
                    }
                }
                _ => {} // a vertex is not there
            }
            match is_seen {
                true => found.drawn.triangles += 1,
                false => found.drawn.triangles_skipped += 1,
            }
        }
        held.add(found.bytes() - told)?;
        Ok(found)
    }

    /// Notes the tiles of the box around a triangle. None are of one outside of the picture, or without an area.
    #[inline]
    fn put(&self, entry: u32, corners: [Seen; 3], entries: &mut Vec<(u32, u32)>) -> bool {
        let [a, b, c] = corners.map(|corner| corner.place.map(i64::from));
        if (b[0] - a[0]) * (c[1] - a[1]) == (b[1] - a[1]) * (c[0] - a[0]) {
            return false;
        }
        let ends: [[i64; 2]; 2] = std::array::from_fn(|axis| {
            let side = TILE[axis] as i64 * i64::from(PARTS);
            let least = a[axis].min(b[axis]).min(c[axis]).div_euclid(side);
            let greatest = a[axis].max(b[axis]).max(c[axis]).div_euclid(side);
            [least.max(0), greatest.min(self.tiles[axis] as i64 - 1)]
        });
        let [columns, rows] = ends.map(|[least, greatest]| least..=greatest);
        let is_seen = !columns.is_empty() && !rows.is_empty();
        for row in rows {
            let tiles = columns.clone().map(|column| row * self.tiles[0] as i64 + column);
            let wanted = self.wanted.as_deref();
            let tiles = tiles.filter(|&tile| wanted.is_none_or(|wanted| wanted[tile as usize]));
            entries.extend(tiles.map(|tile| (tile as u32, entry)));
        }
        is_seen
    }

    /// Sorts what chunks found by tiles; in each, the chunks' order stays.
    fn fill(&mut self, found: Vec<Found>, job: &Job) -> Result<(), RasterError> {
        let pieces: usize = found.iter().map(|found| found.pieces.len()).sum();
        let entries: usize = found.iter().map(|found| found.entries.len()).sum();
        let total = self.first[self.surfaces.len()];
        if u64::from(total) + pieces as u64 > u64::from(u32::MAX) {
            return Err(RasterError::Triangles(u64::from(total) + pieces as u64));
        }
        self.pieces = job.limits.vec("cut triangles", Some(pieces as u64))?;
        self.entries = job.limits.zeroed("triangles by tiles", Some(entries as u64))?;
        let starts = self.tiles[0] as u64 * self.tiles[1] as u64 + 1;
        self.starts = job.limits.zeroed("tiles of the picture", Some(starts))?;
        for &(tile, _) in found.iter().flat_map(|found| &found.entries) {
            self.starts[tile as usize + 1] += 1;
        }
        for tile in 1..self.starts.len() {
            self.starts[tile] += self.starts[tile - 1];
        }
        let mut next = self.starts.clone();
        for found in found {
            let pieces_before = self.pieces.len() as u32;
            for (tile, entry) in found.entries {
                let entry = if entry < total { entry } else { entry + pieces_before };
                self.entries[next[tile as usize]] = entry;
                next[tile as usize] += 1;
            }
            self.pieces.extend(found.pieces);
        }
        Ok(())
    }
}

/// How many tiles a picture has, from left to right and from top to bottom.
pub(super) fn tiles_of(view: &Viewport<'_>) -> [usize; 2] {
    let size = size_of_picture(view);
    [0, 1].map(|axis| size[axis].div_ceil(TILE[axis]))
}

/// Pixels of a picture from left to right, and from top to bottom.
fn size_of_picture(view: &Viewport<'_>) -> [usize; 2] {
    [view.size.width, view.size.height].map(|n| n.get() as usize)
}

/// The vertices of a surface in the picture; those that a plane cuts off stand for what needs a closer look.
fn vertices_of(
    surface: &Painted<'_>,
    cuts: &[HalfSpace],
    view: &Viewport<'_>,
    job: &Job,
) -> Result<Vec<Seen>, RasterError> {
    let positions = &surface.mesh.positions;
    let mut seen: Vec<Seen> =
        job.limits.zeroed("vertices in the picture", Some(positions.len() as u64))?;
    job.progress.begin("look", positions.len() as u64);
    let done = job.threads.run(|| {
        seen.par_chunks_mut(CHUNK).enumerate().try_for_each(|(chunk, seen)| {
            job.check()?;
            exactly(|| {
                for (n, seen) in seen.iter_mut().enumerate() {
                    let place = view.view(positions.get(chunk * CHUNK + n));
                    let is_kept = cuts.iter().all(|half| half.keeps(place));
                    *seen = if is_kept { view.seen(place) } else { Seen::CUT };
                }
            });
            job.progress.advance(seen.len() as u64);
            Ok::<_, Stopped>(())
        })
    });
    done?;
    Ok(seen)
}

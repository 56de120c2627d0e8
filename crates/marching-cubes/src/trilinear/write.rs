//! The triangles and the interior vertices of special cells.

use super::{
    cell::{Cell, Values},
    patch::{Patch, WAIST},
    place::{Interpolant, centre, waist},
    special::Special,
    table::CENTRE,
};
use crate::{
    fill::{Room, Winding, split_off},
    vertex::Placer,
};
use isokit_geom::cube::Edge;
use isokit_lanes::{Coordinate, FirstVertices, Word};
use isokit_volume::Sample;

/// The special cells of a slice on their way into the output.
pub(crate) struct SpecialWriter<'a, T, C> {
    /// Those that are left.
    pub(crate) cells: &'a [Special],
    pub(crate) values: Values<'a, T>,
    pub(crate) placer: &'a Placer<'a, T>,
    pub(crate) winding: Winding,
    /// The slice.
    pub(crate) z: usize,
    /// The number of the next interior vertex.
    pub(crate) next: u32,
    /// The part of the output that is still to be written.
    pub(crate) room: Room<'a, C>,
    pub(crate) triangles: &'a mut [[u32; 3]],
    /// Memory that every cell uses again.
    pub(crate) filling: Filling,
}

/// A special cell in the making.
#[derive(Debug, Default)]
pub(crate) struct Filling {
    triangles: Vec<[u8; 3]>,
    inner: [[f64; 3]; WAIST],
    /// Where the edges are crossed, where anybody asks.
    crossings: [[f64; 3]; 12],
}

impl<T: Sample, C: Coordinate> SpecialWriter<'_, T, C> {
    /// Writes those of some rows, and takes them out of the rows' words. `first` gives the first vertices of
    /// a row.
    pub(crate) fn rows(&mut self, words: &mut [Word], first: impl Fn(usize) -> FirstVertices) {
        for row in words.chunk_by_mut(|a, b| a.row == b.row) {
            let y = row[0].row as u32;
            let mut next = match self.cells.first() {
                Some(cell) if cell.y == y => first(row[0].row),
                Some(_) => continue,
                None => return,
            };
            for word in row {
                let own = |cell: &Special| {
                    cell.y == y && (cell.x as usize) < word.first + u64::BITS as usize
                };
                let (now, later) = self.cells.split_at(self.cells.partition_point(own));
                self.cells = later;
                for special in now {
                    let n = special.x - word.first as u32;
                    word.active &= !(1 << n);
                    self.cell(special, word.case(n), &next.ids(word, n));
                }
                next.pass(word);
            }
        }
    }

    fn cell(&mut self, special: &Special, code: u8, ids: &[u32; 16]) {
        let low = [special.x as usize, special.y as usize, self.z];
        let patch = Patch::new(code, special.joined, special.tunnel);
        let count = patch.vertices();
        let triangles = &mut self.filling.triangles;
        triangles.clear();
        patch.discs().for_each(|disc| triangles.extend(disc.triangles));
        if count > 0 {
            let (cell, samples) = (self.values.cell(code, low), low.map(|i| self.values.sample(i)));
            self.inner(&cell, &patch, (special.tunnel, samples));
        }
        let first = self.next;
        let number = |name: u8| match name.checked_sub(CENTRE) {
            Some(inner) => first + u32::from(inner),
            None => ids[usize::from(name)],
        };
        let triangles = &self.filling.triangles;
        let out = split_off(&mut self.triangles, triangles.len());
        for (out, triangle) in out.iter_mut().zip(triangles) {
            let [a, b, c] = triangle.map(number);
            *out = if self.winding == Winding::Kept { [a, b, c] } else { [a, c, b] };
        }
        self.next += count as u32;
    }

    /// The interior vertices of a cell, and the triangles of its tube.
    fn inner(&mut self, cell: &Cell, patch: &Patch, (tunnel, low): (Option<[u8; 2]>, [u32; 3])) {
        let filling = &mut self.filling;
        for edge in Edge::all() {
            let (corner, axis) = (edge.ends()[0].offset(), edge.axis());
            let start = std::array::from_fn(|k| low[k].wrapping_add(corner[k] as u32));
            let place = &mut filling.crossings[edge.index()];
            *place = corner.map(|i| i as f64);
            if cell.crosses(edge) {
                place[axis] = self.placer.crossing(axis, start);
            }
        }
        let Filling { triangles, inner, crossings } = filling;
        let interpolant = Interpolant::new(cell);
        if let (Some(interpolant), Some(ends)) = (&interpolant, tunnel) {
            *inner = waist(interpolant, ends);
            // Not from where vertices are placed, so that no placement changes a triangle.
            let distance = |edge: u8, n: usize| {
                let (p, q) = (interpolant.crossing(Edge::new(edge)), inner[n]);
                p.iter().zip(q).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt()
            };
            patch.bridge(distance, triangles);
        } else if let Some(ring) = patch.fan() {
            let mut places = [[0.0; 3]; 12];
            let ring = ring.iter().map(|&edge| crossings[usize::from(edge)]);
            let count = ring.zip(&mut places).map(|(from, to)| *to = from).count();
            inner[0] = centre(interpolant.as_ref(), &places[..count]);
        }
        let count = patch.vertices();
        let Room { positions, mut normals } = self.room.split_off(count);
        for n in 0..count {
            positions[n] = self.placer.position_in_cell(low, filling.inner[n]);
            if let Some(normals) = &mut normals {
                let gradient = interpolant.map(|whole| whole.gradient(filling.inner[n]).0);
                let told = gradient.and_then(|gradient| self.placer.outward(gradient));
                let shown = || self.placer.outward(inward(n, filling));
                normals[n] = told.or_else(shown).unwrap_or([0.0, 0.0, 1.0]);
            }
        }
    }
}

/// Against the sum of the normals of the triangles around an interior vertex, as gradients are: in index
/// space and by covectors.
fn inward(n: usize, Filling { triangles, inner, crossings }: &Filling) -> [f64; 3] {
    let place = |name: u8| match name.checked_sub(CENTRE) {
        Some(inner_name) => inner[usize::from(inner_name)],
        None => crossings[usize::from(name)],
    };
    let mut sum = [0.0; 3];
    for triangle in triangles.iter().filter(|t| t.contains(&(CENTRE + n as u8))) {
        let [p, q, r] = triangle.map(place);
        let [u, v]: [[f64; 3]; 2] = [q, r].map(|end| std::array::from_fn(|k| end[k] - p[k]));
        for (k, sum) in sum.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            *sum -= u[i] * v[j] - u[j] * v[i];
        }
    }
    sum
}

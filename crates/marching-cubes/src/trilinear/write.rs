//! The triangles and the interior vertices of special cells.

use super::{
    cell::{Cell, Values},
    patch::{Patch, WAIST},
    place::{Interpolant, centre, waist},
    special::Special,
    table::CENTRE,
};
use crate::{
    fill::{Room, split_off},
    vertex::Placer,
    winding::Winding,
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
    /// The triangles of a tube.
    tube: Vec<[u8; 3]>,
    inner: [[f64; 3]; WAIST],
}

impl<T: Sample, C: Coordinate> SpecialWriter<'_, T, C> {
    /// Writes those of some rows, and takes them out of the rows' words. `first` gives the first vertices of
    /// a row.
    pub(crate) fn rows(&mut self, words: &mut [Word], first: impl Fn(usize) -> FirstVertices) {
        let mut words = words;
        while let Some(&Special { y, .. }) = self.cells.first() {
            // Few rows have one.
            let before = words.partition_point(|word| word.row < y as usize);
            words = &mut words[before..];
            let row = words.partition_point(|word| word.row == y as usize);
            if row == 0 {
                return;
            }
            let (row, later) = words.split_at_mut(row);
            words = later;
            let mut next = first(y as usize);
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
                if self.cells.first().is_none_or(|cell| cell.y != y) {
                    break;
                }
                next.pass(word);
            }
        }
    }

    fn cell(&mut self, special: &Special, code: u8, ids: &[u32; 16]) {
        let low = [special.x as usize, special.y as usize, self.z];
        let patch = Patch::new(code, special.joined, special.tunnel);
        let count = patch.vertices();
        let tube = &mut self.filling.tube;
        tube.clear();
        if count > 0 {
            let (cell, samples) = (self.values.cell(code, low), low.map(|i| self.values.sample(i)));
            self.inner(&cell, &patch, (special.tunnel, samples));
        }
        let first = self.next;
        let number = |name: u8| match name.checked_sub(CENTRE) {
            Some(inner) => first + u32::from(inner),
            None => ids[usize::from(name)],
        };
        let own = split_off(&mut self.triangles, patch.triangles());
        let of_discs = patch.discs().map(|disc| disc.triangles.len()).sum::<usize>();
        debug_assert_eq!(own.len(), of_discs + self.filling.tube.len(), "as were counted");
        let is_kept = self.winding == Winding::Kept;
        let mut left = own.iter_mut();
        let mut write = |triangles: &[[u8; 3]]| {
            for (triangle, own) in triangles.iter().zip(&mut left) {
                let [a, b, c] = triangle.map(number);
                *own = if is_kept { [a, b, c] } else { [a, c, b] };
            }
        };
        patch.discs().for_each(|disc| write(disc.triangles));
        write(&self.filling.tube);
        self.next += count as u32;
    }

    /// The interior vertices of a cell, and the triangles of its tube.
    fn inner(&mut self, cell: &Cell, patch: &Patch, (tunnel, low): (Option<[u8; 2]>, [u32; 3])) {
        let crossing = |edge: u8| {
            let edge = Edge::new(edge);
            let (corner, axis) = (edge.ends()[0].offset(), edge.axis());
            let mut place = corner.map(|i| i as f64);
            let start = std::array::from_fn(|k| low[k].wrapping_add(corner[k] as u32));
            place[axis] = self.placer.crossing::<C>(axis, start);
            place
        };
        let Filling { tube, inner } = &mut self.filling;
        let interpolant = Interpolant::new(cell);
        if let (Some(interpolant), Some(ends)) = (&interpolant, tunnel) {
            *inner = waist(interpolant, ends);
            // Not from where vertices are placed, so that no placement changes a triangle.
            let distances = |edge: u8| {
                let p = interpolant.crossing(Edge::new(edge));
                inner.map(|q| p.iter().zip(q).map(|(p, q)| (p - q) * (p - q)).sum::<f64>().sqrt())
            };
            patch.bridge(distances, tube);
        } else if let Some(ring) = patch.fan() {
            let mut places = [[0.0; 3]; 12];
            ring.iter().zip(&mut places).for_each(|(&edge, place)| *place = crossing(edge));
            inner[0] = centre(interpolant.as_ref(), &places[..ring.len()]);
        }
        let count = patch.vertices();
        let Room { positions, mut normals } = self.room.split_off(count);
        for n in 0..count {
            positions[n] = self.placer.position_in_cell(low, inner[n]);
            if let Some(normals) = &mut normals {
                let gradient = interpolant.map(|whole| whole.gradient(inner[n]).0);
                let told = gradient.and_then(|gradient| self.placer.outward(gradient));
                let place = |name: u8| match name.checked_sub(CENTRE) {
                    Some(inner_name) => inner[usize::from(inner_name)],
                    None => crossing(name),
                };
                let triangles = patch.discs().flat_map(|disc| disc.triangles).chain(&*tube);
                let shown = || self.placer.outward(inward(n, triangles, place));
                normals[n] = told.or_else(shown).unwrap_or([0.0, 0.0, 1.0]);
            }
        }
    }
}

/// Against the sum of the normals of the triangles around interior vertex `n`, as gradients are: in index
/// space and by covectors. `place` says where a vertex is.
fn inward<'t>(
    n: usize,
    triangles: impl Iterator<Item = &'t [u8; 3]>,
    place: impl Fn(u8) -> [f64; 3],
) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for triangle in triangles.filter(|triangle| triangle.contains(&(CENTRE + n as u8))) {
        let [p, q, r] = triangle.map(&place);
        let [u, v]: [[f64; 3]; 2] = [q, r].map(|end| std::array::from_fn(|k| end[k] - p[k]));
        for (k, sum) in sum.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            *sum -= u[i] * v[j] - u[j] * v[i];
        }
    }
    sum
}

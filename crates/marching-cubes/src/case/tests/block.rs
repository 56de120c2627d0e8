//! Cells that share samples, and their triangles on the common lattice edges.

use isokit_geom::cube::{Corner, Edge};

/// A block of cells with few samples, at most 18.
pub(super) struct Block {
    points: [usize; 3],
    cells: Vec<Cell>,
}

/// Where a cell's parts are in its block.
struct Cell {
    corners: [usize; 8],
    edges: [usize; 12],
}

/// Above every name of a lattice edge: three names for each of 18 samples, and a word has 64 bits.
pub(super) const EDGE_NAMES: usize = 64;

impl Block {
    /// The block with `points` samples along x, y and z.
    pub(super) fn new(points: [usize; 3]) -> Self {
        let mut block = Self { points, cells: vec![] };
        for z in 1..points[2] {
            for y in 1..points[1] {
                for x in 1..points[0] {
                    block.cells.push(block.cell([x - 1, y - 1, z - 1]));
                }
            }
        }
        block
    }

    fn cell(&self, ijk: [usize; 3]) -> Cell {
        let corner = |k: Corner| {
            let offset = k.offset();
            self.sample(std::array::from_fn(|axis| ijk[axis] + offset[axis]))
        };
        let edge = |e: Edge| edge_above(corner(e.ends()[0]), e.axis());
        Cell {
            corners: std::array::from_fn(|k| corner(Corner::new(k as u8))),
            edges: std::array::from_fn(|e| edge(Edge::new(e as u8))),
        }
    }

    /// The number of a sample, x fastest.
    pub(super) fn sample(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.points[0] * (j + self.points[1] * k)
    }

    /// How many ways there are to choose the signs of all samples.
    pub(super) fn patterns(&self) -> u32 {
        1 << self.points.iter().product::<usize>()
    }

    /// The triangles that `table` gives where bit `n` of `signs` tells whether sample `n` is inside;
    /// their corners are lattice edges.
    pub(super) fn triangles<'a>(
        &'a self,
        signs: u32,
        table: &'a [impl AsRef<[[u8; 3]]>],
    ) -> impl Iterator<Item = [usize; 3]> + 'a {
        self.cells.iter().flat_map(move |cell| {
            let case = (0..8).fold(0, |case, k| case | (signs >> cell.corners[k] & 1) << k);
            table[case as usize].as_ref().iter().map(|t| t.map(|e| cell.edges[e as usize]))
        })
    }

    /// Whether a lattice edge lies in the plane through sample `at` across `axis`.
    pub(super) fn is_in_plane(&self, edge: usize, axis: usize, at: usize) -> bool {
        let stride: usize = self.points[..axis].iter().product();
        edge % 3 != axis && edge / 3 / stride % self.points[axis] == at
    }
}

/// The lattice edge that runs from `sample` upwards along `axis`.
pub(super) fn edge_above(sample: usize, axis: usize) -> usize {
    3 * sample + axis
}

/// Directed sides of triangles in a block: bit `q` of `to[p]` for the side from `p` to `q`.
pub(super) struct Sides {
    to: [u64; EDGE_NAMES],
    /// Sides that two triangles use in the same direction.
    pub(super) over_used: usize,
}

impl Sides {
    pub(super) fn of(triangles: impl Iterator<Item = [usize; 3]>) -> Self {
        let mut sides = Self { to: [0; EDGE_NAMES], over_used: 0 };
        for [a, b, c] in triangles {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                sides.over_used += (sides.to[p] >> q & 1) as usize;
                sides.to[p] |= 1 << q;
            }
        }
        sides
    }

    /// The sides that no triangle uses in the opposite direction.
    pub(super) fn open(&self) -> impl Iterator<Item = [usize; 2]> {
        let sides = (0..EDGE_NAMES).flat_map(|p| (0..EDGE_NAMES).map(move |q| [p, q]));
        sides.filter(|&[p, q]| self.to[p] >> q & 1 > self.to[q] >> p & 1)
    }
}

//! Which points of a lattice are inside, and how a face of a cell is cut.

use super::CutEdge;
use isokit::marching_cubes::{Boundary, ExtractOptions, Nan};
use isokit::volume::{Sample, View};

/// A lattice of signs.
#[derive(Clone, Debug)]
pub struct Signs {
    points: [usize; 3],
    /// How far the first point lies before the first sample, on each axis.
    guard: usize,
    inside: Vec<bool>,
    /// Points of which no cell may make use.
    masked: Vec<bool>,
}

impl Signs {
    /// The signs of so many samples.
    pub fn new(dims: [usize; 3], inside: impl Fn([usize; 3]) -> bool) -> Self {
        let points = || (0..dims.iter().product()).map(|n| unravel(n, dims));
        let inside: Vec<bool> = points().map(inside).collect();
        Self { points: dims, guard: 0, masked: vec![false; inside.len()], inside }
    }

    /// The signs of a volume's values, as the options ask.
    pub fn of<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) -> Self {
        let mut signs = Self::new(view.dims(), |ijk| view.value(ijk) >= iso);
        if options.nan == Nan::Mask {
            signs = signs.without(|ijk| view.value(ijk).is_nan());
        }
        if options.boundary == Boundary::Closed { signs.closed() } else { signs }
    }

    /// The same with a layer of outside points all around.
    pub fn closed(&self) -> Self {
        let points = self.points.map(|n| n + 2);
        let held = |ijk: [usize; 3]| {
            let there = ijk.map(|i| i.wrapping_sub(1));
            (0..3).all(|k| there[k] < self.points[k]).then(|| self.number(there))
        };
        let mut closed = Self::new(points, |ijk| held(ijk).is_some_and(|n| self.inside[n]));
        closed.guard = self.guard + 1;
        for (n, masked) in closed.masked.iter_mut().enumerate() {
            *masked = held(unravel(n, points)).is_some_and(|n| self.masked[n]);
        }
        closed
    }

    /// The same without the cells that touch these points.
    pub fn without(mut self, masked: impl Fn([usize; 3]) -> bool) -> Self {
        for (n, mask) in self.masked.iter_mut().enumerate() {
            *mask |= masked(unravel(n, self.points));
        }
        self
    }

    /// The first corner of every cell, x fastest.
    pub(super) fn cells(&self) -> impl Iterator<Item = [usize; 3]> {
        let cells = self.points.map(|n| n.saturating_sub(1));
        (0..cells.iter().product()).map(move |n| unravel(n, cells))
    }

    /// The faces of a cell, each as its corners in counter-clockwise order seen from outside the cell.
    /// None for a cell that touches a masked point.
    pub(super) fn faces(&self, cell: [usize; 3]) -> Vec<[[usize; 3]; 4]> {
        let mut faces = vec![];
        for (axis, side) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let at = |u: usize, v: usize| {
                let mut corner = cell;
                corner[axis] += side;
                corner[(axis + 1) % 3] += u;
                corner[(axis + 2) % 3] += v;
                corner
            };
            let mut corners = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
            if side == 0 {
                corners.reverse();
            }
            faces.push(corners);
        }
        let is_masked = |corner: &[usize; 3]| self.masked[self.number(*corner)];
        if faces.iter().flatten().any(is_masked) {
            faces.clear();
        }
        faces
    }

    /// The cuts of a face: each run of inside corners is cut off, from the edge by which the walk around
    /// the face enters it to the edge by which the walk leaves it.
    pub(super) fn cuts(&self, corners: &[[usize; 3]; 4]) -> Vec<[CutEdge; 2]> {
        let inside = |i: usize| self.inside[self.number(corners[i % 4])];
        let edge = |i: usize| CutEdge::between(corners[i % 4], corners[(i + 1) % 4], self.guard);
        let enters = |i: usize| !inside(i) && inside(i + 1);
        let leaves = |i: &usize| inside(*i) && !inside(i + 1);
        let mut cuts = vec![];
        for entry in (0..4).filter(|&i| enters(i)) {
            let exit = (entry + 1..entry + 4).find(leaves).expect("what is entered is left");
            cuts.push([edge(entry), edge(exit)]);
        }
        cuts
    }

    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.points[0] * (j + self.points[1] * k)
    }
}

fn unravel(n: usize, [nx, ny, _]: [usize; 3]) -> [usize; 3] {
    [n % nx, n / nx % ny, n / nx / ny]
}

//! Which triangle is nearest, for sixteen points at once.
//!
//! Points that lie together go down a tree of boxes together: a box is opened if it can hold something nearer to any of
//! them. Boxes are compared in f32 and are a little too large for it, so that nothing is missed; distances are f64. There
//! is one text for all levels, and no fused multiply-add, so the bits are the same. What it is worth is measured by
//! `scripts/bench_fields`.

use crate::{
    Level,
    wide::{BATCH, Float, Mask, Task, Wide, run_at},
};

/// What the nearest of a triangle's points is found from.
///
/// Of a triangle without an area, or with so little that its normal means nothing, the three edges are all there is: its
/// `normal` and what `inside` says do not count, for `has_area` is false.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facet {
    /// A corner.
    pub corner: [f64; 3],
    /// Where the first edge leads from there, and the third.
    pub edges: [[f64; 3]; 2],
    /// One over the squared lengths of the first edge, the third and the one between them; 0 of an edge that has none.
    pub shares: [f64; 3],
    /// The unit normal.
    pub normal: [f64; 3],
    /// How much of each edge it takes to come below or above a point that is so far from the corner: scalar products.
    pub inside: [[f64; 3]; 2],
    /// Whether there is something between the edges.
    pub has_area: bool,
}

/// A box with what is in it: other boxes, or facets.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boxed {
    /// Least and greatest coordinates.
    pub sides: [[f32; 3]; 2],
    /// Of a box that holds facets, the first; else the second of two boxes, of which the first is the next in the list.
    pub first: u32,
    /// How many facets it holds; 0 if boxes.
    pub count: u32,
}

/// A tree of boxes with facets.
#[derive(Clone, Copy, Debug)]
pub struct BoxTree<'a> {
    /// The boxes; the first holds all others.
    pub boxes: &'a [Boxed],
    /// The facets.
    pub facets: &'a [Facet],
}

/// Points, and what is nearest to each.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Company {
    /// Where they are, along x, y, z.
    pub points: [[f64; BATCH]; 3],
    /// The squared distance to the nearest facet, or whatever nothing farther is looked for.
    pub squared: [f64; BATCH],
    /// Its number, or what was there.
    pub facet: [u32; BATCH],
}

/// Points that are asked about together.
pub const COMPANY: usize = BATCH;

/// Boxes on the way that wait to be opened; no tree may be deeper.
pub const DEEPEST: usize = 96;

/// By how much squared distances to boxes may be wrong, relative to them, beside what boxes are too large: f32 rounds a point
/// that is far from them, the difference, and the square.
const SLACK: f32 = 1.0 + 1.0 / (1 << 19) as f32;

impl BoxTree<'_> {
    /// Looks below some boxes for facets that are nearer to any of the points than what is known, after some facets that are
    /// likely to be near.
    ///
    /// # Panics
    ///
    /// If the tree names what is not there, or is deeper than [`DEEPEST`].
    #[inline]
    pub fn find(&self, roots: &[u32], likely: &[u32], company: &mut Company) {
        self.find_at(Level::current(), roots, likely, company);
    }

    fn find_at(&self, level: Level, roots: &[u32], likely: &[u32], company: &mut Company) {
        run_at(level, Find { tree: self, roots, likely, company });
    }
}

struct Find<'b, 'a> {
    tree: &'b BoxTree<'a>,
    roots: &'b [u32],
    likely: &'b [u32],
    company: &'b mut Company,
}

impl Task for Find<'_, '_> {
    #[inline(always)]
    fn run<W: Wide>(self, wide: W) {
        let Self { tree: BoxTree { boxes, facets }, roots, likely, company } = self;
        let points = company.points;
        let p: [W::F64; 3] = points.each_ref().map(|axis| wide.load_f64(axis));
        let q = p.map(|axis| wide.f64_to_f32(axis));
        let mut best = wide.load_f64(&company.squared);
        let mut which = wide.load(&company.facet);
        for &facet in likely {
            (best, which) = nearer(wide, p, &facets[facet as usize], facet, best, which);
        }
        let mut reach = wide.f64_to_f32(best) * wide.f32(SLACK);
        let mut waiting = [0; DEEPEST];
        for &root in roots {
            waiting[0] = root;
            let mut left = 1;
            while left > 0 {
                left -= 1;
                let at = waiting[left];
                let node = &boxes[at as usize];
                let beside = squared_to_box(wide, q, node);
                if (!reach.less(beside)).bits() == 0 {
                    continue;
                }
                if node.count > 0 {
                    for facet in node.first..node.first + node.count {
                        (best, which) =
                            nearer(wide, p, &facets[facet as usize], facet, best, which);
                    }
                    reach = wide.f64_to_f32(best) * wide.f32(SLACK);
                } else {
                    let [a, b] = [at + 1, node.first];
                    let is_first_nearer = is_nearer(
                        [0, 1, 2].map(|k| points[k][BATCH / 2] as f32),
                        &boxes[a as usize],
                        &boxes[b as usize],
                    );
                    let [near, far] = if is_first_nearer { [a, b] } else { [b, a] };
                    waiting[left] = far;
                    waiting[left + 1] = near;
                    left += 2;
                }
            }
        }
        wide.store_f64(best, &mut company.squared);
        company.facet = wide.store(which);
    }
}

/// Whether the middle of the first box is nearer, along the axis on which the two are farther apart.
#[inline(always)]
fn is_nearer(point: [f32; 3], a: &Boxed, b: &Boxed) -> bool {
    let mut sum = 0.0;
    for k in 0..3 {
        let [low, high] = [a, b].map(|node| node.sides[0][k] + node.sides[1][k]);
        sum += (high - low) * (4.0 * point[k] - low - high);
    }
    sum < 0.0
}

#[inline(always)]
fn squared_to_box<W: Wide>(wide: W, point: [W::F32; 3], node: &Boxed) -> W::F32 {
    let zero = wide.f32(0.0);
    let beside = |k: usize| {
        let (low, high) = (wide.f32(node.sides[0][k]), wide.f32(node.sides[1][k]));
        (low - point[k]).max(point[k] - high).max(zero)
    };
    let [x, y, z] = [beside(0), beside(1), beside(2)];
    x * x + y * y + z * z
}

/// The nearest so far, once a facet was looked at.
#[inline(always)]
fn nearer<W: Wide>(
    wide: W,
    point: [W::F64; 3],
    facet: &Facet,
    number: u32,
    best: W::F64,
    which: W::U32,
) -> (W::F64, W::U32) {
    let found = squared_to_facet(wide, point, facet);
    let is_nearer = found.less(best);
    (wide.select_f64(is_nearer, found, best), wide.select(is_nearer, wide.u32(number), which))
}

/// The least of the distances to the three edges and, above and below it, to the plane.
#[inline(always)]
fn squared_to_facet<W: Wide>(wide: W, point: [W::F64; 3], facet: &Facet) -> W::F64 {
    let (zero, one) = (wide.f64(0.0), wide.f64(1.0));
    let Facet { corner, edges: [first, third], shares, normal, inside, has_area } = facet;
    let v: [W::F64; 3] = [0, 1, 2].map(|k| point[k] - wide.f64(corner[k]));
    let across: [f64; 3] = [0, 1, 2].map(|k| third[k] - first[k]);
    let to_edge = |from: [W::F64; 3], edge: &[f64; 3], share: f64| {
        let along = (product(wide, from, edge) * wide.f64(share)).max(zero).min(one);
        let [x, y, z] = [0, 1, 2].map(|k| from[k] - along * wide.f64(edge[k]));
        x * x + y * y + z * z
    };
    let w = [0, 1, 2].map(|k| v[k] - wide.f64(first[k]));
    let least = to_edge(v, first, shares[0]).min(to_edge(v, third, shares[1]));
    let least = least.min(to_edge(w, &across, shares[2]));
    if !has_area {
        return least;
    }
    let [a, b] = [product(wide, v, &inside[0]), product(wide, v, &inside[1])];
    let beside = a.less(zero) | b.less(zero) | one.less(a + b);
    let height = product(wide, v, normal);
    wide.select_f64(beside, least, height * height)
}

#[inline(always)]
fn product<W: Wide>(wide: W, v: [W::F64; 3], of: &[f64; 3]) -> W::F64 {
    v[0] * wide.f64(of[0]) + v[1] * wide.f64(of[1]) + v[2] * wide.f64(of[2])
}

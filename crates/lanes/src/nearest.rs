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
    /// Its number, the lowest of those that are as near; or what was there.
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
        let p = [wide.load_f64(&points[0]), wide.load_f64(&points[1]), wide.load_f64(&points[2])];
        let q = [wide.f64_to_f32(p[0]), wide.f64_to_f32(p[1]), wide.f64_to_f32(p[2])];
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
                    let middle = BATCH / 2;
                    let point = [
                        points[0][middle] as f32,
                        points[1][middle] as f32,
                        points[2][middle] as f32,
                    ];
                    let is_first_nearer = is_nearer(point, &boxes[a as usize], &boxes[b as usize]);
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
    for (k, point) in point.into_iter().enumerate() {
        let low = a.sides[0][k] + a.sides[1][k];
        let high = b.sides[0][k] + b.sides[1][k];
        sum += (high - low) * (4.0 * point - low - high);
    }
    sum < 0.0
}

#[inline(always)]
fn squared_to_box<W: Wide>(wide: W, point: [W::F32; 3], node: &Boxed) -> W::F32 {
    let [low, high] = &node.sides;
    let x = beside(wide, point[0], low[0], high[0]);
    let y = beside(wide, point[1], low[1], high[1]);
    let z = beside(wide, point[2], low[2], high[2]);
    x * x + y * y + z * z
}

#[inline(always)]
fn beside<W: Wide>(wide: W, point: W::F32, low: f32, high: f32) -> W::F32 {
    (wide.f32(low) - point).max(point - wide.f32(high)).max(wide.f32(0.0))
}

/// The nearest so far, once a facet was looked at; of those that are as near the one of the lowest number, in whatever order
/// they come.
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
    let is_no_farther = !best.less(found) & found.less(wide.f64(f64::INFINITY));
    let is_nearer = is_no_farther & (found.less(best) | wide.less(wide.u32(number), which));
    (wide.select_f64(is_nearer, found, best), wide.select(is_nearer, wide.u32(number), which))
}

/// The least of the distances to the three edges and, above and below it, to the plane.
#[inline(always)]
fn squared_to_facet<W: Wide>(wide: W, point: [W::F64; 3], facet: &Facet) -> W::F64 {
    let (zero, one) = (wide.f64(0.0), wide.f64(1.0));
    let Facet { corner, edges: [first, third], shares, normal, inside, has_area } = facet;
    let v = from(wide, point, corner);
    let across = [third[0] - first[0], third[1] - first[1], third[2] - first[2]];
    let least = squared_to_edge(wide, v, first, shares[0]);
    let least = least.min(squared_to_edge(wide, v, third, shares[1]));
    let least = least.min(squared_to_edge(wide, from(wide, v, first), &across, shares[2]));
    if !has_area {
        return least;
    }
    let (a, b) = (product(wide, v, &inside[0]), product(wide, v, &inside[1]));
    let beside = a.less(zero) | b.less(zero) | one.less(a + b);
    let height = product(wide, v, normal);
    wide.select_f64(beside, least, height * height)
}

#[inline(always)]
fn squared_to_edge<W: Wide>(wide: W, v: [W::F64; 3], edge: &[f64; 3], share: f64) -> W::F64 {
    let along = product(wide, v, edge) * wide.f64(share);
    let along = along.max(wide.f64(0.0)).min(wide.f64(1.0));
    let x = v[0] - along * wide.f64(edge[0]);
    let y = v[1] - along * wide.f64(edge[1]);
    let z = v[2] - along * wide.f64(edge[2]);
    x * x + y * y + z * z
}

#[inline(always)]
fn from<W: Wide>(wide: W, v: [W::F64; 3], start: &[f64; 3]) -> [W::F64; 3] {
    [v[0] - wide.f64(start[0]), v[1] - wide.f64(start[1]), v[2] - wide.f64(start[2])]
}

#[inline(always)]
fn product<W: Wide>(wide: W, v: [W::F64; 3], of: &[f64; 3]) -> W::F64 {
    v[0] * wide.f64(of[0]) + v[1] * wide.f64(of[1]) + v[2] * wide.f64(of[2])
}

#[cfg(test)]
mod tests {
    use super::{BoxTree, Boxed, COMPANY, Company, Facet};
    use crate::{Level, vertices::tests::Chance};

    #[test]
    fn every_level_finds_the_same_and_what_one_by_one_is_nearest() {
        let mut chance = Chance(21);
        let mut number = || f64::from(chance.below(1000)) / 1000.0 - 0.5;
        for round in 0..200 {
            // Edges alone: two short ones, and the plane between them if it has a normal along z.
            let facets: Vec<Facet> = (0..4)
                .map(|n| Facet {
                    corner: [number(), number(), number()],
                    edges: [[0.25, 0.0, 0.0], [0.0, 0.5, 0.0]],
                    shares: [16.0, 4.0, 3.2],
                    normal: [0.0, 0.0, 1.0],
                    inside: [[4.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
                    has_area: n % 2 == 0,
                })
                .collect();
            let sides = [[-1.0_f32; 3], [1.0; 3]];
            let boxes = [
                Boxed { sides, first: 2, count: 0 },
                Boxed { sides, first: 0, count: 2 },
                Boxed { sides, first: 2, count: 2 },
            ];
            let tree = BoxTree { boxes: &boxes, facets: &facets };
            let points = [(); 3].map(|()| [(); COMPANY].map(|()| 2.0 * number()));
            let company = Company {
                points,
                squared: [if round % 3 == 0 { 0.1 } else { f64::INFINITY }; COMPANY],
                facet: [u32::MAX; COMPANY],
            };
            let found = |level, likely: &[u32], roots: &[u32]| {
                let mut company = company;
                tree.find_at(level, roots, likely, &mut company);
                company
            };
            let plain = found(Level::Portable, &[], &[0]);
            for &level in Level::available() {
                assert_eq!(found(level, &[], &[0]), plain, "{level}");
                assert_eq!(found(level, &[3, 1], &[2, 1]), plain);
            }
            for lane in 0..COMPANY {
                let facet = plain.facet[lane];
                let near = |facet: u32| found(Level::Portable, &[facet], &[]).squared[lane];
                let least = (0..4).map(near).fold(f64::INFINITY, f64::min);
                assert_eq!(plain.squared[lane], least);
                let lowest = (0..4).find(|&facet| near(facet) == least).unwrap();
                assert!(facet == u32::MAX || facet == lowest, "{facet}, {lowest}");
            }
        }
    }
}

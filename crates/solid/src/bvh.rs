//! Boxes around triangles, and boxes around those.
//!
//! A binary tree, built from the top: triangles are parted where the areas of the two boxes, each times its triangles, add
//! up to least among some planes (surface area heuristic with bins, Wald 2007, "On fast construction of SAH-based bounding
//! volume hierarchies"). Parts are built side by side. How many threads do it changes nothing: where a part is divided
//! depends on the part alone.

use crate::distance::facet;
use isokit_geom::Aabb;
use isokit_lanes::{BoxTree, Boxed, DEEPEST, Facet};

/// A tree over triangles.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    boxes: Vec<Boxed>,
    facets: Vec<Facet>,
    /// Which triangle each facet is.
    triangles: Vec<u32>,
}

/// Triangles that are not divided further.
const FEW: usize = 2;

/// Planes that are tried along each axis, and one more part than that.
const BINS: usize = 16;

/// Triangles that one thread divides by itself.
const ALONE: usize = 4096;

/// So deep in the tree triangles are parted into halves, whatever it costs: 2³² of them are in single ones 32 steps below.
const HALVES_FROM: u32 = 60;

/// One ulp of f32 around 1, eight times: what boxes are larger by, as a part of the largest coordinate. Rounding of a box
/// and of a point that is not farther out than twice that coordinate is less.
const MARGIN: f64 = 1e-6;

#[derive(Clone, Copy, Debug)]
struct Item {
    low: [f64; 3],
    high: [f64; 3],
    triangle: u32,
}

impl Item {
    fn middle(&self, axis: usize) -> f64 {
        0.5 * self.low[axis] + 0.5 * self.high[axis]
    }
}

impl Bvh {
    /// Of triangles with finite corners.
    ///
    /// # Panics
    ///
    /// If there are none, or more than 2³¹.
    pub(crate) fn new(triangles: &[[[f64; 3]; 3]]) -> Self {
        assert!((1..1 << 31).contains(&triangles.len()), "{} triangles", triangles.len());
        let item = |(n, corners): (usize, &[[f64; 3]; 3])| {
            let mut around = Aabb { min: corners[0], max: corners[0] };
            corners.iter().for_each(|&corner| around = around.with(corner));
            Item { low: around.min, high: around.max, triangle: n as u32 }
        };
        let mut items: Vec<Item> = triangles.iter().enumerate().map(item).collect();
        let reach = triangles.as_flattened().as_flattened().iter();
        let margin = MARGIN * reach.fold(0.0_f64, |most, c| most.max(c.abs()));
        let boxes = divide(&mut items, 0, 0, margin);
        let facets = items.iter().map(|item| facet(triangles[item.triangle as usize])).collect();
        Self { boxes, facets, triangles: items.iter().map(|item| item.triangle).collect() }
    }

    /// The tree for sixteen points at once.
    pub(crate) fn tree(&self) -> BoxTree<'_> {
        BoxTree { boxes: &self.boxes, facets: &self.facets }
    }

    /// The boxes, each before those in it.
    pub(crate) fn boxes(&self) -> &[Boxed] {
        &self.boxes
    }

    /// The triangles as facets, in the order in which boxes hold them.
    pub(crate) fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Which triangle each facet is.
    pub(crate) fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// The two boxes in a box, or the facets.
    pub(crate) fn below(&self, at: usize) -> Below {
        let node = &self.boxes[at];
        match node.count {
            0 => Below::Boxes([at + 1, node.first as usize]),
            count => Below::Facets(node.first as usize..(node.first + count) as usize),
        }
    }

    /// Calls back for facets until none that was not seen is nearer than the callback said last, as a squared distance.
    pub(crate) fn visit(&self, point: [f64; 3], within: f64, mut look: impl FnMut(u32) -> f64) {
        let (mut within, mut waiting) = (within, [(0_u32, 0.0); DEEPEST]);
        let mut left = 1;
        while left > 0 {
            left -= 1;
            let (at, beside) = waiting[left];
            if beside > within {
                continue;
            }
            match self.below(at as usize) {
                Below::Facets(facets) => {
                    for facet in facets {
                        within = look(facet as u32);
                    }
                }
                Below::Boxes(two) => {
                    let [a, b] = two.map(|at| (at as u32, squared_to_box(point, &self.boxes[at])));
                    let [near, far] = if a.1 <= b.1 { [a, b] } else { [b, a] };
                    (waiting[left], waiting[left + 1]) = (far, near);
                    left += 2;
                }
            }
        }
    }
}

/// What is in a box.
#[derive(Clone, Debug)]
pub(crate) enum Below {
    Boxes([usize; 2]),
    Facets(std::ops::Range<usize>),
}

/// No more than the squared distance to what is in a box: it is larger than that, by more than is rounded here.
pub(crate) fn squared_to_box(point: [f64; 3], node: &Boxed) -> f64 {
    let [low, high] = node.sides;
    let beside = [0, 1, 2]
        .map(|k| (f64::from(low[k]) - point[k]).max(point[k] - f64::from(high[k])).max(0.0));
    beside[0] * beside[0] + beside[1] * beside[1] + beside[2] * beside[2]
}

/// The boxes of some items, which come into their order; `first` is how many items are before them.
fn divide(items: &mut [Item], first: usize, depth: u32, margin: f64) -> Vec<Boxed> {
    let mut boxes = vec![around(items, margin)];
    if items.len() <= FEW {
        boxes[0].first = first as u32;
        boxes[0].count = items.len() as u32;
        return boxes;
    }
    let middle = part(items, depth);
    let is_large = items.len() > ALONE;
    let (low, high) = items.split_at_mut(middle);
    let (below, deeper) = (first + middle, depth + 1);
    let (mut a, mut b) = match is_large {
        true => rayon::join(
            || divide(low, first, deeper, margin),
            || divide(high, below, deeper, margin),
        ),
        false => (divide(low, first, deeper, margin), divide(high, below, deeper, margin)),
    };
    // Numbers of boxes count from the first of their list.
    let shift = |all: &mut [Boxed], by: usize| {
        all.iter_mut().filter(|node| node.count == 0).for_each(|node| node.first += by as u32);
    };
    shift(&mut a, 1);
    shift(&mut b, 1 + a.len());
    boxes[0].first = 1 + a.len() as u32;
    boxes.append(&mut a);
    boxes.append(&mut b);
    boxes
}

/// The box, a little larger than what is in it.
fn around(items: &[Item], margin: f64) -> Boxed {
    let low = |k: usize| items.iter().fold(f64::INFINITY, |least, item| least.min(item.low[k]));
    let high = |k: usize| items.iter().fold(-f64::INFINITY, |most, item| most.max(item.high[k]));
    let low = [0, 1, 2].map(|k| (low(k) - margin) as f32);
    let high = [0, 1, 2].map(|k| (high(k) + margin) as f32);
    Boxed { sides: [low, high], first: 0, count: 0 }
}

/// Brings those of one part before those of the other, and says how many these are: not none, not all.
fn part(items: &mut [Item], depth: u32) -> usize {
    let half = items.len() / 2;
    if depth >= HALVES_FROM {
        return half;
    }
    let Some((axis, plane, [low, scale])) = best_plane(items) else {
        return half;
    };
    let is_low = |item: &Item| bin(item, axis, low, scale) < plane;
    // Each side in the order that it had: the same for any run.
    let high: Vec<Item> = items.iter().copied().filter(|item| !is_low(item)).collect();
    let mut count = 0;
    for n in 0..items.len() {
        if is_low(&items[n]) {
            items[count] = items[n];
            count += 1;
        }
    }
    items[count..].copy_from_slice(&high);
    count
}

fn bin(item: &Item, axis: usize, low: f64, scale: f64) -> usize {
    (((item.middle(axis) - low) * scale) as usize).min(BINS - 1)
}

/// The axis and the first bin of the higher part, and how bins are found; none if all middles are in one place.
fn best_plane(items: &[Item]) -> Option<(usize, usize, [f64; 2])> {
    let mut best = None;
    let mut least = f64::INFINITY;
    for axis in 0..3 {
        let middles = items.iter().map(|item| item.middle(axis));
        let (low, high) = middles
            .fold((f64::INFINITY, -f64::INFINITY), |(low, high), c| (low.min(c), high.max(c)));
        let scale = BINS as f64 / (high - low);
        if !scale.is_finite() {
            continue;
        }
        let mut bins = [Bin::EMPTY; BINS];
        items.iter().for_each(|item| bins[bin(item, axis, low, scale)].add(item));
        let mut above = [Bin::EMPTY; BINS];
        for n in (1..BINS).rev() {
            above[n - 1] = above[n].with(&bins[n]);
        }
        let mut below = Bin::EMPTY;
        for plane in 1..BINS {
            below = below.with(&bins[plane - 1]);
            let high = &above[plane - 1];
            let cost = below.cost() + high.cost();
            if below.count > 0 && high.count > 0 && cost < least {
                (least, best) = (cost, Some((axis, plane, [low, scale])));
            }
        }
    }
    best
}

/// What lies between two planes.
#[derive(Clone, Copy, Debug)]
struct Bin {
    low: [f64; 3],
    high: [f64; 3],
    count: usize,
}

impl Bin {
    const EMPTY: Self = Self { low: [f64::INFINITY; 3], high: [-f64::INFINITY; 3], count: 0 };

    fn add(&mut self, item: &Item) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(item.low[k]);
            self.high[k] = self.high[k].max(item.high[k]);
        }
        self.count += 1;
    }

    fn with(mut self, other: &Self) -> Self {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
        self.count += other.count;
        self
    }

    /// Half the area of the box, for each that is in it.
    fn cost(&self) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|k| self.high[k] - self.low[k]);
        (x * y + y * z + z * x) * self.count as f64
    }
}

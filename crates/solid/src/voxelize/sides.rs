//! On which side of the surface samples are.
//!
//! Balls around two samples, as large as their distances, hold nothing of the surface. So where the distances of neighbours
//! add up to more than the step between them, the step does not cross it. Along such steps the winding number of a closed
//! surface does not change, and that of an open one no faster than beside its edges (`Rim`). It is asked once for all that
//! are joined by them, and again for parts of a block where it may come past a half between.

use super::{Lattice, farthest};
use isokit_geom::{Affine, vector::length};

/// A block of samples; distances get their sign.
pub(super) struct Sides<'a> {
    lattice: &'a Lattice<'a>,
    from: [usize; 3],
    size: [usize; 3],
    distances: &'a mut [f64],
    is_decided: Vec<bool>,
    /// World units between neighbours, a little more.
    steps: [f64; 3],
    /// Steps along more than one axis, and how long they are.
    diagonals: Vec<([isize; 3], f64)>,
}

/// By how much distances and steps may be wrong.
const SLACK: f64 = 1.0 + 1e-9;

/// Samples that are joined.
struct Region {
    members: Vec<[usize; 3]>,
    /// The one that is farthest from the surface.
    deepest: [usize; 3],
    /// No more steps than this from it to another.
    steps: usize,
    /// Whether there are samples that only a diagonal leads to.
    has_diagonals: bool,
}

impl Region {
    fn is_single(&self) -> bool {
        self.members.len() == 1
    }
}

/// All steps to neighbours that are along two axes or three, and how long they are, a little more.
fn diagonals(index_to_world: &Affine) -> Vec<([isize; 3], f64)> {
    let all = (0..27).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]);
    let all = all.filter(|step| step.iter().filter(|&&along| along != 0).count() > 1);
    let long = |step: [isize; 3]| length(index_to_world.vector(step.map(|along| along as f64)));
    all.map(|step| (step, long(step) * SLACK)).collect()
}

impl<'a> Sides<'a> {
    /// Of distances without a sign.
    pub(super) fn new(
        lattice: &'a Lattice<'a>,
        from: [usize; 3],
        size: [usize; 3],
        distances: &'a mut [f64],
    ) -> Self {
        let steps = lattice.index_to_world.spacing().map(|step| step * SLACK);
        // What is on the surface is inside.
        let is_decided = distances.iter().map(|&distance| distance == 0.0).collect();
        let diagonals = diagonals(&lattice.index_to_world);
        Self { lattice, from, size, distances, is_decided, steps, diagonals }
    }

    /// Gives outer ones a sign.
    pub(super) fn decide(mut self) {
        self.decide_part([0; 3], self.size);
    }

    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.size[1] + j) * self.size[0] + i
    }

    fn distance(&self, ijk: [usize; 3]) -> f64 {
        self.distances[self.number(ijk)].abs()
    }

    fn point(&self, ijk: [usize; 3]) -> [f64; 3] {
        self.lattice.point([0, 1, 2].map(|k| self.from[k] + ijk[k]))
    }

    fn set(&mut self, ijk: [usize; 3], is_inside: bool) {
        let n = self.number(ijk);
        if !self.is_decided[n] {
            self.is_decided[n] = true;
            if !is_inside {
                self.distances[n] = -self.distances[n];
            }
        }
    }

    fn decide_part(&mut self, low: [usize; 3], size: [usize; 3]) {
        if self.all(low, size).all(|ijk| self.is_decided[self.number(ijk)]) {
            return;
        }
        if size == [1; 3] {
            let is_inside = self.lattice.solid.is_in(self.point(low));
            self.set(low, is_inside);
            return;
        }
        if self.decide_at_once(low, size) {
            return;
        }
        let mut is_whole = true;
        let mut regions = self.regions(low, size);
        self.join_single_ones(&mut regions, low, size);
        for region in regions {
            match self.is_inside(&region, size) {
                Some(is_inside) => {
                    region.members.into_iter().for_each(|ijk| self.set(ijk, is_inside));
                }
                None => is_whole = false,
            }
        }
        if is_whole {
            return;
        }
        let cut = size.map(|n| n.div_ceil(2));
        for part in 0..8 {
            let is_high = [0, 1, 2].map(|k| part >> k & 1 == 1);
            let first = [0, 1, 2].map(|k| if is_high[k] { low[k] + cut[k] } else { low[k] });
            let of = [0, 1, 2].map(|k| if is_high[k] { size[k] - cut[k] } else { cut[k] });
            if of.iter().all(|&n| n > 0) {
                self.decide_part(first, of);
            }
        }
    }

    /// If the surface is so far that none of it is between samples.
    fn decide_at_once(&mut self, low: [usize; 3], size: [usize; 3]) -> bool {
        let middle = [0, 1, 2].map(|k| low[k] + size[k] / 2);
        let reach = size.map(|n| (n / 2).max(n - 1 - n / 2) as f64);
        let radius = farthest(&self.lattice.index_to_world, reach) * SLACK;
        if self.distance(middle) <= radius {
            return false;
        }
        let Some(is_inside) = self.is_inside_near(middle, radius, radius) else { return false };
        let all: Vec<_> = self.all(low, size).collect();
        all.into_iter().for_each(|ijk| self.set(ijk, is_inside));
        true
    }

    /// Joins samples that are alone to others by steps along diagonals.
    ///
    /// Beside a surface that is oblique to the axes a step along one of them hardly leads away from it.
    fn join_single_ones(&self, regions: &mut Vec<Region>, low: [usize; 3], size: [usize; 3]) {
        let place = |at: [usize; 3]| {
            let [i, j, k] = [0, 1, 2].map(|axis| at[axis] - low[axis]);
            (k * size[1] + j) * size[0] + i
        };
        let mut owners = vec![usize::MAX; size.iter().product()];
        for (n, region) in regions.iter().enumerate().filter(|(_, region)| !region.is_single()) {
            region.members.iter().for_each(|&at| owners[place(at)] = n);
        }
        for n in 0..regions.len() {
            if !regions[n].is_single() {
                continue;
            }
            let at = regions[n].deepest;
            let distance = self.distance(at);
            let owner = self.diagonals.iter().find_map(|&(step, long)| {
                let beside = [0, 1, 2].map(|axis| at[axis].wrapping_add_signed(step[axis]));
                let is_here = |axis: usize| beside[axis].wrapping_sub(low[axis]) < size[axis];
                let is_joined = (0..3).all(is_here) && distance + self.distance(beside) > long;
                let owner = if is_joined { owners[place(beside)] } else { usize::MAX };
                (owner != usize::MAX).then_some(owner)
            });
            if let Some(owner) = owner {
                regions[n].members.clear();
                regions[owner].members.push(at);
                regions[owner].has_diagonals = true;
            }
        }
        regions.retain(|region| !region.members.is_empty());
        // A diagonal is no longer than a step along each axis.
        for region in regions.iter_mut().filter(|region| region.has_diagonals) {
            region.steps += 3;
        }
    }

    /// Which side all are on that ways in a ball around a sample lead to, if it is one.
    fn is_inside_near(&self, ijk: [usize; 3], radius: f64, way: f64) -> Option<bool> {
        let (solid, point) = (self.lattice.solid, self.point(ijk));
        let scale = solid.place().scale();
        let change = solid.change(point, radius / scale, way / scale);
        solid.is_in_by(point, change)
    }

    fn is_inside(&self, region: &Region, size: [usize; 3]) -> Option<bool> {
        let solid = self.lattice.solid;
        if solid.is_closed() || region.is_single() {
            return Some(solid.is_in(self.point(region.deepest)));
        }
        let radius = farthest(&self.lattice.index_to_world, size.map(|n| (n - 1) as f64)) * SLACK;
        let longest = self.steps.into_iter().fold(0.0, f64::max);
        self.is_inside_near(region.deepest, radius, region.steps as f64 * longest)
    }

    /// All samples of a part.
    fn all(&self, low: [usize; 3], size: [usize; 3]) -> impl Iterator<Item = [usize; 3]> + use<> {
        let row = move |k, j| (0..size[0]).map(move |i| [low[0] + i, low[1] + j, low[2] + k]);
        (0..size[2]).flat_map(move |k| (0..size[1]).flat_map(move |j| row(k, j)))
    }

    /// What is joined in a part, of samples that are not decided.
    fn regions(&self, low: [usize; 3], size: [usize; 3]) -> Vec<Region> {
        let mut is_seen = self.is_decided.clone();
        let mut regions = vec![];
        for start in self.all(low, size) {
            if is_seen[self.number(start)] {
                continue;
            }
            is_seen[self.number(start)] = true;
            let mut region =
                Region { members: vec![start], deepest: start, steps: 0, has_diagonals: false };
            let (mut next, mut round_ends) = (0, 1);
            while next < region.members.len() {
                if next == round_ends {
                    region.steps += 2; // from the deepest to the start and from there on
                    round_ends = region.members.len();
                }
                let at = region.members[next];
                next += 1;
                let distance = self.distance(at);
                if distance > self.distance(region.deepest) {
                    region.deepest = at;
                }
                for axis in 0..3 {
                    for up in [false, true] {
                        let mut beside = at;
                        match up {
                            true if at[axis] + 1 < low[axis] + size[axis] => beside[axis] += 1,
                            false if at[axis] > low[axis] => beside[axis] -= 1,
                            _ => continue,
                        }
                        let n = self.number(beside);
                        if !is_seen[n] && distance + self.distances[n].abs() > self.steps[axis] {
                            is_seen[n] = true;
                            region.members.push(beside);
                        }
                    }
                }
            }
            regions.push(region);
        }
        regions
    }
}

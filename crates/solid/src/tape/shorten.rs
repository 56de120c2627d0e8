//! Fewer steps for a box: operands that nowhere there have a say are left out.

use super::{Binary, Range, Step, Tape};

impl Tape {
    /// The steps that the last one needs.
    pub(super) fn ending(steps: Vec<Step>) -> Self {
        let identity: Vec<u32> = (0..steps.len() as u32).collect();
        Self::kept(&steps, &identity, steps.len() - 1)
    }

    /// The same function in a box with fewer steps; none if there are no fewer. Values there are the same to the bit.
    pub(crate) fn shortened(&self, inside: [Range; 3]) -> Option<Self> {
        let ranges = self.ranges(inside);
        let steps = &self.steps;
        // For each step the one that makes the same number in the box.
        let mut same: Vec<u32> = Vec::with_capacity(steps.len());
        for (n, step) in steps.iter().enumerate() {
            let of = match *step {
                Step::Binary(code @ (Binary::Min | Binary::Max), a, b) => {
                    match ranges[a as usize].wins(code, ranges[b as usize]) {
                        Some(true) => same[a as usize],
                        Some(false) => same[b as usize],
                        None => n as u32,
                    }
                }
                _ => n as u32,
            };
            same.push(of);
        }
        let last = same[steps.len() - 1] as usize;
        let shorter = Self::kept(steps, &same, last);
        (shorter.len() < self.len()).then_some(shorter)
    }

    /// The steps that `last` needs, each of the steps that stand for those it names.
    fn kept(steps: &[Step], same: &[u32], last: usize) -> Self {
        let mut needed = vec![false; last + 1];
        needed[last] = true;
        for n in (0..=last).rev() {
            if needed[n] {
                steps[n].needs().for_each(|a| needed[same[a as usize] as usize] = true);
            }
        }
        let mut names = vec![0; last + 1];
        let mut kept = Vec::new();
        for n in (0..=last).filter(|&n| needed[n]) {
            names[n] = kept.len() as u32;
            kept.push(steps[n].renamed(|a| names[same[a as usize] as usize]));
        }
        Self { steps: kept }
    }
}

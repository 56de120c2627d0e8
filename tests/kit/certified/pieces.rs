//! What hangs together: disjoint sets of numbers.

/// Disjoint sets.
#[derive(Debug)]
pub(super) struct Pieces {
    parents: Vec<usize>,
}

impl Pieces {
    /// So many numbers, each alone.
    pub(super) fn new(count: usize) -> Self {
        Self { parents: (0..count).collect() }
    }

    /// The number that stands for the set of `n`.
    pub(super) fn root(&mut self, mut n: usize) -> usize {
        while self.parents[n] != n {
            self.parents[n] = self.parents[self.parents[n]];
            n = self.parents[n];
        }
        n
    }

    /// Makes one set of two.
    pub(super) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.parents[a.max(b)] = a.min(b);
    }
}

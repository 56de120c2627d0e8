//! What is added up or counted chunk by chunk, the same for any number of threads.

/// A sum that carries along what each addition rounds off (Neumaier): as if made in twice the precision.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sum {
    value: f64,
    lost: f64,
}

impl Sum {
    /// Adds one number.
    #[inline]
    pub(crate) fn add(&mut self, x: f64) {
        let sum = self.value + x;
        let (large, small) =
            if self.value.abs() >= x.abs() { (self.value, x) } else { (x, self.value) };
        self.lost += (large - sum) + small;
        self.value = sum;
    }

    /// Adds another sum.
    pub(crate) fn join(&mut self, other: Self) {
        self.add(other.value);
        self.lost += other.lost;
    }

    /// The sum, rounded once.
    pub(crate) fn total(self) -> f64 {
        self.value + self.lost
    }
}

/// Something that is counted for each label, where neighbours mostly have the same label.
#[derive(Clone, Debug)]
pub(crate) struct Tallies<T>(Vec<(u32, T)>);

impl<T: Default> Tallies<T> {
    /// Nothing counted.
    pub(crate) fn new() -> Self {
        Self(vec![])
    }

    /// The tally of `label`, to add to.
    #[inline]
    pub(crate) fn of(&mut self, label: u32) -> &mut T {
        if self.0.last().is_none_or(|last| last.0 != label) {
            self.0.push((label, T::default()));
        }
        let last = self.0.len() - 1;
        &mut self.0[last].1
    }

    /// Hands the tallies out, in the order in which they were made: a label may come several times.
    pub(crate) fn each(self) -> impl Iterator<Item = (usize, T)> {
        self.0.into_iter().map(|(label, tally)| (label as usize, tally))
    }
}

#[cfg(test)]
mod tests {
    use super::Sum;

    #[test]
    fn a_sum_forgets_nothing_that_cancels() {
        let mut sum = Sum::default();
        for x in [1.0, 1e100, 1.0, -1e100] {
            sum.add(x);
        }
        assert_eq!(sum.total(), 2.0);
    }
}

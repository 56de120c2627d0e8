//! Whole numbers of any length, for the few signs that nothing shorter can tell.
//!
//! A sign and digits of 32 bits, the least first and the greatest not 0. Schoolbook sums and products:
//! the longest operands, of cells that hold both the greatest and the least f64, have some 260 digits.

use std::cmp::Ordering;

/// A whole number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Long {
    is_negative: bool,
    digits: Vec<u32>,
}

impl Long {
    pub(super) const ZERO: Self = Self { is_negative: false, digits: vec![] };

    /// `magnitude · 2^shift`, or its negative.
    pub(super) fn new(is_negative: bool, magnitude: u64, shift: usize) -> Self {
        let mut digits = vec![0; shift / 32];
        let shifted = u128::from(magnitude) << (shift % 32);
        digits.extend((0..3).map(|n| (shifted >> (32 * n)) as u32));
        Self { is_negative, digits }.trimmed()
    }

    /// How it compares with 0.
    pub(super) fn compare_with_zero(&self) -> Ordering {
        match (self.digits.is_empty(), self.is_negative) {
            (true, _) => Ordering::Equal,
            (_, true) => Ordering::Less,
            (_, false) => Ordering::Greater,
        }
    }

    pub(super) fn negative(&self) -> Self {
        Self { is_negative: !self.is_negative, digits: self.digits.clone() }
    }

    pub(super) fn sum(&self, other: &Self) -> Self {
        if self.is_negative == other.is_negative {
            let digits = sum(&self.digits, &other.digits);
            return Self { is_negative: self.is_negative, digits }.trimmed();
        }
        let (large, small) = match compare(&self.digits, &other.digits) {
            Ordering::Less => (other, self),
            _ => (self, other),
        };
        let digits = difference(&large.digits, &small.digits);
        Self { is_negative: large.is_negative, digits }.trimmed()
    }

    pub(super) fn product(&self, other: &Self) -> Self {
        let mut digits = vec![0_u32; self.digits.len() + other.digits.len()];
        for (n, &a) in self.digits.iter().enumerate() {
            let mut carry = 0_u64;
            for (m, &b) in other.digits.iter().enumerate() {
                let next = u64::from(a) * u64::from(b) + u64::from(digits[n + m]) + carry;
                (digits[n + m], carry) = (next as u32, next >> 32);
            }
            digits[n + other.digits.len()] = carry as u32;
        }
        Self { is_negative: self.is_negative != other.is_negative, digits }.trimmed()
    }

    /// Without zeros at the greater end.
    fn trimmed(mut self) -> Self {
        while self.digits.last() == Some(&0) {
            self.digits.pop();
        }
        self
    }
}

fn compare(a: &[u32], b: &[u32]) -> Ordering {
    a.len().cmp(&b.len()).then_with(|| a.iter().rev().cmp(b.iter().rev()))
}

fn sum(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut carry = 0;
    let digit = |n: usize| {
        let [a, b] = [a, b].map(|digits| u64::from(digits.get(n).copied().unwrap_or(0)));
        carry += a + b;
        let digit = carry as u32;
        carry >>= 32;
        digit
    };
    (0..a.len().max(b.len()) + 1).map(digit).collect()
}

/// `a − b`, where `a` is not the lesser.
fn difference(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut borrow = false;
    let digit = |(n, &a): (usize, &u32)| {
        let (digit, first) = a.overflowing_sub(b.get(n).copied().unwrap_or(0));
        let (digit, second) = digit.overflowing_sub(borrow.into());
        borrow = first | second;
        digit
    };
    a.iter().enumerate().map(digit).collect()
}

#[cfg(test)]
mod tests {
    use super::Long;
    use proptest::prelude::*;
    use std::cmp::Ordering;

    fn of(value: i64, shift: usize) -> Long {
        Long::new(value < 0, value.unsigned_abs(), shift)
    }

    /// From a number of which no more than 128 bits are there.
    fn back(long: &Long) -> i128 {
        let digits = long.digits.iter().rev();
        let magnitude = digits.fold(0_i128, |sum, &digit| sum << 32 | i128::from(digit));
        if long.is_negative { -magnitude } else { magnitude }
    }

    proptest! {
        #[test]
        fn sums_and_products_are_those_of_shorter_numbers(a in any::<i32>(), b in any::<i64>(), s in 0..30_usize) {
            let (x, y) = (of(a.into(), s), of(b, 0));
            let (a, b) = (i128::from(a) << s, i128::from(b));
            prop_assert_eq!(back(&x.sum(&y)), a + b);
            prop_assert_eq!(back(&y.sum(&x)), a + b);
            prop_assert_eq!(back(&x.sum(&y.negative())), a - b);
            prop_assert_eq!(back(&x.product(&y)), a * b);
            prop_assert_eq!(x.sum(&x.negative()).compare_with_zero(), Ordering::Equal);
            prop_assert_eq!(x.compare_with_zero(), a.cmp(&0));
        }

        #[test]
        fn the_square_of_a_sum_is_the_sum_of_the_products(a in any::<i64>(), b in any::<i64>(), s in 0..3000_usize) {
            let (a, b) = (of(a, s), of(b, 0));
            let square = a.sum(&b).product(&a.sum(&b));
            let twice = a.product(&b).sum(&b.product(&a));
            let sum = a.product(&a).sum(&twice).sum(&b.product(&b));
            prop_assert_eq!(square.sum(&sum.negative()).compare_with_zero(), Ordering::Equal);
        }
    }
}

//! Bytes by chance, read as choices and numbers.

/// What is left of the bytes. After the last come zeros.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl Bytes<'_> {
    /// The next byte.
    pub(super) fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// One of several.
    pub(super) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[usize::from(self.byte()) % from.len()]
    }

    /// The next eight bytes as a number, least first.
    pub(super) fn word(&mut self) -> u64 {
        u64::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }
}

#[cfg(test)]
mod tests {
    use super::Bytes;

    #[test]
    fn bytes_are_read_in_order_and_then_zeros() {
        let mut bytes = Bytes(&[7, 5, 1, 2, 0, 0, 0, 0, 0, 3, 9]);
        assert_eq!((bytes.byte(), bytes.pick(&['a', 'b', 'c'])), (7, 'c'));
        assert_eq!(bytes.word(), 0x0300_0000_0000_0201);
        assert_eq!((bytes.word(), bytes.byte()), (9, 0));
    }
}

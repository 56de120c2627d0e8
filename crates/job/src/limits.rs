//! How many bytes a task may allocate.

/// A ceiling on what one allocation of a task may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes that a volume or mesh may take in memory. Default: no limit.
    pub bytes: u64,
}

/// The caller's choice: the task is sound, but larger than allowed, or than the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} needs {needed} bytes, {}", self.reason())]
pub struct OverLimit {
    /// What would have been allocated.
    pub what: &'static str,
    /// Its bytes; `u64::MAX` if they do not fit a `u64`.
    pub needed: u64,
    /// Bytes allowed, or bytes that this machine can address. No less than needed where that much is
    /// allowed and the system does not have it.
    pub limit: u64,
}

impl OverLimit {
    fn reason(&self) -> String {
        match self.needed <= self.limit {
            true => "which the system does not have".into(),
            false => format!("the limit is {}", self.limit),
        }
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self { bytes: u64::MAX }
    }
}

impl Limits {
    /// The number of items as a length, if `items` of `item_bytes` each are allowed and fit the
    /// machine's address space. `None` items stand for a product that overflowed.
    ///
    /// # Errors
    ///
    /// [`OverLimit`] before anything is allocated.
    pub fn allow(
        &self,
        what: &'static str,
        items: Option<u64>,
        item_bytes: usize,
    ) -> Result<usize, OverLimit> {
        let limit = self.bytes.min(isize::MAX as u64);
        let needed = items.and_then(|items| items.checked_mul(item_bytes as u64));
        match (items, needed) {
            (Some(items), Some(needed)) if needed <= limit => Ok(items as usize),
            _ => Err(OverLimit { what, needed: needed.unwrap_or(u64::MAX), limit }),
        }
    }

    /// Fails if `items` of `item_bytes` each are not allowed, or if the system has not so much memory.
    /// Nothing is kept.
    ///
    /// # Errors
    ///
    /// [`OverLimit`] then.
    pub fn probe(
        &self,
        what: &'static str,
        items: Option<u64>,
        item_bytes: usize,
    ) -> Result<usize, OverLimit> {
        let count = self.allow(what, items, item_bytes)?;
        let needed = count * item_bytes;
        let over = |_| OverLimit { what, needed: needed as u64, limit: self.bytes };
        Vec::<u8>::new().try_reserve_exact(needed).map_err(over)?;
        Ok(count)
    }

    /// A vector of `items` zeros. Its memory comes from the system when it is first written.
    ///
    /// # Errors
    ///
    /// As [`vec`](Self::vec).
    pub fn zeroed<T: Copy + Default>(
        &self,
        what: &'static str,
        items: Option<u64>,
    ) -> Result<Vec<T>, OverLimit> {
        Ok(vec![T::default(); self.probe(what, items, size_of::<T>())?])
    }

    /// An empty vector with room for exactly `items`, if that is allowed and there is memory.
    ///
    /// # Errors
    ///
    /// [`OverLimit`] if it is not allowed, or if the system has not so much memory.
    pub fn vec<T>(&self, what: &'static str, items: Option<u64>) -> Result<Vec<T>, OverLimit> {
        let count = self.allow(what, items, size_of::<T>())?;
        let mut vec = Vec::new();
        vec.try_reserve_exact(count).map_err(|_| OverLimit {
            what,
            needed: (count * size_of::<T>()) as u64,
            limit: self.bytes,
        })?;
        Ok(vec)
    }
}

#[cfg(test)]
mod tests {
    use super::{Limits, OverLimit};

    #[test]
    fn a_limit_holds_to_the_byte() {
        let limits = Limits { bytes: 80 };
        assert_eq!(limits.allow("volume", Some(10), 8), Ok(10));
        let over = OverLimit { what: "volume", needed: 88, limit: 80 };
        assert_eq!(limits.allow("volume", Some(11), 8), Err(over));
        assert_eq!(over.to_string(), "volume needs 88 bytes, the limit is 80");
    }

    #[test]
    fn what_is_allowed_and_not_there_is_no_limit() {
        // More than the address space of today's machines.
        let over = Limits::default().probe("volume", Some(1 << 60), 1).unwrap_err();
        let said = "volume needs 1152921504606846976 bytes, which the system does not have";
        assert_eq!(over.to_string(), said);
    }

    #[test]
    fn what_overflows_is_never_allowed() {
        for items in [None, Some(u64::MAX), Some(u64::MAX / 8)] {
            assert!(Limits::default().vec::<u64>("volume", items).is_err(), "{items:?}");
        }
    }
}

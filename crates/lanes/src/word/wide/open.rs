//! Where open cells are, as packs go by.

use super::{Group, Groups, Pack};

/// Where words with an open cell are, for [`BitRows::look_up`](crate::BitRows).
///
/// A pack is written down whether it has one or not, and is overwritten if not: with a branch, and a list that grows in a
/// loop, trilinear surfaces of scans take 1.01 to 1.02 times as long (bonsai, CT head; Xeon with AVX-512, November 2026).
pub(crate) struct OpenPlaces<'r> {
    /// For each pack the number of its first word among all words of all rows, and in the eight lowest bits its words that
    /// have one.
    packs: &'r mut [u64],
    kept: usize,
}

/// Room for as many packs as small slices have, for which asking for memory would take a part of the time; and more for large
/// ones.
pub(crate) struct PackRoom {
    few: [u64; 512],
    more: Vec<u64>,
}

impl PackRoom {
    #[inline(always)]
    pub(crate) fn new() -> Self {
        Self { few: [0; 512], more: vec![] }
    }
}

impl<'r> OpenPlaces<'r> {
    /// Room for none.
    pub(crate) const fn none() -> Self {
        Self { packs: &mut [], kept: 0 }
    }

    /// Room for all of them.
    #[inline(always)]
    pub(crate) fn new<P: Pack>(groups: &Groups<'_, P>, room: &'r mut PackRoom) -> Self {
        // The last row of all begins a pack of its own.
        let most = (groups.left.len() * groups.bits.words()).div_ceil(P::WORDS) + 1;
        let PackRoom { few, more } = room;
        if most <= few.len() {
            return Self { packs: few, kept: 0 };
        }
        more.resize(most, 0);
        Self { packs: more, kept: 0 }
    }

    /// Adds a pack.
    #[inline(always)]
    pub(crate) fn add<P: Pack>(&mut self, group: &Group<P>) {
        let ([row, w], open) = (group.place, group.open().found());
        self.packs[self.kept] = ((row * group.words + w) as u64) << 8 | u64::from(open);
        self.kept += usize::from(open != 0);
    }

    /// Those that have one, in order.
    pub(crate) fn packs(&self) -> &[u64] {
        &self.packs[..self.kept]
    }
}

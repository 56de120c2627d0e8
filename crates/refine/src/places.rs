//! Which things share a place.
//!
//! Numbers keep two vertices of one place apart; a reader that merges equal positions does not, and the surface is
//! pinched there. So nothing may move to where something is.
//!
//! Places are hashed, and what moves is written down in a table of bits: only what finds its bit taken is compared,
//! some per cent of all in a mesh where every vertex moves. What stays is only looked up. It costs a few
//! nanoseconds for each thing.

use crate::exact::in_chunks;
use isokit_geom::vector::Vector;
use isokit_job::{Job, Stopped};

/// Bits of the table for each thing that moves, at least.
const SPARSE: usize = 16;

/// Things, numbered from 0, and where they are.
pub(crate) struct Things<P> {
    /// How many there are.
    pub(crate) count: usize,
    /// Where each is; none if it is nowhere.
    pub(crate) place: P,
}

impl<P: Fn(usize) -> Option<Vector> + Sync> Things<P> {
    /// The things that share their place, with one that moves among them: all of one place together, in order.
    pub(crate) fn sharing(
        &self,
        moves: impl Fn(usize) -> bool + Sync,
        job: &Job,
    ) -> Result<Vec<Vec<usize>>, Stopped> {
        const WHAT: &str = "the places of the surface";
        let job = &job.unwatched();
        let hashes = in_chunks(self.count, job, |range| {
            let moving = range.filter(|&n| moves(n)).filter_map(|n| self.hash(n));
            moving.collect::<Vec<u32>>()
        })?;
        let moving: usize = hashes.iter().map(Vec::len).sum();
        if moving == 0 {
            return Ok(vec![]);
        }
        let mut taken = Bits::new(moving, WHAT, job)?;
        let mut shared = Bits::new(moving, WHAT, job)?;
        for hash in hashes.into_iter().flatten() {
            if taken.put(hash) {
                shared.put(hash);
            }
        }
        let stays = |n: &usize| !moves(*n);
        let met = in_chunks(self.count, job, |range| {
            let hashes = range.filter(stays).filter_map(|n| self.hash(n));
            hashes.filter(|&hash| taken.has(hash)).collect::<Vec<u32>>()
        })?;
        for hash in met.into_iter().flatten() {
            shared.put(hash);
        }
        let suspects = in_chunks(self.count, job, |range| {
            let is_suspect = |n: &usize| self.hash(*n).is_some_and(|hash| shared.has(hash));
            let suspects = range.filter(is_suspect);
            suspects.filter_map(|n| Some((bits((self.place)(n)?), n))).collect::<Vec<_>>()
        })?;
        let mut suspects = suspects.concat();
        suspects.sort_unstable();
        let groups = suspects.chunk_by(|(a, _), (b, _)| a == b).filter(|group| group.len() > 1);
        let groups = groups.map(|group| group.iter().map(|&(_, n)| n).collect::<Vec<_>>());
        Ok(groups.filter(|group| group.iter().any(|&n| moves(n))).collect())
    }

    fn hash(&self, n: usize) -> Option<u32> {
        const ODD: u64 = 0x9E37_79B9_7F4A_7C15;
        let mix = |hash: u64, part: u64| (hash ^ hash >> 32 ^ part).wrapping_mul(ODD);
        (self.place)(n).map(|place| (bits(place).into_iter().fold(0, mix) >> 32) as u32)
    }
}

/// The bits of a place; −0 is 0.
fn bits(place: Vector) -> [u64; 3] {
    place.map(|c| (c + 0.0).to_bits())
}

/// A bit for each of many hashes.
struct Bits {
    words: Vec<u64>,
    /// The bits of a hash that count.
    mask: u32,
}

impl Bits {
    fn new(items: usize, what: &'static str, job: &Job) -> Result<Self, Stopped> {
        let bits = items.saturating_mul(SPARSE).clamp(64, 1 << 32).next_power_of_two();
        let words = job.limits.zeroed(what, Some(bits as u64 / 64))?;
        Ok(Self { words, mask: (bits - 1) as u32 })
    }

    /// Sets the bit of a hash. Whether it was set.
    fn put(&mut self, hash: u32) -> bool {
        let (word, bit) = self.split(hash);
        let had = self.words[word] & bit != 0;
        self.words[word] |= bit;
        had
    }

    fn has(&self, hash: u32) -> bool {
        let (word, bit) = self.split(hash);
        self.words[word] & bit != 0
    }

    fn split(&self, hash: u32) -> (usize, u64) {
        let slot = hash & self.mask;
        ((slot / 64) as usize, 1 << (slot % 64))
    }
}

#[cfg(test)]
mod tests {
    use super::Things;
    use isokit_job::{CHUNK, Job};

    /// Places of a lattice, and a few things on top of others.
    fn place(n: usize) -> Option<[f64; 3]> {
        let at = |n: usize| [n % 40, n / 40 % 40, n / 1600].map(|i| 0.1 * i as f64);
        match n {
            7 => None,
            100 | 200 => Some([0.0, -0.0, 5.0]),
            300 => Some([0.0, 0.0, 5.0]),
            60_000 => Some(at(20_000)),
            60_001 => Some(at(20_001)),
            _ => Some(at(n)),
        }
    }

    #[test]
    fn only_those_in_one_place_are_found_and_only_where_one_moves() {
        let things = Things { count: 4 * CHUNK, place };
        let found = |moves: fn(usize) -> bool| things.sharing(moves, &Job::default()).unwrap();
        let three = vec![100, 200, 300];
        assert_eq!(found(|_| true), [three.clone(), vec![20_000, 60_000], vec![20_001, 60_001]]);
        assert_eq!(found(|n| n == 20_001 || n == 5), [[20_001, 60_001]]);
        assert_eq!(found(|n| n == 200), [three]);
        assert!(found(|_| false).is_empty() && found(|n| n == 7).is_empty());
    }
}

//! What f32 does to positions that are finer.
//!
//! GLB and STL hold f32. A mesh far from its origin is kept in f64, and a glTF's metres are a rounded
//! multiple of its millimetres: two vertices may then fall on one place, where a reader that merges equal
//! positions makes one of them and tears or pinches the surface. So they are counted.
//!
//! Each place sets one bit, chosen by its hash, of a table that is sixteen times as long as there are
//! vertices; only vertices whose bit is set twice are sorted. 500 000 vertices take 8 ms of the 46 ms that
//! writing their GLB takes (2-core x86-64 Xeon, November 2026).

use super::{Written, outline::Outline};
use crate::Format;
use isokit_job::{Job, Stopped};
use isokit_mesh::{Positions, Precision};

/// What becomes of a surface's positions in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Loss {
    /// Vertices that fall on the place of another one, and did not before.
    pub(super) merged: u64,
    /// The greatest change of a coordinate, in the mesh's own unit; 0 where nothing is worth a word.
    pub(super) moved: f64,
}

impl Loss {
    /// Compares positions with what `store` makes of them; `back` leads from there to the own unit.
    pub(super) fn of(
        positions: &Positions,
        store: impl Fn([f64; 3]) -> [f32; 3],
        back: impl Fn([f64; 3]) -> [f64; 3],
        job: &Job,
    ) -> Result<Self, Stopped> {
        let merged = match merged(|| stored(positions, &store), job)? {
            0 => 0,
            after => after.saturating_sub(merged(|| positions.iter(), job)?),
        };
        let is_finer = positions.precision() == Precision::F64;
        // Nobody asks how far f32 is from itself.
        let moved = if is_finer || merged > 0 { moved(positions, store, back) } else { 0.0 };
        Ok(Self { merged, moved })
    }

    /// Puts into words what a user should know.
    pub(super) fn report(self, outline: &Outline, format: Format, written: &mut Written) {
        let is_finer = outline.precision == Precision::F64;
        if !is_finer && self.merged == 0 {
            return;
        }
        written.merged_vertices += self.merged;
        let Self { merged, moved } = self;
        let merging = match merged {
            0 => "no two vertices fall together".to_owned(),
            1 => "1 vertex falls on the place of another one".to_owned(),
            _ => format!("{merged} vertices fall on the place of another one"),
        };
        written.warnings.push(format!(
            "surface {:?}: {format} holds f32; coordinates move by up to {moved:.1e}, and {merging}; \
             .ply and .obj keep every digit, or move the origin nearer to the surface",
            outline.head.name
        ));
    }
}

/// The loss of a surface that comes in pieces.
///
/// A vertex is compared with those of its piece and of the last one before that had any; equal places
/// farther apart are not seen.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// Equal to an earlier position, once stored and as they came.
    after: u64,
    before: u64,
    moved: f64,
    /// The last piece that had any.
    last: Positions,
}

impl Tally {
    /// Takes in a piece, as [`Loss::of`] takes a surface, and takes its positions away.
    pub(super) fn take(
        &mut self,
        positions: &mut Positions,
        store: impl Fn([f64; 3]) -> [f32; 3],
        back: impl Fn([f64; 3]) -> [f64; 3],
        job: &Job,
    ) -> Result<(), Stopped> {
        if positions.is_empty() {
            return Ok(());
        }
        let (last, now) = (&self.last, &*positions);
        let after = merged(|| stored(last, &store).chain(stored(now, &store)), job)?;
        // What is apart once stored was apart before.
        if after > 0 {
            self.after += after - merged(|| stored(last, &store), job)?;
            let before = merged(|| last.iter().chain(now.iter()), job)?;
            self.before += before - merged(|| last.iter(), job)?;
        }
        self.moved = self.moved.max(moved(now, store, back));
        std::mem::swap(&mut self.last, positions);
        Ok(())
    }

    /// What has become of all pieces.
    pub(super) fn loss(&self) -> Loss {
        Loss { merged: self.after.saturating_sub(self.before), moved: self.moved }
    }
}

fn stored(
    positions: &Positions,
    store: impl Fn([f64; 3]) -> [f32; 3],
) -> impl Iterator<Item = [f64; 3]> {
    positions.iter().map(move |xyz| store(xyz).map(f64::from))
}

/// The greatest change of a coordinate.
fn moved(
    positions: &Positions,
    store: impl Fn([f64; 3]) -> [f32; 3],
    back: impl Fn([f64; 3]) -> [f64; 3],
) -> f64 {
    positions.iter().fold(0.0, |most, xyz| {
        let back = back(store(xyz).map(f64::from));
        (0..3).fold(most, |most: f64, k| most.max((xyz[k] - back[k]).abs()))
    })
}

/// How many positions are equal to an earlier one; −0 is 0, and NaN is nowhere.
fn merged<I: Iterator<Item = [f64; 3]>>(
    positions: impl Fn() -> I,
    job: &Job,
) -> Result<u64, Stopped> {
    let keys = || {
        let places = positions().filter(|xyz| !xyz.iter().any(|c| c.is_nan()));
        // + 0.0 makes 0 of −0.
        places.map(|xyz| xyz.map(|c| (c + 0.0).to_bits()))
    };
    let bits = (positions().size_hint().0 as u64 * 16).next_power_of_two().max(64);
    let table = || -> Result<Vec<u64>, Stopped> {
        let mut table = job.limits.vec("a table of places", Some(bits / 64))?;
        table.resize((bits / 64) as usize, 0);
        Ok(table)
    };
    let (mut once, mut twice) = (table()?, table()?);
    let place = |key: [u64; 3]| {
        let bit = hash(key) & (bits - 1);
        ((bit / 64) as usize, 1_u64 << (bit % 64))
    };
    let mut any = false;
    for key in keys() {
        let (word, bit) = place(key);
        let again = once[word] & bit;
        twice[word] |= again;
        any |= again != 0;
        once[word] |= bit;
    }
    job.check().map_err(Stopped::from)?;
    if !any {
        return Ok(0);
    }
    let is_crowded = |&key: &[u64; 3]| {
        let (word, bit) = place(key);
        twice[word] & bit != 0
    };
    let mut crowded: Vec<_> = keys().filter(is_crowded).collect();
    crowded.sort_unstable();
    Ok(crowded.windows(2).filter(|pair| pair[0] == pair[1]).count() as u64)
}

/// Odd multipliers with well spread bits; the upper bits of a product depend on all lower ones.
fn hash(key: [u64; 3]) -> u64 {
    let mix = |hash: u64, c: u64| (hash ^ c).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(29);
    key.into_iter().fold(0, mix).wrapping_mul(0xd6e8_feb8_6659_fd93) >> 20
}

#[cfg(test)]
mod tests {
    use super::{Loss, Tally, merged};
    use isokit_job::Job;
    use isokit_mesh::Positions;

    fn check(positions: &[[f64; 3]], expected: u64) {
        let found = merged(|| positions.iter().copied(), &Job::default()).unwrap();
        assert_eq!(found, expected, "{positions:?}");
    }

    #[test]
    fn equal_places_are_counted_once_less_than_they_are() {
        check(&[], 0);
        check(&[[1.0; 3]; 5], 4);
        check(&[[0.0; 3], [-0.0; 3], [1.0, 0.0, 0.0]], 1);
        check(&[[f64::NAN; 3]; 2], 0);
        let many: Vec<_> = (0..10_000).map(|i| [f64::from(i % 9_000), 0.5, 0.0]).collect();
        check(&many, 1000);
    }

    #[test]
    fn only_what_rounding_merges_is_its_loss() {
        let far = 1e6;
        let all = vec![[far; 3], [far; 3], [far + 0.01, far, far], [far + 1.0, far, far]];
        let (round, job) = (|xyz: [f64; 3]| xyz.map(|c| c as f32), Job::default());
        let loss = Loss::of(&Positions::F64(all.clone()), round, |xyz| xyz, &job).unwrap();
        assert_eq!(loss.merged, 1);
        assert!((loss.moved - 0.01).abs() < 1e-6, "{loss:?}");

        let mut tally = Tally::default();
        for piece in [&all[..2], &[], &all[2..]] {
            let mut piece = Positions::F64(piece.to_vec());
            tally.take(&mut piece, round, |xyz| xyz, &job).unwrap();
        }
        assert_eq!(tally.loss(), loss, "in pieces too");
    }
}

//! The index of a volume: made once, kept beside the file.

use isokit_io::{BrickFile, NoBricks};
use isokit_volume::{AnyBricks, Bricks, Sample, Scaling, Statistics, View};
use std::{borrow::Cow, fmt, ops::Range, path::PathBuf};

/// With a greater share of the bricks to look at, all samples may be sooner looked at. For one surface an index by which it
/// is so much saves a tenth of the time with samples of a byte, a quarter in f32; with a sixth it saves nothing (row `index` of
/// `scripts/bench`, and a bonsai; EPYC of 2021, November 2026).
const MOST_ACTIVE: f64 = 1.0 / 8.0;

/// Where an index is from.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Index {
    /// From the file in which it was kept.
    Read(PathBuf),
    /// From the samples. It is kept in this file from now on; `why` is what was wrong with the one that
    /// was there, if there was one.
    Made {
        /// Where it is kept.
        path: PathBuf,
        /// Why it was made again.
        why: Option<NoBricks>,
    },
    /// From the samples, and not kept: the scan has no file of its own, or this was the reason.
    NotKept(Option<String>),
}

impl fmt::Display for Index {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(path) => write!(f, "index read from {}", path.display()),
            Self::Made { path, why: None } => write!(f, "index kept in {}", path.display()),
            Self::Made { path, why: Some(why) } => {
                write!(f, "index made again in {}: {why}", path.display())
            }
            Self::NotKept(None) => f.write_str("index not kept: the volume has no file"),
            Self::NotKept(Some(why)) => write!(f, "index not kept: {why}"),
        }
    }
}

/// The bricks of a volume, from the file or else from the samples.
pub(super) fn of<T: Sample, E>(
    file: Option<&BrickFile>,
    make: impl FnOnce() -> Result<Bricks<T>, E>,
) -> Result<(AnyBricks, Index), E> {
    let Some(file) = file else { return Ok((make()?.into(), Index::NotKept(None))) };
    let path = file.path().to_owned();
    let why = match file.read::<T>() {
        Ok(bricks) => return Ok((bricks.into(), Index::Read(path))),
        Err(NoBricks::Absent) => None,
        Err(why) => Some(why),
    };
    let bricks = make()?;
    let index = match file.write(&bricks) {
        Ok(()) => Index::Made { path, why },
        Err(error) => Index::NotKept(Some(error.to_string())),
    };
    Ok((bricks.into(), index))
}

/// What an index of the whole volume tells of a part.
pub(super) fn of_part<'a, T: Sample>(
    bricks: &'a AnyBricks,
    part: &[Range<usize>; 3],
) -> Option<Cow<'a, Bricks<T>>> {
    let whole = bricks.of::<T>()?;
    match whole.grid().dims() == part.each_ref().map(|range| range.len()) {
        true => Some(Cow::Borrowed(whole)),
        false => whole.part(part).map(Cow::Owned),
    }
}

/// Whether surfaces of samples that are in memory are sooner made with it.
pub(super) fn is_worth_it<T: Sample>(bricks: &Bricks<T>, scaling: Scaling, isos: &[f64]) -> bool {
    let each: Vec<_> = isos.iter().map(|&iso| scaling.threshold(iso)).collect();
    bricks.active_share(&each) <= MOST_ACTIVE
}

/// Range and NaN, if an index tells them and `view` is of all of its samples.
pub(super) fn statistics<T: Sample>(bricks: &AnyBricks, view: &View<'_, T>) -> Option<Statistics> {
    let whole = bricks.of::<T>().filter(|bricks| bricks.grid().dims() == view.dims())?;
    Statistics::of_bricks(whole, view.scaling())
}

/// How many bricks a part of what is indexed has.
pub(super) fn bricks_of_part(bricks: &AnyBricks, part: &[Range<usize>; 3]) -> u64 {
    bricks.grid().part(part).and_then(|grid| grid.count()).unwrap_or(0)
}

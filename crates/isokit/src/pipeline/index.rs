//! The index of a volume: made once, kept beside the file.

use isokit_io::{BrickFile, NoBricks};
use isokit_job::{Job, Stopped};
use isokit_volume::{AnyBricks, Bricks, Sample, Volume};
use std::{fmt, path::PathBuf};

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
pub(super) fn of<T: Sample>(
    volume: &Volume<T>,
    file: Option<&BrickFile>,
    job: &Job,
) -> Result<(AnyBricks, Index), Stopped> {
    let make = || Bricks::of(&volume.view(), job);
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

//! Files with a colour per sample: three or four bytes beside each other, red first, opacity last.
//!
//! A file is read as one lattice three or four times as long along x, of which the bytes are taken as they are. They count as
//! sRGB with straight opacity, which is how images have them; no format of these says.

use super::{Described, VolumeFile, VolumeOptions, open::describe, stored::Order};
use crate::{Format, ReadError, ReadFault};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Channels, ColorVolume, Dtype, Grid};
use std::path::Path;

/// Samples that are colours, as a header describes them.
pub(super) struct Colored {
    channels: Channels,
    /// Of the lattice of colours.
    dims: [u64; 3],
    /// What is said to somebody who asks for values.
    pub(super) fault: ReadFault,
}

impl Colored {
    /// Of so many numbers beside each other, which messages name `what`; none if they cannot be colours.
    pub(super) fn of(count: u64, dims: [u64; 3], dtype: Dtype, what: &str) -> Option<Self> {
        let channels = match (count, dtype) {
            (3, Dtype::U8) => Channels::Rgb,
            (4, Dtype::U8) => Channels::Rgba,
            _ => return None,
        };
        let says = format!("{what}: they are colours, not values");
        Some(Self { channels, dims, fault: ReadFault::Colors(says) })
    }
}

/// A file of colours whose header was read and checked, and whose samples were not.
#[derive(Clone, Debug)]
pub struct ColorFile {
    /// Of all bytes.
    file: VolumeFile,
    channels: Channels,
    grid: Grid,
}

/// Reads and checks the header of the file at `path`, if it says that samples are three or four bytes: an NRRD whose first axis
/// counts them and is of the kind of a colour or a vector, or of none, or a MetaImage with so many channels. None if it says
/// something else.
///
/// # Errors
///
/// If the file cannot be read, breaks its format, is no volume, or uses what we do not support.
pub fn open_colors(path: &Path, job: &Job) -> Result<Option<ColorFile>, ReadError> {
    let options = VolumeOptions::default();
    let described = describe(path, &options)?;
    let Described { colored: Some(Colored { channels, dims, .. }), .. } = described else {
        return Ok(None);
    };
    let count = channels.count() as u64;
    let Some(whole) = dims[0].checked_mul(count) else {
        let says = format!("{count} times {dims:?} bytes are more than 64 bits can count");
        return Err(ReadFault::Caller(says.into()).at(path));
    };
    let [_, y, z] = dims;
    let all = Described { dims: [whole, y, z], triples: None, colored: None, ..described };
    let file = all.check(path, &options, job)?;
    debug_assert!(file.stored.order == Order::XFastest, "numbers of a colour lie together");
    let grid = Grid::new(dims, file.grid().frame).expect("a part of a lattice is one");
    Ok(Some(ColorFile { file, channels, grid }))
}

impl ColorFile {
    /// Sizes and place of the lattice.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What the numbers of a colour are.
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// What the file is.
    pub fn format(&self) -> Format {
        self.file.format()
    }

    /// What was assumed or ignored, each a sentence for the user.
    pub fn notes(&self) -> &[String] {
        self.file.notes()
    }

    /// All colours, in memory.
    ///
    /// # Errors
    ///
    /// If the file cannot be read, if the job's limit does not allow so much memory, or if the job is cancelled.
    pub fn collect(self, job: &Job) -> Result<ColorVolume, ReadError> {
        let Self { file, channels, grid } = self;
        match file.collect(job)? {
            AnyVolume::U8(bytes) => {
                let colors = ColorVolume::new(grid, channels, bytes.into_samples());
                Ok(colors.expect("all bytes of a lattice of colours"))
            }
            _ => unreachable!("only bytes are colours"),
        }
    }
}

#[cfg(test)]
mod tests;

//! What can be asked, and what is answered; how a volume comes into memory; the clock.

use crate::Failure;
use bytemuck::Pod;
use isokit_lanes::prefer_large_pages;
use serde::{Deserialize, Serialize};
use std::{
    fs::{self, File},
    io::Read,
    num::NonZeroU32,
    path::PathBuf,
    time::Instant,
};

/// A piece of work.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "op", rename_all = "kebab-case")]
pub(crate) enum Request {
    /// Take a volume into memory; not timed.
    Load(Load),
    /// Make the surface.
    Extract(Extract),
    /// Count vertices and triangles of the surfaces of these values, and make nothing.
    Count { isos: Vec<f64>, threads: usize },
    /// Find the least and the greatest sample of every brick.
    Index { threads: usize },
    /// Compare every sample with the value, into bits that were written before.
    Classify { iso: f64, threads: usize },
    /// Read every sample.
    Read { threads: usize },
    /// Copy every sample to memory that was written before.
    Copy { threads: usize },
    /// Write fresh memory of these sizes in bytes.
    Fill { parts: Vec<usize>, threads: usize },
    /// Both `Read` and `Fill`: less no extraction can do.
    Bound { parts: Vec<usize>, threads: usize },
    /// Make the surface once, and find out how much memory that takes.
    Memory(Extract),
}

/// Where samples are: raw, x fastest, in this machine's byte order. Without a path they are made up.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Load {
    pub(crate) path: Option<PathBuf>,
    pub(crate) dims: [usize; 3],
    pub(crate) dtype: String,
    /// For peers that know the value 0 only.
    #[serde(default)]
    pub(crate) iso: f64,
}

/// How the surface is to be made.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Extract {
    pub(crate) iso: f64,
    pub(crate) threads: usize,
    pub(crate) normals: bool,
    /// Into the memory of the surface before, if there was one.
    pub(crate) warm: bool,
    #[serde(default)]
    pub(crate) boundary: Boundary,
    #[serde(default)]
    pub(crate) nan: Nan,
    #[serde(default)]
    pub(crate) placement: Placement,
    #[serde(default)]
    pub(crate) gradient: Gradient,
    #[serde(default)]
    pub(crate) topology: Topology,
    #[serde(default)]
    pub(crate) diagonals: Diagonals,
    /// Whether the bricks are known; they are made off the clock.
    #[serde(default)]
    pub(crate) index: bool,
    /// How often, one run right after another into the same memory; the time is that of one on average.
    #[serde(default = "once")]
    pub(crate) runs: NonZeroU32,
}

fn once() -> NonZeroU32 {
    NonZeroU32::MIN
}

/// What lies beyond the border.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Boundary {
    #[default]
    Open,
    Closed,
}

/// What becomes of NaN.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Nan {
    #[default]
    Outside,
    Error,
}

/// Where between two samples a vertex lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Placement {
    #[default]
    Linear,
    Cubic,
    Quintic,
}

/// What normals are made from.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Gradient {
    #[default]
    Central,
    Matching,
}

/// What the surface connects where the signs leave it open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Topology {
    #[default]
    Table,
    Trilinear,
}

/// How the polygons of cells are cut into triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Diagonals {
    #[default]
    Table,
    Fitted,
}

/// What was found. Absent is what the work has nothing of.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Answer {
    /// Wall time.
    pub(crate) seconds: f64,
    /// Pages that the system had to provide meanwhile: of a cold run many, of a warm one few.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) faults: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) vertices: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) triangles: Option<u64>,
    /// Bytes of the samples.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) input: Option<usize>,
    /// Bytes of each part of the output.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) parts: Vec<usize>,
    /// Bytes that were in memory at most, above input and output.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) above: Option<i64>,
    /// With known bricks, the share of those that were looked at.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) active: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) simd: Option<&'static str>,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) error: Option<String>,
}

impl Answer {
    pub(crate) fn failed(failure: &dyn std::error::Error) -> Self {
        Self { error: Some(failure.to_string()), ..Self::default() }
    }
}

/// Does the work, and says how long it took and what it gave.
pub(crate) fn timed<R>(work: impl FnOnce() -> R) -> (Answer, R) {
    let before = page_faults();
    let start = Instant::now();
    let result = work();
    let seconds = start.elapsed().as_secs_f64();
    let faults = page_faults().zip(before).map(|(after, before)| after - before);
    (Answer { seconds, faults, ..Answer::default() }, result)
}

/// Pages that this process was given so far, where the system tells.
fn page_faults() -> Option<u64> {
    let stat = fs::read_to_string("/proc/self/stat").ok()?;
    // The name of the program, in parentheses, may hold spaces.
    stat.rsplit_once(')')?.1.split_whitespace().nth(7)?.parse().ok()
}

impl Load {
    /// The samples, or, without a file, random ones from the middle of their type's range.
    pub(crate) fn samples<T: Pod>(&self) -> Result<Vec<T>, Failure> {
        let mut samples = vec![T::zeroed(); self.dims.iter().product()];
        prefer_large_pages(&mut samples); // numpy does the same for the peers
        match &self.path {
            Some(path) => {
                File::open(path)?.read_exact(bytemuck::cast_slice_mut(&mut samples))?;
            }
            None => {
                let words: &mut [u64] = bytemuck::try_cast_slice_mut(&mut samples)
                    .map_err(|_| "made up samples come in multiples of 8 bytes")?;
                self.make_up(words);
            }
        }
        Ok(samples)
    }

    /// Floats from 1 to 2, integers of any value.
    fn make_up(&self, words: &mut [u64]) {
        let mut state = 0x2545_F491_4F6C_DD1D_u64;
        for word in words {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            *word = match self.dtype.as_str() {
                "f32" => state & 0x007F_FFFF_007F_FFFF | 0x3F80_0000_3F80_0000,
                "f64" => state >> 12 | 0x3FF0 << 48,
                _ => state,
            };
        }
    }
}

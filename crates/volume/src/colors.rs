//! Samples that are colours.

use crate::{Grid, View, VolumeError};

/// What the numbers of a colour are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channels {
    /// Red, green, blue.
    Rgb,
    /// Red, green, blue, opacity.
    Rgba,
}

impl Channels {
    /// How many numbers a colour has.
    pub fn count(self) -> usize {
        match self {
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }
}

/// A lattice of colours, x fastest, the bytes of each beside each other.
///
/// Colours are sRGB codes from 0 to 255, as `#rrggbb` has them; opacity is straight, from 0 for nothing to 255.
///
/// # Guarantees
///
/// There are exactly as many bytes per lattice point as a colour has.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorVolume {
    grid: Grid,
    channels: Channels,
    samples: Vec<u8>,
}

impl ColorVolume {
    /// The colours `samples` on `grid`.
    ///
    /// # Errors
    ///
    /// If the number of bytes is not that of the lattice's colours.
    pub fn new(grid: Grid, channels: Channels, samples: Vec<u8>) -> Result<Self, VolumeError> {
        let needed = grid.count().checked_mul(channels.count() as u64);
        match needed == Some(samples.len() as u64) {
            true => Ok(Self { grid, channels, samples }),
            false => Err(VolumeError { held: samples.len(), needed: needed.unwrap_or(u64::MAX) }),
        }
    }

    /// The lattice.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// What the numbers of a colour are.
    pub fn channels(&self) -> Channels {
        self.channels
    }

    /// All bytes: those of the first colour, then those of the next along x.
    pub fn samples(&self) -> &[u8] {
        &self.samples
    }

    /// Each number of the colours as a lattice of its own, red first.
    pub fn views(&self) -> Vec<View<'_, u8>> {
        let count = self.channels.count();
        // All bytes are in memory, so sizes are of its address space.
        let [nx, ny, _] = self.grid.dims().map(|n| n as isize);
        let step = count as isize;
        let strides = [step, step * nx, step * nx * ny];
        let view = |first| View::strided(&self.samples, first, strides, &self.grid);
        (0..count).map(|first| view(first).expect("as many bytes as colours have")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Channels, ColorVolume};
    use crate::{Grid, VolumeError};
    use isokit_geom::Frame;

    #[test]
    fn each_number_of_a_colour_is_a_lattice() {
        let grid = Grid::new([2, 3, 4], Frame::default()).unwrap();
        for channels in [Channels::Rgb, Channels::Rgba] {
            let count = channels.count();
            let bytes: Vec<u8> = (0..24 * count).map(|n| n as u8).collect();
            let colors = ColorVolume::new(grid, channels, bytes).unwrap();
            assert_eq!(colors.views().len(), count);
            for (channel, view) in colors.views().into_iter().enumerate() {
                assert_eq!(view.dims(), [2, 3, 4]);
                let expected = (((3 * 3 + 2) * 2 + 1) * count + channel) as u8;
                assert_eq!(view.stored([1, 2, 3]), expected);
            }
        }
    }

    #[test]
    fn bytes_and_lattice_must_fit() {
        let of = |dims, held| {
            let grid = Grid::new(dims, Frame::default()).unwrap();
            ColorVolume::new(grid, Channels::Rgba, vec![0; held])
        };
        assert_eq!(of([2, 3, 4], 72), Err(VolumeError { held: 72, needed: 96 }));
        assert_eq!(of([1 << 62, 2, 1], 8), Err(VolumeError { held: 8, needed: u64::MAX }));
    }
}

//! What a volume file does not say, or says wrongly.

use super::{SampleType, Triple, values};
use clap::Args;
use isokit::{
    io::{RawLayout, VolumeOptions},
    volume::Quantity,
};

/// How the input is read.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Input volume")]
pub(crate) struct VolumeArgs {
    /// Distances between samples along x, y, z, or along all three, where the file gives none or wrong ones; of a shape,
    /// those that are wanted
    #[arg(long, value_name = "X[,Y,Z]", value_parser = values::spacing, allow_hyphen_values = true)]
    spacing: Option<Triple<f64>>,
    #[command(flatten)]
    file: FileArgs,
}

/// The same but for the distances between samples.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Input volume")]
pub(crate) struct FileArgs {
    /// Samples along x, y, z of a file without a header; x is fastest
    #[arg(long, value_name = "X,Y,Z", requires = "dtype", value_parser = values::sizes)]
    dims: Option<Triple<u64>>,
    /// Sample type of a file without a header: u8 i8 u16 i16 u32 i32 f32 f64, then le (default) or be
    #[arg(long, value_name = "TYPE", requires = "dims")]
    dtype: Option<SampleType>,
    /// Bytes to skip before the first sample of a file without a header
    #[arg(long, value_name = "BYTES", requires = "dims")]
    skip: Option<u64>,
    /// Place of the first sample, where the file gives none or a wrong one
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    origin: Option<Triple<f64>>,
    /// Which volume of a file that holds several, counted from 0 [default: the first]
    #[arg(long, value_name = "N")]
    volume_index: Option<u64>,
    /// What is read of a file of vectors, three numbers per sample: the components x, y or z along the axes of the
    /// file's world; their length, speed; divergence; vorticity, the length of the curl; or q-criterion, above 0 in
    /// vortices. Derivatives are central differences in world units
    #[arg(long, value_name = "QUANTITY", conflicts_with_all = ["dims", "volume_index"])]
    quantity: Option<Quantity>,
}

impl VolumeArgs {
    /// Whether none was given.
    pub(crate) fn is_empty(&self) -> bool {
        let FileArgs { dims, dtype, skip, origin, volume_index, quantity } = &self.file;
        let raw = dims.is_some() || dtype.is_some() || skip.is_some();
        let chosen = volume_index.is_some() || quantity.is_some();
        !raw && !chosen && self.spacing.is_none() && origin.is_none()
    }

    /// The same for the library.
    pub(crate) fn options(&self) -> VolumeOptions {
        self.file.options(self.spacing)
    }

    /// The distances between samples, if nothing else was given.
    pub(crate) fn only_spacing(&self) -> Option<[f64; 3]> {
        let rest = Self { spacing: None, file: self.file.clone() };
        self.spacing.filter(|_| rest.is_empty()).map(|spacing| spacing.0)
    }
}

impl FileArgs {
    /// The same for the library, with distances between samples where the file gives none or wrong ones.
    pub(crate) fn options(&self, spacing: Option<Triple<f64>>) -> VolumeOptions {
        let layout = |(dims, sample): (Triple<u64>, SampleType)| RawLayout {
            dims: dims.0,
            dtype: sample.dtype,
            endian: sample.endian,
            skip: self.skip.unwrap_or(0),
        };
        let mut options = VolumeOptions::default();
        options.volume_index = self.volume_index;
        options.quantity = self.quantity;
        options.raw = self.dims.zip(self.dtype).map(layout);
        options.spacing = spacing.map(|spacing| spacing.0);
        options.origin = self.origin.map(|origin| origin.0);
        options
    }
}

//! From a scan in a file to meshes in a file, step by step.
//!
//! | step | function |
//! | --- | --- |
//! | read | [`Scan::read`], [`Scan::open`] with options, or [`Scan::new`] for samples from elsewhere |
//! | or look first | [`ScanFile`] knows where samples are before any is read, and reads those that are wanted |
//! | place | [`Scan::placed`] chooses the axes of the world, [`Scan::cropped`] a part of the samples |
//! | resample | [`Scan::resampled`] has samples farther from each other, or nearer |
//! | choose | [`Scan::suggestions`] says which isovalues stand out; [`Scan::iso`] turns "automatic" or a percentage into one |
//! | skip | [`Scan::index`] finds out which parts surfaces have nothing to do with |
//! | extract | [`Scan::mesh`], with normals; [`Scan::meshes_into`] for several isovalues, [`SlabScan::meshes_into`] where the scan exceeds memory |
//! | or sample | [`sparse_meshes_into`] makes samples of a shape, or of another field, only near its surfaces |
//! | or cut | [`Scan::clipped_mesh`], closed where planes, or the [`Mask`] that another scan is, cut |
//! | refine | [`Scan::refine`] divides triangles or balances them, if that is wanted; [`refine_on`] does it by another field than samples, and on its creases |
//! | colour | [`Scan::attribute`] gives each vertex the value of another scan there, [`Scan::attribute_colors`] the colour |
//! | write | [`write_mesh`](crate::io::write_mesh), with [`Scan::context`] |
//!
//! The program `isokit extract` is these steps and nothing else. A step reads no clock and prints nothing;
//! what a user should know comes back as a value ([`Scan::notes`], [`Remark`]).

mod attribute;
mod clip;
mod error;
mod index;
mod iso;
mod lattice;
mod refine;
mod region;
mod remark;
mod resampled;
mod scan;
mod scan_file;
mod slab_scan;
mod sparse;
mod surface;
mod target;
mod values;

pub use clip::Mask;
pub use error::PipelineError;
pub use index::Index;
pub use iso::{IsoChoice, ParseIsoError};
pub use lattice::Lattice;
pub(crate) use lattice::count;
pub use refine::refine_on;
pub use region::{ParseRegionError, Region, RegionError, Span};
pub use remark::Remark;
pub use scan::Scan;
pub use scan_file::ScanFile;
pub use slab_scan::SlabScan;
pub use sparse::sparse_meshes_into;
pub use surface::{Normals, SurfaceOptions};
pub use target::{TargetSpace, UnknownSpace};

//! Pictures of volumes, computed on the processor: no display and no graphics card take part.
//!
//! [`raycast`] looks with a [`Camera`] at a volume whose places look as an [`OpticalModel`] says: in the simplest case by
//! a [`TransferFunction`], which gives each value a colour and an opacity. [`splat`] makes the
//! same picture from the samples' side. The [`Image`] is written by [`write_png`].
//!
//! ```
//! use isokit_geom::Space;
//! use isokit_job::Job;
//! use isokit_render::{
//!     Background, Camera, ControlPoint, Depth, Medium, RaycastOptions, Side, Size, TransferFunction, raycast,
//!     write_png,
//! };
//! use isokit_volume::{Grid, Volume};
//!
//! // How deep a point lies in a ball.
//! let ball = |n: usize| {
//!     let from = [n % 32, n / 32 % 32, n / 1024].map(|i| i as f32 - 15.5);
//!     12.0 - from.iter().map(|c| c * c).sum::<f32>().sqrt()
//! };
//! let grid = Grid::new([32, 32, 32], Default::default())?;
//! let volume = Volume::new(grid, (0..32 * 32 * 32).map(ball).collect())?;
//!
//! // Nothing at the rim, an orange fog that grows denser towards the middle.
//! let fog = TransferFunction::new(vec![
//!     ControlPoint::new(0.0, "#ff800000".parse()?),
//!     ControlPoint::new(12.0, "#ff8000a0".parse()?),
//! ])?;
//! let model = fog.into();
//! let bounds = volume.grid().bounds();
//! let camera = Camera::framing(bounds, Side::Anterior.directions(Space::Ras), Some(30.0), 1.0)?;
//! let size = Size { width: 64.try_into()?, height: 64.try_into()? };
//! let medium = Medium { view: &volume.view(), bricks: None, model: &model, clips: &[] };
//! let (options, job) = (RaycastOptions::DEFAULT, Job::default());
//! let (image, _) = raycast(&medium, (&camera, size), &options, &job)?;
//! assert!(image.pixel(32, 32).opacity > 0.9 && image.pixel(0, 0).opacity == 0.0);
//! let mut file = vec![]; // or a file
//! write_png(&image, Background::Transparent, Depth::Eight, &mut file)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Colours are in linear light and multiplied by their opacity from the first step to the last; only files have them
//! otherwise. The same scene gives the same picture, byte for byte, for any number of threads.

mod camera;
mod clear;
mod colormap;
mod gather;
mod image;
mod interpolant;
mod isocast;
mod light;
mod png;
mod raster;
mod raycast;
mod shading;
mod splat;
mod texture;
mod transfer;
mod trilinear;

pub use camera::{Camera, CameraError, Projection, Ray, Side};
pub use colormap::ColorMap;
pub use gather::{Gathered, opacity_over};
pub use image::{Background, Image, Size};
pub use interpolant::{Interpolant, Kernel};
pub use isocast::{Isosurface, Isosurfaces, Traced, isocast};
pub use light::Light;
pub use png::{Depth, PngError, write_channel_png, write_png};
pub use raster::{
    Cap, Drawn, Paint, Painted, RasterError, RasterOptions, Smoothing, are_behind, boxes_in_sight,
    hides_within, kept_bounds, rasterize,
};
pub use raycast::{Cast, Medium, RaycastError, RaycastOptions, Raycaster, Scatter, raycast};
pub use shading::Channel;
pub use splat::{Splatted, splat};
pub use texture::{Pattern, SolidTexture, TextureError};
pub use transfer::{
    ControlPoint, Material, Mixture, MixtureError, OpticalModel, Peak, SlopeError, SlopeFunction,
    TransferError, TransferFunction, full_slope,
};
pub(crate) use trilinear::Trilinear;

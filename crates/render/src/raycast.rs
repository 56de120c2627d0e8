//! Volume ray casting: along the ray of each pixel the colours and opacities of values are gathered, front to back
//! (Levoy 1988, "Display of surfaces from volume data"; Drebin, Carpenter & Hanrahan 1988 for what is gathered).
//!
//! Values between samples are those of trilinear interpolation, taken in the middle of each of the steps into which
//! a ray's way through the volume is cut; the last is shorter, and its opacity is corrected to its length, so that
//! one substance gathers the same at any length of step. A sample that is NaN hides nothing.
//!
//! Two things are not computed, and counted: steps in blocks of which no value can be seen (`clear.rs`), which changes
//! no bit of the picture; and steps behind what is as good as opaque ([`RaycastOptions::opaque`]).
//! Values are f32: of samples that are i32, u32 or f64 what differs by less than a ten-millionth is one value.
//!
//! What it does not do: colours and opacities change linearly within a step only as far as values do. A transfer
//! function with peaks narrower than the change of value in one step needs shorter steps.

mod march;

use crate::{
    Camera, Gathered, Image, Light, OpticalModel, Size, clear::Clear, gather::OPAQUE,
    transfer::Lookup,
};
use isokit_geom::HalfSpace;
use isokit_job::{Job, Stopped};
use isokit_lanes::exactly;
use isokit_volume::{Bricks, Sample, View};
use march::March;
use rayon::prelude::*;

/// A volume, and what is seen of it.
#[derive(Clone, Copy, Debug)]
pub struct Medium<'a, T> {
    /// The samples.
    pub view: &'a View<'a, T>,
    /// Where in it which values are, if that is known. Changes time only. Bricks are of use if they are those of the
    /// samples; others, with other sizes, are left aside.
    pub bricks: Option<&'a Bricks<T>>,
    /// What its places look like.
    pub model: &'a OpticalModel,
    /// What is kept of it: what is in all of these.
    pub clips: &'a [HalfSpace],
}

/// How rays are cast, and samples are laid on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RaycastOptions {
    /// The length of a step, or from sheet to sheet, in units of the smallest spacing. Changes the picture: it is off by O(step²) where the
    /// transfer function is smooth. Default: 0.5.
    pub step: f64,
    /// The length, in world units, over which the opacities of the transfer function are gathered. Changes the
    /// picture. Default: `None`, the smallest spacing.
    pub unit: Option<f64>,
    /// How gradients are lit; `None` leaves colours as they are. Changes the picture. Default:
    /// [`Light::DEFAULT`].
    pub light: Option<Light>,
    /// With so much opacity nothing behind is looked at. Changes the picture, by no more than what is left to 1 in each part of
    /// a colour. Default: 1 − 2⁻¹³, of which 8 bits show nothing, in the dark either.
    pub opaque: f32,
}

impl RaycastOptions {
    /// The defaults named above.
    pub const DEFAULT: Self =
        Self { step: 0.5, unit: None, light: Some(Light::DEFAULT), opaque: OPAQUE };

    /// The same options with another `step`.
    pub const fn with_step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// The same options with another `unit`.
    pub const fn with_unit(mut self, unit: Option<f64>) -> Self {
        self.unit = unit;
        self
    }

    /// The same options with another `light`.
    pub const fn with_light(mut self, light: Option<Light>) -> Self {
        self.light = light;
        self
    }

    /// The same options with another `opaque`.
    pub const fn with_opaque(mut self, opaque: f32) -> Self {
        self.opaque = opaque;
        self
    }
}

impl Default for RaycastOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What was computed for a picture, and what was not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cast {
    /// Steps whose value was looked at.
    pub steps: u64,
    /// Steps in blocks of cells of which nothing can be seen.
    pub steps_leapt: u64,
    /// Steps behind what is as good as opaque.
    pub steps_hidden: u64,
}

impl Cast {
    fn with(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            steps_leapt: self.steps_leapt + other.steps_leapt,
            steps_hidden: self.steps_hidden + other.steps_hidden,
        }
    }
}

/// Why there is no picture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RaycastError {
    /// The caller's fault: a length of no use.
    #[error(
        "{what} is {value}: it must be above 0, and no more than {most:e} of them in the volume's edges"
    )]
    Length {
        /// Which one.
        what: &'static str,
        /// How long it would be, in world units.
        value: f64,
        /// How many of them the three edges of the volume may have together.
        most: f64,
    },
    /// The job was cancelled, or allows less memory.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Rows of pixels that are cast together.
const BAND: usize = 4;

/// The most steps that fit along the three edges of a volume. No ray through it has more, but for rounding.
pub(crate) const MOST_STEPS: f64 = 1e6;

/// The picture of a volume: its values through a transfer function.
///
/// The picture is the same, byte for byte, for any number of threads, and with bricks or without.
///
/// # Errors
///
/// If a length is not above 0, is infinite, or so short that the three edges of the volume together have more than a
/// million; if the job is cancelled or does not allow the picture's memory.
pub fn raycast<T: Sample>(
    medium: &Medium<'_, T>,
    (camera, size): (&Camera, Size),
    options: &RaycastOptions,
    job: &Job,
) -> Result<(Image, Cast), RaycastError> {
    let (step, unit) = lengths(medium.view, options)?;
    let mut image = Image::new(size, &job.limits).map_err(Stopped::from)?;
    let width = size.width.get() as usize;
    job.progress.begin("render", u64::from(size.height.get()));
    let done = exactly(|| {
        let lookup = Lookup::new(medium.model, step / unit, step);
        let view = medium.view;
        let bricks = medium.bricks.filter(|bricks| bricks.grid().dims() == view.dims());
        let clear = bricks.map(|bricks| Clear::new(view, bricks, &lookup, job)).transpose()?;
        let march = March::new(medium, (&lookup, clear.as_ref()), step, options);
        let middle = |n: usize| n as f64 + 0.5;
        let band = |(band, pixels): (usize, &mut [Gathered])| {
            exactly(|| {
                job.check()?;
                let rows = pixels.len() / width;
                // Down, then to the right, so that rays that are near each other follow each other.
                let rays = (0..pixels.len()).map(|n| {
                    let (column, row) = (n / rows, n % rows);
                    let at = [column, band * BAND + row].map(middle);
                    (row * width + column, camera.pixel_ray(size, at))
                });
                let mut done = Cast::default();
                march.along(rays, pixels, &mut done);
                job.progress.advance(rows as u64);
                Ok(done)
            })
        };
        let bands = image.pixels_mut().par_chunks_mut(width * BAND).enumerate();
        // Sums of whole numbers are the same in any order.
        let both = |a: Cast, b: Cast| Ok::<_, Stopped>(a.with(b));
        job.threads.run(|| bands.map(band).try_reduce(Cast::default, both))
    })?;
    Ok((image, done))
}

/// The length of a step, and that over which opacities are gathered, in world units.
pub(crate) fn lengths<T: Sample>(
    view: &View<'_, T>,
    options: &RaycastOptions,
) -> Result<(f64, f64), RaycastError> {
    let spacing = view.frame().index_to_world.spacing();
    let smallest = spacing.into_iter().fold(f64::INFINITY, f64::min);
    let (step, unit) = (options.step * smallest, options.unit.unwrap_or(smallest));
    let across: f64 = (0..3).map(|axis| view.dims()[axis] as f64 * spacing[axis]).sum();
    for (what, value) in [("the step", step), ("the reference length", unit)] {
        if !(value > 0.0 && value.is_finite() && across / value <= MOST_STEPS) {
            return Err(RaycastError::Length { what, value, most: MOST_STEPS });
        }
    }
    Ok((step, unit))
}

#[cfg(test)]
mod tests;

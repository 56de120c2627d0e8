//! Volume ray casting: along the ray of each pixel the colours and opacities of values are gathered, front to back
//! (Levoy 1988, "Display of surfaces from volume data"; Drebin, Carpenter & Hanrahan 1988 for what is gathered).
//!
//! Values between samples are those of trilinear interpolation, or of cubics (`cubic.rs`), taken in the middle of each of
//! the steps into which a ray's way through the volume is cut, or at both ends of it ([`RaycastOptions::integrated`]); the
//! last is shorter, and its opacity is corrected to its length, so that one substance gathers the same at any length of
//! step. A sample that is NaN hides nothing.
//!
//! Two things are not computed, and counted: steps in blocks of which no value can be seen (`clear.rs`), and along rays
//! beside all others (`seen.rs`), which changes no bit of the picture; and steps behind what is as good as opaque
//! ([`RaycastOptions::opaque`]).
//!
//! Particles may scatter light that comes from a side (`cloud.rs`).
//!
//! Values are f32: of samples that are i32, u32 or f64 what differs by less than a ten-millionth is one value.
//!
//! What it does not do: with the middle of steps a transfer function with peaks narrower than the change of value in
//! one step needs shorter ones.

mod cloud;
mod cubic;
mod ends;
mod march;
mod options;
mod seen;
mod way;

use crate::{
    Camera, Gathered, Image, Kernel, OpticalModel, Size,
    clear::{Around, Clear, MOST_MARGIN},
    transfer::Lookup,
};
use isokit_geom::HalfSpace;
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::exactly;
use isokit_volume::{Bricks, Sample, View};
use march::March;
use seen::Seen;
use way::{Pixel, Ways};

pub(crate) use cloud::Cloud;
pub use cloud::Scatter;
pub use options::RaycastOptions;
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

/// What was computed for a picture, and what was not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cast {
    /// Steps whose value was looked at.
    pub steps: u64,
    /// Steps in blocks of cells of which nothing can be seen.
    pub steps_leapt: u64,
    /// Steps behind what is as good as opaque.
    pub steps_hidden: u64,
    /// Pixels that were cast once more with shorter steps, each time.
    pub pixels_refined: u64,
}

impl Cast {
    fn with(self, other: Self) -> Self {
        Self {
            steps: self.steps + other.steps,
            steps_leapt: self.steps_leapt + other.steps_leapt,
            steps_hidden: self.steps_hidden + other.steps_hidden,
            pixels_refined: self.pixels_refined + other.pixels_refined,
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
/// As [`Raycaster::new`] and [`Raycaster::picture`].
pub fn raycast<T: Sample>(
    medium: &Medium<'_, T>,
    camera: (&Camera, Size),
    options: &RaycastOptions,
    job: &Job,
) -> Result<(Image, Cast), RaycastError> {
    Ok(Raycaster::new(medium, options, job)?.picture(camera, job)?)
}

/// A volume made ready for pictures of it from any place: where something can be seen in it, and what its values look
/// like.
#[derive(Debug)]
pub struct Raycaster<'a, T> {
    medium: Medium<'a, T>,
    options: RaycastOptions,
    /// The length of a step, and that over which opacities are gathered, in world units.
    step: f64,
    unit: f64,
    lookup: Lookup<'a>,
    clear: Option<Clear>,
}

impl<'a, T: Sample> Raycaster<'a, T> {
    /// Finds out where something can be seen, if there are bricks.
    ///
    /// # Errors
    ///
    /// If a length is not above 0, is infinite, or so short that the three edges of the volume together have more than a
    /// million; if the job is cancelled, or does not allow a byte for each block of 4³ cells.
    pub fn new(
        medium: &Medium<'a, T>,
        options: &RaycastOptions,
        job: &Job,
    ) -> Result<Self, RaycastError> {
        let (view, (step, unit)) = (medium.view, lengths(medium.view, options)?);
        exactly(|| {
            let lookup = looked_up(medium.model, (step, unit), options);
            // A step may be seen that reaches out of its block with an end.
            let least = view.frame().index_to_world.least_stretch();
            let reach = if lookup.has_integrals() { 0.5 * step / least } else { 0.0 };
            let is_cubic = options.kernel == Kernel::CatmullRom;
            let margin = (reach * (1.0 + 1e-6)).ceil() as usize + usize::from(is_cubic);
            let around = Around { margin, is_cubic };
            let bricks = medium.bricks.filter(|bricks| bricks.grid().dims() == view.dims());
            let clear = bricks
                .filter(|_| margin <= MOST_MARGIN)
                .map(|bricks| Clear::new(view, bricks, (&lookup, around), job))
                .transpose()?;
            Ok(Self { medium: *medium, options: *options, step, unit, lookup, clear })
        })
    }

    /// The picture from one place.
    ///
    /// # Errors
    ///
    /// If the job is cancelled or does not allow the picture's memory.
    pub fn picture(
        &self,
        (camera, size): (&Camera, Size),
        job: &Job,
    ) -> Result<(Image, Cast), Stopped> {
        let Self { medium, options, step, unit, .. } = self;
        let cloud = exactly(|| Cloud::new(medium, *unit, (options.scatter, camera), job))?;
        let mut image = Image::new(size, &job.limits).map_err(Stopped::from)?;
        let rays = Rays { caster: self, camera, cloud: cloud.as_ref() };
        let mut done = rays.cast((*step, &self.lookup), None, &mut image, job)?;
        let Some(error) = options.error else { return Ok((image, done)) };
        // Each time of those pixels that differed, with steps half as long.
        let mut wanted: Vec<bool> = job
            .limits
            .vec("pixels to be cast again", Some(size.pixels()))
            .map_err(Stopped::from)?;
        wanted.resize(image.pixels().len(), true);
        let across = across(medium.view);
        let steps = (1..=MOST_HALVINGS).map(|halving| step / f64::from(1 << halving));
        for step in steps.take_while(|step| across / step <= MOST_STEPS) {
            let lookup = exactly(|| looked_up(medium.model, (step, *unit), options));
            let mut finer = Image::new(size, &job.limits).map_err(Stopped::from)?;
            finer.pixels_mut().copy_from_slice(image.pixels());
            done = done.with(rays.cast((step, &lookup), Some(&wanted), &mut finer, job)?);
            let pairs = image.pixels().iter().zip(finer.pixels());
            let mut left = 0;
            for (wanted, (coarse, fine)) in wanted.iter_mut().zip(pairs) {
                done.pixels_refined += u64::from(*wanted);
                *wanted &= coarse.differs(*fine) > error;
                left += u64::from(*wanted);
            }
            image = finer;
            if left == 0 {
                break;
            }
        }
        Ok((image, done))
    }
}

/// A model for steps of such a length.
fn looked_up<'a>(
    model: &'a OpticalModel,
    (step, unit): (f64, f64),
    options: &RaycastOptions,
) -> Lookup<'a> {
    let lookup = Lookup::new(model, step / unit, step);
    if options.integrated { lookup.with_integrals() } else { lookup }
}

/// Steps are halved no more often.
const MOST_HALVINGS: u32 = 6;

/// All that the rays of a picture have in common, whatever the length of their steps.
struct Rays<'a, T> {
    caster: &'a Raycaster<'a, T>,
    camera: &'a Camera,
    cloud: Option<&'a Cloud>,
}

impl<T: Sample> Rays<'_, T> {
    /// Casts the rays of all pixels, or of those that are wanted, in steps of such a length.
    fn cast(
        &self,
        (step, lookup): (f64, &Lookup<'_>),
        wanted: Option<&[bool]>,
        image: &mut Image,
        job: &Job,
    ) -> Result<Cast, Stopped> {
        let Self { caster: Raycaster { medium, options, clear, .. }, camera, cloud } = *self;
        let size = image.size();
        let width = size.width.get() as usize;
        job.progress.begin("render", u64::from(size.height.get()));
        let affine = &medium.view.frame().index_to_world;
        let seen = exactly(|| match clear {
            Some(clear) => Seen::new((clear, affine), (camera, size), job),
            None => Ok(None),
        })?;
        let Some(ways) = Ways::new(medium, (camera, size), (step, seen)) else {
            job.progress.advance(u64::from(size.height.get()));
            return Ok(Cast::default());
        };
        let march = March::new(medium, (lookup, clear.as_ref(), cloud), options);
        let band: Work<'_, _, _> = &|(band, pixels): (usize, &mut [Gathered])| {
            exactly(|| {
                job.check()?;
                let rows = pixels.len() / width;
                let wanted = wanted.map(|wanted| &wanted[band * BAND * width..]);
                // Down, then to the right, so that rays that are near each other follow each other.
                let places = (0..width).flat_map(|column| (0..rows).map(move |row| [column, row]));
                let pixels_of = places.filter_map(|[column, row]| {
                    let number = row * width + column;
                    if wanted.is_some_and(|wanted| !wanted[number]) {
                        return None;
                    }
                    let place = [column, band * BAND + row];
                    let begin = if options.jitter { grain(place) } else { 0.0 };
                    Some(Pixel { number, place: place.map(|n| n as f64 + 0.5), begin })
                });
                let ways = ways.of(pixels_of);
                let mut done = Cast::default();
                march.along(ways, pixels, &mut done);
                job.progress.advance(rows as u64);
                Ok(done)
            })
        };
        let bands = image.pixels_mut().par_chunks_mut(width * BAND).enumerate();
        job.threads.run(|| bands.map(band).try_reduce(Cast::default, both))
    }
}

/// Sums of whole numbers are the same in any order.
fn both(a: Cast, b: Cast) -> Result<Cast, Stopped> {
    Ok(a.with(b))
}

/// A number from 0 to 1 for each pixel, such that those around a pixel are spread (Jimenez 2014, "Next generation
/// post-processing in Call of Duty: Advanced Warfare": interleaved gradient noise).
fn grain([column, row]: [usize; 2]) -> f64 {
    let sum = 0.06711056 * column as f64 + 0.00583715 * row as f64;
    (52.9829189 * sum.fract()).fract()
}

/// How long the three edges of a volume are together.
fn across<T: Sample>(view: &View<'_, T>) -> f64 {
    let spacing = view.frame().index_to_world.spacing();
    (0..3).map(|axis| view.dims()[axis] as f64 * spacing[axis]).sum()
}

/// The length of a step, and that over which opacities are gathered, in world units.
pub(crate) fn lengths<T: Sample>(
    view: &View<'_, T>,
    options: &RaycastOptions,
) -> Result<(f64, f64), RaycastError> {
    let spacing = view.frame().index_to_world.spacing();
    let smallest = spacing.into_iter().fold(f64::INFINITY, f64::min);
    let (step, unit) = (options.step * smallest, options.unit.unwrap_or(smallest));
    let across = across(view);
    for (what, value) in [("the step", step), ("the reference length", unit)] {
        if !(value > 0.0 && value.is_finite() && across / value <= MOST_STEPS) {
            return Err(RaycastError::Length { what, value, most: MOST_STEPS });
        }
    }
    Ok((step, unit))
}

#[cfg(test)]
mod tests;

//! Isosurfaces without a mesh: along each ray, where what is between samples has the value.
//!
//! A ray goes from cell to cell (Amanatides & Woo 1987, "A fast voxel traversal algorithm for ray tracing"). In a cell
//! the values along it are a cubic, whose crossings are between the places where it turns (`cell.rs`; Marmitt,
//! Kleer, Wald, Friedrich & Slusallek 2004, "Fast and accurate ray-voxel intersection techniques for iso-surface
//! ray tracing"). Where a kernel makes cubics of samples, it is a polynomial of degree 9 (`nonic.rs`). Whether the ray
//! is inside is handed from cell to cell, so that it goes in and out by turns whatever rounding does: what a ray meets
//! is what it meets of a closed surface.
//!
//! What is beyond the volume is outside: a surface is closed by caps along the border, as the mesh of the extractor is.
//! A cell with a sample that is NaN is outside. Bricks that no surface goes through are passed in one step, which
//! changes no bit of the picture.

mod cell;
mod function;
mod nonic;
mod root;
mod walk;

use crate::{
    Camera, Cap, Gathered, Image, Interpolant, Kernel, Paint, RasterError, RasterOptions, Size,
    clear::{near, on_border},
    shading::Shading,
};
use isokit_geom::HalfSpace;
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::{Side, exactly};
use isokit_volume::{Bricks, Sample, Sides, View};
use rayon::prelude::*;
use walk::Walk;

/// The isosurfaces of a volume.
#[derive(Clone, Copy)]
pub struct Isosurfaces<'a, T> {
    /// The samples.
    pub view: &'a View<'a, T>,
    /// Where in it which values are, if that is known. Changes time only. Bricks are of use if they are those of the
    /// samples; others, with other sizes, are left aside.
    pub bricks: Option<&'a Bricks<T>>,
    /// How values between samples are made of them.
    pub kernel: Kernel,
    /// The surfaces.
    pub surfaces: &'a [Isosurface<'a>],
    /// What closes the holes that planes cut.
    pub caps: &'a [Cap<'a>],
}

/// One of them.
#[derive(Clone, Copy)]
pub struct Isosurface<'a> {
    /// The value on it; finite.
    pub iso: f64,
    /// Its colour.
    pub paint: Paint<'a>,
    /// How much of what is behind it hides, each time that a ray meets it, from 0 to 1.
    pub opacity: f32,
    /// What is kept of it: what is in all of these.
    pub clips: &'a [HalfSpace],
}

/// What was computed for a picture, and what was not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traced {
    /// Cells whose corners were looked at.
    pub cells: u64,
    /// Bricks that were passed in one step.
    pub bricks_passed: u64,
    /// How often a surface was met and lit.
    pub lit: u64,
}

impl Traced {
    fn with(self, other: Self) -> Self {
        Self {
            cells: self.cells + other.cells,
            bricks_passed: self.bricks_passed + other.bricks_passed,
            lit: self.lit + other.lit,
        }
    }
}

/// The picture of the isosurfaces of a volume. With [`Smoothing`](crate::Smoothing) as many rays go through each pixel
/// as it has points.
///
/// It is the same, byte for byte, for any number of threads, and with bricks or without.
///
/// # Errors
///
/// If the job is cancelled or does not allow the picture's memory.
pub fn isocast<T: Sample>(
    scene: &Isosurfaces<'_, T>,
    (camera, size): (&Camera, Size),
    options: &RasterOptions,
    job: &Job,
) -> Result<(Image, Traced), RasterError> {
    let mut image = Image::new(size, &job.limits)?;
    let width = size.width.get() as usize;
    job.progress.begin("render", u64::from(size.height.get()));
    let seen: Vec<_> =
        scene.surfaces.iter().copied().filter(|surface| surface.opacity > 0.0).collect(); // not NaN
    let bricks = scene.bricks.filter(|bricks| bricks.grid().dims() == scene.view.dims());
    let sides: Option<Vec<Sides>> =
        bricks.map(|bricks| seen.iter().map(|surface| sides(scene, bricks, surface)).collect());
    let threshold = |surface: &Isosurface<'_>| scene.view.scaling().threshold(surface.iso);
    let thresholds: Vec<_> = seen.iter().map(threshold).collect();
    let opaque: Vec<_> = seen.iter().copied().filter(|surface| surface.opacity >= 1.0).collect();
    let quiet = job.unwatched();
    let bounds = scene.view.grid().bounds();
    let shading = Shading::new(camera, options, Some(bounds), |view, options| {
        let scene = Isosurfaces { surfaces: &opaque, ..*scene };
        Ok::<_, RasterError>(isocast(&scene, view, options, &quiet)?.0)
    })?;
    let walk = Walk {
        field: Interpolant::new(*scene.view, scene.kernel),
        surfaces: &seen,
        thresholds: &thresholds,
        sides: sides.as_deref(),
        caps: scene.caps,
        shading: &shading,
    };
    let points = options.smoothing.places();
    let share = 1.0 / points.len() as f32;
    let row: Work<'_, _, _> = &|(row, pixels): (usize, &mut [Gathered])| {
        exactly(|| {
            job.check()?;
            let (mut known, mut traced) = (walk.begin(), Traced::default());
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let mut sum = Gathered::NOTHING;
                for [x, y] in &points {
                    let ray = camera.pixel_ray(size, [column as f64 + x, row as f64 + y]);
                    sum = sum.plus(walk.along(&ray, &mut known, &mut traced));
                }
                *pixel = sum.times(share);
            }
            job.progress.advance(1);
            Ok(traced)
        })
    };
    let rows = image.pixels_mut().par_chunks_mut(width).enumerate();
    let traced = job.threads.run(|| rows.map(row).try_reduce(Traced::default, both))?;
    Ok((image, traced))
}

/// Sums of whole numbers are the same in any order.
fn both(a: Traced, b: Traced) -> Result<Traced, Stopped> {
    Ok(a.with(b))
}

/// On which side of a surface bricks are.
fn sides<T: Sample>(
    scene: &Isosurfaces<'_, T>,
    bricks: &Bricks<T>,
    surface: &Isosurface<'_>,
) -> Sides {
    let scaling = scene.view.scaling();
    let mut sides = bricks.sides(scaling.threshold(surface.iso));
    if scene.kernel == Kernel::Linear {
        return sides;
    }
    // Cubics look at samples of other bricks, and lead beyond them.
    let (grid, [nx, ny, _]) = (sides.grid, sides.grid.counts());
    for (number, side) in sides.of_brick.iter_mut().enumerate() {
        let brick = [number % nx, number / nx % ny, number / nx / ny];
        let all = near(bricks, brick, 1).reduce(|a, b| a.with(b));
        let range = all.and_then(|all| all.range()).map(|range| range.map(Sample::to_f64));
        let Some(range) = range.filter(|_| *side != Side::Both) else { continue };
        let reach = Interpolant::<T>::reach(range, true, on_border(brick, grid.counts()));
        let [a, b] = reach.map(|stored| scaling.value(stored));
        let slack = 1e-13 * a.abs().max(b.abs());
        let is_sure = match side {
            Side::Inside => a.min(b) - slack >= surface.iso,
            _ => a.max(b) + slack < surface.iso,
        };
        if !is_sure {
            *side = Side::Both;
        }
    }
    sides
}

#[cfg(test)]
mod tests;

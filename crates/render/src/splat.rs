//! Splatting: the picture of a volume from the side of its samples (Westover 1990, "Footprint evaluation for volume
//! rendering").
//!
//! Each sample is laid on sheets that are parallel to the picture, front to back, whatever the axes of the volume: so
//! nothing pops when the camera turns (Mueller & Crawfis 1998, "Eliminating popping artifacts in sheet buffer-based
//! splatting"). What it gives to a sheet is its footprint: the integral of a round kernel across the sheet
//! (`footprint.rs`). In the space of the samples the kernel is a ball; so where spacings differ footprints are ellipses,
//! and a perspective shows them as large as they are (`sheet.rs`).
//!
//! On a sheet values are added up, not colours: what they look like, and how they face the light by the differences to
//! the pixels and sheets around, is found when a sheet is complete (Mueller, Möller & Crawfis 1999, "Splatting without the
//! blur"). It is then put behind what was gathered before (`tile.rs`).
//!
//! Not computed, and counted, are samples so far from everything that can be seen that they give nothing to it, and
//! sheets behind what is as good as opaque.

mod footprint;
mod sheet;
mod tile;

use crate::{
    Camera, Gathered, Image, Medium, RaycastError, RaycastOptions, Size, Trilinear,
    clear::{Around, CELLS, Clear},
    raycast::{Cloud, lengths},
    transfer::Lookup,
};
use footprint::Footprint;
use isokit_job::{Job, Stopped, Work};
use isokit_lanes::exactly;
use isokit_volume::Sample;
use rayon::prelude::*;
use sheet::{Block, Sheets};
use tile::{TILE, Tiles};

/// What was computed for a picture, and what was not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Splatted {
    /// How often a sample was laid on a sheet.
    pub splats: u64,
    /// Samples of the volume.
    pub samples: u64,
    /// Those that give nothing to what can be seen, or are beside the picture.
    pub samples_skipped: u64,
    /// Sheets behind what is as good as opaque, once for each part of the picture.
    pub sheets_hidden: u64,
}

impl Splatted {
    fn with(self, other: Self) -> Self {
        Self {
            splats: self.splats + other.splats,
            samples: self.samples + other.samples,
            samples_skipped: self.samples_skipped + other.samples_skipped,
            sheets_hidden: self.sheets_hidden + other.sheets_hidden,
        }
    }
}

/// The picture of a volume: its samples, laid on each other.
///
/// The picture is the same, byte for byte, for any number of threads, and with bricks or without. Values between samples
/// are means of those around, so noise is softer than in a ray's picture, and so is what is as small as a sample. A place
/// near a sample that is NaN is not seen.
///
/// # Errors
///
/// As [`raycast`](crate::raycast).
pub fn splat<T: Sample>(
    medium: &Medium<'_, T>,
    (camera, size): (&Camera, Size),
    options: &RaycastOptions,
    job: &Job,
) -> Result<(Image, Splatted), RaycastError> {
    let (step, unit) = lengths(medium.view, options)?;
    let mut image = Image::new(size, &job.limits).map_err(Stopped::from)?;
    let (view, width) = (medium.view, size.width.get() as usize);
    let field = Trilinear::new(*view);
    let Some(sheets) = Sheets::new(&field, (camera, size), step) else {
        return Ok((image, Splatted::default())); // nothing of it is before the camera
    };
    let splatted = exactly(|| {
        let cloud = Cloud::new(medium, unit, (options.scatter, camera), job)?;
        let lookup = Lookup::new(medium.model, step / unit, step);
        let bricks = medium.bricks.filter(|bricks| bricks.grid().dims() == view.dims());
        let clear = bricks
            .map(|bricks| Clear::new(view, bricks, (&lookup, Around::default()), job))
            .transpose()?;
        // Around what can be seen: what gives to it, and what gives to its neighbours on and across sheets.
        let reach = ((2.0 * sheets.reach() + sheets.pitch()) / CELLS as f64).ceil();
        let near = (reach < f64::from(u8::MAX)).then_some(reach as u8); // or else all
        let blocks = blocks(view.dims(), clear.as_ref().zip(near), &sheets, job)?;
        let laid: u64 = blocks.iter().map(Block::samples).sum();
        let all: u64 = view.dims().iter().map(|&n| n as u64).product();
        let footprint = Footprint::new(sheets.thickness());
        let tiles = Tiles {
            medium,
            field,
            camera,
            size,
            sheets: &sheets,
            footprint: &footprint,
            lookup: &lookup,
            cloud: cloud.as_ref(),
            options,
        };
        let bins = bins(&blocks, size, job)?;
        job.progress.begin("render", bins.len() as u64);
        job.limits.probe("parts of the picture", Some(size.pixels()), size_of::<Gathered>())?;
        let tile: Work<'_, _, _> = &|(number, bin): (usize, &Vec<u32>)| {
            exactly(|| {
                job.check()?;
                let drawn = tiles.draw(number, &blocks, bin, job)?;
                job.progress.advance(1);
                Ok::<_, Stopped>(drawn)
            })
        };
        let drawn: Vec<_> =
            job.threads.run(|| bins.par_iter().enumerate().map(tile).collect::<Result<_, _>>())?;
        let samples_skipped = all - laid;
        let mut done = Splatted { samples: all, samples_skipped, ..Splatted::default() };
        for (number, (pixels, of_tile)) in drawn.into_iter().enumerate() {
            let [left, top] = tiles.corner(number);
            for (row, pixels) in pixels.chunks(tiles.extent(number)[0]).enumerate() {
                let from = (top + row) * width + left;
                image.pixels_mut()[from..from + pixels.len()].copy_from_slice(pixels);
            }
            done = done.with(of_tile);
        }
        Ok::<_, Stopped>(done)
    })?;
    Ok((image, splatted))
}

/// The blocks of a volume that give to the picture: all, or those near to what can be seen.
fn blocks(
    dims: [usize; 3],
    clear: Option<(&Clear, u8)>,
    sheets: &Sheets,
    job: &Job,
) -> Result<Vec<Block>, Stopped> {
    let counts = dims.map(|n| (n - 1).div_ceil(CELLS).max(1));
    let most = counts.iter().map(|&n| n as u64).product();
    let mut blocks = job.limits.vec("blocks of the volume", Some(most))?;
    let block = |block: [usize; 3]| {
        let samples = std::array::from_fn(|k| {
            let end = if block[k] + 1 == counts[k] { dims[k] } else { (block[k] + 1) * CELLS };
            [block[k] * CELLS, end]
        });
        sheets.block(samples)
    };
    match clear {
        Some((clear, near)) => blocks.extend(clear.near(near).filter_map(block)),
        None => {
            let [nx, ny, nz] = counts;
            let all = (0..nx * ny * nz).map(|n| [n % nx, n / nx % ny, n / nx / ny]);
            blocks.extend(all.filter_map(block));
        }
    }
    Ok(blocks)
}

/// The blocks that give to each tile, those of the first sheets first.
fn bins(blocks: &[Block], size: Size, job: &Job) -> Result<Vec<Vec<u32>>, Stopped> {
    let [columns, rows] = [size.width, size.height].map(|n| (n.get() as usize).div_ceil(TILE));
    let of = |block: &Block| block.pixels.map(|[first, last]| first / TILE..last / TILE + 1);
    let entries: u64 =
        blocks.iter().map(|block| of(block).iter().map(|r| r.len() as u64).product::<u64>()).sum();
    job.limits.probe("blocks of parts of the picture", Some(entries), size_of::<u32>())?;
    let mut bins = vec![vec![]; columns * rows];
    let mut order: Vec<u32> = (0..blocks.len() as u32).collect();
    order.sort_by_key(|&n| blocks[n as usize].sheets[0]);
    for number in order {
        let [x, y] = of(&blocks[number as usize]);
        for (row, column) in y.flat_map(|row| x.clone().map(move |column| (row, column))) {
            bins[row * columns + column].push(number);
        }
    }
    Ok(bins)
}

#[cfg(test)]
mod tests;

//! From a solid to samples of it.
//!
//! Blocks of 16³ samples are done one by one, by all threads. In a block sixteen samples at a time look for what is nearest
//! (`isokit_lanes::BoxTree`), from the boxes on that can hold something nearest to any sample of the block, and first at
//! what was nearest to the sixteen before them. Which side samples are on is found once for all that are joined by steps
//! that cannot cross the surface (the module `sides`).

mod colors;
mod sides;

pub use colors::voxelize_with_colors;

use crate::{MeshSolid, bvh::Below, bvh::squared_to_box, paint::Paint};
use isokit_geom::Affine;
use isokit_job::{Cancelled, Job, OverLimit, Stopped};
use isokit_lanes::{COMPANY, Company, exactly};
use isokit_volume::{AnyVolume, Grid, Volume};
use rayon::prelude::*;
use sides::Sides;

/// What samples say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum VoxelMode {
    /// How far the surface is, f32, in world units; positive inside.
    #[default]
    Distance,
    /// 1 inside, 0 outside, u8.
    Occupancy,
}

/// How a solid is sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct VoxelOptions {
    /// What samples say. Default: [`VoxelMode::Distance`].
    pub mode: VoxelMode,
    /// How far from the surface distances are told, in world units; farther out it is this one, with its sign. Costs less
    /// the smaller it is. Default: everywhere.
    pub band: Option<f64>,
    /// Whether thin walls are kept. Default: [`Walls::AsTheyAre`].
    pub walls: Walls,
}

impl VoxelOptions {
    fn check(&self) -> Result<(), VoxelError> {
        match self.band {
            Some(band) if band.is_nan() || band <= 0.0 => Err(VoxelError::Band(band)),
            _ => Ok(()),
        }
    }
}

/// What becomes of walls that are thinner than samples are apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Walls {
    /// Samples within the solid are inside. A wall that holds no sample vanishes.
    #[default]
    AsTheyAre,
    /// Samples no farther from the solid than half the longest diagonal of a cell are inside too, and distances are those
    /// to the surface of the solid that is grown by so much. Of any point of the mesh, be it of a sheet without
    /// thickness, the nearest sample is inside.
    Kept,
}

/// Why a solid is not sampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VoxelError {
    /// The caller's fault.
    #[error("a band is wider than 0, found {0}")]
    Band(f64),
    /// There are no colours to be told.
    #[error("the mesh has no colours of vertices")]
    NoColors,
    /// It was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<OverLimit> for VoxelError {
    fn from(over: OverLimit) -> Self {
        Self::Stopped(over.into())
    }
}

impl From<Cancelled> for VoxelError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Stopped(cancelled.into())
    }
}

/// Samples along one side of a block.
pub(crate) const BLOCK: usize = 16;

/// Boxes that a block's samples start from, at most.
const ROOTS: usize = 48;

/// Samples of a solid.
///
/// Distances are rounded to f32 once, from f64; they are exact but for that and the rounding of f64, and of triangles so thin
/// that they have no normal, which count as their edges. A sample is inside if the winding number there says so, as
/// [`Inside`](crate::Inside) reads it; a sample on the surface is.
///
/// # Errors
///
/// If the band is not above 0, the volume is larger than the job allows, or the job is cancelled.
pub fn voxelize(
    solid: &MeshSolid,
    grid: Grid,
    options: &VoxelOptions,
    job: &Job,
) -> Result<AnyVolume, VoxelError> {
    options.check()?;
    let lattice = Lattice::new(solid, &grid, options);
    volume(&lattice, grid, options.mode, &mut [], job)
}

/// All samples, from distances; `colors` has room for as many bytes as their colours have, none if there are to be none.
fn volume(
    lattice: &Lattice<'_>,
    grid: Grid,
    mode: VoxelMode,
    colors: &mut [u8],
    job: &Job,
) -> Result<AnyVolume, VoxelError> {
    match mode {
        VoxelMode::Distance => {
            let told = lattice.told;
            let sample = |distance: f64| (distance + lattice.grown).clamp(-told, told) as f32;
            let samples = sampled(lattice, sample, colors, job)?;
            Ok(Volume::new(grid, samples).expect("one sample for each point").into())
        }
        VoxelMode::Occupancy => {
            let sample = |distance: f64| u8::from(distance + lattice.grown >= 0.0);
            let samples = sampled(lattice, sample, colors, job)?;
            Ok(Volume::new(grid, samples).expect("one sample for each point").into())
        }
    }
}

/// Half the longest diagonal of a cell.
pub(crate) fn half_diagonal(index_to_world: &Affine) -> f64 {
    let ways = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let long = ways.map(|[y, z]| isokit_geom::vector::length(index_to_world.vector([1.0, y, z])));
    0.5 * long.into_iter().fold(0.0, f64::max)
}

/// Samples that are to be found.
pub(crate) struct Lattice<'a> {
    solid: &'a MeshSolid,
    index_to_world: Affine,
    dims: [usize; 3],
    /// Farther than this nothing is looked for, in world units.
    band: f64,
    /// Farther than this distances are not told, once `grown` is added.
    told: f64,
    /// What is added to distances.
    grown: f64,
    /// The colours that samples get; none if they are to get none.
    paint: Option<&'a Paint>,
}

impl<'a> Lattice<'a> {
    pub(crate) fn new(solid: &'a MeshSolid, grid: &Grid, options: &VoxelOptions) -> Self {
        let told = options.band.unwrap_or(f64::INFINITY);
        let index_to_world = grid.frame.index_to_world;
        let grown = match options.walls {
            Walls::AsTheyAre => 0.0,
            Walls::Kept => half_diagonal(&index_to_world),
        };
        let band = match options.mode {
            VoxelMode::Distance => told + grown,
            VoxelMode::Occupancy => 0.0,
        };
        // So that steps between samples that are farther from the surface can be told from those that cross it.
        let band = band.max(half_diagonal(&index_to_world) * 1.001);
        let dims = grid.dims().map(|n| n as usize);
        Self { solid, index_to_world, dims, band, told, grown, paint: None }
    }

    /// The distances of a block of no more than 16³ samples with their signs, x fastest, in world units, of which none is
    /// farther from 0 than the band; and the bytes of the colours.
    pub(crate) fn block(&self, from: [usize; 3], size: [usize; 3]) -> (Vec<f64>, Vec<u8>) {
        let Nearest { mut distances, facets } = nearest(self, from, size);
        let colors = colors::of_block(self, from, size, &facets);
        Sides::new(self, from, size, &mut distances).decide();
        (distances, colors)
    }

    /// Where a sample is, as the solid computes.
    fn point(&self, ijk: [usize; 3]) -> [f64; 3] {
        let xyz = self.index_to_world.point(ijk.map(|c| c as f64));
        self.solid.place().inward(xyz)
    }
}

/// All samples of a lattice, from their distances with a sign; and their colours, if there is room for them.
fn sampled<T: Copy + Default + Send + Sync>(
    lattice: &Lattice<'_>,
    sample: impl Fn(f64) -> T + Sync,
    colors: &mut [u8],
    job: &Job,
) -> Result<Vec<T>, VoxelError> {
    let [nx, ny, nz] = lattice.dims;
    let count = (nx as u64).checked_mul(ny as u64).and_then(|n| n.checked_mul(nz as u64));
    let mut samples: Vec<T> = job.limits.zeroed("the volume", count)?;
    let [across, up, deep] = lattice.dims.map(|n| n.div_ceil(BLOCK));
    job.progress.begin("voxelize", (across * up * deep) as u64);
    for z in 0..deep {
        let block = |n: usize| {
            job.check()?;
            let from = [n % across * BLOCK, n / across * BLOCK, z * BLOCK];
            let size = [0, 1, 2].map(|k| BLOCK.min(lattice.dims[k] - from[k]));
            let found = exactly(|| {
                let (distances, colors) = lattice.block(from, size);
                (distances.into_iter().map(&sample).collect::<Vec<T>>(), colors)
            });
            job.progress.advance(1);
            Ok((from, size, found))
        };
        let blocks = job.threads.run(|| {
            (0..across * up).into_par_iter().map(block).collect::<Result<Vec<_>, Cancelled>>()
        })?;
        for (from, size, (found, of_found)) in blocks {
            put(&mut samples, lattice.dims, (from, size), &found);
            put(colors, lattice.dims, (from, size), &of_found);
        }
    }
    Ok(samples)
}

/// Puts what was found for a block, so many items for each sample as there are, among what all samples have.
fn put<T: Copy>(
    all: &mut [T],
    [nx, ny, _]: [usize; 3],
    (from, size): ([usize; 3], [usize; 3]),
    found: &[T],
) {
    let each = found.len() / size.iter().product::<usize>();
    if each == 0 {
        return;
    }
    for (row, found) in found.chunks_exact(each * size[0]).enumerate() {
        let [y, z] = [from[1] + row % size[1], from[2] + row / size[1]];
        let first = each * ((z * ny + y) * nx + from[0]);
        all[first..first + found.len()].copy_from_slice(found);
    }
}

/// What is nearest to the samples of a block, x fastest.
struct Nearest {
    /// How far it is, in world units; none is above the band.
    distances: Vec<f64>,
    /// Which facet it is; [`NONE`] where there is none within the band.
    facets: Vec<u32>,
}

/// No facet.
const NONE: u32 = u32::MAX;

fn nearest(lattice: &Lattice<'_>, from: [usize; 3], size: [usize; 3]) -> Nearest {
    let solid = lattice.solid;
    let scale = solid.place().scale();
    let mut distances = vec![lattice.band; size.iter().product()];
    let mut facets = vec![NONE; distances.len()];
    let band = lattice.band / scale;
    let Some(roots) = roots(lattice, from, size) else { return Nearest { distances, facets } };
    let tree = solid.bvh().tree();
    let mut company =
        Company { points: [[0.0; COMPANY]; 3], squared: [0.0; COMPANY], facet: [NONE; COMPANY] };
    let (mut likely, mut known) = ([0; 4], 0);
    let steps = [4, 2, 2];
    let packs = [0, 1, 2].map(|k| size[k].div_ceil(steps[k]));
    for n in 0..packs.iter().product() {
        let first = there_and_back(n, packs, steps);
        let at = |lane: usize| {
            let ijk = [lane % 4, lane / 4 % 2, lane / 8];
            // Beside the block the last ones come again.
            [0, 1, 2].map(|k| (first[k] + ijk[k]).min(size[k] - 1))
        };
        for lane in 0..COMPANY {
            let ijk = at(lane);
            let point = lattice.point([0, 1, 2].map(|k| from[k] + ijk[k]));
            (0..3).for_each(|k| company.points[k][lane] = point[k]);
        }
        company.squared = [band * band; COMPANY];
        company.facet = [NONE; COMPANY];
        tree.find(&roots, &likely[..known], &mut company);
        known = 0;
        for lane in 0..COMPANY {
            let facet = company.facet[lane];
            if facet != NONE && known < likely.len() && !likely[..known].contains(&facet) {
                likely[known] = facet;
                known += 1;
            }
            let [i, j, k] = at(lane);
            let sample = (k * size[1] + j) * size[0] + i;
            let distance = company.squared[lane].sqrt() * scale;
            distances[sample] = distance.min(lattice.band);
            facets[sample] = facet;
        }
    }
    Nearest { distances, facets }
}

/// The first sample of a pack; packs that follow each other are neighbours.
fn there_and_back(n: usize, packs: [usize; 3], steps: [usize; 3]) -> [usize; 3] {
    let [x, y, z] = [n % packs[0], n / packs[0] % packs[1], n / (packs[0] * packs[1])];
    let y = if z % 2 == 1 { packs[1] - 1 - y } else { y };
    let x = if n / packs[0] % 2 == 1 { packs[0] - 1 - x } else { x };
    [x * steps[0], y * steps[1], z * steps[2]]
}

/// Boxes that hold all that can be nearest to a sample of a block; none if nothing is within the band of any.
fn roots(lattice: &Lattice<'_>, from: [usize; 3], size: [usize; 3]) -> Option<Vec<u32>> {
    let solid = lattice.solid;
    let bvh = solid.bvh();
    let middle = [0, 1, 2].map(|k| from[k] as f64 + 0.5 * (size[k] - 1) as f64);
    let centre = solid.place().inward(lattice.index_to_world.point(middle));
    // A little more than the distance to the farthest sample.
    let half = size.map(|n| 0.5 * (n - 1) as f64);
    let radius = farthest(&lattice.index_to_world, half) / solid.place().scale() * (1.0 + 1e-9);
    let far = lattice.band / solid.place().scale() + radius;
    let distance = solid.nearest(centre)?.1.squared.sqrt();
    if distance > far * (1.0 + 1e-9) {
        return None;
    }
    let within = (distance + 2.0 * radius).min(far) * (1.0 + 1e-9);
    let mut roots = vec![0];
    let mut next = 0;
    while next < roots.len() && roots.len() < ROOTS {
        match bvh.below(roots[next] as usize) {
            Below::Facets(_) => next += 1,
            Below::Boxes(two) => {
                roots.swap_remove(next);
                let near =
                    |at: &usize| squared_to_box(centre, &bvh.boxes()[*at]) <= within * within;
                roots.extend(two.into_iter().filter(near).map(|at| at as u32));
            }
        }
    }
    let far = |root: &u32| squared_to_box(centre, &bvh.boxes()[*root as usize]);
    roots.sort_by(|a, b| far(a).total_cmp(&far(b)));
    Some(roots)
}

/// How far the corners of a box of index space are from its middle, of half the sides.
pub(crate) fn farthest(index_to_world: &Affine, [x, y, z]: [f64; 3]) -> f64 {
    let ways = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let long =
        ways.map(|[b, c]| isokit_geom::vector::length(index_to_world.vector([x, b * y, c * z])));
    long.into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;

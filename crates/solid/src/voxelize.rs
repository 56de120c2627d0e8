//! From a solid to samples of it.
//!
//! Blocks of 16³ samples are done one by one, by all threads. In a block sixteen samples at a time look for what is nearest
//! (`isokit_lanes::BoxTree`), from the boxes on that can hold something nearest to any sample of the block, and first at
//! what was nearest to the sixteen before them. Which side samples are on is found once for all that are joined by steps
//! that cannot cross the surface (the module `sides`).

mod sides;

use crate::{MeshSolid, bvh::Below, bvh::squared_to_box};
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
    if let Some(band) = options.band.filter(|&band| band.is_nan() || band <= 0.0) {
        return Err(VoxelError::Band(band));
    }
    let lattice = Lattice::new(solid, &grid, options);
    match options.mode {
        VoxelMode::Distance => {
            let band = options.band.unwrap_or(f64::INFINITY);
            let sample = |distance: f64| (distance + lattice.grown).clamp(-band, band) as f32;
            let samples = sampled(&lattice, job, sample)?;
            Ok(Volume::new(grid, samples).expect("one sample for each point").into())
        }
        VoxelMode::Occupancy => {
            let samples = sampled(&lattice, job, |d| u8::from(d + lattice.grown >= 0.0))?;
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
    /// What is added to distances.
    grown: f64,
}

impl<'a> Lattice<'a> {
    pub(crate) fn new(solid: &'a MeshSolid, grid: &Grid, options: &VoxelOptions) -> Self {
        let index_to_world = grid.frame.index_to_world;
        let grown = match options.walls {
            Walls::AsTheyAre => 0.0,
            Walls::Kept => half_diagonal(&index_to_world),
        };
        let band = match options.mode {
            VoxelMode::Distance => options.band.unwrap_or(f64::INFINITY) + grown,
            VoxelMode::Occupancy => 0.0,
        };
        // So that steps between samples that are farther from the surface can be told from those that cross it.
        let band = band.max(half_diagonal(&index_to_world) * 1.001);
        Self { solid, index_to_world, dims: grid.dims().map(|n| n as usize), band, grown }
    }

    /// The distances of a block of no more than 16³ samples with their signs, x fastest, in world units; none is farther from 0
    /// than the band.
    pub(crate) fn block(&self, from: [usize; 3], size: [usize; 3]) -> Vec<f64> {
        let mut distances = distances(self, from, size);
        Sides::new(self, from, size, &mut distances).decide();
        distances
    }

    /// Where a sample is, as the solid computes.
    fn point(&self, ijk: [usize; 3]) -> [f64; 3] {
        let xyz = self.index_to_world.point(ijk.map(|c| c as f64));
        self.solid.place().inward(xyz)
    }
}

/// All samples of a lattice, from their distances with a sign.
fn sampled<T: Copy + Default + Send + Sync>(
    lattice: &Lattice<'_>,
    job: &Job,
    sample: impl Fn(f64) -> T + Sync,
) -> Result<Vec<T>, VoxelError> {
    let [nx, ny, nz] = lattice.dims;
    let count = (nx as u64).checked_mul(ny as u64).and_then(|n| n.checked_mul(nz as u64));
    let mut samples: Vec<T> = job.limits.zeroed("the volume", count)?;
    let [across, up, deep] = lattice.dims.map(|n| n.div_ceil(BLOCK));
    job.progress.begin("voxelize", (across * up * deep) as u64);
    for (z, slab) in samples.chunks_mut(nx * ny * BLOCK).enumerate() {
        let block = |n: usize| {
            job.check()?;
            let from = [n % across * BLOCK, n / across * BLOCK, z * BLOCK];
            let size = [0, 1, 2].map(|k| BLOCK.min(lattice.dims[k] - from[k]));
            let found =
                exactly(|| lattice.block(from, size).into_iter().map(&sample).collect::<Vec<T>>());
            job.progress.advance(1);
            Ok((from, size, found))
        };
        let blocks = job.threads.run(|| {
            (0..across * up).into_par_iter().map(block).collect::<Result<Vec<_>, Cancelled>>()
        })?;
        for (from, size, found) in blocks {
            for (row, found) in found.chunks_exact(size[0]).enumerate() {
                let [y, z] = [from[1] + row % size[1], row / size[1]];
                let first = (z * ny + y) * nx + from[0];
                slab[first..first + size[0]].copy_from_slice(found);
            }
        }
    }
    Ok(samples)
}

/// The distances of a block, x fastest, in world units; none is above the band.
fn distances(lattice: &Lattice<'_>, from: [usize; 3], size: [usize; 3]) -> Vec<f64> {
    let solid = lattice.solid;
    let scale = solid.place().scale();
    let mut distances = vec![lattice.band; size.iter().product()];
    let band = lattice.band / scale;
    let Some(roots) = roots(lattice, from, size) else { return distances };
    let tree = solid.bvh().tree();
    let mut company = Company {
        points: [[0.0; COMPANY]; 3],
        squared: [0.0; COMPANY],
        facet: [u32::MAX; COMPANY],
    };
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
        company.facet = [u32::MAX; COMPANY];
        tree.find(&roots, &likely[..known], &mut company);
        known = 0;
        for lane in 0..COMPANY {
            let facet = company.facet[lane];
            if facet != u32::MAX && known < likely.len() && !likely[..known].contains(&facet) {
                likely[known] = facet;
                known += 1;
            }
            let [i, j, k] = at(lane);
            let distance = company.squared[lane].sqrt() * scale;
            distances[(k * size[1] + j) * size[0] + i] = distance.min(lattice.band);
        }
    }
    distances
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

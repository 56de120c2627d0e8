//! The colour of what is nearest, for each sample: what was found for its distance is known, and only mixed once more.

use super::{Lattice, NONE, VoxelError, VoxelMode, VoxelOptions, half_diagonal, volume};
use crate::{MeshSolid, distance::near, paint::Paint};
use isokit_job::Job;
use isokit_volume::{AnyVolume, Channels, ColorVolume, Grid};

/// Samples of a solid as [`voxelize`](super::voxelize) makes them, and the colour of the nearest point of the surface at each.
///
/// A colour is that of [`MeshSolid::color`]: between vertices it is linear in sRGB codes. It has three numbers, and a fourth for
/// opacity if something shows through some vertex. Of points that are as near, one is taken: at a place always the same one.
///
/// With a band, samples have no colour that are farther from the surface than the band and the longest diagonal of a cell
/// together: they are black, and with a fourth number nothing shows of them. So all corners of a cell have one that the surface
/// of a distance within the band goes through. Without a band, and with [`VoxelMode::Occupancy`], all samples have one.
/// [`Walls::Kept`](super::Walls::Kept) adds what walls are grown by.
///
/// ```
/// use isokit_geom::{Space, Unit};
/// use isokit_job::Job;
/// use isokit_mesh::{Attributes, Positions, Rgba, TriMesh};
/// use isokit_solid::{MeshSolid, VoxelOptions, grid_around, voxelize_with_colors};
///
/// // One triangle, red where x is 0 and blue where it is 1.
/// let [red, blue] = [[255, 0, 0, 255], [0, 0, 255, 255]].map(Rgba);
/// let mesh = TriMesh {
///     positions: Positions::F64(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]),
///     triangles: vec![[0, 1, 2]],
///     attributes: Attributes { values: None, colors: Some(vec![red, blue, red]) },
///     ..TriMesh::default()
/// };
/// let job = Job::default();
/// let solid = MeshSolid::new(&mesh, Default::default(), &job)?;
/// let grid = grid_around(solid.bounds(), [0.2; 3], 1, Unit::Millimetre, Space::Unknown)?;
/// let (distances, colors) = voxelize_with_colors(&solid, grid, &VoxelOptions::default(), &job)?;
/// assert_eq!(distances.grid(), colors.grid());
///
/// // The second row of the second slice runs along the first edge.
/// let row = &colors.samples()[3 * 8 * (8 + 1)..];
/// assert_eq!(row[3..9], [255, 0, 0, 204, 0, 51]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// If the solid is of a mesh without colours; else as [`voxelize`](super::voxelize).
pub fn voxelize_with_colors(
    solid: &MeshSolid,
    grid: Grid,
    options: &VoxelOptions,
    job: &Job,
) -> Result<(AnyVolume, ColorVolume), VoxelError> {
    let paint = solid.paint().ok_or(VoxelError::NoColors)?;
    options.check()?;
    let lattice = Lattice::new(solid, &grid, options).painted(paint, options);
    let channels = channels(paint);
    let bytes = grid.count().checked_mul(channels.count() as u64);
    let mut colors: Vec<u8> = job.limits.zeroed("the volume of colours", bytes)?;
    let volume = volume(&lattice, grid, options.mode, &mut colors, job)?;
    let colors = ColorVolume::new(grid, channels, colors).expect("one colour for each point");
    Ok((volume, colors))
}

fn channels(paint: &Paint) -> Channels {
    if paint.is_opaque() { Channels::Rgb } else { Channels::Rgba }
}

impl<'a> Lattice<'a> {
    /// The same with colours, for which it may be looked farther.
    fn painted(self, paint: &'a Paint, options: &VoxelOptions) -> Self {
        let least = match options.mode {
            // From corners of a cell with a point of which the distance is told, it is no farther than this.
            VoxelMode::Distance => {
                self.told + self.grown + 2.0 * half_diagonal(&self.index_to_world) * 1.001
            }
            VoxelMode::Occupancy => f64::INFINITY,
        };
        Self { band: self.band.max(least), paint: Some(paint), ..self }
    }
}

/// The bytes of all colours of a block, by what is nearest to each sample; none if there are to be none.
pub(super) fn of_block(
    lattice: &Lattice<'_>,
    from: [usize; 3],
    size: [usize; 3],
    facets: &[u32],
) -> Vec<u8> {
    let Some(paint) = lattice.paint else { return vec![] };
    let (count, all) = (channels(paint).count(), lattice.solid.bvh().facets());
    let mut bytes = Vec::with_capacity(count * facets.len());
    for (n, &facet) in facets.iter().enumerate() {
        let ijk = [n % size[0], n / size[0] % size[1], n / (size[0] * size[1])];
        let color = match facet {
            NONE => [0; 4],
            facet => {
                let point = lattice.point([0, 1, 2].map(|k| from[k] + ijk[k]));
                paint.mixed(facet, near(point, &all[facet as usize]).shares()).0
            }
        };
        bytes.extend(&color[..count]);
    }
    bytes
}

#[cfg(test)]
mod tests;

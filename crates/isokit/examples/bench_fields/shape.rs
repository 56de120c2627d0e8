//! Shapes that become meshes, and how good meshes are, whoever made them.

use crate::{Failure, timed};
use isokit::{
    field::{FieldSamples, FieldSlices, Jet, ScalarField, Slope},
    geom::{
        Aabb, Affine,
        vector::{cross, length, sub},
    },
    io::read_mesh,
    job::Job,
    marching_cubes::{Budget, ExtractOptions, Extracted, Slabs, extract_slabs, extract_sparse},
    mesh::{TriMesh, topology},
    refine::{Isosurface, RefineOptions, refine},
    solid::{Model, Placed, Solid},
    volume::Grid,
};
use serde::{Deserialize, Serialize};
use std::{
    fs::{self, File},
    io::BufReader,
    ops::Range,
    path::Path,
};

/// How a shape becomes a mesh.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum How {
    /// With samples near the surface.
    Sparse,
    /// The same, and with vertices on its creases.
    Creases,
    /// The same, and balanced.
    Balanced,
    /// With all samples, of which those in a brick cost what the brick's part of the shape costs.
    Bricks,
    /// With all samples, each made of the whole shape.
    Dense,
}

/// What a mesh is like.
#[derive(Debug, Serialize)]
pub(super) struct Judged {
    triangles: u64,
    /// Root mean square over the mesh of the distance to the surface, value over slope.
    rms: f64,
    /// The greatest.
    most: f64,
    /// Edges that are not those of two triangles, and vertices in which fans touch.
    open: u64,
    nonmanifold: u64,
}

/// Degrees between faces that meet in a crease.
const CREASES: f64 = 30.0;

/// Triangles that are looked at; of more, one in so many.
const LOOKED_AT: usize = 200_000;

/// A field that is as dear in a part as in whole.
struct Whole<'a>(&'a Placed);

impl ScalarField for Whole<'_> {
    fn dims(&self) -> [usize; 3] {
        self.0.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.0.index_to_world()
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        self.0.value(ijk)
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        self.0.slope(ijk)
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        self.0.jet(ijk)
    }

    fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        self.0.fill(points, values);
    }
}

/// A shape in a file.
fn solid(path: &Path) -> Result<Solid, Failure> {
    Ok(serde_json::from_reader::<_, Model>(BufReader::new(File::open(path)?))?.build()?)
}

/// The middle of a shape and the longest side of its box.
fn middle_and_side(solid: &Solid) -> Result<([f64; 3], f64), Failure> {
    let Aabb { min, max } = solid.bounds().ok_or("the shape has no end")?;
    let side = (0..3).map(|k| max[k] - min[k]).fold(0.0, f64::max);
    Ok(([0, 1, 2].map(|k| 0.5 * (min[k] + max[k])), side))
}

/// A lattice with so many samples along the longest side of a shape; two of them on each end are around it.
fn lattice(solid: &Solid, samples: u32) -> Result<Grid, Failure> {
    let (_, side) = middle_and_side(solid)?;
    Ok(solid.grid([side / f64::from(samples - 5); 3])?)
}

/// How a shape becomes a mesh: the seconds, the samples that were made, and what the mesh is like.
pub(super) fn mesh(
    path: &Path,
    samples: u32,
    how: How,
    job: &Job,
) -> Result<(f64, u64, Judged), Failure> {
    let solid = solid(path)?;
    let grid = lattice(&solid, samples)?;
    let placed = solid.placed(&grid);
    let whole = Whole(&placed);
    let options = &ExtractOptions::DEFAULT;
    let mut mesh = TriMesh::with_normals();
    let (seconds, told) = timed(|| -> Result<Extracted, Failure> {
        if let How::Sparse | How::Creases | How::Balanced = how {
            let source = FieldSamples::<f32>::new(&placed, grid.frame)?;
            let told = extract_sparse(&source, 0.0, options, &mut mesh.refill(), job)?;
            if let How::Creases | How::Balanced = how {
                let surface = Isosurface { field: &placed, iso: 0.0 };
                let options = RefineOptions::DEFAULT.with_creases(CREASES);
                let options = options.with_balance(matches!(how, How::Balanced));
                refine(&mut mesh, &surface, &options, job)?;
            }
            return Ok(told);
        }
        let field: &dyn ScalarField = if let How::Dense = how { &whole } else { &placed };
        let source = &mut FieldSlices::new(FieldSamples::<f32>::new(field, grid.frame)?, job);
        let budget = Budget { window: 64, piece_bytes: u64::MAX };
        let slabs = Slabs { isos: &[0.0], options, budget };
        let sinks = &mut vec![mesh.refill()];
        Ok(extract_slabs(source, &slabs, sinks, job)?.remove(0))
    });
    Ok((seconds, told?.skipped.samples_read, judge(&mesh, &solid)?))
}

/// What a mesh in a file is like, beside a shape.
pub(super) fn judge_file(path: &Path, mesh: &Path) -> Result<Judged, Failure> {
    let mut surfaces = read_mesh(mesh, &Job::default())?.surfaces;
    judge(&surfaces.pop().ok_or("no mesh")?.mesh, &solid(path)?)
}

fn judge(mesh: &TriMesh, solid: &Solid) -> Result<Judged, Failure> {
    let found = topology(mesh, &Job::default())?;
    // In coordinates of the world, a unit apart.
    let field = solid.placed(&Grid::new([1; 3], Default::default())?);
    let every = mesh.triangles.len().div_ceil(LOOKED_AT).max(1);
    let (mut squares, mut area, mut most) = (0.0, 0.0, 0.0_f64);
    for triangle in mesh.triangles.iter().step_by(every) {
        let corners = triangle.map(|vertex| mesh.positions.get(vertex as usize));
        let [a, b, c] = corners;
        let own = 0.5 * length(cross(sub(b, a), sub(c, a)));
        // Exact for polynomials of the second degree; Strang & Fix, "An analysis of the finite element method", 1973.
        for [p, q] in [[a, b], [b, c], [c, a]] {
            let far = distance(&field, [0, 1, 2].map(|k| 0.5 * (p[k] + q[k])));
            squares += own / 3.0 * far * far;
            most = most.max(far);
        }
        area += own;
    }
    Ok(Judged {
        triangles: mesh.triangles.len() as u64,
        rms: (squares / area).sqrt(),
        most,
        open: found.boundary_edges,
        nonmanifold: found.nonmanifold_edges + found.nonmanifold_vertices,
    })
}

/// How far a point near the surface is from it.
fn distance(field: &Placed, point: [f64; 3]) -> f64 {
    let Slope { value, gradient } = field.slope(point);
    value.abs() / length(gradient).max(f64::MIN_POSITIVE)
}

/// Writes the steps of a shape; the middle and half the side of a cube around it.
pub(super) fn list(path: &Path, out: &Path) -> Result<([f64; 3], f64), Failure> {
    let solid = solid(path)?;
    fs::write(out, solid.listing().ok_or("a step has no word in listings")?)?;
    let (middle, side) = middle_and_side(&solid)?;
    Ok((middle, 0.52 * side))
}

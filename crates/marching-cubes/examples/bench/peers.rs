//! Extractors by others, written in Rust. Both know f32, one thread, and the value 0, inside negative.

use crate::{
    Contender, Failure,
    protocol::{Answer, Diagonals, Extract, Load, Placement, Request, Topology, timed},
};
use fast_surface_nets::{
    SurfaceNetsBuffer,
    ndshape::{RuntimeShape, Shape},
    surface_nets,
};
use isosurface::{
    distance::Signed,
    extractor::{IndexedInterleavedNormals, IndexedVertices},
    math::Vec3,
    sampler::Sampler,
    source::{HermiteSource, ScalarSource},
};

/// The samples as a distance: below 0 inside. Made off the clock.
fn distances(load: &Load) -> Result<Vec<f32>, Failure> {
    match load.dtype.as_str() {
        "f32" => Ok(load.samples::<f32>()?.iter().map(|v| load.iso as f32 - v).collect()),
        other => Err(format!("f32 only, not {other}").into()),
    }
}

/// What both can do of what can be asked.
fn one_thread(request: Request) -> Result<Extract, Failure> {
    match request {
        Request::Extract(extract) if extract.threads != 1 => Err("one thread only".into()),
        Request::Extract(extract) if extract.placement != Placement::Linear => {
            Err("linear placement only".into())
        }
        Request::Extract(extract) if extract.topology != Topology::Table => {
            Err("a table's topology only".into())
        }
        Request::Extract(extract) if extract.diagonals != Diagonals::Table => {
            Err("a table's diagonals only".into())
        }
        Request::Extract(extract) => Ok(extract),
        _ => Err("extracts only".into()),
    }
}

/// `fast-surface-nets`: one vertex per cell, two triangles per crossed edge, always with normals.
pub(crate) struct SurfaceNets {
    distances: Vec<f32>,
    dims: [u32; 3],
    kept: SurfaceNetsBuffer,
}

impl SurfaceNets {
    pub(crate) fn open(load: &Load) -> Result<Self, Failure> {
        let dims = load.dims.map(|n| n as u32);
        Ok(Self { distances: distances(load)?, dims, kept: SurfaceNetsBuffer::default() })
    }
}

impl Contender for SurfaceNets {
    fn answer(&mut self, request: Request) -> Result<Answer, Failure> {
        let request = one_thread(request)?;
        if !request.normals {
            return Err("always makes normals".into());
        }
        let shape = RuntimeShape::<u32, 3>::new(self.dims);
        debug_assert_eq!(shape.usize(), self.distances.len());
        let mut fresh = SurfaceNetsBuffer::default();
        let out = if request.warm { &mut self.kept } else { &mut fresh };
        let last = self.dims.map(|n| n - 1);
        let (answer, ()) = timed(|| surface_nets(&self.distances, &shape, [0; 3], last, out));
        let (vertices, triangles) = (out.positions.len() as u64, out.indices.len() as u64 / 3);
        Ok(Answer { vertices: Some(vertices), triangles: Some(triangles), ..answer })
    }
}

/// `isosurface`: marching cubes over a function on the unit cube, for us one that looks samples up.
pub(crate) struct MarchingCubes {
    lattice: Lattice,
    kept: [Vec<f32>; 2],
    kept_indices: Vec<u32>,
}

struct Lattice {
    distances: Vec<f32>,
    points: usize,
}

impl MarchingCubes {
    pub(crate) fn open(load: &Load) -> Result<Self, Failure> {
        let [points, ny, nz] = load.dims;
        if [ny, nz] != [points; 2] {
            return Err("cubes only".into());
        }
        let lattice = Lattice { distances: distances(load)?, points };
        Ok(Self { lattice, kept: [vec![], vec![]], kept_indices: vec![] })
    }
}

impl Contender for MarchingCubes {
    fn answer(&mut self, request: Request) -> Result<Answer, Failure> {
        let request = one_thread(request)?;
        let (mut fresh, mut fresh_indices) = (vec![], vec![]);
        let (out, indices) = match request.warm {
            true => (&mut self.kept[usize::from(request.normals)], &mut self.kept_indices),
            false => (&mut fresh, &mut fresh_indices),
        };
        out.clear();
        indices.clear();
        let (lattice, sampler) = (&self.lattice, Sampler::new(&self.lattice));
        let (answer, ()) = timed(|| {
            let mut cubes = isosurface::MarchingCubes::<Signed>::new(lattice.points);
            match request.normals {
                true => cubes
                    .extract(&sampler, &mut IndexedInterleavedNormals::new(out, indices, &sampler)),
                false => cubes.extract(&sampler, &mut IndexedVertices::new(out, indices)),
            }
        });
        let per_vertex = if request.normals { 6 } else { 3 };
        let vertices = (out.len() / per_vertex) as u64;
        let triangles = indices.len() as u64 / 3;
        Ok(Answer { vertices: Some(vertices), triangles: Some(triangles), ..answer })
    }
}

impl Lattice {
    /// The sample nearest to a point. Beyond the last it is the last: the crate asks for one layer more
    /// than there is.
    fn nearest(&self, p: Vec3) -> [usize; 3] {
        let last = self.points - 1;
        [p.x, p.y, p.z].map(|c| ((c * last as f32).round() as usize).min(last))
    }

    fn at(&self, [x, y, z]: [usize; 3]) -> f32 {
        self.distances[x + self.points * (y + self.points * z)]
    }
}

impl ScalarSource for Lattice {
    fn sample_scalar(&self, p: Vec3) -> Signed {
        Signed(self.at(self.nearest(p)))
    }
}

impl HermiteSource for Lattice {
    /// The difference of neighbours, at the sample nearest to the vertex.
    fn sample_normal(&self, p: Vec3) -> Vec3 {
        let here = self.nearest(p);
        let [x, y, z] = std::array::from_fn(|axis| {
            let (mut low, mut high) = (here, here);
            low[axis] = here[axis].saturating_sub(1);
            high[axis] = (here[axis] + 1).min(self.points - 1);
            self.at(high) - self.at(low)
        });
        Vec3::new(x, y, z)
    }
}

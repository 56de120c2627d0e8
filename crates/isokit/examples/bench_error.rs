//! isokit as a contender of `scripts/bench_error`: from samples in memory to a mesh in memory, on the clock.
//!
//! Requests and answers are JSON, one object a line, on stdin and stdout, as those of the example `bench` in
//! `marching-cubes`. That one knows the extraction alone; this one also divides and balances. Reading the
//! volume, and giving memory back, are outside of every time.

use isokit::{
    job::{Job, Threads},
    lanes::prefer_large_pages,
    marching_cubes::{
        Boundary, Degenerate, Diagonals, ExtractOptions, Gradient, Nan, Placement, Topology,
    },
    mesh::{Positions, Precision, TriMesh},
    pipeline::{Normals, Scan, SurfaceOptions},
    refine::{RefineOptions, Subdivision},
    volume::{Dtype, Grid, Sample, Volume, for_dtype},
};
use serde::{Deserialize, Serialize};
use std::{
    fs::File,
    io::{BufRead, BufWriter, Read, Write, stdin, stdout},
    num::NonZeroUsize,
    path::{Path, PathBuf},
    time::Instant,
};

type Failure = Box<dyn std::error::Error>;

/// A piece of work.
#[derive(Debug, Deserialize)]
#[serde(tag = "op", rename_all = "kebab-case")]
enum Request {
    /// Take a volume into memory: raw, x fastest, in this machine's byte order.
    Load { path: PathBuf, dims: [u64; 3], dtype: String, iso: f64 },
    /// Make the surface, and forget it.
    Extract(Making),
    /// Make the surface and write it: positions as f64, normals as f32, triangles as u32, one after another.
    Save { out: PathBuf, making: Making },
}

/// How the surface is to be made.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Making {
    threads: usize,
    placement: PlacementName,
    topology: TopologyName,
    /// Whether normals are of the placement's order.
    matching: bool,
    /// Whether diagonals are fitted.
    fitted: bool,
    /// Whether vertices may lie on samples.
    exact: bool,
    /// Whether positions are kept as f64.
    double: bool,
    /// How often every edge is divided.
    refine: u32,
    /// By how much triangles may leave the surface, in samples.
    max_error: Option<f64>,
    balance: bool,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum PlacementName {
    Linear,
    Cubic,
    Quintic,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum TopologyName {
    Table,
    Trilinear,
}

/// What was found.
#[derive(Debug, Default, Serialize)]
struct Answer {
    /// Wall time.
    seconds: f64,
    vertices: usize,
    triangles: usize,
    /// If an error was named, the greatest that a triangle may have, in samples, and how many triangles have none.
    #[serde(skip_serializing_if = "Option::is_none")]
    bound: Option<(Option<f64>, u64)>,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

fn main() -> Result<(), Failure> {
    let mut state = State { scan: None, iso: 0.0, job: (0, Job::default()) };
    for line in stdin().lock().lines() {
        let request: Request = serde_json::from_str(&line?)?;
        let answer = state.answer(request);
        let failed = |why: Failure| Answer { error: Some(why.to_string()), ..Answer::default() };
        let mut out = stdout().lock();
        serde_json::to_writer(&mut out, &answer.unwrap_or_else(failed))?;
        out.write_all(b"\n")?;
        out.flush()?;
    }
    Ok(())
}

/// A volume in memory, and threads that wait.
struct State {
    scan: Option<Scan>,
    iso: f64,
    /// The job, and how many threads it has: no request pays for the start of a thread.
    job: (usize, Job),
}

impl State {
    fn answer(&mut self, request: Request) -> Result<Answer, Failure> {
        match request {
            Request::Load { path, dims, dtype, iso } => {
                let dtype = Dtype::from_name(&dtype).ok_or("no such type of sample")?;
                self.scan = None; // before there are two
                self.scan = Some(for_dtype!(dtype, T => Scan::new(read::<T>(&path, dims)?)));
                self.iso = iso;
                Ok(Answer::default())
            }
            Request::Extract(making) => Ok(self.make(&making)?.0),
            Request::Save { out, making } => {
                let (answer, mesh) = self.make(&making)?;
                write(&out, &mesh)?;
                Ok(answer)
            }
        }
    }

    /// The surface in fresh memory.
    fn make(&mut self, making: &Making) -> Result<(Answer, TriMesh), Failure> {
        if self.job.0 != making.threads {
            let count = NonZeroUsize::new(making.threads).ok_or("threads are one or more")?;
            let job = Job { threads: Threads::new(count)?, ..Job::default() };
            // The first work of a pool starts it.
            job.threads.run(|| ());
            self.job = (making.threads, job);
        }
        let (scan, job) = (self.scan.as_ref().ok_or("nothing is loaded")?, &self.job.1);
        let (surface, refining) = (surface(making), refining(making)?);
        let start = Instant::now();
        let mut mesh = scan.mesh(self.iso, &surface.before(&refining), job)?;
        let refined = scan.refine(self.iso, &mut mesh, (&refining, &surface), job)?;
        let seconds = start.elapsed().as_secs_f64();
        let (vertices, triangles) = (mesh.positions.len(), mesh.triangles.len());
        let bound = making.max_error.map(|_| (refined.bound, refined.unbounded));
        Ok((Answer { seconds, vertices, triangles, bound, error: None }, mesh))
    }
}

fn surface(making: &Making) -> SurfaceOptions {
    let placement = match making.placement {
        PlacementName::Linear => Placement::Linear,
        PlacementName::Cubic => Placement::Cubic,
        PlacementName::Quintic => Placement::Quintic,
    };
    let topology = match making.topology {
        TopologyName::Table => Topology::Table,
        TopologyName::Trilinear => Topology::Trilinear,
    };
    let degenerate = if making.exact { Degenerate::Exact } else { Degenerate::default() };
    let precision = if making.double { Precision::F64 } else { Precision::F32 };
    let extract = ExtractOptions::DEFAULT.with_boundary(Boundary::Open).with_nan(Nan::Outside);
    let gradient = if making.matching { Gradient::Matching } else { Gradient::Central };
    let extract = extract.with_placement(placement).with_gradient(gradient).with_topology(topology);
    let diagonals = if making.fitted { Diagonals::Fitted } else { Diagonals::Table };
    let extract = extract
        .with_diagonals(diagonals)
        .with_degenerate(degenerate)
        .with_precision(Some(precision));
    SurfaceOptions::default().with_extract(extract).with_normals(Normals::Gradient)
}

fn refining(making: &Making) -> Result<RefineOptions, Failure> {
    let subdivision = match (making.refine, making.max_error) {
        (0, None) => Subdivision::None,
        (levels, None) => Subdivision::Levels(levels),
        (0, Some(error)) => Subdivision::MaxError(error),
        _ => return Err("either so many divisions or an error".into()),
    };
    Ok(RefineOptions::DEFAULT.with_subdivision(subdivision).with_balance(making.balance))
}

fn read<T: Sample>(path: &Path, dims: [u64; 3]) -> Result<Volume<T>, Failure> {
    let grid = Grid::new(dims, Default::default())?;
    let mut samples = vec![T::zeroed(); usize::try_from(grid.count())?];
    prefer_large_pages(&mut samples); // numpy does the same for the peers
    File::open(path)?.read_exact(bytemuck::cast_slice_mut(&mut samples))?;
    Ok(Volume::new(grid, samples)?)
}

fn write(path: &Path, mesh: &TriMesh) -> Result<(), Failure> {
    let mut out = BufWriter::new(File::create(path)?);
    match &mesh.positions {
        Positions::F64(all) => out.write_all(bytemuck::cast_slice(all))?,
        Positions::F32(all) => {
            let wide: Vec<_> = all.iter().map(|place| place.map(f64::from)).collect();
            out.write_all(bytemuck::cast_slice(&wide))?;
        }
    }
    let normals = mesh.normals.as_ref().ok_or("the mesh has no normals")?;
    out.write_all(bytemuck::cast_slice(normals))?;
    out.write_all(bytemuck::cast_slice(&mesh.triangles))?;
    Ok(out.flush()?)
}

//! isokit as a contender of `scripts/bench_fields`: from samples in memory to other samples, or to what is known of all of
//! them, on the clock.
//!
//! Requests and answers are JSON, one object a line, on stdin and stdout, as those of the example `bench_error`. Reading
//! the volume is outside of all times.

mod mesh;
mod shape;

use isokit::{
    field::Filter,
    job::{Job, Threads},
    mesh::TriMesh,
    pipeline::Scan,
    volume::{AnyVolume, Dtype, Grid, Sample, Volume, for_any, for_dtype},
};
use mesh::Around;
use serde::{Deserialize, Serialize};
use shape::{How, Judged};
use std::{
    fs::File,
    hint::black_box,
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
    /// Take a volume into memory: raw, x fastest, in this machine's byte order, samples 1 apart.
    Load { path: PathBuf, dims: [u64; 3], dtype: String },
    /// Other samples of it by a cubic B-spline, so far from each other, and where to write them, raw.
    Resample { threads: usize, spacing: f64, out: Option<PathBuf> },
    /// All bytes, each looked at once.
    Read { threads: usize },
    /// How often values occur.
    Histogram { threads: usize },
    /// Area, volume and gradient at all isovalues.
    Spectrum { threads: usize },
    /// The surface of a shape, on a lattice of so many samples along its longest axis.
    Shape { threads: usize, path: PathBuf, samples: u32, how: How },
    /// How far a mesh in a file is from a shape.
    Judge { path: PathBuf, mesh: PathBuf },
    /// The steps of a shape, for others to read.
    Listing { path: PathBuf, out: PathBuf },
    /// Take a mesh into memory, welded.
    Mesh { path: PathBuf },
    /// Its distance at samples, from the mesh on; and where to write them, raw.
    Voxelize {
        threads: usize,
        #[serde(flatten)]
        lattice: Around,
        out: Option<PathBuf>,
    },
}

/// What was found.
#[derive(Debug, Default, Serialize)]
struct Answer {
    /// Wall time.
    seconds: f64,
    /// Those that were made for a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u64>,
    /// What a mesh is like.
    #[serde(flatten)]
    mesh: Option<Judged>,
    /// Middle and half the side of a cube around a shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    cube: Option<([f64; 3], f64)>,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

fn main() -> Result<(), Failure> {
    let (mut scan, mut mesh) = (None, None);
    for line in stdin().lock().lines() {
        let request: Request = serde_json::from_str(&line?)?;
        let failed = |why: Failure| Answer { error: Some(why.to_string()), ..Answer::default() };
        let answer = answer(request, &mut scan, &mut mesh).unwrap_or_else(failed);
        let mut out = stdout().lock();
        serde_json::to_writer(&mut out, &answer)?;
        out.write_all(b"\n")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(
    request: Request,
    loaded: &mut Option<Scan>,
    mesh: &mut Option<TriMesh>,
) -> Result<Answer, Failure> {
    if let Request::Mesh { path } = request {
        *mesh = Some(mesh::read(&path)?);
        return Ok(Answer::default());
    }
    if let Request::Voxelize { threads, lattice, out } = request {
        let mesh = mesh.as_ref().ok_or("no mesh is loaded")?;
        let (seconds, made) = mesh::distances(mesh, &lattice, &job(threads)?)?;
        write(&made, out.as_deref())?;
        return Ok(Answer { seconds, ..Answer::default() });
    }
    if let Request::Load { path, dims, dtype } = request {
        let dtype = Dtype::from_name(&dtype).ok_or("no such type of sample")?;
        *loaded = None; // before there are two
        *loaded = Some(for_dtype!(dtype, T => Scan::new(read::<T>(&path, dims)?)));
        return Ok(Answer::default());
    }
    match &request {
        Request::Shape { threads, path, samples, how } => {
            let (seconds, samples, mesh) = shape::mesh(path, *samples, *how, &job(*threads)?)?;
            return Ok(Answer {
                seconds,
                samples: Some(samples),
                mesh: Some(mesh),
                ..Answer::default()
            });
        }
        Request::Judge { path, mesh } => {
            return Ok(Answer { mesh: Some(shape::judge_file(path, mesh)?), ..Answer::default() });
        }
        Request::Listing { path, out } => {
            return Ok(Answer { cube: Some(shape::list(path, out)?), ..Answer::default() });
        }
        _ => {}
    }
    // A scan looks for what it is asked once: each time another one is asked.
    let scan = loaded.take().ok_or("nothing is loaded")?;
    let seconds = match request {
        Request::Resample { threads, spacing, out } => {
            let job = job(threads)?;
            let (seconds, made) =
                timed(|| scan.resampled(Filter::CubicBSpline, [spacing; 3], &job));
            write(made?.volume(), out.as_deref())?;
            seconds
        }
        Request::Read { threads } => {
            let job = job(threads)?;
            let bytes: &[u8] =
                for_any!(scan.volume(), volume => bytemuck::cast_slice(volume.samples()));
            let (seconds, sum) = timed(|| job.threads.run(|| sum(bytes, threads)));
            black_box(sum);
            seconds
        }
        Request::Histogram { threads } => {
            let job = job(threads)?;
            let (seconds, found) = timed(|| scan.histogram(&job).map(|found| found.is_some()));
            black_box(found?);
            seconds
        }
        Request::Spectrum { threads } => {
            let job = job(threads)?;
            scan.histogram(&job)?;
            let (seconds, found) = timed(|| scan.spectrum(Scan::LEVELS, &job));
            black_box(found?);
            seconds
        }
        _ => unreachable!("done above"),
    };
    *loaded = Some(Scan::new(for_any!(scan.volume(), volume => AnyVolume::from(volume.clone()))));
    Ok(Answer { seconds, ..Answer::default() })
}

fn timed<R>(work: impl FnOnce() -> R) -> (f64, R) {
    let start = Instant::now();
    let result = work();
    (start.elapsed().as_secs_f64(), result)
}

fn job(threads: usize) -> Result<Job, Failure> {
    let count = NonZeroUsize::new(threads).ok_or("threads are one or more")?;
    let job = Job { threads: Threads::new(count)?, ..Job::default() };
    // The first work of a pool starts it.
    job.threads.run(|| ());
    Ok(job)
}

/// The sum of all bytes, eight at a time.
fn sum(bytes: &[u8], threads: usize) -> u64 {
    std::thread::scope(|scope| {
        let parts = bytes.chunks(bytes.len().div_ceil(threads).max(1)).map(|part| {
            scope.spawn(|| {
                let words = part
                    .chunks_exact(8)
                    .map(|word| u64::from_ne_bytes(word.try_into().unwrap_or_default()));
                words.fold(0_u64, u64::wrapping_add)
            })
        });
        let parts: Vec<_> = parts.collect();
        parts.into_iter().map(|part| part.join().unwrap_or(0)).fold(0, u64::wrapping_add)
    })
}

fn read<T: Sample>(path: &Path, dims: [u64; 3]) -> Result<Volume<T>, Failure> {
    let grid = Grid::new(dims, Default::default())?;
    let mut samples = vec![T::zeroed(); usize::try_from(grid.count())?];
    File::open(path)?.read_exact(bytemuck::cast_slice_mut(&mut samples))?;
    Ok(Volume::new(grid, samples)?)
}

fn write(volume: &AnyVolume, path: Option<&Path>) -> Result<(), Failure> {
    let Some(path) = path else { return Ok(()) };
    let mut out = BufWriter::new(File::create(path)?);
    for_any!(volume, volume => out.write_all(bytemuck::cast_slice(volume.samples()))?);
    Ok(out.flush()?)
}

//! isokit as a contender of `scripts/bench_fields`: from samples in memory to other samples, or to what is known of all of
//! them, on the clock.
//!
//! Requests and answers are JSON, one object a line, on stdin and stdout, as those of the example `bench_error`. Reading
//! the volume is outside of all times.

use isokit::{
    field::{FieldSamples, FieldSlices, Filter, Jet, ScalarField, Slope},
    geom::Affine,
    job::{Job, Threads},
    marching_cubes::{Budget, ExtractOptions, Extracted, Slabs, extract_slabs, extract_sparse},
    mesh::TriMesh,
    pipeline::Scan,
    solid::{Model, Placed},
    volume::{AnyVolume, Dtype, Grid, Sample, Volume, for_any, for_dtype},
};
use serde::{Deserialize, Serialize};
use std::{
    fs::File,
    hint::black_box,
    io::{BufRead, BufReader, BufWriter, Read, Write, stdin, stdout},
    num::NonZeroUsize,
    ops::Range,
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
}

/// How a shape becomes a mesh.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum How {
    /// With samples near the surface.
    Sparse,
    /// With all samples, of which those in a brick cost what the brick's part of the shape costs.
    Bricks,
    /// With all samples, each made of the whole shape.
    Dense,
}

/// What was found.
#[derive(Debug, Default, Serialize)]
struct Answer {
    /// Wall time.
    seconds: f64,
    /// Of a mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    triangles: Option<u64>,
    /// What was not done for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u64>,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

fn main() -> Result<(), Failure> {
    let mut scan = None;
    for line in stdin().lock().lines() {
        let request: Request = serde_json::from_str(&line?)?;
        let failed = |why: Failure| Answer { error: Some(why.to_string()), ..Answer::default() };
        let answer = answer(request, &mut scan).unwrap_or_else(failed);
        let mut out = stdout().lock();
        serde_json::to_writer(&mut out, &answer)?;
        out.write_all(b"\n")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(request: Request, loaded: &mut Option<Scan>) -> Result<Answer, Failure> {
    if let Request::Load { path, dims, dtype } = request {
        let dtype = Dtype::from_name(&dtype).ok_or("no such type of sample")?;
        *loaded = None; // before there are two
        *loaded = Some(for_dtype!(dtype, T => Scan::new(read::<T>(&path, dims)?)));
        return Ok(Answer::default());
    }
    if let Request::Shape { threads, path, samples, how } = request {
        return shape(&path, samples, how, &job(threads)?);
    }
    // A scan looks for what it is asked once: each time another one is asked.
    let scan = loaded.take().ok_or("nothing is loaded")?;
    let seconds = match request {
        Request::Load { .. } | Request::Shape { .. } => unreachable!("done above"),
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
    };
    *loaded = Some(Scan::new(for_any!(scan.volume(), volume => AnyVolume::from(volume.clone()))));
    Ok(Answer { seconds, ..Answer::default() })
}

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

fn shape(path: &Path, samples: u32, how: How, job: &Job) -> Result<Answer, Failure> {
    let solid = serde_json::from_reader::<_, Model>(BufReader::new(File::open(path)?))?.build()?;
    let bounds = solid.bounds().ok_or("the shape has no end")?;
    let longest = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
    // Two samples are left around it.
    let grid = solid.grid([longest / f64::from(samples - 5); 3])?;
    let placed = solid.placed(&grid);
    let whole = Whole(&placed);
    let options = &ExtractOptions::DEFAULT;
    let mut mesh = TriMesh::with_normals();
    let (seconds, told) = timed(|| -> Result<Extracted, Failure> {
        if let How::Sparse = how {
            let source = FieldSamples::<f32>::new(&placed, grid.frame)?;
            return Ok(extract_sparse(&source, 0.0, options, &mut mesh.refill(), job)?);
        }
        let field: &dyn ScalarField = if let How::Dense = how { &whole } else { &placed };
        let source = &mut FieldSlices::new(FieldSamples::<f32>::new(field, grid.frame)?, job);
        let budget = Budget { window: 64, piece_bytes: u64::MAX };
        let slabs = Slabs { isos: &[0.0], options, budget };
        let sinks = &mut vec![mesh.refill()];
        Ok(extract_slabs(source, &slabs, sinks, job)?.remove(0))
    });
    let (samples, triangles) = (told?.skipped.samples_read, mesh.triangles.len() as u64);
    Ok(Answer { seconds, triangles: Some(triangles), samples: Some(samples), ..Answer::default() })
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

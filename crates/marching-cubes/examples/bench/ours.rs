//! isokit as a contender, and the rates of the machine beside it on the same samples.

use crate::{
    Contender, Failure,
    memory::{copy, fill, forget_the_most, in_use, read},
    protocol::{
        Answer, Boundary, Diagonals, Extract, Gradient, Load, Nan, Placement, Request, Topology,
        timed,
    },
};
use isokit_job::{Job, Threads};
use isokit_lanes::{Level, Thresholds, WORD, signs_of_many, words};
use isokit_marching_cubes::{
    self as mc, ExtractOptions, Skipped, Source, count_many, extract_many,
};
use isokit_mesh::{Counts, Positions, TriMesh};
use isokit_volume::{Bricks, Dtype, Grid, Sample, Volume, for_dtype};
use rayon::prelude::*;
use std::{collections::BTreeMap, num::NonZeroUsize};

/// Takes a volume of any type.
pub(crate) fn open(load: &Load) -> Result<Box<dyn Contender>, Failure> {
    let dtype = Dtype::from_name(&load.dtype).ok_or("no such type of sample")?;
    for_dtype!(dtype, T => Ok(Box::new(Isokit::<T>::open(load)?)))
}

struct Isokit<T> {
    volume: Volume<T>,
    bricks: Option<Bricks<T>>,
    /// Jobs with pools of threads, by their number: no request pays for the start of a thread.
    jobs: BTreeMap<usize, Job>,
    /// The mesh of the request before, for warm ones; with normals and without.
    kept: [TriMesh; 2],
    /// Where bits and copies go.
    bits: Vec<u64>,
    copied: Vec<T>,
}

impl<T: Sample> Isokit<T> {
    fn open(load: &Load) -> Result<Self, Failure> {
        let grid = Grid::new(load.dims.map(|n| n as u64), Default::default())?;
        let volume = Volume::new(grid, load.samples()?)?;
        let kept = [TriMesh::default(), TriMesh::with_normals()];
        let jobs = BTreeMap::new();
        Ok(Self { volume, bricks: None, jobs, kept, bits: vec![], copied: vec![] })
    }

    fn job(&mut self, threads: usize) -> Result<Job, Failure> {
        if let Some(job) = self.jobs.get(&threads) {
            return Ok(job.clone());
        }
        let count = NonZeroUsize::new(threads).ok_or("threads are one or more")?;
        let job = Job { threads: Threads::new(count)?, ..Job::default() };
        // The first work of a pool starts it.
        job.threads.run(|| rayon::broadcast(|_| ()));
        self.jobs.insert(threads, job.clone());
        Ok(job)
    }

    fn extract(&mut self, request: &Extract) -> Result<Answer, Failure> {
        let job = self.job(request.threads)?;
        let options = options(request);
        let mut fresh = match request.normals {
            true => TriMesh::with_normals(),
            false => TriMesh::default(),
        };
        let mesh = match request.warm {
            true => &mut self.kept[usize::from(request.normals)],
            false => &mut fresh,
        };
        let view = self.volume.view();
        if request.index && self.bricks.is_none() {
            self.bricks = Some(Bricks::of(&view, &job)?);
        }
        let bricks = self.bricks.as_ref().filter(|_| request.index);
        let source = bricks.and_then(|bricks| Source::with_bricks(&view, bricks));
        let source = source.unwrap_or(Source::from(&view));
        let mut run = || extract_many(source, &[request.iso], &options, &mut [mesh.refill()], &job);
        let all = || (1..request.runs.get()).try_for_each(|_| run().map(drop)).and_then(|()| run());
        let (mut answer, result) = timed(all);
        answer.seconds /= f64::from(request.runs.get());
        let Skipped { bricks, bricks_skipped, .. } = result?[0].skipped;
        let active = (bricks > 0).then(|| (bricks - bricks_skipped) as f64 / bricks as f64);
        let (parts, counts) = (parts(mesh), mesh.counts());
        Ok(Answer { parts, active, input: Some(self.input()), ..counted(answer, counts) })
    }

    fn count(&mut self, isos: &[f64], threads: usize) -> Result<Answer, Failure> {
        let job = self.job(threads)?;
        let options = ExtractOptions::DEFAULT.with_boundary(mc::Boundary::Open);
        let options = options.with_topology(mc::Topology::Table);
        let (answer, counts) = timed(|| count_many(&self.volume.view(), isos, &options, &job));
        let sum = counts?.iter().fold(Counts::default(), |sum, one| Counts {
            vertices: sum.vertices + one.vertices,
            triangles: sum.triangles + one.triangles,
        });
        Ok(counted(answer, sum))
    }

    fn index(&mut self, threads: usize) -> Result<Answer, Failure> {
        let job = self.job(threads)?;
        let (answer, bricks) = timed(|| Bricks::of(&self.volume.view(), &job));
        self.bricks = Some(bricks?);
        Ok(self.with_input(answer))
    }

    /// One bit per sample, as the first pass of an extraction makes them.
    fn classify(&mut self, iso: f64, threads: usize) -> Result<Answer, Failure> {
        let job = self.job(threads)?;
        let [nx, ny, _] = self.volume.view().dims();
        let threshold = self.volume.scaling().threshold::<T>(iso);
        let threshold = Thresholds::new(&[threshold]).ok_or("no sample can be inside")?;
        let per_row = words(nx);
        self.bits.resize(self.volume.samples().len() / nx * per_row, 0);
        let (samples, bits) = (self.volume.samples(), &mut self.bits);
        let slices = bits.par_chunks_mut(per_row * ny).zip(samples.par_chunks(nx * ny));
        let classify = |(bits, slice): (&mut [u64], &[T])| {
            // As an extraction does it: rows that fill their words are one long row, in pieces.
            let (long, words) = if nx % WORD == 0 { (64 * WORD, 64) } else { (nx, per_row) };
            let rows = slice.chunks(long).zip(bits.chunks_mut(words));
            rows.for_each(|(row, bits)| signs_of_many(row, &threshold, bits, words));
        };
        let (answer, ()) = timed(|| job.threads.run(|| slices.for_each(classify)));
        Ok(self.with_input(answer))
    }

    fn read(&mut self, threads: usize) -> Result<Answer, Failure> {
        let job = self.job(threads)?;
        let (answer, _) = timed(|| job.threads.run(|| read(self.volume.samples())));
        Ok(self.with_input(answer))
    }

    fn copy(&mut self, threads: usize) -> Result<Answer, Failure> {
        let job = self.job(threads)?;
        if self.copied.is_empty() {
            self.copied = self.volume.samples().to_vec();
        }
        let (from, to) = (self.volume.samples(), &mut self.copied);
        let (answer, ()) = timed(|| job.threads.run(|| copy(from, to)));
        Ok(self.with_input(answer))
    }

    fn bound(&mut self, parts: &[usize], threads: usize) -> Result<Answer, Failure> {
        let job = self.job(threads)?;
        let samples = self.volume.samples();
        let work = || job.threads.run(|| (read(samples), fill(parts)));
        let (answer, _) = timed(work);
        Ok(self.with_input(answer))
    }

    fn fill(&mut self, parts: &[usize], threads: usize) -> Result<Answer, Failure> {
        let job = self.job(threads)?;
        let (answer, _) = timed(|| job.threads.run(|| fill(parts)));
        Ok(answer)
    }

    /// What an extraction takes beside the volume and the mesh.
    fn memory(&mut self, request: &Extract) -> Result<Answer, Failure> {
        self.job(request.threads)?;
        forget_the_most();
        let before = in_use().ok_or("the system does not tell how much memory is in use")?;
        let answer = self.extract(request)?;
        let after = in_use().ok_or("the system does not tell how much memory is in use")?;
        let output: usize = answer.parts.iter().sum();
        let above = after.most as i64 - before.now as i64 - output as i64;
        Ok(Answer { above: Some(above), ..answer })
    }

    fn input(&self) -> usize {
        size_of_val(self.volume.samples())
    }

    fn with_input(&self, answer: Answer) -> Answer {
        Answer { input: Some(self.input()), simd: Some(Level::current().name()), ..answer }
    }
}

impl<T: Sample> Contender for Isokit<T> {
    fn answer(&mut self, request: Request) -> Result<Answer, Failure> {
        match request {
            Request::Load(_) => Err("a volume is loaded".into()),
            Request::Extract(request) => self.extract(&request),
            Request::Count { isos, threads } => self.count(&isos, threads),
            Request::Index { threads } => self.index(threads),
            Request::Classify { iso, threads } => self.classify(iso, threads),
            Request::Read { threads } => self.read(threads),
            Request::Copy { threads } => self.copy(threads),
            Request::Fill { parts, threads } => self.fill(&parts, threads),
            Request::Bound { parts, threads } => self.bound(&parts, threads),
            Request::Memory(request) => self.memory(&request),
        }
    }
}

fn options(request: &Extract) -> ExtractOptions {
    let boundary = match request.boundary {
        Boundary::Open => mc::Boundary::Open,
        Boundary::Closed => mc::Boundary::Closed,
    };
    let nan = match request.nan {
        Nan::Outside => mc::Nan::Outside,
        Nan::Error => mc::Nan::Error,
    };
    let placement = match request.placement {
        Placement::Linear => mc::Placement::Linear,
        Placement::Cubic => mc::Placement::Cubic,
        Placement::Quintic => mc::Placement::Quintic,
    };
    let topology = match request.topology {
        Topology::Table => mc::Topology::Table,
        Topology::Trilinear => mc::Topology::Trilinear,
    };
    let diagonals = match request.diagonals {
        Diagonals::Table => mc::Diagonals::Table,
        Diagonals::Fitted => mc::Diagonals::Fitted,
    };
    let options = ExtractOptions::DEFAULT.with_boundary(boundary).with_nan(nan);
    let gradient = match request.gradient {
        Gradient::Central => mc::Gradient::Central,
        Gradient::Matching => mc::Gradient::Matching,
    };
    let options = options.with_placement(placement).with_gradient(gradient);
    options.with_topology(topology).with_diagonals(diagonals)
}

fn counted(answer: Answer, Counts { vertices, triangles }: Counts) -> Answer {
    let simd = Some(Level::current().name());
    Answer { vertices: Some(vertices), triangles: Some(triangles), simd, ..answer }
}

/// Bytes of positions, triangles and normals.
fn parts(mesh: &TriMesh) -> Vec<usize> {
    let positions = match &mesh.positions {
        Positions::F32(all) => size_of_val(&all[..]),
        Positions::F64(all) => size_of_val(&all[..]),
    };
    let normals = mesh.normals.as_ref().map(|all| size_of_val(&all[..]));
    [Some(positions), Some(size_of_val(&mesh.triangles[..])), normals]
        .into_iter()
        .flatten()
        .collect()
}

//! isokit as a contender of `scripts/bench_render`: from samples or surfaces in memory to a picture in memory, on the
//! clock.
//!
//! Requests and answers are JSON, one object a line, on stdin and stdout, as those of the example `bench_error`.
//! Reading the volume, finding out where which values are, and extracting are outside of the time of a picture.

use isokit::{
    geom::HalfSpace,
    job::{Job, Threads},
    pipeline::Scan,
    render::{
        Camera, ControlPoint, Gathered, Image, Isosurface, Isosurfaces, Kernel, Light, Medium,
        Paint, Painted, Projection, RasterOptions, RaycastOptions, Raycaster, Size, Smoothing,
        TransferFunction, isocast, rasterize,
    },
    scene::{Scene, Viewpoint},
    volume::{Bricks, Dtype, Grid, Sample, Volume, for_any, for_dtype},
};
use serde::{Deserialize, Serialize};
use std::{
    fs::File,
    io::{BufRead, BufWriter, Read, Write, stdin, stdout},
    num::{NonZeroU32, NonZeroUsize},
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
    /// The picture of its values.
    Cast { view: View, cast: Casting },
    /// The picture of its surfaces, extracted before unless rays are to find them.
    Draw { view: View, surfaces: Vec<Look>, rays: bool },
}

/// From where a picture is taken, and how.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct View {
    threads: usize,
    from: [f64; 3],
    at: [f64; 3],
    up: [f64; 3],
    fov: f64,
    size: [u32; 2],
    /// Whether surfaces and gradients are lit.
    lit: bool,
    /// Points of a pixel at which surfaces are looked at.
    points: u32,
    /// Normals and offsets of what is kept.
    #[serde(default)]
    clips: Vec<[f64; 4]>,
    /// Where to write the picture: red, green, blue and opacity, in linear light, multiplied, as f32.
    out: Option<PathBuf>,
}

/// How rays are cast.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Casting {
    /// Value, red, green, blue in linear light, and opacity over one spacing.
    transfer: Vec<[f64; 5]>,
    step: f64,
    /// Whether bricks of which nothing can be seen are passed.
    leap: bool,
    opaque: Option<f32>,
    /// Whether steps are looked up by the values at both ends.
    #[serde(default)]
    integrated: bool,
    /// Whether values between samples are cubic.
    #[serde(default)]
    cubic: bool,
    /// Whether samples that are nearer to each other than pixels are left out.
    #[serde(default)]
    lod: bool,
}

/// A surface: its value, colour in linear light, and opacity.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Look {
    iso: f64,
    color: [f32; 3],
    opacity: f32,
}

/// What was found.
#[derive(Debug, Default, Serialize)]
struct Answer {
    /// Wall time of the picture.
    seconds: f64,
    /// Wall time of what is known before: bricks, or surfaces.
    before: f64,
    /// Steps or cells that were looked at, or triangles.
    work: u64,
    /// Why there is no result.
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<String>,
}

fn main() -> Result<(), Failure> {
    let mut scan = None;
    for line in stdin().lock().lines() {
        let request: Request = serde_json::from_str(&line?)?;
        let answer = answer(request, &mut scan);
        let failed = |why: Failure| Answer { error: Some(why.to_string()), ..Answer::default() };
        let mut out = stdout().lock();
        serde_json::to_writer(&mut out, &answer.unwrap_or_else(failed))?;
        out.write_all(b"\n")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(request: Request, scan: &mut Option<Scan>) -> Result<Answer, Failure> {
    match request {
        Request::Load { path, dims, dtype } => {
            let dtype = Dtype::from_name(&dtype).ok_or("no such type of sample")?;
            *scan = None; // before there are two
            *scan = Some(for_dtype!(dtype, T => Scan::new(read::<T>(&path, dims)?)));
            Ok(Answer::default())
        }
        Request::Cast { view, cast } => {
            let scan = scan.as_ref().ok_or("nothing is loaded")?;
            let start = Instant::now();
            let coarse = if cast.lod { view.halved(scan)? } else { None };
            let before = start.elapsed().as_secs_f64();
            let scan = coarse.as_ref().unwrap_or(scan);
            let answer = for_any!(scan.volume(), volume => casting(volume, &view, &cast))?;
            Ok(Answer { before: answer.before + before, ..answer })
        }
        Request::Draw { view, surfaces, rays } => {
            let scan = scan.as_ref().ok_or("nothing is loaded")?;
            match rays {
                true => for_any!(scan.volume(), volume => tracing(volume, &view, &surfaces)),
                false => drawing(scan, &view, &surfaces),
            }
        }
    }
}

fn casting<T: Sample>(volume: &Volume<T>, view: &View, cast: &Casting) -> Result<Answer, Failure> {
    let point = |&[value, r, g, b, opacity]: &[f64; 5]| ControlPoint {
        value,
        color: [r, g, b].map(|part| part as f32),
        opacity: opacity as f32,
    };
    let model = TransferFunction::new(cast.transfer.iter().map(point).collect())?.into();
    let (job, clips) = (view.job()?, view.clips()?);
    let default = RaycastOptions::DEFAULT;
    let options = default.with_step(cast.step).with_light(view.light());
    let options = options.with_opaque(cast.opaque.unwrap_or(default.opaque));
    let kernel = if cast.cubic { Kernel::CatmullRom } else { Kernel::Linear };
    // Samples are 1 apart, of which some may be left out.
    let options = options.with_integrated(cast.integrated).with_kernel(kernel).with_unit(Some(1.0));
    let seen = volume.view();
    let start = Instant::now();
    let bricks = cast.leap.then(|| Bricks::of(&seen, &job)).transpose()?;
    let medium = Medium { view: &seen, bricks: bricks.as_ref(), model: &model, clips: &clips };
    let caster = Raycaster::new(&medium, &options, &job)?;
    let before = start.elapsed().as_secs_f64();
    let (camera, size) = (view.camera()?, view.size()?);
    let start = Instant::now();
    let (image, done) = caster.picture((&camera, size), &job)?;
    let seconds = start.elapsed().as_secs_f64();
    view.write(&image)?;
    Ok(Answer { seconds, before, work: done.steps, error: None })
}

fn drawing(scan: &Scan, view: &View, surfaces: &[Look]) -> Result<Answer, Failure> {
    let (job, clips) = (view.job()?, view.clips()?);
    let start = Instant::now();
    let options = Scene::surface_options();
    let mesh = |look: &Look| scan.mesh(look.iso, &options, &job);
    let meshes = surfaces.iter().map(mesh).collect::<Result<Vec<_>, _>>()?;
    let before = start.elapsed().as_secs_f64();
    let painted = surfaces.iter().zip(&meshes).map(|(look, mesh)| {
        let paint = Paint::Plain(look.color);
        Painted { mesh, paint, opacity: look.opacity, clips: &clips }
    });
    let painted: Vec<_> = painted.collect();
    let (camera, size) = (view.camera()?, view.size()?);
    let start = Instant::now();
    let (image, done) = rasterize(&painted, &[], (&camera, size), &view.raster()?, &job)?;
    let seconds = start.elapsed().as_secs_f64();
    view.write(&image)?;
    Ok(Answer { seconds, before, work: done.triangles, error: None })
}

fn tracing<T: Sample>(
    volume: &Volume<T>,
    view: &View,
    surfaces: &[Look],
) -> Result<Answer, Failure> {
    let (job, clips) = (view.job()?, view.clips()?);
    let seen = volume.view();
    let start = Instant::now();
    let bricks = Bricks::of(&seen, &job)?;
    let before = start.elapsed().as_secs_f64();
    let surface = |look: &Look| {
        let paint = Paint::Plain(look.color);
        Isosurface { iso: look.iso, paint, opacity: look.opacity, clips: &clips }
    };
    let surfaces: Vec<_> = surfaces.iter().map(surface).collect();
    let (bricks, kernel) = (Some(&bricks), Kernel::Linear);
    let scene = Isosurfaces { view: &seen, bricks, kernel, surfaces: &surfaces, caps: &[] };
    let (camera, size) = (view.camera()?, view.size()?);
    let start = Instant::now();
    let (image, done) = isocast(&scene, (&camera, size), &view.raster()?, &job)?;
    let seconds = start.elapsed().as_secs_f64();
    view.write(&image)?;
    Ok(Answer { seconds, before, work: done.cells, error: None })
}

impl View {
    /// As few samples as its pixels show, if they are fewer.
    fn halved(&self, scan: &Scan) -> Result<Option<Scan>, Failure> {
        let viewpoints = [Viewpoint::of(&self.camera()?)];
        let halvings =
            Scene::halvings(scan.lattice(), scan.around().0, (&viewpoints, self.size()?))?;
        Ok(scan.halved(halvings, &self.job()?)?)
    }

    fn job(&self) -> Result<Job, Failure> {
        let count = NonZeroUsize::new(self.threads).ok_or("threads are one or more")?;
        let job = Job { threads: Threads::new(count)?, ..Job::default() };
        // The first work of a pool starts it.
        job.threads.run(|| ());
        Ok(job)
    }

    fn camera(&self) -> Result<Camera, Failure> {
        let projection = Projection::Perspective { fov: self.fov };
        Ok(Camera::new(self.from, self.at, self.up, projection)?)
    }

    fn size(&self) -> Result<Size, Failure> {
        let [width, height] = self.size.map(NonZeroU32::new);
        let none = "pictures have pixels";
        Ok(Size { width: width.ok_or(none)?, height: height.ok_or(none)? })
    }

    fn light(&self) -> Option<Light> {
        self.lit.then_some(Light::DEFAULT)
    }

    fn clips(&self) -> Result<Vec<HalfSpace>, Failure> {
        let half = |&[x, y, z, offset]: &[f64; 4]| HalfSpace::new([x, y, z], offset);
        Ok(self.clips.iter().map(half).collect::<Result<_, _>>()?)
    }

    fn raster(&self) -> Result<RasterOptions, Failure> {
        let smoothing = match self.points {
            1 => Smoothing::None,
            4 => Smoothing::Four,
            16 => Smoothing::Sixteen,
            _ => return Err("points are 1, 4 or 16".into()),
        };
        Ok(RasterOptions::DEFAULT.with_light(self.light()).with_smoothing(smoothing))
    }

    fn write(&self, image: &Image) -> Result<(), Failure> {
        let Some(path) = &self.out else { return Ok(()) };
        let mut out = BufWriter::new(File::create(path)?);
        for &Gathered { color: [r, g, b], opacity } in image.pixels() {
            out.write_all(bytemuck::cast_slice(&[r, g, b, opacity]))?;
        }
        Ok(out.flush()?)
    }
}

fn read<T: Sample>(path: &Path, dims: [u64; 3]) -> Result<Volume<T>, Failure> {
    let grid = Grid::new(dims, Default::default())?;
    let mut samples = vec![T::zeroed(); usize::try_from(grid.count())?];
    File::open(path)?.read_exact(bytemuck::cast_slice_mut(&mut samples))?;
    Ok(Volume::new(grid, samples)?)
}

//! A library that has denormal numbers taken for 0 changes nothing, though the process that loads it computes
//! otherwise from its first to its last thread.
//!
//! Such a library is compiled here and loaded into a copy of this process, which extracts from volumes of
//! denormal and of usual numbers on all that works on samples, makes pictures of them, and tells what came out.

#![cfg(all(target_os = "linux", target_arch = "x86_64"))]

use isokit::{
    field::Sampled,
    geom::Frame,
    job::{Job, Threads},
    lanes::Level,
    marching_cubes::{
        Budget, Diagonals, ExtractOptions, Slabs, Source, count, extract, extract_many,
        extract_slabs,
    },
    mesh::{TriMesh, topology},
    refine::{Isosurface, RefineOptions, Subdivision, refine},
    render::{
        Camera, ControlPoint, Image, Medium, OpticalModel, Projection, RaycastOptions, Scatter,
        Size, TransferFunction, raycast, splat,
    },
    volume::{Bricks, Grid, Histogram, Sample, Slices, Statistics, Volume},
};
use isokit_tests::{chance::Chance, modes::modes};
use std::{
    env, fs,
    hint::black_box,
    num::{NonZeroU32, NonZeroUsize},
    path::{Path, PathBuf},
    process::Command,
};

/// What code compiled with `-ffast-math` brings along: FTZ and DAZ, set as soon as it is loaded.
const LIBRARY: &str = "#include <xmmintrin.h>\n\
    __attribute__((constructor)) static void flush(void) { _mm_setcsr(_mm_getcsr() | 0x8040); }\n";

/// A number that depends on every bit (FNV-1a).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Digest(u64);

impl Digest {
    const NEW: Self = Self(0xCBF2_9CE4_8422_2325);

    fn with(self, bits: impl IntoIterator<Item = u64>) -> Self {
        let bytes = bits.into_iter().flat_map(u64::to_le_bytes);
        Self(
            bytes.fold(self.0, |digest, byte| {
                (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
            }),
        )
    }

    fn with_mesh(self, mesh: &TriMesh) -> Self {
        let positions = mesh.positions.iter().flatten().map(f64::to_bits);
        let normals = mesh.normals.iter().flatten().flatten().map(|c| u64::from(c.to_bits()));
        let triangles = mesh.triangles.iter().flatten().map(|&v| u64::from(v));
        self.with(positions.chain(normals).chain(triangles))
    }
}

/// Whether denormal numbers are taken for 0 in this thread.
fn flushes() -> bool {
    black_box(f32::from_bits(1)) * black_box(2.0) == 0.0
}

fn refinements() -> [RefineOptions; 3] {
    let by = |subdivision| RefineOptions::DEFAULT.with_subdivision(subdivision);
    [
        by(Subdivision::None).with_balance(true),
        by(Subdivision::Levels(1)),
        by(Subdivision::MaxError(0.25)),
    ]
}

/// Pictures of values up to five times a unit.
fn pictures<T: Sample>(
    volume: &Volume<T>,
    bricks: &Bricks<T>,
    unit: f64,
    job: &Job,
) -> [Digest; 2] {
    let point = |n: u8| {
        let color = [n % 2, n % 3, n % 5].map(|c| f32::from(c) / 4.0);
        let opacity = [0.0, 0.0, 0.01, 0.3, 0.2, 0.9][usize::from(n)];
        ControlPoint { value: f64::from(n) * unit, color, opacity }
    };
    let function = TransferFunction::new((0..6).map(point).collect()).unwrap();
    let model = OpticalModel::from(function);
    let medium = Medium { view: &volume.view(), bricks: Some(bricks), model: &model, clips: &[] };
    let middle = [6.0, 5.0, 7.0];
    let projection = Projection::Parallel { height: 20.0 };
    let camera = Camera::new([20.0, 9.0, 30.0], middle, [0.0, 1.0, 0.0], projection).unwrap();
    let pixels = NonZeroU32::new(24).unwrap();
    let camera = (&camera, Size { width: pixels, height: pixels });
    let from = [1.0, 2.0, 3.0];
    let scatter = Scatter { from, strength: 1.0, ambient: 0.1, ahead: 0.2 };
    let options = RaycastOptions::DEFAULT.with_light(None);
    let cast = options.with_scatter(Some(scatter));
    let digest = |image: &Image, done: String| {
        let parts =
            image.pixels().iter().flat_map(|p| [p.color[0], p.color[1], p.color[2], p.opacity]);
        assert!(image.pixels().iter().any(|pixel| pixel.opacity > 0.1), "something is seen");
        Digest::NEW.with(parts.map(|c| u64::from(c.to_bits()))).with(done.bytes().map(u64::from))
    };
    let (image, cast) = raycast(&medium, camera, &cast, job).unwrap();
    let (splatted, done) = splat(&medium, camera, &options, job).unwrap();
    [digest(&image, format!("{cast:?}")), digest(&splatted, format!("{done:?}"))]
}

/// All that comes of a volume, as one number a line; pictures if it has a unit: of such numbers of f64 a transfer
/// function makes none.
fn digests<T: Sample>(
    volume: &Volume<T>,
    (iso, unit): (f64, Option<f64>),
    lines: &mut Vec<String>,
) {
    let (view, threads) = (volume.view(), Threads::new(NonZeroUsize::new(3).unwrap()).unwrap());
    for job in [Job::default(), Job { threads, ..Job::default() }] {
        let bricks = Bricks::of(&view, &job).unwrap();
        let fitted = ExtractOptions::DEFAULT.with_diagonals(Diagonals::Fitted);
        for options in modes().into_iter().chain([fitted]) {
            let mesh = extract(&view, iso, &options, &job).unwrap();
            assert!(mesh.triangles.len() > 100, "{} show little", mesh.triangles.len());
            let counted = count(&view, iso, &options, &job).unwrap();
            let window = options.placement.least_window();
            let slabs = Slabs {
                isos: &[iso],
                options: &options,
                budget: Budget { window, piece_bytes: u64::MAX },
            };
            let mut by_slab = TriMesh::with_normals();
            let source = &mut Slices::new(view);
            extract_slabs(source, &slabs, &mut vec![by_slab.refill()], &job).unwrap();
            let mut by_brick = TriMesh::with_normals();
            let source = Source::with_bricks(&view, &bricks).unwrap();
            extract_many(source, &[iso], &options, &mut [by_brick.refill()], &job).unwrap();
            let same = [&mesh, &by_slab, &by_brick].map(|mesh| Digest::NEW.with_mesh(mesh));
            lines.push(format!("{same:?} {counted:?}"));
        }
        let statistics = Statistics::of(&view, &job).unwrap();
        let histogram = Histogram::of(&view, &statistics, &job).unwrap().unwrap();
        let range = statistics.range.unwrap().map(f64::to_bits);
        let bins = [histogram.first.to_bits(), histogram.width.to_bits()];
        let digest = Digest::NEW.with(range).with(bins).with(histogram.counts.iter().copied());
        lines.push(format!("{digest:?}"));
        let field = Sampled::new(view);
        for options in refinements() {
            let mut mesh = extract(&view, iso, &ExtractOptions::DEFAULT, &job).unwrap();
            let surface = Isosurface { field: &field, iso };
            let found = refine(&mut mesh, &surface, &options, &job).unwrap();
            lines.push(format!("{:?} {found:?}", Digest::NEW.with_mesh(&mesh)));
        }
        lines.extend(unit.map(|unit| format!("{:?}", pictures(volume, &bricks, unit, &job))));
        let mesh = extract(&view, iso, &ExtractOptions::DEFAULT, &job).unwrap();
        lines.push(format!("{:?}", topology(&mesh, &job).unwrap().shortfalls()));
    }
}

/// Of volumes of denormal numbers of both signs, of one that has few of them, and of two that have none.
fn all_digests() -> Vec<String> {
    let (mut lines, mut chance) = (vec![], Chance::new(1));
    let grid = Grid::new([13, 11, 14], Frame::default()).unwrap(); // higher than any least window
    let mut bits = || (0..grid.count()).map(|_| chance.bits()).collect::<Vec<u64>>();
    let signed = |r: u64| f32::from_bits(((r % 5) | ((r >> 8) << 31)) as u32);
    let volume = Volume::new(grid, bits().into_iter().map(signed).collect()).unwrap();
    digests(&volume, (0.0, Some(1e-45)), &mut lines);
    digests(&volume, (1e-45, Some(1e-45)), &mut lines);
    let signed = |r: u64| f64::from_bits((r % 5) | ((r >> 8) << 63));
    let volume = Volume::new(grid, bits().into_iter().map(signed).collect()).unwrap();
    digests(&volume, (0.0, None), &mut lines);
    digests(&volume, (5e-324, None), &mut lines);
    let mixed = |r: u64| [1.0, -1.0, -1e-40, 1e-40, 0.0][r as usize % 5];
    let volume = Volume::new(grid, bits().into_iter().map(mixed).collect::<Vec<f32>>()).unwrap();
    digests(&volume, (0.0, Some(5e-41)), &mut lines);
    let usual = |r: u64| (r % 1000) as f32 * 1e-3;
    let volume = Volume::new(grid, bits().into_iter().map(usual).collect()).unwrap();
    digests(&volume, (0.6, Some(0.2)), &mut lines);
    let whole = |r: u64| (r % 256) as u8;
    let volume = Volume::new(grid, bits().into_iter().map(whole).collect()).unwrap();
    digests(&volume, (127.0, Some(50.0)), &mut lines);
    lines
}

/// Names the file into which a copy of this process writes what it finds.
const TOLD: &str = "ISOKIT_FLOATS_TOLD";

/// The copies below run this test alone.
#[test]
fn volumes_of_denormal_and_of_usual_numbers_have_surfaces() {
    let mut lines = vec![format!("flushes {}, level {}", flushes(), Level::current())];
    lines.extend(all_digests());
    assert!(lines.len() > 50, "{} lines", lines.len());
    if let Some(path) = env::var_os(TOLD) {
        fs::write(path, lines.join("\n")).unwrap();
    }
}

#[test]
fn a_library_that_flushes_denormals_changes_no_byte() {
    let library = library();
    let expected = told(&[]);
    assert_eq!(expected[0], format!("flushes false, level {}", Level::current()));
    for level in Level::available() {
        let environment =
            [("LD_PRELOAD", library.to_str().unwrap()), ("ISOKIT_SIMD", level.name())];
        let found = told(&environment);
        assert_eq!(found[0], format!("flushes true, level {level}"));
        assert!(found.len() == expected.len());
        for (found, expected) in found.iter().zip(&expected).skip(1) {
            assert_eq!(found, expected, "{level}");
        }
    }
}

/// The library, compiled with what Rust links with.
fn library() -> PathBuf {
    let [source, library] = ["flush.c", "flush.so"].map(file);
    fs::write(&source, LIBRARY).unwrap();
    let compiler = env::var_os("CC").unwrap_or_else(|| "cc".into());
    let mut command = Command::new(compiler);
    command.args(["-shared", "-fPIC", "-o"]).args([&library, &source]);
    assert!(command.status().expect("a C compiler").success());
    library
}

/// A file of this process.
fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-{name}", std::process::id()))
}

/// What a copy of this process finds in an environment.
#[track_caller]
fn told(environment: &[(&str, &str)]) -> Vec<String> {
    let path = file("told");
    let mut command = Command::new(env::current_exe().unwrap());
    command
        .args(["--exact", "volumes_of_denormal_and_of_usual_numbers_have_surfaces"])
        .env(TOLD, &path);
    let ended = command.envs(environment.iter().copied()).output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stdout));
    let text = fs::read_to_string(&path).unwrap();
    fs::remove_file(path).unwrap();
    text.lines().map(str::to_owned).collect()
}

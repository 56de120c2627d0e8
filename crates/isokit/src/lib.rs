//! From scans and other volumes to meshes that are closed, oriented and in the right place.
//!
//! This is the door: every room of the project under one name, and [`pipeline`], which leads through them.
//!
//! ```
//! use isokit::{job::Job, mesh::topology, pipeline::{Scan, SurfaceOptions}, volume::{Grid, Volume}};
//!
//! // Samples of any of eight types, x fastest: here, how deep a point lies in a ball.
//! let ball = |n: usize| {
//!     let [x, y, z] = [n % 64, n / 64 % 64, n / 4096].map(|i| i as f32 - 31.5);
//!     20.0 - (x * x + y * y + z * z).sqrt()
//! };
//! let grid = Grid::new([64, 64, 64], Default::default())?;
//! let volume = Volume::new(grid, (0..64 * 64 * 64).map(ball).collect())?;
//!
//! // The surface where the value is 0, with normals.
//! let job = Job::default();
//! let mesh = Scan::new(volume).mesh(0.0, &SurfaceOptions::default(), &job)?;
//!
//! // Closed, manifold, oriented, every triangle with an area; a ball has no handles.
//! let found = topology(&mesh, &job)?;
//! assert!(found.shortfalls().is_empty());
//! assert_eq!(found.genus(), Some(0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A tour
//!
//! | to | look at |
//! | --- | --- |
//! | turn a scan in a file into a mesh in a file | [`guide::first_mesh`], [`pipeline`] |
//! | know what holds for every mesh | [`guide::guarantees`] |
//! | know what is read and written, in which axes and units | [`guide::formats`], [`io`] |
//! | extract from samples in memory, in any order of axes | [`marching_cubes::extract`], [`volume::View`] |
//! | know which isovalues are worth a look, and why | [`pipeline::Scan::suggestions`], [`spectrum`] |
//! | have samples farther from each other or nearer | [`pipeline::Scan::resampled`], [`field::resample`] |
//! | ask a volume for values and derivatives between its samples, by any kernel | [`field::Convolved`] |
//! | put solids together, by a file or in Rust | [`guide::shapes`], [`solid`] |
//! | make a volume of a mesh, and one of its colours | [`solid::voxelize`], [`solid::voxelize_with_colors`] |
//! | bring the triangles of a surface nearer to its field | [`pipeline::Scan::refine`], [`refine`](mod@refine) |
//! | make pictures of surfaces and of values | [`guide::pictures`], [`scene`], [`render`](mod@render) |
//! | receive a surface in memory of your own | [`mesh::MeshSink`] |
//! | write a surface that no memory holds | [`io::MeshSpool`] |
//! | find out what is wrong with a mesh | [`mesh::topology`] |
//! | weld a mesh of somebody else | [`mesh::weld_exact`], [`mesh::weld_within`] |
//! | stop, watch or limit a long task | [`job::Job`] |
//!
//! # Words
//!
//! A *sample* is a value at a lattice point, a *cell* the box between eight samples. *Inside* is
//! `sample >= iso`; NaN is outside. `_ijk` is index space, `_xyz` world space. Triangles are
//! counter-clockwise seen from outside.

pub mod guide;
pub mod pipeline;
pub mod scene;

pub use isokit_field as field;
pub use isokit_geom as geom;
pub use isokit_io as io;
pub use isokit_job as job;
pub use isokit_lanes as lanes;
pub use isokit_marching_cubes as marching_cubes;
pub use isokit_mesh as mesh;
pub use isokit_refine as refine;
pub use isokit_render as render;
pub use isokit_solid as solid;
pub use isokit_spectrum as spectrum;
pub use isokit_volume as volume;
pub use isokit_volume::{for_any, for_dtype};

/// The program in the README is a test.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

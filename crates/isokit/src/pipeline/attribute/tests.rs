//! Values at vertices, however both scans lie.

use crate::pipeline::{Region, Scan, SurfaceOptions, TargetSpace};
use isokit_field::Between;
use isokit_geom::{Affine, Frame, Space, Unit, vector::Vector};
use isokit_job::{Job, Threads};
use isokit_mesh::{Rgba, TriMesh};
use isokit_refine::{RefineOptions, Subdivision};
use isokit_volume::{Channels, ColorVolume, Grid, Volume};
use std::num::NonZeroUsize;

/// Samples of a function of the world.
fn scan(dims: [u64; 3], frame: Frame, f: impl Fn(Vector) -> f64) -> Scan {
    let grid = Grid::new(dims, frame).unwrap();
    let [nx, ny, _] = dims;
    let place = |n: u64| [n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64);
    let value = |n: u64| f(frame.index_to_world.point(place(n)));
    Scan::new(Volume::new(grid, (0..grid.count()).map(value).collect::<Vec<f64>>()).unwrap())
}

fn frame(columns: [[f64; 3]; 3], origin: [f64; 3], space: Space) -> Frame {
    let index_to_world = Affine::new(columns, origin).unwrap();
    Frame { index_to_world, unit: Unit::Millimetre, space }
}

/// Oblique, and in RAS.
fn ras() -> Frame {
    frame([[0.8, 0.1, 0.0], [-0.1, 0.9, 0.2], [0.1, 0.0, 1.1]], [-8.0, -9.0, -10.0], Space::Ras)
}

/// A ball around a place of the world.
fn ball() -> Scan {
    scan([20; 3], ras(), |[x, y, z]| 6.0 - (x * x + y * y + z * z).sqrt())
}

fn linear([x, y, z]: Vector) -> f64 {
    3.0 * x - 2.0 * y + 0.5 * z + 100.0
}

/// Every vertex has the value of the function of RAS.
#[track_caller]
fn is_linear(mesh: &TriMesh, values: &[f32], to_ras: impl Fn(Vector) -> Vector) {
    assert!(mesh.positions.len() > 500 && values.len() == mesh.positions.len());
    for (place, &value) in mesh.positions.iter().zip(values) {
        let expected = linear(to_ras(place));
        assert!((f64::from(value) - expected).abs() < 1e-4, "{place:?}: {value}, {expected}");
    }
}

fn mesh(scan: &Scan) -> TriMesh {
    scan.mesh(0.0, &SurfaceOptions::default(), &Job::default()).unwrap()
}

#[test]
fn a_linear_function_is_exact_on_any_lattice() {
    let left_handed = [[0.0, -0.7, 0.2], [1.3, 0.0, 0.0], [0.1, 0.3, -0.9]];
    let other = scan([40, 50, 60], frame(left_handed, [-20.0, 10.0, 20.0], Space::Ras), linear);
    let (ball, job) = (ball(), Job::default());
    let mut mesh = mesh(&ball);
    let values = ball.attribute(&mesh, &other, Between::Linear, &job).unwrap();
    is_linear(&mesh, &values, |place| place);
    let refine =
        RefineOptions::default().with_subdivision(Subdivision::Levels(1)).with_balance(true);
    ball.refine(0.0, &mut mesh, (&refine, &SurfaceOptions::default()), &job).unwrap();
    let values = ball.attribute(&mesh, &other, Between::Linear, &job).unwrap();
    is_linear(&mesh, &values, |place| place);
}

#[test]
fn axes_and_units_of_the_other_scan_are_brought_together_with_ours() {
    // In LPS and in metres.
    let lps = Frame {
        unit: Unit::Metre,
        ..frame([[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]], [-0.02; 3], Space::Lps)
    };
    let other = scan([41; 3], lps, |[x, y, z]| linear([-1e3 * x, -1e3 * y, 1e3 * z]));
    let (ball, job) = (ball(), Job::default());
    for (space, sign) in
        [(TargetSpace::Source, 1.0), (TargetSpace::Ras, 1.0), (TargetSpace::Lps, -1.0)]
    {
        let placed = ball.clone().placed(space).unwrap();
        let mesh = mesh(&placed);
        let values = placed.attribute(&mesh, &other, Between::Linear, &job).unwrap();
        is_linear(&mesh, &values, |[x, y, z]| [sign * x, sign * y, z]);
    }
    let placed = ball.placed(TargetSpace::Index).unwrap();
    let mesh = mesh(&placed);
    let values = placed.attribute(&mesh, &other, Between::Linear, &job).unwrap();
    is_linear(&mesh, &values, |ijk| ras().index_to_world.point(ijk));
    assert_eq!(placed.differences(&other), [""; 0]);
}

#[test]
fn what_a_file_does_not_say_is_taken_to_be_the_same_and_said() {
    let unknown = Frame { unit: Unit::Unknown, space: Space::Unknown, ..ras() };
    let other = scan([20; 3], unknown, linear);
    let said = ball().differences(&other);
    assert_eq!(said[0], "axes are RAS and unknown; they are taken to be the same");
    assert_eq!(said[1], "units are mm and unknown; they are taken to be the same");
}

#[test]
fn caps_have_values_and_what_is_outside_has_none() {
    let job = Job::default();
    let all = scan([20; 3], ras(), |_| 1.0);
    let (box_of_all, other) = (mesh(&all), scan([20; 3], ras(), linear));
    let values = all.attribute(&box_of_all, &other, Between::Linear, &job).unwrap();
    // Caps are up to a thousandth of a sample beyond the border, and have the value there.
    let border = |place: Vector| {
        let ijk = ras().index_to_world.inverse_point(place);
        ras().index_to_world.point(ijk.map(|c| c.clamp(0.0, 19.0)))
    };
    is_linear(&box_of_all, &values, border);
    // A part of the other scan has the values of the whole, where it is.
    let part = other.clone().cropped(&Region::parse_samples("10:,:,:").unwrap()).unwrap();
    let found = all.attribute(&box_of_all, &part, Between::Linear, &job).unwrap();
    let inside = |vertex: usize| {
        ras().index_to_world.inverse_point(box_of_all.positions.get(vertex))[0] >= 9.5
    };
    for (vertex, value) in found.iter().enumerate() {
        assert_eq!(value.is_nan(), !inside(vertex), "{vertex}");
    }
    assert!((0..found.len()).any(|n| found[n] == values[n] && inside(n)));
}

#[test]
fn a_value_that_f32_cannot_hold_is_none() {
    let (ball, job) = (ball(), Job::default());
    let large = scan([20; 3], ras(), |[x, ..]| if x > 0.0 { 1e39 } else { -1e38 });
    let values = ball.attribute(&mesh(&ball), &large, Between::Nearest, &job).unwrap();
    assert!(values.iter().all(|&value| value.is_nan() || value == -1e38));
    assert!(values.iter().any(|value| value.is_nan()) && values.contains(&-1e38));
}

#[test]
fn any_number_of_threads_gives_the_same_values() {
    let (ball, other) = (ball(), scan([15; 3], ras(), |[x, y, z]| (x * y + z).sin()));
    let mesh = mesh(&ball);
    let with = |threads: usize| {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let job = Job { threads, ..Job::default() };
        let values = ball.attribute(&mesh, &other, Between::Linear, &job).unwrap();
        values.into_iter().map(f32::to_bits).collect::<Vec<_>>()
    };
    assert_eq!(with(1), with(3));
}

/// Colours that are linear in the world of RAS, on a lattice of LPS in metres.
fn colors(channels: Channels) -> ColorVolume {
    let step = 1e-3;
    let columns = [[step, 0.0, 0.0], [0.0, step, 0.0], [0.0, 0.0, step]];
    let frame = Frame { unit: Unit::Metre, ..frame(columns, [-0.02; 3], Space::Lps) };
    let grid = Grid::new([41; 3], frame).unwrap();
    let place = |n: u64| [n % 41, n / 41 % 41, n / 1681].map(|i| i as f64 - 20.0);
    let color = |[x, y, z]: Vector| codes([-x, -y, z]).map(|code| code as u8);
    let bytes = (0..grid.count()).flat_map(|n| color(place(n))[..channels.count()].to_vec());
    ColorVolume::new(grid, channels, bytes.collect()).unwrap()
}

fn codes([x, y, z]: Vector) -> [f64; 4] {
    [128.0 + 2.0 * x - y, 100.0 - 3.0 * z, 7.0, 90.0 + z]
}

#[test]
fn linear_colours_are_exact_in_any_world() {
    let (ball, job) = (ball(), Job::default());
    for channels in [Channels::Rgb, Channels::Rgba] {
        let colors = colors(channels);
        assert_eq!(ball.differences_from(&colors.grid().frame), [""; 0]);
        for (space, sign) in [(TargetSpace::Source, 1.0), (TargetSpace::Lps, -1.0)] {
            let placed = ball.clone().placed(space).unwrap();
            let mesh = mesh(&placed);
            let found = placed.attribute_colors(&mesh, &colors, Between::Linear, &job).unwrap();
            for (place, found) in mesh.positions.iter().zip(found) {
                let Rgba(found) = found.unwrap();
                let expected = codes([sign * place[0], sign * place[1], place[2]]);
                let count = channels.count();
                for (found, expected) in found.into_iter().zip(expected).take(count) {
                    assert!((f64::from(found) - expected).abs() < 0.5 + 1e-3, "{place:?}");
                }
                assert!(count == 4 || found[3] == 255);
            }
        }
    }
}

#[test]
fn beyond_the_colours_there_is_none() {
    let (ball, job) = (ball(), Job::default());
    let grid = Grid::new([2; 3], ras()).unwrap();
    let colors = ColorVolume::new(grid, Channels::Rgb, vec![9; 24]).unwrap();
    let found = ball.attribute_colors(&mesh(&ball), &colors, Between::Nearest, &job).unwrap();
    assert!(found.iter().all(|color| color.is_none()));
}

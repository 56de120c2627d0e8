//! Surfaces behind opaque ones: not made, and nobody sees a difference.

use super::{BLUE, RED, behind, look, scan, scene, size};
use crate::{
    pipeline::Scan,
    scene::{CapStyle, Clip, Scene, SurfaceLook, Unneeded, Viewpoint},
};
use isokit_geom::{Affine, Frame, HalfSpace};
use isokit_job::{Job, Threads};
use isokit_mesh::TriMesh;
use isokit_render::{Image, Projection, RasterOptions, Side, Size, Smoothing};
use isokit_volume::{Grid, Volume};
use std::num::{NonZeroU32, NonZeroUsize};

const PARALLEL: Projection = Projection::Parallel { height: 60.0 };
const PERSPECTIVE: Projection = Projection::Perspective { fov: 40.0 };

fn at(from: [f64; 3], orbit: f64, projection: Projection) -> Viewpoint {
    Viewpoint::At { from, at: Some([0.0; 3]), up: [0.0, 0.1, 1.0], orbit, projection }
}

fn framed(orbit: f64, fov: Option<f64>) -> Viewpoint {
    Viewpoint::Framed { side: Side::Anterior, orbit, fov, turns: orbit > 0.0 }
}

/// Balls within a ball.
fn nested(opacities: [f32; 3]) -> Scene {
    let [a, b, c] = opacities;
    let surfaces = vec![
        look("marrow", 15.0, BLUE, c),
        look("skin", 0.0, RED, a),
        look("bone", 10.0, [1.0; 3], b),
    ];
    Scene { surfaces, raster: RasterOptions::DEFAULT, ..scene() }
}

fn bits(image: &Image) -> Vec<[u32; 4]> {
    let pixels = image.pixels().iter();
    pixels.map(|p| [p.color[0], p.color[1], p.color[2], p.opacity].map(f32::to_bits)).collect()
}

/// Makes the surfaces with and without those that are hidden, and compares pictures. Which are hidden comes back.
#[track_caller]
fn check(scene: &Scene, scan: &Scan, (viewpoints, size): (&[Viewpoint], Size)) -> Vec<usize> {
    let (job, camera) = (Job::default(), (viewpoints, size));
    let all = scene.meshes(scan, camera, &job).unwrap();
    let sight = scene.meshes_in_sight(scan, camera, &job).unwrap();
    for (n, (mesh, whole)) in sight.meshes.iter().zip(&all).enumerate() {
        match sight.hidden.contains(&n) {
            true => assert!(*mesh == TriMesh::default() && !whole.triangles.is_empty(), "{n}"),
            false => assert!(mesh == whole, "{n}"),
        }
    }
    for &viewpoint in viewpoints {
        let scene = Scene { viewpoint, ..scene.clone() };
        let draw = |meshes: &[TriMesh]| {
            bits(&scene.draw(meshes, (Some(scan), scan.around()), size, &job).unwrap().0)
        };
        assert!(draw(&sight.meshes) == draw(&all), "{viewpoint:?}, {:?}", sight.hidden);
    }
    sight.hidden
}

#[test]
fn what_a_ball_encloses_is_not_made_and_nobody_sees_a_difference() {
    let scan = scan();
    for viewpoints in [
        vec![at([3.0, 60.0, 9.0], 0.0, PARALLEL)],
        vec![at([3.0, 60.0, 9.0], 0.0, PERSPECTIVE), at([3.0, 60.0, 9.0], 77.0, PERSPECTIVE)],
        vec![framed(0.0, None)],
        vec![framed(0.0, Some(30.0)), framed(100.0, Some(30.0)), framed(200.0, None)],
    ] {
        let camera = (&viewpoints[..], size());
        assert_eq!(check(&nested([1.0, 1.0, 1.0]), &scan, camera), [0, 2], "{viewpoints:?}");
        assert_eq!(check(&nested([1.0, 0.5, 0.0]), &scan, camera), [2], "one nobody sees anyway");
        // Seen through the outer one is the next.
        assert_eq!(check(&nested([0.5, 1.0, 0.3]), &scan, camera), [0]);
        assert_eq!(check(&nested([0.5, 0.5, 0.5]), &scan, camera), [0; 0]);
    }
    // One that is nowhere is not hidden.
    let mut scene = nested([1.0; 3]);
    scene.surfaces[0].iso = Some(99.0);
    assert_eq!(check(&scene, &scan, (&[framed(0.0, None)], size())), [2]);
    assert_eq!(Unneeded::Hidden.to_string(), "it is behind opaque surfaces");
}

#[test]
fn a_plane_through_the_outer_surface_opens_it_and_one_through_the_inner_does_not() {
    let scan = scan();
    let half = HalfSpace::new([0.2, 1.0, 0.1], 2.0).unwrap();
    let clip = |names: Option<&str>, cap| Clip {
        half,
        surfaces: names.map(|name| vec![name.to_owned()]),
        cap,
    };
    let viewpoints = [at([3.0, 60.0, 9.0], 0.0, PERSPECTIVE), framed(40.0, None)];
    for (name, expected) in [(None, &[][..]), (Some("skin"), &[0]), (Some("bone"), &[0, 2])] {
        for cap in [CapStyle::None, CapStyle::Solid] {
            let scene = Scene { clips: vec![clip(name, cap)], ..nested([1.0; 3]) };
            let hidden = check(&scene, &scan, (&viewpoints, size()));
            assert_eq!(hidden, expected, "{name:?}, {cap:?}");
        }
    }
    // What is left of the inner one is behind the plane that leaves a half of the outer one.
    let clips = vec![behind(0.0, Some("skin"), CapStyle::None)];
    let scene = Scene { clips, surfaces: nested([1.0; 3]).surfaces[1..].to_vec(), ..scene() };
    assert_eq!(check(&scene, &scan, (&viewpoints, size())), [0; 0]);
}

#[test]
fn nothing_is_hidden_where_pictures_depend_on_it_all_the_same() {
    let (scan, viewpoint) = (scan(), [at([3.0, 60.0, 9.0], 0.0, PERSPECTIVE)]);
    let camera = (&viewpoint[..], size());
    let hidden =
        |raster: RasterOptions| check(&Scene { raster, ..nested([1.0; 3]) }, &scan, camera);
    let (plain, side) = (RasterOptions::DEFAULT, Some([1.0, 0.5, 0.0]));
    assert_eq!(hidden(plain.with_light_from(side, false)), [0, 2]);
    assert_eq!(hidden(plain.with_light_from(side, true)), [0; 0]);
    assert_eq!(hidden(plain.with_occlusion(0.5)), [0; 0]);
    for smoothing in [Smoothing::None, Smoothing::Sixteen] {
        assert_eq!(hidden(plain.with_smoothing(smoothing)), [0, 2]);
    }
    // From within the outer ball, and from beside it with the eye's plane through it.
    for from in [[0.0, 15.0, 0.0], [19.9, 0.0, 3.0]] {
        for projection in [PERSPECTIVE, PARALLEL] {
            let within = [at(from, 0.0, projection)];
            assert_eq!(check(&nested([1.0; 3]), &scan, (&within, size())), [0; 0]);
        }
    }
    // Pixels as large as the balls.
    let one = NonZeroU32::new(1).unwrap();
    let small = Size { width: one, height: one };
    let far = [at([0.0, 60.0, 0.0], 0.0, Projection::Parallel { height: 1e3 })];
    assert_eq!(check(&nested([1.0; 3]), &scan, (&far, small)), [0; 0]);
}

#[test]
fn a_surface_is_hidden_only_if_it_is_from_all_viewpoints() {
    // Both surfaces end at the border below, with caps in one plane.
    let scan = field([40, 36, 30], |[x, y, z]| {
        12.0 - ((x - 20.0).powi(2) + (y - 18.0).powi(2) + (z - 5.0).powi(2)).sqrt()
    });
    let surfaces = vec![look("skin", 0.0, RED, 1.0), look("bone", 4.0, BLUE, 1.0)];
    let scene = Scene { surfaces, ..nested([1.0; 3]) };
    let from = |from: [f64; 3]| {
        let (at, up) = (Some([20.0, 18.0, 5.0]), [0.1, 0.2, 1.0]);
        Viewpoint::At { from, at, up, orbit: 0.0, projection: PERSPECTIVE }
    };
    let [above, side, below] =
        [[20.0, 60.0, 60.0], [80.0, 20.0, 7.0], [25.0, -30.0, -50.0]].map(from);
    for (viewpoints, expected) in [
        (&[above][..], &[1][..]),
        (&[above, side], &[1]),
        (&[below], &[]),
        (&[above, below], &[]),
        (&[side, above, framed(30.0, Some(30.0))], &[1]),
    ] {
        assert_eq!(check(&scene, &scan, (viewpoints, size())), expected, "{viewpoints:?}");
    }
}

/// Samples of a formula.
fn field(dims: [u64; 3], value: impl Fn([f64; 3]) -> f64) -> Scan {
    let frame = Frame { index_to_world: Affine::IDENTITY, ..Frame::default() };
    let grid = Grid::new(dims, frame).unwrap();
    let place =
        |n: u64| [n % dims[0], n / dims[0] % dims[1], n / dims[0] / dims[1]].map(|i| i as f64);
    let samples = (0..grid.count()).map(|n| value(place(n)) as f32).collect();
    Scan::new(Volume::new(grid, samples).unwrap())
}

/// Numbers from 0 to 1, from a generator with a fixed beginning.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    /// Balls anywhere, some of them beyond the border, and noise, in a lattice that may be askew.
    fn scan(&mut self) -> Scan {
        let dims = [34_u64, 30, 26];
        let is_inside = self.next() < 0.7;
        let balls = [0; 4].map(|_| match is_inside {
            true => (dims.map(|n| (0.35 + 0.3 * self.next()) * n as f64), 3.0 + 5.0 * self.next()),
            false => (dims.map(|n| self.next() * n as f64), 4.0 + 9.0 * self.next()),
        });
        let noise = [0.0, 0.0, 0.3, 1.5][(self.next() * 4.0) as usize];
        let shear = if self.next() < 0.5 { 0.3 } else { 0.0 };
        let columns = [[1.0, shear, 0.0], [0.0, 0.7, 0.0], [shear, 0.1 * shear, 1.3]];
        let index_to_world = Affine::new(columns, [-17.0, -10.1, -16.7]).unwrap();
        let grid = Grid::new(dims, Frame { index_to_world, ..Frame::default() }).unwrap();
        let samples = (0..grid.count()).map(|n| {
            let place = [n % 34, n / 34 % 30, n / 1020].map(|i| i as f64);
            let depth = |(middle, radius): &([f64; 3], f64)| {
                radius - (0..3).map(|k| (place[k] - middle[k]).powi(2)).sum::<f64>().sqrt()
            };
            let depth = balls.iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
            (depth + noise * (self.next() - 0.5)) as f32
        });
        let samples = samples.collect();
        Scan::new(Volume::new(grid, samples).unwrap())
    }

    fn surfaces(&mut self) -> Vec<SurfaceLook> {
        let look = |n: usize| {
            let iso = [-0.5, 0.0, 0.4, 2.0, 2.2, 5.0][(self.next() * 6.0) as usize];
            let (iso, chance) = if n == 0 { (-0.5, 0.8) } else { (iso, 0.5) };
            let opacity = if self.next() < chance { 1.0 } else { 0.4 };
            look(["a", "b", "c", "d"][n], iso, [0.2 * n as f32, 0.5, 1.0 - 0.2 * n as f32], opacity)
        };
        (0..4).map(look).collect()
    }

    fn viewpoint(&mut self) -> Viewpoint {
        let projection = if self.next() < 0.5 { PARALLEL } else { PERSPECTIVE };
        match self.next() {
            n if n < 0.5 => framed(360.0 * self.next(), (n < 0.3).then_some(30.0)),
            n => {
                let far = if n < 0.8 { 70.0 } else { 25.0 };
                let from = [0; 3].map(|_| far * (0.2 + self.next()) * (self.next() - 0.5).signum());
                at(from, 30.0 * self.next(), projection)
            }
        }
    }
}

#[test]
fn of_surfaces_by_chance_what_is_hidden_is_seen_in_no_picture() {
    let (mut chance, mut hidden, mut shown) = (Chance(11), 0, 0);
    for n in 0..60 {
        let scan = chance.scan();
        let clips = match n % 4 {
            0 => {
                let name = ["a", "b"][n / 4 % 2];
                let half = HalfSpace::new([chance.next(), 1.0, -chance.next()], 1.0).unwrap();
                vec![Clip { half, surfaces: Some(vec![name.into()]), cap: CapStyle::Solid }]
            }
            _ => vec![],
        };
        let scene = Scene { surfaces: chance.surfaces(), clips, ..nested([1.0; 3]) };
        let viewpoints: Vec<_> = (0..1 + n % 2).map(|_| chance.viewpoint()).collect();
        let found = check(&scene, &scan, (&viewpoints, size())).len();
        (hidden, shown) = (hidden + found, shown + 4 - found);
    }
    assert!(hidden > 12 && shown > 100, "{hidden}, {shown}");
}

#[test]
fn what_is_hidden_does_not_depend_on_threads() {
    let mut chance = Chance(5);
    for _ in 0..6 {
        let (scan, surfaces) = (chance.scan(), chance.surfaces());
        let scene = Scene { surfaces, ..nested([1.0; 3]) };
        let viewpoint = [framed(20.0, Some(30.0))];
        let found = [1, 2, 5].map(|threads| {
            let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
            let job = Job { threads, ..Job::default() };
            scene.meshes_in_sight(&scan, (&viewpoint, size()), &job).unwrap()
        });
        assert!(found[1] == found[0] && found[2] == found[0]);
    }
}

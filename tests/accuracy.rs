//! How the error of a surface falls with the distance of the samples: orders, fitted on four grids.
//!
//! A field with a known gradient is sampled, and the error of a vertex is |f| / |∇f| there, its distance
//! from the surface to first order. Orders are slopes of a line through the logarithms (Etiene et al. 2009,
//! "Verifiable visualization for isosurface extraction").

use isokit::{
    geom::{Affine, Frame},
    job::Job,
    marching_cubes::{Boundary, Degenerate, ExtractOptions, Gradient, Placement, extract},
    mesh::{Precision, TriMesh, topology},
    volume::{Grid, Volume},
};
use isokit_tests::{
    chance::Chance,
    fields::{self, Field, gradient},
};
use std::f64::consts::PI;

/// Samples along each axis of the cube from −1 to 1.
const GRIDS: [u64; 4] = [41, 57, 81, 113];

fn volume(field: &Field, points: u64) -> Volume<f64> {
    let step = 2.0 / (points - 1) as f64;
    let index_to_world = Affine::axis_aligned([step; 3], [-1.0; 3]).unwrap();
    let grid = Grid::new([points; 3], Frame { index_to_world, ..Frame::default() }).unwrap();
    let place = |i: u64| index_to_world.point([i as f64; 3])[0];
    let at = |n: u64| field([n % points, n / points % points, n / points / points].map(place));
    Volume::new(grid, (0..grid.count()).map(at).collect()).unwrap()
}

fn surface(field: &Field, points: u64, (placement, gradient): (Placement, Gradient)) -> TriMesh {
    let options = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
    let options = options.with_degenerate(Degenerate::Exact).with_precision(Some(Precision::F64));
    let options = options.with_placement(placement).with_gradient(gradient);
    extract(&volume(field, points).view(), 0.0, &options, &Job::default()).unwrap()
}

/// The slope of a line through the logarithms of errors over those of the distances of samples.
fn order(errors: [f64; 4]) -> f64 {
    let points = GRIDS.iter().zip(errors).map(|(&n, error)| (-((n - 1) as f64).ln(), error.ln()));
    let points: Vec<_> = points.collect();
    let mean = |part: fn(&(f64, f64)) -> f64| points.iter().map(part).sum::<f64>() / 4.0;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let (mut xy, mut xx) = (0.0, 0.0);
    for p in &points {
        xy += (p.0 - x) * (p.1 - y);
        xx += (p.0 - x) * (p.0 - x);
    }
    xy / xx
}

/// The errors of places and of normals (as the sine's double of half the angle), root mean square. Normals are f32:
/// what rounding the true ones makes is taken off theirs.
fn errors(field: &Field, mesh: &TriMesh) -> [f64; 2] {
    let (mut place, mut angle) = (0.0, 0.0);
    for (xyz, normal) in mesh.positions.iter().zip(mesh.normals.as_ref().unwrap()) {
        let steep = gradient(field, xyz);
        let length = steep.iter().map(|c| c * c).sum::<f64>().sqrt();
        place += (field(xyz) / length).powi(2);
        let exact = steep.map(|c| -c / length);
        let apart =
            |found: [f32; 3]| (0..3).map(|k| (f64::from(found[k]) - exact[k]).powi(2)).sum::<f64>();
        angle += apart(*normal) - apart(exact.map(|c| c as f32));
    }
    [place, angle].map(|sum| (sum / mesh.positions.len() as f64).sqrt())
}

fn metaballs() -> Field {
    fields::metaballs(&[[-0.3, -0.1, 0.05], [0.25, 0.15, -0.1], [0.1, -0.35, 0.2]], 0.4)
}

/// The order of normals made from central differences within a volume; and of a surface that leaves it, since at the border
/// their order is one.
const WITHIN: f64 = 1.9;
const THROUGH_THE_BORDER: f64 = 1.4;

#[track_caller]
fn check(name: &str, field: &Field, of_central: f64) {
    let mut finest = vec![];
    for (made, [of_places, of_normals]) in [
        ((Placement::Linear, Gradient::Central), [1.9, of_central]),
        ((Placement::Quintic, Gradient::Central), [5.5, of_central]),
        ((Placement::Cubic, Gradient::Matching), [3.8, 3.8]),
        ((Placement::Quintic, Gradient::Matching), [5.5, 5.5]),
    ] {
        let errors = GRIDS.map(|points| errors(field, &surface(field, points, made)));
        let [places, normals] = [0, 1].map(|n| order(errors.map(|both| both[n])));
        let says = format!("{name}, {made:?}: {places:.2}, {normals:.2} from {errors:?}");
        assert!(places >= of_places, "places of {says}");
        assert!(normals >= of_normals, "normals of {says}");
        finest.push(errors[3]);
    }
    let [linear, central, cubic, quintic] = finest[..] else { unreachable!("four") };
    assert!(cubic[0] < linear[0] / 10.0 && quintic[0] < cubic[0] / 10.0, "{name}: {finest:?}");
    assert!(cubic[1] < linear[1] && quintic[1] < cubic[1], "{name}: {finest:?}");
    assert!(central[0] == quintic[0] && central[1] < 1.1 * linear[1], "{name}: {finest:?}");
}

#[test]
fn a_sphere() {
    check("sphere", &fields::sphere(0.7), WITHIN);
}

#[test]
fn a_torus() {
    check("torus", &fields::torus(0.6, 0.25), WITHIN);
}

#[test]
fn a_gyroid_that_leaves_through_the_border() {
    check("gyroid", &fields::gyroid(1.5), THROUGH_THE_BORDER);
}

#[test]
fn waves_that_leave_through_the_border() {
    check("waves", &fields::waves(), THROUGH_THE_BORDER);
}

#[test]
fn soft_balls_that_flow_together() {
    check("metaballs", &metaballs(), WITHIN);
}

/// A window in which the finest waves have as many samples as 320³ to 900³ of the whole give them.
#[test]
fn a_window_of_marschner_and_lobbs_signal() {
    let whole = fields::marschner_lobb();
    let window = move |[x, y, z]: [f64; 3]| {
        whole([0.45 + 0.125 * x, 0.3 + 0.125 * y, 0.02 + 0.125 * z]) - 0.5
    };
    check("Marschner and Lobb", &(Box::new(window) as Field), THROUGH_THE_BORDER);
}

/// What is said of them, so that whoever measures areas of noisy scans may place linearly.
#[test]
fn in_noise_a_longer_stencil_makes_a_rougher_surface() {
    let smooth = volume(&fields::sphere(0.7), 57);
    let mut chance = Chance::new(3);
    let noise = smooth.samples().iter().map(|value| value + 0.02 * (chance.unit() - 0.5));
    let noisy = Volume::new(*smooth.grid(), noise.collect::<Vec<f64>>()).unwrap();
    let [linear, cubic, quintic] =
        [Placement::Linear, Placement::Cubic, Placement::Quintic].map(|placement| {
            let options = ExtractOptions::DEFAULT.with_placement(placement);
            let mesh = extract(&noisy.view(), 0.0, &options, &Job::default()).unwrap();
            topology(&mesh, &Job::default()).unwrap().measure.area
        });
    assert!(linear < cubic && cubic < quintic, "{linear}, {cubic}, {quintic}");
}

/// What is said of them too: how deep a place is in a wall has a crease in its middle, within their stencils.
#[test]
fn in_a_wall_thinner_than_its_stencil_a_vertex_on_a_straight_line_is_nearer() {
    let wall = |thickness: f64| -> Field {
        Box::new(move |place| {
            let off = place.iter().map(|c| c * c).sum::<f64>().sqrt() - 0.7;
            0.5 * thickness - off.abs()
        })
    };
    let points = 41;
    // In distances of samples.
    let places = |thickness: f64, placement| {
        let field = wall(thickness * 2.0 / (points - 1) as f64);
        errors(&field, &surface(&field, points, (placement, Gradient::Central)))[0]
    };
    for (thickness, placement) in [
        (1.6, Placement::Cubic),
        (1.6, Placement::Quintic),
        (2.4, Placement::Cubic),
        (3.2, Placement::Quintic),
    ] {
        let [straight, longer] = [Placement::Linear, placement].map(|p| places(thickness, p));
        assert!(straight < longer / 1.5, "{thickness}, {placement:?}: {straight:e}, {longer:e}");
    }
    for (thickness, placement) in [(6.0, Placement::Cubic), (10.0, Placement::Quintic)] {
        let [straight, longer] = [Placement::Linear, placement].map(|p| places(thickness, p));
        assert!(longer < straight / 2.0, "{thickness}, {placement:?}: {straight:e}, {longer:e}");
    }
}

/// Area and volume of a surface.
fn measures(field: &Field, points: u64, placement: Placement) -> [f64; 2] {
    let mesh = surface(field, points, (placement, Gradient::Central));
    let measure = topology(&mesh, &Job::default()).unwrap().measure;
    [measure.area, measure.volume]
}

#[track_caller]
fn check_measures(field: &Field, exact: [f64; 2]) {
    for placement in [Placement::Linear, Placement::Cubic, Placement::Quintic] {
        let found = GRIDS.map(|points| measures(field, points, placement));
        for n in [0, 1] {
            let errors = found.map(|both| (both[n] - exact[n]).abs());
            let order = order(errors);
            assert!((1.9..2.2).contains(&order), "{placement:?}: {order}, {errors:?}");
        }
    }
}

#[test]
fn areas_and_volumes_of_a_sphere_are_of_order_two() {
    let radius = 0.7_f64;
    let exact = [4.0 * PI * radius.powi(2), 4.0 / 3.0 * PI * radius.powi(3)];
    check_measures(&fields::sphere(radius), exact);
}

#[test]
fn areas_and_volumes_of_a_torus_are_of_order_two() {
    let (radius, tube) = (0.6_f64, 0.25_f64);
    let exact = [4.0 * PI.powi(2) * radius * tube, 2.0 * PI.powi(2) * radius * tube.powi(2)];
    check_measures(&fields::torus(radius, tube), exact);
}

/// What they are by a closed form nobody knows. If the order is two, two finer grids tell to order four.
#[test]
fn areas_and_volumes_of_soft_balls_are_of_order_two() {
    let field = metaballs();
    let [coarse, fine] = [161, 225].map(|points| measures(&field, points, Placement::Quintic));
    let ratio = (224.0_f64 / 160.0).powi(2);
    let exact = [0, 1].map(|n| fine[n] + (fine[n] - coarse[n]) / (ratio - 1.0));
    check_measures(&field, exact);
}

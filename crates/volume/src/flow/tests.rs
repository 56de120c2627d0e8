//! Flows that are known, on lattices that lie anyhow.

use crate::{Grid, Quantity, Scaling, Vectors, View, Volume};
use isokit_geom::{
    Affine, Frame,
    vector::{Vector, cross, length},
};
use isokit_job::{Job, Threads};
use std::{f64::consts::TAU, num::NonZeroUsize};

const SAME: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Oblique, sheared, anisotropic, and left-handed with `sign` −1.
fn frame(sign: f64) -> Frame {
    let columns = [[0.5, 0.1, 0.0], [-0.2, 0.7, 0.1], [0.05 * sign, 0.1 * sign, 0.9 * sign]];
    Frame { index_to_world: Affine::new(columns, [1.0, -2.0, 3.0]).unwrap(), ..Frame::default() }
}

/// The components of a flow, sampled.
fn flow(dims: [u64; 3], frame: Frame, f: impl Fn(Vector) -> Vector) -> [Volume<f64>; 3] {
    let grid = Grid::new(dims, frame).unwrap();
    let place = |n: u64| {
        let ijk = [n % dims[0], n / dims[0] % dims[1], n / (dims[0] * dims[1])];
        frame.index_to_world.point(ijk.map(|i| i as f64))
    };
    let component = |c: usize| (0..grid.count()).map(|n| f(place(n))[c]).collect();
    [0, 1, 2].map(|c| Volume::new(grid, component(c)).unwrap())
}

fn of(flow: &[Volume<f64>; 3], quantity: Quantity) -> Vec<f32> {
    let views = flow.each_ref().map(Volume::view);
    let found = Vectors::new(views, SAME).quantity(quantity, &Job::default()).unwrap();
    found.samples().to_vec()
}

/// A flow whose derivatives are the same everywhere has these quantities everywhere.
#[track_caller]
fn check(f: impl Fn(Vector) -> Vector, divergence: f64, vorticity: f64, q: f64) {
    for sign in [1.0, -1.0] {
        let flow = flow([7, 6, 5], frame(sign), &f);
        for (quantity, expected) in [
            (Quantity::Divergence, divergence),
            (Quantity::Vorticity, vorticity),
            (Quantity::QCriterion, q),
        ] {
            for found in of(&flow, quantity) {
                assert!((f64::from(found) - expected).abs() < 1e-5, "{quantity}: {found}");
            }
        }
    }
}

#[test]
fn what_turns_as_a_whole_has_twice_its_speed_of_turning_and_its_square() {
    let axis = [0.3, -0.4, 1.2];
    let omega = length(axis);
    check(|place| cross(axis, place), 0.0, 2.0 * omega, omega * omega);
}

#[test]
fn pure_shear_neither_spreads_nor_is_a_vortex() {
    check(|[_, y, _]| [1.5 * y + 2.0, 0.0, 0.0], 0.0, 1.5, 0.0);
}

#[test]
fn stretching_spreads_and_does_not_turn() {
    let [a, b, c] = [0.5, -0.25, 2.0];
    let q = -0.5 * (a * a + b * b + c * c);
    check(|[x, y, z]| [a * x + 1.0, b * y, c * z], a + b + c, 0.0, q);
}

#[test]
fn speed_and_components_are_those_of_the_samples_in_the_world() {
    let flow = flow([3, 4, 5], frame(1.0), |[x, y, z]| [x, 2.0 * y, z - 1.0]);
    let views = flow.each_ref().map(|one| one.view().with_scaling(Scaling::new(2.0, 1.0).unwrap()));
    // Stored along y, −x and z.
    let turned = Vectors::new(views, [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    let job = Job::default();
    let [x, y, z, speed] =
        ["x", "y", "z", "speed"].map(|name| turned.quantity(name.parse().unwrap(), &job).unwrap());
    for n in 0..60 {
        let value = |c: usize| 2.0 * flow[c].samples()[n] + 1.0;
        assert_eq!(x.samples()[n], -value(1) as f32);
        assert_eq!([y.samples()[n], z.samples()[n]], [value(0) as f32, value(2) as f32]);
        let expected = length([0, 1, 2].map(value)) as f32;
        assert!((speed.samples()[n] - expected).abs() <= 1e-6 * expected);
    }
    // What turns with the axes turns as fast: a quarter turn of everything changes no quantity.
    let vortex = self::flow([5; 3], Frame::default(), |[x, y, _]| [y * 0.7, -x * 0.2, 0.0]);
    let views = vortex.each_ref().map(Volume::view);
    let plain = Vectors::new(views, SAME).quantity(Quantity::Vorticity, &job).unwrap();
    assert!(plain.samples().iter().all(|w| (w - 0.9).abs() < 1e-6));
}

/// The greatest error inside of a flow of Arnold, Beltrami and Childress, which is its own curl, with so many samples.
fn abc_error(n: u64, quantity: Quantity) -> f64 {
    let [a, b, c] = [1.0, 0.7, 0.4];
    let step = TAU / (n - 1) as f64;
    let affine = Affine::axis_aligned([step; 3], [0.0; 3]).unwrap();
    let frame = Frame { index_to_world: affine, ..Frame::default() };
    let abc = |[x, y, z]: Vector| {
        [a * z.sin() + c * y.cos(), b * x.sin() + a * z.cos(), c * y.sin() + b * x.cos()]
    };
    let found = of(&flow([n; 3], frame, abc), quantity);
    let mut most = 0.0_f64;
    for (number, found) in found.into_iter().enumerate() {
        let ijk =
            [number % n as usize, number / n as usize % n as usize, number / (n * n) as usize];
        if ijk.iter().any(|&i| i == 0 || i + 1 == n as usize) {
            continue;
        }
        let [x, y, z] = ijk.map(|i| i as f64 * step);
        // Rows of the derivatives, by hand.
        let [xy, xz] = [-c * y.sin(), a * z.cos()];
        let [yx, yz] = [b * x.cos(), -a * z.sin()];
        let [zx, zy] = [-b * x.sin(), c * y.cos()];
        let expected = match quantity {
            Quantity::Vorticity => length(abc([x, y, z])),
            Quantity::QCriterion => -(xy * yx + xz * zx + yz * zy),
            _ => 0.0,
        };
        most = most.max((f64::from(found) - expected).abs());
    }
    most
}

#[test]
fn errors_fall_with_the_square_of_the_distance_of_samples() {
    for quantity in [Quantity::Vorticity, Quantity::QCriterion] {
        let [coarse, fine] = [17, 33].map(|n| abc_error(n, quantity));
        let order = (coarse / fine).log2();
        assert!((1.8..2.2).contains(&order) && fine < 0.05, "{quantity}: {coarse}, {fine}");
    }
    assert!(abc_error(17, Quantity::Divergence) < 1e-6);
}

/// Numbers that look like chance.
fn chance(count: usize, mut state: u64) -> Vec<f64> {
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / f64::from(1 << 23) - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// The definition, with matrices written out: central differences along x, y, z of a lattice with one step for all.
fn plain(flow: &[Volume<f64>; 3], ijk: [usize; 3], step: f64, quantity: Quantity) -> f64 {
    let dims = flow[0].grid().dims().map(|n| n as usize);
    let at = |c: usize, [i, j, k]: [usize; 3]| flow[c].samples()[i + dims[0] * (j + dims[1] * k)];
    let mut gradient = [[0.0; 3]; 3];
    for (c, row) in gradient.iter_mut().enumerate() {
        for (axis, entry) in row.iter_mut().enumerate() {
            let (mut low, mut high) = (ijk, ijk);
            low[axis] = ijk[axis].saturating_sub(1);
            high[axis] = (ijk[axis] + 1).min(dims[axis] - 1);
            let steps = (high[axis] - low[axis]) as f64;
            *entry = if steps > 0.0 { (at(c, high) - at(c, low)) / (steps * step) } else { 0.0 };
        }
    }
    let (mut spin, mut strain, mut curl) = (0.0, 0.0, [0.0; 3]);
    let other = |c: usize, k: usize| gradient[k][c];
    for (c, row) in gradient.iter().enumerate() {
        for (k, entry) in row.iter().enumerate() {
            spin += (0.5 * (entry - other(c, k))).powi(2);
            strain += (0.5 * (entry + other(c, k))).powi(2);
        }
        let (i, j) = ((c + 1) % 3, (c + 2) % 3);
        curl[c] = gradient[j][i] - gradient[i][j];
    }
    match quantity {
        Quantity::Divergence => (0..3).map(|c| gradient[c][c]).sum(),
        Quantity::Vorticity => length(curl),
        _ => 0.5 * (spin - strain),
    }
}

#[test]
fn chance_has_the_quantities_of_their_definitions() {
    for (n, dims) in [[5, 4, 6], [1, 7, 3], [4, 1, 1], [2, 2, 2]].into_iter().enumerate() {
        let affine = Affine::axis_aligned([0.5; 3], [0.0; 3]).unwrap();
        let grid = Grid::new(dims, Frame { index_to_world: affine, ..Frame::default() }).unwrap();
        let seed = |c: usize| 3 * n as u64 + c as u64;
        let flow =
            [0, 1, 2].map(|c| Volume::new(grid, chance(grid.count() as usize, seed(c))).unwrap());
        for quantity in [Quantity::Divergence, Quantity::Vorticity, Quantity::QCriterion] {
            for (number, found) in of(&flow, quantity).into_iter().enumerate() {
                let [nx, ny, _] = dims.map(|n| n as usize);
                let ijk = [number % nx, number / nx % ny, number / (nx * ny)];
                let expected = plain(&flow, ijk, 0.5, quantity);
                assert!((f64::from(found) - expected).abs() < 1e-5, "{quantity} {ijk:?}");
            }
        }
    }
}

#[test]
fn what_has_no_value_stays_where_it_is() {
    let mut samples = flow([5; 3], Frame::default(), |place| cross([0.0, 0.0, 1.0], place));
    let mut hole = samples[1].samples().to_vec();
    hole[62] = f64::NAN; // the middle
    samples[1] = Volume::new(*samples[1].grid(), hole).unwrap();
    for (quantity, expected) in [(Quantity::Vorticity, 2.0), (Quantity::QCriterion, 1.0)] {
        for (n, found) in of(&samples, quantity).into_iter().enumerate() {
            assert!(if n == 62 { found.is_nan() } else { (found - expected).abs() < 1e-6 }, "{n}");
        }
    }
}

#[test]
fn components_may_lie_together_and_threads_make_no_difference() {
    let numbers = chance(3 * 6 * 5 * 4, 1);
    let grid = Grid::new([6, 5, 4], frame(1.0)).unwrap();
    let views = [0, 1, 2].map(|c| View::strided(&numbers, c, [3, 18, 90], &grid).unwrap());
    let with = |threads: usize| {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let job = Job { threads, ..Job::default() };
        let found = Vectors::new(views, SAME).quantity(Quantity::QCriterion, &job).unwrap();
        found.samples().iter().map(|q| q.to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(with(1), with(3));
    let apart = [0, 1, 2]
        .map(|c| Volume::new(grid, numbers.iter().skip(c).step_by(3).copied().collect()).unwrap());
    let found: Vec<u32> = of(&apart, Quantity::QCriterion).iter().map(|q| q.to_bits()).collect();
    assert_eq!(with(2), found);
}

#[test]
fn names_are_read_back() {
    for (quantity, name) in Quantity::ALL {
        assert_eq!((name.parse(), quantity.to_string().as_str()), (Ok(quantity), name));
    }
    assert!("curl".parse::<Quantity>().is_err());
}

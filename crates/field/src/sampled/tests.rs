//! Cubics of samples, against what they are exact for, sums sample by sample, and their orders.

use super::Sampled;
use crate::ScalarField;
use isokit_volume::{Grid, Scaling, Volume, line};

fn volume(dims: [usize; 3], f: impl Fn([f64; 3]) -> f64) -> Volume<f64> {
    let [nx, ny, nz] = dims;
    let grid = Grid::new(dims.map(|n| n as u64), Default::default()).unwrap();
    let point = |n: usize| [n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64);
    Volume::new(grid, (0..nx * ny * nz).map(|n| f(point(n))).collect()).unwrap()
}

/// Places all over a lattice, on its border, and a little beyond.
fn places(dims: [usize; 3]) -> impl Iterator<Item = [f64; 3]> {
    (0..400).map(move |n: u32| {
        std::array::from_fn(|axis| {
            let share = f64::from(n * [37, 101, 53][axis] % 211) / 210.0;
            share * (dims[axis] as f64 - 0.5) - 0.25
        })
    })
}

#[test]
fn a_value_is_known_where_it_is_finite() {
    for dims in [[9, 7, 8], [3, 6, 5], [2, 1, 4]] {
        let holes = |[x, y, z]: [f64; 3]| match (31.0 * x + 7.0 * y + 3.0 * z) % 89.0 {
            0.0..3.0 => f64::INFINITY.copysign(x - y),
            3.0..6.0 => f64::NAN,
            rest => rest,
        };
        let holes = volume(dims, holes);
        let field = Sampled::new(holes.view());
        for ijk in places(dims) {
            assert_eq!(field.is_known(ijk), field.value(ijk).is_finite(), "{dims:?}, {ijk:?}");
        }
    }
}

#[test]
fn products_of_cubics_are_exact_with_gradient_and_hessian_up_to_the_border() {
    let part = |c: [f64; 4], x: f64| {
        let value = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
        [value, c[1] + x * (2.0 * c[2] + 3.0 * x * c[3]), 2.0 * c[2] + 6.0 * x * c[3]]
    };
    let parts = |[x, y, z]: [f64; 3]| {
        let x = part([0.3, -0.2, 0.05, 0.011], x);
        [x, part([-0.4, 0.1, 0.03, -0.007], y), part([0.9, 0.15, -0.02, 0.004], z)]
    };
    let f = |xyz| parts(xyz).iter().map(|part| part[0]).product::<f64>();
    let dims = [6, 5, 7];
    let volume = volume(dims, f).with_scaling(Scaling::new(-2.0, 3.0).unwrap());
    let field = Sampled::new(volume.view());
    for ijk in places(dims) {
        let p = parts(ijk);
        let product =
            |orders: [usize; 3]| -2.0 * (0..3).map(|axis| p[axis][orders[axis]]).product::<f64>();
        let unit = |axis: usize| std::array::from_fn(|k| usize::from(k == axis));
        let jet = field.jet(ijk);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-11 * (1.0 + b.abs()), "{a} {b}");
        near(jet.value, 3.0 + product([0; 3]));
        for a in 0..3 {
            near(jet.gradient[a], product(unit(a)));
            for b in 0..3 {
                let [u, v]: [[usize; 3]; 2] = [unit(a), unit(b)];
                near(jet.hessian[a][b], product(std::array::from_fn(|k| u[k] + v[k])));
            }
        }
        let slope = field.slope(ijk);
        near(slope.value, jet.value);
        near(field.value(ijk), jet.value);
        (0..3).for_each(|k| near(slope.gradient[k], jet.gradient[k]));
    }
}

/// Value, first and second derivatives at a place, sample by sample.
fn plainly(field: &Sampled<'_, f64>, ijk: [f64; 3]) -> [[[f64; 3]; 3]; 3] {
    let [x, y, z] = field.stencils(ijk);
    let mut whole = [[[0.0; 3]; 3]; 3];
    for n in 0..27 {
        let [ox, oy, oz] = [n % 3, n / 3 % 3, n / 9];
        for (c, k) in z.samples().enumerate() {
            let mut slice = 0.0;
            for (b, j) in y.samples().enumerate() {
                let mut row = 0.0;
                for (a, i) in x.samples().enumerate() {
                    row += field.view.stored([i, j, k]) * x.weights[ox][a];
                }
                slice += row * y.weights[oy][b];
            }
            whole[oz][oy][ox] += slice * z.weights[oz][c];
        }
    }
    whole
}

#[test]
fn four_slices_at_a_time_give_the_bits_of_one_sample_at_a_time() {
    for dims in [[6, 5, 7], [4, 9, 2], [1, 3, 5]] {
        let volume = volume(dims, |[x, y, z]| (1.7 * x).sin() - (0.9 * y + x).cos() * (z - 0.4));
        let field = Sampled::new(volume.view());
        for ijk in places(dims) {
            let (plain, jet) = (plainly(&field, ijk), field.jet(ijk));
            let value = plain[0][0][0];
            let first = [plain[0][0][1], plain[0][1][0], plain[1][0][0]];
            let [xy, xz, yz] = [plain[0][1][1], plain[1][0][1], plain[1][1][0]];
            let [xx, yy, zz] = [plain[0][0][2], plain[0][2][0], plain[2][0][0]];
            let second = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
            assert_eq!((jet.value, jet.gradient, jet.hessian), (value, first, second), "{ijk:?}");
            let slope = field.slope(ijk);
            assert_eq!((slope.value, slope.gradient), (value, first), "{ijk:?}");
            assert_eq!(field.value(ijk), value, "{ijk:?}");
        }
    }
}

#[test]
fn on_an_edge_of_the_lattice_it_is_the_cubic_of_that_edge() {
    let volume = volume([5, 6, 4], |[x, y, z]| (1.3 * x).sin() + (y * z * 0.7).cos());
    let (view, field) = (volume.view(), Sampled::new(volume.view()));
    for (cell, s) in (0..5).flat_map(|cell| [-0.4, 0.0, 0.3].map(|s| (cell, s))) {
        let mut around = [0.0; 4];
        line::values(&mut around, cell - 1, 6, |j| view.value([2, j, 1]));
        let found = field.value([2.0, cell as f64 + 0.5 + s, 1.0]);
        assert!((found - line::between(&around, s)).abs() < 1e-14, "{cell}, {s}");
    }
}

#[test]
fn halving_the_distance_of_samples_divides_errors_by_their_orders() {
    let f = |[x, y, z]: [f64; 3]| (1.1 * x + 0.2).sin() * (0.9 * y).cos() + (z - 0.3 * x).sin();
    let worst = |n: usize| {
        let h = 4.0 / (n - 1) as f64;
        let volume = volume([n; 3], |ijk| f(ijk.map(|i| i * h)));
        let field = Sampled::new(volume.view());
        let mut worst = [0.0_f64; 3];
        for place in places([4; 3]).map(|p| p.map(|c| (c + 0.25) * 4.0 / 3.5)) {
            let [x, y, z] = place;
            let jet = field.jet(place.map(|c| c / h));
            let cos = (z - 0.3 * x).cos();
            let by_x = 1.1 * (1.1 * x + 0.2).cos() * (0.9 * y).cos() - 0.3 * cos;
            let by_x_and_y = -0.99 * (1.1 * x + 0.2).cos() * (0.9 * y).sin();
            let by_z_twice = -(z - 0.3 * x).sin();
            worst[0] = worst[0].max((jet.value - f(place)).abs());
            worst[1] = worst[1].max((jet.gradient[0] / h - by_x).abs());
            worst[1] = worst[1].max((jet.gradient[2] / h - cos).abs());
            worst[2] = worst[2].max((jet.hessian[0][1] / h / h - by_x_and_y).abs());
            worst[2] = worst[2].max((jet.hessian[2][2] / h / h - by_z_twice).abs());
        }
        worst
    };
    let [coarse, fine] = [worst(33), worst(65)];
    for (n, order) in [4.0, 3.0, 2.0].into_iter().enumerate() {
        let found = (coarse[n] / fine[n]).log2();
        assert!((found - order).abs() < 0.35, "{found} is not {order}: {coarse:?}, {fine:?}");
    }
}

#[test]
fn a_cell_is_the_sum_of_its_control_points() {
    for dims in [[6, 5, 7], [2, 3, 4]] {
        let waves = volume(dims, |[x, y, z]| (1.7 * x).sin() - (0.9 * y + x).cos() * (z - 0.4));
        let waves = waves.with_scaling(Scaling::new(-2.0, 3.0).unwrap());
        for field in [Sampled::new(waves.view()), Sampled::catmull_rom(waves.view())] {
            for ijk in places(dims).map(|ijk| ijk.map(|c| c.max(0.0))) {
                let cell = [0, 1, 2].map(|k| (ijk[k] as usize).min(dims[k] - 2));
                let points = field.control_points(cell);
                let weight = |k: usize, n: usize| {
                    let t = ijk[k] - cell[k] as f64;
                    [1.0, 3.0, 3.0, 1.0][n] * t.powi(n as i32) * (1.0 - t).powi(3 - n as i32)
                };
                let all = (0..64).map(|n| [n % 4, n / 4 % 4, n / 16]);
                let parts = all
                    .map(|[i, j, k]| points[k][j][i] * weight(0, i) * weight(1, j) * weight(2, k));
                let (sum, value) = (parts.sum::<f64>(), field.value(ijk));
                assert!((sum - value).abs() < 1e-12, "{ijk:?}: {sum} for {value}");
            }
        }
    }
}

#[test]
fn a_hole_spreads_to_the_cells_that_look_at_it_and_no_further() {
    let hole = volume([9; 3], |ijk| if ijk == [4.0; 3] { f64::NAN } else { ijk[0] });
    let field = Sampled::new(hole.view());
    assert!(field.value([2.5, 4.0, 5.5]).is_nan() && field.jet([5.9, 3.5, 4.5]).value.is_nan());
    assert!((field.value([1.9, 4.5, 4.5]) - 1.9).abs() < 1e-14);
    assert!((field.slope([4.5, 4.5, 6.1]).gradient[0] - 1.0).abs() < 1e-13);
}

#[test]
fn a_volume_of_one_slice_does_not_change_across_it() {
    let flat = volume([4, 3, 1], |[x, y, _]| x * y);
    let jet = Sampled::new(flat.view()).jet([1.5, 1.5, 0.0]);
    assert!((jet.value - 2.25).abs() < 1e-14);
    let across = [[jet.gradient[2]; 3], jet.hessian[2]];
    assert!(across.as_flattened().iter().all(|part| part.abs() < 1e-14), "{across:?}");
}

//! A volume seen through cubics: smooth within each cell, and exact at the samples.
//!
//! Along each axis the function is the cubic through the four nearest samples, so in space it is the tensor
//! product of three such cubics, made of 64 samples. On an edge of the lattice it is the cubic of
//! `Placement::Cubic` in `marching-cubes`: vertices placed by that lie on its surface, to the last digits.
//! That is why it is this kernel and not Catmull & Rom's ([`Sampled::catmull_rom`]), which has a continuous gradient but
//! errors of O(h³) where these are O(h⁴). Across faces of cells the value is continuous and the gradient is not, by as
//! much as it is wrong. Of samples h apart of a smooth function the value is off by O(h⁴), the gradient by
//! O(h³), the Hessian by O(h²), in units of the world.
//!
//! A sample that is not finite leaves no value in the cells whose stencils it is in.

use crate::{
    Jet, ScalarField, Slope,
    kernel::{Cubic, Stencil, WIDTH, samples, stretch},
};
use isokit_geom::Affine;
use isokit_volume::{Dtype, Sample, View};

/// The cubic function through the samples of a volume.
#[derive(Clone, Copy, Debug)]
pub struct Sampled<'a, T> {
    view: View<'a, T>,
    cubic: Cubic,
}

impl<'a, T: Sample> Sampled<'a, T> {
    /// The function through the samples of `view`.
    pub fn new(view: View<'a, T>) -> Self {
        Self { view, cubic: Cubic::Lagrange }
    }

    /// Another function through the samples of `view`, with a continuous gradient: in each cell along each axis the cubic
    /// that rises at a sample as from the one before to the one after (Catmull & Rom 1974, "A class of local interpolating
    /// splines"). Values are off by O(h³), gradients by O(h²).
    pub fn catmull_rom(view: View<'a, T>) -> Self {
        Self { view, cubic: Cubic::CatmullRom }
    }

    /// How far a value of a cell may be from the middle of the range of the samples that it is made of, the cell's corners
    /// and those around, where half of the range is 1; more if the cell is at the border of the volume.
    pub fn growth(is_border: bool) -> f64 {
        stretch(is_border).powi(3)
    }

    fn stencils(&self, ijk: [f64; 3]) -> [Stencil; 3] {
        let dims = self.view.dims();
        std::array::from_fn(|axis| Stencil::at(self.cubic, ijk[axis], dims[axis]))
    }

    /// The stored samples of a stencil by their places along y, x and z; 0 where the volume has fewer.
    #[inline(always)]
    fn stored(&self, [x, y, z]: &[Stencil; 3]) -> [[[f64; WIDTH]; WIDTH]; WIDTH] {
        let mut stored = [[[0.0; WIDTH]; WIDTH]; WIDTH];
        let along_x = x.samples();
        for (c, k) in z.samples().enumerate() {
            for (stored, j) in stored.iter_mut().zip(y.samples()) {
                let four = (along_x.len() == WIDTH).then(|| [along_x.start, j, k]);
                if let Some(four) = four.and_then(|place| self.view.four(place)) {
                    for (stored, sample) in stored.iter_mut().zip(four) {
                        stored[c] = sample.to_f64();
                    }
                    continue;
                }
                for (stored, i) in stored.iter_mut().zip(along_x.clone()) {
                    stored[c] = self.view.stored([i, j, k]).to_f64();
                }
            }
        }
        stored
    }

    /// Sums of stored samples over a stencil, along x, then y, then z: for each of the derivatives that are
    /// asked for, as orders along x, y, z, `ORDERS` less one in all at most. The four slices go side by side.
    #[inline(always)]
    fn sums<const ORDERS: usize, const N: usize>(
        &self,
        ijk: [f64; 3],
        asked: [[usize; 3]; N],
    ) -> [f64; N] {
        let stencils = self.stencils(ijk);
        let [x, y, z] = &stencils;
        let stored = self.stored(&stencils);
        let mut slices = [[[0.0; WIDTH]; ORDERS]; ORDERS];
        for b in 0..WIDTH {
            let mut rows = [[0.0; WIDTH]; ORDERS];
            for a in 0..WIDTH {
                for (row, weights) in rows.iter_mut().zip(&x.weights) {
                    for (row, stored) in row.iter_mut().zip(&stored[b][a]) {
                        *row += stored * weights[a];
                    }
                }
            }
            for (along_y, (slices, weights)) in slices.iter_mut().zip(&y.weights).enumerate() {
                for (slices, row) in slices[..ORDERS - along_y].iter_mut().zip(&rows) {
                    for (slice, row) in slices.iter_mut().zip(row) {
                        *slice += row * weights[b];
                    }
                }
            }
        }
        asked.map(|[along_x, along_y, along_z]| {
            let (slices, weights) = (&slices[along_y][along_x], &z.weights[along_z]);
            slices.iter().zip(weights).fold(0.0, |sum, (slice, weight)| sum + slice * weight)
        })
    }
}

impl<T: Sample> ScalarField for Sampled<'_, T> {
    fn dims(&self) -> [usize; 3] {
        self.view.dims()
    }

    fn index_to_world(&self) -> Affine {
        self.view.frame().index_to_world
    }

    fn value(&self, ijk: [f64; 3]) -> f64 {
        let [value] = self.sums::<1, 1>(ijk, [[0; 3]]);
        self.view.scaling().value(value)
    }

    fn is_known(&self, ijk: [f64; 3]) -> bool {
        let is_place = ijk.iter().all(|c| c.is_finite());
        if !matches!(T::DTYPE, Dtype::F32 | Dtype::F64) {
            return is_place;
        }
        let ([i, j, k], [nx, ny, nz]) = (ijk, self.view.dims());
        let (x, y, z) = (samples(i, nx), samples(j, ny), samples(k, nz));
        let is_finite = |sample: T| sample.to_f64().is_finite();
        let fours = |n: usize| self.view.four([x.start, y.start + n % WIDTH, z.start + n / WIDTH]);
        if [&x, &y, &z].iter().all(|line| line.len() == WIDTH) && fours(0).is_some() {
            // All are asked, side by side.
            let known = |row: &[T; WIDTH]| row.iter().fold(true, |all, &s| all & is_finite(s));
            return (0..WIDTH * WIDTH).fold(is_place, |all, n| all & fours(n).is_some_and(known));
        }
        let rows = z.flat_map(|k| y.clone().map(move |j| [j, k]));
        let mut places = rows.flat_map(|[j, k]| x.clone().map(move |i| [i, j, k]));
        is_place && places.all(|place| is_finite(self.view.stored(place)))
    }

    fn slope(&self, ijk: [f64; 3]) -> Slope {
        let scaling = self.view.scaling();
        let [value, x, y, z] = self.sums::<2, 4>(ijk, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]);
        let gradient = [x, y, z].map(|part| part * scaling.slope());
        Slope { value: scaling.value(value), gradient }
    }

    fn jet(&self, ijk: [f64; 3]) -> Jet {
        let scaling = self.view.scaling();
        let firsts = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
        let seconds = [[2, 0, 0], [0, 2, 0], [0, 0, 2], [0, 1, 1], [1, 0, 1], [1, 1, 0]];
        let asked: [[usize; 3]; 10] =
            std::array::from_fn(|n| if n < 4 { firsts[n] } else { seconds[n - 4] });
        let [value, rest @ ..] = self.sums::<3, 10>(ijk, asked);
        let [x, y, z, xx, yy, zz, yz, xz, xy] = rest.map(|part| part * scaling.slope());
        Jet {
            value: scaling.value(value),
            gradient: [x, y, z],
            hessian: [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
        }
    }
}

#[cfg(test)]
mod tests {
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
            let product = |orders: [usize; 3]| {
                -2.0 * (0..3).map(|axis| p[axis][orders[axis]]).product::<f64>()
            };
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
            let volume =
                volume(dims, |[x, y, z]| (1.7 * x).sin() - (0.9 * y + x).cos() * (z - 0.4));
            let field = Sampled::new(volume.view());
            for ijk in places(dims) {
                let (plain, jet) = (plainly(&field, ijk), field.jet(ijk));
                let value = plain[0][0][0];
                let first = [plain[0][0][1], plain[0][1][0], plain[1][0][0]];
                let [xy, xz, yz] = [plain[0][1][1], plain[1][0][1], plain[1][1][0]];
                let [xx, yy, zz] = [plain[0][0][2], plain[0][2][0], plain[2][0][0]];
                let second = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
                assert_eq!(
                    (jet.value, jet.gradient, jet.hessian),
                    (value, first, second),
                    "{ijk:?}"
                );
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
}

//! Against the plain sums that are meant, at every level.

use super::{Add, Neighbours, Normals, Outflow, Outflows, RowNormals, STRIP, Scale, WHOLE};
use crate::{Level, wide::run_at};

/// Samples of a box, in rows that are padded.
struct Lattice {
    count: usize,
    strips: usize,
    rows: Vec<Vec<u8>>,
}

/// Rows of a slice, and slices; those at the ends are only neighbours.
const SIDE: usize = 5;

impl Lattice {
    fn new(count: usize, mut sample: impl FnMut() -> u8) -> Self {
        let strips = count.div_ceil(STRIP);
        let mut row = || {
            let mut row = vec![0; STRIP * (strips + 2)];
            row[STRIP..STRIP + count].fill_with(&mut sample);
            row[STRIP - 1] = row[STRIP];
            let last = row[STRIP + count - 1];
            row[STRIP + count..].fill(last);
            row
        };
        Self { count, strips, rows: (0..SIDE * SIDE).map(|_| row()).collect() }
    }

    fn neighbours(&self, j: usize, k: usize) -> Neighbours<'_> {
        let row = |j: usize, k: usize| &self.rows[j + SIDE * k][..];
        Neighbours {
            own: row(j, k),
            low: [row(j - 1, k), row(j, k - 1)],
            high: [row(j + 1, k), row(j, k + 1)],
        }
    }

    fn normals(
        &self,
        level: Level,
        scale: &Scale,
        [j, k]: [usize; 2],
    ) -> ([Vec<i16>; 3], Vec<bool>) {
        let mut out = [(); 3].map(|()| vec![0; STRIP * (self.strips + 2)]);
        let mut is_even = vec![false; self.strips];
        let rows = self.neighbours(j, k);
        let (count, to) = (self.count, out.each_mut().map(|row| &mut row[..]));
        run_at(level, Normals { rows, scale, count, out: to, is_even: &mut is_even });
        (out, is_even)
    }
}

fn lattices() -> Vec<Lattice> {
    let mut state = 9_u64;
    let mut next = move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        state >> 33
    };
    let mut all = vec![];
    for count in [1, 2, 31, 32, 33, 64, 100] {
        all.push(Lattice::new(count, || next() as u8));
        all.push(Lattice::new(count, || (next() % 3) as u8));
        all.push(Lattice::new(count, || u8::from(next() % 200 == 0)));
        all.push(Lattice::new(count, || 7));
    }
    all
}

const SCALES: [Scale; 2] = [
    Scale { weights: [1.0; 3], times: [1.0; 2] },
    Scale { weights: [0.3, 1.0, 0.11], times: [2.0, 1.0] },
];

#[test]
fn normals_are_gradients_over_their_lengths_at_every_level() {
    for lattice in lattices() {
        for scale in SCALES {
            let plain = lattice.normals(Level::Portable, &scale, [2, 2]);
            for &level in Level::available() {
                assert_eq!(lattice.normals(level, &scale, [2, 2]), plain, "{level}");
            }
            let Neighbours { own, low, high } = lattice.neighbours(2, 2);
            for at in STRIP..STRIP + lattice.count {
                let is_end = at == STRIP || at == STRIP + lattice.count - 1;
                let rise =
                    |[a, b]: [u8; 2], times: f32| f64::from(times) * (f64::from(b) - f64::from(a));
                let rises = [
                    rise([own[at - 1], own[at + 1]], if is_end { 2.0 } else { 1.0 }),
                    rise([low[0][at], high[0][at]], scale.times[0]),
                    rise([low[1][at], high[1][at]], scale.times[1]),
                ];
                let weights = scale.weights.map(f64::from);
                let square: f64 = (0..3).map(|k| weights[k] * rises[k] * rises[k]).sum();
                for k in 0..3 {
                    let exact = match square > 0.0 {
                        true => weights[k] * rises[k] / square.sqrt() * f64::from(WHOLE / 2),
                        false => 0.0,
                    };
                    let found = f64::from(plain.0[k][at]);
                    assert!((found - exact).abs() < 0.51 + 7e-4 * exact.abs(), "{found} {exact}");
                }
            }
        }
    }
}

#[test]
fn sums_are_those_of_all_edges_at_every_level() {
    for lattice in lattices() {
        let of = |place| lattice.normals(Level::Portable, &SCALES[0], place);
        let [own, y0, y1, z0, z1] = [[2, 2], [1, 2], [3, 2], [2, 1], [2, 3]].map(of);
        let normals = || RowNormals {
            own: own.0.each_ref().map(|row| &row[..]),
            low: [&y0.0[1], &z0.0[2]],
            high: [&y1.0[1], &z1.0[2]],
        };
        let rows = lattice.neighbours(2, 2);
        let mut plain = [Outflow::default(); 256];
        for at in STRIP..STRIP + lattice.count {
            let sum = &mut plain[usize::from(rows.own[at])];
            sum.samples += 1;
            let [x, y, z] = &own.0;
            let edges = [
                (0, 1, rows.own[at + 1], x[at] + x[at + 1]),
                (0, -1, rows.own[at - 1], x[at] + x[at - 1]),
                (1, 1, rows.high[0][at], y[at] + y1.0[1][at]),
                (1, -1, rows.low[0][at], y[at] + y0.0[1][at]),
                (2, 1, rows.high[1][at], z[at] + z1.0[2][at]),
                (2, -1, rows.low[1][at], z[at] + z0.0[2][at]),
            ];
            for (axis, side, other, share) in edges {
                let rise = i64::from(other) - i64::from(rows.own[at]);
                sum.crossings += rise.signum();
                sum.rises[axis] += rise;
                sum.shares += side * i64::from(share) * rise.signum().abs();
            }
        }
        let thrice = plain.map(|sum| sum.with(sum).with(sum));
        let together = thrice.map(|sum| Outflow { rises: [sum.rises.iter().sum(), 0, 0], ..sum });
        for &level in Level::available() {
            for (rises_are_apart, expected) in [(true, &thrice), (false, &together)] {
                let mut found = Outflows::new(rises_are_apart);
                for _ in 0..3 {
                    let (is_even, count) = (&own.1[..], lattice.count);
                    let sums = &mut found;
                    run_at(level, Add { sums, rows, normals: normals(), is_even, count });
                }
                assert!(*found.sums() == *expected, "{level}, {} samples", lattice.count);
            }
        }
    }
}

#[test]
fn sums_do_not_run_over() {
    const COUNT: usize = 100_000;
    let strips = COUNT.div_ceil(STRIP);
    fn row<T: Copy>(strips: usize, each: [T; 4]) -> Vec<T> {
        each.repeat(STRIP * (strips + 2) / 4)
    }
    // Every fourth sample is above its neighbours but those below it along y and z, and all of its edges count for all they can.
    let (mut own, high) = (row(strips, [255, 0, 0, 0]), row(strips, [0_u8; 4]));
    own[STRIP - 1] = own[STRIP];
    own[STRIP + COUNT..].fill(0); // as the last one is
    let half = WHOLE / 2;
    let (along_x, along) = (row(strips, [0, half, 0, -half]), row(strips, [half; 4]));
    let rows = Neighbours { own: &own, low: [&own, &own], high: [&high, &high] };
    let normals =
        RowNormals { own: [&along_x, &along, &along], low: [&along; 2], high: [&along; 2] };
    for rises_are_apart in [true, false] {
        let mut found = Outflows::new(rises_are_apart);
        for _ in 0..10 {
            found.add(rows, normals, &vec![false; strips], COUNT);
        }
        let sums = found.sums();
        let count = 250_000;
        assert_eq!([sums[255].samples, sums[0].samples], [count as u64, 3 * count as u64]);
        // The first one of each row has itself beside it.
        assert_eq!(sums[255].shares, 3 * i64::from(WHOLE) * count - 10 * i64::from(half));
        assert!(sums[255].shares > i64::from(i32::MAX), "they would not run over anyway");
        let rises = [-510 * count + 10 * 255, -255 * count, -255 * count];
        let together = [rises.iter().sum(), 0, 0];
        assert_eq!(sums[255].rises, if rises_are_apart { rises } else { together });
    }
}

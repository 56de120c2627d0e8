//! Every set of registers against arrays, operation by operation.

use super::{BATCH, Float, Mask, Task, Wide, run_at};
use crate::Level;

/// What f32 rounds up, down, to even, to 0, to a denormal and to infinity is among them.
const SPECIAL: [f64; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.5,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    5e-324,
    1e-40,
    -1e-45,
    3.402_823_466_385_288_6e38,
    3.402_823_567_797_336_6e38,
    -3.402_823_567_797_336_6e38,
    1.000_000_059_604_644_8,
    1.000_000_178_813_934_3,
    2_147_483_648.0,
    0.1,
    -7e22,
    1.2e-38,
];

const WHOLE: [u32; 7] = [0, 1, 0x7FFF_FFFF, 0x8000_0000, 0x8000_0001, u32::MAX - 1, u32::MAX];

/// Two lists of numbers of either kind, the bits of some places, and where the bits of results go.
struct Every<'a> {
    floats: [[f64; BATCH]; 2],
    whole: [[u32; BATCH]; 2],
    places: u16,
    out: &'a mut Vec<u64>,
}

impl Task for Every<'_> {
    fn run<W: Wide>(self, wide: W) {
        let Self { floats, whole, places, out } = self;
        let (a, b) = (wide.load_f64(&floats[0]), wide.load_f64(&floats[1]));
        let (c, d) = (wide.f64_to_f32(a), wide.f64_to_f32(b));
        let (n, m) = (wide.load(&whole[0]), wide.load(&whole[1]));
        // Which NaN comes out nobody promises.
        let bits = |x: f64| if x.is_nan() { u64::MAX } else { x.to_bits() };
        let (less, below) = (a.less(b), wide.less(n, m));
        for numbers in [
            [a.max(b), a.min(b), a.abs(), a.sqrt(), a + b, a - b],
            [a * b, a / b, wide.f32_to_f64(c), wide.u32_to_f64(n), wide.f64(0.1), a],
            [
                wide.select_f64(below, a, b),
                wide.select_f64(less, a, b),
                wide.i32_to_f64(n),
                a,
                b,
                b,
            ],
        ]
        .as_flattened()
        {
            let mut to = [0.0; BATCH];
            wide.store_f64(*numbers, &mut to);
            out.extend(to.map(bits));
        }
        for numbers in [
            [c, c.max(d), c.min(d), c.abs(), c.sqrt(), c + d],
            [c - d, c * d, c / d, wide.to_unit(c), wide.f32(0.1), d],
            [wide.select_f32(less, c, d), wide.select_f32(below, c, d), c, c, d, d],
        ]
        .as_flattened()
        {
            let mut to = [0.0; BATCH];
            wide.store_f32(*numbers, &mut to);
            out.extend(to.map(|x| bits(x.into())));
        }
        let small = [0.0, 0.999, 1.5, 7.0, 1e6 + 0.75, f64::from(i32::MAX)];
        let small = std::array::from_fn(|i| small[(i + whole[0][0] as usize) % small.len()]);
        out.extend(wide.store(wide.truncate(wide.load_f64(&small))).map(u64::from));
        let short = wide.load_f32(&small.map(|x: f64| x.min(16_777_216.0) as f32));
        let whole_short = wide.truncate_f32(short);
        out.extend(wide.store(whole_short).map(u64::from));
        let mut to = [0.0; BATCH];
        wide.store_f32(wide.u32_to_f32(whole_short), &mut to);
        out.extend(to.map(|x| bits(x.into())));
        let own = wide.mask(places);
        for numbers in [n + m, n * m, wide.select(less, n, m), wide.select(own, n, m)] {
            out.extend(wide.store(numbers).map(u64::from));
        }
        for mask in [less, c.less(d), below, wide.equal(n, m), !less, own, own & less, own | less] {
            out.push(mask.bits().into());
        }
        let (mut narrow, mut places) = ([[0.0; 3]; BATCH], [[0.0; 3]; BATCH]);
        wide.interleave([c, d, c + d], &mut narrow);
        wide.interleave_f64([a, b, a + b], &mut places);
        out.extend(narrow.into_iter().flatten().map(|x| bits(x.into())));
        out.extend(places.into_iter().flatten().map(bits));
    }
}

#[test]
fn every_level_computes_as_arrays_do() {
    for (s, t) in (0..20).flat_map(|s| (0..20).map(move |t| (s, t))) {
        let pick = |k: usize, i: usize| i * (k % 3 + 1) + k;
        let floats = [s, t].map(|k| std::array::from_fn(|i| SPECIAL[pick(k, i) % SPECIAL.len()]));
        let whole = [s, t].map(|k| std::array::from_fn(|i| WHOLE[pick(k, i) % WHOLE.len()]));
        let of = |level| {
            let mut out = vec![];
            let places = (s * 3331 + t * 71) as u16;
            run_at(level, Every { floats, whole, places, out: &mut out });
            out
        };
        for &level in Level::available() {
            assert!(of(level) == of(Level::Portable), "{level}");
        }
    }
}

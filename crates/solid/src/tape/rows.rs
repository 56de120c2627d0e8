//! Values at many lattice points: a step is done for a run of points along x, then the next one.
//!
//! What does not depend on x is made once for a row, what depends on z alone once for a slice, and what depends on x alone
//! once for all rows. So the sines of a gyroid cost next to nothing. Loops over a run are plain; the compiler makes vector
//! instructions of them, which round as plain ones do.

use super::{Binary, Step, Tape, Unary};
use std::ops::Range;

/// Points in a long run, and in a short one for what is left of a row.
const LONG: usize = 32;
const SHORT: usize = 8;

/// The steps of a tape in the order of the loops in which they are made.
#[derive(Debug, Default)]
struct Plan {
    /// Of no axis, of z, of y and maybe z: one number each.
    constant: Vec<u32>,
    of_slice: Vec<u32>,
    of_row: Vec<u32>,
    /// Those of them that runs need.
    spread: [Vec<u32>; 3],
    /// Of x alone, and of x with others: a run each.
    of_x: Vec<u32>,
    of_all: Vec<u32>,
}

impl Plan {
    fn new(steps: &[Step]) -> Self {
        let mut axes: Vec<u8> = Vec::with_capacity(steps.len());
        let mut is_needed = vec![false; steps.len()];
        for step in steps {
            let own = match step {
                Step::Axis(axis) => 1 << axis,
                step => step.needs().fold(0, |all, a| all | axes[a as usize]),
            };
            if own & 1 == 1 {
                step.needs().for_each(|a| is_needed[a as usize] = true);
            }
            axes.push(own);
        }
        if let Some(last) = is_needed.last_mut() {
            *last = true;
        }
        let mut plan = Self::default();
        for (n, own) in axes.into_iter().enumerate() {
            let (list, spread) = match own {
                0 => (&mut plan.constant, Some(0)),
                0b100 => (&mut plan.of_slice, Some(1)),
                0b010 | 0b110 => (&mut plan.of_row, Some(2)),
                0b001 => (&mut plan.of_x, None),
                _ => (&mut plan.of_all, None),
            };
            list.push(n as u32);
            if let Some(level) = spread.filter(|_| is_needed[n]) {
                plan.spread[level].push(n as u32);
            }
        }
        plan
    }
}

impl Tape {
    /// The values at the lattice points of a box, x fastest.
    pub(crate) fn fill(&self, points: [Range<usize>; 3], values: &mut [f64]) {
        let [x, y, z] = points;
        assert_eq!(values.len(), x.len() * y.len() * z.len(), "one value for each point");
        if values.is_empty() {
            return;
        }
        let plan = Plan::new(&self.steps);
        let mut numbers = vec![0.0; self.steps.len()];
        let (mut long, mut short) = (vec![], vec![]);
        let mut done = 0;
        while done < x.len() {
            let (from, left) = (x.start + done, x.len() - done);
            let part = Part { from, at: done, width: x.len(), y: y.clone(), z: z.clone() };
            if left > 2 * SHORT {
                self.fill_part::<LONG>(&plan, &part, &mut numbers, &mut long, values);
                done += LONG;
            } else {
                self.fill_part::<SHORT>(&plan, &part, &mut numbers, &mut short, values);
                done += SHORT;
            }
        }
    }

    fn fill_part<const W: usize>(
        &self,
        plan: &Plan,
        part: &Part,
        numbers: &mut [f64],
        runs: &mut Vec<[f64; W]>,
        values: &mut [f64],
    ) {
        runs.resize(self.steps.len(), [0.0; W]);
        let mut point = [0.0; 3];
        let mut one = |list: &[u32], spread: &[u32], point: [f64; 3], runs: &mut [[f64; W]]| {
            for &n in list {
                numbers[n as usize] = match self.steps[n as usize] {
                    Step::Constant(value) => value,
                    Step::Axis(axis) => point[usize::from(axis)],
                    Step::Unary(code, a) => code.of(numbers[a as usize]),
                    Step::Binary(code, a, b) => code.of(numbers[a as usize], numbers[b as usize]),
                };
            }
            spread.iter().for_each(|&n| runs[n as usize] = [numbers[n as usize]; W]);
        };
        one(&plan.constant, &plan.spread[0], point, runs);
        plan.of_x.iter().for_each(|&n| run(&self.steps, n as usize, part.from, runs));
        let length = W.min(part.width - part.at);
        for k in part.z.clone() {
            point[2] = k as f64;
            one(&plan.of_slice, &plan.spread[1], point, runs);
            for j in part.y.clone() {
                point[1] = j as f64;
                one(&plan.of_row, &plan.spread[2], point, runs);
                plan.of_all.iter().for_each(|&n| run(&self.steps, n as usize, part.from, runs));
                let row = (k - part.z.start) * part.y.len() + (j - part.y.start);
                let made = &runs[self.steps.len() - 1][..length];
                values[row * part.width + part.at..][..length].copy_from_slice(made);
            }
        }
    }
}

/// Runs of points that begin at the same x.
struct Part {
    from: usize,
    /// Where in a row of values, and how long that is.
    at: usize,
    width: usize,
    y: Range<usize>,
    z: Range<usize>,
}

#[inline(always)]
fn map<const W: usize>(out: &mut [f64; W], a: &[f64; W], of: impl Fn(f64) -> f64) {
    for n in 0..W {
        out[n] = of(a[n]);
    }
}

#[inline(always)]
fn zip<const W: usize>(
    out: &mut [f64; W],
    a: &[f64; W],
    b: &[f64; W],
    of: impl Fn(f64, f64) -> f64,
) {
    for n in 0..W {
        out[n] = of(a[n], b[n]);
    }
}

/// Step `n` for a run of points from an x on.
fn run<const W: usize>(steps: &[Step], n: usize, from: usize, runs: &mut [[f64; W]]) {
    let (before, own) = runs.split_at_mut(n);
    let out = &mut own[0];
    // A loop for each function, so that none asks for every point which it is.
    macro_rules! unary {
        ($code:expr, $a:expr, $($name:ident)*) => {
            match $code { $(Unary::$name => map(out, $a, |a| Unary::$name.of(a)),)* }
        };
    }
    macro_rules! binary {
        ($code:expr, $a:expr, $b:expr, $($name:ident)*) => {
            match $code { $(Binary::$name => zip(out, $a, $b, |a, b| Binary::$name.of(a, b)),)* }
        };
    }
    match steps[n] {
        Step::Constant(value) => *out = [value; W],
        Step::Axis(_) => *out = std::array::from_fn(|w| (from + w) as f64),
        Step::Unary(code, a) => {
            let a = &before[a as usize];
            unary!(code, a, Neg Abs Sqrt Square Floor Sin Cos Tan Asin Acos Atan Exp Ln);
        }
        Step::Binary(code, a, b) => {
            let (a, b) = (&before[a as usize], &before[b as usize]);
            binary!(code, a, b, Add Sub Mul Div Min Max Pow Atan2 Signed);
        }
    }
}

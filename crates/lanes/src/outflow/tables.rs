//! Sums of what samples add, by value, in numbers of 32 bits.

use super::{Outflow, STRIP};

/// Tables that take turns, so that samples of one value do not wait for each other.
const TURNS: usize = 4;

/// What samples add by value, in numbers that soon overflow.
type Table<const N: usize> = Box<[[[i32; N]; 256]; TURNS]>;

#[derive(Clone, Debug)]
pub(super) enum Tables {
    /// Shares, crossings, rises along x, y and z, and samples.
    Apart(Table<8>),
    /// Shares, crossings, all rises, and samples.
    Together(Table<4>),
}

impl Tables {
    pub(super) fn new(rises_are_apart: bool) -> Self {
        match rises_are_apart {
            true => Self::Apart(Box::new([[[0; 8]; 256]; TURNS])),
            false => Self::Together(Box::new([[[0; 4]; 256]; TURNS])),
        }
    }

    /// Takes what samples of a value have added.
    pub(super) fn take(&mut self, value: usize) -> [Outflow; TURNS] {
        std::array::from_fn(|turn| match self {
            Self::Apart(table) => {
                let [shares, crossings, x, y, z, samples, ..] = take(&mut table[turn][value]);
                Outflow { samples: samples as u64, crossings, rises: [x, y, z], shares }
            }
            Self::Together(table) => {
                let [shares, crossings, rise, samples] = take(&mut table[turn][value]);
                Outflow { samples: samples as u64, crossings, rises: [rise, 0, 0], shares }
            }
        })
    }
}

fn take<const N: usize>(numbers: &mut [i32; N]) -> [i64; N] {
    std::mem::replace(numbers, [0; N]).map(i64::from)
}

/// Adds what the samples of a strip add, each at its value.
#[inline(always)]
pub(super) fn enter<const N: usize>(
    table: &mut Table<N>,
    values: &[u8],
    of_sample: impl Fn(usize) -> [i16; N],
) {
    let mut entries = [[0; N]; STRIP];
    for (i, entry) in entries.iter_mut().enumerate() {
        *entry = of_sample(i);
    }
    if values.len() == STRIP {
        // Whose turn it is, is known: a tenth of the time of a spectrum (AMD EPYC of 2024, 2026-11).
        let (turns, _) = entries.as_chunks::<TURNS>();
        let (values, _) = values.as_chunks::<TURNS>();
        for (entries, values) in turns.iter().zip(values) {
            for n in 0..TURNS {
                enter_one(&mut table[n][values[n] as usize], &entries[n]);
            }
        }
    } else {
        for (i, &value) in values.iter().enumerate() {
            enter_one(&mut table[i % TURNS][value as usize], &entries[i]);
        }
    }
}

#[inline(always)]
fn enter_one<const N: usize>(sum: &mut [i32; N], entry: &[i16; N]) {
    for i in 0..N {
        sum[i] += i32::from(entry[i]);
    }
}

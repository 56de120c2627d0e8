//! Every loop against the definition, sample by sample.

use super::{
    Lane, Strided, Threshold, Thresholds, many_at, nan::has_nan_at, nans, signs_of_many, words,
};
use crate::Level;
use std::fmt::Debug;

fn by_definition<T: Copy>(row: &[T], holds: impl Fn(T) -> bool) -> Vec<u64> {
    let mut bits = vec![0; words(row.len())];
    for (i, _) in row.iter().enumerate().filter(|&(_, &sample)| holds(sample)) {
        bits[i / 64] |= 1 << (i % 64);
    }
    bits
}

/// `sample` makes samples from chance; few different ones, so that many are equal to a bound.
fn check<T: Lane + Debug>(bounds: &[T], sample: fn(u64) -> T) {
    let mut state = 7_u64;
    let mut next = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        sample(state >> 33)
    };
    for length in 0..=200 {
        // As far into a longer row as makes every alignment occur.
        let row: Vec<T> = (0..length + 64).map(|_| next()).collect();
        let row = &row[length * 7 % 64..][..length];
        let mut found = vec![u64::MAX; words(length)];
        for &bound in bounds {
            for threshold in [Threshold::AtLeast(bound), Threshold::AtMost(bound)] {
                let expected = by_definition(row, |sample| threshold.is_inside(sample));
                let alone = Thresholds::new(&[threshold]).unwrap();
                for &level in Level::available() {
                    found.fill(u64::MAX);
                    many_at(level, row, &alone, Strided { out: &mut found, stride: 0, step: 1 });
                    assert_eq!(found, expected, "{level}, {length} samples, {threshold:?}");
                }
            }
        }
        check_many(row, bounds);
        nans(row, &mut found);
        let nan = |sample: T| sample.partial_cmp(&sample).is_none();
        assert_eq!(found, by_definition(row, nan), "{length} samples");
        for &level in Level::available() {
            let any = row.iter().any(|&sample| nan(sample));
            assert_eq!(has_nan_at(level, row), any, "{level}, {length} samples");
        }
    }
}

/// Rows of every length that begin at every place of a cache line.
#[track_caller]
fn check_places<T: Lane + Debug>(bound: T, sample: fn(u64) -> T) {
    let places = 64 / size_of::<T>();
    let all: Vec<T> = (0..200 + places as u64).map(|n| sample(n * n / 7)).collect();
    let threshold = Threshold::AtLeast(bound);
    let alone = Thresholds::new(&[threshold]).unwrap();
    let mut out = [u64::MAX; 4];
    for (length, first) in (0..=200).flat_map(|length| (0..places).map(move |at| (length, at))) {
        let row = &all[first..][..length];
        let expected = by_definition(row, |sample| threshold.is_inside(sample));
        for &level in Level::available() {
            out.fill(u64::MAX);
            let (found, beyond) = out.split_at_mut(words(length));
            many_at(level, row, &alone, Strided { out: found, stride: 0, step: 1 });
            assert_eq!(found, expected, "{level}, {length} samples from {first}");
            assert!(beyond.iter().all(|&word| word == u64::MAX), "{level}, {length} samples");
        }
    }
}

/// Every first so many bounds at once against each alone.
#[track_caller]
fn check_many<T: Lane + Debug>(row: &[T], bounds: &[T]) {
    for count in 1..=bounds.len() {
        for make in [Threshold::AtLeast, Threshold::AtMost] {
            let each: Vec<_> = bounds[..count].iter().map(|&bound| make(bound)).collect();
            let all = Thresholds::new(&each).unwrap();
            for &level in Level::available() {
                let (own, stride) = (words(row.len()), words(row.len()) + count);
                let mut out = vec![u64::MAX; stride * count];
                many_at(level, row, &all, Strided { out: &mut out, stride, step: 1 });
                for (k, &threshold) in each.iter().enumerate() {
                    let expected = by_definition(row, |sample| threshold.is_inside(sample));
                    let (found, between) = out[k * stride..][..stride].split_at(own);
                    assert!(between.iter().all(|&word| word == u64::MAX));
                    assert_eq!(found, expected, "{level}, {threshold:?} of {count}");
                }
                let mut beside = vec![[u64::MAX; 8]; own];
                let places = beside.as_flattened_mut();
                many_at(level, row, &all, Strided { out: places, stride: 1, step: 8 });
                for (k, plane) in out.chunks_exact(stride).enumerate() {
                    assert!(beside.iter().map(|words| words[k]).eq(plane[..own].iter().copied()));
                }
                let rest = beside.iter().flat_map(|words| &words[count..]);
                assert!(rest.into_iter().all(|&word| word == u64::MAX), "{level}");
            }
        }
    }
}

#[test]
fn thresholds_of_two_directions_or_that_nothing_passes_are_not_asked_at_once() {
    use Threshold::{AtLeast, AtMost, Never};
    let fits = |thresholds: &[Threshold<u8>]| Thresholds::new(thresholds).map(|all| all.count());
    assert_eq!(fits(&[AtLeast(7), AtLeast(3), AtLeast(7)]), Some(3));
    assert_eq!(fits(&[AtMost(7)]), Some(1));
    assert_eq!([fits(&[]), fits(&[AtLeast(7), AtMost(3)]), fits(&[AtLeast(7), Never])], [None; 3]);
}

#[test]
fn every_length_agrees_with_the_definition_wherever_it_begins() {
    check_places(128, |n| (n * 37) as u8);
    check_places(-1, |n| (n * 37) as i8);
    check_places(0x8000, |n| (n * 9001) as u16);
    check_places(0, |n| (n * 9001) as i16);
    check_places(1 << 31, |n| (n * 900_001_937) as u32);
    check_places(0, |n| (n * 900_001_937) as i32);
    check_places(0.0, |n| (n * 37 % 11) as f32 - 5.0);
    check_places(0.0, |n| (n * 37 % 11) as f64 - 5.0);
}

#[test]
fn every_level_agrees_with_the_definition_for_whole_numbers() {
    check(&[0_u8, 1, 127, 128, 254, 255], |r| [0, 1, 127, 128, 129, 255][r as usize % 6]);
    check(&[i8::MIN, -1, 0, 1, i8::MAX], |r| r as i8);
    check(&[0_u16, 0x7FFF, 0x8000, 0xFFFF], |r| [0, 0x7FFF, 0x8000, 0xFFFF][r as usize % 4]);
    check(&[i16::MIN, -1, 0, i16::MAX], |r| [i16::MIN, -1, 0, i16::MAX, -300][r as usize % 5]);
    check(&[0_u32, 1 << 31, u32::MAX], |r| [0, 1, 1 << 31, u32::MAX][r as usize % 4]);
    check(&[i32::MIN, 0, i32::MAX], |r| [i32::MIN, -1, 0, i32::MAX][r as usize % 4]);
}

#[test]
fn every_level_agrees_with_the_definition_for_floats() {
    const ODD: [f64; 8] = [f64::NAN, -0.0, 0.0, 1.0, -1.0, f64::INFINITY, 1e-310, -f64::INFINITY];
    check(&[0.0, -0.0, 1.0, f64::INFINITY, -f64::INFINITY, 1e-310], |r| ODD[r as usize % 8]);
    check(&[0.0_f32, 1e-40, -1.0, f32::MAX], |r| match r % 3 {
        0 => f32::from_bits(r as u32),
        1 => [0.0, -0.0, 1e-40, f32::NAN][r as usize / 3 % 4],
        _ => ODD[r as usize % 8] as f32,
    });
}

#[test]
fn one_nan_is_found_wherever_it_is() {
    for (length, at) in (1..140).flat_map(|length| (0..length).map(move |at| (length, at))) {
        let mut row = vec![f32::INFINITY; length];
        row[at] = f32::NAN;
        assert!(Level::available().iter().all(|&level| has_nan_at(level, &row)), "{at}");
    }
}

#[test]
fn a_tie_is_inside_and_nan_is_not() {
    let word = |threshold| {
        let mut word = [0];
        let threshold = Thresholds::new(&[threshold]).unwrap();
        signs_of_many(&[1.0, f64::NAN, -0.0, 0.0], &threshold, &mut word, 1);
        word[0]
    };
    assert_eq!(word(Threshold::AtLeast(0.0)), 0b1101);
    assert_eq!(word(Threshold::AtMost(0.0)), 0b1100);
}

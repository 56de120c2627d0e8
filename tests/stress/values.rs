//! Values on which extractors break: items 1 to 12 and 25 of the list.

use crate::{bits, check, mesh, options, sampled};
use isokit::{
    marching_cubes::{Boundary, Degenerate, ExtractOptions, Nan},
    volume::{Sample, Volume},
};
use isokit_tests::{
    chance::Chance, fields, modes::modes, oracle::assert_as_defined, reference::Surface,
    volumes::made,
};
use std::fmt::Debug;

#[test]
fn samples_all_on_the_isovalue_are_a_box_closed_and_nothing_open() {
    let flat = made([4, 5, 6], |_| 7_u16);
    assert_eq!((check(&flat, 7.0).components, check(&flat, 7.0).euler), (1, 2));
    let open = ExtractOptions::DEFAULT.with_boundary(Boundary::Open);
    assert!(mesh(&flat, 7.0, &open).triangles.is_empty());
}

#[test]
fn one_sample_on_the_isovalue_is_a_small_octahedron_and_a_point_if_exact() {
    let above = made([3, 3, 3], |ijk| if ijk == [1; 3] { 0.0_f32 } else { 1.0 });
    assert_eq!(check(&above, 0.0), check(&made([3, 3, 3], |_| 1.0), 0.0), "it is inside too");
    let one = made([3, 3, 3], |ijk| if ijk == [1; 3] { 0.0_f32 } else { -1.0 });
    assert_eq!(check(&one, 0.0).triangles, 8);
    let exact = mesh(&one, 0.0, &ExtractOptions::DEFAULT.with_degenerate(Degenerate::Exact));
    assert!(exact.positions.iter().all(|position| position == [1.0; 3]));
}

#[test]
fn a_checkerboard_cuts_every_edge() {
    let points = 9;
    let board =
        made([points; 3], |[i, j, k]| if (i + j + k).is_multiple_of(2) { 1_i8 } else { -1 });
    check(&board, 0.0);
    let open = mesh(&board, 0.0, &ExtractOptions::DEFAULT.with_boundary(Boundary::Open));
    assert_eq!(open.positions.len() as u64, 3 * points * points * (points - 1));
    assert_eq!(open.triangles.len() as u64, 4 * (points - 1).pow(3));
}

/// Everything that must hold, of the same small whole numbers in another type; and the same bytes.
#[track_caller]
fn check_in<T: Sample + TryFrom<i8, Error: Debug>>(numbers: &Volume<i8>, iso: f64) {
    let samples = numbers.samples().iter().map(|&number| T::try_from(number).unwrap());
    let volume = Volume::new(*numbers.grid(), samples.collect()).unwrap();
    check(&volume, iso);
    for options in modes() {
        let [expected, found] = [mesh(numbers, iso, &options), mesh(&volume, iso, &options)];
        assert!(bits(&found) == bits(&expected), "{:?}, {options:?}", T::DTYPE);
    }
}

#[test]
fn the_same_numbers_in_any_type_are_the_same_bytes() {
    let mut chance = Chance::new(7);
    let volumes: [(Volume<i8>, &[f64]); 4] = [
        (made([3, 4, 5], |_| 7), &[7.0]),
        (made([5; 3], |[i, j, k]| (i + j + k) as i8 % 2), &[1.0]),
        (made([7; 3], |_| chance.below(7) as i8), &[2.0, 2.5]),
        (made([9, 8, 7], |_| chance.below(128) as i8), &[64.0]),
    ];
    for (volume, isos) in &volumes {
        for &iso in *isos {
            check(volume, iso);
            check_in::<u8>(volume, iso);
            check_in::<i16>(volume, iso);
            check_in::<u16>(volume, iso);
            check_in::<i32>(volume, iso);
            check_in::<u32>(volume, iso);
            check_in::<f32>(volume, iso);
            check_in::<f64>(volume, iso);
        }
    }
}

/// The thousands are in `tests/ties.rs`.
#[test]
fn small_whole_numbers() {
    for seed in 0..20 {
        let mut chance = Chance::new(seed);
        check(&made([7; 3], |_| chance.below(7) as i8 - 3), 0.0);
    }
}

#[test]
fn bytes_by_chance_between_two_and_on_one() {
    let mut chance = Chance::new(1);
    let noise = made([14, 13, 12], |_| chance.bits() as u8);
    assert_ne!(check(&noise, 127.5), check(&noise, 128.5));
    assert_eq!(check(&noise, 127.5), check(&noise, 128.0), "no byte is between");
}

#[test]
fn isovalues_at_and_beyond_the_ends_of_the_range() {
    let mut chance = Chance::new(2);
    let noise = made([6, 5, 7], |_| chance.below(9) as i32 - 4);
    let all = check(&noise, -4.0);
    assert_eq!(all, check(&noise, -5.0));
    assert_eq!((all.components, all.euler), (1, 2));
    assert!(check(&noise, 4.0).components > 1);
    assert_eq!(check(&noise, 5.0), Surface::default());
}

#[test]
fn minus_zero_is_zero() {
    let with = |zero: f32| made([3, 3, 3], move |ijk| if ijk == [1; 3] { zero } else { -1.0 });
    for iso in [0.0, -0.0] {
        let options = ExtractOptions::DEFAULT;
        assert_eq!(mesh(&with(0.0), iso, &options), mesh(&with(-0.0), iso, &options));
        assert_eq!(check(&with(-0.0), iso).triangles, 8);
    }
}

#[test]
fn the_greatest_and_the_least_number_side_by_side() {
    let board = |ijk: [u64; 3]| (ijk[0] + ijk[1] / 2 + ijk[2]).is_multiple_of(2);
    check(&made([6, 6, 6], |ijk| if board(ijk) { i32::MAX } else { i32::MIN }), 0.0);
    check(&made([6, 6, 6], |ijk| if board(ijk) { f32::MAX } else { f32::MIN }), 0.0);
    check(&made([6, 6, 6], |ijk| if board(ijk) { f32::MAX } else { f32::MIN }), -3e38);
    check(&made([6, 6, 6], |ijk| if board(ijk) { f64::MAX } else { f64::MIN }), 1e308);
}

#[test]
fn the_smallest_numbers_there_are() {
    let mut chance = Chance::new(3);
    let denormal = |chance: &mut Chance| f32::from_bits(chance.below(4) as u32);
    let volume = made([7, 7, 7], |_| denormal(&mut chance));
    assert!(check(&volume, 1e-45).components > 0);
    assert_eq!(check(&volume, 1e-45), check(&volume, f64::from(f32::from_bits(1))));
    assert!(check(&made([7, 7, 7], |_| f64::from_bits(chance.below(4))), 5e-324).components > 0);
}

#[test]
fn a_little_noise_on_a_large_number() {
    let mut chance = Chance::new(4);
    let volume = made([9, 9, 9], |_| (1e6 + chance.unit()) as f32);
    check(&volume, 1_000_000.5);
    check(&volume, 1_000_000.49);
}

#[test]
fn a_field_times_a_power_of_two_gives_the_same_bytes() {
    let gyroid = sampled(&fields::gyroid(1.5), 17);
    let scaled = |power: i32| {
        made([17; 3], |ijk| gyroid.view().value(ijk.map(|i| i as usize)) * 2_f64.powi(power))
    };
    for options in options() {
        let expected = mesh(&gyroid, 0.125, &options);
        for power in [-100, 100] {
            let found = mesh(&scaled(power), 0.125 * 2_f64.powi(power), &options);
            assert_eq!(found, expected, "times 2 to the {power}");
        }
    }
}

#[test]
fn tiny_and_huge_fields() {
    let gyroid = sampled(&fields::gyroid(1.5), 13);
    for factor in [1e-30, 1e30] {
        let at = |ijk: [u64; 3]| (gyroid.view().value(ijk.map(|i| i as usize)) * factor) as f32;
        let scaled = check(&made([13; 3], at), 0.125 * factor);
        assert_eq!(scaled, check(&gyroid, 0.125), "times {factor:e}");
    }
}

#[test]
fn samples_without_a_value() {
    let sphere = fields::sphere(0.7);
    let at = |ijk: [u64; 3]| sphere(ijk.map(|i| i as f64 / 6.0 - 1.0)) as f32;
    let mut chance = Chance::new(5);
    let holes: [Volume<f32>; 4] = [
        made([13; 3], |ijk| if ijk == [6, 6, 2] { f32::NAN } else { at(ijk) }),
        made([13; 3], |ijk| if ijk[2] == 5 { f32::NAN } else { at(ijk) }),
        made([13; 3], |ijk| if chance.below(2) == 0 { f32::NAN } else { at(ijk) }),
        made([13; 3], |_| f32::NAN),
    ];
    for volume in &holes {
        check(volume, 0.0);
        for options in options() {
            assert_as_defined(&volume.view(), 0.0, &options.with_nan(Nan::Mask));
        }
    }
    assert_eq!(check(&holes[1], 0.0).components, 2, "a slice without values cuts the ball in two");
    assert_eq!(check(&holes[3], 0.0), Surface::default());
}

#[test]
fn infinite_samples() {
    let infinite = [f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0, 1.0];
    let mut chance = Chance::new(6);
    check(&made([8; 3], |_| infinite[chance.below(5) as usize]), 0.0);
    check(&made([8; 3], |_| f64::from(infinite[chance.below(2) as usize])), 1.5);
}

#[test]
fn any_bits_at_all() {
    for seed in 0..20 {
        let mut chance = Chance::new(seed);
        check(&made([7, 6, 5], |_| f32::from_bits(chance.bits() as u32)), 0.0);
        let iso = f64::from(f32::from_bits(chance.bits() as u32));
        let volume = made([5, 6, 7], |_| f64::from_bits(chance.bits()));
        check(&volume, if iso.is_finite() { iso } else { 1.0 });
    }
}

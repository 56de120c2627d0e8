//! What is between samples.

use super::{PLAIN, medium, opacities, picture, size, volume};
use crate::{
    Camera, Image, Kernel, OpticalModel, Projection, RaycastOptions, TransferFunction, raycast,
};
use isokit_job::{Job, Threads};
use isokit_volume::{Bricks, Volume};
use std::num::NonZeroUsize;

const CUBIC: RaycastOptions = PLAIN.with_kernel(Kernel::CatmullRom);

fn camera(middle: f64) -> Camera {
    let parallel = Projection::Parallel { height: 1.5 * middle };
    Camera::new([-20.0, -9.0, 31.0], [middle; 3], [0.0, 1.0, 0.0], parallel).unwrap()
}

/// A function with waves 7 to 9 long, at samples so far from each other, in a cube 12 long.
fn waves(spacing: f64) -> Volume<f32> {
    volume([(12.0 / spacing) as u64 + 1; 3], spacing, |ijk| {
        let [x, y, z] = ijk.map(|c| c * spacing);
        (60.0 + 40.0 * (0.9 * x).sin() * (0.8 * y + 0.3).sin() * (0.7 * z).cos()) as f32
    })
}

fn root_mean_square(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels().iter().zip(b.pixels());
    let sum: f64 = pairs.map(|(a, b)| f64::from(a.differs(*b)).powi(2)).sum();
    (sum / a.pixels().len() as f64).sqrt()
}

#[test]
fn cubics_come_near_to_what_many_more_samples_show() {
    let model = opacities([0.0, 120.0], |v| 0.4 * ((v - 55.0) / 45.0).clamp(0.0, 1.0).powi(2));
    for light in [None, RaycastOptions::DEFAULT.light] {
        let options = |kernel, spacing: f64| {
            let options = PLAIN.with_light(light).with_kernel(kernel);
            options.with_step(0.1 / spacing).with_unit(Some(1.0))
        };
        let view = (&camera(6.0), 30);
        let exact = picture(&waves(0.125), &model, view, &options(Kernel::Linear, 0.125)).0;
        let off = |kernel, spacing| {
            let image = picture(&waves(spacing), &model, view, &options(kernel, spacing)).0;
            root_mean_square(&image, &exact)
        };
        let [linear, cubic] = [Kernel::Linear, Kernel::CatmullRom].map(|kernel| off(kernel, 1.0));
        assert!(cubic < 0.3 * linear, "{cubic} for {linear}");
        assert!(off(Kernel::CatmullRom, 0.5) < 0.25 * cubic, "{cubic}");
    }
}

/// Samples of 0 and 100 by chance, with much that is even, and NaN where that is wanted.
fn rocks(has_holes: bool) -> Volume<f32> {
    let mut state = 7_u64;
    let rocks: Vec<bool> = (0..30 * 20 * 90)
        .map(|n| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let seldom = if n / 600 % 90 < 40 { 400 } else { 3 };
            state >> 40 & 0xffff < 65536 / seldom
        })
        .collect();
    volume([30, 20, 90], 1.0, |[x, y, z]| {
        let n = x as usize + 30 * (y as usize + 20 * z as usize);
        match (has_holes && n.is_multiple_of(97), rocks[n]) {
            (true, _) => f32::NAN,
            (_, true) => 100.0,
            _ => 0.0,
        }
    })
}

/// Shows what is beyond all samples, and nothing else.
fn beyond() -> OpticalModel {
    let peak = |value| crate::Peak { value, width: 8.0, color: [0.5; 3], opacity: 0.5 };
    TransferFunction::of_peaks(&[peak(-12.0), peak(112.0)]).unwrap().into()
}

#[test]
fn cubics_beyond_all_samples_are_the_same_with_bricks_and_for_any_threads() {
    for has_holes in [false, true] {
        let (rocks, model) = (rocks(has_holes), beyond());
        let view = rocks.view();
        let bricks = Bricks::of(&view, &Job::default()).unwrap();
        let lit = CUBIC.with_light(RaycastOptions::DEFAULT.light);
        for options in [CUBIC, lit.with_jitter(true), lit.with_step(7.0).with_integrated(true)] {
            let camera = (&camera(20.0), size(40));
            let plain = raycast(&medium(&view, &model), camera, &options, &Job::default());
            let plain = plain.unwrap().0;
            assert!(plain.pixels().iter().any(|pixel| pixel.opacity > 0.1), "nothing is seen");
            for threads in [1, 2, 7] {
                let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
                let job = Job { threads, ..Job::default() };
                let medium = crate::Medium { bricks: Some(&bricks), ..medium(&view, &model) };
                let (found, cast) = raycast(&medium, camera, &options, &job).unwrap();
                assert!(found == plain, "{options:?}");
                assert!(cast.steps_leapt > 0, "{cast:?}");
            }
        }
    }
}

#[test]
fn where_a_sample_is_missing_it_is_linear_between_those_that_are_there() {
    let slab = volume([9, 9, 21], 1.0, |[.., z]| if z == 10.0 { f32::NAN } else { 60.0 });
    let model = opacities([0.0, 100.0], |_| 0.1);
    let bounds = slab.grid().bounds();
    let camera = Camera::framing(bounds, ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]), None, 1.0).unwrap();
    let [linear, cubic] =
        [PLAIN, CUBIC].map(|options| picture(&slab, &model, (&camera, 9), &options).0);
    assert!(cubic == linear && cubic.pixel(4, 4).opacity > 0.8);
}

//! With bricks and without them a picture is the same, bit for bit.

use super::{PLAIN, blobs, cameras, glow, medium, picture, size, volume};
use crate::{
    Camera, Cast, ControlPoint, Image, Medium, OpticalModel, Projection, RaycastOptions, Raycaster,
    TransferFunction, raycast,
};
use isokit_job::Job;
use isokit_volume::{Bricks, Sample, Scaling, Volume};

/// The picture with bricks.
fn with<T: Sample>(
    bricks: &Bricks<T>,
    volume: &Volume<T>,
    model: &OpticalModel,
    (camera, n): (&Camera, u32),
    options: &RaycastOptions,
) -> (Image, Cast) {
    let view = volume.view();
    let medium = Medium { bricks: Some(bricks), ..medium(&view, model) };
    raycast(&medium, (camera, size(n)), options, &Job::default()).unwrap()
}

#[test]
fn leaps_over_what_cannot_be_seen_change_no_bit() {
    let volume = blobs();
    let bricks = Bricks::of(&volume.view(), &Job::default()).unwrap();
    for camera in cameras(&volume) {
        let grained = PLAIN.with_step(0.7).with_jitter(true);
        let integrated = RaycastOptions::DEFAULT.with_step(1.7).with_integrated(true);
        let fine = PLAIN.with_integrated(true).with_jitter(true);
        let middles = [PLAIN, RaycastOptions::DEFAULT, PLAIN.with_step(0.13), grained];
        for options in middles.into_iter().chain([integrated, fine]) {
            let (plain, walked) = picture(&volume, &glow(), (&camera, 60), &options);
            let (leapt, cast) = with(&bricks, &volume, &glow(), (&camera, 60), &options);
            assert!(leapt == plain);
            assert_eq!(
                cast.steps + cast.steps_leapt + cast.steps_hidden,
                walked.steps + walked.steps_hidden
            );
            assert!(cast.steps_leapt > cast.steps, "{cast:?}");
            assert!(plain.pixels().iter().any(|pixel| pixel.opacity > 0.5), "nothing is seen");
        }
    }
}

#[test]
fn long_integrated_steps_see_what_lies_bricks_away() {
    let wall = volume([12, 12, 70], 1.0, |[.., z]| if z > 40.0 { 100.0_f32 } else { 0.0 });
    let bricks = Bricks::of(&wall.view(), &Job::default()).unwrap();
    let points = [(0.0, 0.0), (50.0, 0.0), (100.0, 0.02)];
    let point = |(value, opacity)| ControlPoint { value, color: [1.0; 3], opacity };
    let model = TransferFunction::new(points.map(point).into()).unwrap().into();
    for n in 0..40 {
        let (from, at) = ([5.5, 5.5, -10.0 - 0.9 * f64::from(n)], [5.5, 5.5, 35.0]);
        let parallel = Projection::Parallel { height: 10.0 };
        let camera = Camera::new(from, at, [0.0, 1.0, 0.0], parallel).unwrap();
        for step in [18.0, 24.0, 31.0] {
            let options = PLAIN.with_step(step).with_integrated(true).with_jitter(n > 0);
            let plain = picture(&wall, &model, (&camera, 4 + n), &options).0;
            assert!(with(&bricks, &wall, &model, (&camera, 4 + n), &options).0 == plain, "{step}");
        }
    }
}

#[test]
fn what_is_made_ready_once_serves_all_cameras() {
    let volume = blobs();
    let (view, model, job) = (volume.view(), glow(), Job::default());
    let bricks = Bricks::of(&view, &job).unwrap();
    let medium = Medium { bricks: Some(&bricks), ..medium(&view, &model) };
    let options = RaycastOptions::DEFAULT.with_error(Some(0.01));
    let caster = Raycaster::new(&medium, &options, &job).unwrap();
    for camera in cameras(&volume) {
        let camera = (&camera, size(30));
        assert!(
            caster.picture(camera, &job) == Ok(raycast(&medium, camera, &options, &job).unwrap())
        );
    }
}

#[test]
fn bricks_of_another_volume_are_left_aside() {
    let (volume, other) = (blobs(), volume([9, 9, 9], 1.0, |_| 0_u8));
    let bricks = Bricks::of(&other.view(), &Job::default()).unwrap();
    let camera = &cameras(&volume)[1];
    let (expected, _) = picture(&volume, &glow(), (camera, 20), &PLAIN);
    let found = with(&bricks, &volume, &glow(), (camera, 20), &PLAIN);
    assert!(found.0 == expected && found.1.steps_leapt == 0);
}

#[test]
fn bricks_change_no_bit_whatever_samples_mean() {
    // Values far below those that are seen, in one brick with them; and a function that begins just above a brick's
    // greatest value.
    let filled = volume([150, 20, 20], 1.0, |[x, y, z]| {
        let wave = (0.3 * x).sin() + (0.4 * y).cos() * (0.5 * z).sin();
        if (x as u32 / 9).is_multiple_of(3) { -32768.0 } else { wave as f32 * 0.3 }
    });
    for (slope, intercept) in [(1.0, 0.0), (-0.1, 3.0), (0.1, -3276.8), (2.0, 1e4)] {
        let scaling = Scaling::new(slope, intercept).unwrap();
        let volume = filled.clone().with_scaling(scaling);
        let bricks = Bricks::of(&volume.view(), &Job::default()).unwrap();
        let value = |stored: f64| scaling.value(stored);
        let mut ends = [value(0.2), value(0.4), value(0.5)];
        ends.sort_by(f64::total_cmp);
        let points = ends.iter().zip([0.0, 0.3, 0.0]);
        let points =
            points.map(|(&value, opacity)| ControlPoint { value, color: [1.0; 3], opacity });
        let model = TransferFunction::new(points.collect()).unwrap().into();
        let camera = cameras(&blobs()).remove(1);
        let plain = picture(&volume, &model, (&camera, 40), &RaycastOptions::DEFAULT).0;
        let options = RaycastOptions::DEFAULT;
        let found = with(&bricks, &volume, &model, (&camera, 40), &options);
        assert!(found.0 == plain, "{slope}, {intercept}");
        assert!(plain.pixels().iter().any(|pixel| pixel.opacity > 0.1), "{slope}: nothing is seen");
    }
}

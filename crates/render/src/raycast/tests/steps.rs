//! Steps of other lengths, and light on the way.

use super::{PLAIN, blobs, cameras, opacities, picture, volume};
use crate::{Camera, Image, Projection, Scatter};

#[test]
fn rays_that_begin_anywhere_gather_the_same_of_one_substance() {
    let slab = volume([20, 20, 9], 1.5, |_| 7_u8);
    let model = opacities([0.0, 10.0], |_| 0.2);
    let (from, at) = ([14.0, 14.0, -9.0], [14.0, 14.0, 0.0]);
    let parallel = Projection::Parallel { height: 20.0 };
    let camera = Camera::new(from, at, [0.0, 1.0, 0.0], parallel).unwrap();
    for step in [0.3, 1.0, 7.0, 50.0] {
        let options = PLAIN.with_step(step).with_unit(Some(2.0)).with_jitter(true);
        let exact = 1.0 - 0.8_f32.powf(6.0);
        for pixel in picture(&slab, &model, (&camera, 16), &options).0.pixels() {
            assert!((pixel.opacity - exact).abs() < 2e-6, "{step}: {pixel:?} for {exact}");
        }
    }
    let ramp = volume([20, 20, 9], 1.5, |[_, _, z]| z as f32);
    let model = opacities([0.0, 8.0], |value| 0.05 * value);
    let of = |jitter| {
        let options = PLAIN.with_step(2.0).with_jitter(jitter);
        picture(&ramp, &model, (&camera, 16), &options).0
    };
    assert!(of(false).pixels().iter().all(|pixel| *pixel == of(false).pixel(0, 0)));
    let grains = of(true);
    let mean = grains.pixels().iter().map(|pixel| pixel.opacity).sum::<f32>() / 256.0;
    assert!(grains.pixel(0, 0) != grains.pixel(1, 0));
    assert!((mean - of(false).pixel(0, 0).opacity).abs() < 0.01);
}

#[test]
fn pixels_are_cast_again_until_no_more_differs_than_the_error() {
    let (ball, cameras) = (blobs(), cameras(&blobs()));
    let model = opacities([0.0, 200.0], |value| 0.4 * (value / 200.0).powi(2));
    let camera = &cameras[1];
    let exact = picture(&ball, &model, (camera, 40), &PLAIN.with_step(0.004)).0;
    let worst = |image: &Image| {
        let pairs = image.pixels().iter().zip(exact.pixels());
        pairs.map(|(a, b)| a.differs(*b)).fold(0.0, f32::max)
    };
    let coarse = picture(&ball, &model, (camera, 40), &PLAIN.with_step(2.0));
    let mut before = coarse.1.steps;
    for error in [0.001, 0.0003] {
        let options = PLAIN.with_step(2.0).with_error(Some(error));
        let (image, cast) = picture(&ball, &model, (camera, 40), &options);
        assert!(worst(&image) <= error, "{error}: {}", worst(&image));
        assert!(worst(&coarse.0) > error, "{error}: {}", worst(&coarse.0));
        assert!(cast.steps > before && cast.pixels_refined >= 1600, "{cast:?}");
        before = cast.steps;
        let fine = picture(&ball, &model, (camera, 40), &PLAIN.with_step(2.0 / 64.0)).1;
        assert!(cast.steps * 2 < fine.steps, "{cast:?}, {fine:?}");
    }
}

#[test]
fn scattered_light_leaves_what_lies_in_shadow_dark() {
    let fog = volume([24, 24, 24], 1.0, |_| 1_u8);
    let model = opacities([0.0, 10.0], |_| 0.15);
    let (from, at) = ([11.5, 11.5, -20.0], [11.5; 3]);
    let parallel = Projection::Parallel { height: 20.0 };
    let camera = Camera::new(from, at, [0.0, 1.0, 0.0], parallel).unwrap();
    let scatter = Scatter { from: [0.0, 1.0, 0.0], strength: 1.0, ambient: 0.1, ahead: 0.0 };
    let lit = picture(&fog, &model, (&camera, 20), &PLAIN.with_scatter(Some(scatter))).0;
    let plain = picture(&fog, &model, (&camera, 20), &PLAIN).0;
    // Light comes from above: by the way that it has come the fog is darker.
    for row in 0..20 {
        let [found, whole] = [&lit, &plain].map(|image| f64::from(image.pixel(10, row).color[0]));
        let share = 0.1 + 0.85_f64.powf(2.0 + f64::from(row));
        assert!((found / whole - share).abs() < 0.01, "{row}: {} for {share}", found / whole);
    }
}

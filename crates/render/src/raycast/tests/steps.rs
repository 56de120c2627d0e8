//! Steps of other lengths, and light on the way.

use super::{PLAIN, blobs, cameras, medium, opacities, picture, size, through, volume};
use crate::{
    Camera, ControlPoint, Image, Material, Mixture, OpticalModel, Projection, RaycastOptions,
    Scatter, SlopeFunction, TransferFunction, splat,
};
use isokit_geom::{Affine, Frame};
use isokit_job::Job;
use isokit_volume::{Grid, Volume};

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
fn steps_that_are_integrated_are_exact_where_values_change_evenly_along_them() {
    let ramp = volume([20, 20, 9], 1.5, |[_, _, z]| z as f32);
    let (from, at) = ([14.0, 14.0, -9.0], [14.0, 14.0, 0.0]);
    let parallel = Projection::Parallel { height: 20.0 };
    let camera = Camera::new(from, at, [0.0, 1.0, 0.0], parallel).unwrap();
    // A step, and a peak that is narrower than any step.
    let opacity = |value: f64| match value {
        3.0..5.0 => 0.1,
        6.0..6.01 => 0.6,
        _ => 0.0,
    };
    let points = [2.99999, 3.0, 4.99999, 5.0, 5.99999, 6.0, 6.00999, 6.01];
    let points = points.map(|value| ControlPoint {
        value,
        color: [value as f32 / 10.0; 3],
        opacity: opacity(value) as f32,
    });
    let model = TransferFunction::new(points.into()).unwrap().into();
    // Over a length of 1.5 for each value.
    let exact = 1.0 - 0.9_f64.powf(2.0) * 0.4_f64.powf(0.01);
    for step in [0.4, 1.0, 2.5, 20.0] {
        let options = PLAIN.with_step(step).with_integrated(true);
        for pixel in picture(&ramp, &model, (&camera, 4), &options).0.pixels() {
            assert!(
                (f64::from(pixel.opacity) - exact).abs() < 1e-5,
                "{step}: {pixel:?} for {exact}"
            );
        }
    }
    let middle = picture(&ramp, &model, (&camera, 4), &PLAIN.with_step(2.5)).0.pixel(0, 0);
    assert!((f64::from(middle.opacity) - exact).abs() > 1e-2, "{middle:?}");
}

#[test]
fn integrated_steps_come_near_to_short_ones_with_fewer_of_them() {
    let (ball, cameras) = (blobs(), cameras(&blobs()));
    let peak = opacities([80.0, 90.0], |value| 0.4 - 0.08 * (value - 85.0).abs());
    for light in [None, RaycastOptions::DEFAULT.light] {
        let lit = PLAIN.with_light(light);
        let exact = picture(&ball, &peak, (&cameras[1], 40), &lit.with_step(0.01)).0;
        let off = |options: &RaycastOptions| {
            let image = picture(&ball, &peak, (&cameras[1], 40), options).0;
            let pairs = image.pixels().iter().zip(exact.pixels());
            pairs.map(|(a, b)| f64::from(a.differs(*b)).powi(2)).sum::<f64>().sqrt()
        };
        let (middle, integrated) = (lit.with_step(1.0), lit.with_step(1.0).with_integrated(true));
        let [middle, integrated] = [off(&middle), off(&integrated)];
        assert!(integrated < 0.25 * middle, "{integrated} for {middle}");
    }
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

#[test]
fn integrated_steps_scatter_what_light_comes_to_them() {
    let fog = volume([24, 24, 24], 1.0, |_| 1_u8);
    let model = opacities([0.0, 10.0], |_| 0.15);
    let camera = &cameras(&fog)[1];
    let scatter = Scatter { from: [0.3, 1.0, 0.0], strength: 1.0, ambient: 0.1, ahead: 0.0 };
    let middle = PLAIN.with_scatter(Some(scatter));
    let [middle, integrated] = [middle, middle.with_integrated(true)]
        .map(|options| picture(&fog, &model, (camera, 30), &options).0);
    let plain = picture(&fog, &model, (camera, 30), &PLAIN).0;
    let mut darker = 0;
    for ((middle, integrated), plain) in
        middle.pixels().iter().zip(integrated.pixels()).zip(plain.pixels())
    {
        assert!(middle.differs(*integrated) < 1e-5, "{middle:?}, {integrated:?}");
        darker += usize::from(integrated.color[0] < 0.7 * plain.color[0]);
    }
    assert!(darker > 100, "{darker}");
}

#[test]
fn integrated_steps_that_end_where_no_number_is_show_nothing() {
    let slab = volume([5, 5, 21], 1.0, |[.., z]| if z == 10.0 { f32::NAN } else { 60.0 });
    let model = opacities([0.0, 100.0], |_| 0.1);
    let camera =
        Camera::framing(slab.grid().bounds(), ([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]), None, 1.0)
            .unwrap();
    let options = PLAIN.with_step(0.5).with_integrated(true);
    let found = picture(&slab, &model, (&camera, 9), &options).0.pixel(4, 4);
    // Values are between numbers alone below 9 and from 11 to 20: the step that ends at 9 has none there.
    let expected = 1.0 - 0.9_f32.powf(8.5 + 9.0);
    assert!((found.opacity - expected).abs() < 1e-5, "{found:?} for {expected}");
}

#[test]
fn steps_are_halved_no_more_often_than_there_may_be_steps() {
    let ramp = volume([2; 3], 1.0, |[_, _, z]| z as f32);
    let model = opacities([0.0, 1.0], |value| 0.5 + 0.3 * value * value);
    let shown = |options| through(&ramp, &model, &options);
    // Half of that is too short, and no error is small enough.
    let options = PLAIN.with_step(8e-6);
    assert_eq!(shown(options.with_error(Some(0.0))), shown(options));
    assert!(shown(options)[1] > 0.4);
}

#[test]
fn pictures_are_alike_whatever_the_unit_of_the_world() {
    let hill: Vec<_> = [(0.0, 0.0), (90.0, 0.1), (255.0, 0.5)]
        .map(|(value, opacity)| ControlPoint { value, color: [0.9, 0.5, 0.2], opacity })
        .into();
    let hill = TransferFunction::new(hill).unwrap();
    let material =
        |values, opacity, density| Material { values, color: [0.8; 3], opacity, density };
    let materials = vec![material([0.0, 40.0], 0.0, 0.0), material([160.0, 255.0], 0.1, 1.0)];
    let of = |factor: f64| {
        let grid = *blobs().grid();
        let index_to_world = Affine::axis_aligned([factor; 3], [0.0; 3]).unwrap();
        let grid = Grid::new(grid.dims(), Frame { index_to_world, ..Frame::default() }).unwrap();
        let samples = blobs().samples().to_vec();
        let volume = Volume::new(grid, samples).unwrap();
        let towards = ([0.3, 1.0, -0.4], [0.0, 0.0, 1.0]);
        let camera = Camera::framing(grid.bounds(), towards, Some(30.0), 1.0).unwrap();
        let fading = SlopeFunction::fading(hill.clone(), 30.0 / factor).unwrap();
        let models = [fading.into(), Mixture::new(materials.clone(), 0.6).unwrap().into()];
        models.map(|model: OpticalModel| {
            let light = RaycastOptions::DEFAULT.with_scatter(Some(Scatter {
                from: [1.0, 0.0, 1.0],
                strength: 0.5,
                ambient: 0.5,
                ahead: 0.2,
            }));
            let view = volume.view();
            let (medium, job) = (medium(&view, &model), Job::default());
            let splats = splat(&medium, (&camera, size(40)), &light, &job).unwrap().0;
            [picture(&volume, &model, (&camera, 40), &light).0, splats]
        })
    };
    let plain = of(1.0);
    assert!(plain.as_flattened().iter().all(|i| i.pixels().iter().any(|p| p.opacity > 0.3)));
    for factor in [2.0_f64.powi(200), 2.0_f64.powi(-200)] {
        for (found, plain) in of(factor).as_flattened().iter().zip(plain.as_flattened()) {
            let pairs = found.pixels().iter().zip(plain.pixels());
            let most = pairs.map(|(a, b)| a.differs(*b)).fold(0.0, f32::max);
            assert!(most < 1e-5, "{factor}: {most}");
        }
    }
}

//! Lookups against the models that they are of.

use super::{Lookup, PARTS, SEEN};
use crate::{
    ControlPoint, Gathered, Material, Mixture, OpticalModel, SlopeFunction, TransferFunction,
};

fn function(points: &[(f64, f32, f32)]) -> TransferFunction {
    let point = |&(value, shade, opacity): &(f64, f32, f32)| ControlPoint {
        value,
        color: [shade, 0.5 * shade, 0.0],
        opacity,
    };
    TransferFunction::new(points.iter().map(point).collect()).unwrap()
}

fn look(lookup: &Lookup<'_>, value: f32, slope: f32) -> Gathered {
    let (part, share) = lookup.part(value);
    lookup.gathered(super::Place { part, share, value, slope: slope.into() }, None)
}

/// By how much the parts of two colours differ at most.
fn off(a: Gathered, b: Gathered) -> f32 {
    let pairs = a.color.into_iter().chain([a.opacity]).zip(b.color.into_iter().chain([b.opacity]));
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn a_lookup_is_the_function_but_for_rounding() {
    for (factor, shift) in [(1.0, 0.0), (1e-6, 0.0), (1e30, -1e30), (1.0, 1e3)] {
        let place = |value: f64| value * factor + shift;
        let hill: OpticalModel =
            function(&[(place(0.0), 0.0, 0.0), (place(10.0), 1.0, 0.8), (place(30.0), 0.5, 0.0)])
                .into();
        let lookup = Lookup::new(&hill, 0.5, 1.0);
        for n in 0..1000 {
            let value = place(-5.0 + 45.0 * f64::from(n) / 999.0);
            let found = look(&lookup, value as f32, 0.0);
            let exact = hill.at(value);
            let expected = 1.0 - (1.0 - exact.opacity).sqrt();
            // Next to a point of the function a part has two slopes.
            let off = 3e-4;
            assert!((found.opacity - expected).abs() <= off, "{value}: {found:?}");
            assert!((found.color[0] - exact.color[0] * expected).abs() <= 2.0 * off, "{value}");
        }
    }
}

#[test]
fn a_lookup_keeps_steps_to_the_value_and_peaks_however_narrow() {
    let of = |points: &[(f64, f32)]| {
        let points: Vec<_> = points.iter().map(|&(value, opacity)| (value, 1.0, opacity)).collect();
        OpticalModel::from(function(&points))
    };
    for model in [
        of(&[(100.0, 0.0), (100.0, 0.5)]),
        of(&[(0.0, 0.2), (0.0, 0.0), (255.0, 0.0), (255.0, 0.7)]),
        of(&[(0.0, 0.1), (128.0, 0.1), (128.0, 0.9), (255.0, 0.9)]),
        of(&[(0.0, 0.0), (63.995, 0.0), (64.0, 0.8), (64.005, 0.0), (255.0, 0.0)]),
    ] {
        let lookup = Lookup::new(&model, 1.0, 1.0);
        for value in (-1..=256).flat_map(|n| [n as f32, (n as f32).next_down(), n as f32 + 0.5]) {
            let (found, exact) =
                (look(&lookup, value, 0.0).opacity, model.at(value.into()).opacity);
            assert!((found - exact).abs() < 1e-3, "{value}: {found} for {exact}");
        }
    }
    let peak = of(&[(0.0, 0.0), (6.9999, 0.0), (7.0, 0.8), (7.0001, 0.0), (31e3, 0.0)]);
    let lookup = Lookup::new(&peak, 1.0, 1.0);
    // Parts beside that of the peak are taken for such.
    assert!(lookup.is_clear([40.0, 30e3]) && !lookup.is_clear([7.0, 7.0]));
    assert!(!lookup.is_clear([0.0, 8.0]));
}

fn models() -> [OpticalModel; 3] {
    let rows = vec![
        (1.0, function(&[(0.0, 0.0, 0.0), (50.0, 1.0, 0.3)])),
        (5.0, function(&[(20.0, 1.0, 0.9), (20.0, 1.0, 0.0), (70.0, 0.2, 0.999)])),
    ];
    let material = |low: f64, shade: f32, opacity: f32, density: f64| Material {
        values: [low, low + 8.0],
        color: [shade; 3],
        opacity,
        density,
    };
    let body = vec![
        material(0.0, 0.0, 0.0, 0.0),
        material(20.0, 0.6, 0.2, 1.0),
        material(60.0, 1.0, 0.9, 2.5),
    ];
    [
        function(&[(0.0, 0.0, 0.1), (30.0, 1.0, 0.4), (30.0, 0.5, 0.6)]).into(),
        SlopeFunction::new(rows).unwrap().into(),
        Mixture::new(body, 0.7).unwrap().into(),
    ]
}

#[test]
fn a_lookup_of_any_model_is_the_model_at_every_slope() {
    for model in models() {
        let lookup = Lookup::new(&model, 0.4, 0.25);
        for n in 0..2000 {
            let (value, slope) = (-10.0 + 0.05 * n as f32, (n % 13) as f32);
            let exact = lookup.exact([value.into(), slope.into()], 1.0, None);
            let found = look(&lookup, value, slope);
            assert!(off(found, exact) < 1e-3, "{value}, {slope}: {found:?} for {exact:?}");
            let shows = exact.opacity > 0.0;
            assert!(!shows || lookup.place(value).is_some(), "{value}, {slope}");
        }
        assert!(lookup.place(f32::NAN).is_none());
    }
}

#[test]
fn two_halves_of_a_step_gather_what_the_whole_does() {
    for model in models() {
        let lookup = Lookup::new(&model, 0.4, 0.25);
        for (value, slope) in [(12.0, 3.0), (29.0, 0.5), (35.0, 12.0), (64.0, 2.0)] {
            let over = |part| lookup.exact([value, slope], part, None);
            let (whole, halves) = (over(1.0), over(0.5).over(over(0.5)));
            assert!((whole.opacity - halves.opacity).abs() < 1e-6, "{value}: {whole:?}");
            // A surface lies in the middle of each.
            assert!(off(whole, halves) < 0.02, "{value}: {whole:?} for {halves:?}");
        }
    }
}

#[test]
fn a_part_in_which_a_value_shows_is_seen() {
    for model in models() {
        let lookup = Lookup::new(&model, 1.0, 1.0);
        for part in (0..PARTS).step_by(7) {
            let value = |share: f32| lookup.base + (part as f32 + share) / lookup.scale;
            let ends = [0.0, 1.0].map(|share| f64::from(value(share)));
            assert!(!model.shows_any(ends) || lookup.is(part, SEEN), "{ends:?}");
        }
    }
}

//! Solids on lattices keep the laws of fields.

use crate::{Model, PeriodicSurface, Shape};
use isokit_field::{ScalarField, conformance::check};
use isokit_volume::Grid;
use std::{fs, path::Path};

/// On a lattice of about so many samples along its longest side.
fn check_on_lattice(model: &Model, samples: f64) {
    let solid = model.build().expect("a shape");
    let bounds = solid.bounds().expect("it has an end");
    let longest = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max);
    let h = longest / samples;
    check(&solid.placed(&solid.grid([h, 0.8 * h, 1.3 * h]).expect("a lattice")));
}

#[test]
fn primitives_conform() {
    for shape in [
        Shape::Sphere { radius: 2.0 },
        Shape::Box { size: [3.0, 2.0, 1.0], round: 0.0 },
        Shape::Box { size: [3.0, 2.0, 1.0], round: 0.4 },
        Shape::Cylinder { radius: 1.0, height: 3.0, round: 0.2 },
        Shape::Cone { radius: 1.5, top: 0.5, height: 2.0 },
        Shape::Torus { radius: 2.0, tube: 0.7 },
        Shape::Capsule { from: [0.0; 3], to: [1.0, 2.0, 3.0], radius: 0.8 },
    ] {
        check_on_lattice(&shape.into(), 17.0);
    }
}

#[test]
fn periodic_surfaces_planes_and_formulas_conform() {
    let ball = Shape::Sphere { radius: 3.0 };
    let walls = [
        PeriodicSurface::Gyroid,
        PeriodicSurface::SchwarzP,
        PeriodicSurface::SchwarzD,
        PeriodicSurface::Neovius,
        PeriodicSurface::Iwp,
    ];
    let walls = walls.map(|surface| Shape::Periodic { surface, cell: 2.5, thickness: Some(0.2) });
    let plane = Shape::Plane { normal: [1.0, -2.0, 2.0], at: 0.5 };
    // The second has no value where x is below 0.3.
    let formulas = ["1 - x^2 / 4 + sin(y) * exp(-z / 3)", "sqrt(x - 0.3) + 0.2 - y"];
    let formulas = formulas.map(|text| Shape::Formula(text.parse().expect("a formula")));
    for shape in walls.into_iter().chain([plane]).chain(formulas) {
        check_on_lattice(&ball.clone().intersection(shape).into(), 19.0);
    }
}

#[test]
fn the_shapes_of_the_fixtures_conform() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/shapes");
    let files =
        fs::read_dir(folder).expect("the fixtures").map(|entry| entry.expect("a file").path());
    let files = files.filter(|path| path.extension().is_some_and(|word| word == "toml"));
    let mut count = 0;
    for path in files {
        let model: Model =
            toml::from_str(&fs::read_to_string(&path).expect("a text")).expect("a shape");
        check_on_lattice(&model, 30.0);
        count += 1;
    }
    assert_eq!(count, 5);
}

#[test]
fn on_a_flat_face_the_slope_is_that_of_the_face() {
    let block = Shape::Box { size: [4.0, 6.0, 8.0], round: 0.0 };
    let cylinder = Shape::Cylinder { radius: 2.0, height: 8.0, round: 0.0 };
    let cone = Shape::Cone { radius: 4.0, top: 2.0, height: 8.0 };
    let top = |u, v| ([u, v, 4.0], [0.0, 0.0, -1.0]);
    let slant = 68_f64.sqrt();
    for n in 0..49 {
        let [u, v] = [n % 7, n / 7].map(|c| f64::from(c) / 4.0 - 0.75);
        for (shape, (place, slope)) in [
            (&block, ([2.0, u, v], [-1.0, 0.0, 0.0])),
            (&block, ([u, -3.0, v], [0.0, 1.0, 0.0])),
            (&block, top(u, v)),
            (&cylinder, top(u, v)),
            (&cylinder, ([0.0, 2.0, v], [0.0, -1.0, 0.0])),
            (&cone, top(u, v)),
            (&cone, ([3.0 - v / 4.0, 0.0, v], [-8.0 / slant, 0.0, -2.0 / slant])),
        ] {
            let solid = Model::from(shape.clone()).build().expect("a shape");
            let placed = solid.placed(&Grid::new([1; 3], Default::default()).expect("a lattice"));
            let found = placed.slope(place);
            let apart = [0, 1, 2].map(|k| found.gradient[k] - slope[k]);
            let most = apart.iter().fold(found.value.abs(), |most, c| most.max(c.abs()));
            assert!(most < 1e-14, "{shape:?}, {place:?}: {found:?}");
        }
    }
}

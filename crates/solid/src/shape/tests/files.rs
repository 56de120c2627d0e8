//! What a file may say, and what is refused, with its place.

use super::super::{Array, Combination, Model, PeriodicSurface, Shape};
use isokit_geom::Unit;

fn model(text: &str) -> Model {
    toml::from_str(text).unwrap_or_else(|error| panic!("{error}"))
}

fn refusal(text: &str) -> String {
    match toml::from_str::<Model>(text) {
        Err(error) => error.to_string(),
        Ok(model) => match model.build() {
            Err(error) => error.to_string(),
            Ok(solid) => solid.grid([1.0; 3]).unwrap_err().to_string(),
        },
    }
}

#[test]
fn a_tree_is_read_as_it_is_written() {
    let found = model(
        r#"
        unit = "mm"
        bounds = { from = [-1, -1, -1], to = [1.5, 1, 1] }
        [shape]
        difference = ["plate", { gyroid = { cell = 2, thickness = 0.1 } }]
        blend = 0.5
        move = [1, 0, 0]
        array = { count = 3, about = "y" }
        [part.plate]
        box = { size = [1, 2, 3] }
        rotate = { z = 30 }
        scale = 2
        shell = 0.1
        "#,
    );
    let plate = Shape::Box { size: [1.0, 2.0, 3.0], round: 0.0 };
    let plate = Shape::Shell { of: plate.into(), thickness: 0.1 };
    let gyroid =
        Shape::Periodic { surface: PeriodicSurface::Gyroid, cell: 2.0, thickness: Some(0.1) };
    let shape = Shape::Part("plate".into()).combined(Combination::Difference, gyroid, 0.5);
    let array = Array::Polar { count: 3, axis: 1, turn: 120.0 };
    assert_eq!(found.shape, shape.moved([1.0, 0.0, 0.0]).repeated(array));
    assert_eq!(found.part["plate"], plate.scaled(2.0).rotated([0.0, 0.0, 30.0]));
    assert_eq!((found.unit, found.bounds.unwrap().to), (Unit::Millimetre, [1.5, 1.0, 1.0]));
}

#[test]
fn unknown_words_are_refused_with_their_line() {
    for (text, line, says) in [
        ("[shape]\nsphere = { radius = 1 }\nmoved = [1, 0, 0]", "line 3", "unknown field `moved`"),
        ("[shape]\nunion = [\n  { sphere = { radios = 1 } },\n]", "line 3", "radios"),
        ("[shape]\nmove = [1, 2, 3]", "line 1", "this is no shape yet: expected one of sphere"),
        ("[shape]\nsphere = { radius = 1 }\nbox = { size = [1, 1, 1] }", "line 1", "two shapes"),
        ("[shape]\nunion = [\n  3,\n]", "line 3", "the name of a part"),
        ("[shape]\nsphere = { radius = 1 }\nblend = 1", "line 1", "blend is for union"),
        ("[shape]\nsphere = { radius = 1 }\narray = { count = 2 }", "line", "an array needs step"),
        ("[shape]\nformula = \"x + * y\"", "line 2", "column 5: expected a number"),
        ("unit = \"furlong\"\n[shape]\nsphere = { radius = 1 }", "line 1", "furlong"),
    ] {
        let found = refusal(text);
        assert!(found.contains(line) && found.contains(says), "{text}\n{found}");
    }
}

#[test]
fn numbers_out_of_range_are_refused_with_their_place_in_the_tree() {
    for (text, says) in [
        (
            "[shape]\nsphere = { radius = -1 }",
            "shape.sphere.radius: expected a finite number above 0, found -1",
        ),
        (
            "[shape]\nunion = [\"a\", { box = { size = [1, 0, 1] }, move = [1, 1, 1] }]\n[part.a]\nsphere = { radius = 1 }",
            "shape.union[1].box.size: expected a finite number above 0, found 0",
        ),
        ("[shape]\nunion = []", "shape.union: expected at least one shape, found none"),
        (
            "[shape]\nbox = { size = [1, 1, 1], round = 0.6 }",
            "shape.box.round: expected a number from 0 to 0.5, found 0.6",
        ),
        ("[shape]\ntorus = { radius = 1, tube = 2 }", "shape.torus.tube: "),
        ("[shape]\nsphere = { radius = 1 }\nrotate = { x = inf }", "shape.rotate: "),
        (
            "[shape]\nsphere = { radius = 1 }\nmirror = [0, 0, 0]",
            "shape.mirror: expected a direction",
        ),
        (
            "[shape]\nsphere = { radius = 1 }\narray = { count = 0, about = \"z\" }",
            "shape.array.count: ",
        ),
        (
            "[shape]\nsphere = { radius = 1 }\narray = { count = [999, 999, 999], step = [1, 1, 1] }",
            "shape.array.count: ",
        ),
        ("[shape]\npart = \"lid\"", "shape: there is no part \"lid\""),
        (
            "[shape]\nsphere = { radius = 1 }\n[part.lid]\ncone = { radius = 0, height = 1 }",
            "part.lid.cone.radius: ",
        ),
        (
            "[shape]\npart = \"a\"\n[part.a]\nunion = [\"b\"]\n[part.b]\nunion = [\"a\"]",
            "part.b.union[0]: a part is made of itself: a of b of a",
        ),
        ("[shape]\nsphere = { radius = 1e-200 }", "expected a size from 1e-100 to 1e100"),
        (
            "[shape]\nsphere = { radius = 1 }\narray = { count = 3, about = \"z\", turn = 1e308 }",
            "shape.array.turn: expected a size",
        ),
        ("[shape]\ngyroid = { cell = 1 }", "shape: it has no end along x"),
        ("[shape]\nplane = { normal = \"z\" }", "it has no end along x"),
        ("[shape]\nsphere = { radius = 1 }\noffset = -2", "shape: nothing is left of it"),
        (
            "bounds = { from = [0, 0, 0], to = [1, 0, 1] }\n[shape]\nsphere = { radius = 1 }",
            "bounds: ",
        ),
        (
            "[shape]\nsphere = { radius = 1e12 }",
            "spacing: expected at most 2147483647 samples along x",
        ),
    ] {
        let found = refusal(text);
        assert!(found.contains(says), "{text}\n{found}");
    }
}

#[test]
fn parts_of_parts_of_parts_take_no_time() {
    // Written out, the shape would have 2⁶⁰ balls.
    let mut text =
        "[shape]\nunion = [\"p59\", \"p59\"]\n[part.p0]\nsphere = { radius = 1 }\n".to_owned();
    for n in 1..60 {
        text += &format!("[part.p{n}]\nunion = [\"p{m}\", \"p{m}\"]\n", m = n - 1);
    }
    let solid = model(&text).build().unwrap();
    assert_eq!((solid.value([0.0; 3]), solid.bounds().unwrap().max), (1.0, [1.0; 3]));
    let scaled = text.replace("\"]\n[part.p", "\"]\nscale = [1, 1, 1.1]\n[part.p");
    assert!(model(&scaled).build().is_ok());
    let moved = text.replace(", \"p", ", { part = \"p").replace("\"]", "\", move = [1, 2, 3] }]");
    assert!(model(&moved).build().is_ok(), "n moves by as much are n places");
    // And here all are elsewhere.
    for n in 1..60 {
        text = text.replace(
            &format!(", \"p{n}\"]"),
            &format!(", {{ part = \"p{n}\", move = [{n}.{n}, 2, 3] }}]"),
        );
    }
    assert!(refusal(&text).contains("this takes more than"));
}

#[test]
fn what_would_be_looked_at_without_an_end_is_refused() {
    let ball = "[shape]\npart = \"p40\"\n[part.p0]\nsphere = { radius = 1 }\n";
    // Each offset is another, so that no box is known from before.
    let mut text = ball.to_owned();
    for n in 1..=40 {
        let (m, by) = (n - 1, 0.5_f64.powi(n));
        text += &format!("[part.p{n}]\nunion = [\"p{m}\", {{ part = \"p{m}\", offset = {by} }}]\n");
    }
    assert!(refusal(&text).contains("this takes more than"));
    // Copies that are all in one place make no new step.
    let copies = Array::Linear { count: 100_000, step: [0.0; 3], center: false };
    let ball = Shape::Sphere { radius: 1.0 };
    let all = ball.repeated(copies).repeated(copies).repeated(copies);
    assert!(Model::from(all).build().unwrap_err().to_string().contains("this takes more than"));
    // Parts that were made already hide how deep they are.
    let mut text = "[part.p0]\nsphere = { radius = 1 }\n".to_owned();
    for n in 1..=30_000 {
        text += &format!("[part.p{n}]\npart = \"p{}\"\n", n - 1);
    }
    let first: Vec<_> = (1..=300).map(|n| format!("\"p{}\"", 100 * n)).collect();
    text +=
        &format!("[shape]\nunion = [{}, {{ part = \"p30000\", offset = 1 }}]\n", first.join(", "));
    assert!(refusal(&text).contains("within each other"));
}

#[test]
fn what_is_nested_too_deep_is_refused() {
    let mut shape = Shape::Sphere { radius: 1.0 };
    for _ in 0..300 {
        shape = shape.moved([1.0, 0.0, 0.0]);
    }
    let error = Model::from(shape).build().unwrap_err().to_string();
    assert!(error.contains("more than 200 shapes within each other"), "{error}");
}

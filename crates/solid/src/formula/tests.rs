//! What formulas mean, and what is refused.

use super::Formula;
use crate::{Model, Shape};

fn value(text: &str, point: [f64; 3]) -> f64 {
    let formula: Formula = text.parse().unwrap_or_else(|error| panic!("{error}"));
    Model::from(Shape::Formula(formula)).build().unwrap().value(point)
}

#[test]
fn operators_bind_as_in_books() {
    for (text, expected) in [
        ("1 + 2 * 3", 7.0),
        ("2 * 3 ^ 2", 18.0),
        ("-2 ^ 2", -4.0),
        ("2 ^ -1", 0.5),
        ("2 ^ 3 ^ 2", 512.0),
        ("8 / 4 / 2", 1.0),
        ("8 - 4 - 2", 2.0),
        ("-2 * -3", 6.0),
        ("--2", 2.0),
        ("+2", 2.0),
        ("(1 + 2) * 3", 9.0),
        ("1.5e1 + .5", 15.5),
        ("2 * pi", std::f64::consts::TAU),
        ("ln(e)", 1.0),
        ("mod(-1, 3) + mod(7, 3)", 3.0),
        ("max(1, 5, 3) - min(4, 2, 8)", 3.0),
        ("clamp(7, 0, 2) + clamp(-7, 0, 2)", 2.0),
        ("length(3, 4) + length(-2)", 7.0),
        ("atan2(0, -1) - pi", 0.0),
        ("abs(-3) + floor(-0.5) + sqrt(16)", 6.0),
        ("pow(2, 10) - 4 ^ 0.5", 1022.0),
    ] {
        let found = value(text, [0.0; 3]);
        assert!((found - expected).abs() < 1e-12, "{text} = {found}");
    }
    assert_eq!(value("x*100 + y*10 + z", [1.0, 2.0, 3.0]), 123.0);
    assert_eq!(value("x^3 - x*x*x + y^0", [1.7, 2.0, 3.0]), 1.0);
}

#[test]
fn a_refusal_shows_where() {
    for (text, column, expected, found) in [
        ("", 1, "a number, x, y, z, a function or (", "the end"),
        ("x + ", 5, "a number, x, y, z, a function or (", "the end"),
        ("x + )", 5, "a number, x, y, z, a function or (", "\")\""),
        ("2 x", 3, "an operator or the end", "\"x\""),
        ("(x", 3, "\")\"", "the end"),
        ("sin x", 5, "\"(\"", "\"x\""),
        ("1.2.3 + x", 1, "a number such as 2.5 or 1e-3", "\"1.2.3\""),
        ("x § y", 3, "+ - * / ^ ( ) a comma, a number or a word", "\"§\""),
        ("é", 1, "+ - * / ^ ( ) a comma, a number or a word", "\"é\""),
        ("1 + atan2(x)", 5, "atan2 of two numbers", "1 of them"),
        ("min(x)", 1, "min of two numbers or more", "1 of them"),
    ] {
        let error = text.parse::<Formula>().unwrap_err();
        let told = (error.column, error.expected.as_str(), error.found.as_str());
        assert_eq!(told, (column, expected, found), "{text}");
    }
    let error = "x + siin(y)".parse::<Formula>().unwrap_err();
    assert!(error.to_string().ends_with("found \"siin\"\n  x + siin(y)\n      ^"), "{error}");
}

#[test]
fn no_formula_is_too_long_or_too_deep_for_the_stack() {
    let sum = vec!["x"; 15_000].join(" + ");
    assert_eq!(value(&sum, [1.0, 0.0, 0.0]), 15_000.0);
    for deep in ["(".repeat(50_000), "-".repeat(50_000), "2^".repeat(30_000), "1".repeat(70_000)] {
        let error = deep.parse::<Formula>().unwrap_err();
        assert!(error.expected.starts_with("at most"), "{error}");
    }
}

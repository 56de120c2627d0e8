//! `resample`: the same ball at other samples.

use crate::kit::{CENTRE, Folder, assert_near, ball, middle};
use isokit::geom::Space;
use isokit_cli::Exit;

fn info(folder: &Folder, name: &str) -> serde_json::Value {
    folder.done(&format!("info {name} --json")).json()
}

#[test]
fn a_ball_stays_where_it_is_with_samples_even_finer_and_fewer() {
    let folder = Folder::with_ball();
    let before = info(&folder, "ball.nii");
    for (words, is_rough) in [
        ("--spacing 0.5", false),
        ("--spacing 0.4,0.3,0.7 --kernel catmull-rom", false),
        ("--spacing 0.5 --kernel lanczos3", false),
        ("--spacing 0.5 --smoothing", true),
        ("--spacing 2", true),
        ("--spacing 1 --kernel nearest", true),
    ] {
        let ran = folder.done(&format!("resample ball.nii {words} -o other.nrrd"));
        assert!(ran.err.contains("of f32"), "{words}: {}", ran.err);
        let after = info(&folder, "other.nrrd");
        let origin = |info: &serde_json::Value| -> Vec<f64> {
            (0..3).map(|k| info["index_to_world"][k][3].as_f64().unwrap()).collect()
        };
        assert_eq!((origin(&after), &after["space"]), (origin(&before), &before["space"]));
        folder.done("extract other.nrrd --iso 50 -o ball.ply");
        let found = folder.topology("ball.ply");
        assert!(found.shortfalls().is_empty(), "{words}");
        let tolerance = if is_rough { 0.6 } else { 0.05 };
        assert_near(middle(&found), CENTRE, tolerance);
        let volume = found.measure.volume;
        let expected = 4.0 / 3.0 * std::f64::consts::PI * 64.0;
        let off = (volume / expected - 1.0).abs();
        assert!(off < if is_rough { 0.25 } else { 0.02 }, "{words}: {volume} of {expected}");
    }
}

#[test]
fn words_that_do_not_fit_are_refused_before_anything_is_read() {
    let folder = Folder::new();
    for (words, says) in [
        ("--spacing 1 -o a.ply", "expected a name that ends in one of"),
        ("--spacing 1 --smoothing --kernel linear -o a.nii", "leave it out"),
        ("--spacing 0 -o a.nii", "expected one distance above 0"),
        ("--spacing 1 --kernel cubic -o a.nii", "expected nearest, linear"),
        ("--spacing 1 -o none.nii", "are the same file"),
        ("-o a.nii", "--spacing <X[,Y,Z]>"),
    ] {
        let ran = folder.run(&format!("resample none.nii {words}"));
        assert!(ran.exit == Exit::Usage && ran.err.contains(says), "{words}: {}", ran.err);
    }
    assert!(folder.names().is_empty());
}

#[test]
fn what_cannot_be_resampled_is_said_with_what_helps() {
    let folder = Folder::new();
    folder.volume(
        "hole.nii",
        Space::Ras,
        |ijk| if ijk == [3, 4, 5] { f32::NAN } else { ball(ijk) },
    );
    let ran = folder.run("resample hole.nii --spacing 1 -o a.nii");
    assert_eq!(ran.exit, Exit::Failed);
    for words in ["[3, 4, 5] is NaN", "--kernel catmull-rom"] {
        assert!(ran.err.contains(words), "{}", ran.err);
    }
    let ran = folder.run("resample hole.nii --spacing 1e-9 -o a.nii");
    assert!(
        ran.exit == Exit::Failed && ran.err.contains("choose a greater --spacing"),
        "{}",
        ran.err
    );
    assert_eq!(folder.names(), ["hole.nii"]);
    folder.done("resample hole.nii --spacing 1 --kernel linear -o a.nii");
    assert!(info(&folder, "a.nii")["nan"].as_u64().unwrap() > 0);
}

#[test]
fn distances_that_a_file_has_not_are_given_beside_those_that_are_wanted() {
    let folder = Folder::new();
    folder.volume("ball.npy", Space::Ras, ball);
    folder.done("resample ball.npy --input-spacing 0.5,1,2 --origin 1,2,3 --spacing 1 -o even.nii");
    let even = info(&folder, "even.nii");
    assert_eq!(even["spacing"], serde_json::json!([1.0, 1.0, 1.0]));
    let origin: Vec<f64> = (0..3).map(|k| even["index_to_world"][k][3].as_f64().unwrap()).collect();
    assert_eq!(origin, [1.0, 2.0, 3.0]);
}

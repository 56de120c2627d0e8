//! `suggest`: isovalues that stand out.

use crate::kit::{Folder, ball};
use isokit::geom::Space;
use isokit_cli::Exit;
use serde_json::json;

#[test]
fn isovalues_come_with_reasons_and_a_command_that_works() {
    let folder = Folder::with_ball();
    let text = folder.done("suggest ball.nii").text().to_owned();
    for words in
        ["█", "mean ", "isovalue  score", "parts the samples into two classes", "per unit steep"]
    {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
    let command = text.lines().find_map(|line| line.trim().strip_prefix("isokit extract "));
    folder.done(&format!("extract {}", command.unwrap_or_else(|| panic!("{text}"))));
    assert!(folder.names().contains(&"mesh.glb".to_owned()));
}

#[test]
fn scripts_get_them_best_first() {
    let folder = Folder::with_ball();
    let report = folder.done("suggest ball.nii --json").json();
    assert_eq!(report["schema"], "isokit.suggest/1");
    let all = report["suggestions"].as_array().unwrap();
    let score = |n: usize| all[n]["score"].as_f64().unwrap();
    assert!(all.len() >= 2 && (1..all.len()).all(|n| score(n) <= score(n - 1)), "{report}");
    let [least, greatest] = [0, 1].map(|n| report["range"][n].as_f64().unwrap());
    for one in all {
        assert!((least..=greatest).contains(&one["iso"].as_f64().unwrap()));
        assert!(["otsu", "laplacian", "contour"].contains(&one["method"].as_str().unwrap()));
        assert!(one["reason"].as_str().unwrap().len() > 20);
    }
    let median = report["percentiles"]["50"].as_f64().unwrap();
    assert!(least < median && median < greatest);
    assert!(report["deviation"].as_f64().unwrap() > 0.0);
}

#[test]
fn values_so_many_deviations_above_the_mean_and_percentiles_are_told() {
    let folder = Folder::with_ball();
    let text = folder.done("suggest ball.nii").text().to_owned();
    let report = folder.done("suggest ball.nii --json").json();
    let numbers = |of: &str| -> Vec<f64> {
        let line = text.lines().find_map(|line| line.trim().strip_prefix(of));
        let line = line.unwrap_or_else(|| panic!("no {of:?} in {text}"));
        line.split(", ").map(|number| number.parse().unwrap()).collect()
    };
    let is_near = |found: f64, exact: f64| (found - exact).abs() <= 1e-5 * exact.abs();
    let of = |name: &str| report[name].as_f64().unwrap();
    for (times, found) in
        [1.0, 2.0, 3.0, 5.0].into_iter().zip(numbers("1, 2, 3, 5 deviations above the mean: "))
    {
        assert!(is_near(found, of("mean") + times * of("deviation")), "{times}: {found}");
    }
    let found = numbers("1, 5, 25, 50, 75, 95, 99 % of the samples up to: ");
    for (percent, found) in [1, 5, 25, 50, 75, 95, 99].into_iter().zip(found) {
        let exact = report["percentiles"][percent.to_string()].as_f64().unwrap();
        assert!(is_near(found, exact), "{percent}: {found}, not {exact}");
    }
}

#[test]
fn the_plot_is_a_picture_with_three_curves() {
    let folder = Folder::with_ball();
    let ran = folder.done("suggest ball.nii --plot values.png");
    assert!(ran.err.contains("wrote"), "{}", ran.err);
    let file = std::fs::File::open(folder.path("values.png")).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!([info.width, info.height], [960, 480]);
    for color in [[0x00, 0x9e, 0x73], [0x00, 0x72, 0xb2], [0xd5, 0x5e, 0x00]] {
        let part = pixels.chunks(info.line_size / 960).filter(|pixel| pixel.starts_with(&color));
        assert!(part.count() > 200, "{color:?}");
    }
    let ran = folder.run("suggest ball.nii --plot nowhere/values.png");
    assert!(ran.err.contains("there is no folder"), "{}", ran.err);
    let ran = folder.run("suggest ball.nii --plot values.svg");
    assert!(ran.exit == Exit::Usage && ran.err.contains(".png"), "{}", ran.err);
}

#[test]
fn samples_of_one_value_or_none_suggest_nothing() {
    let folder = Folder::new();
    folder.volume("flat.nrrd", Space::Ras, |_| 7.0);
    assert!(folder.done("suggest flat.nrrd").text().contains("no isovalue separates"));
    folder.volume("nan.nrrd", Space::Ras, |_| f32::NAN);
    assert!(folder.done("suggest nan.nrrd").text().contains("no value is finite"));
    let report = folder.done("suggest nan.nrrd --json").json();
    assert_eq!((&report["suggestions"], &report["mean"]), (&json!([]), &json!(null)));
    let ran = folder.run("suggest flat.nrrd --plot a.png");
    assert!(ran.exit == Exit::Usage && ran.err.contains("nothing to plot"), "{}", ran.err);
    let hole = |ijk| if ijk == [0, 0, 0] { f32::NAN } else { ball(ijk) };
    folder.volume("hole.nrrd", Space::Lps, hole);
    assert!(folder.done("suggest hole.nrrd").text().contains("isokit extract hole.nrrd --iso "));
}

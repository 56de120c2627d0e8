//! `extract --index`: the same mesh, sooner.

use crate::kit::{DIMS, Folder, ball};
use isokit::geom::Space;
use isokit_cli::Exit;
use serde_json::Value;
use std::fs;

/// Extracts with an index: the mesh, what was skipped, and what was said.
#[track_caller]
fn indexed(folder: &Folder, iso: &str) -> (Vec<u8>, Value, String) {
    let line = format!("extract ball.nii --iso {iso} -o mesh.ply --index --report report.json");
    let ran = folder.run(&line);
    assert_eq!(ran.exit, Exit::Done, "{}", ran.err);
    let report = fs::read(folder.path("report.json")).unwrap();
    let report: Value = serde_json::from_slice(&report).unwrap();
    let mesh = fs::read(folder.path("mesh.ply")).unwrap();
    (mesh, report["skipped"].clone(), ran.err)
}

#[track_caller]
fn plain(folder: &Folder, iso: &str) -> Vec<u8> {
    folder.run(&format!("extract ball.nii --iso {iso} -o plain.ply"));
    fs::read(folder.path("plain.ply")).unwrap()
}

#[test]
fn an_index_is_made_once_and_changes_nothing() {
    let folder = Folder::with_ball();
    for (n, iso) in ["0.5", "0.5", "-2", "3"].iter().enumerate() {
        let (mesh, skipped, said) = indexed(&folder, iso);
        assert_eq!(mesh, plain(&folder, iso), "{iso}");
        assert_eq!(skipped["bricks"], 4);
        assert_eq!(said.contains("index kept in"), n == 0, "{said}");
    }
    assert!(folder.names().contains(&"ball.nii.bricks".to_owned()));
    let (_, skipped, _) = indexed(&folder, "1e6");
    assert_eq!((&skipped["bricks_skipped"], &skipped["samples_read"]), (&4.into(), &0.into()));
}

#[test]
fn several_values_share_an_index() {
    let folder = Folder::with_ball();
    let run = |more: &str| {
        let out = format!("extract ball.nii --iso 0.5 --iso 2 --iso -1 -o mesh.glb {more}");
        assert_eq!(folder.run(&out).exit, Exit::Done);
        fs::read(folder.path("mesh.glb")).unwrap()
    };
    assert_eq!(run("--index"), run(""));
}

#[test]
fn an_index_of_what_the_volume_was_before_is_made_again() {
    let folder = Folder::with_ball();
    indexed(&folder, "0.5");
    folder.volume("ball.nii", Space::Ras, |ijk| ball(ijk) + 2.0);
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(5);
    let file = fs::File::options().write(true).open(folder.path("ball.nii")).unwrap();
    file.set_modified(later).unwrap();
    let (mesh, _, said) = indexed(&folder, "0.5");
    assert!(said.contains("made again") && said.contains("has changed since"), "{said}");
    assert_eq!(mesh, plain(&folder, "0.5"));
}

#[test]
fn a_damaged_index_is_made_again() {
    let folder = Folder::with_ball();
    indexed(&folder, "0.5");
    let whole = fs::read(folder.path("ball.nii.bricks")).unwrap();
    let mut flipped = whole.clone();
    flipped[60] ^= 0x40;
    for broken in [&[][..], &whole[..20], &whole[..whole.len() - 1], &flipped, &[7; 5000]] {
        fs::write(folder.path("ball.nii.bricks"), broken).unwrap();
        let (mesh, _, said) = indexed(&folder, "0.5");
        assert!(said.contains("damaged"), "{said}");
        assert_eq!(mesh, plain(&folder, "0.5"));
        assert_eq!(fs::read(folder.path("ball.nii.bricks")).unwrap(), whole);
    }
}

#[test]
fn an_index_that_cannot_be_kept_is_a_warning() {
    let folder = Folder::with_ball();
    fs::create_dir(folder.path("ball.nii.bricks")).unwrap();
    let (mesh, skipped, said) = indexed(&folder, "0.5");
    assert!(said.contains("index not kept"), "{said}");
    assert_eq!(skipped["bricks"], 4);
    assert_eq!(mesh, plain(&folder, "0.5"));
}

/// A raw volume of [`SIZES`] samples with a ball in it, and the words that describe it.
fn large(folder: &Folder) -> &'static str {
    let samples = (0..SIZES.iter().product()).flat_map(|n: usize| {
        let ijk = [n % SIZES[0], n / SIZES[0] % SIZES[1], n / SIZES[0] / SIZES[1]];
        let away = ijk.iter().zip([150.0, 60.0, 90.0]).map(|(&i, c)| (i as f32 - c).powi(2));
        (12.0 - away.sum::<f32>().sqrt()).to_le_bytes()
    });
    fs::write(folder.path("large.raw"), samples.collect::<Vec<u8>>()).unwrap();
    "large.raw --dims 200,90,150 --dtype f32"
}

const SIZES: [usize; 3] = [200, 90, 150];

/// The file of a command with an index and without, and what was skipped with it.
#[track_caller]
fn both(folder: &Folder, words: &str) -> Value {
    let made = |more: &str| {
        let ran = folder.run(&format!("extract {words} -o mesh.glb --report report.json {more}"));
        assert_eq!(ran.exit, Exit::Done, "{words}: {}", ran.err);
        let report = fs::read(folder.path("report.json")).unwrap();
        let report: Value = serde_json::from_slice(&report).unwrap();
        (fs::read(folder.path("mesh.glb")).unwrap(), report)
    };
    let (plain, told) = made("");
    let (mesh, report) = made("--index");
    assert!(mesh == plain, "{words}");
    assert_eq!(report["surfaces"], told["surfaces"], "{words}");
    assert_eq!(report["input"], told["input"], "{words}");
    report["skipped"].clone()
}

/// How many of the samples that are told were read, of how many, in hundredths.
fn share(skipped: &Value, of: usize) -> u64 {
    100 * skipped["samples_read"].as_u64().unwrap() / of as u64
}

#[test]
fn of_a_part_the_index_is_that_of_the_whole_volume() {
    let folder = Folder::new();
    let volume = large(&folder);
    both(&folder, &format!("{volume} --iso 0"));
    let kept = fs::read(folder.path("large.raw.bricks")).unwrap();
    for (part, samples, bricks) in [
        ("--roi 3:,5:,10:", 197 * 85 * 140, 4 * 12 * 18),
        ("--roi 64:,:,40:", 136 * 90 * 110, 3 * 12 * 14),
        ("--roi-mm 10:,:,-9:149", 190 * 90 * 150, 3 * 12 * 19),
    ] {
        let skipped = both(&folder, &format!("{volume} --iso 0 --iso 2 {part}"));
        assert_eq!(skipped["bricks"], bricks, "{part}");
        assert!(share(&skipped, samples) < 25, "{part}: {skipped}");
        assert!(skipped["bricks_skipped"].as_u64() > Some(bricks * 3 / 4), "{part}: {skipped}");
    }
    // Of a part that is full of the ball all samples are sooner looked at.
    let full = both(&folder, &format!("{volume} --iso 0 --roi 140:160,50:70,80:100"));
    assert_eq!((&full["bricks_skipped"], &full["samples_read"]), (&0.into(), &8000.into()));
    assert_eq!(fs::read(folder.path("large.raw.bricks")).unwrap(), kept);
}

#[test]
fn planes_look_at_the_samples_near_the_surface_only() {
    let folder = Folder::new();
    let volume = large(&folder);
    for more in ["", "--roi 3:,5:,10:", "--clip 0,-1,0.5,10 --normals area --iso 3"] {
        let skipped = both(&folder, &format!("{volume} --iso 0 --clip 1,0.5,-0.25,155 {more}"));
        assert!(share(&skipped, SIZES.iter().product()) < 8, "{more}: {skipped}");
        assert!(skipped["bricks_skipped"].as_u64() > Some(0), "{more}: {skipped}");
    }
    for part in ["--roi 140:160,50:70,80:100", "--roi 5:50,:,:"] {
        both(&folder, &format!("{volume} --iso 0 --clip 1,0.5,-0.25,155 {part}"));
    }
}

#[test]
fn what_of_a_file_holds_no_surface_is_not_read() {
    let folder = Folder::new();
    let volume = large(&folder);
    let one = both(&folder, &format!("{volume} --iso 0 --max-memory 64MiB"));
    assert_eq!(one["bricks"], 4 * 12 * 19);
    // The rows around the ball, of the slices around it.
    assert!((3..25).contains(&share(&one, SIZES.iter().product())), "{one}");
    let two = both(&folder, &format!("{volume} --iso 0 --iso -20 --max-memory 80MiB"));
    assert!(two["samples_read"].as_u64() > one["samples_read"].as_u64(), "{two}");
    let part = both(&folder, &format!("{volume} --iso 0 --max-memory 64MiB --roi 9:,50:,95:140"));
    assert!(part["samples_read"].as_u64() < one["samples_read"].as_u64(), "{part}");
    // A window of fewer slices.
    let short = "--placement linear --topology table --max-memory 50MiB";
    let short = both(&folder, &format!("{volume} --iso 0 {short}"));
    assert_eq!(short, one);
    let none = both(&folder, &format!("{volume} --iso 1e6 --boundary open --max-memory 64MiB"));
    assert_eq!(none["samples_read"], 0);
}

#[test]
fn with_a_kept_index_rows_far_from_the_surfaces_are_not_even_read() {
    let folder = Folder::new();
    let volume = large(&folder);
    folder.done(&format!("extract {volume} --iso 0 -o a.glb --index"));
    let modes = [
        "",
        "--topology table --placement linear --boundary open --threads 1",
        "--normals area --degenerate exact",
        "--normals none --diagonals fitted",
        "--iso 2:inner --iso 5 --placement cubic",
        "--space index --nan outside",
    ];
    let made = |mode: &str| {
        folder.done(&format!("extract {volume} --iso 0 {mode} -o a.glb --report a.json"));
        (fs::read(folder.path("a.glb")).unwrap(), folder.json("a.json")["surfaces"].clone())
    };
    // Without a report, which would look at all samples of a part.
    let part = || {
        folder.done(&format!("extract {volume} --iso 0 --roi 3:,5:,10: --index -o a.glb"));
        fs::read(folder.path("a.glb")).unwrap()
    };
    folder.done(&format!("extract {volume} --iso 0 --roi 3:,5:,10: -o whole.glb"));
    let whole = fs::read(folder.path("whole.glb")).unwrap();
    let before = modes.map(made);
    // NaN in the first slices, of which the file says nothing.
    let path = folder.path("large.raw");
    let since = fs::metadata(&path).unwrap().modified().unwrap();
    let mut bytes = fs::read(&path).unwrap();
    bytes[..4 * SIZES[0] * SIZES[1] * 50].fill(0xff);
    fs::write(&path, bytes).unwrap();
    fs::File::options().write(true).open(&path).unwrap().set_modified(since).unwrap();
    for (mode, before) in modes.iter().zip(before) {
        assert!(made(&format!("{mode} --index")) == before, "{mode}");
        let skipped = &folder.json("a.json")["skipped"];
        // Whole slices of rows; of samples in memory bricks near the surface would be read, a fiftieth.
        assert!((8..30).contains(&share(skipped, SIZES.iter().product())), "{mode}: {skipped}");
    }
    assert!(part() == whole);
}

#[test]
fn with_a_kept_index_nan_and_empty_surfaces_are_told_as_without() {
    let folder = Folder::new();
    let volume = large(&folder);
    let mut bytes = fs::read(folder.path("large.raw")).unwrap();
    bytes[400..404].copy_from_slice(&f32::NAN.to_le_bytes());
    fs::write(folder.path("hole.raw"), bytes).unwrap();
    let hole = volume.replace("large", "hole");
    for line in [
        format!("{hole} --iso 0"),
        format!("{hole} --iso 0 --nan outside -o -"),
        format!("{hole} --iso 0 --nan mask -v"),
        format!("{volume} --iso 0 -o - --format glb"),
        format!("{volume} --iso 999"),
        format!("{volume} --iso 999 --roi 3:,:,:"),
    ] {
        let run = |more: &str| {
            let out = if line.contains("-o -") { "" } else { "-o a.ply" };
            let ran = folder.run(&format!("extract {line} {out} {more}"));
            let told = |said: &&str| {
                !["index", "read ", "note: index"].iter().any(|word| said.starts_with(word))
            };
            let said: Vec<_> = ran.err.lines().filter(told).map(str::to_owned).collect();
            (ran.exit, ran.out, said)
        };
        let plain = run("");
        assert!(run("--index") == plain && run("--index") == plain, "{line}: {:?}", plain.2);
    }
}

#[test]
fn what_looks_at_samples_elsewhere_too_reads_all_of_them() {
    let folder = Folder::new();
    let volume = large(&folder);
    for mode in [
        "--iso 0 --refine 1 --balance",
        "--iso 0 --max-error 0.1",
        "--iso 0 --texture wood",
        "--iso 0 --clip 0,0,1,90",
        "--iso 0 --iso 90%",
        "--iso auto --normals area",
        "--iso 0 --iso -90",
    ] {
        let skipped = both(&folder, &format!("{volume} {mode}"));
        let again = both(&folder, &format!("{volume} {mode}"));
        assert_eq!(skipped, again, "{mode}: as when the index was made");
        fs::remove_file(folder.path("large.raw.bricks")).unwrap();
    }
}

#[test]
fn an_index_that_slices_made_is_the_one_that_the_volume_in_memory_makes() {
    let folder = Folder::new();
    let volume = large(&folder);
    let kept = |more: &str| {
        folder.done(&format!("extract {volume} --iso 0 -o mesh.ply --index {more}"));
        let bytes = fs::read(folder.path("large.raw.bricks")).unwrap();
        fs::remove_file(folder.path("large.raw.bricks")).unwrap();
        bytes
    };
    let whole = kept("");
    for more in ["--max-memory 64MiB", "--max-memory 64MiB --roi 9:50,:,:", "--roi :,:,:5"] {
        assert!(kept(more) == whole, "{more}");
    }
}

#[test]
fn an_index_counts_as_memory_and_is_not_made_in_vain() {
    let folder = Folder::new();
    // As many bricks as take 27 MiB, and nothing in the file.
    fs::File::create(folder.path("vast.raw")).unwrap().set_len(4_000_000_000).unwrap();
    let needed = |more: &str| {
        let words = "extract vast.raw --dims 2000,2000,1000 --dtype u8 --iso 1 -o mesh.ply";
        let ran = folder.run(&format!("{words} --max-memory 1MiB {more}"));
        assert_eq!(ran.exit, Exit::Failed, "{}", ran.err);
        let said = ran.err.split("need ").nth(1).and_then(|rest| rest.split("MiB").next());
        said.unwrap().parse::<u64>().unwrap()
    };
    let more = needed("--index") - needed("");
    assert!((26..=28).contains(&more), "{more} MiB");
    assert_eq!(folder.names(), ["vast.raw"]);
}

#[test]
fn without_an_index_all_samples_are_read() {
    let folder = Folder::with_ball();
    folder.run("extract ball.nii --iso 0.5 -o mesh.ply --report report.json");
    let report: Value =
        serde_json::from_slice(&fs::read(folder.path("report.json")).unwrap()).unwrap();
    assert_eq!(report["skipped"]["samples_read"], DIMS.iter().product::<usize>());
    assert_eq!(report["skipped"]["bricks"], 0);
    assert!(!folder.names().iter().any(|name| name.ends_with(".bricks")));
}

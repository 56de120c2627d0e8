//! What a scene may say, and what is refused.

use super::{At, CapWord, Color, Ground, ModeWord, PresetWord, SceneFile};
use isokit::{mesh::Rgba, pipeline::IsoChoice};

fn refusal(text: &str) -> String {
    toml::from_str::<SceneFile>(text).unwrap_err().to_string()
}

#[test]
fn everything_that_a_scene_may_say_is_read() {
    let scene: SceneFile = toml::from_str(
        r##"
        [volume]
        path = "head.nii.gz"
        [[surface]]
        name = "skin"
        iso = -300
        color = "#d8a580"
        opacity = 0.35
        [[surface]]
        iso = "50%"
        [[clip]]
        plane = [1, 0.0, 0.0, 12.5]
        surfaces = ["skin"]
        cap = "slice"
        [transfer]
        points = [[-1000, "#00000000"], [300.5, "#e8dcc0c0"]]
        unit = 1.5
        [camera]
        projection = "perspective"
        from = [300, -400, 120]
        at = "center"
        up = [0, 0, 1]
        fov = 30
        [light]
        shading = "gradient"
        specular = 0.3
        [sampling]
        step = 0.25
        integrated = true
        [output]
        size = [1024, 768]
        mode = "surfaces"
        background = "#ffffff"
        "##,
    )
    .unwrap();
    assert_eq!(scene.surface[0].iso, IsoChoice::Value(-300.0));
    assert_eq!(scene.surface[1].iso, IsoChoice::Percent(50.0));
    assert_eq!(scene.clip[0].plane, [1.0, 0.0, 0.0, 12.5]);
    assert_eq!(scene.clip[0].cap, CapWord::Slice);
    let points = scene.transfer.unwrap().points.unwrap();
    assert_eq!(points[1], (300.5, Color(Rgba([0xe8, 0xdc, 0xc0, 0xc0]))));
    assert!(matches!(scene.camera.at, Some(At::Center(_))));
    assert_eq!((scene.sampling.step, scene.sampling.integrated), (Some(0.25), true));
    assert_eq!(scene.output.mode, Some(ModeWord::Surfaces));
    assert_eq!(scene.output.background, Some(Ground::Color(Rgba([255; 4]))));
    let preset: SceneFile = toml::from_str("[transfer]\npreset = \"ct-bone\"").unwrap();
    assert_eq!(preset.transfer.unwrap().preset, Some(PresetWord::CtBone));
}

#[test]
fn a_word_too_many_is_refused_with_its_line() {
    let found = refusal("[camera]\nview = \"left\"\nzoom = 3\n");
    assert!(found.contains("line 3") && found.contains("unknown field `zoom`"), "{found}");
    for (text, says) in [
        (
            "[output]\nmode = \"fog\"",
            "unknown variant `fog`, expected one of `surfaces`, `iso-raycast`, `raycast`, `splat`",
        ),
        ("[output]\nbackground = \"#ffffff80\"", "expected transparent or an opaque #rrggbb"),
        ("[[surface]]\niso = \"bone\"", "expected a number, a percentage"),
        ("[[surface]]\niso = nan", "an isovalue is finite"),
        ("[[surface]]\niso = true", "\"auto\" or a percentage"),
        ("[[surface]]\niso = 1\ncolor = \"red\"", "expected #rrggbb or #rrggbbaa"),
        ("[[clip]]\nplane = [1, 0, 0]", "length"),
        ("[camera]\nat = \"middle\"", "expected \"center\" or three numbers"),
        ("[volume]\n", "missing field `path`"),
        ("[volume]\npath = \"a\"\nquantity = \"curl\"", "expected x, y, z, speed"),
    ] {
        let found = refusal(text);
        assert!(found.contains(says), "{text}: {found}");
    }
}

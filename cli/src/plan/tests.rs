//! What fits together and what does not, from words alone.

use super::{ConvertPlan, ConvertTo, ExtractPlan, Repeat, Stream};
use crate::args::{Cli, Command};
use clap::Parser;
use isokit::{geom::Unit, io::Format, pipeline::TargetSpace};

fn parsed(line: &str) -> Command {
    let line = format!("isokit {line}");
    Cli::try_parse_from(line.split(' ')).unwrap_or_else(|error| panic!("{line}: {error}")).command
}

fn extract(line: &str) -> Result<ExtractPlan, String> {
    let Command::Extract(args) = parsed(&format!("extract {line}")) else { panic!("{line}") };
    ExtractPlan::new(*args).map_err(|error| error.to_string())
}

fn convert(line: &str) -> Result<ConvertPlan, String> {
    let Command::Convert(args) = parsed(&format!("convert {line}")) else { panic!("{line}") };
    ConvertPlan::new(args).map_err(|error| error.to_string())
}

#[test]
fn the_extension_decides_the_format_in_any_case() {
    for (name, format) in [
        ("a.glb", Format::Glb),
        ("a.gltf", Format::Gltf),
        ("a.OBJ", Format::Obj),
        ("a.b.ply", Format::Ply),
        ("a.stl", Format::Stl),
    ] {
        let plan = extract(&format!("ct.nii --iso 300 -o {name}")).unwrap();
        assert_eq!(plan.target.format, format);
        assert_eq!(plan.target.stream, Stream::File(name.into()));
    }
}

#[test]
fn an_unknown_extension_is_refused_with_those_that_are_known() {
    let expected = "expected a name that ends in one of .glb .gltf .obj .ply .stl, found";
    for (name, found) in [("a.3mf", ".3mf"), ("a", "none"), ("a.ply.gz", ".gz"), ("a.nii", ".nii")]
    {
        let refusal = extract(&format!("ct.nii --iso 300 -o {name}")).unwrap_err();
        assert_eq!(refusal, format!("{name}: {expected} {found}"));
    }
    let refusal = convert("a.stl -o a.xyz").unwrap_err();
    assert!(refusal.contains(".stl .nrrd .nhdr .nii .nii.gz .npy .raw, found .xyz"), "{refusal}");
}

#[test]
fn a_folder_that_is_not_there_is_found_before_anything_is_read() {
    let refusal = extract("ct.nii --iso 300 -o no/such/folder/a.ply").unwrap_err();
    assert_eq!(refusal, "no/such/folder/a.ply: there is no folder no/such/folder");
    let refusal = extract("ct.nii --iso 300 -o a.ply --report no/r.json").unwrap_err();
    assert_eq!(refusal, "no/r.json: there is no folder no");
}

#[test]
fn stdout_takes_one_thing_and_says_what() {
    let plan = extract("ct.nii --iso 300 -o -").unwrap();
    assert_eq!((plan.target.stream, plan.target.format), (Stream::Stdout, Format::Ply));
    let plan = extract("ct.nii --iso 1 --iso 2 -o - --format glb").unwrap();
    assert_eq!(plan.target.format, Format::Glb);
    for (line, refusal) in [
        ("ct.nii --iso 1 --iso 2 -o -", "PLY holds one surface only"),
        ("ct.nii --iso 1 -o - --report -", "mesh and report cannot both go to stdout"),
        ("ct.nii --iso 1 -o a.ply --format stl", "--format says what -o - writes"),
    ] {
        let found = extract(line).unwrap_err();
        assert!(found.starts_with(refusal), "{found}");
    }
}

#[test]
fn a_gltf_unit_is_for_gltf() {
    let plan = extract("ct.nii --iso 300 -o a.glb --gltf-unit angstrom").unwrap();
    assert_eq!(plan.target.gltf_unit, Some(Unit::Angstrom));
    let refusal = extract("ct.nii --iso 300 -o a.ply --gltf-unit mm").unwrap_err();
    assert_eq!(refusal, "--gltf-unit is for .glb and .gltf; PLY has no fixed unit");
}

#[test]
fn several_surfaces_get_colours_and_a_single_one_does_not() {
    assert_eq!(extract("ct.nii --iso 300 -o a.glb").unwrap().levels[0].color, None);
    let levels = extract("ct.nii --iso 1 --iso 2:x:#01020304 --iso 3 -o a.glb").unwrap().levels;
    let colors: Vec<_> = levels.iter().map(|level| level.color.unwrap()).collect();
    assert_eq!(colors[1].to_string(), "#01020304");
    assert!(colors[0] != colors[2] && !colors[0].is_translucent());
    assert_eq!(levels[1].name.as_deref(), Some("x"));
    assert_eq!(levels[0].name, None);
}

#[test]
fn repeats_are_cold_or_warm() {
    let repeat = |option: &str| {
        extract(&format!("ct.nii --iso 1 -o a.glb --report r.json{option}")).unwrap().repeat
    };
    assert_eq!(repeat(""), Repeat::Once);
    assert_eq!(repeat(" --repeat 3"), Repeat::Cold(3.try_into().unwrap()));
    assert_eq!(repeat(" --repeat-warm 3"), Repeat::Warm(3.try_into().unwrap()));
}

#[test]
fn the_output_says_whether_a_volume_or_a_mesh_is_converted() {
    let plan = convert("a.raw --dims 2,3,4 --dtype u16be -o a.nii.gz --space index").unwrap();
    assert_eq!(plan.space, TargetSpace::Index);
    let ConvertTo::Volume { options, .. } = plan.to else { panic!("{plan:?}") };
    assert_eq!(options.raw.unwrap().dims, [2, 3, 4]);
    let ConvertTo::Mesh { target, weld } = convert("a.stl -o b.obj --weld 0.5").unwrap().to else {
        panic!("a mesh")
    };
    assert_eq!((target.format, weld), (Format::Obj, Some(0.5)));
}

#[test]
fn options_of_the_other_kind_are_refused() {
    for (line, refusal) in [
        ("a.nii -o b.ply --spacing 1,1,1", "the output is a mesh: --dims"),
        ("a.stl -o b.ply --space index", "a mesh has no samples to number"),
        ("a.nii -o b.nrrd --weld 0", "the output is a volume: --format"),
    ] {
        let found = convert(line).unwrap_err();
        assert!(found.starts_with(refusal), "{found}");
    }
}

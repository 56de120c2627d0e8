//! `convert`: the same thing in another file.

use crate::kit::{CENTRE, Folder, assert_near, ball, middle};
use isokit::{
    geom::Space,
    io::{VolumeOptions, read_volume},
    job::Job,
    volume::AnyVolume,
};
use isokit_cli::Exit;

fn volume(folder: &Folder, name: &str) -> AnyVolume {
    read_volume(&folder.path(name), &VolumeOptions::default(), &Job::default()).unwrap().volume
}

#[test]
fn a_volume_goes_round_through_formats_that_hold_all_of_it() {
    let folder = Folder::with_ball();
    folder.done("convert ball.nii -o a.nrrd");
    folder.done("convert a.nrrd -o b.nhdr");
    folder.done("convert b.nhdr -o c.nii.gz");
    assert_eq!(volume(&folder, "c.nii.gz"), volume(&folder, "ball.nii"));
}

#[test]
fn what_a_format_cannot_hold_comes_from_options() {
    let folder = Folder::with_ball();
    folder.done("convert ball.nii -o a.npy");
    folder.done("convert a.npy -o b.raw");
    folder.done(
        "convert b.raw -o c.nrrd --dims 16,14,12 --dtype f32 --spacing 1,2,1.5 --origin 10,20,30",
    );
    let [there, back] = ["ball.nii", "c.nrrd"].map(|name| volume(&folder, name));
    assert_eq!(back.grid().frame.index_to_world, there.grid().frame.index_to_world);
}

#[test]
fn a_volume_may_be_turned() {
    let folder = Folder::with_ball();
    folder.done("convert ball.nii -o a.nrrd --space lps");
    let turned = volume(&folder, "a.nrrd");
    assert_eq!(turned.grid().frame.space, Space::Lps);
    assert_eq!(turned.grid().frame.index_to_world.origin(), [-10.0, -20.0, 30.0]);
}

#[test]
fn a_mesh_goes_round_through_all_formats() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50:ball:#d8a58080 -o a.glb");
    let expected = folder.topology("a.glb");
    let mut from = "a.glb";
    for name in ["b.obj", "c.gltf", "d.ply", "e.stl", "f.glb"] {
        folder.done(&format!("convert {from} -o {name} --weld 0"));
        from = name;
    }
    let found = folder.topology("f.glb");
    assert_eq!((found.vertices, found.triangles), (expected.vertices, expected.triangles));
    assert_eq!(found.shortfalls(), [""; 0]);
    folder.done("convert a.glb -o g.ply");
    assert_near(middle(&folder.topology("g.ply")), middle(&expected), 1e-3);
}

#[test]
fn a_mesh_may_be_turned() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50 -o a.ply");
    folder.done("convert a.ply -o b.ply --space lps");
    let [x, y, z] = CENTRE;
    assert_near(middle(&folder.topology("b.ply")), [-x, -y, z], 1e-4);
    assert_eq!(folder.mesh("b.ply").space, Space::Lps);
    assert!(folder.topology("b.ply").measure.volume > 0.0);
    let ran = folder.run("convert a.ply -o - --space lps");
    let bytes = std::fs::read(folder.path("b.ply")).unwrap();
    assert_eq!(ran.out, bytes);
}

#[test]
fn nonsense_is_refused_in_a_clear_sentence() {
    let folder = Folder::with_ball();
    folder.done("extract ball.nii --iso 50 -o a.ply");
    for (line, exit, says) in [
        ("convert ball.nii -o b.ply", Exit::Failed, "`isokit extract` makes a mesh of a volume"),
        ("convert a.ply -o b.nii", Exit::Failed, "isokit voxelize` makes a volume of a mesh"),
        ("convert a.ply -o b.tiff", Exit::Usage, "found .tiff"),
        ("convert ball.nii -o b.mha", Exit::Usage, "found .mha"),
        ("convert ball.nii -o b.nrrd --gltf-unit mm", Exit::Usage, "the output is a volume"),
    ] {
        let ran = folder.run(line);
        assert_eq!(ran.exit, exit, "{line}: {}", ran.err);
        assert!(ran.err.contains(says), "{line}: {}", ran.err);
    }
    assert_eq!(folder.names(), ["a.ply", "ball.nii"]);
}

#[test]
fn one_volume_of_several_is_chosen_by_number() {
    let folder = Folder::new();
    folder.volume("ball.raw", Space::Unknown, ball);
    let ran = folder.run("convert ball.raw -o a.nrrd --dims 16,14,6 --dtype f32 --volume-index 3");
    assert_eq!(ran.exit, Exit::Failed);
}

//! What is beside the picture.

use super::{scan, scene, size};
use crate::scene::{Scene, Unneeded, Viewpoint};
use isokit_geom::Space;
use isokit_job::Job;
use isokit_mesh::TriMesh;
use isokit_render::{Image, Projection, RasterOptions, Side, Size};

/// The scene from a place near it, looking at a part of it.
fn near(at: [f64; 3], projection: Projection) -> Scene {
    let from = [2.0, 45.0, -3.0];
    let viewpoint =
        Viewpoint::At { from, at: Some(at), up: [0.0, 0.0, 1.0], orbit: 0.0, projection };
    Scene { viewpoint, ..scene() }
}

fn draw(scene: &Scene, meshes: &[TriMesh], size: Size) -> Image {
    let scan = scan();
    scene.draw(meshes, (Some(&scan), scan.around()), size, &Job::default()).unwrap().0
}

fn triangles(meshes: &[TriMesh]) -> usize {
    meshes.iter().map(|mesh| mesh.triangles.len()).sum()
}

#[test]
fn what_is_beside_the_picture_is_not_extracted_and_nobody_sees_a_difference() {
    let (scan, job, mut sizes) = (scan(), Job::default(), [size(); 3]);
    sizes[1].width = 37.try_into().unwrap();
    sizes[2].height = 20.try_into().unwrap();
    let all = Viewpoint::Framed { side: Side::Left, orbit: 0.0, fov: None, turns: false };
    for projection in [Projection::Parallel { height: 12.0 }, Projection::Perspective { fov: 20.0 }]
    {
        for (at, size) in [[0.0; 3], [7.0, 3.0, 10.0], [-12.0, 0.0, 1.0]].into_iter().zip(sizes) {
            let scene = near(at, projection);
            let whole = scene.meshes(&scan, (&[all], size), &job).unwrap();
            let shown = scene.meshes(&scan, (&[scene.viewpoint], size), &job).unwrap();
            let needs = scene.needs(&scan, (&[scene.viewpoint], size), &job).unwrap();
            assert!(4 * needs.samples_skipped > needs.samples, "{projection:?}, {at:?}: {needs:?}");
            let [shown, whole] = [shown, whole].map(|meshes| draw(&scene, &meshes, size));
            let seen = whole.pixels().iter().filter(|pixel| pixel.opacity > 0.0).count();
            assert!(2 * seen > whole.pixels().len(), "{seen} of {}", whole.pixels().len());
            for (shown, whole) in shown.pixels().iter().zip(whole.pixels()) {
                let off = (0..3).map(|n| (shown.color[n] - whole.color[n]).abs());
                assert!(off.fold(0.0, f32::max) < 1e-6, "{projection:?}, {at:?}");
            }
        }
    }
}

#[test]
fn pictures_from_several_places_have_what_each_of_them_shows() {
    let (scan, job) = (scan(), Job::default());
    let projection = Projection::Perspective { fov: 20.0 };
    let [left, right] = [[-12.0, 0.0, 1.0], [12.0, 0.0, 1.0]].map(|at| near(at, projection));
    let both = [left.viewpoint, right.viewpoint];
    let meshes = left.meshes(&scan, (&both, size()), &job).unwrap();
    for scene in [left, right] {
        let alone = scene.meshes(&scan, (&[scene.viewpoint], size()), &job).unwrap();
        assert!(triangles(&alone) < triangles(&meshes));
        let pairs = [&alone, &meshes].map(|meshes| draw(&scene, meshes, size()));
        for (alone, both) in pairs[0].pixels().iter().zip(pairs[1].pixels()) {
            let off = (0..3).map(|n| (alone.color[n] - both.color[n]).abs());
            assert!(off.fold(0.0, f32::max) < 1e-6);
        }
    }
}

#[test]
fn what_is_beside_the_picture_altogether_is_counted_and_said() {
    let (scan, job) = (scan(), Job::default());
    let away = near([2.0, 90.0, -3.0], Projection::Perspective { fov: 20.0 });
    let camera = (&[away.viewpoint][..], size());
    let needs = away.needs(&scan, camera, &job).unwrap();
    assert!(needs.surfaces.iter().all(|need| need.part == Err(Unneeded::Beside)), "{needs:?}");
    assert_eq!((needs.bricks_skipped, needs.samples_skipped), (needs.bricks, needs.samples));
    assert_eq!(triangles(&away.meshes(&scan, camera, &job).unwrap()), 0);
    assert_eq!(away.trace(&scan, size(), &job).unwrap().1.cells, 0);
    let meshes = away.meshes(&scan, camera, &job).unwrap();
    let around = (scan.around().0, Space::Ras);
    let image = away.draw(&meshes, (Some(&scan), around), size(), &job).unwrap().0;
    assert!(image.pixels().iter().all(|pixel| pixel.opacity == 0.0));
}

#[test]
fn what_is_beside_the_picture_may_be_in_the_way_of_light() {
    let (scan, job) = (scan(), Job::default());
    let scene = near([7.0, 3.0, 10.0], Projection::Parallel { height: 12.0 });
    let count = |raster: RasterOptions| {
        let scene = Scene { raster, ..scene.clone() };
        triangles(&scene.meshes(&scan, (&[scene.viewpoint], size()), &job).unwrap())
    };
    let alone = count(scene.raster);
    let lit = scene.raster.with_light_from(Some([1.0, 0.0, 0.0]), false);
    assert_eq!(count(lit), alone);
    let shadows = scene.raster.with_light_from(Some([1.0, 0.0, 0.0]), true);
    let all = count(shadows);
    assert!(all > alone && count(scene.raster.with_occlusion(0.5)) == all);
}

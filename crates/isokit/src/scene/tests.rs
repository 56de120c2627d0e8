//! Balls within balls: seen, cut and left out.

mod beside;
mod colors;
mod detail;
mod hidden;
mod read;

use super::{CapStyle, Clip, Preset, Scene, SceneError, SurfaceLook, Unneeded, Viewpoint};
use crate::pipeline::Scan;
use isokit_geom::{Aabb, Affine, Frame, HalfSpace, Space};
use isokit_job::Job;
use isokit_mesh::{Positions, TriMesh};
use isokit_render::{
    ControlPoint, Gathered, Image, Pattern, Projection, RasterOptions, RaycastOptions, Side, Size,
    SolidTexture, TransferFunction,
};
use isokit_volume::{Grid, Scaling, Volume};
use std::num::NonZeroU32;

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

/// How far within a ball of radius 20 a place is, in millimetres; samples are 1, 0.8 and 1.25 apart.
fn scan() -> Scan {
    let (dims, spacing) = ([60_u64, 75, 48], [1.0, 0.8, 1.25]);
    let affine = Affine::axis_aligned(spacing, [-29.5, -29.6, -29.375]).unwrap();
    let grid = Grid::new(dims, Frame { index_to_world: affine, ..Frame::default() }).unwrap();
    let depth = |n: u64| {
        let place = affine.point([n % 60, n / 60 % 75, n / 4500].map(|i| i as f64));
        20.0 - place.iter().map(|c| c * c).sum::<f64>().sqrt() as f32
    };
    Scan::new(Volume::new(grid, (0..grid.count()).map(depth).collect()).unwrap())
}

fn look(name: &str, iso: f64, color: [f32; 3], opacity: f32) -> SurfaceLook {
    SurfaceLook { name: name.into(), iso: Some(iso), color, opacity, texture: None }
}

/// A translucent ball of radius 20 around an opaque one of radius 10, seen from the front.
fn scene() -> Scene {
    let raster = RasterOptions::DEFAULT.with_light(None);
    Scene {
        surfaces: vec![look("skin", 0.0, RED, 0.5), look("bone", 10.0, BLUE, 1.0)],
        clips: vec![],
        model: None,
        viewpoint: Viewpoint::At {
            from: [0.0, 60.0, 0.0],
            at: Some([0.0; 3]),
            up: [0.0, 0.0, 1.0],
            orbit: 0.0,
            projection: Projection::Parallel { height: 60.0 },
        },
        raster,
        raycast: RaycastOptions::DEFAULT,
    }
}

/// Keeps what is behind the plane y = `offset`, seen from the front.
fn behind(offset: f64, surfaces: Option<&str>, cap: CapStyle) -> Clip {
    let half = HalfSpace::new([0.0, 1.0, 0.0], offset).unwrap();
    Clip { half, surfaces: surfaces.map(|name| vec![name.into()]), cap }
}

fn size() -> Size {
    let n = NonZeroU32::new(81).unwrap();
    Size { width: n, height: n }
}

fn drawn(scene: &Scene, scan: &Scan) -> Result<Image, SceneError> {
    let meshes = scene.meshes(scan, (&[scene.viewpoint], size()), &Job::default())?;
    Ok(scene.draw(&meshes, (Some(scan), scan.around()), size(), &Job::default())?.0)
}

#[track_caller]
fn assert_near(found: Gathered, color: [f32; 3], opacity: f32) {
    let expected = color.into_iter().chain([opacity]);
    for (found, expected) in found.color.into_iter().chain([found.opacity]).zip(expected) {
        assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
    }
}

#[test]
fn a_ball_in_a_ball_is_seen_through_the_outer_one() {
    let image = drawn(&scene(), &scan()).unwrap();
    assert_near(image.pixel(40, 40), [0.5, 0.0, 0.5], 1.0);
    // Beside the inner one, both walls of the outer.
    assert_near(image.pixel(40, 18), [0.75, 0.0, 0.0], 0.75);
    assert_near(image.pixel(0, 0), [0.0; 3], 0.0);
}

#[test]
fn planes_cut_what_they_name_and_caps_close_it() {
    let scan = scan();
    let with = |clips: Vec<Clip>| {
        let point = |value, color| ControlPoint { value, color, opacity: 0.0 };
        let points = vec![point(0.0, [0.0; 3]), point(20.0, [0.0, 1.0, 0.0])];
        let model = Some(TransferFunction::new(points).unwrap().into());
        drawn(&Scene { clips, model, ..scene() }, &scan).unwrap().pixel(40, 40)
    };
    // The camera looks along -y: the front wall of the outer ball is gone.
    assert_near(with(vec![behind(5.0, Some("skin"), CapStyle::None)]), [0.0, 0.0, 1.0], 1.0);
    let solid = with(vec![behind(5.0, None, CapStyle::Solid)]);
    assert_near(solid, BLUE, 1.0);
    let beyond = with(vec![behind(12.0, None, CapStyle::Solid)]);
    assert_near(beyond, RED, 1.0);
    let slice = with(vec![behind(5.0, None, CapStyle::Slice)]);
    // In the middle of the picture, 5 from the middle of the ball, the value is 15.
    assert!((slice.color[1] - 0.75).abs() < 0.01 && slice.opacity == 1.0, "{slice:?}");
    // A second plane takes away half of the cap.
    let half = HalfSpace::new([0.0, 0.0, 1.0], -3.0).unwrap();
    let other = Clip { half, surfaces: None, cap: CapStyle::None };
    let both = with(vec![behind(5.0, None, CapStyle::Solid), other]);
    // The camera looks along a line that it takes away the cap of, and the surfaces behind.
    assert_near(both, [0.0; 3], 0.0);
}

#[test]
fn a_cap_is_cut_from_the_solid_that_its_surface_is_cut_from() {
    let texture = SolidTexture::new(Pattern::Checker, [RED, BLUE], 4.0).unwrap();
    let skin = SurfaceLook { texture: Some(texture), ..look("skin", 0.0, [1.0; 3], 1.0) };
    let clips = vec![behind(5.0, None, CapStyle::Solid)];
    let (scene, scan) = (Scene { surfaces: vec![skin], clips, ..scene() }, scan());
    let traced = scene.trace(&scan, size(), &Job::default()).unwrap().0;
    for image in [drawn(&scene, &scan).unwrap(), traced] {
        let mut seen = [0; 2];
        for (column, row) in (18..63).flat_map(|row| (18..63).map(move |column| (column, row))) {
            // Seen from the front x points to the left.
            let [x, z] = [column, row].map(|n| (40.0 - f64::from(n)) * 60.0 / 81.0);
            let is_at_edge = |c: f64| (c / 4.0 - (c / 4.0).round()).abs() < 0.15;
            if is_at_edge(x) || is_at_edge(z) || x.hypot(z) > 19.0 {
                continue;
            }
            let color = texture.at([x, 5.0, z]);
            assert_near(image.pixel(column, row), color, 1.0);
            seen[usize::from(color == BLUE)] += 1;
        }
        assert!(seen.iter().all(|&pixels| pixels > 100), "{seen:?}");
    }
}

#[test]
fn what_planes_cut_away_is_not_extracted_and_nobody_sees_a_difference() {
    let scan = scan();
    let whole: Vec<TriMesh> =
        scene().meshes(&scan, (&[scene().viewpoint], size()), &Job::default()).unwrap();
    // Framed too: by what is left.
    let framed = Viewpoint::Framed { side: Side::Left, orbit: 20.0, fov: Some(30.0), turns: false };
    for normal in [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.05, -1.0, 0.08]] {
        for offset in [-6.0, 3.0] {
            let half = HalfSpace::new(normal, offset).unwrap();
            let clip = Clip { half, surfaces: None, cap: CapStyle::Solid };
            let scene = Scene { clips: vec![clip], viewpoint: framed, ..scene() };
            let cut = scene.meshes(&scan, (&[scene.viewpoint], size()), &Job::default()).unwrap();
            assert!(cut[0].triangles.len() < whole[0].triangles.len());
            let draw = |meshes: &[TriMesh]| {
                let subject = (Some(&scan), scan.around());
                scene.draw(meshes, subject, size(), &Job::default()).unwrap().0
            };
            let pairs =
                draw(&cut).pixels().to_vec().into_iter().zip(draw(&whole).pixels().to_vec());
            for (cut, whole) in pairs {
                let off = (0..3).map(|n| (cut.color[n] - whole.color[n]).abs());
                assert!(off.fold(0.0, f32::max) < 1e-6, "{normal:?}, {offset}");
            }
            let needs = scene.needs(&scan, (&[scene.viewpoint], size()), &Job::default()).unwrap();
            assert!(needs.samples_skipped > needs.samples / 10, "{needs:?}");
        }
    }
}

#[test]
fn needs_say_why_nothing_is_made_of_a_surface() {
    let scan = scan();
    let mut scene = scene();
    scene.surfaces[0].opacity = 0.0;
    scene.clips = vec![behind(-40.0, Some("bone"), CapStyle::None)];
    let needs = scene.needs(&scan, (&[scene.viewpoint], size()), &Job::default()).unwrap();
    let why: Vec<_> = needs.surfaces.iter().map(|need| need.part.clone()).collect();
    assert_eq!(why, [Err(Unneeded::Transparent), Err(Unneeded::CutAway)]);
    assert_eq!((needs.bricks, needs.samples), (needs.bricks_skipped, needs.samples_skipped));
    let meshes = scene.meshes(&scan, (&[scene.viewpoint], size()), &Job::default()).unwrap();
    assert!(meshes.iter().all(|mesh| mesh.triangles.is_empty()));
    let viewpoint = [scene.viewpoint];
    let all = super::tests::scene().needs(&scan, (&viewpoint, size()), &Job::default()).unwrap();
    assert!(all.samples_skipped == 0 && all.bricks_skipped < all.bricks, "{all:?}");
}

#[test]
fn a_camera_at_a_place_looks_at_the_same_middle_whatever_planes_leave() {
    let scan = scan();
    let look = |clips: Vec<Clip>| {
        let projection = Projection::Parallel { height: 60.0 };
        let (from, up) = ([0.0, 60.0, 0.0], [0.0, 0.0, 1.0]);
        let viewpoint = Viewpoint::At { from, at: None, up, orbit: 0.0, projection };
        drawn(&Scene { clips, viewpoint, ..scene() }, &scan).unwrap()
    };
    let half = HalfSpace::new([1.0, 0.0, 0.0], 0.0).unwrap();
    let (whole, cut) =
        (look(vec![]), look(vec![Clip { half, surfaces: None, cap: CapStyle::None }]));
    // What is left, on the right as seen from the front, is where it was; of the rest one looks into the half.
    assert_eq!(cut.pixel(60, 40), whole.pixel(60, 40));
    assert_eq!(cut.pixel(20, 40), Gathered::NOTHING);
}

#[test]
fn rays_are_cut_by_planes_that_cut_all() {
    let scan = scan();
    let points = [(0.0, 0.0), (1.0, 0.1)].map(|(value, opacity)| ControlPoint {
        value,
        color: RED,
        opacity,
    });
    let model = Some(TransferFunction::new(points.into()).unwrap().into());
    let cast = |clips: Vec<Clip>| {
        let scene = Scene { clips, model: model.clone(), ..scene() };
        scene.cast(&scan, size(), &Job::default()).unwrap().0.pixel(40, 40).opacity
    };
    let (whole, named) = (cast(vec![]), cast(vec![behind(0.0, Some("skin"), CapStyle::None)]));
    assert_eq!(whole, named);
    let half = cast(vec![behind(0.0, None, CapStyle::None)]);
    assert!(((1.0 - half).powi(2) - (1.0 - whole)).abs() < 1e-3, "{half}, {whole}");
}

#[test]
fn pictures_of_values_from_several_places_are_those_from_each_alone() {
    let scan = scan();
    let points = [(0.0, 0.0), (1.0, 0.1)].map(|(value, opacity)| ControlPoint {
        value,
        color: RED,
        opacity,
    });
    let model = Some(TransferFunction::new(points.into()).unwrap().into());
    let scene = Scene { clips: vec![behind(3.0, None, CapStyle::None)], model, ..scene() };
    let turned = |orbit: f64| Viewpoint::Framed {
        side: Side::Superior,
        orbit,
        fov: Some(40.0),
        turns: orbit > 90.0,
    };
    let viewpoints = [scene.viewpoint, turned(10.0), turned(100.0)];
    let (size, job, mut made) = (size(), Job::default(), vec![]);
    scene
        .cast_each(&scan, (&viewpoints, size), &job, |image, cast| {
            made.push((image, cast));
            Ok::<_, SceneError>(())
        })
        .unwrap();
    assert_eq!(made.len(), viewpoints.len());
    for (viewpoint, made) in viewpoints.into_iter().zip(made) {
        let alone = Scene { viewpoint, ..scene.clone() }.cast(&scan, size, &job).unwrap();
        assert!(made == alone, "{viewpoint:?}");
    }
}

#[test]
fn a_scene_that_does_not_fit_together_is_refused() {
    let scan = scan();
    let with = |clip| Scene { clips: vec![clip], ..scene() };
    let unknown = drawn(&with(behind(0.0, Some("liver"), CapStyle::None)), &scan).unwrap_err();
    assert!(unknown.to_string().contains("\"liver\""), "{unknown}");
    let slice = drawn(&with(behind(0.0, None, CapStyle::Slice)), &scan).unwrap_err();
    assert!(matches!(slice, SceneError::NoTransfer));
    let capped = with(behind(0.0, None, CapStyle::Solid));
    let meshes = vec![TriMesh::default(); 2];
    let mesh_only = capped.draw(&meshes, (None, scan.around()), size(), &Job::default());
    assert!(matches!(mesh_only, Err(SceneError::NoValues)));
    assert!(matches!(scene().cast(&scan, size(), &Job::default()), Err(SceneError::NoTransfer)));
}

#[test]
fn every_preset_shows_something_of_a_scan_with_such_values() {
    for (preset, factor) in [
        (Preset::Auto, 1.0),
        (Preset::CtBone, 40.0),
        (Preset::CtSkin, 40.0),
        (Preset::Mr, 1e-3),
        (Preset::Density, 1e9),
    ] {
        let grid = Grid::new([30; 3], Frame::default()).unwrap();
        let depth = |n: u64| {
            let place = [n % 30, n / 30 % 30, n / 900].map(|i| i as f64 - 14.5);
            (10.0 - place.iter().map(|c| c * c).sum::<f64>().sqrt()) * factor
        };
        let scan = Scan::new(
            Volume::new(grid, (0..grid.count()).map(depth).collect::<Vec<f64>>()).unwrap(),
        );
        let transfer = preset.transfer(&scan, &Job::default()).unwrap();
        let viewpoint = Viewpoint::Framed { side: Side::Left, orbit: 0.0, fov: None, turns: false };
        let scene = Scene { model: Some(transfer.into()), viewpoint, ..scene() };
        let image = scene.cast(&scan, size(), &Job::default()).unwrap().0;
        assert!(image.pixel(40, 40).opacity > 0.3, "{preset:?}");
        assert_eq!(image.pixel(0, 0).opacity, 0.0);
    }
    let flat = Grid::new([3; 3], Frame::default()).unwrap();
    let flat = Scan::new(Volume::new(flat, vec![1.0_f32; 27]).unwrap());
    for preset in [Preset::Auto, Preset::Mr, Preset::Density] {
        let error = preset.transfer(&flat, &Job::default()).unwrap_err().to_string();
        assert!(error.contains("all samples have one value"), "{preset:?}: {error}");
    }
}

#[test]
fn a_density_map_is_seen_from_two_deviations_on_and_an_image_by_its_own_tissue() {
    // One in a hundred is 100: the mean is 1, the deviation 9.95.
    let grid = Grid::new([20, 20, 25], Frame::default()).unwrap();
    let peaks = (0..grid.count()).map(|n| if n % 100 == 0 { 100.0_f32 } else { 0.0 }).collect();
    let peaks = Scan::new(Volume::new(grid, peaks).unwrap());
    let density = Preset::Density.transfer(&peaks, &Job::default()).unwrap();
    let values: Vec<f64> = density.points().iter().map(|point| point.value).collect();
    for (value, deviations) in values.into_iter().zip([2.0, 3.0, 6.0]) {
        assert!((value - (1.0 + deviations * 9.95)).abs() < 0.2, "{deviations}: {value}");
    }
    // Air, and tissue from 100 to 199, all alike often.
    let tissue = (0..grid.count()).map(|n| if n % 2 == 0 { 0 } else { 100 + (n / 2 % 100) as u8 });
    let image = Scan::new(Volume::new(grid, tissue.collect()).unwrap());
    let mr = Preset::Mr.transfer(&image, &Job::default()).unwrap();
    let values: Vec<f64> = mr.points().iter().skip(1).map(|point| point.value).collect();
    for (value, share) in values.into_iter().zip([0.3, 0.6, 0.9, 1.0]) {
        assert!((value - (99.0 + 100.0 * share)).abs() <= 1.0, "{share}: {value}");
    }
}

#[test]
fn a_surface_that_is_flat_is_framed_as_it_is() {
    let corners = [[100.0, 100.0, 5.0], [200.0, 100.0, 5.0], [100.0, 200.0, 5.0], [f64::NAN; 3]];
    let mesh = TriMesh {
        positions: Positions::F64(corners.into()),
        triangles: vec![[0, 1, 2]],
        ..TriMesh::default()
    };
    let viewpoint = Viewpoint::Framed { side: Side::Superior, orbit: 0.0, fov: None, turns: false };
    let surface = SurfaceLook { iso: None, ..look("flat", 0.0, RED, 1.0) };
    let scene = Scene { surfaces: vec![surface], viewpoint, ..scene() };
    let around = (Aabb { min: [0.0; 3], max: [1.0; 3] }, Space::default());
    let image = scene.draw(&[mesh], (None, around), size(), &Job::default()).unwrap().0;
    let seen = image.pixels().iter().filter(|pixel| pixel.opacity > 0.5).count();
    assert!(seen > 81 * 81 / 3, "{seen}");
}

#[test]
fn a_value_on_the_surface_is_inside_of_it_for_rays_and_caps_too() {
    let grid = Grid::new([9; 3], Frame::default()).unwrap();
    let scaling = Scaling::new(0.1, 0.0).unwrap();
    let volume = Volume::new(grid, vec![7_i16; 729]).unwrap().with_scaling(scaling);
    let scan = Scan::new(volume);
    let projection = Projection::Perspective { fov: 30.0 };
    let (from, up) = ([4.0, 7.0, 4.0], [0.0, 0.0, 1.0]);
    let viewpoint = Viewpoint::At { from, at: Some([4.0, 0.0, 4.0]), up, orbit: 0.0, projection };
    let surfaces = vec![look("all", scaling.value(7.0), RED, 0.5)];
    let inside = Scene { surfaces, viewpoint, ..scene() };
    // From within one looks through one wall, by either way.
    let traced = inside.trace(&scan, size(), &Job::default()).unwrap().0.pixel(40, 40);
    assert_near(traced, [0.5, 0.0, 0.0], 0.5);
    assert_near(drawn(&inside, &scan).unwrap().pixel(40, 40), [0.5, 0.0, 0.0], 0.5);
    let capped = Scene { clips: vec![behind(4.0, None, CapStyle::Solid)], ..inside };
    let traced = capped.trace(&scan, size(), &Job::default()).unwrap().0.pixel(40, 40);
    assert_near(traced, RED, 1.0);
}

#[test]
fn rays_need_the_bricks_of_which_something_can_be_seen() {
    let point = |value, opacity| ControlPoint { value, color: [1.0; 3], opacity };
    let transfer = TransferFunction::new(vec![point(15.0, 0.0), point(20.0, 1.0)]).unwrap();
    let rays = Scene { model: Some(transfer.into()), ..scene() };
    let needs = |scene: &Scene| {
        scene.needs_of_rays(&scan(), (&[scene.viewpoint], size()), &Job::default()).unwrap()
    };
    let all = needs(&rays);
    assert!(all.bricks_skipped > all.bricks / 2 && all.bricks_skipped < all.bricks, "{all:?}");
    let half = Scene { clips: vec![behind(0.0, None, CapStyle::None)], ..rays.clone() };
    assert!(needs(&half).bricks_skipped > all.bricks_skipped);
    let named = Scene { clips: vec![behind(0.0, Some("bone"), CapStyle::None)], ..rays.clone() };
    assert_eq!(needs(&named), all);
    let lost = Scene { clips: vec![behind(0.0, Some("lost"), CapStyle::None)], ..rays };
    let size = size();
    let (job, camera) = (Job::default(), (&[lost.viewpoint][..], size));
    let refused = lost.cast(&scan(), size, &job).unwrap_err();
    assert_eq!(refused.to_string(), lost.needs(&scan(), camera, &job).unwrap_err().to_string());
    let none = scene().needs_of_rays(&scan(), camera, &job);
    assert!(matches!(none, Err(SceneError::NoTransfer)));
}

#[test]
fn a_surface_that_planes_cut_away_is_not_looked_for_by_rays() {
    let away = behind(-40.0, None, CapStyle::None);
    let scene = Scene { clips: vec![away], ..scene() };
    let (image, traced) = scene.trace(&scan(), size(), &Job::default()).unwrap();
    assert!(image.pixels().iter().all(|pixel| pixel.opacity == 0.0));
    assert_eq!(traced.lit, 0);
    let whole = Scene { clips: vec![], ..scene };
    let all = whole.trace(&scan(), size(), &Job::default()).unwrap().1;
    assert!(traced.cells < all.cells / 100, "{traced:?} of {all:?}");
}

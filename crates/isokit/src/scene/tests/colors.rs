//! Meshes whose vertices have colours.

use super::{BLUE, RED, assert_near, behind, look, scan, scene, size};
use crate::scene::{CapStyle, Scene, SurfaceLook};
use isokit_job::Job;
use isokit_mesh::Rgba;
use isokit_render::{Gathered, Pattern, SolidTexture};

/// What is in the middle of the picture of the skin, whose vertices are green and half open.
fn middle(look: SurfaceLook, cap: Option<CapStyle>) -> Gathered {
    let (scan, job) = (scan(), Job::default());
    let clips = cap.map(|cap| behind(5.0, None, cap)).into_iter().collect();
    let scene = Scene { surfaces: vec![look], clips, ..scene() };
    let mut meshes = scene.meshes(&scan, (&[scene.viewpoint], size()), &job).unwrap();
    let green = Rgba([0, 255, 0, 51]);
    meshes[0].attributes.colors = Some(vec![green; meshes[0].positions.len()]);
    let around = (Some(&scan), scan.around());
    scene.draw(&meshes, around, size(), &job).unwrap().0.pixel(40, 40)
}

#[test]
fn vertices_have_their_colours_unless_the_surface_is_cut_from_a_texture() {
    let skin = look("skin", 0.0, RED, 0.5);
    // Through two walls, each of a fifth of a half.
    assert_near(middle(skin.clone(), None), [0.0, 0.19, 0.0], 0.19);
    let texture = SolidTexture::new(Pattern::Checker, [BLUE, BLUE], 3.0).unwrap();
    let carved = SurfaceLook { texture: Some(texture), ..skin };
    assert_near(middle(carved, None), [0.0, 0.0, 0.75], 0.75);
}

#[test]
fn a_cap_has_the_colour_of_the_surface() {
    let skin = look("skin", 0.0, RED, 1.0);
    assert_near(middle(skin, Some(CapStyle::Solid)), RED, 1.0);
}

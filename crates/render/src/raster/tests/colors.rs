//! Surfaces in the colours of their vertices, against what is linear in space and against surfaces of one colour.

use super::{PARALLEL, PERSPECTIVE, PLAIN, ball, camera, painted, picture, size};
use crate::{
    Channel, Image,
    raster::{Paint, Painted, RasterOptions, rasterize},
};
use isokit_geom::{HalfSpace, vector::Vector};
use isokit_job::{Job, Threads};
use isokit_mesh::{Positions, Rgba, TriMesh};
use std::num::NonZeroUsize;

fn triangle(corners: [Vector; 3]) -> TriMesh {
    let positions = Positions::F64(corners.to_vec());
    TriMesh { positions, triangles: vec![[0, 1, 2]], ..TriMesh::default() }
}

/// Around the origin, across the view along y.
fn flat() -> TriMesh {
    triangle([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 2.0]])
}

/// A surface in the colours of its vertices.
fn of_vertices<'a>(mesh: &'a TriMesh, colors: &'a [Rgba]) -> Painted<'a> {
    Painted { paint: Paint::Vertices(colors), ..painted(mesh, [0.0; 3], 1.0) }
}

/// A colour of each vertex of a mesh, of one opacity or of many.
fn motley(mesh: &TriMesh, opacity: Option<u8>) -> Vec<Rgba> {
    let code = |place: f64| (127.5 + 120.0 * place) as u8;
    let color = |[x, y, z]: Vector| {
        let [r, g, b] = [x, y, z].map(code);
        Rgba([r, g, b, opacity.unwrap_or(code(x * z))])
    };
    mesh.positions.iter().map(color).collect()
}

/// Light from a side, and what is in its way.
fn in_shadow() -> RasterOptions {
    RasterOptions::DEFAULT.with_light_from(Some([1.0, -1.0, 2.0]), true)
}

#[test]
fn in_the_middle_of_three_colours_is_their_mean_in_linear_light() {
    let colors = [[255, 0, 9, 255], [0, 200, 50, 255], [30, 100, 250, 255]].map(Rgba);
    let (mesh, camera) = (flat(), camera([0.0, -5.0, 0.0], PARALLEL));
    let (image, _) = picture(&[of_vertices(&mesh, &colors)], (&camera, size(61, 61)), &PLAIN);
    let middle = image.pixel(30, 30);
    for part in 0..3 {
        let mean = colors.iter().map(|color| color.to_linear()[part]).sum::<f32>() / 3.0;
        assert!((middle.color[part] - mean).abs() < 1e-6, "{middle:?}, part {part}: {mean}");
    }
    assert_eq!(middle.opacity, 1.0);
}

#[test]
fn colours_are_linear_in_space_from_anywhere_and_where_a_plane_cuts() {
    let mesh = triangle([[-1.0, -1.0, -1.0], [1.0, 2.0, -1.0], [-1.0, 3.0, 1.0]]);
    let colors = [[0, 0, 0, 255], [0, 255, 0, 255], [255, 0, 0, 255]].map(Rgba);
    let linear = |[x, _, z]: Vector| [(0.5 * z + 0.5) as f32, (0.5 * x + 0.5) as f32, 0.0];
    let clip = [HalfSpace::new([1.0, 0.2, 0.3], 0.1).unwrap()];
    for (projection, clips) in
        [(PARALLEL, &[][..]), (PERSPECTIVE, &[]), (PERSPECTIVE, &clip), (PARALLEL, &clip)]
    {
        let camera = camera([1.0, -3.0, 0.7], projection);
        let surface = Painted { clips, ..of_vertices(&mesh, &colors) };
        let expected = Painted { paint: Paint::Solid(&linear), ..surface };
        let look = |surface| picture(&[surface], (&camera, size(90, 80)), &PLAIN).0;
        let (found, expected) = (look(surface), look(expected));
        let mut seen = 0;
        for (found, expected) in found.pixels().iter().zip(expected.pixels()) {
            assert_eq!(found.opacity, expected.opacity);
            let is_near = (0..3).all(|n| (found.color[n] - expected.color[n]).abs() < 1e-6);
            assert!(is_near, "{found:?}, {expected:?}");
            seen += usize::from(found.opacity > 0.0);
        }
        assert!(seen > 200, "{seen}");
    }
}

#[test]
fn vertices_of_one_colour_are_the_picture_of_that_colour_to_the_bit() {
    let ball = ball([0.0; 3], 1.0, 24);
    let view = camera([1.0, -4.0, 0.7], PERSPECTIVE);
    let clips = [HalfSpace::new([0.3, -1.0, 0.2], 0.6).unwrap()];
    for color in [[216, 165, 128, 255], [7, 200, 31, 128], [255, 255, 255, 255]].map(Rgba) {
        let [r, g, b, opacity] = color.to_linear();
        let colors = vec![color; ball.positions.len()];
        for options in [RasterOptions::DEFAULT, PLAIN, in_shadow()] {
            let look = |surface| {
                picture(&[Painted { clips: &clips, ..surface }], (&view, size(70, 70)), &options)
            };
            let found = look(of_vertices(&ball, &colors));
            let expected = look(painted(&ball, [r, g, b], opacity));
            assert!(found == expected, "{color:?}, {options:?}");
        }
    }
}

#[test]
fn opacity_of_vertices_is_a_share_of_the_surfaces() {
    let (mesh, camera) = (flat(), camera([0.0, -5.0, 0.0], PARALLEL));
    let wall = triangle([[-9.0, 1.0, -9.0], [9.0, 1.0, -9.0], [0.0, 1.0, 9.0]]);
    let wall = painted(&wall, [0.0, 0.0, 1.0], 1.0);
    let colors = [[255, 0, 0, 255], [255, 0, 0, 102], [255, 0, 0, 0]].map(Rgba);
    for opacity in [1.0, 0.5] {
        let front = Painted { opacity, ..of_vertices(&mesh, &colors) };
        for surfaces in [[front, wall], [wall, front]] {
            let middle = picture(&surfaces, (&camera, size(61, 61)), &PLAIN).0.pixel(30, 30);
            // A share of the mean of 1, 0.4 and 0.
            let share = opacity * 1.4 / 3.0;
            assert!((middle.color[0] - share).abs() < 1e-6, "{middle:?}");
            assert!((middle.color[2] - (1.0 - share)).abs() < 1e-6, "{middle:?}");
        }
    }
}

#[test]
fn depths_and_normals_do_not_ask_for_colours() {
    let ball = ball([0.0; 3], 1.0, 24);
    let (colors, view) = (motley(&ball, None), camera([1.0, -4.0, 0.7], PERSPECTIVE));
    for channel in [Channel::Depth, Channel::Normal] {
        let options = RasterOptions::DEFAULT.with_channel(channel);
        let look = |surface| picture(&[surface], (&view, size(60, 60)), &options);
        assert!(look(of_vertices(&ball, &colors)) == look(painted(&ball, [0.3; 3], 1.0)));
    }
}

#[test]
fn colours_of_vertices_are_the_same_for_any_number_of_threads() {
    let (inner, outer) = (ball([0.0; 3], 0.8, 30), ball([0.2, 0.0, 0.1], 1.0, 40));
    let (opaque, translucent) = (motley(&inner, Some(255)), motley(&outer, None));
    let surfaces = [of_vertices(&outer, &translucent), of_vertices(&inner, &opaque)];
    let view = camera([1.0, -4.0, 0.7], PERSPECTIVE);
    let look = |threads| -> Image {
        let threads = Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap();
        let job = Job { threads, ..Job::default() };
        rasterize(&surfaces, &[], (&view, size(150, 130)), &in_shadow(), &job).unwrap().0
    };
    let one = look(1);
    assert!(look(2) == one && look(7) == one);
}

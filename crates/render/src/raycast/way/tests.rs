//! Ways are what a volume and planes leave of the camera's rays.

use super::{Pixel, Ways};
use crate::{Camera, Cast, Medium, OpticalModel, Projection, Ray, Size, TransferFunction};
use isokit_geom::{
    Affine, Frame, HalfSpace,
    vector::{Vector, dot},
};
use isokit_volume::{Grid, Volume};
use std::num::NonZeroU32;

const DIMS: [u64; 3] = [9, 14, 6];
const STEP: f64 = 0.37;

fn size(width: u32, height: u32) -> Size {
    let [width, height] = [width, height].map(|n| NonZeroU32::new(n).unwrap());
    Size { width, height }
}

fn model() -> OpticalModel {
    TransferFunction::new(vec![crate::ControlPoint::new(0.0, "#ffffffff".parse().unwrap())])
        .unwrap()
        .into()
}

/// From which distance of a ray to which all of these hold: that a number, which changes evenly, is not above 0.
fn where_all_hold(numbers: impl Iterator<Item = [f64; 2]>) -> Option<[f64; 2]> {
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for [at_origin, along] in numbers {
        match along.total_cmp(&0.0) {
            _ if along == 0.0 && at_origin > 0.0 => return None,
            _ if along == 0.0 => {}
            std::cmp::Ordering::Less => near = near.max(-at_origin / along),
            _ => far = far.min(-at_origin / along),
        }
    }
    (near < far).then_some([near, far])
}

fn kept(ray: &Ray, affine: &Affine, clips: &[HalfSpace]) -> Option<[f64; 2]> {
    let (origin, direction) =
        (affine.inverse_point(ray.origin), affine.inverse_vector(ray.direction));
    let faces = (0..3).flat_map(|k| {
        let last = DIMS[k] as f64 - 1.0;
        [[-origin[k], -direction[k]], [origin[k] - last, direction[k]]]
    });
    let planes =
        clips.iter().map(|clip| [clip.beyond(ray.origin), dot(clip.normal(), ray.direction)]);
    where_all_hold(faces.chain(planes))
}

fn assert_near(found: Vector, wanted: Vector) {
    for k in 0..3 {
        assert!((found[k] - wanted[k]).abs() < 1e-9, "{found:?} for {wanted:?}");
    }
}

#[test]
fn ways_are_what_a_volume_and_planes_leave_of_the_cameras_rays() {
    let oblique = [[0.9, 0.1, -0.2], [-0.3, 0.7, 0.2], [0.1, -0.4, 1.3]];
    let affines = [
        Affine::axis_aligned([1.0; 3], [0.0; 3]).unwrap(),
        Affine::axis_aligned([0.4, 0.5, 2.0], [-7.0, 12.0, 3.0]).unwrap(),
        Affine::new(oblique, [10.0, -20.0, 5.0]).unwrap(),
    ];
    let projections =
        [Projection::Parallel { height: 22.0 }, Projection::Perspective { fov: 40.0 }];
    // Along an axis of the grid, where lines lie in faces of the box, and aslant; from outside and from within.
    let froms = [[4.0, 6.5, -30.0], [40.0, -9.0, 17.0], [4.5, 6.0, 2.0]];
    let (model, mut through, mut beside) = (model(), 0, 0);
    for affine in affines {
        let frame = Frame { index_to_world: affine, ..Frame::default() };
        let grid = Grid::new(DIMS, frame).unwrap();
        let volume = Volume::new(grid, vec![0_u8; grid.count() as usize]).unwrap();
        let view = volume.view();
        let at = affine.point([4.0, 6.5, 2.5]);
        let planes = [[0.3, -0.2, 1.0], [-1.0, 0.1, 0.0]];
        let clips = planes.map(|normal| HalfSpace::new(normal, dot(normal, at) + 0.8).unwrap());
        let cases = froms.iter().flat_map(|from| projections.map(|projection| (from, projection)));
        for ((from, projection), clips) in
            cases.flat_map(|case| [&[][..], &clips[..1], &clips[..]].map(|clips| (case, clips)))
        {
            let camera =
                Camera::new(affine.point(*from), at, affine.vector([0.0, 1.0, 0.0]), projection);
            let (camera, size) = (camera.unwrap(), size(21, 10));
            let medium = Medium { view: &view, bricks: None, model: &model, clips };
            let ways = Ways::new(&medium, (&camera, size), (STEP, None)).unwrap();
            let pixels: Vec<_> = (0..21 * 10)
                .map(|number| Pixel {
                    number,
                    place: [(number % 21) as f64 + 0.5, (number / 21) as f64 + 0.5],
                    begin: (number % 4) as f64 / 4.0,
                })
                .collect();
            let mut sights = ways.of(pixels.iter().copied());
            let mut found = vec![None; pixels.len()];
            while let Some((number, way)) = sights.next(&mut Cast::default()) {
                assert!(found[number].replace(way).is_none(), "twice at {number}");
            }
            for (pixel, found) in pixels.iter().zip(found) {
                let ray = camera.pixel_ray(size, pixel.place);
                let wanted = kept(&ray, &affine, clips);
                // What is nearly nothing may be nothing for one of them.
                let length = wanted.map_or(0.0, |[near, far]| far - near);
                let Some(way) = found else {
                    assert!(length < 1e-9, "{length} is lost of {pixel:?}");
                    beside += 1;
                    continue;
                };
                assert!(((way.before + way.steps) * STEP - length).abs() < 1e-9, "{pixel:?}");
                assert!(way.before <= pixel.begin && way.steps >= 0.0, "{pixel:?}");
                let Some([near, _]) = wanted else { continue };
                let point = |steps: f64| -> Vector {
                    let along = near + (way.before + steps) * STEP;
                    std::array::from_fn(|k| ray.origin[k] + along * ray.direction[k])
                };
                assert_near(affine.point(way.start), point(0.0));
                assert_near(affine.point(way.at(way.steps)), point(way.steps));
                assert_near(way.towards, ray.direction);
                let whole = std::array::from_fn(|k| way.pace[k] * way.step[k].abs());
                assert_near(whole.map(|c: f64| if c.is_nan() { 1.0 } else { c.abs() }), [1.0; 3]);
                through += 1;
            }
        }
    }
    assert!(through > 1000 && beside > 1000, "{through} and {beside}");
}

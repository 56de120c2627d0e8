//! What a camera shows of boxes, places and bodies.

use super::{Camera, CameraError, Projection, Ray, Side};
use isokit_geom::{
    Aabb, Space,
    vector::{Vector, cross, dot, length, sub},
};

const WAYS: [Option<f64>; 3] = [None, Some(30.0), Some(100.0)];

fn bounds() -> Aabb {
    Aabb { min: [-3.0, 10.0, 2.0], max: [5.0, 11.0, 20.0] }
}

/// Where a place is in the picture: as far as the ray of which point goes by it.
fn seen(camera: &Camera, place: Vector) -> [f64; 2] {
    let middle = camera.ray([0.0; 2]);
    let point = |axis: usize| -> [f64; 2] { std::array::from_fn(|k| f64::from(k == axis)) };
    let aside = |axis: usize| camera.ray(point(axis));
    let from = sub(place, camera.from());
    match camera.projection() {
        Projection::Parallel { .. } => [0, 1].map(|axis| {
            let step = sub(aside(axis).origin, middle.origin);
            dot(from, step) / dot(step, step)
        }),
        Projection::Perspective { .. } => [0, 1].map(|axis| {
            let direction = aside(axis).direction;
            let ahead = dot(direction, camera.forward());
            let step: Vector = std::array::from_fn(|k| direction[k] / ahead - camera.forward()[k]);
            dot(from, step) / dot(step, step) / dot(from, camera.forward())
        }),
    }
}

#[test]
fn a_framed_box_fills_the_picture_and_stays_within() {
    for fov in WAYS {
        for aspect in [0.5, 1.0, 2.0] {
            for forward in [[0.0, 1.0, 0.0], [-1.0, 0.3, 0.2], [0.1, 0.1, -2.0]] {
                let up = if forward[2] < -1.0 { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
                let camera = Camera::framing(bounds(), (forward, up), fov, aspect).unwrap();
                let corners = bounds().corners().map(|corner| seen(&camera, corner));
                let most = corners
                    .iter()
                    .fold(0.0_f64, |most, [x, y]| most.max(x.abs() / aspect).max(y.abs()));
                assert!((0.93..0.9401).contains(&most), "{fov:?}, {aspect}, {forward:?}: {most}");
            }
        }
    }
}

#[test]
fn a_box_that_turns_fills_the_picture_at_its_widest_and_stays_within() {
    for fov in WAYS {
        for aspect in [0.2, 1.0, 2.0] {
            for forward in [[0.0, 1.0, 0.0], [-1.0, 0.3, 0.2]] {
                let directions = (forward, [0.0, 0.0, 1.0]);
                let camera = Camera::framing_turns(bounds(), directions, fov, aspect).unwrap();
                let steps = (0..720).map(|step| f64::from(step) / 2.0);
                let most = steps.fold(0.0_f64, |most, degrees| {
                    // The box turns around what is up in the picture, the camera stays.
                    let (sine, cosine) = degrees.to_radians().sin_cos();
                    let middle = [1.0, 10.5, 11.0];
                    let up = camera.up();
                    let corners = bounds().corners().map(|corner| {
                        let from = sub(corner, middle);
                        let (aside, along) = (cross(up, from), dot(up, from));
                        let place = |k: usize| {
                            middle[k]
                                + up[k] * along
                                + (from[k] - up[k] * along) * cosine
                                + aside[k] * sine
                        };
                        seen(&camera, std::array::from_fn(place))
                    });
                    corners
                        .iter()
                        .fold(most, |most, [x, y]| most.max(x.abs() / aspect).max(y.abs()))
                });
                assert!((0.9395..0.9401).contains(&most), "{fov:?}, {aspect}, {forward:?}: {most}");
            }
        }
    }
}

#[test]
fn a_frustum_is_what_a_picture_shows() {
    let (mut shown, mut state) = (0, 9_u64);
    for fov in WAYS {
        for aspect in [0.4, 1.0, 3.0] {
            let directions = ([1.0, 2.0, -0.5], [0.0, 0.0, 1.0]);
            let camera = Camera::framing(bounds(), directions, fov, aspect).unwrap();
            let frustum = camera.frustum(aspect);
            for _ in 0..2000 {
                let place = [0, 1, 2].map(|k| {
                    state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
                    let part = (state >> 40) as f64 / (1 << 24) as f64;
                    camera.from()[k] + 40.0 * (2.0 * part - 1.0) + 20.0 * camera.forward()[k]
                });
                let [x, y] = seen(&camera, place);
                let is_ahead = dot(sub(place, camera.from()), camera.forward()) >= 0.0;
                let is_shown = is_ahead && x.abs() <= aspect && y.abs() <= 1.0;
                assert_eq!(frustum.iter().all(|half| half.keeps(place)), is_shown, "{place:?}");
                shown += u32::from(is_shown);
            }
        }
    }
    assert!((1000..9000).contains(&shown), "{shown}");
}

#[test]
fn rays_are_of_length_one_and_lead_to_what_they_show() {
    for fov in WAYS {
        let camera =
            Camera::framing(bounds(), ([1.0, 2.0, -0.5], [0.0, 0.0, 1.0]), fov, 1.5).unwrap();
        for point in [[0.0, 0.0], [1.5, -1.0], [-0.7, 0.9]] {
            let Ray { origin, direction } = camera.ray(point);
            assert!((length(direction) - 1.0).abs() < 1e-14);
            let far = std::array::from_fn(|k| origin[k] + 37.0 * direction[k]);
            let off =
                sub([seen(&camera, far)[0], seen(&camera, far)[1], 0.0], [point[0], point[1], 0.0]);
            assert!(length(off) < 1e-12, "{fov:?}, {point:?}: {off:?}");
        }
    }
}

#[test]
fn the_upper_edge_is_half_of_the_angle_or_of_the_height_away() {
    let new = |projection| Camera::new([0.0; 3], [0.0, 5.0, 0.0], [0.0, 0.0, 1.0], projection);
    let perspective = new(Projection::Perspective { fov: 50.0 }).unwrap();
    let cosine = dot(perspective.ray([0.0, 1.0]).direction, perspective.forward());
    assert!((cosine.acos().to_degrees() - 25.0).abs() < 1e-9);
    let parallel = new(Projection::Parallel { height: 8.0 }).unwrap();
    assert_eq!(parallel.ray([0.0, 1.0]).origin, [0.0, 0.0, 4.0]);
}

#[test]
fn seen_from_a_side_the_body_is_the_right_way_around() {
    for space in [Space::Ras, Space::Lps] {
        // Where the body's right, front and head are.
        let flip = if space == Space::Lps { -1.0 } else { 1.0 };
        let (right, front, head) = ([flip, 0.0, 0.0], [0.0, flip, 0.0], [0.0, 0.0, 1.0]);
        for (side, towards, up, leftmost) in [
            (Side::Anterior, front, head, Some(right)),
            (Side::Posterior, front.map(|c: f64| -c), head, Some(right.map(|c: f64| -c))),
            (Side::Right, right, head, Some(front.map(|c: f64| -c))),
            (Side::Left, right.map(|c: f64| -c), head, Some(front)),
            (Side::Superior, head, front, Some(right.map(|c: f64| -c))),
            (Side::Inferior, head.map(|c: f64| -c), front, Some(right)),
        ] {
            let camera = Camera::framing(bounds(), side.directions(space), None, 1.0).unwrap();
            assert_eq!(dot(camera.forward(), towards), -1.0, "{side:?}: it looks back at the body");
            let above: Vector = std::array::from_fn(|k| camera.from()[k] + up[k]);
            assert!(seen(&camera, above)[1] > 0.0, "{side:?}, {space:?}: up");
            if let Some(leftmost) = leftmost {
                let left: Vector = std::array::from_fn(|k| camera.from()[k] + leftmost[k]);
                assert!(seen(&camera, left)[0] < 0.0, "{side:?}, {space:?}: left in the picture");
            }
        }
    }
}

#[test]
fn an_orbit_keeps_its_distance_and_comes_back() {
    for fov in WAYS {
        let at = [1.0, 10.5, 11.0];
        let camera =
            Camera::framing(bounds(), ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0]), fov, 1.0).unwrap();
        for degrees in [0.0, 10.0, 90.0, 359.0] {
            let turned = camera.orbited(degrees);
            let [before, after] = [camera, turned].map(|camera| sub(camera.from(), at));
            assert!((length(before) - length(after)).abs() < 1e-12 * length(before));
            let angle = cross(before, after)[2].atan2(dot(before, after)).to_degrees();
            let off = (angle - degrees + 180.0).rem_euclid(360.0) - 180.0;
            assert!(off.abs() < 1e-9, "{angle} for {degrees}");
            // What it looks at stays in the middle.
            let [x, y] = seen(&turned, at);
            assert!(x.abs() + y.abs() < 1e-12, "{x}, {y}");
        }
    }
}

#[test]
fn what_is_no_camera_is_refused() {
    let parallel = Projection::Parallel { height: 1.0 };
    let new = |at, up, projection| Camera::new([0.0; 3], at, up, projection).unwrap_err();
    let up = [0.0, 0.0, 1.0];
    assert_eq!(new([0.0; 3], up, parallel), CameraError::NoDirection);
    assert_eq!(new([0.0, 0.0, 5.0], up, parallel), CameraError::NoUp);
    assert_eq!(new([1.0, 0.0, 0.0], [0.0; 3], parallel), CameraError::NoUp);
    assert_eq!(new([f64::NAN, 0.0, 0.0], up, parallel), CameraError::NotFinite);
    for projection in [
        Projection::Parallel { height: 0.0 },
        Projection::Perspective { fov: 180.0 },
        Projection::Perspective { fov: -3.0 },
    ] {
        assert_eq!(new([1.0, 0.0, 0.0], up, projection), CameraError::NoExtent);
    }
    let point = Aabb { min: [1.0; 3], max: [1.0; 3] };
    for fov in WAYS {
        let framed = Camera::framing(point, ([0.0, 1.0, 0.0], up), fov, 1.0);
        assert_eq!(framed, Err(CameraError::NoExtent));
    }
}

//! Every ray through a block of which something is seen goes through it where the picture's tiles say.

use super::Seen;
use crate::{
    Camera, ControlPoint, Projection, Size, TransferFunction,
    clear::{Around, CELLS, Clear},
    transfer::Lookup,
};
use isokit_geom::{Affine, vector::length};
use isokit_job::{Job, Threads};
use isokit_volume::{Bricks, Grid, Volume};
use std::num::{NonZeroU32, NonZeroUsize};

/// A volume of zeros but for the samples given, of which alone something is seen.
fn clear(dims: [u64; 3], ones: &[[u64; 3]]) -> Clear {
    let grid = Grid::new(dims, Default::default()).unwrap();
    let mut samples = vec![0_u8; grid.count() as usize];
    for [i, j, k] in ones {
        samples[(i + dims[0] * (j + dims[1] * k)) as usize] = 255;
    }
    let volume = Volume::new(grid, samples).unwrap();
    let point = |value: f64, rgba: &str| ControlPoint::new(value, rgba.parse().unwrap());
    let points = vec![point(100.0, "#ffffff00"), point(200.0, "#ffffffff")];
    let model = TransferFunction::new(points).unwrap().into();
    let (view, job) = (volume.view(), Job::default());
    let bricks = Bricks::of(&view, &job).unwrap();
    Clear::new(&view, &bricks, (&Lookup::new(&model, 1.0, 1.0), Around::default()), &job).unwrap()
}

fn blocks(clear: &Clear) -> impl Iterator<Item = [usize; 3]> {
    (0..clear.counts()[2]).flat_map(|z| clear.seen(z))
}

fn size(width: u32, height: u32) -> Size {
    let [width, height] = [width, height].map(|n| NonZeroU32::new(n).unwrap());
    Size { width, height }
}

fn seen(clear: &Clear, affine: &Affine, camera: (&Camera, Size)) -> Option<Seen> {
    Seen::new((clear, affine), camera, &Job::default()).unwrap()
}

fn chance() -> impl FnMut(u64) -> u64 {
    let mut state = 5_u64;
    move |below| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
        (state >> 40) % below
    }
}

/// Between which distances the ray through the middle of a pixel is in a block.
fn within(
    block: [usize; 3],
    affine: &Affine,
    (camera, size): (&Camera, Size),
    place: [f64; 2],
) -> Option<[f64; 2]> {
    let ray = camera.pixel_ray(size, place);
    let (origin, direction) =
        (affine.inverse_point(ray.origin), affine.inverse_vector(ray.direction));
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for k in 0..3 {
        let ends =
            [block[k], block[k] + 1].map(|n| ((n * CELLS) as f64 - origin[k]) / direction[k]);
        near = near.max(ends[0].min(ends[1]));
        far = far.min(ends[0].max(ends[1]));
    }
    (near < far).then_some([near, far])
}

fn affines() -> [Affine; 3] {
    let oblique = [[0.9, 0.1, -0.2], [-0.3, 0.7, 0.2], [0.1, -0.4, 1.3]];
    [
        Affine::axis_aligned([1.0; 3], [0.0; 3]).unwrap(),
        Affine::axis_aligned([0.4, 0.5, 2.0], [-7.0, 1e6, 3.0]).unwrap(),
        Affine::new(oblique, [100.0, -20.0, 5.0]).unwrap(),
    ]
}

#[test]
fn rays_go_through_what_may_be_seen_between_the_distances_of_their_tiles() {
    let (dims, mut chance) = ([45, 30, 52], chance());
    let (mut through, mut beside, mut kept_out) = (0, 0, 0);
    for (round, affine) in (0..48).zip(affines().iter().cycle()) {
        // Samples between blocks belong to several.
        let ones: Vec<_> = (0..round % 7).map(|_| dims.map(&mut chance)).collect();
        let clear = clear(dims, &ones);
        let mut turn = || chance(2001) as f64 / 1000.0 - 1.0;
        let middle = affine.point(dims.map(|n| 0.5 * (n - 1) as f64));
        let away = [turn(), turn(), turn()];
        let distance = 100.0 / length(away);
        let from = [0, 1, 2].map(|k| middle[k] + distance * away[k]);
        let at = middle.map(|c| c + 9.0 * turn());
        let projection = match round % 2 {
            0 => Projection::Parallel { height: 40.0 },
            _ => Projection::Perspective { fov: 30.0 },
        };
        let camera = Camera::new(from, at, [0.1, 0.9, 0.3], projection).unwrap();
        // Tiles at the right and lower border are not whole.
        let size = [size(64, 40), size(37, 51), size(5, 3)][round % 3];
        let tiles = seen(&clear, affine, (&camera, size)).unwrap();
        for threads in [1, 2, 7] {
            let job = Job {
                threads: Threads::new(NonZeroUsize::new(threads).unwrap()).unwrap(),
                ..Job::default()
            };
            let again = Seen::new((&clear, affine), (&camera, size), &job).unwrap();
            assert!(again.as_ref() == Some(&tiles), "{threads} threads");
        }
        let pixels =
            (0..size.height.get()).flat_map(|y| (0..size.width.get()).map(move |x| [x, y]));
        for place in pixels.map(|pixel| pixel.map(|n| f64::from(n) + 0.5)) {
            let found = tiles.at(place);
            let mut is_through = false;
            for block in blocks(&clear) {
                let Some([near, far]) = within(block, affine, (&camera, size), place) else {
                    continue;
                };
                let [from, to] = found.unwrap();
                assert!(from <= near && far <= to, "{near} to {far} of {from} to {to}");
                is_through = true;
            }
            through += u32::from(is_through);
            beside += u32::from(!is_through);
            kept_out += u32::from(found.is_none());
        }
    }
    assert!(through > 500, "{through}");
    assert!(2 * kept_out > beside, "{kept_out} of {beside}");
}

#[test]
fn a_tile_with_one_block_is_little_longer_than_the_block() {
    let affine = affines()[0];
    let clear = clear([45; 3], &[[22; 3]]);
    assert_eq!(blocks(&clear).collect::<Vec<_>>(), [[5; 3]]);
    for projection in [Projection::Parallel { height: 50.0 }, Projection::Perspective { fov: 60.0 }]
    {
        let camera =
            Camera::new([22.0, 22.0, -40.0], [22.0; 3], [0.0, 1.0, 0.0], projection).unwrap();
        let tiles = seen(&clear, &affine, (&camera, size(64, 64))).unwrap();
        let [near, far] = tiles.at([31.5, 31.5]).unwrap();
        assert!((56.0..=60.0).contains(&near) && (64.0..=68.0).contains(&far), "{near} to {far}");
        assert_eq!(tiles.at([0.5, 31.5]), None);
        assert_eq!(tiles.at([31.5, 63.5]), None);
    }
}

#[test]
fn nothing_is_in_the_picture_where_nothing_is_seen() {
    let clear = clear([20; 3], &[]);
    let camera = Camera::new(
        [-30.0, 10.0, 9.0],
        [10.0; 3],
        [0.0, 0.0, 1.0],
        Projection::Perspective { fov: 50.0 },
    );
    let tiles = seen(&clear, &affines()[0], (&camera.unwrap(), size(30, 30))).unwrap();
    assert!((0..30).all(|n| tiles.at([f64::from(n) + 0.5; 2]).is_none()));
}

#[test]
fn what_is_beside_the_camera_or_behind_it_has_no_place_in_a_picture() {
    let clear = clear([45; 3], &[[22; 3]]);
    let affine = affines()[0];
    let perspective = Projection::Perspective { fov: 60.0 };
    let tiles = |from: [f64; 3], at: [f64; 3], projection| {
        let camera = Camera::new(from, at, [0.0, 1.0, 0.0], projection).unwrap();
        seen(&clear, &affine, (&camera, size(32, 32)))
    };
    assert_eq!(tiles([22.0; 3], [22.0, 22.0, 40.0], perspective), None);
    assert_eq!(tiles([10.0, 22.0, 22.0], [10.0, 22.0, 40.0], perspective), None);
    assert_eq!(tiles([22.0, 22.0, 40.0], [22.0, 22.0, 60.0], perspective), None);
    // Side by side rays begin where the camera is too, and what is behind is nearer than that.
    let parallel = Projection::Parallel { height: 50.0 };
    let behind = tiles([22.0, 22.0, 40.0], [22.0, 22.0, 60.0], parallel).unwrap();
    assert!(behind.at([16.5; 2]).unwrap()[1] < 0.0);
    // Where numbers end nothing is known.
    let huge = Projection::Parallel { height: 1e-307 };
    assert_eq!(tiles([22.0, 22.0, -40.0], [22.0; 3], huge), None);
}

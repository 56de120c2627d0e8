//! From places in the world to places in the picture.
//!
//! A place in the picture is in 1/256 of a pixel, as a whole number, so that it is exactly on one side of an edge or on
//! the other. Depth is a number that grows away from the camera and changes linearly across the picture: how much farther
//! ahead it is than what the camera looks at, in a perspective as a share of the distance. So it has the most digits
//! there.

use crate::{Camera, Projection, Ray, Size};
use isokit_geom::{
    HalfSpace,
    vector::{Vector, dot},
};

/// Parts of a pixel.
pub(super) const PARTS: i32 = 256;

/// Places farther aside than this, in pixels, are not numbered: triangles are cut there.
const ASIDE: f64 = (1 << 20) as f64;

/// Nearer to the eye of a perspective than this share of the distance to what it looks at nothing is seen.
const NEAR: f64 = 1e-6;

/// A vertex in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// To the right from the picture's left edge, and down from its top, in parts of a pixel.
    pub(super) place: [i32; 2],
    pub(super) depth: f32,
}

impl Seen {
    /// Stands for a vertex whose triangles need a closer look.
    pub(super) const CUT: Self = Self { place: [i32::MIN; 2], depth: 0.0 };

    pub(super) fn is_cut(self) -> bool {
        self.place[0] == i32::MIN
    }
}

/// How a camera fills a picture.
#[derive(Clone, Debug)]
pub(super) struct Viewport<'a> {
    camera: &'a Camera,
    pub(super) size: Size,
    is_parallel: bool,
    /// Pixels of what is 1 aside (and, in a perspective, 1 ahead).
    scale: f64,
    /// The middle of the picture, in pixels.
    middle: [f64; 2],
    /// How far ahead is what the camera looks at.
    distance: f64,
    /// How far ahead something is seen at least.
    near: f64,
    /// What can be placed in the picture, as the camera sees it.
    sides: Vec<HalfSpace>,
}

impl<'a> Viewport<'a> {
    pub(super) fn new(camera: &'a Camera, size: Size) -> Self {
        let middle = [size.width, size.height].map(|n| 0.5 * f64::from(n.get()));
        let scale = middle[1] * camera.magnification();
        let is_parallel = matches!(camera.projection(), Projection::Parallel { .. });
        let (near, aside) = match is_parallel {
            true => (0.0, ASIDE / scale),
            false => (NEAR * camera.distance(), 0.0),
        };
        let slope = if is_parallel { 0.0 } else { ASIDE / scale };
        let sides = [
            ([0.0, 0.0, -1.0], -near),
            ([1.0, 0.0, -slope], aside),
            ([-1.0, 0.0, -slope], aside),
            ([0.0, 1.0, -slope], aside),
            ([0.0, -1.0, -slope], aside),
        ];
        // A side where numbers end cuts nothing.
        let sides = sides.into_iter().filter_map(|(normal, offset)| half(normal, offset)).collect();
        let distance = camera.distance();
        Self { camera, size, is_parallel, scale, middle, distance, near, sides }
    }

    /// All that a surface is cut by, as the camera sees it.
    pub(super) fn cuts(&self, clips: &[HalfSpace]) -> Vec<HalfSpace> {
        let turned = |clip: &HalfSpace| {
            let offset = clip.offset() - dot(clip.normal(), self.camera.from());
            half(self.camera.turned(clip.normal()), offset)
        };
        self.sides.iter().copied().chain(clips.iter().filter_map(turned)).collect()
    }

    /// A place of the world as the camera sees it.
    #[inline(always)]
    pub(super) fn view(&self, place: Vector) -> Vector {
        self.camera.view(place)
    }

    /// Where in the picture something is that all sides keep.
    #[inline(always)]
    pub(super) fn seen(&self, place: Vector) -> Seen {
        let (place, depth) = self.pixels(place);
        Seen { place: place.map(parts), depth: depth as f32 }
    }

    /// The same in pixels, before it is rounded.
    #[inline(always)]
    pub(super) fn pixels(&self, [right, up, ahead]: Vector) -> ([f64; 2], f64) {
        let (scale, depth) = match self.is_parallel {
            true => (self.scale, ahead - self.distance),
            false => (self.scale / ahead, (ahead - self.distance) / ahead),
        };
        ([self.middle[0] + scale * right, self.middle[1] - scale * up], depth)
    }

    /// Whether something so far ahead is seen, if it is not aside.
    pub(super) fn is_ahead(&self, ahead: f64) -> bool {
        ahead >= self.near
    }

    /// How far aside, for each step ahead, the picture shows something at most; 0 if rays are side by side.
    pub(super) fn slope(&self) -> f64 {
        if self.is_parallel { 0.0 } else { self.middle[0].hypot(self.middle[1]) / self.scale }
    }

    /// Parts of a pixel that something so far ahead is moved by in the picture, if it is moved by 1 aside.
    pub(super) fn parts_of_one(&self, ahead: f64) -> f64 {
        let pixels = if self.is_parallel { self.scale } else { self.scale / ahead };
        pixels * f64::from(PARTS)
    }

    /// How far at most a place that is so far ahead, or nearer, is from where the picture has it, across and along rays:
    /// places in the picture are whole numbers, and depths have the digits of `f32`.
    pub(super) fn rounding(&self, [near, far]: [f64; 2]) -> f64 {
        let across = 1.0 / f64::from(PARTS) / self.scale;
        let digits = f64::from(f32::EPSILON);
        let along =
            [near, far].map(|ahead| (ahead - self.distance).abs()).into_iter().fold(0.0, f64::max);
        match self.is_parallel {
            true => across + digits * along,
            // A depth d is that of a place distance / (1 − d) ahead.
            false => far * across + digits * along * far / self.distance,
        }
    }

    /// The depth of a place along the ray of a point of the picture.
    pub(super) fn depth(&self, place: Vector) -> Option<f32> {
        let view = self.view(place);
        self.is_ahead(view[2]).then(|| self.seen(view).depth)
    }

    /// The ray of a point of the picture, in pixels from its upper left corner.
    pub(super) fn ray(&self, [x, y]: [f64; 2]) -> Ray {
        self.camera.pixel_ray(self.size, [x, y])
    }
}

fn half(normal: Vector, offset: f64) -> Option<HalfSpace> {
    HalfSpace::new(normal, offset).ok()
}

/// Parts of a pixel, to the nearest.
#[inline(always)]
fn parts(pixels: f64) -> i32 {
    // Made positive, so that to cut off is to round down.
    let up = 2.0 * ASIDE;
    ((pixels + up) * f64::from(PARTS) + 0.5) as i64 as i32 - (up * f64::from(PARTS)) as i32
}

//! What a picture shows of a surface where it is seen: its colour under a light, its normal, or how far ahead it is.
//!
//! What is in the way of light is known from pictures of depths, taken from where light comes from (Williams 1978,
//! "Casting curved shadows on curved surfaces"): one for the light itself, and for what comes from all around, the ambient
//! occlusion, one for each of many directions (Landis 2002, "Production-ready global illumination"). Only opaque surfaces
//! and caps are in the way.

use crate::{Camera, Gathered, Image, RasterOptions, Size};
use isokit_geom::{
    Aabb,
    vector::{Vector, dot, unit},
};
use std::num::NonZeroU32;

/// What pixels are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Colours under the light.
    #[default]
    Color,
    /// Unit vectors across the surface, towards the eye: to the right, up, and back to the eye. All that is seen is
    /// opaque.
    Normal,
    /// How far ahead of the camera the surface is, along where it looks, in world units, thrice. All that is seen is
    /// opaque.
    Depth,
}

/// All that surfaces of a picture have in common.
pub(crate) struct Shading<'a> {
    camera: &'a Camera,
    options: &'a RasterOptions,
    /// Where light comes from, if not from the eye.
    from: Option<Vector>,
    shadow: Option<Seen>,
    around: Vec<Seen>,
}

/// What light that comes from a side sees.
struct Seen {
    camera: Camera,
    /// Where it comes from: one long.
    from: Vector,
    image: Image,
    /// How wide a pixel is.
    pixel: f64,
}

/// Directions from which light comes from all around.
const DIRECTIONS: u32 = 64;

/// Pixels along each side of the pictures of depths: of those directions, and of the light.
const SIDES: [u32; 2] = [320, 2048];

impl<'a> Shading<'a> {
    /// For what is in a box, where `draw` makes pictures of depths.
    pub(crate) fn new<E>(
        camera: &'a Camera,
        options: &'a RasterOptions,
        bounds: Option<Aabb>,
        draw: impl Fn((&Camera, Size), &RasterOptions) -> Result<Image, E>,
    ) -> Result<Self, E> {
        let from = options.light_from.and_then(unit);
        let see = |from: Vector, side: u32| -> Result<Option<Seen>, E> {
            let up = if from[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [0.0, 1.0, 0.0] };
            let towards = from.map(|c| -c);
            // What has no extent is in nobody's way.
            let camera =
                bounds.and_then(|bounds| Camera::framing(bounds, (towards, up), None, 1.0).ok());
            let Some(camera) = camera else { return Ok(None) };
            let side = NonZeroU32::MIN.saturating_add(side - 1);
            let pixel = 2.0 * camera.half_height(1.0) / f64::from(side.get());
            // In pixels, which are numbers of f32 in whatever unit the world is.
            let depths = RasterOptions {
                channel: Channel::Depth,
                depth_unit: pixel,
                ..RasterOptions::PLAIN
            };
            let image = draw((&camera, Size { width: side, height: side }), &depths)?;
            Ok(Some(Seen { camera, from, image, pixel }))
        };
        let is_lit = options.light.is_some() && options.channel == Channel::Color;
        let shadow = match from {
            Some(from) if is_lit && options.shadows => see(from, SIDES[1])?,
            _ => None,
        };
        let mut around = vec![];
        if is_lit && options.occlusion > 0.0 {
            for from in (0..DIRECTIONS).map(direction) {
                around.extend(see(from, SIDES[0])?);
            }
        }
        Ok(Self { camera, options, from, shadow, around })
    }

    /// The colour of a surface across `normal` at a place, seen along `towards`, if its own is `color`.
    #[inline]
    pub(crate) fn color(
        &self,
        color: impl FnOnce() -> [f32; 3],
        normal: impl FnOnce() -> Vector,
        place: Vector,
        towards: Vector,
    ) -> [f32; 3] {
        match (self.options.channel, &self.options.light) {
            (Channel::Depth, _) => {
                let ahead = dot(self.camera.forward(), from_to(self.camera.from(), place));
                [(ahead / self.options.depth_unit) as f32; 3]
            }
            (Channel::Normal, _) => {
                let [right, up, ahead] = self.camera.turned(facing(normal(), towards));
                [right, up, -ahead].map(|c| c as f32)
            }
            (Channel::Color, None) => color(),
            (Channel::Color, Some(light)) => {
                let (color, normal) = (color(), normal());
                if self.from.is_none() && self.around.is_empty() {
                    return light.shade(color, normal, towards);
                }
                let normal = facing(normal, towards);
                let (from, is_lit) = match self.from {
                    Some(from) => {
                        (from, self.shadow.as_ref().map_or(1.0, |seen| seen.share(place, normal)))
                    }
                    None => (towards.map(|c| -c), 1.0),
                };
                let halfway = unit(from_to(towards, from)).unwrap_or(from);
                let [matt, gloss] = [dot(normal, from), dot(normal, halfway)]
                    .map(|cosine| cosine.clamp(0.0, 1.0) as f32);
                // A side that turns away from the light has no highlight.
                let gloss = if matt > 0.0 {
                    light.specular * gloss.powi(light.shininess.into())
                } else {
                    0.0
                };
                let open = self.open(place, normal);
                let matt = open * (light.ambient + light.diffuse * matt * is_lit);
                color.map(|part| (part * matt + open * is_lit * gloss).min(1.0))
            }
        }
    }

    /// A cap as the picture shows it.
    pub(crate) fn cap(
        &self,
        look: Gathered,
        normal: Vector,
        place: Vector,
        towards: Vector,
    ) -> Gathered {
        match self.options.channel {
            Channel::Color => look,
            _ => Gathered::new(self.color(|| look.straight(), || normal, place, towards), 1.0),
        }
    }

    /// How much hides what is behind it.
    pub(crate) fn opacity(&self, opacity: f32) -> f32 {
        match self.options.channel {
            Channel::Color => opacity.min(1.0),
            _ => 1.0,
        }
    }

    /// The share of light from all around that comes to a place.
    fn open(&self, place: Vector, normal: Vector) -> f32 {
        let (mut open, mut all) = (0.0, 0.0);
        for seen in &self.around {
            let cosine = dot(seen.from, normal);
            if cosine > 0.0 {
                all += cosine;
                open += if seen.sees(place, normal, [0, 0]) { cosine } else { 0.0 };
            }
        }
        let share = if all > 0.0 { (open / all) as f32 } else { 1.0 };
        1.0 - self.options.occlusion.min(1.0) * (1.0 - share)
    }
}

impl Seen {
    /// Whether light comes to a place, or to one so many pixels of the picture of depths beside it.
    fn sees(&self, place: Vector, normal: Vector, [right, down]: [i64; 2]) -> bool {
        // Far enough before the surface that it is not in its own way, where pixels are as large as they are.
        let place = std::array::from_fn(|k| place[k] + 1.5 * self.pixel * normal[k]);
        let [x, y, ahead] = self.camera.view(place);
        let size = self.image.size();
        let (width, height) = (i64::from(size.width.get()), i64::from(size.height.get()));
        let column = (0.5 * width as f64 + x / self.pixel).floor() as i64 + right;
        let row = (0.5 * height as f64 - y / self.pixel).floor() as i64 + down;
        if !(0..width).contains(&column) || !(0..height).contains(&row) {
            return true;
        }
        let first = self.image.pixel(column as u32, row as u32);
        first.opacity == 0.0 || ahead / self.pixel <= f64::from(first.color[0]) + 1.0
    }

    /// The share of light that comes to a place: between light and shadow a part of it.
    fn share(&self, place: Vector, normal: Vector) -> f32 {
        let around = (0..9).map(|n| [n % 3 - 1, n / 3 - 1]);
        around.filter(|beside| self.sees(place, normal, *beside)).count() as f32 / 9.0
    }
}

/// Directions that are spread evenly (the spiral of Fibonacci numbers: Swinbank & Purser 2006).
fn direction(n: u32) -> Vector {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let z = 1.0 - 2.0 * (f64::from(n) + 0.5) / f64::from(DIRECTIONS);
    let (sine, cosine) = (std::f64::consts::TAU * f64::from(n) / golden).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    [radius * cosine, radius * sine, z]
}

fn from_to(a: Vector, b: Vector) -> Vector {
    std::array::from_fn(|k| b[k] - a[k])
}

/// One long, and towards the eye; back to the eye where there is none.
fn facing(normal: Vector, towards: Vector) -> Vector {
    let away = if dot(normal, towards) > 0.0 { -1.0 } else { 1.0 };
    unit(normal).map_or(towards.map(|c| -c), |normal| normal.map(|c| away * c))
}

#[cfg(test)]
mod tests;

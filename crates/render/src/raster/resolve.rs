//! From what is seen at points to the colours of pixels.

use super::{
    Cap, Drawn, Paint, Painted,
    bins::Bins,
    screen::{PARTS, Viewport},
    tile::{NONE, TILE, Tile, key, triangle_of},
    tint::between,
};
use crate::{Gathered, Ray, gather::OPAQUE, shading::Shading};
use isokit_geom::vector::{Vector, cross, dot, normal, sub};

/// All that pixels have in common.
pub(super) struct Resolve<'a> {
    pub(super) surfaces: &'a [Painted<'a>],
    pub(super) caps: &'a [Cap<'a>],
    pub(super) view: &'a Viewport<'a>,
    pub(super) bins: &'a Bins<'a>,
    pub(super) shading: &'a Shading<'a>,
}

/// What of a pixel is known while its points are looked at.
#[derive(Default)]
struct Pixel {
    /// The triangles that were lit.
    lit: Vec<(u32, Gathered)>,
    /// What is seen at a point, if there are caps among it: keys, and how the caps look.
    layers: Vec<(u64, Option<Gathered>)>,
}

impl Resolve<'_> {
    /// Fills the pixels of a tile, row by row.
    pub(super) fn tile<'p>(
        &self,
        tile: &Tile,
        [column, row]: [usize; 2],
        rows: impl Iterator<Item = &'p mut [Gathered]>,
        drawn: &mut Drawn,
    ) {
        let mut known = Pixel::default();
        for (y, pixels) in rows.enumerate() {
            for (x, pixel) in pixels.iter_mut().enumerate() {
                let place = [column * TILE[0] + x, row * TILE[1] + y];
                *pixel = self.pixel(tile, y * TILE[0] + x, place, &mut known, drawn);
            }
        }
    }

    fn pixel(
        &self,
        tile: &Tile,
        number: usize,
        place: [usize; 2],
        known: &mut Pixel,
        drawn: &mut Drawn,
    ) -> Gathered {
        let count = tile.points().len();
        let points = number * count..(number + 1) * count;
        let is_empty = |point| tile.at(point) == (&[], NONE);
        if self.caps.is_empty() && points.clone().all(is_empty) {
            return Gathered::NOTHING;
        }
        let ray = self.view.ray(place.map(|n| n as f64 + 0.5));
        known.lit.clear();
        let mut sum = Gathered::NOTHING;
        for (point, part) in points.zip(tile.points()) {
            let (before, nearest) = tile.at(point);
            let mut gathered = Gathered::NOTHING;
            if self.caps.is_empty() {
                let all = before.iter().copied().chain((nearest != NONE).then_some(nearest));
                for (n, key) in all.enumerate() {
                    if gathered.opacity >= OPAQUE {
                        drawn.hidden += (before.len() - n) as u64;
                        break;
                    }
                    gathered = gathered.over(self.lit(triangle_of(key), &ray, known, drawn));
                }
            } else {
                let keys = before.iter().copied().chain((nearest != NONE).then_some(nearest));
                known.layers.clear();
                known.layers.extend(keys.map(|key| (key, None)));
                let place = [0, 1].map(|n| place[n] as f64 + f64::from(part[n]) / f64::from(PARTS));
                self.add_caps(place, &mut known.layers);
                for n in 0..known.layers.len() {
                    if gathered.opacity >= OPAQUE {
                        let behind = &known.layers[n..];
                        let translucent = behind.iter().filter(|&&(key, look)| {
                            look.is_none() && !self.bins.is_opaque(triangle_of(key))
                        });
                        drawn.hidden += translucent.count() as u64;
                        break;
                    }
                    let (key, look) = known.layers[n];
                    let next = match look {
                        Some(look) => look,
                        None => self.lit(triangle_of(key), &ray, known, drawn),
                    };
                    gathered = gathered.over(next);
                }
            }
            sum = sum.plus(gathered);
        }
        // By a power of two: exact.
        sum.times(1.0 / count as f32)
    }

    /// Puts what is seen of caps at a point among what is seen of surfaces.
    fn add_caps(&self, place: [f64; 2], layers: &mut Vec<(u64, Option<Gathered>)>) {
        let ray = self.view.ray(place);
        for (number, cap) in (0_u32..).zip(self.caps) {
            let Some((far, look)) = cap.along(&ray) else { continue };
            let place = std::array::from_fn(|k| ray.origin[k] + far * ray.direction[k]);
            // In front of a triangle of the same depth, which is the rim of the hole.
            let look = self.shading.cap(look, cap.half.normal(), place, ray.direction);
            let depth = self.view.depth(place);
            layers.extend(depth.map(|depth| (key(depth, number), Some(look))));
        }
        let depth = |key: u64| key >> u32::BITS;
        layers.sort_by_key(|&(key, look)| (depth(key), look.is_none(), key));
    }

    /// A triangle where the ray through the middle of a pixel meets it, or nearest to that.
    fn lit(&self, triangle: u32, ray: &Ray, known: &mut Pixel, drawn: &mut Drawn) -> Gathered {
        // What was lit last is often what comes next.
        if let Some((_, found)) = known.lit.iter().rev().find(|(lit, _)| *lit == triangle) {
            return *found;
        }
        drawn.lit += 1;
        let (surface, number) = self.bins.place(triangle);
        let Painted { mesh, paint, opacity, .. } = self.surfaces[surface];
        let vertices = mesh.triangles[number];
        let corners = mesh.corners(vertices);
        let shares = shares(corners, ray);
        let mix = |of: [Vector; 3]| -> Vector {
            std::array::from_fn(|k| (0..3).map(|n| shares[n] * of[n][k]).sum())
        };
        let place = mix(corners);
        let [r, g, b, share] = match paint {
            Paint::Vertices(colors) => between(colors, vertices, shares),
            Paint::Plain(_) | Paint::Solid(_) => [1.0; 4],
        };
        let color = || match paint {
            Paint::Plain(color) => color,
            Paint::Solid(color) => color(place),
            Paint::Vertices(_) => [r, g, b],
        };
        let across =
            || {
                let of = |normals: &[[f32; 3]], vertex: u32| normals.get(vertex as usize).copied();
                match &mesh.normals {
                    // One that is not there is 0: the others count.
                    Some(normals) => mix(vertices
                        .map(|vertex| of(normals, vertex).unwrap_or_default().map(f64::from))),
                    None => normal(corners),
                }
            };
        let color = self.shading.color(color, across, place, ray.direction);
        let found = Gathered::new(color, self.shading.opacity(opacity * share));
        known.lit.push((triangle, found));
        found
    }
}

/// How near to each corner a ray meets a triangle, from 0 to 1, and together 1 (Möller & Trumbore 1997, "Fast,
/// minimum storage ray-triangle intersection"). Beside the triangle: of a place on its rim.
fn shares(corners: [Vector; 3], ray: &Ray) -> [f64; 3] {
    let (first, second) = (sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    let across = cross(ray.direction, second);
    let determinant = dot(first, across);
    let from = sub(ray.origin, corners[0]);
    let u = dot(from, across) / determinant;
    let v = dot(ray.direction, cross(from, first)) / determinant;
    let shares = [1.0 - u - v, u, v].map(|share| share.max(0.0));
    let sum: f64 = shares.iter().sum();
    match sum.is_finite() && sum > 0.0 {
        true => shares.map(|share| share / sum),
        false => [1.0 / 3.0; 3], // seen from its edge
    }
}

#[cfg(test)]
mod tests {
    use super::shares;
    use crate::Ray;

    #[test]
    fn a_ray_meets_a_triangle_by_shares_of_its_corners() {
        let corners = [[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [0.0, 8.0, 5.0]];
        let at = |x, y| Ray { origin: [x, y, 0.0], direction: [0.0, 0.0, 1.0] };
        assert_eq!(shares(corners, &at(1.0, 4.0)), [0.25, 0.25, 0.5]);
        assert_eq!(shares(corners, &at(9.0, -1.0))[1], 1.0);
        let along = Ray { origin: [0.0; 3], direction: [1.0, 0.0, 0.0] };
        assert_eq!(shares(corners, &along), [1.0 / 3.0; 3]);
    }
}

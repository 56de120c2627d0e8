//! Pictures of meshes: any number of surfaces, opaque or translucent, cut by planes, with smooth edges.
//!
//! 1. Vertices are seen as the camera does (`screen.rs`): a place in the picture in 1/256 of a pixel, and a depth.
//! 2. Triangles are put into tiles of the picture (`bins.rs`). One that crosses a plane, or comes too near the
//!    camera, is cut first, in space (`cut.rs`).
//! 3. A tile finds for each of its points, several in a pixel, the nearest opaque triangle and all translucent ones
//!    before it (`tile.rs`). Whole numbers decide: two triangles with a common side never share a point of
//!    it, and leave none out. Triangles that lie behind all that is opaque in the tile are not looked at.
//! 4. What is seen at a point is sorted by depth, exactly, whatever the order of triangles (Carpenter 1984, "The
//!    A-buffer, an antialiased hidden surface method"), and gathered front to back; a pixel is the mean of its
//!    points (`resolve.rs`). Only what is seen is lit: once for each pixel and triangle.
//!
//! Triangles that meet at the same depth are in the order of their surfaces, and of their numbers within. Cells of
//! the mesh that intersect each other are sorted point by point too.

mod behind;
mod bins;
mod cut;
mod resolve;
mod screen;
mod tile;
mod tint;

use crate::{Camera, Channel, Gathered, Image, Light, Ray, Size, shading::Shading};
pub use behind::{are_behind, boxes_in_sight, hides_within};
use bins::Bins;
pub use cut::kept_bounds;
use isokit_geom::{
    Aabb, HalfSpace,
    vector::{Vector, dot},
};
use isokit_job::{Job, OverLimit, Stopped};
use isokit_lanes::exactly;
use isokit_mesh::{Rgba, TriMesh};
use rayon::prelude::*;
use resolve::Resolve;
use screen::Viewport;
use tile::{TILE, Tile};

/// A surface of a picture.
#[derive(Clone, Copy)]
pub struct Painted<'a> {
    /// Its triangles. Those that name a vertex that is not there, or is not finite, are left out.
    pub mesh: &'a TriMesh,
    /// Its colour.
    pub paint: Paint<'a>,
    /// How much of what is behind it one of its triangles hides, from 0 to 1.
    pub opacity: f32,
    /// What is kept of it: what is in all of these.
    pub clips: &'a [HalfSpace],
}

impl Painted<'_> {
    /// The same where no colour is asked for, and nothing shows through.
    fn whole(&self) -> Self {
        Self { paint: Paint::Plain([0.0; 3]), opacity: 1.0, ..*self }
    }

    /// Whether all of it hides what is behind it.
    fn is_opaque(&self) -> bool {
        let is_translucent = match self.paint {
            Paint::Vertices(colors) => colors.iter().any(|color| color.is_translucent()),
            Paint::Plain(_) | Paint::Solid(_) => false,
        };
        self.opacity >= 1.0 && !is_translucent
    }
}

/// The box around surfaces.
fn bounds(surfaces: &[Painted<'_>]) -> Option<Aabb> {
    let is_finite = |place: &&Vector| place.iter().all(|c| c.is_finite());
    Aabb::around(
        surfaces.iter().flat_map(|painted| painted.mesh.positions.iter()).filter(|p| is_finite(&p)),
    )
}

/// Which colour places have, in linear light, not multiplied by an opacity.
#[derive(Clone, Copy)]
pub enum Paint<'a> {
    /// One.
    Plain([f32; 3]),
    /// One of each place of the world, whatever the triangles: a solid texture (Peachey 1985, "Solid texturing of
    /// complex surfaces"; Perlin 1985, "An image synthesizer").
    Solid(&'a (dyn Fn(Vector) -> [f32; 3] + Sync)),
    /// One of each vertex of the mesh, by its number, and between them what is linear in light. Opacity is linear too, and
    /// a share of the surface's. What has no such vertex is white, as are surfaces without a mesh.
    Vertices(&'a [Rgba]),
}

/// What closes the hole that a plane cuts.
#[derive(Clone, Copy)]
pub struct Cap<'a> {
    /// The plane.
    pub half: HalfSpace,
    /// What is seen at a place on it: nothing outside of what was cut.
    pub look: &'a (dyn Fn(Vector) -> Gathered + Sync),
}

impl Cap<'_> {
    /// How far along a ray it is met, and what is seen there, if it is.
    pub(crate) fn along(&self, ray: &Ray) -> Option<(f64, Gathered)> {
        let far = -self.half.beyond(ray.origin) / dot(self.half.normal(), ray.direction);
        // Not of a plane that is seen from its edge.
        if !(far > 0.0 && far.is_finite()) {
            return None;
        }
        let look = (self.look)(std::array::from_fn(|k| ray.origin[k] + far * ray.direction[k]));
        (look.opacity > 0.0).then_some((far, look))
    }
}

/// How surfaces are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RasterOptions {
    /// How surfaces are lit; `None` leaves colours as they are. Changes the picture. Default: [`Light::DEFAULT`].
    pub light: Option<Light>,
    /// How many points of a pixel are looked at. Changes the edges of surfaces. Default: [`Smoothing::Four`].
    pub smoothing: Smoothing,
    /// What pixels are. Default: [`Channel::Color`].
    pub channel: Channel,
    /// Where light comes from, in the world; of any length above 0. Changes the picture. Default: `None`, from the eye.
    pub light_from: Option<Vector>,
    /// Whether opaque surfaces and caps are in the way of light that does not come from the eye. Changes the picture,
    /// and needs one more picture of what is seen. Default: false.
    pub shadows: bool,
    /// How much darker it is where what is opaque is in the way of light from all around: from 0 to 1, where places
    /// that see nothing but walls are dark. Changes the picture, and needs 64 small ones of what is seen. Default: 0.
    pub occlusion: f32,
    /// The unit of depths, in world units.
    pub(crate) depth_unit: f64,
}

/// How many points of a pixel are looked at: no two of them in a line with an edge of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Smoothing {
    /// Its middle: edges are jagged.
    None,
    /// Four, for displays.
    #[default]
    Four,
    /// Sixteen, for print.
    Sixteen,
}

impl RasterOptions {
    /// Whether the picture depends on the normals of surfaces.
    pub fn needs_normals(&self) -> bool {
        match self.channel {
            Channel::Color => self.light.is_some(),
            Channel::Normal => true,
            Channel::Depth => false,
        }
    }

    /// Whether the picture depends on surfaces beside it, which may be in the way of light.
    pub fn needs_surroundings(&self) -> bool {
        self.occlusion > 0.0 || self.shadows && self.light_from.is_some()
    }

    /// The defaults named above.
    pub const DEFAULT: Self =
        Self { light: Some(Light::DEFAULT), smoothing: Smoothing::Four, ..Self::PLAIN };

    /// Colours as they are, one point for each pixel.
    pub(crate) const PLAIN: Self = Self {
        light: None,
        smoothing: Smoothing::None,
        channel: Channel::Color,
        light_from: None,
        shadows: false,
        occlusion: 0.0,
        depth_unit: 1.0,
    };

    /// The same options with another `light`.
    pub const fn with_light(mut self, light: Option<Light>) -> Self {
        self.light = light;
        self
    }

    /// The same options with another `smoothing`.
    pub const fn with_smoothing(mut self, smoothing: Smoothing) -> Self {
        self.smoothing = smoothing;
        self
    }

    /// The same options for another `channel`: of what is nearest, at the middle of each pixel.
    pub const fn with_channel(mut self, channel: Channel) -> Self {
        self.channel = channel;
        if !matches!(channel, Channel::Color) {
            self.smoothing = Smoothing::None;
        }
        self
    }

    /// The same options with light from elsewhere, and `shadows` or none.
    pub const fn with_light_from(mut self, from: Option<Vector>, shadows: bool) -> Self {
        (self.light_from, self.shadows) = (from, shadows);
        self
    }

    /// The same options with another `occlusion`.
    pub const fn with_occlusion(mut self, occlusion: f32) -> Self {
        self.occlusion = occlusion;
        self
    }
}

impl Default for RasterOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What was computed for a picture, and what was not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Triangles in the tiles of the picture, those behind others too.
    pub triangles: u64,
    /// Triangles beside the picture, cut away, as thin as a line, or of surfaces that cannot be seen.
    pub triangles_skipped: u64,
    /// How often a triangle was lit in a pixel.
    pub lit: u64,
    /// Points of translucent triangles that lie behind what is as good as opaque, in the tiles of the picture: of those
    /// that were looked at.
    pub hidden: u64,
    /// How often a triangle was not looked at in a tile, since all of it lies behind what is opaque there.
    pub triangles_hidden: u64,
}

impl Drawn {
    fn with(self, other: Self) -> Self {
        Self {
            triangles: self.triangles + other.triangles,
            triangles_skipped: self.triangles_skipped + other.triangles_skipped,
            lit: self.lit + other.lit,
            hidden: self.hidden + other.hidden,
            triangles_hidden: self.triangles_hidden + other.triangles_hidden,
        }
    }
}

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RasterError {
    /// The caller's choice: larger than places in the picture are numbered.
    #[error("a picture of {} by {} pixels: {MOST_PIXELS} are the most on a side", .0.width, .0.height)]
    Size(Size),
    /// There are more triangles than 31 bits number: beyond those come pieces of them.
    #[error("{0} triangles in one picture are more than 31 bits can number")]
    Triangles(u64),
    /// The job was cancelled, or allows less memory.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl From<OverLimit> for RasterError {
    fn from(error: OverLimit) -> Self {
        Self::Stopped(error.into())
    }
}

/// The most pixels on a side of a picture.
const MOST_PIXELS: u32 = 1 << 16;

/// The picture of some surfaces and of the caps of what was cut away from them.
///
/// It is the same, byte for byte, for any number of threads.
///
/// # Errors
///
/// If the picture has more than 65,536 pixels on a side; if the surfaces have more than 2³¹ triangles; if the job is
/// cancelled or does not allow the memory.
pub fn rasterize(
    surfaces: &[Painted<'_>],
    caps: &[Cap<'_>],
    (camera, size): (&Camera, Size),
    options: &RasterOptions,
    job: &Job,
) -> Result<(Image, Drawn), RasterError> {
    if size.width.get().max(size.height.get()) > MOST_PIXELS {
        return Err(RasterError::Size(size));
    }
    let quiet = job.unwatched();
    let in_the_way = surfaces.iter().filter(|painted| painted.is_opaque());
    let opaque: Vec<_> = in_the_way.map(Painted::whole).collect();
    // Caps hide light too, wherever a surface was cut.
    let around = if caps.is_empty() { bounds(&opaque) } else { bounds(surfaces) };
    let shading = Shading::new(camera, options, around, |view, options| {
        Ok::<_, RasterError>(rasterize(&opaque, caps, view, options, &quiet)?.0)
    })?;
    let surfaces = match options.channel {
        Channel::Color => surfaces.to_vec(),
        // All that is seen is opaque.
        _ => surfaces.iter().filter(|painted| painted.opacity > 0.0).map(Painted::whole).collect(),
    };
    let surfaces = &surfaces[..];
    let mut image = Image::new(size, &job.limits)?;
    let view = Viewport::new(camera, size);
    let (bins, binned) = exactly(|| Bins::of(surfaces, &view, None, job))?;
    let resolve = Resolve { surfaces, caps, view: &view, bins: &bins, shading: &shading };
    let width = size.width.get() as usize;
    let [columns, rows] = bins.tiles();
    job.progress.begin("render", rows as u64);
    let row = |(row, pixels): (usize, &mut [Gathered])| {
        exactly(|| {
            let (mut tile, mut drawn) = (Tile::new(options.smoothing), Drawn::default());
            for column in 0..columns {
                job.check()?;
                tile.draw([column, row], &bins, &mut drawn);
                let left = column * TILE[0];
                let parts = pixels.chunks_mut(width).map(|row| {
                    let right = width.min(left + TILE[0]);
                    &mut row[left..right]
                });
                resolve.tile(&tile, [column, row], parts, &mut drawn);
            }
            job.progress.advance(1);
            Ok(drawn)
        })
    };
    let bands = image.pixels_mut().par_chunks_mut(width * TILE[1]).enumerate();
    // Sums of whole numbers are the same in any order.
    let both = |a: Drawn, b: Drawn| Ok::<_, Stopped>(a.with(b));
    let drawn = job.threads.run(|| bands.map(row).try_reduce(Drawn::default, both))?;
    Ok((image, drawn.with(binned)))
}

#[cfg(test)]
mod tests;

//! Scenes: what is to be seen of a scan or of meshes. Only what the picture needs is computed.
//!
//! | step | function |
//! | --- | --- |
//! | know what is to be read, and read that | [`Scene::samples_of_surfaces`], [`Scene::samples_of_rays`] |
//! | know what is computed, and what not | [`Scene::needs`], [`Scene::needs_of_rays`] |
//! | make the surfaces that can be seen | [`Scene::meshes_in_sight`], [`Scene::meshes`], [`Scene::meshes_on_screen`] |
//! | draw them, cut and capped | [`Scene::draw`] |
//! | or trace rays to them, without a mesh | [`Scene::trace`] |
//! | or cast rays through the values | [`Scene::cast`], [`Scene::cast_each`] |
//! | or lay the samples on each other | [`Scene::splat`] |
//!
//! A plane keeps places on one side of it. Of a surface that is cut only the part of the scan on that side is
//! extracted, and of one that is seen from a place only what is in the picture; a surface that is transparent, cut away
//! altogether, or wholly behind an opaque one, is not. Samples that are NaN are outside.

mod caps;
mod detail;
mod error;
mod hidden;
mod meshes;
mod needs;
mod preset;
mod viewpoint;

pub use detail::OnScreen;
pub use error::SceneError;
pub use meshes::InSight;
pub use needs::{Needs, SurfaceNeed, Unneeded};
pub use preset::Preset;
pub use viewpoint::Viewpoint;

use crate::pipeline::Scan;
use caps::Caps;
use isokit_geom::{Aabb, HalfSpace, Space, vector::Vector};
use isokit_job::Job;
use isokit_mesh::{Rgba, TriMesh};
use isokit_render::{
    Cast, Drawn, Image, Interpolant, Isosurface, Isosurfaces, Kernel, Medium, OpticalModel, Paint,
    Painted, RasterOptions, RaycastOptions, Raycaster, Size, SolidTexture, Splatted, Traced,
    TransferFunction, isocast, kept_bounds, rasterize, splat,
};
use isokit_volume::for_any;

/// What is to be seen, from where, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Surfaces, which [`Scene::draw`] and [`Scene::trace`] show.
    pub surfaces: Vec<SurfaceLook>,
    /// What cuts them, and rays.
    pub clips: Vec<Clip>,
    /// What values look like, in [`Scene::cast`] and [`Scene::splat`] and where a plane shows a slice.
    pub model: Option<OpticalModel>,
    /// From where it is seen.
    pub viewpoint: Viewpoint,
    /// How surfaces are drawn.
    pub raster: RasterOptions,
    /// How rays are cast. The kernel is that of [`Scene::trace`] too.
    pub raycast: RaycastOptions,
}

/// A surface and its looks.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceLook {
    /// By which planes name it.
    pub name: String,
    /// The value on it. None of a mesh that is there already.
    pub iso: Option<f64>,
    /// Its colour in linear light, not multiplied by its opacity. A mesh whose vertices have colours is drawn in those.
    pub color: [f32; 3],
    /// How much of what is behind it hides, each time that one looks through it, from 0 to 1; times that of vertices.
    pub opacity: f32,
    /// A texture that it is cut from, instead of its colour.
    pub texture: Option<SolidTexture>,
}

impl SurfaceLook {
    /// The colour that it has at a place.
    pub fn color_at(&self, place: Vector) -> [f32; 3] {
        self.texture.map_or(self.color, |texture| texture.at(place))
    }

    /// Its colour, or those of vertices, or those of places.
    fn paint<'a>(
        &self,
        solid: &'a (dyn Fn(Vector) -> [f32; 3] + Sync),
        vertices: Option<&'a [Rgba]>,
    ) -> Paint<'a> {
        match (self.texture, vertices) {
            (Some(_), _) => Paint::Solid(solid),
            (None, Some(colors)) => Paint::Vertices(colors),
            (None, None) => Paint::Plain(self.color),
        }
    }
}

/// A plane that cuts.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// What is kept.
    pub half: HalfSpace,
    /// The names of the surfaces that it cuts; none for all. Rays are cut by planes that cut all.
    pub surfaces: Option<Vec<String>>,
    /// What closes the hole.
    pub cap: CapStyle,
}

/// What closes the hole that a plane cuts into a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CapStyle {
    /// Nothing: one looks inside.
    #[default]
    None,
    /// The colour of the innermost surface that is cut there, opaque.
    Solid,
    /// The values there, in the colours of the transfer function, opaque.
    Slice,
}

impl Scene {
    /// The picture of surfaces, one for each of the scene's: of a scan, if there is one, whose values caps show. From a
    /// side all of them are in the picture; where there is none, the box.
    ///
    /// # Errors
    ///
    /// If a plane names a surface that is not there, or shows values where there is no scan or no transfer function;
    /// if the camera sees nothing; or if the picture is too large.
    ///
    /// # Panics
    ///
    /// If there are not as many meshes as surfaces.
    pub fn draw(
        &self,
        meshes: &[TriMesh],
        (scan, around): (Option<&Scan>, (Aabb, Space)),
        size: Size,
        job: &Job,
    ) -> Result<(Image, Drawn), SceneError> {
        assert_eq!(meshes.len(), self.surfaces.len(), "one mesh for each surface");
        self.check_names()?;
        let bounds = match self.viewpoint {
            Viewpoint::Framed { .. } => self.extent(meshes).unwrap_or(around.0),
            // The middle stays where it is, whatever planes leave.
            Viewpoint::At { .. } => around.0,
        };
        let camera = self.viewpoint.camera((bounds, around.1), size)?;
        let clips: Vec<Vec<HalfSpace>> =
            self.surfaces.iter().map(|look| self.halves(look)).collect();
        let solids = self.solids();
        let looks = self.surfaces.iter().zip(meshes).zip(&clips).zip(&solids);
        let painted = looks.map(|(((look, mesh), clips), solid)| Painted {
            mesh,
            paint: look.paint(solid, mesh.attributes.colors.as_deref()),
            opacity: look.opacity,
            clips,
        });
        let painted: Vec<_> = painted.collect();
        let draw = |caps: &Caps<'_>| {
            Ok(rasterize(&painted, &caps.all(), (&camera, size), &self.raster, job)?)
        };
        match scan.filter(|_| self.has_caps()) {
            Some(scan) => for_any!(scan.volume(), volume => {
                let field = Interpolant::new(scan.view(volume), Kernel::Linear);
                draw(&Caps::new(self, &|place| field.at(place))?)
            }),
            None if self.has_caps() => Err(SceneError::NoValues),
            None => draw(&Caps::new(self, &|_| None)?),
        }
    }

    /// The picture of a scan's surfaces, without meshes of them. From a side the whole scan is in the picture. Those of
    /// which planes leave nothing, or nothing in the picture, are not looked for.
    ///
    /// # Errors
    ///
    /// As [`draw`](Self::draw).
    pub fn trace(&self, scan: &Scan, size: Size, job: &Job) -> Result<(Image, Traced), SceneError> {
        self.check_names()?;
        let camera = self.viewpoint.camera(scan.around(), size)?;
        let clips: Vec<Vec<HalfSpace>> =
            self.surfaces.iter().map(|look| self.halves(look)).collect();
        let solids = self.solids();
        let looks = self.surfaces.iter().zip(&clips).zip(&solids);
        let of = (&[self.viewpoint][..], size);
        let views = self.views(scan.lattice(), of, self.raster.needs_surroundings())?;
        let looks = looks.filter_map(|((look, clips), solid)| {
            let (paint, opacity) = (look.paint(solid, None), look.opacity);
            self.part_of(look, scan.lattice(), &views).ok()?;
            Some(Isosurface { iso: look.iso?, paint, opacity, clips })
        });
        let surfaces: Vec<_> = looks.collect();
        for_any!(scan.volume(), volume => {
            let view = scan.view(volume);
            let (bricks, kernel) = (scan.part_bricks(&view, job)?, self.raycast.kernel);
            let field = Interpolant::new(view, kernel);
            let value = |place| field.at(place);
            let caps = Caps::new(self, &value)?;
            let caps = caps.all();
            let (bricks, surfaces, caps) = (Some(bricks), &surfaces[..], &caps[..]);
            let scene = Isosurfaces { view: &view, bricks, kernel, surfaces, caps };
            Ok(isocast(&scene, (&camera, size), &self.raster, job)?)
        })
    }

    /// The picture of a scan's values, by rays. From a side the whole scan is in the picture; planes for surfaces alone,
    /// and caps, are not shown.
    ///
    /// # Errors
    ///
    /// If a plane names a surface that is not there; if nothing says what values look like; if the camera sees nothing;
    /// or as [`raycast`](isokit_render::raycast).
    pub fn cast(&self, scan: &Scan, size: Size, job: &Job) -> Result<(Image, Cast), SceneError> {
        let mut made = None;
        self.cast_each(scan, (&[self.viewpoint], size), job, |image, cast| {
            made = Some((image, cast));
            Ok::<_, SceneError>(())
        })?;
        Ok(made.expect("one viewpoint, one picture"))
    }

    /// The same from several viewpoints, one picture after the other. What does not depend on the viewpoint is done once.
    ///
    /// # Errors
    ///
    /// As [`cast`](Self::cast), or what is said of a picture.
    pub fn cast_each<E: From<SceneError>>(
        &self,
        scan: &Scan,
        (viewpoints, size): (&[Viewpoint], Size),
        job: &Job,
        mut each: impl FnMut(Image, Cast) -> Result<(), E>,
    ) -> Result<(), E> {
        let (model, clips) = self.of_values()?;
        for_any!(scan.volume(), volume => {
            let view = scan.view(volume);
            let bricks = scan.part_bricks(&view, job).map_err(SceneError::from)?;
            let medium = Medium { view: &view, bricks: Some(bricks), model, clips: &clips };
            let caster = Raycaster::new(&medium, &self.raycast, job).map_err(SceneError::from)?;
            for viewpoint in viewpoints {
                let camera = viewpoint.camera(scan.around(), size).map_err(SceneError::from)?;
                let (image, cast) = caster.picture((&camera, size), job).map_err(SceneError::from)?;
                each(image, cast)?;
            }
            Ok(())
        })
    }

    /// The same by samples that are laid on each other.
    ///
    /// # Errors
    ///
    /// As [`cast`](Self::cast).
    pub fn splat(
        &self,
        scan: &Scan,
        size: Size,
        job: &Job,
    ) -> Result<(Image, Splatted), SceneError> {
        let (model, clips) = self.of_values()?;
        let camera = self.viewpoint.camera(scan.around(), size)?;
        for_any!(scan.volume(), volume => {
            let view = scan.view(volume);
            let bricks = scan.part_bricks(&view, job)?;
            let medium = Medium { view: &view, bricks: Some(bricks), model, clips: &clips };
            Ok(splat(&medium, (&camera, size), &self.raycast, job)?)
        })
    }

    /// What pictures of values need: what they look like, and where they are cut.
    fn of_values(&self) -> Result<(&OpticalModel, Vec<HalfSpace>), SceneError> {
        self.check_names()?;
        let model = self.model.as_ref().ok_or(SceneError::NoTransfer)?;
        Ok((model, self.cuts_of_all().collect()))
    }

    /// The same scene with one of its surfaces alone to be seen.
    #[must_use]
    pub fn with_only(&self, surface: usize) -> Self {
        let mut scene = self.clone();
        for (n, look) in scene.surfaces.iter_mut().enumerate() {
            look.opacity = if n == surface { look.opacity } else { 0.0 };
        }
        scene
    }

    /// The box around what planes leave of the surfaces that can be seen, if it is more than a point.
    pub fn extent(&self, meshes: &[TriMesh]) -> Option<Aabb> {
        let seen = self.surfaces.iter().zip(meshes).filter(|(look, _)| look.opacity > 0.0);
        let boxes = seen.filter_map(|(look, mesh)| kept_bounds(mesh, &self.halves(look)));
        let found = boxes.reduce(|a, b| a.with(b.min).with(b.max))?;
        let extents = [0, 1, 2].map(|k| found.max[k] - found.min[k]);
        let is_wide = extents.iter().all(|extent| extent.is_finite()) && extents != [0.0; 3];
        is_wide.then_some(found)
    }

    /// The planes that cut all surfaces, and rays.
    fn cuts_of_all(&self) -> impl Iterator<Item = HalfSpace> {
        self.clips.iter().filter(|clip| clip.surfaces.is_none()).map(|clip| clip.half)
    }

    /// The planes that cut a surface.
    fn clips_of(&self, look: &SurfaceLook) -> impl Iterator<Item = &Clip> {
        self.clips.iter().filter(|clip| clip.cuts(&look.name))
    }

    /// The colours of each surface at places.
    fn solids(&self) -> Vec<impl Fn(Vector) -> [f32; 3] + Sync> {
        self.surfaces.iter().map(|look| |place| look.color_at(place)).collect()
    }

    fn halves(&self, look: &SurfaceLook) -> Vec<HalfSpace> {
        self.clips_of(look).map(|clip| clip.half).collect()
    }

    /// Whether a plane shows the values where it cuts.
    pub fn has_slices(&self) -> bool {
        self.clips.iter().any(|clip| clip.cap == CapStyle::Slice)
    }

    fn has_caps(&self) -> bool {
        self.clips.iter().any(|clip| clip.cap != CapStyle::None)
    }

    fn check_names(&self) -> Result<(), SceneError> {
        let is_unknown = |name: &&String| !self.surfaces.iter().any(|look| look.name == **name);
        let mut named = self.clips.iter().filter_map(|clip| clip.surfaces.as_ref()).flatten();
        named.find(is_unknown).map_or(Ok(()), |name| Err(SceneError::UnknownSurface(name.clone())))
    }
}

/// How steep the borders are of what a function shows of a scan: as [`isokit_render::full_slope`].
///
/// # Errors
///
/// If the job is cancelled.
pub fn full_slope(scan: &Scan, function: &TransferFunction, job: &Job) -> Result<f64, SceneError> {
    let slope = for_any!(scan.volume(), volume => {
        isokit_render::full_slope(&scan.view(volume), function, job)
    });
    Ok(slope?)
}

impl Clip {
    fn cuts(&self, name: &str) -> bool {
        self.surfaces.as_ref().is_none_or(|names| names.iter().any(|cut| cut == name))
    }
}

#[cfg(test)]
mod tests;

//! Meshes of a scan's surfaces, as far as pictures show them.

use super::{Scene, SceneError, Viewpoint, hidden::Wall, needs::Views};
use crate::pipeline::{Lattice, Normals, Scan, SurfaceOptions};
use isokit_job::Job;
use isokit_marching_cubes::{ExtractOptions, Nan};
use isokit_mesh::TriMesh;
use isokit_render::Size;
use std::ops::Range;

/// The samples of a box, of the whole lattice.
pub(super) type Part = [Range<usize>; 3];

/// Surfaces that pictures show, and those that none does.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InSight {
    /// One for each surface of the scene, as [`Scene::meshes`] has them; of those that are hidden, empty ones.
    pub meshes: Vec<TriMesh>,
    /// The surfaces that were not made since all of each is [behind an opaque one](super::Unneeded::Hidden).
    pub hidden: Vec<usize>,
}

impl Scene {
    /// How a scene's surfaces are extracted: with the defaults, and NaN outside.
    pub fn surface_options() -> SurfaceOptions {
        SurfaceOptions::default().with_extract(ExtractOptions::DEFAULT.with_nan(Nan::Outside))
    }

    /// The surfaces of a scan that can be seen in pictures of a size from some viewpoints, each as far as it is not cut
    /// away or beside the pictures, or a few cells farther; empty meshes for the others. Without normals, if no picture of
    /// the scene asks for them.
    ///
    /// Each is whole behind the others, for pictures of [one alone](Self::with_only) and for light from
    /// elsewhere; [`meshes_in_sight`](Self::meshes_in_sight) are for pictures of all together.
    ///
    /// # Errors
    ///
    /// If a plane names a surface that is not there, if a camera sees nothing, or if an extraction fails.
    pub fn meshes(
        &self,
        scan: &Scan,
        camera: (&[Viewpoint], Size),
        job: &Job,
    ) -> Result<Vec<TriMesh>, SceneError> {
        self.check_names()?;
        let views = self.views(scan.lattice(), camera, self.raster.needs_surroundings())?;
        self.meshes_in(scan, &views, job)
    }

    /// The same for pictures of all surfaces together, without those that lie wholly behind an opaque one from all of the
    /// viewpoints: the pictures that [`draw`](Self::draw) makes of the scan from there, with as many points in a pixel, are
    /// the same, byte for byte, unless vertices are given colours that show what is behind.
    ///
    /// What hides others is the opaque surface of the lowest value that no plane cuts; those of higher values come after
    /// it. Nothing is hidden where pictures have shadows or occlusion, where the camera is within a surface, or where one
    /// that is hidden may reach beyond the others and so be what the picture is framed by.
    ///
    /// # Errors
    ///
    /// As [`meshes`](Self::meshes), or if the job is cancelled or does not allow the memory.
    pub fn meshes_in_sight(
        &self,
        scan: &Scan,
        camera: (&[Viewpoint], Size),
        job: &Job,
    ) -> Result<InSight, SceneError> {
        self.check_names()?;
        let views = self.views(scan.lattice(), camera, self.raster.needs_surroundings())?;
        let parts = self.parts(scan.lattice(), &views);
        let mut meshes = vec![TriMesh::default(); parts.len()];
        let Some(mut wall) = Wall::of(self, scan, &parts) else {
            self.make(scan, &parts, &mut meshes, job)?;
            return Ok(InSight { meshes, hidden: vec![] });
        };
        let only = |chosen: &dyn Fn(usize) -> bool| -> Vec<Option<Part>> {
            let parts = parts.iter().enumerate();
            parts.map(|(n, part)| part.clone().filter(|_| chosen(n))).collect()
        };
        let within = wall.within.clone();
        let first = only(&|n| !within.contains(&n));
        wall.margin = self.make(scan, &first, &mut meshes, job)?[wall.surface];
        let hidden = wall.hidden(&meshes, camera, job)?;
        let rest = only(&|n| within.contains(&n) && !hidden.contains(&n));
        self.make(scan, &rest, &mut meshes, job)?;
        Ok(InSight { meshes, hidden })
    }

    pub(super) fn meshes_in(
        &self,
        scan: &Scan,
        views: &Views,
        job: &Job,
    ) -> Result<Vec<TriMesh>, SceneError> {
        let mut meshes = vec![TriMesh::default(); self.surfaces.len()];
        self.make(scan, &self.parts(scan.lattice(), views), &mut meshes, job)?;
        Ok(meshes)
    }

    /// The samples that each surface needs, if any.
    fn parts(&self, lattice: &Lattice, views: &Views) -> Vec<Option<Part>> {
        let part = |look| self.part_of(look, lattice, views).ok();
        self.surfaces.iter().map(part).collect()
    }

    /// Makes surfaces in their parts. How near vertices of each may be to samples comes back, in edge lengths.
    fn make(
        &self,
        scan: &Scan,
        parts: &[Option<Part>],
        meshes: &mut [TriMesh],
        job: &Job,
    ) -> Result<Vec<f64>, SceneError> {
        let normals = if self.raster.needs_normals() { Normals::Gradient } else { Normals::None };
        let options = Self::surface_options().with_normals(normals);
        let mut margins = vec![0.0; parts.len()];
        // Surfaces of the same part are made in one pass.
        for n in 0..parts.len() {
            let Some(part) = &parts[n] else { continue };
            if parts[..n].contains(&parts[n]) {
                continue;
            }
            let same: Vec<usize> = (n..parts.len()).filter(|&m| parts[m] == parts[n]).collect();
            let isos: Vec<f64> = same.iter().filter_map(|&m| self.surfaces[m].iso).collect();
            let mut made = vec![TriMesh::default(); isos.len()];
            let extracted = scan.meshes_of_part(part, &isos, &options, &mut made, job)?;
            for ((m, mesh), extracted) in same.into_iter().zip(made).zip(extracted) {
                (meshes[m], margins[m]) = (mesh, extracted.margin);
            }
        }
        Ok(margins)
    }
}

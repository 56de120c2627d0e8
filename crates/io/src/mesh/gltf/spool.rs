//! glTF of surfaces that come in pieces.

use super::{
    Scale,
    content::{Bounds, Undirected, report_unseen},
    plan::{Bin, Part, Plan, is_seen},
    write::{put_normals, put_positions, put_triangles},
};
use crate::{
    Format, Output, WriteError, WriteFault,
    mesh::{MeshContext, Written, outline::Outline, rounding::Tally, section::Section},
};
use isokit_job::Job;
use isokit_mesh::TriMesh;
use std::io::{self, Write};

/// A surface that comes in pieces.
#[derive(Debug)]
pub(in crate::mesh) struct Spool {
    scale: Scale,
    positions: Section,
    normals: Section,
    triangles: Section,
    bounds: Bounds,
    tally: Tally,
    /// Why a surface with triangles cannot be written; one without is not.
    unfit: Option<WriteFault>,
    /// Why there are no normals, if so.
    undirected: Option<Undirected>,
}

impl Spool {
    pub(in crate::mesh) fn create(beside: &Output, context: &MeshContext) -> io::Result<Self> {
        let [positions, normals, triangles] = [(); 3].map(|()| Section::create(beside));
        Ok(Self {
            scale: Scale::of(context),
            positions: positions?,
            normals: normals?,
            triangles: triangles?,
            bounds: Bounds::default(),
            tally: Tally::default(),
            unfit: None,
            undirected: None,
        })
    }

    /// Takes in the next piece.
    pub(in crate::mesh) fn take(
        &mut self,
        piece: &mut TriMesh,
        outline: &Outline,
        job: &Job,
    ) -> Result<(), WriteFault> {
        let (scale, first) = (self.scale, outline.counts.vertices - piece.positions.len() as u64);
        if self.unfit.is_none() {
            let within = self.bounds.take(&piece.positions, scale, &outline.head, first);
            self.unfit = within.err();
        }
        if is_seen(&outline)
            && let Some(unfit) = self.unfit.take()
        {
            return Err(unfit);
        }
        self.positions.add(job, |stream| put_positions(stream, &piece.positions, scale))?;
        let normals = piece.normals.as_deref().unwrap_or_default();
        self.undirected = self.undirected.or_else(|| Undirected::find(normals, first));
        if self.undirected.is_none() {
            self.normals.add(job, |stream| put_normals(stream, normals))?;
        }
        self.triangles.add(job, |stream| put_triangles(stream, &piece.triangles))?;
        let (store, back) = (|xyz| scale.store(xyz), |xyz| scale.restore(xyz));
        Ok(self.tally.take(&mut piece.positions, store, back, job)?)
    }

    /// The sections in the order of the buffer.
    pub(in crate::mesh) fn sections(&self) -> [&Section; 3] {
        [&self.positions, &self.normals, &self.triangles]
    }

    fn append_to(self, out: &mut Output, job: &Job) -> Result<(), WriteFault> {
        self.positions.append_to(out, job)?;
        if self.undirected.is_none() {
            self.normals.append_to(out, job)?;
        }
        self.triangles.append_to(out, job)
    }
}

/// Writes what [`write_glb`](super::write_glb) writes of the whole surfaces.
pub(in crate::mesh) fn finish_glb(
    all: Vec<Spool>,
    out: &mut Output,
    outlines: &[Outline],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteFault> {
    let parts = parts(Format::Glb, &all, outlines, written);
    out.write_all(&Plan::new(&parts, context, None)?.glb_head())?;
    append_seen(all, out, outlines, job)
}

/// Writes what [`write_gltf`](super::write_gltf) writes of the whole surfaces.
pub(in crate::mesh) fn finish_gltf(
    all: Vec<Spool>,
    json: Output,
    outlines: &[Outline],
    context: &MeshContext,
    job: &Job,
    written: &mut Written,
) -> Result<(), WriteError> {
    let bin = Bin::beside(json.path());
    let parts = parts(Format::Gltf, &all, outlines, written);
    let plan = Plan::new(&parts, context, Some(bin.uri.clone()));
    let plan = plan.map_err(|fault| fault.at(json.path()))?;
    bin.finish(json, &plan, |out| append_seen(all, out, outlines, job), written)
}

fn parts(format: Format, all: &[Spool], outlines: &[Outline], written: &mut Written) -> Vec<Part> {
    report_unseen(outlines, written);
    let part = |(spool, outline): (&Spool, &Outline)| {
        let mut outline = outline.clone();
        if is_seen(&&outline) {
            spool.tally.loss().report(&outline, format, written);
            if let Some(undirected) = spool.undirected {
                undirected.report(&outline.head, written);
                outline.has_normals = false;
            }
        }
        Part { outline, bounds: spool.bounds, is_translucent: false }
    };
    all.iter().zip(outlines).map(part).collect()
}

fn append_seen(
    all: Vec<Spool>,
    out: &mut Output,
    outlines: &[Outline],
    job: &Job,
) -> Result<(), WriteFault> {
    let mut seen = all.into_iter().zip(outlines).filter(|(_, outline)| is_seen(outline));
    seen.try_for_each(|(spool, _)| spool.append_to(out, job))
}

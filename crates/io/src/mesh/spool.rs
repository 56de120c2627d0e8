//! Surfaces that come in pieces and are never in memory as a whole.
//!
//! A file names its counts first and keeps vertices and triangles apart, but pieces bring some of each. So
//! each section of a file grows in a file of its own, which has no name and is gone with the process; when
//! all pieces have come the header is written and the sections are copied behind it. What is written is,
//! byte for byte, what [`write_mesh`](super::write_mesh) writes of the whole surfaces.
//!
//! In memory is, of each surface, the piece that is being filled; for STL and glTF also the positions of
//! the pieces just before, and for STL the triangles of one. The disk holds what has come, and while it is
//! copied at most twice that.

use super::{
    MeshContext, SurfaceHead, Written, format_of, gltf, holds_several, name_all, obj,
    outline::Outline, paths, ply, section::Section, sound, stl,
};
use crate::{Format, Output, WriteError, WriteFault};
use isokit_job::{Job, OverLimit};
use isokit_mesh::{Counts, MeshSink, Piece, Precision, TriMesh};
use std::{io, path::Path};

/// Writes surfaces of which nobody has the whole; their pieces may come in turns.
///
/// The files and what is said of them are those of [`write_mesh`](super::write_mesh), but for two limits of
/// what is remembered. [`Written::merged_vertices`] compares a vertex with those of its piece and of the
/// one before that had any: vertices that fall together farther apart are not counted. And in STL a
/// triangle may name vertices of those two pieces and of the next one only, or it is an error.
///
/// Dropped before it is [finished](Self::finish) it leaves nothing behind, and what stood under the names
/// before still stands there.
///
/// ```
/// use isokit_io::{MeshContext, MeshSpool, SurfaceHead, WriteError};
/// use isokit_job::Job;
/// use isokit_mesh::{Counts, MeshSink, PositionsMut, Precision};
///
/// # let folder = tempfile::tempdir().unwrap();
/// # let path = folder.path().join("strip.ply");
/// let strip = SurfaceHead { name: "strip".into(), ..SurfaceHead::default() };
/// let mut spool =
///     MeshSpool::create(&path, vec![strip], false, &MeshContext::default(), &Job::default())?;
/// for step in 0..1000_u32 {
///     let counts = Counts { vertices: 2, triangles: u64::from(step < 999) };
///     let mut sink = spool.sink(0);
///     let piece = sink.piece(counts, Precision::F32)?;
///     if let PositionsMut::F32(positions) = piece.positions {
///         positions.copy_from_slice(&[[step as f32, 0.0, 0.0], [step as f32, 1.0, 0.0]]);
///     }
///     // The last corner is a vertex of the next piece.
///     piece.triangles.fill([2 * step, 2 * step + 2, 2 * step + 1]);
/// }
/// let written = spool.finish()?;
/// assert_eq!(written.files, [path]);
/// # Ok::<(), WriteError>(())
/// ```
#[derive(Debug)]
pub struct MeshSpool {
    format: Format,
    context: MeshContext,
    job: Job,
    /// The same job, but its progress is that of whoever makes the pieces.
    quiet: Job,
    files: Vec<Output>,
    surfaces: Vec<Coming>,
    sections: Sections,
}

/// A surface of which pieces are still coming.
#[derive(Debug)]
struct Coming {
    /// What has come, the last piece too.
    outline: Outline,
    /// Whether any has come.
    has_begun: bool,
    /// The last piece; it may not be full yet.
    piece: TriMesh,
    state: State,
    /// The greatest number of a vertex that a triangle names.
    needed: u32,
}

/// What has become of the last piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// There is none, or it is in its sections.
    Idle,
    /// Somebody fills it.
    Open,
    /// It could not be taken in, or not as a whole.
    Broken,
}

/// What has come, by format; one for each surface.
#[derive(Debug)]
enum Sections {
    Ply(Vec<ply::Spool>),
    Stl(Vec<stl::Spool>),
    Obj(Vec<obj::Spool>),
    Gltf(Vec<gltf::Spool>),
}

impl MeshSpool {
    /// Begins files for surfaces of which nothing is known but this. Each gets its name when all are whole.
    ///
    /// With `normals`, each piece asks for them where the format has some.
    ///
    /// # Errors
    ///
    /// If the name has another ending than those, or if no file can be made there.
    pub fn create(
        path: &Path,
        surfaces: Vec<SurfaceHead>,
        normals: bool,
        context: &MeshContext,
        job: &Job,
    ) -> Result<Self, WriteError> {
        let format = format_of(path).map_err(|fault| fault.at(path))?;
        let paths = paths(format, path, surfaces.iter().map(|head| head.name.as_str()));
        let files = paths.iter().map(|path| Output::create(path));
        let files = files.collect::<Result<Vec<_>, WriteError>>()?;
        let new = |head| Coming::new(head, normals && format != Format::Stl);
        let mut surfaces: Vec<_> = surfaces.into_iter().map(new).collect();
        if surfaces.is_empty() && !holds_several(format) {
            surfaces.push(Coming::new(SurfaceHead::default(), false));
        }
        let sections = Sections::create(format, surfaces.len(), &files, context)?;
        let (context, job, quiet) = (context.clone(), job.clone(), job.unwatched());
        Ok(Self { format, context, job, quiet, files, surfaces, sections })
    }

    /// The sink of a surface, counted from 0. It may be taken again and again, for one piece or for many.
    pub fn sink(&mut self, surface: usize) -> SpoolSink<'_> {
        SpoolSink { spool: self, surface }
    }

    /// Writes all that has come to the files and gives them their names. The job's progress counts bytes;
    /// while pieces come it is left to whoever makes them.
    ///
    /// # Errors
    ///
    /// As [`write_mesh`](super::write_mesh), or if a piece could not be taken in. Nothing is left behind.
    pub fn finish(mut self) -> Result<Written, WriteError> {
        for n in 0..self.surfaces.len() {
            self.close(n).map_err(|fault| fault.at(self.path(n)))?;
        }
        self.job.progress.begin("write", self.sections.bytes());
        let outlines: Vec<_> = self.surfaces.into_iter().map(|coming| coming.outline).collect();
        let finish = Finish { outlines: &outlines, context: &self.context, job: &self.job };
        finish.files(self.format, self.sections, self.files)
    }

    /// Ends a surface.
    fn close(&mut self, surface: usize) -> Result<(), WriteFault> {
        self.settle(surface)?;
        let coming = &self.surfaces[surface];
        coming.check()?;
        match &mut self.sections {
            Sections::Stl(all) => all[surface].put_waiting(&coming.outline, &self.quiet),
            _ => Ok(()),
        }
    }

    /// The file of a surface, or the one of all.
    fn path(&self, surface: usize) -> &Path {
        let file = self.files.get(surface).or(self.files.first());
        file.map_or(Path::new(""), Output::path)
    }

    /// Ends a surface's last piece and counts the next one in.
    fn make_room(
        &mut self,
        surface: usize,
        counts: Counts,
        precision: Precision,
    ) -> Result<(), WriteFault> {
        if surface >= self.surfaces.len() {
            let fault = format!("no surface {surface} of {} begun", self.surfaces.len());
            return Err(WriteFault::Caller(fault.into()));
        }
        self.settle(surface)?;
        let coming = &mut self.surfaces[surface];
        // Without this piece the surface has a hole.
        coming.state = State::Broken;
        coming.announce(self.format, counts, precision)?;
        match self.format {
            Format::Stl => stl::check(coming.outline.counts.triangles)?,
            Format::Glb | Format::Gltf => {
                gltf::check(self.format, self.surfaces.iter().map(|coming| &coming.outline))?;
            }
            _ => {}
        }
        let coming = &mut self.surfaces[surface];
        coming.probe(counts, &self.job)?;
        coming.state = State::Open;
        Ok(())
    }

    /// Takes in the piece that is now full, if there is one.
    fn settle(&mut self, surface: usize) -> Result<(), WriteFault> {
        let coming = &mut self.surfaces[surface];
        match coming.state {
            State::Idle => return Ok(()),
            State::Broken => {
                return Err(sound::fault(&coming.outline.head.name, "a piece of it is lost"));
            }
            State::Open => coming.state = State::Broken,
        }
        coming.needed = sound::needed(coming.needed, &coming.piece.triangles);
        let (piece, outline, job) = (&mut coming.piece, &coming.outline, &self.quiet);
        match &mut self.sections {
            Sections::Ply(all) => all[surface].take(piece, job)?,
            Sections::Stl(all) => all[surface].take(piece, outline, job)?,
            Sections::Obj(all) => all[surface].take(piece, job)?,
            Sections::Gltf(all) => all[surface].take(piece, outline, job)?,
        }
        coming.state = State::Idle;
        Ok(())
    }
}

impl Sections {
    fn create(
        format: Format,
        surfaces: usize,
        files: &[Output],
        context: &MeshContext,
    ) -> Result<Self, WriteError> {
        Ok(match format {
            Format::Ply => Self::Ply(spools(surfaces, files, ply::Spool::create)?),
            Format::Stl => Self::Stl(spools(surfaces, files, stl::Spool::create)?),
            Format::Obj => Self::Obj(spools(surfaces, files, obj::Spool::create)?),
            _ => Self::Gltf(spools(surfaces, files, |out| gltf::Spool::create(out, context))?),
        })
    }

    /// Bytes that have come.
    fn bytes(&self) -> u64 {
        let sum =
            |sections: &[&Section]| sections.iter().map(|section| section.bytes()).sum::<u64>();
        match self {
            Self::Ply(all) => all.iter().map(|spool| sum(&spool.sections())).sum(),
            Self::Stl(all) => all.iter().map(|spool| sum(&spool.sections())).sum(),
            Self::Obj(all) => all.iter().map(|spool| sum(&spool.sections())).sum(),
            Self::Gltf(all) => all.iter().map(|spool| sum(&spool.sections())).sum(),
        }
    }
}

/// What all files need to be finished.
struct Finish<'a> {
    outlines: &'a [Outline],
    context: &'a MeshContext,
    job: &'a Job,
}

impl Finish<'_> {
    fn files(
        self,
        format: Format,
        sections: Sections,
        mut files: Vec<Output>,
    ) -> Result<Written, WriteError> {
        let Self { outlines, context, job } = self;
        let mut written = Written::default();
        let own = |done: Result<(), WriteFault>, out: &Output| done.map_err(|f| f.at(out.path()));
        match sections {
            Sections::Ply(all) => {
                for ((spool, out), outline) in all.into_iter().zip(&mut files).zip(outlines) {
                    own(spool.finish(out, outline, context, job), out)?;
                }
            }
            Sections::Stl(all) => {
                for ((spool, out), outline) in all.into_iter().zip(&mut files).zip(outlines) {
                    own(spool.finish(out, outline, context, job, &mut written), out)?;
                }
            }
            Sections::Obj(all) => {
                if let Some(out) = files.pop() {
                    obj::finish(all, out, outlines, context, job, &mut written)?;
                }
            }
            Sections::Gltf(all) if format == Format::Glb => {
                if let Some(out) = files.first_mut() {
                    let done = gltf::finish_glb(all, out, outlines, context, job, &mut written);
                    own(done, out)?;
                }
            }
            Sections::Gltf(all) => {
                if let Some(out) = files.pop() {
                    gltf::finish_gltf(all, out, outlines, context, job, &mut written)?;
                }
            }
        }
        name_all(files, &mut written)?;
        Ok(written)
    }
}

/// A spool for each surface, beside its file or the one of all.
fn spools<T>(
    surfaces: usize,
    files: &[Output],
    create: impl Fn(&Output) -> io::Result<T>,
) -> Result<Vec<T>, WriteError> {
    let one = |out: &Output| create(out).map_err(|error| WriteFault::Io(error).at(out.path()));
    files.iter().cycle().take(surfaces).map(one).collect()
}

impl Coming {
    fn new(head: SurfaceHead, has_normals: bool) -> Self {
        Self {
            outline: Outline { head, has_normals, ..Outline::default() },
            piece: if has_normals { TriMesh::with_normals() } else { TriMesh::default() },
            state: State::Idle,
            has_begun: false,
            needed: 0,
        }
    }

    /// Fails if a triangle names no vertex that came.
    fn check(&self) -> Result<(), WriteFault> {
        let Outline { head, counts, .. } = &self.outline;
        let flaw = sound::too_few(*counts, self.needed);
        flaw.map_or(Ok(()), |flaw| Err(sound::fault(&head.name, &flaw)))
    }

    /// Counts a piece in, and fails if it cannot follow those that came.
    fn announce(
        &mut self,
        format: Format,
        more: Counts,
        precision: Precision,
    ) -> Result<(), WriteFault> {
        let Outline { counts, precision: held, .. } = &mut self.outline;
        if self.has_begun && *held != precision {
            let fault = "its pieces differ in precision";
            return Err(sound::fault(&self.outline.head.name, fault));
        }
        let vertices = counts.vertices.saturating_add(more.vertices);
        if vertices > u32::MAX.into() {
            return Err(WriteFault::TooLarge {
                format,
                what: "vertices of a surface",
                needed: vertices,
                limit: u32::MAX.into(),
                remedy: "extract it in parts",
            });
        }
        (*held, self.has_begun) = (precision, true);
        counts.vertices = vertices;
        counts.triangles = counts.triangles.saturating_add(more.triangles);
        Ok(())
    }

    /// Fails if a piece may not take so much memory.
    fn probe(&self, counts: Counts, job: &Job) -> Result<(), OverLimit> {
        let Outline { precision, has_normals, .. } = self.outline;
        let bytes = counts.bytes(precision, has_normals);
        job.limits.probe("a piece of a surface", bytes, 1).map(drop)
    }
}

/// Takes one surface of a [`MeshSpool`] piece by piece.
#[derive(Debug)]
pub struct SpoolSink<'a> {
    spool: &'a mut MeshSpool,
    surface: usize,
}

impl MeshSink for SpoolSink<'_> {
    type Error = WriteError;

    /// As the spool was asked for, but STL has none.
    fn wants_normals(&self) -> bool {
        self.spool.surfaces.get(self.surface).is_some_and(|coming| coming.outline.has_normals)
    }

    fn piece(&mut self, counts: Counts, precision: Precision) -> Result<Piece<'_>, WriteError> {
        let (spool, n) = (&mut *self.spool, self.surface);
        let taken = spool.make_room(n, counts, precision);
        taken.map_err(|fault| fault.at(spool.path(n)))?;
        Ok(spool.surfaces[n].piece.renew(counts, precision))
    }
}

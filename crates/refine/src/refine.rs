//! The entry: a mesh, the surface that it stands for, and what is wanted.

use crate::{
    Isosurface, RefineError, RefineOptions, Subdivision,
    balance::balance,
    build::build,
    crease::crease,
    edges::{Edges, NEW},
    exact::in_chunks,
    ground::Ground,
    known::Known,
    sagitta::Sagitta,
    split::{HALVED, Split, WHOLE, middle},
};
use isokit_job::Job;
use isokit_lanes::exactly;
use isokit_mesh::{Precision, TriMesh};

/// What became of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Refined {
    /// Vertices that are new on creases, and where they meet.
    pub creased: u64,
    /// How often edges were divided.
    pub rounds: u32,
    /// Vertices that are new.
    pub new_vertices: u64,
    /// New vertices that stayed in the middle of their edges, because the field has no surface near it along
    /// its gradient, or beside the border along that, or because a triangle would have become flat or turned over, or two
    /// vertices met in one place. Those on caps along a closed border, which is no surface of the field, are not among them.
    pub unprojected: u64,
    /// Edges that were to be divided and are not, each time counted, because a triangle would have become
    /// flat, or two vertices met, even so.
    pub undivided: u64,
    /// With [`Subdivision::MaxError`], the greatest distance in world units by which a triangle may leave
    /// the surface, as far as the Hessian of the field tells at corners and middles of sides, over all
    /// triangles but the `unbounded`; `None` if it is known of none. It is that of the divided triangles, before
    /// [`RefineOptions::balance`] moves them: that trades the greatest distance for a less mean one.
    pub bound: Option<f64>,
    /// With [`Subdivision::MaxError`], triangles of which that was not reached or is not known: in noise, where the surface
    /// bends within a cell, next to samples without a value, where positions are too coarse, and after ten rounds.
    pub unbounded: u64,
    /// Vertices that balance moved along their normals.
    pub balanced: u64,
    /// Vertices that it did not, because there is no normal or the field has no value there, or because a
    /// triangle would have become flat or turned over, or two vertices met; those of caps are not among them.
    pub unbalanced: u64,
}

/// Brings a mesh nearer to the surface that it stands for. Its vertices should be on it, as
/// `Placement::Cubic` puts them; where they are not, they stay, and their neighbours are better than they.
///
/// No triangle becomes flat and no vertex gets to where another one is, as positions are kept, and as a file will
/// ([`RefineOptions::file_scale`]); where the mesh had such, it may keep them.
///
/// Normals, if the mesh has some, are outward unit vectors of the surface, best those of `Gradient::Matching`. New
/// vertices get those of the field, and balance moves all vertices along what they have; a mesh without normals is balanced along those of the
/// field, which takes several times as long. A mesh without triangles is left alone.
///
/// Beside the mesh, and the new one, some 200 bytes per triangle are in use meanwhile.
///
/// # Errors
///
/// If the options mean nothing, the mesh has triangles that name a vertex twice or one that is not there, the
/// new mesh has 2³² vertices or triangles or more, or the job is cancelled or allows less memory. The mesh
/// is then as the last whole step left it.
pub fn refine(
    mesh: &mut TriMesh,
    surface: &Isosurface<'_>,
    options: &RefineOptions,
    job: &Job,
) -> Result<Refined, RefineError> {
    check(mesh, surface, options, job)?;
    exactly(|| refined(mesh, surface, options, job))
}

fn refined(
    mesh: &mut TriMesh,
    surface: &Isosurface<'_>,
    options: &RefineOptions,
    job: &Job,
) -> Result<Refined, RefineError> {
    let precision = mesh.positions.precision();
    let file_scale = options.file_scale.filter(|_| precision == Precision::F32);
    let ground = Ground::new(*surface, precision).with_file_scale(file_scale);
    if file_scale.is_some_and(|scale| !ground.fits(scale)) {
        return Err(RefineError::Options("files in a unit in which f32 cannot hold the positions"));
    }
    let mut refined = Refined::default();
    if mesh.triangles.is_empty() {
        return Ok(refined);
    }
    if let Some(degrees) = options.creases {
        refined.creased = crease(mesh, &ground, degrees.to_radians(), job)?;
    }
    match options.subdivision {
        Subdivision::None => {}
        Subdivision::Levels(levels) => {
            for _ in 0..levels {
                let edges = Edges::new(mesh, job)?;
                let divided = refined.divide((mesh, &edges), &ground, |_| true, job)?;
                let Some(Divided { built, .. }) = divided else { break };
                *mesh = built;
            }
        }
        Subdivision::MaxError(error) => refined.bounded(mesh, &ground, error, job)?,
    }
    if options.balance {
        (refined.balanced, refined.unbalanced) = balance(mesh, &ground, job)?;
    }
    Ok(refined)
}

fn check(
    mesh: &TriMesh,
    surface: &Isosurface<'_>,
    options: &RefineOptions,
    job: &Job,
) -> Result<(), RefineError> {
    if !surface.iso.is_finite() {
        return Err(RefineError::Options("the surface of a value that is no finite number"));
    }
    if options.creases.is_some_and(|degrees| !(degrees > 0.0 && degrees < 180.0)) {
        return Err(RefineError::Options("creases of an angle that is not above 0 and below 180"));
    }
    if options.file_scale.is_some_and(|scale| !(scale > 0.0 && scale.is_finite())) {
        return Err(RefineError::Options("files whose unit is not above 0"));
    }
    match options.subdivision {
        Subdivision::Levels(levels) if !(1..=Subdivision::MOST).contains(&levels) => {
            return Err(RefineError::Options("so many times: 1 to 6 are possible"));
        }
        Subdivision::MaxError(error) if !(error > 0.0 && error.is_finite()) => {
            return Err(RefineError::Options("to an error that is not above 0"));
        }
        _ => {}
    }
    let vertices = mesh.positions.len();
    if mesh.normals.as_ref().is_some_and(|normals| normals.len() != vertices) {
        return Err(RefineError::Options("a mesh that has not one normal for each vertex"));
    }
    let is_sound =
        |[a, b, c]: [u32; 3]| a != b && b != c && c != a && (a.max(b).max(c) as usize) < vertices;
    let unsound = in_chunks(mesh.triangles.len(), &job.unwatched(), |mut range| {
        range.find(|&t| !is_sound(mesh.triangles[t]))
    })?;
    let first = unsound.into_iter().flatten().next();
    first.map_or(Ok(()), |triangle| Err(RefineError::Unsound { triangle }))
}

/// A mesh whose chosen edges were divided.
struct Divided<'a> {
    split: Split<'a>,
    built: TriMesh,
    /// The new vertices by the edges that had them.
    numbers: Vec<u32>,
}

impl Refined {
    /// Divides until the error is kept. What is known of edges that stay is carried on.
    fn bounded(
        &mut self,
        mesh: &mut TriMesh,
        ground: &Ground<'_>,
        error: f64,
        job: &Job,
    ) -> Result<(), RefineError> {
        let mut edges = Edges::new(mesh, job)?;
        let mut from = vec![NEW; edges.len()];
        let mut known = Known::default();
        for round in 0.. {
            known = known.carried((mesh, &edges), &from, ground, job)?;
            let sagitta = Sagitta::of((mesh, &edges), &known, error, job)?;
            (self.bound, self.unbounded) = (sagitta.bound, sagitta.unbounded);
            let chosen = |edge: usize| sagitta.is_too_long(edge);
            if round == Sagitta::ROUNDS || !(0..edges.len()).any(chosen) {
                break;
            }
            let divided = self.divide((mesh, &edges), ground, chosen, job)?;
            let Some(Divided { split, built, numbers }) = divided else { break };
            (edges, from) = edges.after(&split, (&built, &numbers), job)?;
            *mesh = built;
        }
        Ok(())
    }

    /// Divides the chosen edges, if any can be.
    fn divide<'a>(
        &mut self,
        (mesh, edges): (&'a TriMesh, &'a Edges),
        ground: &Ground<'_>,
        chosen: impl Fn(usize) -> bool + Sync,
        job: &Job,
    ) -> Result<Option<Divided<'a>>, RefineError> {
        let split = Split::new((mesh, edges), ground, &chosen, job)?;
        let states = &split.states;
        let (mut new, mut unprojected, mut undivided) = (0, 0, 0);
        for (edge, &state) in states.iter().enumerate() {
            new += u64::from(state != WHOLE);
            undivided += u64::from(state == WHOLE && chosen(edge));
            if state == HALVED {
                let is_cap = ground.spot(middle(mesh, edges.ends[edge])).is_beyond;
                unprojected += u64::from(!is_cap);
            }
        }
        self.undivided += undivided;
        if new == 0 {
            return Ok(None);
        }
        let (built, numbers) = build((mesh, edges), &split, ground, job)?;
        self.rounds += 1;
        self.new_vertices += new;
        self.unprojected += unprojected;
        Ok(Some(Divided { split, built, numbers }))
    }
}

#[cfg(test)]
mod tests;

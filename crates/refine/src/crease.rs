//! Vertices and edges where the faces of a solid meet.
//!
//! Marching cubes puts no vertex on a crease: its triangles cut creases off. An edge of the mesh whose ends lie on two
//! faces is cut where the tangent planes at its ends meet. From there the faces are asked again, ever nearer to the
//! crease, so that it is found where they are curved too, and none is found where what seemed a crease is round. The
//! triangles that come of it lie on one face each, and the edges between new vertices along the crease.
//!
//! Where the corners of a triangle are on three faces, and these meet in a point, that is a vertex too.
//!
//! That planes at vertices tell where a crease is: Kobbelt, Botsch, Schwanecke & Seidel 2001, "Feature sensitive surface
//! extraction from volume data", section 3, for the cells of a volume. That triangles which cut creases off can be
//! mended in the mesh: Attene, Falcidieno, Rossignac & Spagnuolo 2005, "Sharpen & Bend".

mod bricks;
mod face;

use crate::{
    RefineError,
    build::{build, longer},
    edges::Edges,
    exact::in_chunks,
    ground::Ground,
    places::Things,
    settle::{Rules, settle},
    split::{Corner, Cut, Split, WHOLE, rounded},
};
use bricks::in_bricks;
use face::{Face, crossing, meeting_point};
use isokit_geom::vector::{Vector, length, normal, sub};
use isokit_job::Job;
use isokit_mesh::{Positions, TriMesh};

/// Gives a mesh vertices on the creases of its surface: where faces meet whose normals differ by more than `angle`, in
/// radians. Vertices that are there are brought onto the surface. How many are new.
pub(crate) fn crease(
    mesh: &mut TriMesh,
    ground: &Ground<'_>,
    angle: f64,
    job: &Job,
) -> Result<u64, RefineError> {
    const WHAT: &str = "the faces of the surface";
    let per_vertex = 4 * size_of::<Option<Face>>() + size_of::<([i64; 3], u32, u8)>();
    job.limits.probe(WHAT, Some(mesh.positions.len() as u64), per_vertex)?;
    job.progress.begin("crease", 2 * mesh.positions.len() as u64);
    let faces = bring(mesh, ground, job)?;
    if let Some(normals) = &mut mesh.normals {
        let known = normals.iter_mut().zip(&faces);
        known.for_each(|(own, face)| face.iter().for_each(|face| *own = face.outward()));
    }
    let least = angle.cos();
    let edges = Edges::new(mesh, job)?;
    let ends = |edge: u32| edges.ends[edge as usize].map(|v| v as usize);
    let sharp: Vec<u32> = (0..edges.len() as u32)
        .filter(|&edge| matches!(ends(edge).map(|v| faces[v]), [Some(a), Some(b)] if a.meets(&b, least)))
        .collect();
    let first = |n: usize| mesh.positions.get(ends(sharp[n])[0]);
    let cross = |n: usize, ground: &Ground<'_>| {
        let [Some(a), Some(b)] = ends(sharp[n]).map(|v| faces[v]) else { return None };
        let places = ends(sharp[n]).map(|v| mesh.positions.get(v));
        crossing(places, [a, b], least, ground).map(|place| rounded(place, mesh))
    };
    let crossings = in_bricks(&first, sharp.len(), ground, cross, job)?;
    let cut = |edge: usize| match sharp.binary_search(&(edge as u32)).map(|n| crossings[n]) {
        Ok(Some(place)) => Cut::At(place),
        _ => Cut::Not,
    };
    let outward = |v: u32| faces[v as usize].map(|face| face.normal.map(|c| -c));
    let split = Split::cut((mesh, &edges), cut, Some(&outward), ground, job)?;
    let states = &split.states;
    let vertices = states.iter().filter(|&&state| state != WHOLE).count() as u64;
    if vertices == 0 {
        return Ok(0);
    }
    let corners = corners((mesh, &edges), &split, &faces, ground, job)?;
    let (mut built, _) = build((mesh, &edges), &split, ground, job)?;
    let corners = apart(corners, &built, ground, job)?;
    let added = corners.len() as u64;
    fan(&mut built, corners, job)?;
    *mesh = built;
    Ok(vertices + added)
}

/// Vertices that are nearer to the surface, in samples, are on it.
const NEAR: f64 = 1e-4;

/// Moves vertices onto the surface, along its gradient, as far as no triangle turns over and none meets another; and says on which face each is.
fn bring(
    mesh: &mut TriMesh,
    ground: &Ground<'_>,
    job: &Job,
) -> Result<Vec<Option<Face>>, RefineError> {
    let near = NEAR * ground.least_stretch();
    let look = |v: usize, ground: &Ground<'_>| {
        let from = mesh.positions.get(v);
        let face = Face::near(from, ground);
        if face.is_some_and(|face| face.height(from).abs() < near) {
            return (face, None);
        }
        let to = ground.projected(from, ground.spot(from).held());
        let to = to.map(|to| rounded(to, mesh)).filter(|&to| to != from);
        (face, to.map(|to| (to, Face::near(to, ground))))
    };
    let places = |v: usize| mesh.positions.get(v);
    let looks = in_bricks(&places, mesh.positions.len(), ground, look, job)?;
    let (mut faces, moved): (Vec<_>, Vec<_>) = looks.into_iter().unzip();
    let mut states: Vec<u8> = moved.iter().map(|to| u8::from(to.is_some())).collect();
    let place = |v: u32, states: &[u8]| match (states[v as usize], moved[v as usize]) {
        (1, Some((to, _))) => to,
        _ => mesh.positions.get(v as usize),
    };
    let rules = Rules {
        parts: &mesh.triangles,
        is_bad: |t: usize, states: &[u8]| {
            let corners = mesh.triangles[t];
            ground.is_spoiled(corners.map(|v| place(v, states)), normal(mesh.corners(corners)))
        },
        count: moved.len(),
        place: |v: usize, states: &[u8]| Some(ground.in_file(place(v as u32, states))),
    };
    settle(&mut states, &rules, job)?;
    let held = (0..states.len()).filter(|&v| states[v] == 1);
    for (v, (to, face)) in held.filter_map(|v| Some((v, moved[v]?))) {
        faces[v] = face;
        match &mut mesh.positions {
            Positions::F32(all) => all[v] = to.map(|c| c as f32),
            Positions::F64(all) => all[v] = to,
        }
    }
    Ok(faces)
}

/// A vertex within a triangle, which becomes three.
struct Inner {
    /// The triangle's number in the mesh that was built.
    triangle: usize,
    place: Vector,
    normal: [f32; 3],
}

/// Where three faces meet in triangles that were cut on all sides.
fn corners(
    (mesh, edges): (&TriMesh, &Edges),
    split: &Split<'_>,
    faces: &[Option<Face>],
    ground: &Ground<'_>,
    job: &Job,
) -> Result<Vec<Inner>, RefineError> {
    let states = &split.states[..];
    let found = in_chunks(mesh.triangles.len(), &job.unwatched(), |range| {
        let (mut made, mut inner) = (0, vec![]);
        for t in range {
            let cuts = edges.sides[t].iter().filter(|&&e| states[e as usize] != WHOLE).count();
            if cuts == 3 {
                // The last of the four is what is between the cuts.
                let corner = corner(t, split, mesh.triangles[t].map(|v| faces[v as usize]), ground);
                inner.extend(corner.map(|(place, normal)| (made + 3, place, normal)));
            }
            made += cuts + 1;
        }
        (made, inner)
    })?;
    let (mut before, mut all) = (0, vec![]);
    for (made, inner) in found {
        let of = |(n, place, normal)| Inner { triangle: before + n, place, normal };
        all.extend(inner.into_iter().map(of));
        before += made;
    }
    Ok(all)
}

/// Where the three faces of a triangle meet, if that is on the surface and what is between the cuts can be three triangles,
/// each on its face.
fn corner(
    t: usize,
    split: &Split<'_>,
    faces: [Option<Face>; 3],
    ground: &Ground<'_>,
) -> Option<(Vector, [f32; 3])> {
    let [Some(a), Some(b), Some(c)] = faces else { return None };
    let states = &split.states[..];
    let (children, _) = split.children(t, states);
    let [ab, bc, ca] = children[3].map(|corner: Corner| split.place(corner, states));
    let middle: Vector = std::array::from_fn(|k| (ab[k] + bc[k] + ca[k]) / 3.0);
    let sides = [[ab, bc], [bc, ca], [ca, ab]].map(|[from, to]| length(sub(to, from)));
    let reach = 2.0 * sides.into_iter().fold(0.0, f64::max);
    let place = meeting_point([a, b, c], middle, reach, ground)?;
    let place = split.rounded(place);
    // A side of what is between two cuts lies on the face of the corner that they cut off.
    let fan = [([ab, bc, place], b), ([bc, ca, place], c), ([ca, ab, place], a)];
    let is_sound =
        |(corners, face): ([Vector; 3], Face)| !ground.is_spoiled(corners, face.normal.map(|c| -c));
    let sum = [0, 1, 2].map(|k| -(a.normal[k] + b.normal[k] + c.normal[k]));
    let long = length(sum);
    let outward = if long > 1e-3 { sum.map(|c| (c / long) as f32) } else { a.outward() };
    fan.into_iter().all(is_sound).then_some((place, outward))
}

/// Those that are nowhere where another one is, or a vertex of the mesh.
fn apart(
    mut inner: Vec<Inner>,
    mesh: &TriMesh,
    ground: &Ground<'_>,
    job: &Job,
) -> Result<Vec<Inner>, RefineError> {
    let held = mesh.positions.len();
    let place = |n: usize| match n.checked_sub(held) {
        None => mesh.positions.get(n),
        Some(n) => inner[n].place,
    };
    let things = Things { count: held + inner.len(), place: |n| Some(ground.in_file(place(n))) };
    let mut lost = things.sharing(|n| n >= held, job)?.concat();
    lost.sort_unstable();
    let mut n = held..;
    inner.retain(|_| n.next().is_none_or(|n| lost.binary_search(&n).is_err()));
    Ok(inner)
}

/// Makes three triangles around each new vertex.
fn fan(mesh: &mut TriMesh, inner: Vec<Inner>, job: &Job) -> Result<(), RefineError> {
    const WHAT: &str = "the corners of the surface";
    let more = inner.len();
    let held = mesh.positions.len();
    let counts = [held + more, mesh.triangles.len() + 2 * more].map(|n| n as u64);
    let [vertices, triangles] = counts;
    if vertices.max(triangles) > u64::from(u32::MAX) {
        return Err(RefineError::TooLarge { vertices, triangles });
    }
    job.limits.probe(WHAT, Some(triangles), size_of::<[u32; 3]>())?;
    let mut all = Vec::with_capacity(triangles as usize);
    let mut rest = inner.iter().zip(held as u32..).peekable();
    for (t, &[a, b, c]) in mesh.triangles.iter().enumerate() {
        match rest.next_if(|(inner, _)| inner.triangle == t) {
            Some((_, v)) => all.extend([[a, b, v], [b, c, v], [c, a, v]]),
            None => all.push([a, b, c]),
        }
    }
    mesh.triangles = all;
    let places = || inner.iter().map(|inner| inner.place);
    match &mut mesh.positions {
        Positions::F32(old) => {
            *old = longer(old, places().map(|place| place.map(|c| c as f32)), vertices as usize);
        }
        Positions::F64(old) => *old = longer(old, places(), vertices as usize),
    }
    if let Some(normals) = &mut mesh.normals {
        *normals = longer(normals, inner.iter().map(|inner| inner.normal), vertices as usize);
    }
    Ok(())
}

#[cfg(test)]
mod tests;

//! Cuts polygons into triangles so that these lie along the surface.
//!
//! The surface goes through a cell in polygons, whose corners are on its edges; where it is bent the polygons are not flat,
//! and how they are cut decides how far their triangles lie from it. With its ends on the surface a diagonal leaves it by an
//! eighth of the second fundamental form along it, and by how much the normal turns from end to end tells that:
//! (n₁ − n₀) · (p₁ − p₀), to the fourth order of its length (Rusinkiewicz 2004, "Estimating curvatures and their derivatives on triangle
//! meshes"). The way is taken whose diagonals have the least sum of squares. So the triangles of a tube lie along it, and those of a
//! saddle go down into the valley and not over it.
//!
//! To choose diagonals by what the surface is like is as old as triangulations of data: Dyn, Levin & Rippa 1990, "Data dependent
//! triangulations for piecewise linear interpolation". That marching cubes leaves the choice to itself in each cell is
//! because no diagonal lies in a face: which cells are beside it does not matter, and the mesh is closed however all are cut.
//!
//! Normals of all corners are known once the next slice is filled, so it is a pass of its own over the whole surface. Meanwhile
//! the cases of all cells are kept, a byte for each.
//!
//! Tried: the least error over the area of the triangles, from all their sides, comes nearer by a hundredth and takes several times
//! as long; the shortest diagonals gain a third as much; diagonals in faces too, flipped wherever that
//! gains, come nearer by a few hundredths with triangles so thin that they look less as the surface does.

use crate::{
    Diagonals, ExtractError, ExtractOptions,
    case::{
        COUNTS,
        polygons::{CORNERS, Filling, MOST, POLYGONS, Polygon, diagonals},
    },
    fill::split_off,
    winding::Winding,
};
use isokit_job::{Cancelled, Job};
use isokit_lanes::exactly;
use isokit_mesh::{MeshSink, Piece, PositionsMut};
use rayon::prelude::*;
use std::{
    array, mem,
    ops::{Add, Mul, Sub},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// The cases of the cells whose triangles were written, one after the other.
#[derive(Debug, Default)]
pub(crate) struct Cases(Mutex<Vec<Run>>);

/// Cells whose triangles follow each other.
#[derive(Debug)]
struct Run {
    /// The number of the first triangle.
    first: u64,
    cases: Vec<u8>,
}

impl Cases {
    /// None yet, if the options ask for them, and the sink has what they are for.
    pub(crate) fn wanted<S: MeshSink>(
        options: &ExtractOptions,
        sink: &mut S,
    ) -> Result<Option<Self>, ExtractError<S::Error>> {
        match (options.diagonals, sink.held().is_some(), sink.wants_normals()) {
            (Diagonals::Table, ..) => Ok(None),
            (Diagonals::Fitted, true, true) => Ok(Some(Self::default())),
            (Diagonals::Fitted, is_kept, _) => Err(ExtractError::Unfitted { is_kept }),
        }
    }

    /// Those of a slice, whose triangles begin with number `first`.
    pub(crate) fn add(&self, first: u64, cases: Vec<u8>) {
        if !cases.is_empty() {
            self.lock().push(Run { first, cases });
        }
    }

    /// Forgets them.
    pub(crate) fn clear(&self) {
        self.lock().clear();
    }

    /// Cuts all polygons of the surface that the sink holds anew.
    pub(crate) fn fit<S: MeshSink>(
        &self,
        sink: &mut S,
        winding: Winding,
        job: &Job,
    ) -> Result<(), ExtractError<S::Error>> {
        let mut runs = mem::take(&mut *self.lock());
        runs.sort_unstable_by_key(|run| run.first);
        let Some(Piece { positions, normals: Some(normals), triangles }) = sink.held() else {
            return Ok(());
        };
        let normals = &*normals;
        let triangles = (triangles, winding);
        match positions {
            PositionsMut::F32(positions) => {
                fit(&Vertices { positions, normals }, triangles, &runs, job)?;
            }
            PositionsMut::F64(positions) => {
                fit(&Vertices { positions, normals }, triangles, &runs, job)?;
            }
        }
        Ok(())
    }

    /// A thread that panicked ends the extraction in any case.
    fn lock(&self) -> MutexGuard<'_, Vec<Run>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn fit<C: Coordinate>(
    vertices: &Vertices<'_, C>,
    (mut triangles, winding): (&mut [[u32; 3]], Winding),
    runs: &[Run],
    job: &Job,
) -> Result<(), Cancelled> {
    let (mut tasks, mut before) = (vec![], 0);
    for run in runs {
        split_off(&mut triangles, (run.first - before) as usize);
        let count: usize =
            run.cases.iter().map(|&case| usize::from(COUNTS[usize::from(case)])).sum();
        tasks.push((&run.cases[..], split_off(&mut triangles, count)));
        before = run.first + count as u64;
    }
    tasks.into_par_iter().try_for_each(|(cases, triangles)| {
        job.check()?;
        exactly(|| match winding {
            Winding::Kept => vertices.fit::<false>(cases, triangles),
            Winding::Turned => vertices.fit::<true>(cases, triangles),
        });
        Ok(())
    })
}

/// What the choice depends on.
struct Vertices<'a, C> {
    positions: &'a [[C; 3]],
    normals: &'a [[f32; 3]],
}

impl<C: Coordinate> Vertices<'_, C> {
    /// Cuts the polygons of some cells, whose triangles are turned or not.
    fn fit<const TURNED: bool>(&self, cases: &[u8], mut triangles: &mut [[u32; 3]]) {
        let polygons = &*POLYGONS;
        for &case in cases {
            let own = split_off(&mut triangles, COUNTS[usize::from(case)].into());
            for polygon in polygons.of(case) {
                let (own, fillings) = (&mut own[polygon.first..], polygons.fillings(polygon));
                match polygon.corners {
                    4 => self.cut::<4, TURNED>(polygon, fillings, own),
                    5 => self.cut::<5, TURNED>(polygon, fillings, own),
                    6 => self.cut::<6, TURNED>(polygon, fillings, own),
                    _ => self.cut::<CORNERS, TURNED>(polygon, fillings, own),
                }
            }
        }
    }

    /// Cuts one polygon of `N` corners, which the first of `triangles` cut as the table does.
    #[inline(always)]
    fn cut<const N: usize, const TURNED: bool>(
        &self,
        polygon: &Polygon,
        fillings: &[Filling],
        triangles: &mut [[u32; 3]],
    ) {
        let triangles = &mut triangles[..N - 2];
        let named = &polygon.named[usize::from(TURNED)];
        let corners: [u32; N] = array::from_fn(|n| triangles.as_flattened()[usize::from(named[n])]);
        let places = corners.map(|v| wide(self.positions[v as usize]));
        let normals = corners.map(|v| wide(self.normals[v as usize].map(C::from)));
        let mut squares = [0.0; MOST];
        for n in 0..const { N * (N - 3) / 2 } {
            let [a, b] = const { diagonals::<N>() }[n];
            let bend: f64 = dot(minus(places[b], places[a]), minus(normals[b], normals[a])).into();
            squares[n] = bend * bend;
        }
        let sum = |filling: &Filling| {
            let own = filling.diagonals[..N - 3].iter();
            own.fold(0.0, |sum, &d| sum + squares[usize::from(d)])
        };
        // What is not a number is not less.
        let (mut best, mut least) = (polygon.own, sum(&fillings[polygon.own]));
        for (n, filling) in fillings.iter().enumerate() {
            let sum = sum(filling);
            (best, least) = if sum < least { (n, sum) } else { (best, least) };
        }
        let better = &fillings[best].triangles[..N - 2];
        if best == polygon.own || !are_sound(&places, &normals, better, TURNED) {
            return;
        }
        for (triangle, &[a, b, c]) in triangles.iter_mut().zip(better) {
            let own = if TURNED { [a, c, b] } else { [a, b, c] };
            *triangle = own.map(|n| corners[usize::from(n)]);
        }
    }
}

/// Whether all triangles between some corners look where the normals of all corners together do, by more than rounding.
#[inline(always)]
fn are_sound<const N: usize, C: Coordinate>(
    places: &[[C; 4]; N],
    normals: &[[C; 4]; N],
    triangles: &[[u8; 3]],
    turned: bool,
) -> bool {
    /// The share of the greatest area that is surely more.
    const LEAST: f32 = 1.0 / 65536.0;
    let mean = normals.iter().fold([C::from(0.0); 4], |sum, &normal| plus(sum, normal));
    let ways = places.map(|place| minus(place, places[0]));
    // The product of three vectors: a · (b × m).
    let across = ways.map(|way| cross(way, mean));
    let size = ways.iter().fold(C::from(0.0), |sum, &way| sum + dot(way, way));
    let least = C::from(LEAST * N as f32) * size;
    triangles.iter().all(|corners| {
        let [a, b, c] = corners.map(usize::from);
        let area = dot(minus(ways[b], ways[a]), minus(across[c], across[a]));
        if turned { C::from(0.0) - area > least } else { area > least }
    })
}

/// A coordinate as a surface keeps it.
trait Coordinate:
    Copy
    + Sync
    + From<f32>
    + Into<f64>
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
{
}

impl Coordinate for f32 {}
impl Coordinate for f64 {}

/// A vector with a fourth part that is 0: as wide as registers are.
#[inline(always)]
fn wide<C: Coordinate>([x, y, z]: [C; 3]) -> [C; 4] {
    [x, y, z, C::from(0.0)]
}

#[inline(always)]
fn plus<C: Coordinate>(a: [C; 4], b: [C; 4]) -> [C; 4] {
    array::from_fn(|k| a[k] + b[k])
}

#[inline(always)]
fn minus<C: Coordinate>(a: [C; 4], b: [C; 4]) -> [C; 4] {
    array::from_fn(|k| a[k] - b[k])
}

#[inline(always)]
fn dot<C: Coordinate>(a: [C; 4], b: [C; 4]) -> C {
    let each: [C; 4] = array::from_fn(|k| a[k] * b[k]);
    each[0] + each[1] + each[2]
}

#[inline(always)]
fn cross<C: Coordinate>(a: [C; 4], b: [C; 4]) -> [C; 4] {
    let turned = |v: [C; 4]| [v[1], v[2], v[0], v[3]];
    let (next_a, next_b) = (turned(a), turned(b));
    turned(array::from_fn(|k| a[k] * next_b[k] - next_a[k] * b[k]))
}

#[cfg(test)]
mod tests;

//! Surfaces that planes cut, closed where they do.
//!
//! What is inside of the surface and on the kept side of all planes is a solid again: its samples are those whose values are
//! at the isovalue or above, and that no plane cuts away. Its surface is extracted like any other, so it is closed and
//! manifold however planes and samples lie. Each vertex then goes, on its edge of the lattice, to where the edge leaves the
//! solid: where linear interpolation has the isovalue, or through a plane, whichever comes first. So the cut is flat, and
//! only its rim is cut off within a cell.

use crate::pipeline::{Normals, PipelineError, Scan, SurfaceOptions, sparse_meshes_into};
use isokit_field::{Sampled, ScalarField};
use isokit_geom::{
    Affine, HalfSpace,
    vector::{Vector, dot, length},
};
use isokit_job::Job;
use isokit_lanes::Extent;
use isokit_marching_cubes::{Diagonals, Extracted, Placement};
use isokit_mesh::{Positions, TriMesh, area_normals};
use isokit_volume::{Bricks, Grid, Points, Sample, SampleSource, View, Volume, for_any};
use std::{borrow::Cow, ops::Range};

/// A plane as the lattice sees it.
struct Cut {
    /// How much farther beyond it the next sample along x, y, z is, and how far the first; in world units.
    step: Vector,
    first: f64,
    /// Out of what is kept, one long.
    normal: Vector,
}

/// As near as vertices come to samples, in parts of an edge.
const NEAR: f64 = 1e-3;

impl Scan {
    /// The surface where the value is `iso`, of what all planes keep, closed where they cut.
    ///
    /// Where there are planes vertices are placed linearly and diagonals are the table's, whatever the options say. It takes 8 bytes for each sample;
    /// with an [index](Self::index) only for samples near the surface, if that goes through an eighth of the bricks at
    /// the most. Without a plane it is the surface as it is.
    ///
    /// # Errors
    ///
    /// As [`mesh`](Self::mesh).
    pub fn clipped_mesh(
        &self,
        iso: f64,
        planes: &[HalfSpace],
        options: &SurfaceOptions,
        job: &Job,
    ) -> Result<(TriMesh, Extracted), PipelineError> {
        let mut meshes = [TriMesh::default()];
        let extracted = match planes {
            [] => self.meshes_into(&[iso], options, &mut meshes, job)?,
            _ => self.clip_into(iso, planes, options, (&mut meshes, job))?,
        };
        let [mesh] = meshes;
        Ok((mesh, extracted.into_iter().next().expect("one isovalue has one surface")))
    }

    /// The same where there are planes, into a mesh.
    fn clip_into(
        &self,
        iso: f64,
        planes: &[HalfSpace],
        options: &SurfaceOptions,
        (meshes, job): (&mut [TriMesh; 1], &Job),
    ) -> Result<Vec<Extracted>, PipelineError> {
        let range = self.statistics(job)?.range.unwrap_or([iso, iso]);
        let linear = options.extract.clone().with_placement(Placement::Linear);
        let linear = linear.with_diagonals(Diagonals::Table); // vertices are still to be moved
        let options = options.clone().with_extract(linear);
        let (extracted, cuts) = for_any!(self.volume(), volume => {
            let view = self.view(volume);
            let cuts = cuts(&view.frame().index_to_world, planes);
            let known = self.known(volume, &self.part(), &[iso]);
            let clipped = Clipped { view, iso, steep: steep(&view, range), cuts: &cuts, known };
            let extracted = match &clipped.known {
                Some(_) => sparse_meshes_into(&clipped, &[iso], &options, meshes, job)?,
                None => {
                    let all = Self::new(clipped.all(job)?);
                    all.meshes_into(&[iso], &options, meshes, job)?
                }
            };
            (extracted, cuts)
        });
        let [mesh] = meshes;
        for_any!(self.volume(), volume => settle(mesh, &self.view(volume), iso, &cuts));
        if options.normals == Normals::Area {
            area_normals(mesh, job)?;
        }
        Ok(extracted)
    }
}

fn cuts(affine: &Affine, planes: &[HalfSpace]) -> Vec<Cut> {
    let cut = |plane: &HalfSpace| {
        let long = length(plane.normal());
        let step = affine.columns().map(|column| dot(plane.normal(), column) / long);
        let first = plane.beyond(affine.origin()) / long;
        Cut { step, first, normal: plane.normal().map(|c| c / long) }
    };
    planes.iter().map(cut).collect()
}

/// How fast what is beyond a plane falls: about as values do.
fn steep<T: Sample>(view: &View<'_, T>, [least, greatest]: [f64; 2]) -> f64 {
    let spacing = view.frame().index_to_world.spacing().into_iter().fold(0.0, f64::max);
    (0.25 * (greatest - least) / spacing).clamp(f64::MIN_POSITIVE, f64::MAX)
}

/// The values, and what is less than the isovalue beyond the planes.
struct Clipped<'a, T: Sample> {
    view: View<'a, T>,
    iso: f64,
    steep: f64,
    cuts: &'a [Cut],
    known: Option<Cow<'a, Bricks<T>>>,
}

impl<T: Sample> Clipped<'_, T> {
    /// All of them.
    fn all(&self, job: &Job) -> Result<Volume<f64>, PipelineError> {
        let [nx, ny, nz] = self.view.dims();
        let grid = self.grid();
        let mut samples: Vec<f64> =
            job.limits.zeroed("samples that planes cut", Some(grid.count()))?;
        for (slice, k) in samples.chunks_exact_mut(nx * ny).zip(0..nz) {
            job.check()?;
            self.fill(&[0..nx, 0..ny, k..k + 1], slice);
        }
        Ok(Volume::new(grid, samples).expect("a sample for each lattice point"))
    }

    fn sample(&self, ijk: [usize; 3]) -> f64 {
        let beyond = self.beyond(|cut| cut.beyond(ijk.map(|n| n as f64)));
        match beyond > 0.0 {
            true => (self.iso - self.steep * beyond).min(self.iso.next_down()),
            false => self.view.value(ijk),
        }
    }

    /// The greatest of what is told of the planes.
    fn beyond(&self, of: impl Fn(&Cut) -> f64) -> f64 {
        self.cuts.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl<T: Sample> SampleSource<f64> for Clipped<'_, T> {
    fn grid(&self) -> Grid {
        self.view.grid()
    }

    fn extent(&self, points: &Points) -> Option<Extent<f64>> {
        let stored = self.known.as_ref()?.extent(points);
        let ends =
            stored.range().map(|ends| ends.map(|end| self.view.scaling().value(end.to_f64())));
        let kept = ends.map_or(Extent::EMPTY, |[a, b]| Extent {
            least: a.min(b),
            greatest: a.max(b),
            has_nan: false,
        });
        let kept = Extent { has_nan: stored.has_nan, ..kept };
        let cut =
            Extent { least: f64::NEG_INFINITY, greatest: self.iso.next_down(), has_nan: false };
        // Rounding keeps order, so no sample of the box is nearer or farther than its corners are.
        let [nearest, farthest] = [Cut::nearest, Cut::farthest]
            .map(|corner| self.beyond(|cut| cut.beyond(corner(cut, points))));
        Some(match () {
            () if nearest > 0.0 => cut,
            () if farthest > 0.0 => kept.with(cut),
            () => kept,
        })
    }

    fn fill(&self, [x, y, z]: &Points, samples: &mut [f64]) {
        assert_eq!(samples.len(), x.len() * y.len() * z.len(), "one for each point");
        let rows = z.clone().flat_map(|k| y.clone().map(move |j| (j, k)));
        for (row, (j, k)) in samples.chunks_exact_mut(x.len().max(1)).zip(rows) {
            for (sample, i) in row.iter_mut().zip(x.clone()) {
                *sample = self.sample([i, j, k]);
            }
        }
    }
}

/// Moves vertices along their edges to where these leave the solid; on a cut they get the plane's normal, elsewhere that
/// of the field.
fn settle<T: Sample>(mesh: &mut TriMesh, view: &View<'_, T>, iso: f64, cuts: &[Cut]) {
    let affine = view.frame().index_to_world;
    let columns = affine.covector_columns();
    let field = Sampled::new(*view);
    for vertex in 0..mesh.positions.len() {
        let mut ijk = affine.inverse_point(mesh.positions.get(vertex));
        let mut on = None;
        if let Some((place, cut)) = leaves(view, iso, cuts, ijk) {
            (ijk, on) = (place, cut);
            let place = affine.point(place);
            match &mut mesh.positions {
                Positions::F32(all) => all[vertex] = place.map(|c| c as f32),
                Positions::F64(all) => all[vertex] = place,
            }
        }
        let Some(normals) = &mut mesh.normals else { continue };
        let found = match on {
            Some(cut) => cut.normal,
            None => {
                let falls = field.slope(ijk).gradient.map(|c| -c);
                [0, 1, 2].map(|k| (0..3).map(|axis| columns[axis][k] * falls[axis]).sum())
            }
        };
        let long = length(found);
        // Where the field has none, what the extraction found stays.
        if long > 0.0 && long.is_finite() {
            normals[vertex] = found.map(|c| (c / long) as f32);
        }
    }
}

/// Where the edge of a vertex leaves the solid, and through which plane, if it is through one. None of a vertex that is on
/// no edge between two samples: on the border of the volume, or within a cell.
fn leaves<'a, T: Sample>(
    view: &View<'_, T>,
    iso: f64,
    cuts: &'a [Cut],
    ijk: Vector,
) -> Option<(Vector, Option<&'a Cut>)> {
    let nearest = ijk.map(f64::round);
    let away = [0, 1, 2].map(|k| (ijk[k] - nearest[k]).abs());
    let axis = (1..3).fold(0, |most, k| if away[k] > away[most] { k } else { most });
    // Rounding leaves less than half of what vertices keep from samples.
    let is_on_edge = (0..3).all(|k| (away[k] < 0.5 * NEAR) != (k == axis));
    let dims = view.dims();
    let (mut low, mut high) = (nearest, nearest);
    (low[axis], high[axis]) = (ijk[axis].floor(), ijk[axis].floor() + 1.0);
    let is_within = |end: Vector| (0..3).all(|k| end[k] >= 0.0 && end[k] < dims[k] as f64);
    if !(is_on_edge && is_within(low) && is_within(high)) {
        return None;
    }
    let value = |end: Vector| view.value(end.map(|c| c as usize));
    let is_inside =
        |end: Vector| value(end) >= iso && cuts.iter().all(|cut| cut.beyond(end) <= 0.0);
    let (from, to) = if is_inside(low) { (low, high) } else { (high, low) };
    let (inside, outside) = (value(from), value(to));
    let mut first = (f64::INFINITY, None);
    if outside < iso {
        first.0 = (inside - iso) / (inside - outside);
    }
    for cut in cuts {
        let [before, after] = [from, to].map(|end| cut.beyond(end));
        if after > 0.0 && -before / (after - before) < first.0 {
            first = (-before / (after - before), Some(cut));
        }
    }
    let (share, cut) = first;
    let share = if share.is_finite() { share.clamp(NEAR, 1.0 - NEAR) } else { return None };
    let place = std::array::from_fn(|k| from[k] + (to[k] - from[k]) * share);
    Some((place, cut))
}

impl Cut {
    /// How far beyond the plane a place of index space is, in world units.
    fn beyond(&self, ijk: Vector) -> f64 {
        self.first + dot(self.step, ijk)
    }

    /// The corner of a box that is least beyond the plane.
    fn nearest(&self, points: &Points) -> Vector {
        self.corner(points, |step| step < 0.0)
    }

    /// The one that is most beyond it.
    fn farthest(&self, points: &Points) -> Vector {
        self.corner(points, |step| step > 0.0)
    }

    fn corner(&self, points: &Points, is_last: impl Fn(f64) -> bool) -> Vector {
        let end = |axis: usize| {
            let Range { start, end } = points[axis];
            if is_last(self.step[axis]) { end - 1 } else { start }
        };
        [0, 1, 2].map(|axis| end(axis) as f64)
    }
}

#[cfg(test)]
mod tests {
    use crate::pipeline::{Scan, SurfaceOptions};
    use isokit_geom::{
        Affine, Frame, HalfSpace,
        vector::{dot, length},
    };
    use isokit_job::Job;
    use isokit_mesh::{TriMesh, topology};
    use isokit_volume::{Grid, Volume};
    use std::f64::consts::PI;

    /// How deep a place is in a ball of radius 10 around 0.
    fn ball() -> Scan {
        let affine = Affine::axis_aligned([0.5, 0.6, 0.55], [-12.0; 3]).unwrap();
        let grid = Grid::new([49, 41, 45], Frame { index_to_world: affine, ..Frame::default() });
        let grid = grid.unwrap();
        let depth = |n: u64| {
            let place = affine.point([n % 49, n / 49 % 41, n / 2009].map(|i| i as f64));
            (10.0 - length(place)) as f32
        };
        Scan::new(Volume::new(grid, (0..grid.count()).map(depth).collect()).unwrap())
    }

    fn clipped(scan: &Scan, iso: f64, planes: &[HalfSpace]) -> TriMesh {
        let (options, job) = (SurfaceOptions::default(), Job::default());
        scan.clipped_mesh(iso, planes, &options, &job).unwrap().0
    }

    #[test]
    fn a_ball_that_a_plane_cuts_is_closed_and_flat_there_with_the_volume_of_its_cap() {
        for (normal, far) in
            [([0.0, 0.0, 1.0], 3.0), ([1.0, -2.0, 0.5], -4.0), ([3.0, 1.0, 2.0], 0.0)]
        {
            let long = length(normal);
            let plane = HalfSpace::new(normal, far * long).unwrap();
            let mesh = clipped(&ball(), 0.0, &[plane]);
            let found = topology(&mesh, &Job::default()).unwrap();
            assert_eq!(found.shortfalls(), [""; 0]);
            assert_eq!((found.components.len(), found.euler()), (1, 2));
            // All but a cap of height 10 - far.
            let height = 10.0 - far;
            let whole = 4.0 / 3.0 * PI * 1000.0;
            let expected = whole - PI * height * height * (30.0 - height) / 3.0;
            assert!(
                (found.measure.volume / expected - 1.0).abs() < 0.015,
                "{} for {expected}",
                found.measure.volume
            );
            // The farthest vertices are on the plane, and look along it.
            let unit = normal.map(|c| c / long);
            let normals = mesh.normals.as_ref().unwrap();
            let (mut on, mut area) = (0, 0.0);
            for (place, normal) in mesh.positions.iter().zip(normals) {
                let away = dot(unit, place) - far;
                assert!(away < 2e-3, "{away}");
                let outward = if away > -1e-6 { unit } else { place.map(|c| c / length(place)) };
                on += u32::from(away > -1e-6);
                let cosine = dot(normal.map(f64::from), outward);
                area += f64::from(u8::from(cosine < 0.9));
            }
            let circle = PI * (100.0 - far * far) / 0.3;
            assert!(f64::from(on) > 0.5 * circle, "{on} of {circle}");
            assert!(area < 0.02 * normals.len() as f64, "{area} of {}", normals.len());
        }
    }

    #[test]
    fn any_planes_leave_what_is_closed_and_none_or_all_of_it() {
        let plane = |normal, offset| HalfSpace::new(normal, offset).unwrap();
        let wedge = [
            plane([1.0, 0.0, 0.0], 0.0),
            plane([0.2, 1.0, 0.0], 1.0),
            plane([0.0, 0.3, -1.0], 2.0),
        ];
        let grid = Grid::new([9; 3], Frame::default()).unwrap();
        let mut state = 7_u64;
        let mut chance = |_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1);
            (state >> 60) as i8 - 8
        };
        for n in 0..60 {
            let noise = Volume::new(grid, (0..729).map(&mut chance).collect()).unwrap();
            let scan = Scan::new(noise);
            let at = f64::from(n % 7) * 0.5;
            let cuts = [plane([1.0, f64::from(n % 3), 0.0], 3.0 + at), plane([0.0, -1.0, 1.0], at)];
            let found = topology(&clipped(&scan, 0.0, &cuts), &Job::default()).unwrap();
            assert_eq!(found.shortfalls(), [""; 0], "{n}");
        }
        let found = topology(&clipped(&ball(), 0.0, &wedge), &Job::default()).unwrap();
        assert_eq!((found.shortfalls().len(), found.components.len()), (0, 1));
        let nothing = clipped(&ball(), 0.0, &[plane([0.0, 0.0, 1.0], -50.0)]);
        assert_eq!(nothing.triangles.len(), 0);
        let all = clipped(&ball(), 0.0, &[plane([0.0, 0.0, 1.0], 50.0)]);
        let linear = SurfaceOptions::default();
        let linear =
            linear.clone().with_extract(linear.extract.with_placement(super::Placement::Linear));
        assert_eq!(all.triangles, ball().mesh(0.0, &linear, &Job::default()).unwrap().triangles);
    }
}

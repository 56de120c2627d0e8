//! What a surface cuts off within each cell, told from the samples and the cell's own triangles.

use crate::sampled;
use isokit::{
    geom::Frame,
    job::Job,
    marching_cubes::{Boundary, ExtractOptions, Topology, extract, extract_into},
    mesh::{Precision, TriMesh},
    volume::{Sample, View},
};
use isokit_tests::{
    check::{Census, sides_of},
    fields,
    symmetry::{Seat, cell_of, seats},
};
use std::{array::from_fn, collections::BTreeMap, f64::consts::PI};

type Corner = [i64; 3];

/// Whether a sample is inside; what is none is outside.
pub(crate) fn is_inside<T: Sample>(view: &View<'_, T>, iso: f64, corner: Corner) -> bool {
    let dims = view.dims().map(|n| n as i64);
    let is_there = (0..3).all(|k| (0..dims[k]).contains(&corner[k]));
    is_there && view.value(corner.map(|i| i as usize)) >= iso
}

/// A mesh in f64, one length apart as the samples are, so that nothing is rounded but shares of edges.
struct Cells<'a, T: Sample> {
    view: View<'a, T>,
    iso: f64,
    places: Vec<[f64; 3]>,
    seats: Vec<Seat>,
    by_edge: BTreeMap<Corner, [f64; 3]>,
}

/// Asserts that each vertex is within its own edge, which has a sample on each side of the isovalue, or within a cell that
/// has; that what is inside of a cell is no less than nothing and no more than the cell, by the table; and that all of it
/// together is what a closed surface encloses.
#[track_caller]
pub(crate) fn assert_in_cells<T: Sample>(view: &View<'_, T>, iso: f64, options: &ExtractOptions) {
    let options = options.clone().with_precision(Some(Precision::F64));
    let view = view.with_frame(Frame::default());
    let mut mesh = TriMesh::default();
    extract_into(&view, iso, &options, &mut mesh.refill(), &Job::default()).unwrap();
    let cells = Cells::of(view, iso, &mesh);
    cells.assert_crossed();
    let volumes = cells.volumes(&mesh);
    // Sheets of a cell may cut through each other where there are more of them than the table has.
    let apart = volumes.iter().filter(|_| options.topology == Topology::Table);
    for (cell, volume) in apart {
        assert!((-1e-12..=1.0 + 1e-12).contains(volume), "{volume} in {cell:?}, {options:?}");
    }
    if options.boundary == Boundary::Closed {
        let parts = volumes.values().sum::<f64>();
        let [all, within] = [cells.whole() as f64 + parts, Census::of(&mesh).volume];
        let whole_box: f64 = view.dims().iter().map(|&n| n as f64 + 1.0).product();
        assert!((all - within).abs() <= 1e-12 * whole_box, "{all} and {within}, {options:?}");
    }
}

impl<'a, T: Sample> Cells<'a, T> {
    fn of(view: View<'a, T>, iso: f64, mesh: &TriMesh) -> Self {
        let places: Vec<_> = mesh.positions.iter().collect();
        let seats = seats(&places);
        let on = |(seat, place): (&Seat, &[f64; 3])| match seat {
            Seat::On(edge) => Some((*edge, *place)),
            Seat::Within(_) => None,
        };
        let by_edge = seats.iter().zip(&places).filter_map(on).collect();
        Self { view, iso, places, seats, by_edge }
    }

    fn is_inside(&self, corner: Corner) -> bool {
        is_inside(&self.view, self.iso, corner)
    }

    fn assert_crossed(&self) {
        for (seat, place) in self.seats.iter().zip(&self.places) {
            let [low, high] = match seat {
                Seat::On(edge) => [0, 1].map(|up| edge.map(|c| (c + up).div_euclid(2))),
                Seat::Within(_) => [0, 1].map(|up| place.map(|c| c.floor() as i64 + up)),
            };
            let corner = |n: usize| from_fn(|k| [low, high][n >> k & 1][k]);
            let inside = (0..8).filter(|&n| self.is_inside(corner(n))).count();
            assert!((1..8).contains(&inside), "{place:?} is on no cut edge and in no cut cell");
        }
    }

    /// How many cells have all their corners inside.
    fn whole(&self) -> usize {
        let [nx, ny, nz] = self.view.dims().map(|n| n as i64);
        let cells =
            (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        let is_whole = |cell: &Corner| {
            (0..8).all(|n: i64| self.is_inside(from_fn(|k| cell[k] + (n >> k & 1))))
        };
        cells.filter(is_whole).count()
    }

    /// What is inside of each cell with triangles. The flux of (x, y, z) / 3 from the cell's first corner goes out through
    /// its triangles and through the faces that do not touch this corner.
    fn volumes(&self, mesh: &TriMesh) -> BTreeMap<Corner, f64> {
        let mut of_cell: BTreeMap<Corner, Vec<[u32; 3]>> = BTreeMap::new();
        for &triangle in &mesh.triangles {
            of_cell.entry(cell_of(mesh.corners(triangle))).or_default().push(triangle);
        }
        let volume = |(cell, triangles): (Corner, Vec<[u32; 3]>)| {
            let local = |v: u32| from_fn(|k| self.places[v as usize][k] - cell[k] as f64);
            let cut: f64 = triangles.iter().map(|t| determinant(t.map(local)) / 6.0).sum();
            let sides: Vec<_> = triangles.iter().flat_map(|&t| sides_of(t)).collect();
            let is_rim = |&[a, b]: &[u32; 2]| !sides.contains(&[b, a]);
            let rim: Vec<_> = sides.iter().copied().filter(is_rim).collect();
            let faces: f64 = (0..3).map(|axis| self.face(cell, axis, &rim) / 3.0).sum();
            (cell, cut + faces)
        };
        of_cell.into_iter().map(volume).collect()
    }

    /// The area inside of a cell's upper face across an axis: what the cell's rim there runs around, and those parts of
    /// the face's own edges that are inside.
    fn face(&self, cell: Corner, axis: usize, rim: &[[u32; 2]]) -> f64 {
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        let flat = |place: [f64; 3]| [place[i] - cell[i] as f64, place[j] - cell[j] as f64];
        let in_face = |v: u32| match self.seats[v as usize] {
            Seat::On(edge) => edge[axis] == 2 * (cell[axis] + 1),
            Seat::Within(_) => false,
        };
        // The triangles are on the other side of their rim, so the face runs along it backwards.
        let rims = rim.iter().filter(|side| side.iter().all(|&v| in_face(v)));
        let rims = rims.map(|&[a, b]| [b, a].map(|v| flat(self.places[v as usize])));
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[u, v]| {
            let mut corner = cell;
            (corner[axis], corner[i], corner[j]) = (cell[axis] + 1, cell[i] + u, cell[j] + v);
            corner
        });
        let edges = (0..4).filter_map(|n| {
            let ends = [corners[n], corners[(n + 1) % 4]];
            let inside = ends.map(|corner| self.is_inside(corner));
            let cut = self.by_edge.get(&from_fn(|k| ends[0][k] + ends[1][k]));
            let [start, end] = ends.map(|corner| flat(corner.map(|c| c as f64)));
            match (inside, cut) {
                ([true, true], None) => Some([start, end]),
                ([true, false], Some(&cut)) => Some([start, flat(cut)]),
                ([false, true], Some(&cut)) => Some([flat(cut), end]),
                ([false, false], None) => None,
                _ => panic!("{ends:?} are {inside:?} inside, cut at {cut:?}"),
            }
        });
        rims.chain(edges).map(|[a, b]| (a[0] * b[1] - a[1] * b[0]) / 2.0).sum()
    }
}

fn determinant([p, q, r]: [[f64; 3]; 3]) -> f64 {
    (0..3).map(|k| p[k] * (q[(k + 1) % 3] * r[(k + 2) % 3] - q[(k + 2) % 3] * r[(k + 1) % 3])).sum()
}

/// Of a ball the sum of all cells is near to its volume, and a triangle that is turned over or missing shows in its cell alone.
#[test]
fn a_triangle_that_is_turned_over_or_missing_shows_in_its_cell() {
    let ball = sampled(&fields::sphere(0.7), 17);
    let options = ExtractOptions::DEFAULT.with_precision(Some(Precision::F64));
    let mut mesh = extract(&ball.view(), 0.0, &options, &Job::default()).unwrap();
    let volumes = |mesh: &TriMesh| Cells::of(ball.view(), 0.0, mesh).volumes(mesh);
    let whole = volumes(&mesh);
    let sum = whole.values().sum::<f64>() + Cells::of(ball.view(), 0.0, &mesh).whole() as f64;
    let expected = 4.0 / 3.0 * PI * (0.7_f64 * 8.0).powi(3);
    assert!((sum / expected - 1.0).abs() < 0.02, "{sum}, not {expected}");
    let [a, b, c] = mesh.triangles[40];
    let cell = cell_of(mesh.corners([a, b, c]));
    let changed = |mesh: &TriMesh| -> Vec<Corner> {
        let found = volumes(mesh).into_iter();
        found.filter(|(cell, volume)| whole[cell] != *volume).map(|(cell, _)| cell).collect()
    };
    mesh.triangles[40] = [a, c, b];
    assert_eq!(changed(&mesh), [cell]);
    mesh.triangles.remove(40);
    assert_eq!(changed(&mesh), [cell]);
}

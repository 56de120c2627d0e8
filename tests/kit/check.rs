//! What a mesh is, found the plain way: with maps of sides, and nothing of the library's own topology.

use isokit::mesh::TriMesh;
use std::collections::{BTreeMap, BTreeSet};

/// Everything that can be wrong with a mesh, counted, and its invariants.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Census {
    /// Connected pieces of triangles.
    pub components: usize,
    /// Vertices less sides plus triangles.
    pub euler: i64,
    /// Sides of one triangle only.
    pub boundary_sides: usize,
    /// Sides of more than two triangles.
    pub overused_sides: usize,
    /// Sides that two triangles use in the same direction.
    pub turned_sides: usize,
    /// Vertices whose triangles are not one fan, open or closed.
    pub pinched_vertices: usize,
    /// Vertices that no triangle uses.
    pub unused_vertices: usize,
    /// Vertices that lie where another one lies.
    pub coinciding_vertices: usize,
    /// Triangles without area, as the stored positions have it.
    pub flat_triangles: usize,
    /// Positions and normals with a part that is not finite, normals whose length is not 1.
    pub unsound_numbers: usize,
    /// The enclosed volume; below 0 where the inside is outside.
    pub volume: f64,
}

impl Census {
    /// Counts.
    ///
    /// # Panics
    ///
    /// If a triangle names a vertex that is not there, or one twice.
    pub fn of(mesh: &TriMesh) -> Self {
        let mut census = Self { unsound_numbers: unsound_numbers(mesh), ..Self::default() };
        census.count_sides(mesh);
        census.count_fans(mesh);
        let mut places: Vec<_> =
            mesh.positions.iter().map(|p| p.map(|c| (c + 0.0).to_bits())).collect();
        places.sort_unstable();
        census.coinciding_vertices = places.windows(2).filter(|pair| pair[0] == pair[1]).count();
        let middle = mesh.bounds().map_or([0.0; 3], |bounds| bounds.min);
        for &triangle in &mesh.triangles {
            let [p, q, r] = mesh.corners(triangle);
            let normal = cross(minus(q, p), minus(r, p));
            census.flat_triangles += usize::from(normal == [0.0; 3]);
            let [p, q, r] = [p, q, r].map(|p| minus(p, middle));
            let qr = cross(q, r);
            census.volume += (p[0] * qr[0] + p[1] * qr[1] + p[2] * qr[2]) / 6.0;
        }
        census
    }

    /// Connected pieces and Euler characteristic alone, in a fraction of the time.
    ///
    /// # Panics
    ///
    /// As [`Census::of`] does.
    pub fn shape(mesh: &TriMesh) -> (usize, i64) {
        let mut census = Self::default();
        census.count_sides(mesh);
        (census.components, census.euler)
    }

    fn count_sides(&mut self, mesh: &TriMesh) {
        let mut sides: BTreeMap<[u32; 2], [usize; 2]> = BTreeMap::new();
        let mut pieces: Vec<usize> = (0..mesh.positions.len()).collect();
        for [a, b] in mesh.triangles.iter().flat_map(|&t| sides_of(t)) {
            assert!(a != b && (a.max(b) as usize) < pieces.len(), "a side from {a} to {b}");
            sides.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
            let (a, b) = (root(&mut pieces, a as usize), root(&mut pieces, b as usize));
            pieces[a] = b;
        }
        let used: BTreeSet<u32> = mesh.triangles.iter().flatten().copied().collect();
        self.unused_vertices = mesh.positions.len() - used.len();
        self.components = used.iter().filter(|&&v| pieces[v as usize] == v as usize).count();
        self.euler = used.len() as i64 - sides.len() as i64 + mesh.triangles.len() as i64;
        let count = |holds: fn(usize, usize) -> bool| {
            sides.values().filter(|[there, back]| holds(*there, *back)).count()
        };
        self.boundary_sides = count(|there, back| there + back == 1);
        self.overused_sides = count(|there, back| there + back > 2);
        self.turned_sides = count(|there, back| there > 1 || back > 1);
    }

    /// Around a vertex every triangle leads from one neighbour to another: one path, or one ring.
    fn count_fans(&mut self, mesh: &TriMesh) {
        let mut around: BTreeMap<u32, BTreeMap<u32, u32>> = BTreeMap::new();
        let mut doubled = BTreeSet::new();
        for &[a, b, c] in &mesh.triangles {
            for (vertex, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
                if around.entry(vertex).or_default().insert(from, to).is_some() {
                    doubled.insert(vertex);
                }
            }
        }
        let pinched = around.iter().filter(|(v, next)| doubled.contains(v) || !is_one_fan(next));
        self.pinched_vertices = pinched.count();
    }

    /// What must be 0 for every surface, open or closed, whose vertices keep apart.
    pub fn faults(&self) -> usize {
        self.faults_of_topology() + self.coinciding_vertices + self.flat_triangles
    }

    /// What must be 0 for every surface, wherever its vertices lie.
    pub fn faults_of_topology(&self) -> usize {
        self.overused_sides
            + self.turned_sides
            + self.pinched_vertices
            + self.unused_vertices
            + self.unsound_numbers
    }
}

/// Asserts that a mesh is closed, two-manifold, consistently oriented and free of flat triangles.
#[track_caller]
pub fn assert_closed(mesh: &TriMesh) -> Census {
    let census = Census::of(mesh);
    assert_eq!((census.faults(), census.boundary_sides), (0, 0), "{census:?}");
    census
}

/// Asserts the same of a mesh that may end somewhere.
#[track_caller]
pub fn assert_sound(mesh: &TriMesh) -> Census {
    let census = Census::of(mesh);
    assert_eq!(census.faults(), 0, "{census:?}");
    census
}

/// Whether these steps from neighbour to neighbour are one path or one ring.
pub(crate) fn is_one_fan<V: Ord + Copy>(next: &BTreeMap<V, V>) -> bool {
    let reached: BTreeSet<V> = next.values().copied().collect();
    let first = next.keys().find(|from| !reached.contains(from)).or(next.keys().next());
    let (mut at, mut steps) = (first, 0);
    while let Some(to) = at.and_then(|from| next.get(from)) {
        steps += 1;
        at = Some(to).filter(|&to| Some(to) != first && steps < next.len());
    }
    steps == next.len()
}

/// The directed sides of a triangle.
pub fn sides_of([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn unsound_numbers(mesh: &TriMesh) -> usize {
    let positions = mesh.positions.iter().filter(|p| !p.iter().all(|c| c.is_finite())).count();
    let length = |n: &[f32; 3]| n.iter().map(|&c| f64::from(c) * f64::from(c)).sum::<f64>().sqrt();
    let is_unit = |n: &&[f32; 3]| (length(n) - 1.0).abs() < 1e-6;
    let normals = mesh.normals.iter().flatten().filter(|n| !is_unit(n)).count();
    positions + normals
}

fn root(pieces: &mut [usize], mut v: usize) -> usize {
    while pieces[v] != v {
        pieces[v] = pieces[pieces[v]];
        v = pieces[v];
    }
    v
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        a[i] * b[j] - a[j] * b[i]
    })
}

#[cfg(test)]
mod tests {
    use super::Census;
    use isokit::mesh::{Positions, TriMesh};

    const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn census(corners: &[[f32; 3]], triangles: &[[u32; 3]]) -> Census {
        let positions = Positions::F32(corners.to_vec());
        Census::of(&TriMesh {
            positions,
            normals: None,
            triangles: triangles.to_vec(),
            ..TriMesh::default()
        })
    }

    fn tetrahedron(first: u32) -> [[u32; 3]; 4] {
        [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(|t| t.map(|v| v + first))
    }

    #[test]
    fn a_tetrahedron_is_sound() {
        let volume = 1.0 / 6.0;
        let expected = Census { components: 1, euler: 2, volume, ..Census::default() };
        assert_eq!(census(&CORNERS, &tetrahedron(0)), expected);
    }

    #[test]
    fn every_fault_is_seen() {
        let whole = tetrahedron(0);
        let open = census(&CORNERS, &whole[..3]);
        assert_eq!((open.boundary_sides, open.euler, open.faults()), (3, 1, 0));
        let turned = census(&CORNERS, &[whole[0], whole[1], whole[2], [1, 3, 2]]);
        assert_eq!(turned.turned_sides, 3);
        let doubled = census(&CORNERS, &[&whole[..], &[whole[3]]].concat());
        assert_eq!((doubled.overused_sides, doubled.pinched_vertices), (3, 3));
        let unused = census(&[&CORNERS[..], &[[5.0; 3]]].concat(), &whole);
        assert_eq!((unused.unused_vertices, unused.faults()), (1, 1));
        let flat = census(&[CORNERS[0], CORNERS[1], CORNERS[1], CORNERS[3]], &whole);
        assert_eq!((flat.coinciding_vertices, flat.flat_triangles), (1, 2));
        let unsound = census(&[CORNERS[0], CORNERS[1], [f32::NAN; 3], CORNERS[3]], &whole);
        assert_eq!(unsound.unsound_numbers, 1);
        let inverted = census(&CORNERS, &whole.map(|[a, b, c]| [a, c, b]));
        assert!(inverted.volume < 0.0);
    }

    #[test]
    fn two_solids_that_share_a_vertex_are_pinched_there() {
        let second = tetrahedron(3).map(|t| t.map(|v| v.min(6)));
        let corners = [&CORNERS[..], &[[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, 0.0, 2.0]]].concat();
        let found = census(&corners, &[tetrahedron(0), second].concat());
        assert_eq!((found.pinched_vertices, found.components, found.faults()), (1, 1, 1));
    }
}

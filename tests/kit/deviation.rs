//! How far triangles are from a surface that is known, and how near they could be.

use isokit::mesh::{Positions, TriMesh};

/// A point or a displacement.
type Vector = [f64; 3];

/// How deep a point is inside, in world units: a distance, at least near the surface.
pub type Depth<'a> = &'a dyn Fn(Vector) -> f64;

/// Distances of all points of all triangles from a surface, in world units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Root mean square.
    pub rms: f64,
    /// The mean, above 0 outside.
    pub mean: f64,
    /// The greatest among the points that were looked at.
    pub greatest: f64,
}

/// Seven points of a triangle, as barycentric coordinates, with weights that make integrals of polynomials of
/// degree five exact (Radon 1948).
fn points() -> [(f64, Vector); 7] {
    let root = 15.0_f64.sqrt();
    let (near, far) = ((6.0 - root) / 21.0, (6.0 + root) / 21.0);
    let (light, heavy) = ((155.0 - root) / 1200.0, (155.0 + root) / 1200.0);
    let at = |corner: usize, other: f64| {
        std::array::from_fn(|k| if k == corner { 1.0 - 2.0 * other } else { other })
    };
    let mut points = [(0.225, [1.0 / 3.0; 3]); 7];
    for corner in 0..3 {
        points[1 + corner] = (light, at(corner, near));
        points[4 + corner] = (heavy, at(corner, far));
    }
    points
}

/// Measures seven points of each triangle.
pub fn deviation(mesh: &TriMesh, depth: Depth<'_>) -> Deviation {
    let (mut area, mut found) = (0.0, Deviation::default());
    for &triangle in &mesh.triangles {
        let corners = mesh.corners(triangle);
        let own = area_of(corners);
        area += own;
        for (weight, shares) in points() {
            let distance = -depth(mixed(corners, shares));
            found.rms += own * weight * distance * distance;
            found.mean += own * weight * distance;
            found.greatest = found.greatest.max(distance.abs());
        }
    }
    Deviation { rms: (found.rms / area).sqrt(), mean: found.mean / area, ..found }
}

/// The mesh with its vertices moved along the surface's normals so that the root mean square is the least that
/// there is: all equations at once, from distances at seven points of each triangle, by conjugate gradients.
/// `normal` tells the outward unit normal at a point. Positions become f64.
pub fn best_by_offsets(
    mesh: &TriMesh,
    depth: Depth<'_>,
    normal: &dyn Fn(Vector) -> Vector,
) -> TriMesh {
    let vertices: Vec<Vector> = mesh.positions.iter().collect();
    let normals: Vec<Vector> = vertices.iter().map(|&place| normal(place)).collect();
    // For each triangle its matrix and right-hand side.
    let of_triangle = |&triangle: &[u32; 3]| {
        let corners = mesh.corners(triangle);
        let area = area_of(corners);
        let (mut matrix, mut side) = ([[0.0; 3]; 3], [0.0; 3]);
        for (weight, shares) in points() {
            let place = mixed(corners, shares);
            let (distance, here) = (-depth(place), normal(place));
            let lift: Vector =
                std::array::from_fn(|k| shares[k] * dot(here, normals[triangle[k] as usize]));
            for i in 0..3 {
                side[i] -= area * weight * lift[i] * distance;
                for j in 0..3 {
                    matrix[i][j] += area * weight * lift[i] * lift[j];
                }
            }
        }
        (matrix, side)
    };
    let each: Vec<_> = mesh.triangles.iter().map(of_triangle).collect();
    let product = |d: &[f64]| {
        let mut product = vec![0.0; d.len()];
        for (triangle, (matrix, _)) in mesh.triangles.iter().zip(&each) {
            for (i, &v) in triangle.iter().enumerate() {
                product[v as usize] +=
                    (0..3).map(|j| matrix[i][j] * d[triangle[j] as usize]).sum::<f64>();
            }
        }
        product
    };
    let mut rest = vec![0.0; vertices.len()];
    for (triangle, (_, side)) in mesh.triangles.iter().zip(&each) {
        triangle.iter().zip(side).for_each(|(&v, part)| rest[v as usize] += part);
    }
    let square = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
    let (mut d, mut way) = (vec![0.0; vertices.len()], rest.clone());
    let (first, mut left) = (square(&rest), square(&rest));
    while left > 1e-24 * first {
        let image = product(&way);
        let step = left / way.iter().zip(&image).map(|(a, b)| a * b).sum::<f64>();
        d.iter_mut().zip(&way).for_each(|(d, way)| *d += step * way);
        rest.iter_mut().zip(&image).for_each(|(rest, image)| *rest -= step * image);
        let next = square(&rest);
        way.iter_mut().zip(&rest).for_each(|(way, rest)| *way = rest + next / left * *way);
        left = next;
    }
    let moved = |n: usize| std::array::from_fn(|k| vertices[n][k] + d[n] * normals[n][k]);
    let positions = Positions::F64((0..vertices.len()).map(moved).collect());
    TriMesh { positions, normals: None, triangles: mesh.triangles.clone(), ..TriMesh::default() }
}

fn mixed(corners: [Vector; 3], shares: Vector) -> Vector {
    let [a, b, c] = corners;
    std::array::from_fn(|k| shares[0] * a[k] + shares[1] * b[k] + shares[2] * c[k])
}

fn area_of([a, b, c]: [Vector; 3]) -> f64 {
    let (u, v): (Vector, Vector) =
        (std::array::from_fn(|k| b[k] - a[k]), std::array::from_fn(|k| c[k] - a[k]));
    let normal: Vector =
        std::array::from_fn(|k| u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3]);
    0.5 * dot(normal, normal).sqrt()
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::{best_by_offsets, deviation, points};
    use isokit::mesh::{Positions, TriMesh};

    #[test]
    fn integrals_of_degree_five_are_exact() {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for (a, b) in (0..=5).flat_map(|a| (0..=5 - a).map(move |b| (a, b))) {
            let found: f64 = points().iter().map(|(w, p)| w * p[0].powi(a) * p[1].powi(b)).sum();
            let exact = 2.0 * factorial(a) * factorial(b) / factorial(2 + a + b);
            assert!((found - exact).abs() < 1e-14, "{a}, {b}: {found}, {exact}");
        }
    }

    /// Of an equilateral triangle in a ball all vertices are moved alike, and the best is known.
    #[test]
    fn one_triangle_is_raised_by_the_mean_of_what_it_lacks() {
        let (side, radius) = (0.1_f64, 10.0_f64);
        let height = (radius * radius - side * side / 3.0).sqrt();
        let corner = |n: f64| {
            let angle = n * std::f64::consts::TAU / 3.0;
            [angle.cos(), angle.sin()].map(|c| c * side / 3.0_f64.sqrt())
        };
        let corners = [0.0, 1.0, 2.0].map(corner).map(|[x, y]| [x, y, height]);
        let positions = Positions::F64(corners.to_vec());
        let mesh =
            TriMesh { positions, normals: None, triangles: vec![[0, 1, 2]], ..TriMesh::default() };
        let length = |p: [f64; 3]| p.iter().map(|c| c * c).sum::<f64>().sqrt();
        let depth = |p| radius - length(p);
        let normal = |p| {
            [0, 1, 2].map(|k: usize| -> f64 {
                let p: [f64; 3] = p;
                p[k] / length(p)
            })
        };
        let lacks = side * side / 8.0 / radius;
        let found = deviation(&mesh, &depth);
        assert!((found.mean / -lacks - 1.0).abs() < 1e-3, "{found:?}");
        let best = deviation(&best_by_offsets(&mesh, &depth, &normal), &depth);
        assert!(best.mean.abs() < 1e-4 * lacks && best.rms < 0.5 * found.rms, "{best:?}");
    }
}

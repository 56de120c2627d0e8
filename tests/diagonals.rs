//! What fitted diagonals do to the error of triangles, and what they leave as it was.

use isokit::{
    geom::{
        Affine,
        vector::{dot, length},
    },
    job::Job,
    marching_cubes::{Boundary, Diagonals, ExtractOptions, Gradient, Placement},
    mesh::TriMesh,
    pipeline::{Normals, Scan, SurfaceOptions},
    refine::RefineOptions,
};
use isokit_tests::{
    check::assert_sound,
    deviation::deviation,
    fields::{self, Field, gradient},
    volumes,
};

/// How deep a place is in a tube of radius 0.4 that lies across all axes.
fn tube() -> Field {
    let along = [0.37, 0.51, 0.78];
    Box::new(move |place| {
        let way = dot(place, along) / length(along);
        0.4 - (dot(place, place) - way * way).max(0.0).sqrt()
    })
}

fn metaballs() -> Field {
    fields::metaballs(&[[-0.3, -0.1, 0.05], [0.25, 0.15, -0.1], [0.1, -0.35, 0.2]], 0.4)
}

/// The depth in a field, to first order.
fn depth(field: Field) -> Field {
    Box::new(move |place| field(place) / length(gradient(&field, place)))
}

fn options(placement: Placement, diagonals: Diagonals) -> SurfaceOptions {
    let extract = ExtractOptions::DEFAULT.with_boundary(Boundary::Open); // caps are no surface
    let extract = extract.with_placement(placement).with_diagonals(diagonals);
    SurfaceOptions::default().with_extract(extract)
}

/// The same surface cut by the table and fitted, then balanced or not.
fn both(scan: &Scan, placement: Placement, refine: &RefineOptions) -> [TriMesh; 2] {
    [Diagonals::Table, Diagonals::Fitted].map(|diagonals| {
        let (options, job) = (options(placement, diagonals), Job::default());
        let mut mesh = scan.mesh(0.0, &options.before(refine), &job).unwrap();
        scan.refine(0.0, &mut mesh, (refine, &options), &job).unwrap();
        mesh
    })
}

/// The root mean square angle between triangles and the field, in degrees.
fn angle(mesh: &TriMesh, field: &Field) -> f64 {
    let (mut area, mut square) = (0.0, 0.0);
    for &triangle in &mesh.triangles {
        let corners = mesh.corners(triangle);
        let normal = isokit::geom::vector::normal(corners);
        let middle = [0, 1, 2].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0);
        let steep = gradient(field, middle);
        let cosine = -dot(normal, steep) / (length(normal) * length(steep));
        area += length(normal);
        square += length(normal) * cosine.clamp(-1.0, 1.0).acos().powi(2);
    }
    (square / area).sqrt().to_degrees()
}

#[test]
fn triangles_are_nearer_to_smooth_surfaces_and_look_more_as_they_do() {
    // What is left of the root mean square at most, of angles, and of balanced surfaces.
    for (name, field, [rms, angles, balanced]) in [
        ("ball", fields::sphere(0.7), [1.0, 1.0, 1.01]),
        ("ring", fields::torus(0.6, 0.25), [0.85, 0.8, 0.9]),
        ("tube", tube(), [0.75, 0.7, 0.75]),
        ("gyroid", depth(fields::gyroid(1.0)), [0.85, 1.0, 0.9]),
        ("finer gyroid", depth(fields::gyroid(1.5)), [0.87, 1.0, 0.9]),
        ("soft balls", depth(metaballs()), [0.98, 1.0, 1.0]),
        ("waves", depth(fields::waves()), [0.85, 1.0, 0.9]),
    ] {
        let scan = Scan::new(volumes::cube(&field, 41));
        for placement in [Placement::Linear, Placement::Cubic, Placement::Quintic] {
            let [plain, fitted] = both(&scan, placement, &RefineOptions::DEFAULT);
            assert_sound(&fitted);
            assert_eq!(plain.positions, fitted.positions);
            let [before, after] = [&plain, &fitted].map(|mesh| deviation(mesh, &field).rms);
            assert!(after < rms * before, "{name}, {placement:?}: {after:e} of {before:e}");
            let [before, after] = [&plain, &fitted].map(|mesh| angle(mesh, &field));
            assert!(after < angles * before, "{name}, {placement:?}: {after}° of {before}°");
        }
        let balance = RefineOptions::DEFAULT.with_balance(true);
        let meshes = both(&scan, Placement::Cubic, &balance);
        let [before, after] = meshes.each_ref().map(|mesh| deviation(mesh, &field).rms);
        assert!(after < balanced * before, "{name}, balanced: {after:e} of {before:e}");
    }
}

#[test]
fn what_is_fitted_may_be_divided_and_balanced() {
    let refine = RefineOptions::DEFAULT.with_balance(true);
    let refine = refine.with_subdivision(isokit::refine::Subdivision::Levels(1));
    for (says, scan) in [
        ("noise", Scan::new(volumes::noise([9, 8, 10], 3))),
        ("ties", Scan::new(volumes::ties([9, 8, 10], 2, 5))),
    ] {
        let [plain, fitted] = both(&scan, Placement::Cubic, &refine);
        assert_sound(&fitted);
        assert_eq!(plain.counts(), fitted.counts(), "{says}");
        assert_ne!(plain.triangles, fitted.triangles, "{says}");
    }
}

#[test]
fn normals_that_are_not_kept_choose_the_same_diagonals() {
    let scan = Scan::new(volumes::cube(&fields::torus(0.6, 0.25), 33));
    let options = options(Placement::Quintic, Diagonals::Fitted);
    let job = Job::default();
    let kept = scan.mesh(0.0, &options, &job).unwrap();
    for normals in [Normals::Area, Normals::None] {
        let mesh = scan.mesh(0.0, &options.clone().with_normals(normals), &job).unwrap();
        assert_eq!(mesh.triangles, kept.triangles, "{normals:?}");
        assert_ne!(mesh.normals, kept.normals, "{normals:?}");
        assert_eq!(mesh.normals.is_none(), normals == Normals::None);
    }
}

#[test]
fn in_a_frame_that_mirrors_the_same_diagonals_are_chosen() {
    let [there, back] = [1.0, -1.0].map(|sign| {
        let affine = Affine::axis_aligned([0.1, 0.11, 0.12 * sign], [-1.0, -1.1, -1.2 * sign]);
        let field = fields::waves();
        let mirrored: Field = Box::new(move |[x, y, z]| field([x, y, sign * z]));
        let scan = Scan::new(volumes::placed(&mirrored, [21; 3], affine.unwrap()));
        let options = options(Placement::Quintic, Diagonals::Fitted);
        scan.mesh(0.2, &options, &Job::default()).unwrap()
    });
    let turned = |&[a, b, c]: &[u32; 3]| [a, c, b];
    assert_eq!(there.triangles, back.triangles.iter().map(turned).collect::<Vec<_>>());
}

#[test]
fn matching_normals_choose_no_worse() {
    let field = depth(fields::gyroid(1.0));
    let scan = Scan::new(volumes::cube(&field, 33));
    let [central, matching] = [Gradient::Central, Gradient::Matching].map(|gradient| {
        let mut options = options(Placement::Quintic, Diagonals::Fitted);
        options.extract = options.extract.with_gradient(gradient);
        deviation(&scan.mesh(0.0, &options, &Job::default()).unwrap(), &field).rms
    });
    assert!(matching < 1.001 * central, "{matching:e} of {central:e}");
}

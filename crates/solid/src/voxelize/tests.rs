//! Samples against single answers, volumes against exact ones, meshes against what comes back.

use super::{VoxelError, VoxelMode, VoxelOptions, Walls, half_diagonal, voxelize};
use crate::{
    MeshSolid, SolidOptions, Winding,
    kit::{Chance, around, ball, broken, cube, moved, oblique, threads, turned},
};
use isokit_job::{Job, Limits};
use isokit_mesh::TriMesh;
use isokit_volume::{AnyVolume, Grid};

fn solid(mesh: &TriMesh) -> MeshSolid {
    MeshSolid::new(mesh, SolidOptions::default(), &Job::default()).unwrap()
}

fn distances(solid: &MeshSolid, grid: Grid, options: &VoxelOptions, job: &Job) -> Vec<f32> {
    match voxelize(solid, grid, options, job).unwrap() {
        AnyVolume::F32(volume) => volume.samples().to_vec(),
        other => panic!("{:?}", other.dtype()),
    }
}

fn occupancy(solid: &MeshSolid, grid: Grid, walls: Walls) -> Vec<u8> {
    let options = VoxelOptions { mode: VoxelMode::Occupancy, walls, ..VoxelOptions::default() };
    match voxelize(solid, grid, &options, &Job::default()).unwrap() {
        AnyVolume::U8(volume) => volume.samples().to_vec(),
        other => panic!("{:?}", other.dtype()),
    }
}

fn points(grid: &Grid) -> Vec<[f64; 3]> {
    let [nx, ny, nz] = grid.dims();
    let all = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
    all.map(|ijk| grid.frame.index_to_world.point(ijk.map(|c| c as f64))).collect()
}

#[test]
fn a_sample_is_what_its_point_is_told_to_the_bit() {
    let as_it_is = SolidOptions { winding: Winding::AsItIs, ..SolidOptions::default() };
    let mut chance = Chance(12);
    let meshes =
        [cube(), ball(10), broken(), chance.soup(40), TriMesh::joined(&[ball(6), cube()]).unwrap()];
    for mesh in meshes {
        for options in [SolidOptions::default(), as_it_is] {
            let solid = MeshSolid::new(&mesh, options, &Job::default()).unwrap();
            for grid in [around(19), oblique()] {
                let found = distances(&solid, grid, &VoxelOptions::default(), &Job::default());
                for (n, (found, p)) in found.into_iter().zip(points(&grid)).enumerate() {
                    let alone = solid.signed_distance(p) as f32;
                    assert_eq!(found.to_bits(), alone.to_bits(), "{n}: {found}, not {alone}");
                }
            }
        }
    }
}

#[test]
fn beyond_the_band_there_is_the_band() {
    for band in [0.01, 0.3] {
        for mesh in [ball(12), broken()] {
            let (solid, job) = (solid(&mesh), Job::default());
            let whole = distances(&solid, around(27), &VoxelOptions::default(), &job);
            let options = VoxelOptions { band: Some(band), ..VoxelOptions::default() };
            let narrow = distances(&solid, around(27), &options, &job);
            let clamped = whole.iter().map(|d| d.clamp(-band as f32, band as f32));
            assert!(clamped.eq(narrow), "{band}");
        }
    }
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let solid = solid(&broken());
    let of = |count| distances(&solid, oblique(), &VoxelOptions::default(), &threads(count));
    let one = of(1);
    assert!([2, 7].into_iter().all(|count| of(count) == one));
    let again = MeshSolid::new(&broken(), SolidOptions::default(), &threads(7)).unwrap();
    assert_eq!(distances(&again, oblique(), &VoxelOptions::default(), &threads(3)), one);
}

#[test]
fn occupied_is_what_is_not_outside() {
    for mesh in [cube(), broken(), turned(&ball(9))] {
        let solid = solid(&mesh);
        let signed = distances(&solid, oblique(), &VoxelOptions::default(), &Job::default());
        let expected = signed.iter().map(|&distance| u8::from(distance >= 0.0));
        assert!(expected.eq(occupancy(&solid, oblique(), Walls::AsTheyAre)));
    }
}

#[test]
fn thin_walls_are_kept_if_that_is_asked_for() {
    // A plate of a tenth of the spacing, between samples; and an open sheet, which has no inside.
    let plate = moved(&cube(), |[x, y, z]| [0.8 * x, 0.8 * y, 0.01 * z + 0.07]);
    let mut sheet = plate.clone();
    sheet.triangles.truncate(2);
    let sheet = moved(&sheet, |[x, y, z]| [0.8 * (z - 0.07) * 100.0, y, x * 0.1]);
    let grid = around(31);
    for mesh in [plate, sheet] {
        let solid = solid(&mesh);
        assert!(occupancy(&solid, grid, Walls::AsTheyAre).iter().all(|&sample| sample == 0));
        let kept = occupancy(&solid, grid, Walls::Kept);
        // The nearest sample of every place of the mesh is inside.
        let mut chance = Chance(13);
        for _ in 0..2000 {
            let triangle = mesh.triangles[chance.below(mesh.triangles.len() as u32) as usize];
            let [a, b, c] = mesh.corners(triangle);
            let (mut u, mut v) = (chance.number().abs(), chance.number().abs());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let p = [0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]));
            let ijk = grid.frame.index_to_world.inverse_point(p).map(|c| c.round() as usize);
            assert_eq!(kept[(ijk[2] * 31 + ijk[1]) * 31 + ijk[0]], 1, "{p:?}");
        }
        let signed = distances(&solid, grid, &VoxelOptions::default(), &Job::default());
        let half = half_diagonal(&grid.frame.index_to_world) as f32;
        let near = signed.iter().map(|distance| u8::from(*distance >= -half));
        assert!(near.zip(&kept).filter(|(a, b)| a != *b).count() <= 2, "but for rounding");
    }
}

#[test]
fn the_share_of_samples_inside_comes_near_to_the_volume() {
    // Errors of lattice points in a smooth body are of an order between 1 and 2.
    let exact = isokit_mesh::measure(&ball(24), &Job::default()).unwrap().volume;
    let errors = [17_u64, 33, 65].map(|n| {
        let inside = occupancy(&solid(&ball(24)), around(n), Walls::AsTheyAre);
        let cell = (3.0 / (n - 1) as f64).powi(3);
        let count = inside.into_iter().map(u64::from).sum::<u64>();
        (count as f64 * cell / exact - 1.0).abs()
    });
    let bounds = [0.02, 0.01, 0.005];
    assert!(errors.iter().zip(bounds).all(|(error, bound)| *error < bound), "{errors:?}");
}

#[test]
fn a_surface_with_holes_has_the_side_that_its_winding_says() {
    let mut mesh = ball(16);
    let holes = |mesh: &TriMesh, t: &[u32; 3]| mesh.corners(*t)[0][2] < 0.7;
    mesh.triangles = mesh.triangles.iter().copied().filter(|t| holes(&mesh, t)).collect();
    let solid = solid(&mesh);
    let found = distances(&solid, around(22), &VoxelOptions::default(), &Job::default());
    for (found, p) in found.into_iter().zip(points(&around(22))) {
        assert_eq!(found >= 0.0, solid.winding(p, 0.0) >= 0.5 || found == 0.0, "{p:?}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let solid = solid(&cube());
    for band in [0.0, -1.0, f64::NAN] {
        let options = VoxelOptions { band: Some(band), ..VoxelOptions::default() };
        let error = voxelize(&solid, around(5), &options, &Job::default()).unwrap_err();
        assert!(matches!(error, VoxelError::Band(_)), "{error}");
    }
    let job = Job { limits: Limits { bytes: 1000 }, ..Job::default() };
    let error = voxelize(&solid, around(7), &VoxelOptions::default(), &job).unwrap_err();
    assert_eq!(error.to_string(), "the volume needs 1372 bytes, the limit is 1000");
}

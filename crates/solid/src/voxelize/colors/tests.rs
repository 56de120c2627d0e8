//! Colours against what is known of them, on smooth shapes and on triangles by chance.

use crate::{
    MeshSolid, SolidError, SolidOptions, VoxelError, VoxelMode, VoxelOptions, Walls,
    distance::near,
    kit::{Chance, around, ball, cube, grid, oblique, threads},
    voxelize, voxelize_with_colors,
};
use isokit_geom::Affine;
use isokit_job::{Job, Limits};
use isokit_mesh::{Positions, Rgba, TriMesh};
use isokit_volume::{AnyVolume, Channels, ColorVolume, Grid};

/// The mesh with a colour of each place.
fn painted(mesh: TriMesh, mut color: impl FnMut([f64; 3]) -> [u8; 4]) -> TriMesh {
    let colors = mesh.positions.iter().map(|place| Rgba(color(place))).collect();
    let mut mesh = mesh;
    mesh.attributes.colors = Some(colors);
    mesh
}

fn random(chance: &mut Chance) -> [u8; 4] {
    std::array::from_fn(|_| chance.below(256) as u8)
}

fn solid(mesh: &TriMesh) -> MeshSolid {
    MeshSolid::new(mesh, SolidOptions::default(), &Job::default()).unwrap()
}

fn colors(mesh: &TriMesh, grid: Grid, options: &VoxelOptions) -> ColorVolume {
    voxelize_with_colors(&solid(mesh), grid, options, &Job::default()).unwrap().1
}

/// Where samples are, and their colours.
fn pairs(colors: &ColorVolume) -> Vec<([f64; 3], Vec<u8>)> {
    let [nx, ny, _] = colors.grid().dims();
    let to_world = colors.grid().frame.index_to_world;
    let place = |n: u64| to_world.point([n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64));
    let all = colors.samples().chunks_exact(colors.channels().count());
    all.enumerate().map(|(n, color)| (place(n as u64), color.to_vec())).collect()
}

#[test]
fn a_sample_on_a_vertex_has_the_colour_of_the_vertex() {
    let mut chance = Chance(41);
    let mesh = painted(cube(), |_| random(&mut chance));
    let found = colors(&mesh, around(13), &VoxelOptions::default());
    assert_eq!(found.channels(), Channels::Rgba);
    let found = pairs(&found);
    for (place, color) in mesh.positions.iter().zip(mesh.attributes.colors.as_ref().unwrap()) {
        let (_, found) = found.iter().find(|(at, _)| *at == place).unwrap();
        assert_eq!(found[..], color.0, "{place:?}");
        assert_eq!(solid(&mesh).color(place), Some(*color));
    }
}

#[test]
fn what_is_linear_in_space_stays_so_on_triangles() {
    let linear = |[x, y, z]: [f64; 3]| {
        [120.0 + 40.0 * x - 20.0 * y + 10.0 * z, 100.0 + 99.0 * z, 5.0, 200.0 + 50.0 * y]
    };
    let mesh = painted(cube(), |place| linear(place).map(|code| code as u8));
    let solid = solid(&mesh);
    for grid in [around(19), oblique()] {
        for (place, found) in pairs(&colors(&mesh, grid, &VoxelOptions::default())) {
            let nearest = solid.closest(place).unwrap();
            // Within the cube several sides may be as near.
            let mut sides = place.map(f64::abs);
            sides.sort_by(f64::total_cmp);
            let is_tie = sides[2] < 1.0 && sides[2] - sides[1] < 1e-9;
            for (code, found) in linear(nearest.point).into_iter().zip(found) {
                let away = (code - f64::from(found)).abs();
                assert!(is_tie || away < 0.5 + 1e-6, "{place:?}: {found}, not {code}");
            }
        }
    }
}

#[test]
fn shares_of_the_corners_lead_to_the_nearest_point() {
    let mut chance = Chance(42);
    for _ in 0..20 {
        let mesh = chance.soup(12);
        let solid = solid(&mesh);
        for _ in 0..100 {
            let found = solid.closest(chance.point().map(|c| 2.0 * c)).unwrap();
            let corners = mesh.corners(mesh.triangles[found.triangle as usize]);
            assert!(found.shares.iter().all(|&share| (0.0..=1.0).contains(&share)));
            assert!((found.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            for (k, expected) in found.point.into_iter().enumerate() {
                let mixed: f64 = corners.iter().zip(found.shares).map(|(c, s)| s * c[k]).sum();
                assert!((mixed - expected).abs() < 1e-7, "{found:?}");
            }
        }
    }
}

#[test]
fn a_mesh_of_one_colour_gives_it_to_all_samples() {
    for (color, count) in [([17, 0, 255, 255], 3), ([1, 2, 3, 128], 4)] {
        let mut chance = Chance(43);
        for mesh in [ball(9), cube(), chance.soup(30)] {
            let found = colors(&painted(mesh, |_| color), oblique(), &VoxelOptions::default());
            assert_eq!(found.channels().count(), count);
            assert!(pairs(&found).iter().all(|(_, found)| found[..] == color[..count]));
        }
    }
}

/// The colours of all triangles that are as near as the nearest.
fn candidates(solid: &MeshSolid, place: [f64; 3]) -> Vec<[u8; 4]> {
    let (point, facets) = (solid.place().inward(place), solid.bvh().facets());
    let all: Vec<_> = facets.iter().map(|facet| near(point, facet)).collect();
    let least = all.iter().map(|near| near.squared).fold(f64::INFINITY, f64::min);
    let all = all.iter().enumerate().filter(|(_, near)| near.squared <= least + 1e-14);
    let paint = solid.paint().unwrap();
    all.map(|(number, near)| paint.mixed(number as u32, near.shares()).0).collect()
}

#[test]
fn chance_has_the_colour_of_a_nearest_triangle_too() {
    let mut chance = Chance(44);
    for _ in 0..6 {
        let mesh = chance.soup(50);
        let solid = solid(&painted(mesh, |_| random(&mut chance)));
        for grid in [around(14), oblique()] {
            let job = Job::default();
            let (_, found) =
                voxelize_with_colors(&solid, grid, &VoxelOptions::default(), &job).unwrap();
            for (place, found) in pairs(&found) {
                let expected = candidates(&solid, place);
                assert!(expected.iter().any(|color| color[..] == found[..]), "{place:?}");
                let single = solid.color(place).unwrap();
                assert_eq!(single.0[..found.len()], found, "{place:?}");
            }
        }
    }
}

#[test]
fn a_place_as_near_to_several_triangles_has_the_same_colour_on_every_lattice() {
    // A colour for each face: every corner is its own.
    let mut chance = Chance(48);
    let TriMesh { positions, triangles, .. } = cube();
    let corners = triangles.as_flattened().iter().map(|&v| positions.get(v as usize)).collect();
    let apart = TriMesh {
        positions: Positions::F64(corners),
        triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        ..TriMesh::default()
    };
    let mut face = vec![];
    let mesh = painted(apart, |_| {
        if face.is_empty() {
            let color = random(&mut chance);
            face.extend([color; 3]);
        }
        face.pop().unwrap()
    });
    let whole = pairs(&colors(&mesh, around(13), &VoxelOptions::default()));
    let wider = grid([21; 3], Affine::axis_aligned([0.25; 3], [-2.5; 3]).unwrap());
    let near = VoxelOptions { band: Some(0.6), ..VoxelOptions::default() };
    let (solid, mut ties) = (solid(&mesh), 0);
    for other in [colors(&mesh, wider, &VoxelOptions::default()), colors(&mesh, wider, &near)] {
        let other = pairs(&other);
        for (place, color) in &whole {
            let (_, found) = other.iter().find(|(at, _)| at == place).unwrap();
            assert!(found == color || found[..] == [0; 4], "{place:?}");
            assert_eq!(solid.color(*place).unwrap().0[..], color[..], "{place:?}");
            ties += usize::from(candidates(&solid, *place).len() > 1);
        }
    }
    assert!(ties > 100, "{ties}");
}

#[test]
fn distances_are_those_without_colours_to_the_bit() {
    let mut chance = Chance(45);
    let solid = solid(&painted(ball(10), |_| random(&mut chance)));
    let job = Job::default();
    for mode in [VoxelMode::Distance, VoxelMode::Occupancy] {
        for (band, walls) in [(None, Walls::AsTheyAre), (Some(0.05), Walls::Kept)] {
            let options = VoxelOptions { mode, band, walls };
            let alone = voxelize(&solid, oblique(), &options, &job).unwrap();
            let (beside, _) = voxelize_with_colors(&solid, oblique(), &options, &job).unwrap();
            let is_same = match (&alone, &beside) {
                (AnyVolume::F32(a), AnyVolume::F32(b)) => a == b,
                (AnyVolume::U8(a), AnyVolume::U8(b)) => a == b,
                _ => false,
            };
            assert!(is_same, "{options:?}");
        }
    }
}

#[test]
fn beyond_the_band_and_a_cell_nothing_has_a_colour() {
    let mut chance = Chance(46);
    let mesh = painted(ball(10), |_| random(&mut chance));
    let (solid, grid) = (solid(&mesh), around(27));
    let diagonal = 3.0_f64.sqrt() * 3.0 / 26.0;
    let whole = pairs(&colors(&mesh, grid, &VoxelOptions::default()));
    for (band, walls) in [(0.01, Walls::AsTheyAre), (0.4, Walls::AsTheyAre), (0.01, Walls::Kept)] {
        let options = VoxelOptions { band: Some(band), walls, ..VoxelOptions::default() };
        let grown = if walls == Walls::Kept { 0.5 * diagonal } else { 0.0 };
        let reach = band + diagonal + grown;
        let mut beyond = 0;
        for ((place, found), (_, known)) in
            pairs(&colors(&mesh, grid, &options)).into_iter().zip(&whole)
        {
            let distance = solid.closest(place).unwrap().distance;
            if distance < reach {
                assert!(candidates(&solid, place).iter().any(|color| color[..] == found[..]));
            } else if distance > reach * 1.002 {
                assert_eq!(found, [0; 4]);
                beyond += 1;
            }
            assert!(found == [0; 4] || found == *known);
        }
        assert!(beyond > 1000, "{beyond}");
    }
    let options = VoxelOptions { mode: VoxelMode::Occupancy, ..VoxelOptions::default() };
    assert_eq!(pairs(&colors(&mesh, grid, &options)), whole);
}

#[test]
fn any_number_of_threads_finds_the_same() {
    let mut chance = Chance(47);
    let soup = chance.soup(60);
    let mesh = painted(soup, |_| random(&mut chance));
    let of = |count| {
        let job = threads(count);
        let solid = MeshSolid::new(&mesh, SolidOptions::default(), &job).unwrap();
        voxelize_with_colors(&solid, oblique(), &VoxelOptions::default(), &job).unwrap().1
    };
    let one = of(1);
    assert!([2, 7].into_iter().all(|count| of(count) == one));
}

#[test]
fn what_cannot_be_is_refused() {
    let job = Job { limits: Limits { bytes: 1000 }, ..Job::default() };
    let options = VoxelOptions::default();
    let of = |mesh: &TriMesh| voxelize_with_colors(&solid(mesh), around(7), &options, &job);
    assert_eq!(of(&cube()), Err(VoxelError::NoColors));
    let mut mesh = painted(cube(), |_| [1, 2, 3, 255]);
    let error = of(&mesh).unwrap_err().to_string();
    assert_eq!(error, "the volume of colours needs 1029 bytes, the limit is 1000");
    mesh.attributes.colors.as_mut().unwrap().pop();
    let error = MeshSolid::new(&mesh, SolidOptions::default(), &Job::default()).unwrap_err();
    assert_eq!(error, SolidError::Colors { colors: 7, vertices: 8 });
    assert_eq!(solid(&cube()).color([0.0; 3]), None);
}

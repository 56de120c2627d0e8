//! `render` of meshes whose vertices have colours.

use crate::{
    colors::{ball, opaque, painted, surface, write},
    kit::Folder,
    render::{middle, pixels},
};
use isokit::{geom::Space, mesh::Surface};
use std::fs;

/// The bytes of a picture.
fn picture(folder: &Folder, words: &str) -> Vec<u8> {
    folder.done(&format!("render {words} --size 65x65 -o a.png"));
    fs::read(folder.path("a.png")).unwrap()
}

#[test]
fn what_extract_colours_by_a_map_is_seen_in_its_hues() {
    let folder = Folder::with_ball();
    folder.volume("x.nii", Space::Ras, |[i, ..]| i as f32);
    let words = "--iso 50:#ff0000 --attribute x.nii --colormap viridis";
    for name in ["a.ply", "a.glb", "a.gltf", "a.obj"] {
        folder.done(&format!("extract ball.nii {words} -o {name}"));
        folder.done(&format!("render {name} --size 65x65 -o a.png"));
        let (_, all) = pixels(&folder, "a.png");
        let count = |is: fn([u8; 3]) -> bool| {
            all.iter().filter(|pixel| is([pixel[0], pixel[1], pixel[2]])).count()
        };
        // From purple over green to yellow: none of it is the surface's red.
        let counts = [
            count(|[r, g, b]| b > g && g < 90 && b > r),
            count(|[r, g, b]| g > r.saturating_add(30) && g > b),
            count(|[r, g, b]| r > 150 && g > 150 && b < 100),
        ];
        assert!(counts.iter().all(|&count| count > 30), "{name}: {counts:?}");
        assert_eq!(count(|[r, g, b]| r > 100 && g < 30 && b < 30), 0, "{name}");
    }
}

#[test]
fn vertices_of_one_colour_make_the_picture_of_that_colour() {
    let folder = Folder::new();
    for color in ["#07c81f", "#d8a580", "#d8a58080"] {
        let code = |at: usize| {
            let digits = color.get(at..at + 2).unwrap_or("ff");
            u8::from_str_radix(digits, 16).unwrap()
        };
        let mesh = painted(ball([0.0; 3]), |_| [1, 3, 5, 7].map(code));
        write(&folder, "a.ply", &[surface("ball", mesh)]);
        write(&folder, "b.ply", &[surface("ball", ball([0.0; 3]))]);
        let words = "--background transparent";
        let found = picture(&folder, &format!("a.ply {words}"));
        assert!(found == picture(&folder, &format!("b.ply --color {color} {words}")), "{color}");
    }
}

#[test]
fn a_colour_that_was_typed_comes_before_those_of_the_file() {
    let folder = Folder::new();
    let own = Surface { color: "#00ff00".parse().ok(), ..surface("a", ball([0.0; 3])) };
    let many = surface("a", painted(ball([0.0; 3]), opaque));
    write(&folder, "plain.ply", &[surface("a", ball([0.0; 3]))]);
    let expected = picture(&folder, "plain.ply --color #3060c0");
    for (name, surface) in [("own.glb", own), ("many.glb", many.clone()), ("many.ply", many)] {
        write(&folder, name, &[surface]);
        assert!(picture(&folder, name) != expected, "{name}");
        let typed = picture(&folder, &format!("{name} --color #3060c0"));
        // In metres a few pixels at the rim may be others.
        assert!(name.ends_with("glb") || typed == expected, "{name}");
        let [r, g, b] = middle(&folder, "a.png")[..] else { panic!("three parts") };
        assert!(b > g.saturating_add(40) && g > r, "{name}: {r}, {g}, {b}");
    }
}

#[test]
fn opacity_is_that_of_vertices_and_in_obj_that_of_the_surface() {
    let folder = Folder::new();
    let mesh = painted(ball([0.0; 3]), |_| [255, 0, 0, 128]);
    let surface = Surface { color: "#ffffff80".parse().ok(), ..surface("ball", mesh) };
    for name in ["a.ply", "a.glb", "a.obj"] {
        write(&folder, name, std::slice::from_ref(&surface));
        picture(&folder, &format!("{name} --background transparent"));
        // Through two walls: 1 - (1 - 128/255)^2.
        assert_eq!(middle(&folder, "a.png")[3], 192, "{name}");
    }
}

#[test]
fn any_number_of_threads_draws_the_same_colours() {
    let folder = Folder::new();
    let mesh = painted(ball([0.0; 3]), |[x, y, z]| [x * y, y + z, x * z, 9.0 * z].map(|c| c as u8));
    write(&folder, "a.ply", &[surface("ball", mesh)]);
    let one = picture(&folder, "a.ply --threads 1");
    for threads in [2, 7] {
        assert!(picture(&folder, &format!("a.ply --threads {threads}")) == one, "{threads}");
    }
}

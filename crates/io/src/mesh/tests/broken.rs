//! Files cut short, or with a byte wrong, are errors or other meshes, and never a panic.

use crate::{
    Format,
    mesh::kit::{STREAMS, context, read, surface, written},
};
use proptest::{collection::vec, option, prelude::*, sample::Index};

/// A small file of each kind that a reader must tell from others.
fn files() -> Vec<(Format, Vec<u8>)> {
    let mut files: Vec<_> =
        STREAMS.map(|format| (format, written(format, &[surface(3)], &context()).0)).into();
    let text_ply = "ply\nformat ascii 1.0\ncomment SPACE=RAS\nelement vertex 3\n\
                    property float x\nproperty double y\nproperty int z\nproperty uchar red\n\
                    element face 1\nproperty list uchar int vertex_indices\nend_header\n\
                    0 0 0 7\n1 0 0 7\n0 1 0 7\n3 0 1 2\n";
    let text_stl = "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                    vertex 0 1 0\nendloop\nendfacet\nendsolid a b\n";
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0 \\\n1\nv 0 1 0 .1 .2 .3\nvn 0 0 1\nvt 0 0\n\
               usemtl a\ng b\nf 1//1 -2/1/1 3//1\no c\nf 1 2 3\n";
    let gltf = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
        "nodes":[{"mesh":0,"children":[1],"scale":[1,2,-3]},{"rotation":[0,0,0,1]}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"mode":5}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","normalized":true,
        "sparse":{"count":1,"indices":{"bufferView":0,"componentType":5121},
        "values":{"bufferView":0,"byteOffset":1}}}],
        "bufferViews":[{"buffer":0,"byteLength":48,"byteStride":12}],
        "buffers":[{"byteLength":48,"uri":"data:;base64,BASE64"}]}"#;
    let gltf = gltf.replace("BASE64", &"AAAA".repeat(16));
    files.push((Format::Ply, text_ply.into()));
    files.push((Format::Stl, text_stl.into()));
    files.push((Format::Obj, obj.into()));
    files.push((Format::Gltf, gltf.into()));
    files
}

#[test]
fn all_of_them_are_sound() {
    for (format, bytes) in files() {
        read(format, &bytes).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn a_cut_anywhere_does_not_panic() {
    for (format, bytes) in files() {
        for end in 0..bytes.len() {
            let _ = read(format, &bytes[..end]);
        }
    }
}

#[test]
fn a_binary_file_that_is_cut_is_refused() {
    for (format, bytes) in files() {
        let is_binary = bytes.contains(&0);
        for end in (0..bytes.len()).filter(|_| is_binary) {
            assert!(read(format, &bytes[..end]).is_err(), "{format} cut at {end}");
        }
    }
}

#[test]
fn a_wrong_byte_anywhere_does_not_panic() {
    for (format, mut bytes) in files() {
        for at in 0..bytes.len() {
            let right = bytes[at];
            for wrong in
                [0, b'0', b'9', b'-', b' ', b'\n', 0x7f, 0x80, 0xff, right ^ 1, right ^ 0x80]
            {
                bytes[at] = wrong;
                let _ = read(format, &bytes);
            }
            bytes[at] = right;
        }
    }
}

#[test]
fn nothing_and_anything_are_refused() {
    for format in [Format::Glb, Format::Gltf, Format::Obj, Format::Ply, Format::Stl] {
        for bytes in [&b""[..], b"\n", b"hello", &[0xff; 200]] {
            let error = read(format, bytes).unwrap_err().to_string();
            assert!(error.starts_with(&format!("test: {format}")), "{error}");
        }
    }
}

proptest! {
    #[test]
    fn several_wrong_bytes_do_not_panic(
        edits in vec((any::<Index>(), prop_oneof![any::<u8>(), Just(b'9'), Just(b' '), Just(255)]), 1..6),
        end in option::of(any::<Index>()),
    ) {
        for (format, mut bytes) in files() {
            for (at, byte) in &edits {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            let end = end.map_or(bytes.len(), |end| end.index(bytes.len()));
            let _ = read(format, &bytes[..end]);
        }
    }
}

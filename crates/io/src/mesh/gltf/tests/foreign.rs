//! Files as other programs write them, right and wrong.

use crate::{
    Format,
    mesh::kit::{fault, read_back},
};
use isokit_geom::Unit;
use isokit_mesh::Rgba;
use serde_json::{Value, json};

/// Four corners of a square, y up, 16 bits each and 8 bytes apart; four indices; a sparse value.
const DATA: &str = "data:application/octet-stream;base64,";

fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = DATA.to_owned();
    for three in bytes.chunks(3) {
        let bits = three.iter().fold(0, |bits, &byte| bits << 8 | u32::from(byte))
            << (8 * (3 - three.len()));
        let letters =
            (0..=three.len()).map(|k| char::from(LETTERS[(bits >> (18 - 6 * k) & 63) as usize]));
        text.extend(letters);
    }
    text
}

/// A square of non-normalised i16, interleaved with nothing, as a strip.
fn square() -> Value {
    let corners: [[i16; 4]; 4] = [[0, 0, 0, 7], [2, 0, 0, 7], [0, 2, 0, 7], [2, 2, 0, 7]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 3, /* sparse */ 3, 0, 0, 0]);
    bytes.extend([9_i16, 2, 0].iter().flat_map(|c| c.to_le_bytes()));
    json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
        "nodes": [{"mesh": 0, "name": "square"}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.0, 0.0, 1.0]}}],
        "meshes": [{"primitives": [
            {"attributes": {"POSITION": 0}, "indices": 1, "mode": 5, "material": 0}
        ]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5122, "type": "VEC3", "count": 4},
            {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 4},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 32, "byteStride": 8},
            {"buffer": 0, "byteOffset": 32, "byteLength": 4},
            {"buffer": 0, "byteOffset": 36, "byteLength": 1},
            {"buffer": 0, "byteOffset": 40, "byteLength": 6},
        ],
        "buffers": [{"byteLength": bytes.len(), "uri": base64(&bytes)}],
    })
}

/// The square with a value of its JSON replaced.
fn with(pointer: &str, value: Value) -> String {
    let mut file = square();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = file.pointer_mut(parent).unwrap_or_else(|| panic!("{pointer}"));
    match parent {
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
        parent => parent[key] = value,
    }
    file.to_string()
}

#[track_caller]
fn check_fault(pointer: &str, value: Value, expected: &str) {
    assert_eq!(fault(Format::Gltf, with(pointer, value)), format!("test: glTF, {expected}"));
}

#[test]
fn quantised_strips_are_read_in_metres() {
    let input = read_back(Format::Gltf, square().to_string());
    let surface = &input.surfaces[0];
    assert_eq!((input.unit, surface.name.as_str()), (Unit::Metre, "square"));
    assert_eq!(surface.color, Some(Rgba([255, 0, 0, 255])));
    assert_eq!(surface.mesh.triangles, [[0, 1, 2], [2, 1, 3]]);
    assert_eq!(surface.mesh.positions.get(3), [2.0, 0.0, 2.0], "z up");
}

#[test]
fn a_texture_is_not_read_and_a_note_says_so() {
    assert_eq!(read_back(Format::Gltf, square().to_string()).notes, [""; 0]);
    let file = |nodes: Value| {
        let mut file = square();
        let material = json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}});
        file["materials"] = json!([material]);
        file["textures"] = json!([{"source": 0}]);
        file["images"] = json!([{"uri": "data:image/png;base64,eA=="}]);
        file["nodes"] = nodes;
        read_back(Format::Gltf, file.to_string())
    };
    let one = file(json!([{"mesh": 0, "name": "square"}]));
    let says = r#"the texture of surface "square" is not read, only the colours beside it"#;
    assert_eq!((one.notes, one.surfaces[0].color), (vec![says.into()], Some(Rgba([255; 4]))));
    let three = file(json!([{"mesh": 0, "name": "square"}, {"mesh": 0}, {"mesh": 0}]));
    let says =
        r#"the textures of surface "square" and 2 more are not read, only the colours beside them"#;
    assert_eq!(three.notes, [says]);
}

#[test]
fn opacity_counts_only_where_the_material_says_so() {
    let file = |mode: Option<&str>| {
        let mut file = square();
        // The positions are quantised: as colours, they are 0 and a part of 32767, with an opacity of 7.
        let attributes = json!({"POSITION": 0, "COLOR_0": 2});
        file["meshes"][0]["primitives"][0]["attributes"] = attributes;
        let colors = json!({"bufferView": 0, "componentType": 5122, "type": "VEC4", "count": 4, "normalized": true});
        file["accessors"].as_array_mut().unwrap().push(colors);
        let color = json!({"baseColorFactor": [1.0, 0.0, 0.0, 0.5]});
        file["materials"] = json!([{"pbrMetallicRoughness": color}]);
        if let Some(mode) = mode {
            file["materials"][0]["alphaMode"] = json!(mode);
        }
        let surface = read_back(Format::Gltf, file.to_string()).surfaces.remove(0);
        (surface.color.unwrap().0[3], surface.mesh.attributes.colors.unwrap()[0].0[3])
    };
    assert_eq!([file(None), file(Some("OPAQUE"))], [(255, 255); 2]);
    assert_eq!([file(Some("BLEND")), file(Some("MASK"))], [(128, 0); 2]);
    let mut plain = square();
    let attributes = json!({"POSITION": 0, "COLOR_0": 2});
    plain["meshes"][0]["primitives"][0] = json!({"attributes": attributes, "mode": 5});
    let colors = json!({"componentType": 5126, "type": "VEC4", "count": 4});
    plain["accessors"].as_array_mut().unwrap().push(colors);
    let surfaces = read_back(Format::Gltf, plain.to_string()).surfaces;
    assert_eq!(surfaces[0].mesh.attributes.colors, Some(vec![Rgba([0, 0, 0, 255]); 4]));
}

#[test]
fn numbers_of_colours_that_are_beyond_are_said() {
    let notes = |normalized: bool| {
        let mut file = square();
        let attributes = json!({"POSITION": 0, "COLOR_0": 2});
        file["meshes"][0]["primitives"][0]["attributes"] = attributes;
        let colors = json!({"bufferView": 0, "componentType": 5122, "type": "VEC3", "count": 4, "normalized": normalized});
        file["accessors"].as_array_mut().unwrap().push(colors);
        read_back(Format::Gltf, file.to_string()).notes
    };
    assert_eq!(notes(true), [""; 0]);
    let says = "3 vertices have colours with numbers that are not from 0 to 1; cut to that";
    assert_eq!(notes(false), [says]);
}

#[test]
fn fans_and_lists_without_indices_are_read_too() {
    let fan = read_back(Format::Gltf, with("/meshes/0/primitives/0/mode", json!(6)));
    assert_eq!(fan.surfaces[0].mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    let list = with("/meshes/0/primitives/0", json!({"attributes": {"POSITION": 0}, "mode": 5}));
    assert_eq!(read_back(Format::Gltf, list).surfaces[0].mesh.triangles.len(), 2);
}

#[test]
fn sparse_and_normalised_numbers_are_understood() {
    let sparse = json!({"count": 1, "indices": {"bufferView": 2, "componentType": 5121},
                        "values": {"bufferView": 3}});
    let file = with("/accessors/0/sparse", sparse.clone());
    let input = read_back(Format::Gltf, file);
    assert_eq!(input.surfaces[0].mesh.positions.get(3), [9.0, 0.0, 2.0]);
    let zeros = json!({"componentType": 5122, "type": "VEC3", "count": 4, "sparse": sparse});
    let input = read_back(Format::Gltf, with("/accessors/0", zeros));
    assert_eq!(input.surfaces[0].mesh.positions.get(1), [0.0; 3]);
    let input = read_back(Format::Gltf, with("/accessors/0/normalized", json!(true)));
    assert_eq!(input.surfaces[0].mesh.positions.get(3)[0], f64::from((2.0 / 32767.0) as f32));
}

#[test]
fn the_transforms_of_all_parents_are_put_into_the_positions() {
    let nodes = json!([
        {"children": [1], "scale": [1.0, 1.0, -1.0]},
        {"translation": [0.0, 0.0, 5.0], "children": [2]},
        {"mesh": 0, "matrix": [2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
    ]);
    let input = read_back(Format::Gltf, with("/nodes", nodes));
    let mesh = &input.surfaces[0].mesh;
    assert_eq!(mesh.positions.get(3), [4.0, 5.0, 2.0]);
    assert_eq!(mesh.triangles[0], [0, 2, 1], "a mirror turns the winding");
}

#[test]
fn only_the_scene_is_shown() {
    let mut file = square();
    file["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "name": "shown"}, {"name": "a joint"}]);
    file["scenes"] = json!([{"nodes": [0]}, {"nodes": [1, 2]}]);
    file["scene"] = json!(1);
    let input = read_back(Format::Gltf, file.to_string());
    assert_eq!(input.surfaces.len(), 1);
    assert_eq!(input.surfaces[0].name, "shown");
}

#[test]
fn what_cannot_be_read_is_named() {
    check_fault(
        "/extensionsRequired/0",
        json!("EXT_meshopt_compression"),
        "required extension 0: EXT_meshopt_compression is not supported",
    );
    check_fault(
        "/meshes/0/primitives/0/mode",
        json!(1),
        "mesh 0: a primitive of Lines is not supported",
    );
    check_fault("/asset/version", json!("1.0"), "byte 0: glTF 1.0 is not supported");
}

#[test]
fn a_fault_is_named_with_its_place() {
    check_fault("/nodes/0/mesh", json!(7), "mesh 7: expected a mesh, found a number that none has");
    check_fault("/nodes/0/children", json!([0]), "node 0: expected one parent or none, found two");
    check_fault(
        "/meshes/0/primitives/0/indices",
        json!(2),
        "accessor 2: expected an accessor, found a number that none has",
    );
    check_fault(
        "/accessors/0/bufferView",
        json!(9),
        "accessor 0: expected a buffer view, found a number that none has",
    );
    check_fault(
        "/accessors/0/type",
        json!("VEC2"),
        "accessor 0: expected elements of Vec3, found Vec2",
    );
    check_fault(
        "/accessors/1/componentType",
        json!(5126),
        "accessor 1: expected indices without sign, found F32",
    );
    check_fault(
        "/bufferViews/0/byteStride",
        json!(4),
        "accessor 0: expected a stride of at least 6, found 4 bytes",
    );
    check_fault(
        "/bufferViews/1/byteOffset",
        json!(30),
        "mesh 0: expected vertices below 4, found 7",
    );
    check_fault(
        "/buffers/0/uri",
        json!("data:;base64,?"),
        "buffer 0: expected data in Base64, found \"data:;base64,?\"",
    );
    for outside in ["../secret.bin", "/etc/passwd", "https://example.org/a.bin"] {
        let expected = format!("buffer 0: expected a file in the same folder, found {outside:?}");
        check_fault("/buffers/0/uri", json!(outside), &expected);
    }
    assert!(
        fault(Format::Gltf, "{\n\"asset\": ?")
            .starts_with("test: glTF, line 2: expected JSON of glTF 2.0")
    );
}

#[test]
fn counts_that_the_file_cannot_hold_take_no_memory() {
    for count in [6_u64, 1 << 40, u64::MAX] {
        let found = fault(Format::Gltf, with("/accessors/0/count", json!(count)));
        assert!(found.contains("bytes of an accessor, file holds 32"), "{found}");
        let zeros =
            json!({"componentType": 5126, "type": "VEC3", "count": count.saturating_mul(1000)});
        let found = fault(Format::Gltf, with("/accessors/0", zeros));
        assert!(found.contains("no more elements than bytes"), "{found}");
    }
    let found = fault(Format::Gltf, with("/bufferViews/0/byteLength", json!(u64::MAX)));
    assert!(found.contains("bytes of a buffer view, file holds 46"), "{found}");
    let found = fault(Format::Gltf, with("/buffers/0/byteLength", json!(1_u64 << 60)));
    assert!(found.contains("bytes of a buffer, file holds 46"), "{found}");
}

//! Where everything lies in the buffer, and whether it fits: from counts alone.

use super::mark;
use crate::{Format, WriteFault};

/// The sizes of a surface.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shape {
    pub(super) vertices: u64,
    pub(super) triangles: u64,
    pub(super) has_normals: bool,
    pub(super) has_colors: bool,
    pub(super) has_values: bool,
}

/// A range of the buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Block {
    pub(super) start: u64,
    pub(super) bytes: u64,
}

/// The blocks of a surface, one behind the other. All begin at a multiple of 4.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Blocks {
    pub(super) positions: Block,
    pub(super) normals: Option<Block>,
    pub(super) colors: Option<Block>,
    pub(super) values: Option<Block>,
    pub(super) indices: Block,
}

/// A vertex, a normal and a triangle are all three numbers of 4 bytes.
const ITEM: u64 = 12;
/// A colour is four numbers of 2 bytes.
const COLOR: u64 = 8;
/// The number of a vertex.
const VALUE: u64 = 4;

/// The blocks of all surfaces and the bytes of the buffer. What overflows is `u64::MAX`.
pub(super) fn layout(shapes: impl IntoIterator<Item = Shape>) -> (Vec<Blocks>, u64) {
    let mut end = 0_u64;
    let mut block = |items: u64, item: u64| {
        let (start, bytes) = (end, items.saturating_mul(item));
        end = end.saturating_add(bytes);
        Block { start, bytes }
    };
    let blocks = shapes.into_iter().map(|shape| Blocks {
        positions: block(shape.vertices, ITEM),
        normals: shape.has_normals.then(|| block(shape.vertices, ITEM)),
        colors: shape.has_colors.then(|| block(shape.vertices, COLOR)),
        values: shape.has_values.then(|| block(shape.vertices, VALUE)),
        indices: block(shape.triangles, ITEM),
    });
    let blocks = blocks.collect();
    (blocks, end)
}

/// Bytes up to the next multiple of 4.
pub(super) fn padded(bytes: u64) -> u64 {
    bytes.saturating_add(3) & !3
}

/// The bytes of a GLB file with so much JSON and so large a buffer.
pub(super) fn glb_bytes(json: u64, buffer: u64) -> u64 {
    let bin = if buffer == 0 { 0 } else { buffer.saturating_add(mark::CHUNK) };
    (mark::HEADER + mark::CHUNK).saturating_add(padded(json)).saturating_add(bin)
}

/// Goes on if the whole file, or the buffer beside it, is within what 32 bits count: in GLB the length
/// is such a number, and readers keep offsets in such.
pub(super) fn check(format: Format, json: u64, buffer: u64) -> Result<(), WriteFault> {
    let limit = u64::from(u32::MAX);
    let needed = if format == Format::Glb { glb_bytes(json, buffer) } else { buffer };
    if needed <= limit {
        return Ok(());
    }
    let remedy = "write .ply, or each surface to a file of its own";
    Err(WriteFault::TooLarge { format, what: "bytes", needed, limit, remedy })
}

#[cfg(test)]
mod tests {
    use super::{Block, Shape, check, glb_bytes, layout};
    use crate::Format;

    #[test]
    fn blocks_follow_each_other() {
        let shape = |vertices, triangles, has_normals| Shape {
            vertices,
            triangles,
            has_normals,
            ..Shape::default()
        };
        let (blocks, end) = layout([shape(3, 1, true), shape(4, 2, false)]);
        assert_eq!(blocks[0].normals, Some(Block { start: 36, bytes: 36 }));
        assert_eq!(blocks[1].positions, Block { start: 84, bytes: 48 });
        assert_eq!((blocks[1].normals, end), (None, 156));
        let (blocks, end) =
            layout([Shape { has_colors: true, has_values: true, ..shape(3, 1, false) }]);
        assert_eq!(blocks[0].colors, Some(Block { start: 36, bytes: 24 }));
        assert_eq!((blocks[0].values, end), (Some(Block { start: 60, bytes: 12 }), 84));
    }

    #[test]
    fn four_gibibytes_are_too_many_and_one_byte_less_is_not() {
        let most = u64::from(u32::MAX);
        let buffer = (most - 20 - 1000 - 8) / 4 * 4;
        assert_eq!(glb_bytes(998, buffer), most - 3);
        assert!(check(Format::Glb, 1000, buffer).is_ok());
        assert!(check(Format::Glb, 1001, buffer).is_err());
        assert!(check(Format::Gltf, u64::MAX, most).is_ok());
        let error = check(Format::Gltf, 0, most + 1).unwrap_err().to_string();
        assert!(error.starts_with("glTF holds at most 4294967295 bytes, this needs 4294967296"));
        assert!(error.contains(".ply"), "{error}");
    }

    #[test]
    fn sizes_that_overflow_are_too_large_and_do_not_panic() {
        for vertices in [200_000_000, u64::MAX / 12, u64::MAX] {
            let triangles = 2 * (vertices / 4);
            let shape = Shape { vertices, triangles, has_normals: true, ..Shape::default() };
            let (_, buffer) = layout([shape; 3]);
            assert!(check(Format::Glb, 500, buffer).is_err(), "{vertices}");
        }
    }
}

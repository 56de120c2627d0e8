//! Colours of vertices, and those between them.
//!
//! Vertices have sRGB codes of a byte. Between them light is linear, and so is opacity: along the triangle, as normals are,
//! and not across the picture. What codes mean is looked up: no power is worked out for a pixel.

use isokit_mesh::Rgba;
use std::sync::LazyLock;

/// Linear light of each code as red, green and blue, and last its opacity.
static CODES: LazyLock<[[f32; 4]; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| Rgba([code as u8; 4]).to_linear()));

/// What a vertex has that has no colour.
const WHITE: Rgba = Rgba([u8::MAX; 4]);

/// The linear light of a place in a triangle, and last its opacity, by its shares of the corners.
pub(super) fn between(colors: &[Rgba], corners: [u32; 3], shares: [f64; 3]) -> [f32; 4] {
    let corners = corners.map(|vertex| colors.get(vertex as usize).unwrap_or(&WHITE).0);
    let codes = &*CODES;
    // Shares are 1 together, but for the rounding of f64, which is gone from the f32: of three corners alike it is theirs.
    std::array::from_fn(|part| {
        let light = |n: usize| f64::from(codes[usize::from(corners[n][part])][part]);
        (0..3).map(|n| shares[n] * light(n)).sum::<f64>() as f32
    })
}

#[cfg(test)]
mod tests {
    use super::between;
    use isokit_mesh::Rgba;

    #[test]
    fn between_corners_of_one_colour_there_is_that_colour_to_the_bit() {
        for code in 0..=u8::MAX {
            let color = Rgba([code, 255 - code, code / 2, code]);
            for share in [0.0, 1e-17, 0.1, 1.0 / 3.0, 0.7] {
                let shares = [share, (1.0 - share) * 0.3, (1.0 - share) * 0.7];
                assert_eq!(between(&[color; 3], [2, 0, 1], shares), color.to_linear());
            }
        }
    }

    #[test]
    fn a_vertex_without_a_colour_is_white() {
        let black = Rgba([0, 0, 0, 255]);
        assert_eq!(between(&[black], [0, 1, 2], [0.5, 0.25, 0.25]), [0.5, 0.5, 0.5, 1.0]);
    }
}

//! Colours for surfaces that were given none.

use isokit::mesh::Rgba;

/// Calm colours that are told apart on light and dark ground, also by most colour-blind eyes. All are
/// opaque: only a user who asks for it sees through a surface.
const COLORS: [[u8; 3]; 8] = [
    [0xe8, 0xdc, 0xc0],
    [0xc8, 0x6b, 0x4f],
    [0x5b, 0x8f, 0xb9],
    [0x8a, 0xa8, 0x5f],
    [0xd9, 0xa4, 0x41],
    [0x8c, 0x72, 0xa8],
    [0x4f, 0xa3, 0x9a],
    [0xb0, 0x5c, 0x7e],
];

/// The colour of surface number `n` of several.
pub(crate) fn color(n: usize) -> Rgba {
    let [r, g, b] = COLORS[n % COLORS.len()];
    Rgba([r, g, b, u8::MAX])
}

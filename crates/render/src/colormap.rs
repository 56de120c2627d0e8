//! Colour maps: from a number to a colour.
//!
//! Viridis and magma are those of matplotlib (van der Walt & Smith 2015; the data is in the public domain by CC0):
//! every fifth of its 256 colours, and what is linear in sRGB between them, less than one of 255 steps off. Coolwarm is
//! Moreland's ("Diverging Color Maps for Scientific Visualization", ISVC 2009): from cool blue over white to warm
//! red along a path in Msh, which is CIELAB in polar coordinates. Gray is linear in sRGB, as its lightness nearly is.

use isokit_mesh::{Rgba, srgb_of_linear};

/// A path of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColorMap {
    /// From dark blue over green to yellow, evenly; the same for most colour-blind eyes.
    Viridis,
    /// From black over purple to light yellow, evenly.
    Magma,
    /// From black to white.
    Gray,
    /// From blue over white to red: for what has a middle.
    Coolwarm,
}

const VIRIDIS: &str = "\
     440154 46085c 471063 481769 481d6f 482475 472a7a 46307e 453781 433d84 414287 3f4889 3d4e8a \
     3a538b 38598c 355e8d 33638d 31688e 2e6d8e 2c718e 2a768e 297b8e 27808e 25848e 23898e 218e8d \
     20928c 1f978b 1e9c89 1fa188 21a585 24aa83 28ae80 2eb37c 35b779 3dbc74 46c06f 50c46a 5ac864 \
     65cb5e 70cf57 7cd250 89d548 95d840 a2da37 b0dd2f bddf26 cae11f d8e219 e5e419 f1e51d fde725";
const MAGMA: &str = "\
     000004 02020b 050416 090720 0e0b2b 140e36 1a1042 21114e 29115a 311165 390f6e 420f75 4a1079 \
     52137c 5a167e 621980 6a1c81 721f81 792282 812581 892881 912b81 992d80 a1307e aa337d b2357b \
     ba3878 c23b75 ca3e72 d2426f d9466b e04c67 e75263 ec5860 f1605d f4695c f7725c f97b5d fb8560 \
     fc8e64 fd9869 fea16e feaa74 feb47b febd82 fec68a fecf92 fed89a fde2a3 fdebac fcf4b6 fcfdbf";

/// Bytes of a colour and the blank behind it.
const WORD: usize = 7;

impl ColorMap {
    /// All of them, with their names.
    pub const ALL: [(Self, &str); 4] = [
        (Self::Viridis, "viridis"),
        (Self::Magma, "magma"),
        (Self::Gray, "gray"),
        (Self::Coolwarm, "coolwarm"),
    ];

    /// The map of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|(_, known)| *known == name).map(|(map, _)| map)
    }

    /// What it is called.
    pub fn name(self) -> &'static str {
        Self::ALL.into_iter().find(|(map, _)| *map == self).map_or("", |(_, name)| name)
    }

    /// The opaque colour of a part of the way, from 0 to 1; what is beyond has the colour of the end.
    pub fn at(self, part: f64) -> Rgba {
        let part = part.clamp(0.0, 1.0);
        let [r, g, b] = match self {
            Self::Viridis => between(VIRIDIS, part),
            Self::Magma => between(MAGMA, part),
            Self::Gray => [255.0 * part; 3],
            Self::Coolwarm => coolwarm(part),
        };
        let byte = |c: f64| c.round().clamp(0.0, 255.0) as u8;
        Rgba([byte(r), byte(g), byte(b), u8::MAX])
    }

    /// The colour of a value in a range. Where both ends are one, values at it have the colour of the middle.
    /// None of NaN.
    pub fn color(self, value: f64, [low, high]: [f64; 2]) -> Option<Rgba> {
        if value.is_nan() {
            return None;
        }
        // Halves, so that no range overflows.
        let part = (value * 0.5 - low * 0.5) / (high * 0.5 - low * 0.5);
        Some(self.at(if part.is_nan() { 0.5 } else { part }))
    }
}

/// What is linear between colours that are listed.
fn between(list: &str, part: f64) -> [f64; 3] {
    let count = list.len().div_ceil(WORD);
    let at = part * (count - 1) as f64;
    let low = (at as usize).min(count - 2);
    let color = |n: usize| [0, 2, 4].map(|k| digits(&list.as_bytes()[n * WORD + k..][..2]));
    let ([a, b], share) = ([color(low), color(low + 1)], at - low as f64);
    std::array::from_fn(|k| a[k] * (1.0 - share) + b[k] * share)
}

/// A number of two hexadecimal digits.
fn digits(text: &[u8]) -> f64 {
    let digit = |byte: u8| char::from(byte).to_digit(16).map_or(0.0, f64::from);
    16.0 * digit(text[0]) + digit(text[1])
}

/// How far from black, how far from gray, and which hue (Moreland 2009, section 5).
type Msh = [f64; 3];

/// The ends of the map, #3b4cc0 and #b40426, and how bright its middle is.
const COOL: Msh = [80.0, 1.08, -1.1];
const WARM: Msh = [80.0, 1.08, 0.5];
const MIDDLE: f64 = 88.0;

/// Each end to a white whose hue is that of the end turned a little farther (there, figure 5).
fn coolwarm(part: f64) -> [f64; 3] {
    let (end, share) = if part < 0.5 { (COOL, 2.0 * part) } else { (WARM, 2.0 - 2.0 * part) };
    let [m, s, h] = end;
    let spin = s * (MIDDLE * MIDDLE - m * m).sqrt() / (m * s.sin());
    let white = [MIDDLE, 0.0, if h > -std::f64::consts::FRAC_PI_3 { h + spin } else { h - spin }];
    srgb(std::array::from_fn(|k| end[k] * (1.0 - share) + white[k] * share))
}

/// From Msh to CIELAB, to XYZ with white D65 (CIE 15), to sRGB (IEC 61966-2-1), 0 to 255.
fn srgb([m, s, h]: Msh) -> [f64; 3] {
    let (l, a, b) = (m * s.cos(), m * s.sin() * h.cos(), m * s.sin() * h.sin());
    let y = (l + 16.0) / 116.0;
    let cube = |f: f64| if f > 6.0 / 29.0 { f * f * f } else { (f - 16.0 / 116.0) / 7.787 };
    let [x, y, z] = [0.95047 * cube(y + a / 500.0), cube(y), 1.08883 * cube(y - b / 200.0)];
    let rows = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
    rows.map(|[p, q, r]| 255.0 * srgb_of_linear((p * x + q * y + r * z).clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::ColorMap;
    use isokit_mesh::Rgba;

    fn at(map: ColorMap, part: f64) -> String {
        map.at(part).to_string()
    }

    #[test]
    fn colours_are_those_that_were_published() {
        let is_near = |map: ColorMap, parts: [f64; 5], published: [[u8; 3]; 5], steps| {
            for (part, published) in parts.into_iter().zip(published) {
                let found = map.at(part).0;
                let is_near = (0..3).all(|k| found[k].abs_diff(published[k]) <= steps);
                assert!(is_near, "{map:?} at {part}: {found:?}, {published:?}");
            }
        };
        // matplotlib's table of 256, entries 0, 64, 128, 191 and 255.
        let parts = [0.0, 64.0, 128.0, 191.0, 255.0].map(|entry| entry / 255.0);
        let viridis = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [92, 200, 99], [253, 231, 37]];
        is_near(ColorMap::Viridis, parts, viridis, 1);
        let magma = [[0, 0, 4], [81, 18, 124], [183, 55, 121], [251, 135, 97], [252, 253, 191]];
        is_near(ColorMap::Magma, parts, magma, 1);
        // Moreland's table of 33, entries 0, 8, 16, 24 and 32.
        let coolwarm =
            [[59, 76, 192], [141, 176, 254], [221, 221, 221], [244, 154, 123], [180, 4, 38]];
        is_near(ColorMap::Coolwarm, [0.0, 0.25, 0.5, 0.75, 1.0], coolwarm, 2);
        assert_eq!(at(ColorMap::Gray, 0.2), "#333333");
    }

    #[test]
    fn colours_change_little_by_little_and_end_at_the_ends() {
        for (map, name) in ColorMap::ALL {
            assert_eq!((ColorMap::from_name(name), map.name()), (Some(map), name));
            let mut last = map.at(0.0);
            for n in 1..=1000 {
                let next = map.at(f64::from(n) / 1000.0);
                assert!((0..4).all(|k| next.0[k].abs_diff(last.0[k]) <= 2), "{name} {n}");
                last = next;
            }
            let beyond = [-1.0, f64::NEG_INFINITY, 2.0, f64::INFINITY].map(|part| map.at(part));
            let ends = [map.at(0.0), map.at(1.0)];
            assert_eq!(beyond, [ends[0], ends[0], ends[1], ends[1]]);
        }
        assert_eq!(ColorMap::from_name("jet"), None);
    }

    #[test]
    fn a_range_may_be_turned_round_empty_or_as_large_as_numbers() {
        let color = |value, range| ColorMap::Gray.color(value, range).map(|Rgba([r, ..])| r);
        assert_eq!(color(3.0, [2.0, 7.0]), Some(51));
        assert_eq!(color(3.0, [7.0, 2.0]), Some(204));
        assert_eq!(
            [2.0, 3.0, 4.0].map(|value| color(value, [3.0; 2])),
            [Some(0), Some(128), Some(255)]
        );
        assert_eq!(color(0.0, [-f64::MAX, f64::MAX]), Some(128));
        assert_eq!(color(f64::NAN, [0.0, 1.0]), None);
    }
}

//! MTL: the colours that an OBJ names.
//!
//! Only `Kd`, `d` and `Tr` are read; textures and shine say nothing of a surface's shape.

use crate::mesh::{NEUTRAL, SurfaceHead, facts::MAKER};
use isokit_mesh::Rgba;
use std::{collections::HashMap, fmt::Write};

/// One material for each surface. `Kd` is sRGB, as is the custom; Blender takes it for linear light.
pub(super) fn text<'a>(
    surfaces: impl Iterator<Item = &'a SurfaceHead>,
    names: &[String],
) -> String {
    let mut text = format!("# {MAKER}\n");
    for (surface, name) in surfaces.zip(names) {
        let [r, g, b, a] = surface.color.unwrap_or(NEUTRAL).0.map(|byte| f32::from(byte) / 255.0);
        // Writing to memory does not fail.
        let _ = write!(text, "\nnewmtl {name}\nKd {r} {g} {b}\nd {a}\nillum 2\n");
    }
    text
}

/// The colours of a library by the names of their materials. What is not understood is passed over.
pub(super) fn colors(text: &str) -> HashMap<&str, Rgba> {
    let mut colors = HashMap::new();
    let mut current = None;
    for line in text.lines() {
        let line = line.trim();
        let (key, value) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let mut numbers = value.split_whitespace().map_while(|word| word.parse::<f32>().ok());
        let mut byte = || numbers.next().map(|c| (c * 255.0).round() as u8);
        match key {
            "newmtl" => current = Some(value.trim()),
            "Kd" => {
                if let (Some(name), Some(r), Some(g), Some(b)) = (current, byte(), byte(), byte()) {
                    let Rgba([.., a]) = *colors.entry(name).or_insert(Rgba([u8::MAX; 4]));
                    colors.insert(name, Rgba([r, g, b, a]));
                }
            }
            "d" | "Tr" => {
                if let (Some(name), Some(byte)) = (current, byte()) {
                    let opacity = if key == "d" { byte } else { u8::MAX - byte };
                    colors.entry(name).or_insert(Rgba([u8::MAX; 4])).0[3] = opacity;
                }
            }
            _ => {}
        }
    }
    colors
}

#[cfg(test)]
mod tests {
    use super::{colors, text};
    use crate::SurfaceHead;
    use isokit_mesh::Rgba;

    #[test]
    fn every_byte_is_read_back() {
        for byte in 0..=255 {
            let color = Rgba([byte, 255 - byte, 7, byte]);
            let surface = SurfaceHead { color: Some(color), ..SurfaceHead::default() };
            let text = text([&surface].into_iter(), &["a".into()]);
            assert_eq!(colors(&text)["a"], color);
        }
    }

    #[test]
    fn broken_lines_say_nothing() {
        let text = "Kd 1 1 1\nnewmtl a b\nKd 1 0\nKd red\nTr 0.25\nd\n\nnewmtl\nKd 0 0 0";
        assert_eq!(colors(text).get("a b"), Some(&Rgba([255, 255, 255, 191])));
    }
}

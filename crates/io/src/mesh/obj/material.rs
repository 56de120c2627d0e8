//! MTL: the colours that an OBJ names.
//!
//! Only `Kd`, `d` and `Tr` are read, and whether there is a texture; shine says nothing of a surface's shape.

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

/// What is read of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Material {
    pub(super) color: Option<Rgba>,
    /// Whether a picture, which is not read, says what its colour is.
    pub(super) has_texture: bool,
}

impl Material {
    /// Its colour, which is white until something is said of it.
    fn color(&mut self) -> &mut Rgba {
        self.color.get_or_insert(Rgba([u8::MAX; 4]))
    }
}

/// The materials of a library by their names. What is not understood is passed over.
pub(super) fn materials(text: &str) -> HashMap<&str, Material> {
    let mut materials = HashMap::<_, Material>::new();
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
                    materials.entry(name).or_default().color().0[..3].copy_from_slice(&[r, g, b]);
                }
            }
            "d" | "Tr" => {
                if let (Some(name), Some(byte)) = (current, byte()) {
                    let opacity = if key == "d" { byte } else { u8::MAX - byte };
                    materials.entry(name).or_default().color().0[3] = opacity;
                }
            }
            "map_Kd" => {
                if let Some(name) = current.filter(|_| !value.trim().is_empty()) {
                    materials.entry(name).or_default().has_texture = true;
                }
            }
            _ => {}
        }
    }
    materials
}

#[cfg(test)]
mod tests {
    use super::{Material, materials, text};
    use crate::SurfaceHead;
    use isokit_mesh::Rgba;

    #[test]
    fn every_byte_is_read_back() {
        for byte in 0..=255 {
            let color = Rgba([byte, 255 - byte, 7, byte]);
            let surface = SurfaceHead { color: Some(color), ..SurfaceHead::default() };
            let text = text([&surface].into_iter(), &["a".into()]);
            let material = Material { color: Some(color), has_texture: false };
            assert_eq!(materials(&text)["a"], material);
        }
    }

    #[test]
    fn broken_lines_say_nothing() {
        let text = "Kd 1 1 1\nnewmtl a b\nKd 1 0\nKd red\nTr 0.25\nd\n\nnewmtl\nKd 0 0 0";
        let color = Some(Rgba([255, 255, 255, 191]));
        assert_eq!(materials(text)["a b"], Material { color, has_texture: false });
    }

    #[test]
    fn a_texture_is_no_colour() {
        let all = materials(
            "newmtl a\nmap_Kd -s 1 1 1 a b.png\nnewmtl b\nmap_Kd \nmap_Ks c.png\nKd 0 0 0",
        );
        assert_eq!(all["a"], Material { color: None, has_texture: true });
        assert_eq!(all["b"], Material { color: Some(Rgba([0, 0, 0, 255])), has_texture: false });
    }
}

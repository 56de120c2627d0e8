//! A mesh with a name, as files hold several of them.

use crate::TriMesh;
use std::{fmt, str::FromStr};

/// A mesh and what a file can say of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// What a viewer calls it.
    pub name: String,
    /// How it looks; `None` leaves it to the viewer.
    pub color: Option<Rgba>,
    /// The value it is the isosurface of, where it is one.
    pub iso: Option<f64>,
    /// The triangles.
    pub mesh: TriMesh,
}

/// A colour in sRGB with straight (not pre-multiplied) opacity, 8 bits each, as `#rrggbb[aa]` gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rgba(pub [u8; 4]);

impl Rgba {
    /// Whether something behind it shows through.
    pub fn is_translucent(self) -> bool {
        self.0[3] < u8::MAX
    }

    /// The colour in linear light, opacity last, each from 0 to 1 (IEC 61966-2-1).
    pub fn to_linear(self) -> [f32; 4] {
        let [r, g, b, a] = self.0.map(|byte| f64::from(byte) / 255.0);
        let linear = |s: f64| match s <= 0.040_45 {
            true => s / 12.92,
            false => ((s + 0.055) / 1.055).powf(2.4),
        };
        [linear(r), linear(g), linear(b), a].map(|c| c as f32)
    }

    /// The colour whose linear light this is.
    pub fn from_linear([r, g, b, a]: [f32; 4]) -> Self {
        let byte = |s: f64| (s * 255.0).round().clamp(0.0, 255.0) as u8;
        let [r, g, b] = [r, g, b].map(|c| byte(srgb_of_linear(c.into())));
        Self([r, g, b, byte(a.into())])
    }
}

/// The sRGB code of linear light, both from 0 to 1 (IEC 61966-2-1).
pub fn srgb_of_linear(light: f64) -> f64 {
    match light <= 0.003_130_8 {
        true => light * 12.92,
        false => 1.055 * light.powf(1.0 / 2.4) - 0.055,
    }
}

/// Not a colour.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected #rrggbb or #rrggbbaa, found {0:?}")]
pub struct ParseRgbaError(String);

impl FromStr for Rgba {
    type Err = ParseRgbaError;

    fn from_str(text: &str) -> Result<Self, ParseRgbaError> {
        let fail = || ParseRgbaError(text.to_owned());
        let digits = text.strip_prefix('#').ok_or_else(fail)?;
        let is_hex = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        if !is_hex || ![6, 8].contains(&digits.len()) {
            return Err(fail());
        }
        let mut bytes = [u8::MAX; 4];
        for (byte, pair) in bytes.iter_mut().zip(digits.as_bytes().chunks(2)) {
            let pair = str::from_utf8(pair).map_err(|_| fail())?;
            *byte = u8::from_str_radix(pair, 16).map_err(|_| fail())?;
        }
        Ok(Self(bytes))
    }
}

impl fmt::Display for Rgba {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b, a] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")?;
        if self.is_translucent() { write!(f, "{a:02x}") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::Rgba;

    #[test]
    fn colours_are_read_back_as_written() {
        for text in ["#d8a58080", "#000000", "#ffffff00"] {
            assert_eq!(text.parse::<Rgba>().unwrap().to_string(), text);
        }
        assert_eq!("#010203".parse(), Ok(Rgba([1, 2, 3, 255])));
        for text in ["", "d8a580", "#d8a5", "#d8a58", "#d8a5zz", "#+1+2+3", "#éaaaa"] {
            assert!(text.parse::<Rgba>().is_err(), "{text:?}");
        }
    }

    #[test]
    fn every_byte_survives_linear_light() {
        for byte in 0..=255 {
            let colour = Rgba([byte, 255 - byte, 7, byte]);
            assert_eq!(Rgba::from_linear(colour.to_linear()), colour);
        }
        assert_eq!(Rgba([255, 0, 0, 255]).to_linear(), [1.0, 0.0, 0.0, 1.0]);
    }
}

//! Pictures in linear light, and how they become bytes.

use crate::Gathered;
use isokit_job::{Limits, OverLimit};
use isokit_mesh::srgb_of_linear;
use std::num::NonZeroU32;

/// How many pixels a picture has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// From left to right.
    pub width: NonZeroU32,
    /// From top to bottom.
    pub height: NonZeroU32,
}

impl Size {
    /// All pixels.
    pub fn pixels(self) -> u64 {
        u64::from(self.width.get()) * u64::from(self.height.get())
    }
}

/// What is gathered in each pixel, row by row from the top.
///
/// # Guarantees
///
/// There is one for each pixel of its size.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    size: Size,
    pixels: Vec<Gathered>,
}

/// What shows where a picture is not opaque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// A colour in linear light: the picture is opaque.
    Color([f32; 3]),
    /// Nothing: the picture has an opacity, not multiplied into its colour.
    Transparent,
}

impl Image {
    /// A picture of nothing.
    ///
    /// # Errors
    ///
    /// If `limits` do not allow its bytes.
    pub fn new(size: Size, limits: &Limits) -> Result<Self, OverLimit> {
        let count = limits.probe("picture", Some(size.pixels()), size_of::<Gathered>())?;
        Ok(Self { size, pixels: vec![Gathered::NOTHING; count] })
    }

    /// How many pixels there are.
    pub fn size(&self) -> Size {
        self.size
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[Gathered] {
        &self.pixels
    }

    /// All pixels, to be changed.
    pub fn pixels_mut(&mut self) -> &mut [Gathered] {
        &mut self.pixels
    }

    /// The pixel in a column from the left of a row from the top.
    ///
    /// # Panics
    ///
    /// If there is no such pixel.
    pub fn pixel(&self, column: u32, row: u32) -> Gathered {
        assert!(column < self.size.width.get(), "column {column} of {}", self.size.width);
        self.pixels[row as usize * self.size.width.get() as usize + column as usize]
    }

    /// The picture before a background, in sRGB (IEC 61966-2-1), row by row from the top: red, green, blue and,
    /// before a transparent one, opacity, each from 0 to 1.
    pub fn encoded(&self, background: Background) -> impl Iterator<Item = [f32; 4]> {
        self.pixels.iter().map(move |&pixel| {
            let (color, opacity) = match background {
                Background::Color(color) => (pixel.over(Gathered::new(color, 1.0)).color, 1.0),
                Background::Transparent => (pixel.straight(), pixel.opacity),
            };
            let [r, g, b] = color.map(|part| srgb_of_linear(part.clamp(0.0, 1.0).into()) as f32);
            [r, g, b, opacity.clamp(0.0, 1.0)]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::{Background, Image, Size};
    use crate::Gathered;
    use isokit_job::Limits;
    use isokit_mesh::Rgba;
    use std::num::NonZeroU32;

    fn size(width: u32, height: u32) -> Size {
        let [width, height] = [width, height].map(|n| NonZeroU32::new(n).unwrap());
        Size { width, height }
    }

    #[test]
    fn a_picture_larger_than_allowed_takes_no_memory() {
        let huge = size(1 << 20, 1 << 20);
        let error = Image::new(huge, &Limits { bytes: 1 << 30 }).unwrap_err();
        assert_eq!(error.needed, 16 * huge.pixels());
        assert!(Image::new(size(64, 64), &Limits { bytes: 1 << 16 }).is_ok());
    }

    #[test]
    fn colours_come_out_as_their_codes_before_any_background() {
        for text in ["#000000", "#ffffff", "#d8a580", "#010203"] {
            let rgba: Rgba = text.parse().unwrap();
            let [r, g, b, _] = rgba.to_linear();
            let mut image = Image::new(size(1, 1), &Limits::default()).unwrap();
            for opacity in [0.25, 1.0] {
                image.pixels_mut()[0] = Gathered::new([r, g, b], opacity);
                let own = Background::Color([r, g, b]);
                for (background, alpha) in [(own, 1.0), (Background::Transparent, opacity)] {
                    let found = image.encoded(background).next().unwrap();
                    let bytes = found.map(|code| (code * 255.0).round() as u8);
                    assert_eq!(bytes[..3], rgba.0[..3], "{text} at {opacity}");
                    assert_eq!(found[3], alpha);
                }
            }
        }
    }
}

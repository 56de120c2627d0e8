//! Pictures as PNG (ISO/IEC 15948), in sRGB.

use crate::{Background, Image};
use std::io::Write;

/// Bits of each part of a colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// What displays show.
    #[default]
    Eight,
    /// For further work.
    Sixteen,
}

/// Why a picture was not written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the picture")]
pub struct PngError(#[from] png::EncodingError);

/// Writes a picture before a background. Before a transparent one it has an opacity, which is not multiplied into its
/// colour.
///
/// # Errors
///
/// If `out` takes no more.
pub fn write_png(
    image: &Image,
    background: Background,
    depth: Depth,
    out: impl Write,
) -> Result<(), PngError> {
    let (size, is_opaque) = (image.size(), background != Background::Transparent);
    let mut encoder = png::Encoder::new(out, size.width.get(), size.height.get());
    encoder.set_color(if is_opaque { png::ColorType::Rgb } else { png::ColorType::Rgba });
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_depth(match depth {
        Depth::Eight => png::BitDepth::Eight,
        Depth::Sixteen => png::BitDepth::Sixteen,
    });
    let channels = if is_opaque { 3 } else { 4 };
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let width = size.width.get() as usize;
    let mut row = Vec::with_capacity(width * channels * 2);
    let mut pixels = image.encoded(background);
    for _ in 0..size.height.get() {
        row.clear();
        for code in pixels.by_ref().take(width).flat_map(|all| all.into_iter().take(channels)) {
            match depth {
                Depth::Eight => row.push((code * 255.0).round() as u8),
                Depth::Sixteen => row.extend(((code * 65535.0).round() as u16).to_be_bytes()),
            }
        }
        stream.write_all(&row).map_err(png::EncodingError::from)?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Depth, write_png};
    use crate::{Background, Gathered, Image, Size};
    use isokit_job::Limits;
    use std::{io::Cursor, num::NonZeroU32};

    /// Two pixels side by side above two others: half of a red, nothing, white, and a green.
    fn picture() -> Image {
        let two = NonZeroU32::new(2).unwrap();
        let mut image = Image::new(Size { width: two, height: two }, &Limits::default()).unwrap();
        image.pixels_mut().copy_from_slice(&[
            Gathered::new([1.0, 0.0, 0.0], 0.5),
            Gathered::NOTHING,
            Gathered::new([1.0; 3], 1.0),
            Gathered::new([0.0, 0.2, 0.0], 1.0),
        ]);
        image
    }

    fn read_back(background: Background, depth: Depth) -> (png::ColorType, Vec<u8>) {
        let mut bytes = vec![];
        write_png(&picture(), background, depth, &mut bytes).unwrap();
        let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let found = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((found.width, found.height), (2, 2));
        (found.color_type, pixels)
    }

    #[test]
    fn a_transparent_background_leaves_colours_as_they_are() {
        let (color, pixels) = read_back(Background::Transparent, Depth::Eight);
        assert_eq!(color, png::ColorType::Rgba);
        let green = 124; // 1.055 · 0.2^(1/2.4) − 0.055, in 255ths
        let expected = [[255, 0, 0, 128], [0; 4], [255; 4], [0, green, 0, 255]];
        assert_eq!(pixels, expected.concat());
    }

    #[test]
    fn before_a_colour_it_is_opaque_and_mixed_in_linear_light() {
        let (color, pixels) = read_back(Background::Color([0.0, 0.0, 1.0]), Depth::Sixteen);
        assert_eq!(color, png::ColorType::Rgb);
        let parts: Vec<u16> =
            pixels.chunks(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect();
        // Half of the light has the code 0.735357.
        assert_eq!(parts[..6], [48_192, 0, 48_192, 0, 0, 65_535]);
    }
}

//! Pictures as PNG (ISO/IEC 15948), in sRGB.

use crate::{Background, Channel, Image};
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

/// Writes what is no colour with 16 bits, as it is and not as light: of [`Channel::Depth`] a grey from the nearest, 0, to
/// the farthest, 1, which come back; of [`Channel::Normal`] three parts from −1, as 0, to 1. Nothing is seen through.
///
/// # Errors
///
/// If `out` takes no more.
///
/// # Panics
///
/// If the channel is that of colours.
pub fn write_channel_png(
    image: &Image,
    channel: Channel,
    out: impl Write,
) -> Result<Option<[f32; 2]>, PngError> {
    assert_ne!(channel, Channel::Color, "colours are written by write_png");
    let seen = || image.pixels().iter().filter(|pixel| pixel.opacity > 0.0);
    let depths = seen().map(|pixel| pixel.color[0]);
    let [near, far] = depths
        .fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], depth| [a.min(depth), b.max(depth)]);
    let size = image.size();
    let mut encoder = png::Encoder::new(out, size.width.get(), size.height.get());
    encoder.set_depth(png::BitDepth::Sixteen);
    encoder.set_color(match channel {
        Channel::Normal => png::ColorType::Rgba,
        _ => png::ColorType::GrayscaleAlpha,
    });
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let width = size.width.get() as usize;
    let mut row = Vec::with_capacity(width * 8);
    for pixels in image.pixels().chunks(width) {
        row.clear();
        let mut put = |share: f32| {
            row.extend(((share.clamp(0.0, 1.0) * 65535.0).round() as u16).to_be_bytes());
        };
        for pixel in pixels {
            let is_seen = pixel.opacity > 0.0;
            match channel {
                Channel::Normal => pixel
                    .color
                    .iter()
                    .for_each(|part| put(if is_seen { 0.5 * part + 0.5 } else { 0.0 })),
                _ if is_seen && far > near => put((pixel.color[0] - near) / (far - near)),
                _ => put(0.0),
            }
            put(f32::from(u8::from(is_seen)));
        }
        stream.write_all(&row).map_err(png::EncodingError::from)?;
    }
    stream.finish()?;
    writer.finish()?;
    Ok((near <= far).then_some([near, far]))
}

#[cfg(test)]
mod tests {
    use super::{Depth, write_channel_png, write_png};
    use crate::{Background, Channel, Gathered, Image, Size};
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

    #[test]
    fn depths_and_normals_are_written_as_they_are() {
        let mut image = picture();
        let seen = |color| Gathered { color, opacity: 1.0 };
        image.pixels_mut().copy_from_slice(&[
            seen([-1.0, 0.0, 1.0]),
            Gathered::NOTHING,
            seen([3.0; 3]),
            seen([1.0; 3]),
        ]);
        let written = |channel| {
            let mut file = vec![];
            let range = write_channel_png(&image, channel, &mut file).unwrap();
            let mut reader = png::Decoder::new(Cursor::new(file)).read_info().unwrap();
            let mut all = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut all).unwrap();
            let parts = all.chunks(2).map(|two| u16::from_be_bytes([two[0], two[1]]));
            (range, parts.collect::<Vec<_>>())
        };
        let most = u16::MAX;
        let (range, depths) = written(Channel::Depth);
        assert_eq!(range, Some([-1.0, 3.0]));
        assert_eq!(depths, [0, most, 0, 0, most, most, 1 << 15, most]);
        let (_, normals) = written(Channel::Normal);
        assert_eq!(normals[..8], [0, 1 << 15, most, most, 0, 0, 0, 0]);
    }
}

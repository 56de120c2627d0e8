//! gzip, zlib and bzip2 as streams of bytes.

use bzip2::bufread::BzDecoder;
use flate2::bufread::{GzDecoder, ZlibDecoder};
use std::{
    fmt,
    io::{self, BufRead, Read},
};

/// How bytes are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layer {
    Plain,
    Gzip,
    Zlib,
    Bzip2,
}

impl Layer {
    /// What the first bytes of a file show. zlib has no mark that other data could not have.
    pub(crate) fn of_content(head: &[u8]) -> Self {
        match head {
            [0x1f, 0x8b, 8, ..] => Self::Gzip,
            [b'B', b'Z', b'h', b'1'..=b'9', 0x31 | 0x17, ..] => Self::Bzip2,
            _ => Self::Plain,
        }
    }

    /// How many bytes `packed` bytes can become, at most.
    ///
    /// Deflate spends a bit on up to 129 bytes, which makes 1032 of one. A block of bzip2 takes more
    /// than 22 bytes and becomes no more than 45.9 million, which is below 2²¹ each.
    pub(crate) fn most(self, packed: u64) -> u64 {
        match self {
            Self::Plain => packed,
            Self::Gzip | Self::Zlib => packed.saturating_mul(1032),
            Self::Bzip2 => packed.saturating_mul(1 << 21),
        }
    }
}

/// What `reader` holds, unpacked. Packed parts may follow each other; what else follows is ignored,
/// as `gzip` and `bzip2` do.
pub(super) struct Unpacked<R> {
    layer: Layer,
    decoder: Decoder<R>,
}

enum Decoder<R> {
    Gzip(GzDecoder<R>),
    Zlib(ZlibDecoder<R>),
    Bzip2(BzDecoder<R>),
    Ended,
}

impl<R> fmt::Debug for Unpacked<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Unpacked").field("layer", &self.layer).finish_non_exhaustive()
    }
}

impl<R: BufRead> Unpacked<R> {
    pub(super) fn new(layer: Layer, reader: R) -> Self {
        let decoder = match layer {
            Layer::Plain => Decoder::Ended,
            Layer::Gzip => Decoder::Gzip(GzDecoder::new(reader)),
            Layer::Zlib => Decoder::Zlib(ZlibDecoder::new(reader)),
            Layer::Bzip2 => Decoder::Bzip2(BzDecoder::new(reader)),
        };
        Self { layer, decoder }
    }

    /// The next part, if another follows.
    fn next(&mut self) -> io::Result<()> {
        let (mut reader, mark) = match std::mem::replace(&mut self.decoder, Decoder::Ended) {
            Decoder::Gzip(decoder) => (decoder.into_inner(), 0x1f),
            Decoder::Bzip2(decoder) => (decoder.into_inner(), b'B'),
            Decoder::Zlib(_) | Decoder::Ended => return Ok(()),
        };
        // The first byte alone: the buffer may end just there.
        if reader.fill_buf()?.first() == Some(&mark) {
            *self = Self::new(self.layer, reader);
        }
        Ok(())
    }
}

impl<R: BufRead> Read for Unpacked<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            let count = match &mut self.decoder {
                Decoder::Gzip(decoder) => decoder.read(into)?,
                Decoder::Zlib(decoder) => decoder.read(into)?,
                Decoder::Bzip2(decoder) => decoder.read(into)?,
                Decoder::Ended => return Ok(0),
            };
            if count > 0 || into.is_empty() {
                return Ok(count);
            }
            self.next()?;
        }
    }
}

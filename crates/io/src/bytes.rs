//! Bytes of a file: one layer of gzip or bzip2 taken off, numbers in either byte order.
//!
//! How many bytes can still come is known before any is read: exactly for a plain file, at most for a
//! packed one, from how far its packing can compress. So what a header announces is checked against
//! the file before memory is taken for it.

mod unpack;

pub(crate) use unpack::Layer;

use crate::{Format, Place, ReadError, ReadFault};
use isokit_job::Job;
use std::{
    fs::File,
    io::{self, BufRead, BufReader, ErrorKind, Read},
    path::Path,
};
use unpack::Unpacked;

/// The order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Endian {
    /// Least significant byte first.
    Little,
    /// Most significant byte first.
    Big,
}

impl Endian {
    /// This machine's order.
    pub const NATIVE: Self = if cfg!(target_endian = "big") { Self::Big } else { Self::Little };
}

/// A binary header.
#[derive(Clone, Copy)]
pub(crate) struct Record<'a> {
    /// All of it; every number asked for lies inside.
    pub(crate) bytes: &'a [u8],
    pub(crate) endian: Endian,
}

macro_rules! numbers {
    ($($t:ident),*) => {$(
        pub(crate) fn $t(self, at: usize) -> $t {
            let mut number = [0; size_of::<$t>()];
            number.copy_from_slice(&self.bytes[at..at + size_of::<$t>()]);
            match self.endian {
                Endian::Little => $t::from_le_bytes(number),
                Endian::Big => $t::from_be_bytes(number),
            }
        }
    )*};
}

impl Record<'_> {
    numbers!(i16, i32, i64, f32, f64);
}

/// A file being read from its start.
#[derive(Debug)]
pub(crate) struct Bytes {
    reader: Reader,
    position: u64,
    left: u64,
}

#[derive(Debug)]
enum Reader {
    Plain(BufReader<File>),
    Packed(Box<BufReader<Unpacked<Reader>>>),
}

/// Larger reads go past the buffer, straight to where they are wanted.
const BUFFER: usize = 1 << 16;

/// Bytes read between two looks at the cancel token.
const PIECE: u64 = 1 << 22;

impl Bytes {
    /// The file at `path`; a layer of gzip or bzip2 is taken off where its first bytes show one.
    pub(crate) fn open(path: &Path) -> Result<Self, ReadError> {
        let open = || {
            let mut plain = Self::open_plain(path)?;
            let layer = Layer::of_content(plain.fill_buf()?);
            Ok(plain.unpack(layer))
        };
        open().map_err(|error: io::Error| ReadFault::Io(error).at(path))
    }

    /// The file as it is.
    pub(crate) fn open_plain(path: &Path) -> io::Result<Self> {
        // Before it is opened: opening a pipe waits for whoever writes to it.
        let found = path.metadata()?;
        if !found.is_file() {
            return Err(io::Error::new(ErrorKind::InvalidInput, "not a regular file"));
        }
        let reader = BufReader::with_capacity(BUFFER, File::open(path)?);
        Ok(Self { reader: Reader::Plain(reader), position: 0, left: found.len() })
    }

    /// From here on, what is packed this way. The position counts from 0 again.
    pub(crate) fn unpack(self, layer: Layer) -> Self {
        if layer == Layer::Plain {
            return self;
        }
        let unpacked = Unpacked::new(layer, self.reader);
        let reader = Reader::Packed(Box::new(BufReader::with_capacity(BUFFER, unpacked)));
        Self { reader, position: 0, left: layer.most(self.left) }
    }

    /// How many bytes came so far.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// How many bytes can still come, at most.
    pub(crate) fn left(&self) -> u64 {
        self.left
    }

    /// How many bytes will still come, if that is known.
    pub(crate) fn exactly_left(&self) -> Option<u64> {
        matches!(self.reader, Reader::Plain(_)).then_some(self.left)
    }

    /// Reads until `into` is full or there is no more, and says how many bytes came.
    ///
    /// A packed stream that breaks off counts as one that ends.
    pub(crate) fn read_up_to(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let mut done = 0;
        while done < into.len() {
            match self.read(&mut into[done..]) {
                Ok(0) => break,
                Ok(count) => done += count,
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if error.kind() == ErrorKind::UnexpectedEof => break,
                Err(error) => return Err(error),
            }
        }
        Ok(done)
    }

    /// Goes on by `count` bytes, or to the end, and says how many that were.
    pub(crate) fn skip(&mut self, count: u64, format: Format, job: &Job) -> Result<u64, ReadFault> {
        let count = count.min(self.left);
        if let Reader::Plain(reader) = &mut self.reader {
            // The size of a file fits an `i64` on every system.
            reader.seek_relative(count as i64)?;
            self.passed(count);
            return Ok(count);
        }
        let mut done = 0;
        while done < count {
            job.check()?;
            let piece = PIECE.min(count - done);
            let passed = io::copy(&mut self.take(piece), &mut io::sink());
            match passed.map_err(|error| self.fault(format, error))? {
                0 => break,
                passed => done += passed,
            }
        }
        Ok(done)
    }

    /// What is wrong when reading failed here.
    pub(crate) fn fault(&self, format: Format, error: io::Error) -> ReadFault {
        match error.kind() {
            ErrorKind::InvalidData | ErrorKind::InvalidInput | ErrorKind::UnexpectedEof => {
                ReadFault::Broken {
                    format,
                    place: Place::Byte(self.position),
                    expected: "sound compressed data".into(),
                    found: error.to_string(),
                }
            }
            _ => error.into(),
        }
    }

    fn passed(&mut self, count: u64) {
        self.position += count;
        self.left = self.left.saturating_sub(count);
    }
}

impl Read for Bytes {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(into)?;
        self.passed(count as u64);
        Ok(count)
    }
}

impl BufRead for Bytes {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.reader.fill_buf()
    }

    fn consume(&mut self, count: usize) {
        self.reader.consume(count);
        self.passed(count as u64);
    }
}

impl Read for Reader {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(reader) => reader.read(into),
            Self::Packed(reader) => reader.read(into),
        }
    }
}

impl BufRead for Reader {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match self {
            Self::Plain(reader) => reader.fill_buf(),
            Self::Packed(reader) => reader.fill_buf(),
        }
    }

    fn consume(&mut self, count: usize) {
        match self {
            Self::Plain(reader) => reader.consume(count),
            Self::Packed(reader) => reader.consume(count),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Bytes, Endian, Record};
    use crate::Format;
    use flate2::{Compression, write::GzEncoder};
    use isokit_job::Job;
    use std::{fs, io::Read, io::Write};

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(vec![], Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn file_of(bytes: &[u8]) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), bytes).unwrap();
        file
    }

    #[test]
    fn numbers_are_read_in_either_order() {
        let bytes = [1, 2, 0, 0, 0x3f, 0x80, 0, 0];
        let record = |endian| Record { bytes: &bytes, endian };
        assert_eq!(record(Endian::Little).i16(0), 0x0201);
        assert_eq!(record(Endian::Big).i16(0), 0x0102);
        assert_eq!(record(Endian::Big).f32(4), 1.0);
    }

    #[test]
    fn one_layer_is_taken_off_and_no_more() {
        let inner = gzip(b"samples");
        let mut all = vec![];
        Bytes::open(file_of(&gzip(&inner)).path()).unwrap().read_to_end(&mut all).unwrap();
        assert_eq!(all, inner);
    }

    #[test]
    fn members_follow_each_other_and_what_follows_them_is_ignored() {
        let mut file = vec![];
        for _ in 0..50_000 {
            file.extend(gzip(b"ab"));
        }
        file.extend(b"\n");
        let mut all = String::new();
        Bytes::open(file_of(&file).path()).unwrap().read_to_string(&mut all).unwrap();
        assert_eq!(all, "ab".repeat(50_000));
    }

    #[test]
    fn no_more_bytes_come_than_were_said_to_be_left() {
        let zeros = vec![0; 10_000_000];
        let mut encoder = bzip2::write::BzEncoder::new(vec![], bzip2::Compression::best());
        encoder.write_all(&zeros).unwrap();
        for packed in [gzip(&zeros), encoder.finish().unwrap()] {
            let bytes = Bytes::open(file_of(&packed).path()).unwrap();
            assert!(bytes.left() >= 10_000_000, "{}", bytes.left());
        }
    }

    #[test]
    fn a_skip_counts_what_it_passed() {
        for content in [vec![7; 1000], gzip(&[7; 1000])] {
            let file = file_of(&content);
            let mut bytes = Bytes::open(file.path()).unwrap();
            let mut skip = |count| bytes.skip(count, Format::Raw, &Job::default()).unwrap();
            assert_eq!((skip(10), skip(u64::MAX), skip(1)), (10, 990, 0));
        }
    }
}

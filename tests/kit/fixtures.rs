//! The volumes of `fixtures/volumes`, made here and nowhere else.
//!
//! The small writers beside this file are no part of the library: what the library reads is thereby
//! checked against bytes that it did not write.

mod head;
mod labels;
mod marschner_lobb;
mod nifti;
mod npy;
mod nrrd;
mod orbital;
mod part;
mod ties;

use flate2::{Compression, read::MultiGzDecoder, write::GzEncoder};
use isokit::volume::{AnyVolume, Sample};
use std::{
    io::{self, Read, Write},
    sync::LazyLock,
};

/// A volume, and the file that holds it.
#[derive(Clone, Debug)]
pub struct Fixture {
    /// The file's name.
    pub name: &'static str,
    /// What a reader should find in it.
    pub volume: AnyVolume,
    /// The bytes before the samples.
    head: Vec<u8>,
    /// The samples.
    body: Vec<u8>,
    packing: Packing,
}

/// Which bytes of a file are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Packing {
    None,
    /// The samples, with gzip.
    Body,
    /// The whole file, with gzip.
    All,
}

/// All of them, in the order of the table in `fixtures/README.md`. Made once, when first asked for.
pub fn all() -> &'static [Fixture] {
    static ALL: LazyLock<Vec<Fixture>> = LazyLock::new(|| {
        vec![
            head::fixture(),
            marschner_lobb::fixture(),
            part::fixture(),
            orbital::fixture(),
            labels::fixture(),
            ties::fixture(),
        ]
    });
    &ALL
}

/// The fixture of this name.
///
/// # Panics
///
/// If there is none.
pub fn named(name: &str) -> &'static Fixture {
    all().iter().find(|fixture| fixture.name == name).expect("one of the fixtures")
}

impl Fixture {
    /// The bytes of the file.
    pub fn file(&self) -> Vec<u8> {
        match self.packing {
            Packing::None => [&*self.head, &self.body].concat(),
            Packing::Body => [&*self.head, &packed(&self.body)].concat(),
            Packing::All => packed(&[&*self.head, &self.body].concat()),
        }
    }

    /// Whether a file has this content. Two compressors may pack it differently.
    pub fn is_held_by(&self, file: &[u8]) -> bool {
        let whole = [&*self.head, &self.body].concat();
        let found = match self.packing {
            Packing::None => Ok(file.to_vec()),
            Packing::Body => {
                let (head, body) = file.split_at(self.head.len().min(file.len()));
                unpacked(body).map(|body| [head, &body].concat())
            }
            Packing::All => unpacked(file),
        };
        found.is_ok_and(|found| found == whole)
    }
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(vec![], Compression::best());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("a vector takes all")
}

fn unpacked(bytes: &[u8]) -> io::Result<Vec<u8>> {
    let mut all = vec![];
    MultiGzDecoder::new(bytes).read_to_end(&mut all)?;
    Ok(all)
}

/// The samples as little-endian bytes.
fn little_endian<T: Sample + ToLittleEndian>(samples: &[T]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(size_of_val(samples));
    samples.iter().for_each(|sample| sample.append(&mut bytes));
    bytes
}

trait ToLittleEndian {
    fn append(&self, bytes: &mut Vec<u8>);
}

macro_rules! to_little_endian {
    ($($t:ty),*) => {$(
        impl ToLittleEndian for $t {
            fn append(&self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        }
    )*};
}

to_little_endian!(u8, i8, i16, f32);

#[cfg(test)]
mod tests {
    use super::{Fixture, Packing, ties};

    #[test]
    fn a_file_holds_its_fixture_until_a_byte_changes() {
        for packing in [Packing::None, Packing::Body, Packing::All] {
            let fixture = Fixture { packing, ..ties::fixture() };
            let mut file = fixture.file();
            assert!(fixture.is_held_by(&file), "{packing:?}");
            assert!(!fixture.is_held_by(&file[..file.len() - 1]), "{packing:?}");
            let middle = file.len() / 2;
            file[middle] ^= 1;
            assert!(!fixture.is_held_by(&file), "{packing:?}");
        }
    }
}

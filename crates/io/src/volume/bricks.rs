//! The index of a volume, kept in a file beside it.
//!
//! `scan.nii.gz.bricks` has the least and the greatest sample of every brick of `scan.nii.gz`, little-endian:
//!
//! | bytes | what |
//! | --- | --- |
//! | 8 | `isobrick` |
//! | 4 | version: 1 |
//! | 4 | the type of a sample: its place in [`Dtype::ALL`] |
//! | 3 × 8 | samples along x, y, z |
//! | 8 | fingerprint of the volume: sizes and times of its files, and how samples lie in them |
//! | n × sample | the least of each brick, x fastest |
//! | n × sample | the greatest |
//! | n | 1 where a brick has NaN, else 0 |
//! | 8 | checksum of all bytes before |
//!
//! Samples are as stored: the file does not depend on what they mean or where they are. One that is not
//! exactly as expected is not used, whatever is wrong with it.

use super::VolumeFile;
use crate::{Output, WriteError, WriteFault};
use isokit_lanes::Extent;
use isokit_volume::{BrickGrid, Bricks, Dtype, Sample};
use std::{
    fmt,
    fs::{self, File},
    io::{self, Read, Write},
    path::{Path, PathBuf},
    time::UNIX_EPOCH,
};

const MAGIC: [u8; 8] = *b"isobrick";
const VERSION: u32 = 1;

/// Where the index of a volume is kept, and which volume it must be of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrickFile {
    path: PathBuf,
    dtype: Dtype,
    grid: BrickGrid,
    fingerprint: u64,
}

/// Why an index is not used. Each is a reason to make a new one.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NoBricks {
    /// There is no file.
    Absent,
    /// It is of another volume, or of this one before it was changed.
    Stale,
    /// It is no index, or a damaged one.
    Broken,
    /// The system does not let us read it.
    Unreadable(io::ErrorKind),
}

impl fmt::Display for NoBricks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Absent => f.write_str("there is none"),
            Self::Stale => f.write_str("the volume has changed since"),
            Self::Broken => f.write_str("it is no index, or damaged"),
            Self::Unreadable(kind) => write!(f, "it cannot be read: {kind}"),
        }
    }
}

impl VolumeFile {
    /// Where the index of this volume is kept.
    ///
    /// # Errors
    ///
    /// If the system does not tell size and time of a file, if one is no regular file, or if the volume is a
    /// quantity of vectors.
    pub fn bricks(&self) -> io::Result<BrickFile> {
        if self.is_of_vectors() {
            return Err(io::Error::other("a quantity of vectors has no index"));
        }
        let (stored, count) = (&self.stored, self.grid.count());
        let mut sum = Fnv::default();
        let last = (self.first + count).div_ceil(stored.per_file);
        let data = (self.first / stored.per_file..last).map(|n| stored.files.path(n));
        for path in [self.path.clone()].into_iter().chain(data) {
            let facts = fs::metadata(path)?;
            if !facts.is_file() {
                return Err(io::Error::other("no regular file"));
            }
            let since = facts.modified()?.duration_since(UNIX_EPOCH).unwrap_or_default();
            sum.add(&facts.len().to_le_bytes());
            sum.add(&since.as_nanos().to_le_bytes());
        }
        let lies = (stored.header, stored.lines, stored.coding, stored.skip, stored.per_file);
        sum.add(format!("{lies:?} {:?} {:?}", stored.endian, stored.order).as_bytes());
        sum.add(&self.first.to_le_bytes());
        let index = self.first / count;
        let name = self.path.file_name().unwrap_or_default().to_string_lossy();
        let name = match index {
            0 => format!("{name}.bricks"),
            _ => format!("{name}.{index}.bricks"),
        };
        let dims = self.grid.dims().map(|n| usize::try_from(n).unwrap_or(usize::MAX));
        let (path, grid) = (self.path.with_file_name(name), BrickGrid::new(dims));
        Ok(BrickFile { path, dtype: self.dtype(), grid, fingerprint: sum.0 })
    }
}

impl BrickFile {
    /// Where the file is, if there is one.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The index, if it is whole and of the volume as it is now.
    ///
    /// # Errors
    ///
    /// If not, with the reason.
    pub fn read<T: Sample>(&self) -> Result<Bricks<T>, NoBricks> {
        let unreadable = |error: io::Error| match error.kind() {
            io::ErrorKind::NotFound => NoBricks::Absent,
            kind => NoBricks::Unreadable(kind),
        };
        let facts = fs::metadata(&self.path).map_err(unreadable)?;
        if !facts.is_file() {
            return Err(NoBricks::Broken); // a pipe would keep us waiting
        }
        let file = File::open(&self.path).map_err(unreadable)?;
        let mut header = [0; HEADER];
        (&file).read_exact(&mut header).map_err(|_| NoBricks::Broken)?;
        if header[..12] != self.header()[..12] {
            return Err(NoBricks::Broken);
        }
        if header != self.header() || T::DTYPE != self.dtype {
            return Err(NoBricks::Stale);
        }
        let (Some(count), Some(rest)) = (self.grid.count(), self.rest()) else {
            return Err(NoBricks::Broken);
        };
        if facts.len() != HEADER as u64 + rest {
            return Err(NoBricks::Broken);
        }
        // As many bytes as the file has, so no more memory than that is asked for.
        let mut bytes = Vec::with_capacity(rest as usize);
        file.take(rest).read_to_end(&mut bytes).map_err(unreadable)?;
        let (body, sum) = bytes.split_last_chunk::<8>().ok_or(NoBricks::Broken)?;
        if bytes.len() as u64 != rest || u64::from_le_bytes(*sum) != checksum(&header, body) {
            return Err(NoBricks::Broken);
        }
        let ends = count as usize * size_of::<T>();
        let (ends, nan) = body.split_at(2 * ends);
        let ends: Vec<T> = ends.chunks_exact(size_of::<T>()).map(from_le).collect();
        let (least, greatest) = ends.split_at(count as usize);
        let extents = least
            .iter()
            .zip(greatest)
            .zip(nan)
            .map(|((&least, &greatest), &nan)| Extent { least, greatest, has_nan: nan != 0 });
        Bricks::from_extents(self.grid.dims(), extents.collect()).ok_or(NoBricks::Broken)
    }

    /// Keeps an index. A reader finds all of it or the one before.
    ///
    /// # Errors
    ///
    /// If it cannot be written.
    ///
    /// # Panics
    ///
    /// If the index is of other sizes or samples than the volume.
    pub fn write<T: Sample>(&self, bricks: &Bricks<T>) -> Result<(), WriteError> {
        assert_eq!((bricks.grid(), T::DTYPE), (&self.grid, self.dtype), "the volume's own");
        let mut bytes = self.header().to_vec();
        for end in [|e: &Extent<T>| e.least, |e: &Extent<T>| e.greatest] {
            bricks.extents().iter().for_each(|extent| push_le(end(extent), &mut bytes));
        }
        bytes.extend(bricks.extents().iter().map(|extent| u8::from(extent.has_nan)));
        let sum = checksum(&bytes, &[]);
        bytes.extend(sum.to_le_bytes());
        let mut output = Output::create(&self.path)?;
        output.write_all(&bytes).map_err(|error| WriteFault::Io(error).at(&self.path))?;
        output.finish()
    }

    fn header(&self) -> [u8; HEADER] {
        let mut header = [0; HEADER];
        let dtype = Dtype::ALL.iter().position(|&dtype| dtype == self.dtype).unwrap_or(0) as u32;
        header[..8].copy_from_slice(&MAGIC);
        header[8..12].copy_from_slice(&VERSION.to_le_bytes());
        header[12..16].copy_from_slice(&dtype.to_le_bytes());
        for (bytes, n) in header[16..40].chunks_exact_mut(8).zip(self.grid.dims()) {
            bytes.copy_from_slice(&(n as u64).to_le_bytes());
        }
        header[40..].copy_from_slice(&self.fingerprint.to_le_bytes());
        header
    }

    /// Bytes after the header.
    fn rest(&self) -> Option<u64> {
        self.grid.count()?.checked_mul(2 * self.dtype.bytes() as u64 + 1)?.checked_add(8)
    }
}

/// Bytes before the samples.
const HEADER: usize = 48;

fn from_le<T: Sample>(bytes: &[u8]) -> T {
    let sample: T = bytemuck::pod_read_unaligned(bytes);
    if cfg!(target_endian = "big") { sample.swap_bytes() } else { sample }
}

fn push_le<T: Sample>(sample: T, bytes: &mut Vec<u8>) {
    let sample = if cfg!(target_endian = "big") { sample.swap_bytes() } else { sample };
    bytes.extend(bytemuck::bytes_of(&sample));
}

fn checksum(header: &[u8], body: &[u8]) -> u64 {
    let mut sum = Fnv::default();
    sum.add(header);
    sum.add(body);
    sum.0
}

/// FNV-1a (Fowler, Noll & Vo): the same on every machine and in every version. It finds accidents, not
/// intentions.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }
}

impl Fnv {
    fn add(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{BrickFile, NoBricks};
    use crate::{RawLayout, VolumeOptions, open_volume};
    use isokit_job::Job;
    use isokit_volume::{AnyVolume, Bricks, Sample, for_any, for_dtype};
    use proptest::prelude::*;
    use std::{fs, path::Path};
    use tempfile::TempDir;

    const DIMS: [u64; 3] = [130, 10, 20];

    /// A raw volume of chance samples, and where its index goes.
    fn volume(folder: &Path, dtype: isokit_volume::Dtype) -> (BrickFile, AnyVolume) {
        let path = folder.join(format!("{dtype}.raw"));
        if !path.exists() {
            let count = DIMS.iter().product::<u64>() as usize * dtype.bytes();
            let bytes: Vec<u8> = (0..count).map(|n| (n * n / 7 % 251) as u8).collect();
            fs::write(&path, bytes).unwrap();
        }
        let (endian, skip) = (crate::Endian::NATIVE, 0);
        let raw = Some(RawLayout { dims: DIMS, dtype, endian, skip });
        let options = VolumeOptions { raw, ..Default::default() };
        let file = open_volume(&path, &options, &Job::default()).unwrap();
        (file.bricks().unwrap(), file.collect(&Job::default()).unwrap())
    }

    fn kept(folder: &Path) -> (BrickFile, Vec<u8>) {
        let (file, any) = volume(folder, isokit_volume::Dtype::I16);
        let AnyVolume::I16(volume) = any else { panic!("another type") };
        file.write(&Bricks::of(&volume.view(), &Job::default()).unwrap()).unwrap();
        let bytes = fs::read(file.path()).unwrap();
        (file, bytes)
    }

    #[test]
    fn what_is_kept_is_found_again_for_every_type() {
        fn check<T: Sample>(file: &BrickFile, view: &isokit_volume::View<'_, T>) {
            assert_eq!(file.read::<T>(), Err(NoBricks::Absent));
            let bricks = Bricks::of(view, &Job::default()).unwrap();
            file.write(&bricks).unwrap();
            assert_eq!(file.read::<T>(), Ok(bricks));
        }
        let folder = TempDir::new().unwrap();
        for dtype in isokit_volume::Dtype::ALL {
            let (file, volume) = volume(folder.path(), dtype);
            assert_eq!(file.path(), folder.path().join(format!("{dtype}.raw.bricks")));
            for_any!(&volume, volume => check(&file, &volume.view()));
            for_dtype!(dtype, T => assert!(file.read::<T>().is_ok()));
        }
    }

    #[test]
    fn a_volume_that_changed_has_no_index_any_more() {
        let folder = TempDir::new().unwrap();
        let (file, _) = kept(folder.path());
        let path = folder.path().join("i16.raw");
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes).unwrap();
        let later = std::time::SystemTime::now() + std::time::Duration::from_secs(2);
        fs::File::options().write(true).open(&path).unwrap().set_modified(later).unwrap();
        let (now, _) = volume(folder.path(), isokit_volume::Dtype::I16);
        assert_eq!(now.path(), file.path());
        assert_eq!(now.read::<i16>(), Err(NoBricks::Stale));
    }

    #[test]
    fn other_sizes_types_or_volumes_are_stale() {
        let folder = TempDir::new().unwrap();
        let (file, _) = kept(folder.path());
        assert_eq!(file.read::<u16>(), Err(NoBricks::Stale));
        let grid = isokit_volume::BrickGrid::new([130, 20, 10]);
        assert_eq!(BrickFile { grid, ..file.clone() }.read::<i16>(), Err(NoBricks::Stale));
        let other = BrickFile { fingerprint: file.fingerprint ^ 1, ..file };
        assert_eq!(other.read::<i16>(), Err(NoBricks::Stale));
    }

    #[test]
    fn an_index_that_was_cut_off_or_goes_on_is_not_used() {
        let folder = TempDir::new().unwrap();
        let (file, bytes) = kept(folder.path());
        for length in 0..bytes.len() {
            fs::write(file.path(), &bytes[..length]).unwrap();
            assert_eq!(file.read::<i16>(), Err(NoBricks::Broken), "{length} bytes");
        }
        fs::write(file.path(), [&bytes[..], &[0]].concat()).unwrap();
        assert_eq!(file.read::<i16>(), Err(NoBricks::Broken));
    }

    #[test]
    fn no_changed_byte_goes_unnoticed() {
        let folder = TempDir::new().unwrap();
        let (file, bytes) = kept(folder.path());
        for at in 0..bytes.len() {
            let mut broken = bytes.clone();
            broken[at] ^= 1 << (at % 8);
            fs::write(file.path(), broken).unwrap();
            assert!(file.read::<i16>().is_err(), "byte {at}");
        }
    }

    #[test]
    fn a_folder_in_its_place_is_not_read() {
        let folder = TempDir::new().unwrap();
        let (file, _) = volume(folder.path(), isokit_volume::Dtype::I16);
        fs::create_dir(file.path()).unwrap();
        assert_eq!(file.read::<i16>(), Err(NoBricks::Broken));
    }

    proptest! {
        #[test]
        fn chance_is_no_index(bytes in prop::collection::vec(any::<u8>(), 0..900), start: bool) {
            let folder = TempDir::new().unwrap();
            let (file, kept) = kept(folder.path());
            let head = if start { &kept[..48] } else { &[] };
            fs::write(file.path(), [head, &bytes].concat()).unwrap();
            prop_assert_eq!(file.read::<i16>(), Err(NoBricks::Broken));
        }
    }
}

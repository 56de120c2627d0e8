//! Small volume files made by hand, in every format and encoding, apart from the writers under test.

use flate2::{
    Compression,
    write::{GzEncoder, ZlibEncoder},
};
use isokit_io::{Endian, RawLayout, VolumeOptions};
use isokit_volume::Dtype;
use std::{
    fs,
    io::Write,
    path::{Path, PathBuf},
};

/// A file, those that it refers to, and what the caller must say to have it read.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) what: &'static str,
    /// The file to open comes first.
    pub(crate) files: Vec<(String, Vec<u8>)>,
    pub(crate) options: VolumeOptions,
}

/// Samples as bytes of this machine, and what they are.
#[derive(Clone, Debug)]
pub(crate) struct Array {
    pub(crate) dims: [u64; 3],
    pub(crate) dtype: Dtype,
    pub(crate) bytes: Vec<u8>,
}

impl Array {
    /// The samples in the byte order of a file.
    pub(crate) fn in_order(&self, endian: Endian) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        if endian != if cfg!(target_endian = "big") { Endian::Big } else { Endian::Little } {
            bytes.chunks_mut(self.dtype.bytes()).for_each(<[u8]>::reverse);
        }
        bytes
    }

    /// The array with its axes in the opposite order: z fastest.
    pub(crate) fn reversed_axes(&self) -> Self {
        let [nx, ny, nz] = self.dims;
        let mut bytes = vec![];
        for x in 0..nx {
            for y in 0..ny {
                for z in 0..nz {
                    let (n, size) = ((x + nx * (y + ny * z)) as usize, self.dtype.bytes());
                    bytes.extend(&self.bytes[n * size..(n + 1) * size]);
                }
            }
        }
        Self { dims: [nz, ny, nx], bytes, ..*self }
    }
}

impl Case {
    /// Writes the files and says which one to open.
    pub(crate) fn lay_out(&self, folder: &Path) -> PathBuf {
        for (name, bytes) in &self.files {
            fs::write(folder.join(name), bytes).unwrap();
        }
        folder.join(&self.files[0].0)
    }
}

pub(crate) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(vec![], Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub(crate) fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(vec![], Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

pub(crate) fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = bzip2::write::BzEncoder::new(vec![], bzip2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// One after the other.
pub(crate) fn joined(parts: &[&[u8]]) -> Vec<u8> {
    parts.concat()
}

/// A NIfTI header of either version: identity sform, millimetres.
pub(crate) fn nifti_header(array: &Array, endian: Endian, version: u8, magic: &[u8]) -> Vec<u8> {
    let two = version == 2;
    let mut header = vec![0; if two { 540 } else { 348 }];
    let mut put = |at: usize, bytes: &[u8]| {
        let bytes: Vec<u8> = match endian {
            Endian::Little => bytes.to_vec(),
            Endian::Big => bytes.iter().rev().copied().collect(),
        };
        header[at..at + bytes.len()].copy_from_slice(&bytes);
    };
    let code = match array.dtype {
        Dtype::U8 => 2_i16,
        Dtype::I16 => 4,
        Dtype::I32 => 8,
        Dtype::F32 => 16,
        Dtype::F64 => 64,
        Dtype::I8 => 256,
        Dtype::U16 => 512,
        Dtype::U32 => 768,
    };
    let single = magic.starts_with(b"n+");
    put(0, &(if two { 540_i32 } else { 348 }).to_le_bytes());
    put(if two { 12 } else { 70 }, &code.to_le_bytes());
    let dims = [3, array.dims[0], array.dims[1], array.dims[2], 1, 1, 1, 1];
    for (n, size) in dims.into_iter().enumerate() {
        match two {
            true => put(16 + 8 * n, &size.to_le_bytes()),
            false => put(40 + 2 * n, &(size as u16).to_le_bytes()),
        }
        match two {
            true => put(104 + 8 * n, &1_f64.to_le_bytes()),
            false => put(76 + 4 * n, &1_f32.to_le_bytes()),
        }
    }
    let offset = if single { if two { 544 } else { 352 } } else { 0 };
    match two {
        true => put(168, &i64::from(offset).to_le_bytes()),
        false => put(108, &(offset as f32).to_le_bytes()),
    }
    match two {
        true => put(348, &1_i32.to_le_bytes()),
        false => put(254, &1_i16.to_le_bytes()),
    }
    for axis in 0..3 {
        match two {
            true => put(400 + 40 * axis, &1_f64.to_le_bytes()),
            false => put(280 + 20 * axis, &1_f32.to_le_bytes()),
        }
    }
    match two {
        true => put(500, &2_i32.to_le_bytes()),
        false => put(123, &[2]),
    }
    let at = if two { 4 } else { 344 };
    header[at..at + magic.len()].copy_from_slice(magic);
    header
}

/// The array in every format, encoding and way of splitting files, in one byte order.
pub(crate) fn cases(array: &Array, endian: Endian) -> Vec<Case> {
    let mut cases = vec![];
    let mut add = |what, files: &[(&str, Vec<u8>)]| {
        let files = files.iter().map(|(name, bytes)| (name.to_string(), bytes.clone())).collect();
        cases.push(Case { what, files, options: VolumeOptions::default() });
    };
    let samples = array.in_order(endian);
    let [x, y, z] = array.dims;

    let nifti = |version: u8, magic: &[u8]| nifti_header(array, endian, version, magic);
    let one = joined(&[&nifti(1, b"n+1\0"), &[0; 4], &samples]);
    add("NIfTI-1", &[("a.nii", one.clone())]);
    add("NIfTI-1 in gzip", &[("a.nii.gz", gzip(&one))]);
    let two = joined(&[&nifti(2, b"n+2\0\r\n\x1a\n"), &[0; 4], &samples]);
    add("NIfTI-2 in bzip2", &[("a.nii.bz2", bzip2(&two))]);
    let pair = nifti(1, b"ni1\0");
    add("a NIfTI pair", &[("a.hdr", pair.clone()), ("a.img", samples.clone())]);
    add("a packed image", &[("a.img.gz", gzip(&samples)), ("a.hdr", pair)]);

    let order = if endian == Endian::Little { "little" } else { "big" };
    let kind = match array.dtype {
        Dtype::U8 => "uchar",
        Dtype::I8 => "signed char",
        Dtype::U16 => "uint16_t",
        Dtype::I16 => "short",
        Dtype::U32 => "unsigned int",
        Dtype::I32 => "int",
        Dtype::F32 => "float",
        Dtype::F64 => "double",
    };
    let nrrd = |more: &str| {
        format!(
            "NRRD0005\n# by hand\ntype: {kind}\ndimension: 3\nsizes: {x} {y} {z}\n\
             spacings: 1 2 3\nendian: {order}\nkey:=value\n{more}"
        )
        .into_bytes()
    };
    let with = |more: &str, data: &[u8]| joined(&[&nrrd(more), data]);
    add("NRRD", &[("a.nrrd", with("encoding: raw\n\n", &samples))]);
    add("NRRD, gzip", &[("a.nrrd", with("encoding: gzip\n\n", &gzip(&samples)))]);
    add("NRRD, bzip2", &[("a.nrrd", with("encoding: bz2\n\n", &bzip2(&samples)))]);
    let skipped = with("encoding: raw\nline skip: 1\nbyte skip: 2\n\n", b"a line\nxx");
    add("NRRD that skips", &[("a.nrrd", joined(&[&skipped, &samples]))]);
    let detached = |more: &str| nrrd(&format!("encoding: raw\n{more}"));
    let last = detached("byte skip: -1\ndatafile: a.raw\n");
    let headed = joined(&[b"some header", &samples]);
    add("NRRD, last bytes", &[("a.nhdr", last), ("a.raw", headed.clone())]);
    add("NRRD, packed file", &[("a.nhdr", detached("data file: a.gz")), ("a.gz", gzip(&samples))]);
    let slices: Vec<Vec<u8>> =
        samples.chunks(samples.len() / z as usize).map(<[u8]>::to_vec).collect();
    let named = |header: (&str, Vec<u8>), slices: &[Vec<u8>]| {
        let mut files = vec![(header.0.to_owned(), header.1)];
        let names = (1..).map(|n| format!("s{n:02}.raw"));
        files.extend(names.zip(slices.iter().cloned()));
        files
    };
    let borrowed = |files: Vec<(String, Vec<u8>)>| -> Vec<(&'static str, Vec<u8>)> {
        files.into_iter().map(|(name, bytes)| (&*name.leak(), bytes)).collect()
    };
    let list: String = (1..=z).map(|n| format!("s{n:02}.raw\r\n")).collect();
    let header = detached(&format!("data file: LIST\n{list}"));
    add("NRRD, a list", &borrowed(named(("a.nhdr", header), &slices)));
    let header = detached(&format!("data file: s%02d.raw 1 {z} 1\n"));
    add("NRRD, a series", &borrowed(named(("a.nhdr", header), &slices)));

    let kind = match array.dtype {
        Dtype::U8 => "MET_UCHAR",
        Dtype::I8 => "MET_CHAR",
        Dtype::U16 => "MET_USHORT",
        Dtype::I16 => "MET_SHORT",
        Dtype::U32 => "MET_UINT",
        Dtype::I32 => "MET_LONG",
        Dtype::F32 => "MET_FLOAT",
        Dtype::F64 => "MET_DOUBLE",
    };
    let big = if endian == Endian::Big { "True" } else { "False" };
    let meta = |more: &str| {
        format!(
            "ObjectType = Image\nNDims = 3\nDimSize = {x} {y} {z}\nElementType = {kind}\n\
             ElementSpacing = 1 2 3\nElementByteOrderMSB = {big}\n{more}"
        )
        .into_bytes()
    };
    let local = "ElementDataFile = LOCAL\n";
    add("MetaImage", &[("a.mha", joined(&[&meta(local), &samples]))]);
    let packed = meta(&format!("CompressedData = True\n{local}"));
    add("MetaImage, zlib", &[("a.mha", joined(&[&packed, &zlib(&samples)]))]);
    let header = meta("HeaderSize = -1\nElementDataFile = a.raw\n");
    add("MetaImage, last bytes", &[("a.mhd", header), ("a.raw", headed)]);
    let packed: Vec<Vec<u8>> = slices.iter().map(|slice| zlib(slice)).collect();
    let header = meta(&format!("CompressedData = True\nElementDataFile = LIST\n{list}"));
    add("MetaImage, packed slices", &borrowed(named(("a.mhd", header), &packed)));
    let header = meta(&format!("ElementDataFile = s%02d.raw 1 {z} 1\n"));
    add("MetaImage, a series", &borrowed(named(("a.mhd", header), &slices)));

    let mark = match (array.dtype.bytes(), endian) {
        (1, _) => '|',
        (_, Endian::Little) => '<',
        (_, Endian::Big) => '>',
    };
    let kind = match array.dtype {
        Dtype::F32 | Dtype::F64 => 'f',
        Dtype::U8 | Dtype::U16 | Dtype::U32 => 'u',
        Dtype::I8 | Dtype::I16 | Dtype::I32 => 'i',
    };
    let descr = format!("{mark}{kind}{}", array.dtype.bytes());
    let npy = |order: &str, version: u8, samples: &[u8]| {
        let text = format!(
            "{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({z}, {y}, {x}), }}\n"
        );
        let length = (text.len() as u32).to_le_bytes();
        let length = if version == 1 { &length[..2] } else { &length[..] };
        joined(&[b"\x93NUMPY", &[version, 0], length, text.as_bytes(), samples])
    };
    add("NPY", &[("a.npy", npy("False", 1, &samples))]);
    add("NPY in bzip2", &[("a.npy.bz2", bzip2(&npy("False", 3, &samples)))]);
    let turned = array.reversed_axes().in_order(endian);
    add("NPY, Fortran order", &[("a.npy", npy("True", 2, &turned))]);

    let (dims, dtype) = (array.dims, array.dtype);
    let mut options = VolumeOptions::default();
    options.raw = Some(RawLayout { dims, dtype, endian, skip: 11 });
    let headed = joined(&[b"some header", &samples]);
    for (what, name, bytes) in
        [("raw", "a.raw", headed.clone()), ("raw in gzip", "a.bin", gzip(&headed))]
    {
        let files = vec![(name.to_owned(), bytes)];
        cases.push(Case { what, files, options: options.clone() });
    }
    cases
}

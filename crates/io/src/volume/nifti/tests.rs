//! Headers of this format, and what they mean.

use super::header::{Layout, ONE, TWO};
use crate::{ReadError, VolumeFile, VolumeOptions, open_volume};
use isokit_geom::{Space, Unit};
use isokit_job::Job;
use isokit_volume::Scaling;
use std::fs;

/// A header of 2 × 3 × 4 bytes: spacings 1, 2, 3 in millimetres, both codes 0, changed at will.
struct Draft {
    bytes: Vec<u8>,
    layout: &'static Layout,
}

impl Draft {
    fn new(layout: &'static Layout) -> Self {
        let mut draft = Self { bytes: vec![0; layout.size + 4 + 24], layout };
        draft.bytes[..4].copy_from_slice(&(layout.size as i32).to_le_bytes());
        let magic: &[u8] = if layout.size == 348 { b"n+1\0" } else { b"n+2\0\r\n\x1a\n" };
        draft.bytes[layout.magic..layout.magic + magic.len()].copy_from_slice(magic);
        draft.sizes(&[3, 2, 3, 4]).reals(layout.pixdim, &[1.0, 1.0, 2.0, 3.0]);
        draft.bytes[layout.datatype] = 2;
        draft.bytes[layout.units] = 2;
        let offset = (layout.size + 4) as i64;
        match layout.size == 348 {
            true => drop(draft.reals(layout.vox_offset, &[offset as f64])),
            false => draft.bytes[168..176].copy_from_slice(&offset.to_le_bytes()),
        }
        draft
    }

    fn sizes(&mut self, sizes: &[i64]) -> &mut Self {
        let width = self.layout.widths[0];
        for (n, size) in sizes.iter().enumerate() {
            let at = self.layout.dim + n * width;
            self.bytes[at..at + width].copy_from_slice(&size.to_le_bytes()[..width]);
        }
        self
    }

    fn reals(&mut self, at: usize, numbers: &[f64]) -> &mut Self {
        for (n, number) in numbers.iter().enumerate() {
            match self.layout.widths[1] {
                4 => self.bytes[at + 4 * n..][..4].copy_from_slice(&(*number as f32).to_le_bytes()),
                _ => self.bytes[at + 8 * n..][..8].copy_from_slice(&number.to_le_bytes()),
            }
        }
        self
    }

    /// `qform_code` and `sform_code`.
    fn codes(&mut self, codes: [u8; 2]) -> &mut Self {
        let [first, second] = [0, 1].map(|n| self.layout.codes + n * self.layout.widths[2]);
        (self.bytes[first], self.bytes[second]) = (codes[0], codes[1]);
        self
    }

    fn try_open(&self, options: &VolumeOptions) -> Result<VolumeFile, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.nii");
        fs::write(&path, &self.bytes).unwrap();
        open_volume(&path, options, &Job::default())
    }

    fn open(&self) -> VolumeFile {
        self.try_open(&VolumeOptions::default()).unwrap()
    }

    #[track_caller]
    fn is_refused(&self, expected: &str) {
        let error = self.try_open(&VolumeOptions::default()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

const SFORM: [f64; 12] = [0.0, -2.0, 0.0, 10.0, 1.0, 0.0, 0.0, 20.0, 0.0, 0.5, 3.0, 30.0];

/// A quarter turn about z, and its origin.
fn quarter_turn() -> [f64; 6] {
    [0.0, 0.0, 0.5_f64.sqrt(), 7.0, 8.0, 9.0]
}

#[test]
fn the_sform_wins_over_the_qform_and_the_qform_over_nothing() {
    for layout in [&ONE, &TWO] {
        let mut draft = Draft::new(layout);
        draft.reals(layout.srow, &SFORM).reals(layout.quatern, &quarter_turn());
        let affine = |draft: &Draft| draft.open().grid().frame.index_to_world;

        let sform = affine(draft.codes([1, 4]));
        assert_eq!(sform.columns(), [[0.0, 1.0, 0.0], [-2.0, 0.0, 0.5], [0.0, 0.0, 3.0]]);
        assert_eq!(sform.origin(), [10.0, 20.0, 30.0]);
        assert_eq!(draft.open().grid().frame.space, Space::Ras);

        let qform = affine(draft.codes([1, 0]));
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near(qform.point([1.0, 1.0, 1.0]), [7.0 - 2.0, 8.0 + 1.0, 9.0 + 3.0]), "{qform:?}");
        assert_eq!(draft.open().grid().frame.space, Space::Ras);

        let neither = affine(draft.codes([0, 0]));
        assert_eq!(neither.point([1.0; 3]), [1.0, 2.0, 3.0]);
        assert_eq!(draft.open().grid().frame.space, Space::Unknown);
    }
}

#[test]
fn qfac_reflects_the_last_axis() {
    let mut draft = Draft::new(&ONE);
    draft.codes([1, 0]).reals(ONE.quatern, &quarter_turn()).reals(ONE.pixdim, &[-1.0]);
    let affine = draft.open().grid().frame.index_to_world;
    assert!((affine.determinant() + 6.0).abs() < 1e-6, "{affine:?}");
}

#[test]
fn a_half_turn_that_was_rounded_up_is_a_half_turn() {
    let mut draft = Draft::new(&ONE);
    draft.codes([1, 0]).reals(ONE.quatern, &[0.0, 1.0 + 1e-7, 0.0, 0.0, 0.0, 0.0]);
    let affine = draft.open().grid().frame.index_to_world;
    assert_eq!(
        affine.columns().map(|column| column.map(f64::round)),
        [[-1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, -3.0]]
    );
    assert!((affine.determinant() - 6.0).abs() < 1e-12);
}

#[test]
fn a_bogus_map_is_refused_unless_the_caller_gives_a_spacing() {
    let bogus = [
        ([f64::NAN; 12], "row 0, column 0 is NaN"),
        ([0.0; 12], "axis 0 has length 0"),
        ([1.0; 12], "the three axes lie in one plane"),
    ];
    for (rows, found) in bogus {
        let mut draft = Draft::new(&ONE);
        draft.codes([0, 1]).reals(ONE.srow, &rows);
        draft.is_refused("a.nii: NIfTI, byte 280: expected a usable map from samples");
        draft.is_refused("(--spacing overrides it)");
        draft.is_refused(found);
        let options = VolumeOptions { spacing: Some([1.0, 1.0, 2.0]), ..Default::default() };
        let file = draft.try_open(&options).unwrap();
        assert_eq!(file.grid().frame.index_to_world.spacing(), [1.0, 1.0, 2.0]);
        assert_eq!(file.notes().len(), 1, "{:?}", file.notes());
    }
    let mut draft = Draft::new(&ONE);
    draft.reals(ONE.pixdim, &[1.0, 1.0, 0.0, 1.0]).is_refused("byte 76: expected a usable map");
}

#[test]
fn axes_that_are_missing_have_size_1_and_need_no_spacing() {
    let mut draft = Draft::new(&ONE);
    draft.sizes(&[2, 6, 4, -9]).reals(ONE.pixdim, &[1.0, 1.0, 2.0, 0.0]);
    assert_eq!(draft.open().grid().dims(), [6, 4, 1]);
    draft.codes([0, 1]).reals(ONE.srow, &[1.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    assert_eq!(draft.open().grid().frame.index_to_world.spacing(), [1.0, 2.0, 1.0]);
}

#[test]
fn sizes_are_checked_one_by_one() {
    for (sizes, expected) in [
        (&[0][..], "byte 40: expected 1 to 7 axes, found 0"),
        (&[8], "byte 40: expected 1 to 7 axes, found 8"),
        (&[3, 2, 0, 4], "byte 44: expected a size above 0, found 0"),
        (&[3, 2, 3, -4], "byte 46: expected a size above 0, found -4"),
        (&[7, 9, 9, 9, 32767, 32767, 32767, 32767], "volumes of"),
    ] {
        Draft::new(&ONE).sizes(sizes).is_refused(expected);
    }
    Draft::new(&TWO).sizes(&[3, i64::MAX, i64::MAX, 1]).is_refused("no lattice");
}

#[test]
fn the_fourth_axis_and_those_after_it_count_volumes() {
    let mut draft = Draft::new(&ONE);
    draft.sizes(&[5, 2, 2, 1, 2, 3]);
    let file = draft.open();
    assert_eq!(file.grid().dims(), [2, 2, 1]);
    assert!(file.notes()[0].starts_with("the file holds 6 volumes; the first is read"));
    let asked = |index| VolumeOptions { volume_index: Some(index), ..Default::default() };
    draft.bytes[352..].copy_from_slice(&std::array::from_fn::<u8, 24, _>(|n| n as u8));
    let file = draft.try_open(&asked(5)).unwrap();
    assert!(file.notes().is_empty());
    let error = draft.try_open(&asked(6)).unwrap_err().to_string();
    assert!(error.contains("volume 6 of 6 was asked for; they count from 0"), "{error}");
}

#[test]
fn a_scaling_needs_a_slope() {
    let of = |slope: f64, intercept: f64| {
        Draft::new(&TWO).reals(TWO.scl, &[slope, intercept]).open().scaling()
    };
    assert_eq!(of(2.5, -7.0), Scaling::new(2.5, -7.0).unwrap());
    for slope in [0.0, f64::NAN, f64::INFINITY] {
        assert_eq!(of(slope, 5.0), Scaling::IDENTITY, "{slope}");
    }
    assert_eq!(of(2.0, f64::NAN), Scaling::new(2.0, 0.0).unwrap());
}

#[test]
fn units_are_told_by_the_low_bits_and_assumed_where_there_are_none() {
    let of = |code: u8| {
        let mut draft = Draft::new(&ONE);
        draft.bytes[ONE.units] = code;
        let file = draft.open();
        (file.grid().frame.unit, file.notes().len())
    };
    assert_eq!(of(1 | 8), (Unit::Metre, 0));
    assert_eq!(of(2 | 16), (Unit::Millimetre, 0));
    assert_eq!(of(3), (Unit::Micrometre, 0));
    assert_eq!(of(0), (Unit::Millimetre, 1));
    assert_eq!(of(7), (Unit::Millimetre, 1));
}

#[test]
fn samples_begin_at_vox_offset_after_any_extension() {
    let mut draft = Draft::new(&ONE);
    draft.bytes.splice(352..352, [9; 16]);
    draft.reals(ONE.vox_offset, &[368.0]);
    assert!(draft.open().notes().is_empty());
    draft.reals(ONE.vox_offset, &[0.0]);
    assert!(draft.open().notes()[0].starts_with("vox_offset is 0; 352 is assumed"));
    for offset in [348.0, 352.5, -352.0, 1e30, f64::NAN] {
        draft.reals(ONE.vox_offset, &[offset]);
        draft.is_refused("byte 108: expected vox_offset of at least 352");
    }
    draft.reals(ONE.vox_offset, &[1e6]).is_refused("24 bytes of samples, file holds 0");
}

#[test]
fn types_that_cannot_be_read_are_named() {
    for (code, name) in
        [(32, "complex64"), (128, "RGB24"), (1024, "int64"), (1536, "float128"), (2304, "RGBA32")]
    {
        let mut draft = Draft::new(&ONE);
        draft.bytes[ONE.datatype..ONE.datatype + 2].copy_from_slice(&i16::to_le_bytes(code));
        draft.is_refused(&format!("byte 70: sample type {name}"));
    }
    let mut draft = Draft::new(&ONE);
    draft.bytes[ONE.datatype] = 3;
    draft.is_refused("byte 70: expected a code of a data type, found 3");
}

#[test]
fn analyze_is_read_without_what_nifti_added() {
    let mut draft = Draft::new(&ONE);
    draft.codes([9, 9]).reals(ONE.scl, &[5.0, 5.0]).reals(ONE.vox_offset, &[0.0]);
    draft.bytes[ONE.magic..ONE.magic + 4].copy_from_slice(&[0; 4]);
    draft.is_refused("byte 344: expected \"n+1\" or \"ni1\"");
    let folder = tempfile::tempdir().unwrap();
    let (header, image) = (folder.path().join("A.HDR"), folder.path().join("A.IMG"));
    fs::write(&header, &draft.bytes[..348]).unwrap();
    fs::write(&image, [0; 24]).unwrap();
    for path in [header, image] {
        let file = open_volume(&path, &VolumeOptions::default(), &Job::default()).unwrap();
        assert_eq!(file.grid().frame.space, Space::Unknown);
        assert_eq!(file.scaling(), Scaling::IDENTITY);
        assert!(file.notes()[0].starts_with("Analyze 7.5"));
    }
}

//! Parts of scans in files, with an index beside them.

use super::ScanFile;
use crate::pipeline::{Index, Region, Scan, SurfaceOptions, TargetSpace};
use isokit_io::{Endian, RawLayout, VolumeOptions};
use isokit_job::Job;
use isokit_volume::Dtype;
use std::{fs, path::Path};
use tempfile::TempDir;

const DIMS: [usize; 3] = [150, 60, 70];

/// Distances from a ball that is a small part of all samples, in steps, so that some are ties.
fn write(path: &Path) {
    let sample = |n: usize| {
        let ijk = [n % DIMS[0], n / DIMS[0] % DIMS[1], n / DIMS[0] / DIMS[1]];
        let away = ijk.iter().zip([100.0, 30.0, 40.0]).map(|(&i, c)| (i as f64 - c).powi(2));
        (100.0 - 4.0 * away.sum::<f64>().sqrt()).max(0.0) as u8
    };
    fs::write(path, (0..DIMS.iter().product()).map(sample).collect::<Vec<u8>>()).unwrap();
}

fn open(path: &Path, region: &Region) -> ScanFile {
    let mut options = VolumeOptions::default();
    let dims = DIMS.map(|n| n as u64);
    options.raw = Some(RawLayout { dims, dtype: Dtype::U8, endian: Endian::Little, skip: 0 });
    ScanFile::open(path, &options, TargetSpace::Source, region, &Job::default()).unwrap()
}

#[test]
fn of_a_part_no_more_is_read_where_an_index_of_the_volume_is_kept() {
    let (folder, job) = (TempDir::new().unwrap(), Job::default());
    let path = folder.path().join("ball.raw");
    write(&path);
    let mut whole = open(&path, &Region::Whole).read(&job).unwrap();
    let parts = ["10:,3:,:60", "64:150,:,17:", "90:149,21:,5:44", "0:70,:,:"];
    let parts = parts.map(|part| Region::parse_samples(part).unwrap());
    // Before there is one, that of a part is of the part, and not kept.
    let file = open(&path, &parts[0]);
    assert!(!file.has_index());
    let mut scan = file.read(&job).unwrap();
    assert!(matches!(scan.index(&job).unwrap(), Index::NotKept(Some(_))));
    assert!(!path.with_extension("raw.bricks").exists());
    assert!(matches!(whole.index(&job).unwrap(), Index::Made { .. }));
    let options = SurfaceOptions::default();
    for part in &parts {
        let file = open(&path, part);
        assert!(file.has_index());
        let mut scan = file.read(&job).unwrap();
        let plain = scan.clone();
        assert!(matches!(scan.index(&job).unwrap(), Index::Read(_)), "{part:?}");
        let held = scan.part().map(|range| range.len() as u64);
        assert_eq!(scan.volume().grid().dims(), held, "{part:?}");
        assert_eq!(scan.statistics(&job).unwrap(), plain.statistics(&job).unwrap(), "{part:?}");
        let cropped = whole.clone().cropped(part).unwrap();
        let mesh = |scan: &Scan, iso: f64| scan.mesh(iso, &options, &job).unwrap();
        for iso in [20.0, 60.0, 99.5] {
            assert_eq!(mesh(&scan, iso), mesh(&plain, iso), "{iso} of {part:?}");
            assert_eq!(mesh(&cropped, iso), mesh(&plain, iso), "{iso} of {part:?}");
        }
    }
    // Of the ball alone, ends of the bricks around are farther off than those of the samples.
    let most = |part: &str| {
        let mut scan = open(&path, &Region::parse_samples(part).unwrap()).read(&job).unwrap();
        scan.index(&job).unwrap();
        scan.statistics(&job).unwrap().range.unwrap()[1]
    };
    assert_eq!((most("100:,30:,40:"), most("101:,30:,40:")), (100.0, 96.0));
}

//! Parts as they are typed, and the samples that they are.

use super::{Region, RegionError, Span};
use isokit_geom::{Affine, Frame};
use isokit_volume::Grid;

fn grid(columns: [[f64; 3]; 3], origin: [f64; 3]) -> Grid {
    let index_to_world = Affine::new(columns, origin).unwrap();
    Grid::new([10, 20, 30], Frame { index_to_world, ..Frame::default() }).unwrap()
}

/// Samples 2 apart along x, 1 along y, 0.5 along z, the first at (−10, 0, 100).
fn plain() -> Grid {
    grid([[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.5]], [-10.0, 0.0, 100.0])
}

#[test]
fn ends_may_be_left_open() {
    let region = Region::parse_samples("2:,:7,:").unwrap();
    assert_eq!(region.samples(&plain()), Ok([2..10, 0..7, 0..30]));
    assert_eq!(Region::Whole.samples(&plain()), Ok([0..10, 0..20, 0..30]));
}

#[test]
fn a_part_that_leads_out_is_refused_with_the_size() {
    let refused = |text: &str| {
        Region::parse_samples(text).unwrap().samples(&plain()).unwrap_err().to_string()
    };
    let size = "which has 20: a part needs 0 <= from < to <= 20";
    assert_eq!(refused(":,3:21,:"), format!("samples 3:21 of the y axis, {size}"));
    assert_eq!(refused(":,3:3,:"), format!("samples 3:3 of the y axis, {size}"));
    assert_eq!(refused(":,25:,:"), format!("samples 25:20 of the y axis, {size}"));
}

#[test]
fn a_world_box_takes_the_samples_around_it() {
    let region = Region::parse_world("-6.5:-2,0.1:2.9,:").unwrap();
    assert_eq!(region.samples(&plain()), Ok([1..5, 0..4, 0..30]));
    // Ends on samples take these and no more, however they are rounded.
    let region = Region::parse_world("-8:-2,1:3,100.5:101").unwrap();
    assert_eq!(region.samples(&plain()), Ok([1..5, 1..4, 1..3]));
}

#[test]
fn a_world_box_is_cut_to_the_volume_and_must_meet_it() {
    let region = Region::parse_world("-1e9:-8,:,:1e9").unwrap();
    assert_eq!(region.samples(&plain()), Ok([0..2, 0..20, 0..30]));
    let beside = Region::parse_world("50:60,:,:").unwrap().samples(&plain()).unwrap_err();
    assert!(matches!(beside, RegionError::World { .. }));
    let says = "the box lies outside of the volume, which reaches from [-10.0, 0.0, 100.0] to";
    assert!(beside.to_string().starts_with(says), "{beside}");
    let turned = Region::parse_world("3:-3,:,:").unwrap().samples(&plain());
    assert!(matches!(turned, Err(RegionError::World { .. })));
}

#[test]
fn a_reflected_axis_is_followed() {
    let reflected = grid([[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]], [0.0; 3]);
    let region = Region::parse_world("-4:-2,5:6,:").unwrap();
    assert_eq!(region.samples(&reflected), Ok([2..5, 0..20, 5..7]));
}

#[test]
fn a_refusal_names_what_was_expected_and_found() {
    for text in
        ["", "1:2", "1:2,3:4", "1:2,3:4,5:6,7:8", "a:b,:,:", "1,2,3", "-1:2,:,:", "0.5:,:,:"]
    {
        let error = Region::parse_samples(text).unwrap_err().to_string();
        let expected = "expected three ranges x0:x1,y0:y1,z0:z1 of whole numbers";
        assert_eq!(error, format!("{expected} (an end may be left out), found {text:?}"));
    }
    assert!(Region::parse_world("nan:,:,:").is_err());
    let spans = [Span { from: Some(-1.5), to: Some(2.0) }, Span::default(), Span::default()];
    assert_eq!(Region::parse_world("-1.5:2,:,:"), Ok(Region::World(spans)));
}

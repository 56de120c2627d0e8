//! Samples against values, one by one.

use super::{FieldSamples, FieldSlices, sample};
use crate::{Sampled, ScalarField, kit::Waves};
use isokit_geom::{Frame, Unit};
use isokit_job::{Job, Limits, Stopped, Threads};
use isokit_volume::{SampleSource, SlabSource};
use std::num::NonZero;

fn job(threads: usize) -> Job {
    Job { threads: Threads::new(NonZero::new(threads).unwrap()).unwrap(), ..Job::default() }
}

#[test]
fn a_sample_is_the_value_at_its_point_whoever_asks() {
    for dims in [[1, 1, 1], [70, 9, 17], [5, 33, 2]] {
        let field = Waves::new(dims);
        let frame = Frame { unit: Unit::Metre, ..Frame::default() };
        let wide = sample::<f64>(FieldSamples::new(&field, frame).unwrap(), &job(1)).unwrap();
        assert_eq!(wide.grid().frame, Frame { index_to_world: field.index_to_world(), ..frame });
        for threads in [1, 2, 7] {
            let samples = FieldSamples::<f32>::new(&field, frame).unwrap();
            let narrow = sample(samples, &job(threads)).unwrap();
            let [nx, ny, _] = dims;
            for (n, (wide, narrow)) in wide.samples().iter().zip(narrow.samples()).enumerate() {
                let value = field.value([n % nx, n / nx % ny, n / nx / ny].map(|i| i as f64));
                assert_eq!(
                    (wide.to_bits(), narrow.to_bits()),
                    (value.to_bits(), (value as f32).to_bits())
                );
            }
        }
    }
}

#[test]
fn slices_may_be_asked_for_a_few_at_a_time() {
    let (field, job) = (Waves::new([20, 11, 13]), job(2));
    let all = sample::<f32>(FieldSamples::new(&field, Frame::default()).unwrap(), &job).unwrap();
    let mut slices = FieldSlices::new(FieldSamples::new(&field, Frame::default()).unwrap(), &job);
    let mut found = vec![0.0; all.samples().len()];
    let (few, rest) = found.split_at_mut(220 * 3);
    slices.fill(few).unwrap();
    slices.fill(rest).unwrap();
    assert_eq!(found, all.samples());
}

#[test]
fn what_was_sampled_is_sampled_again() {
    let (field, job) = (Waves::new([9, 8, 7]), Job::default());
    let all = sample::<f64>(FieldSamples::new(&field, Frame::default()).unwrap(), &job).unwrap();
    let seen = Sampled::new(all.view());
    let again = sample::<f64>(FieldSamples::new(&seen, Frame::default()).unwrap(), &job).unwrap();
    assert_eq!(again, all);
}

#[test]
fn extents_hold_the_samples_and_are_not_known_where_bounds_are_not() {
    let field = Waves::new([30, 20, 10]);
    let samples = FieldSamples::<f32>::new(&field, Frame::default()).unwrap();
    let mut found = vec![0.0; 8 * 5 * 3];
    for x in 0..22 {
        let points = [x..x + 8, 5..10, 7..10];
        samples.fill(&points, &mut found);
        let extent = samples.extent(&points).unwrap();
        assert!(found.iter().all(|f| (extent.least..=extent.greatest).contains(f)));
    }
    let view = isokit_volume::Volume::new(samples.grid(), vec![f32::NAN; 6000]).unwrap();
    let unknown = Sampled::new(view.view());
    let unknown = FieldSamples::<f64>::new(&unknown, Frame::default()).unwrap();
    assert!(unknown.extent(&[0..8, 0..8, 0..8]).is_none());
}

#[test]
fn a_job_may_forbid_or_stop_it() {
    let field = Waves::new([10, 10, 10]);
    let samples = || FieldSamples::<f32>::new(&field, Frame::default()).unwrap();
    let limited = Job { limits: Limits { bytes: 3999 }, ..Job::default() };
    assert!(matches!(sample(samples(), &limited), Err(Stopped::OverLimit(_))));
    let cancelled = Job::default();
    cancelled.cancel.cancel();
    assert!(matches!(sample(samples(), &cancelled), Err(Stopped::Cancelled(_))));
    assert!(FieldSamples::<f32>::new(&Waves::new([3, 0, 3]), Frame::default()).is_err());
}

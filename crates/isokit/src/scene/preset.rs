//! Transfer functions to begin with.

use super::SceneError;
use crate::pipeline::{IsoChoice, PipelineError, Scan};
use isokit_job::Job;
use isokit_mesh::Rgba;
use isokit_render::{ControlPoint, TransferFunction};
use isokit_volume::Histogram;

/// A transfer function by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// What is above Otsu's threshold, denser and lighter the higher it is: for MR, microscopes, density maps and
    /// simulations.
    #[default]
    Auto,
    /// Bone in Hounsfield units, the more compact the whiter.
    CtBone,
    /// Skin in Hounsfield units, translucent, with bone behind it.
    CtSkin,
    /// Tissue of a magnetic resonance image, whose values have no unit: above Otsu's threshold, by how many of the samples
    /// there are darker; dark ones are a veil.
    Mr,
    /// The peaks of a density map, whose values have no unit, by how many standard deviations they are above the mean: from
    /// 2 on, or less where no value is 6 above it.
    Density,
}

impl Preset {
    /// The function, if it is the same for all scans: then no sample is looked at.
    pub fn known(self) -> Option<TransferFunction> {
        TransferFunction::new(self.fixed()).ok()
    }

    /// The points of a function that is the same for all scans; of others none.
    fn fixed(self) -> Vec<ControlPoint> {
        match self {
            Self::CtBone => vec![
                point(150.0, [0xc8, 0x90, 0x60, 0]),
                point(300.0, [0xe8, 0xdc, 0xc0, 90]),
                point(1200.0, [0xff, 0xfa, 0xf0, 230]),
            ],
            Self::CtSkin => vec![
                point(-600.0, [0xd8, 0xa5, 0x80, 0]),
                point(-300.0, [0xd8, 0xa5, 0x80, 40]),
                point(-100.0, [0xc8, 0x80, 0x60, 4]),
                point(150.0, [0xc8, 0x80, 0x60, 2]),
                point(350.0, [0xe8, 0xdc, 0xc0, 120]),
                point(1200.0, [0xff, 0xfa, 0xf0, 230]),
            ],
            Self::Auto | Self::Mr | Self::Density => vec![],
        }
    }

    /// The function for a scan.
    ///
    /// # Errors
    ///
    /// If the scan's values give no threshold and one is needed, or if the job is cancelled.
    pub fn transfer(self, scan: &Scan, job: &Job) -> Result<TransferFunction, SceneError> {
        let points = match self {
            Self::CtBone | Self::CtSkin => self.fixed(),
            Self::Auto => {
                let low = scan.iso(IsoChoice::Auto, job)?;
                let high = scan.iso(IsoChoice::Percent(100.0), job)?;
                let at = |share: f64| low * (1.0 - share) + high * share;
                vec![
                    point(low, [0xb0, 0x60, 0x40, 0]),
                    point(at(0.25), [0xd8, 0xa5, 0x70, 24]),
                    point(at(1.0), [0xff, 0xf6, 0xe6, 200]),
                ]
            }
            Self::Mr => {
                let low = scan.iso(IsoChoice::Auto, job)?;
                let histogram = scan.histogram(job)?.ok_or(no_values("it has no finite value"))?;
                let at = |share| quantile(histogram, low, share);
                vec![
                    point(low, [0x90, 0x58, 0x48, 0]),
                    point(at(0.3), [0xa8, 0x78, 0x68, 8]),
                    point(at(0.6), [0xc4, 0xa8, 0x98, 50]),
                    point(at(0.9), [0xec, 0xe0, 0xd4, 160]),
                    point(at(1.0), [0xff, 0xff, 0xff, 220]),
                ]
            }
            Self::Density => {
                let histogram = scan.histogram(job)?.ok_or(no_values("it has no finite value"))?;
                let (mean, deviation) = moments(histogram);
                let sixth = deviation.min((histogram.range[1] - mean) / 6.0);
                if sixth <= 0.0 {
                    return Err(no_values("all samples have one value"));
                }
                let at = |deviations: f64| mean + deviations * sixth;
                vec![
                    point(at(2.0), [0x30, 0x60, 0xa8, 0]),
                    point(at(3.0), [0x58, 0x90, 0xd0, 60]),
                    point(at(6.0), [0xe8, 0xf2, 0xff, 220]),
                ]
            }
        };
        TransferFunction::new(points).map_err(|_| {
            let reason = "its values are too large for a transfer function";
            PipelineError::Iso { choice: IsoChoice::Auto, reason }.into()
        })
    }
}

fn no_values(reason: &'static str) -> SceneError {
    PipelineError::Iso { choice: IsoChoice::Auto, reason }.into()
}

/// Of the values above `low` the one that so large a share of them is no greater than; never below `low`.
fn quantile(histogram: &Histogram, low: f64, share: f64) -> f64 {
    let bins =
        || histogram.counts.iter().enumerate().map(|(n, count)| (histogram.middle(n), *count));
    let above = || bins().filter(|(value, _)| *value > low);
    let all: u64 = above().map(|(_, count)| count).sum();
    let mut wanted = share * all as f64;
    let found = above().find(|(_, count)| {
        wanted -= *count as f64;
        wanted <= 0.0
    });
    found.map_or(histogram.range[1], |(value, _)| value).max(low)
}

/// Mean and standard deviation.
fn moments(histogram: &Histogram) -> (f64, f64) {
    let all = histogram.counts.iter().sum::<u64>() as f64;
    let mean_of = |of: &dyn Fn(f64) -> f64| {
        let bins = histogram.counts.iter().enumerate();
        bins.map(|(n, count)| of(histogram.middle(n)) * *count as f64 / all).sum::<f64>()
    };
    let mean = mean_of(&|value| value);
    (mean, mean_of(&|value| (value - mean).powi(2)).sqrt())
}

fn point(value: f64, rgba: [u8; 4]) -> ControlPoint {
    ControlPoint::new(value, Rgba(rgba))
}

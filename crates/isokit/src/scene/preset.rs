//! Transfer functions to begin with.

use super::SceneError;
use crate::pipeline::{IsoChoice, PipelineError, Scan};
use isokit_job::Job;
use isokit_mesh::Rgba;
use isokit_render::{ControlPoint, TransferFunction};

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
}

impl Preset {
    /// The function for a scan.
    ///
    /// # Errors
    ///
    /// If the scan's values give no threshold and one is needed, or if the job is cancelled.
    pub fn transfer(self, scan: &Scan, job: &Job) -> Result<TransferFunction, SceneError> {
        let points = match self {
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
        };
        TransferFunction::new(points).map_err(|_| {
            let reason = "its values are too large for a transfer function";
            PipelineError::Iso { choice: IsoChoice::Auto, reason }.into()
        })
    }
}

fn point(value: f64, rgba: [u8; 4]) -> ControlPoint {
    ControlPoint::new(value, Rgba(rgba))
}

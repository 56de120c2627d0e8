//! What decides how a place looks.

use super::{ControlPoint, Mixture, SlopeFunction, TransferFunction, slopes::extinction};

/// How light is given off and hidden (Max 1995, "Optical models for direct volume rendering").
#[derive(Clone, Debug, PartialEq)]
pub enum OpticalModel {
    /// A place looks like its value.
    Values(TransferFunction),
    /// It looks like its value and the slope there.
    Slopes(SlopeFunction),
    /// It is made of materials, and their surfaces are seen.
    Mixture(Mixture),
}

impl OpticalModel {
    /// What a value looks like on a slice, where there are no slopes and no surfaces.
    pub fn at(&self, value: f64) -> ControlPoint {
        match self {
            Self::Values(function) => function.at(value),
            Self::Slopes(slopes) => slopes.steepest().at(value),
            Self::Mixture(mixture) => mixture.substance().at(value),
        }
    }

    /// Whether a value from `least` to `greatest` can be seen.
    pub fn shows_any(&self, range: [f64; 2]) -> bool {
        match self {
            Self::Values(function) => function.shows_any(range),
            Self::Slopes(slopes) => slopes.rows().any(|(_, function)| function.shows_any(range)),
            Self::Mixture(mixture) => mixture.shows_any(range),
        }
    }

    /// What hides light in a reference length `unit` of the world, at a value where values are so steep: it adds up along
    /// a ray. Finite.
    pub(crate) fn extinction(&self, [value, slope]: [f64; 2], unit: f64) -> f64 {
        match self {
            Self::Values(function) => extinction(function.at(value).opacity),
            Self::Slopes(slopes) => extinction(slopes.at(value, slope).opacity),
            Self::Mixture(mixture) => {
                let of_surface = mixture.surface_opacity(mixture.change(value), slope, unit);
                extinction(mixture.substance().at(value).opacity) + extinction(of_surface)
            }
        }
    }

    /// Whether slopes change what is seen.
    pub(crate) fn has_slopes(&self) -> bool {
        !matches!(self, Self::Values(_))
    }
}

impl From<TransferFunction> for OpticalModel {
    fn from(function: TransferFunction) -> Self {
        Self::Values(function)
    }
}

impl From<SlopeFunction> for OpticalModel {
    fn from(slopes: SlopeFunction) -> Self {
        Self::Slopes(slopes)
    }
}

impl From<Mixture> for OpticalModel {
    fn from(mixture: Mixture) -> Self {
        Self::Mixture(mixture)
    }
}

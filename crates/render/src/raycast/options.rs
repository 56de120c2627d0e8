//! How rays are cast.

use super::Scatter;
use crate::{Kernel, Light, gather::OPAQUE};

/// How rays are cast, and samples are laid on each other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RaycastOptions {
    /// The length of a step, or from sheet to sheet, in units of the smallest spacing. Changes the picture: it is off by
    /// O(step²) where the transfer function is smooth, and what is thinner in the volume than a step may be missed, so
    /// that 1 is long. Default: 0.5.
    pub step: f64,
    /// The length, in world units, over which the opacities of the transfer function are gathered. Changes the
    /// picture. Default: `None`, the smallest spacing.
    pub unit: Option<f64>,
    /// How gradients are lit; `None` leaves colours as they are. Changes the picture. Default:
    /// [`Light::DEFAULT`].
    pub light: Option<Light>,
    /// With so much opacity nothing behind is looked at. Changes the picture, by no more than what is left to 1 in each
    /// part of a colour (times the strength of light that is scattered, where that is more). Above 1, or NaN: all is
    /// looked at. Default: 1 − 2⁻¹³, of which 8 bits show nothing, in the dark either.
    pub opaque: f32,
    /// How values between samples are made of them. Changes the picture. For rays alone; light that is
    /// [scattered](Self::scatter) is linear. Default: [`Kernel::Linear`].
    pub kernel: Kernel,
    /// Whether rays begin with a part of a step, of another length in each pixel: rings that steps leave on smooth things
    /// become a grain. Changes the picture. For rays alone. Default: false.
    pub jitter: bool,
    /// Whether a step shows all values between those at its two ends, as if they changed evenly, so that a peak of a
    /// function of values that lies between them is not missed, and shows no rings, however narrow it is. If one end has no
    /// value, the step shows nothing. Light is that of its middle. Of functions of more than values the middle counts.
    /// Steps that reach over more than 32 samples leap over nothing. Changes the picture. For rays alone. Default:
    /// false.
    pub integrated: bool,
    /// By how much a colour or an opacity may differ from that with steps twice as long, from 0 to 1: a pixel in which it
    /// differs by more is cast again with shorter ones, down to a 64th, as long as the three edges of the volume have no
    /// more than a million of them. Where steps are short enough that the error is of order 2, what is left of it is about
    /// a third of that. Changes the picture. For rays alone. Default: `None`, all steps are of one length.
    pub error: Option<f32>,
    /// Light that particles scatter. Changes the picture. Default: `None`.
    pub scatter: Option<Scatter>,
}

impl RaycastOptions {
    /// The defaults named above.
    pub const DEFAULT: Self = Self {
        step: 0.5,
        unit: None,
        light: Some(Light::DEFAULT),
        opaque: OPAQUE,
        kernel: Kernel::Linear,
        jitter: false,
        integrated: false,
        error: None,
        scatter: None,
    };

    /// The same options with another `step`.
    pub const fn with_step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// The same options with another `unit`.
    pub const fn with_unit(mut self, unit: Option<f64>) -> Self {
        self.unit = unit;
        self
    }

    /// The same options with another `light`.
    pub const fn with_light(mut self, light: Option<Light>) -> Self {
        self.light = light;
        self
    }

    /// The same options with another `opaque`.
    pub const fn with_opaque(mut self, opaque: f32) -> Self {
        self.opaque = opaque;
        self
    }

    /// The same options with another `kernel`.
    pub const fn with_kernel(mut self, kernel: Kernel) -> Self {
        self.kernel = kernel;
        self
    }

    /// The same options with `jitter` or without.
    pub const fn with_jitter(mut self, jitter: bool) -> Self {
        self.jitter = jitter;
        self
    }

    /// The same options with `integrated` or without.
    pub const fn with_integrated(mut self, integrated: bool) -> Self {
        self.integrated = integrated;
        self
    }

    /// The same options with another `error`.
    pub const fn with_error(mut self, error: Option<f32>) -> Self {
        self.error = error;
        self
    }

    /// The same options with another `scatter`.
    pub const fn with_scatter(mut self, scatter: Option<Scatter>) -> Self {
        self.scatter = scatter;
        self
    }
}

impl Default for RaycastOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

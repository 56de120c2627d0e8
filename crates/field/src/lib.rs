//! Smooth functions of space: what lies between the samples of a volume.
//!
//! A [`ScalarField`] tells value, gradient and Hessian at any point of index space. [`Sampled`] is a volume
//! seen that way, through cubics along each axis. A [`SeparableKernel`] says how much of each sample is the value between
//! them, and [`resample`] makes other samples with it; [`Filter`] has those of the field. [`probe`] gives the value at
//! a place.

mod field;
mod filter;
mod interval;
mod kernel;
mod probe;
mod resample;
mod sampled;

pub use field::{Jet, ScalarField, Slope};
pub use filter::{Filter, SeparableKernel, Spline, Window};
pub use interval::Interval;
pub use probe::{Between, probe};
pub use resample::{ResampleError, resample, resample_nearest};
pub use sampled::Sampled;

//! Smooth functions of space: what lies between the samples of a volume.
//!
//! A [`ScalarField`] tells value, gradient and Hessian at any point of index space. [`Sampled`] is a volume
//! seen that way, through cubics along each axis. A [`SeparableKernel`] says how much of each sample is the value between
//! them; [`Filter`] has those of the field. [`Convolved`] is a volume seen through any of them, and [`resample`] makes other
//! samples with it. [`probe`] gives the value at a place. From a field to samples leads [`sample`], or [`FieldSamples`],
//! where only a few are wanted. What every field owes to whoever asks it, the feature `conformance` has as a suite for
//! tests.

mod border;
#[cfg(any(test, feature = "conformance"))]
pub mod conformance;
mod convolved;
mod field;
mod filter;
mod interval;
mod kernel;
#[cfg(test)]
mod kit;
mod probe;
mod resample;
mod sample;
mod sampled;

pub use convolved::Convolved;
pub use field::{Jet, ScalarField, Slope};
pub use filter::{Filter, SeparableKernel, Spline, Window};
pub use interval::Interval;
pub use probe::{Between, probe};
pub use resample::{ResampleError, resample, resample_nearest};
pub use sample::{FieldSamples, FieldSlices, sample};
pub use sampled::Sampled;

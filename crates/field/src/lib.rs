//! Smooth functions of space: what lies between the samples of a volume.
//!
//! A [`ScalarField`] tells value, gradient and Hessian at any point of index space. [`Sampled`] is a volume
//! seen that way, through cubics along each axis.

mod field;
mod kernel;
mod sampled;

pub use field::{Jet, ScalarField, Slope};
pub use sampled::Sampled;

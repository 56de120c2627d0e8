//! What will be done. Nothing is opened before the plan is whole: whatever can be known to fail from the
//! words alone, or from the folders they name, fails here, before gigabytes are read.

mod color;
mod convert;
mod extract;
mod palette;
mod places;
mod render;
mod resample;
mod sample;
mod suggest;
mod target;
mod voxelize;

pub(crate) use color::ColorPlan;
pub(crate) use convert::{ConvertPlan, ConvertTo};
pub(crate) use extract::{ExtractPlan, LevelPlan, Repeat};
pub(crate) use palette::color;
pub(crate) use render::{FadePlan, LookPlan, ModelPlan, RenderPlan, Subject};
pub(crate) use resample::ResamplePlan;
pub(crate) use sample::SamplePlan;
pub(crate) use suggest::SuggestPlan;
pub(crate) use target::{MeshTarget, Stream, TextTarget, is_png};
pub(crate) use voxelize::VoxelizePlan;

#[cfg(test)]
mod tests;

//! The program from words to bytes: every command on small volumes, written here.

mod attribute;
mod check;
mod colors;
mod convert;
mod extract;
mod failures;
mod far;
mod hidden;
mod index;
mod info;
mod kit;
mod looks;
mod paint;
mod part;
mod places;
mod refine;
mod render;
mod report;
mod resample;
mod sample;
mod shapes;
mod slabs;
mod streams;
mod suggest;
mod vectors;
mod voxelize;

//! Which values of a volume matter: what surface there is at each, and which stand out, and why.
//!
//! | question | answer |
//! | --- | --- |
//! | how large is the surface at each value, how much is inside, how steep is it? | [`ContourSpectrum`] |
//! | which values part the samples into classes? | [`classes()`] |
//! | which isovalues are worth a look? | [`suggest()`] |
//!
//! Nothing here makes a surface: all is counted in one pass over the samples.

mod bytes;
mod classes;
mod contour;
mod edges;
mod levels;
mod peaks;
mod suggest;

pub use classes::{Classes, classes};
pub use contour::{Contour, ContourSpectrum};
pub use levels::Levels;
pub use suggest::{Reason, Suggestion, suggest};

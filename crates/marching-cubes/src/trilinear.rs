//! Cells whose signs leave open what the surface connects, decided as the trilinear interpolant does.
//!
//! Half of the 256 codes are *simple*: inside and outside are each connected along the edges of the cell,
//! and the surface is one disc, whatever the values. In a cell with another code it depends on them. The
//! values of a cell are those of its samples less the isovalue, and what they decide is
//!
//! - on each ambiguous face, whether the inside is joined across it (`decide`): two cells see the same
//!   four values, and answer alike;
//! - in the interior, whether two regions that the surface of the cell keeps apart are joined (`decide`):
//!   then a tube takes the place of two discs.
//!
//! No rounding takes part in an answer (`number`, `long`). From code and faces a table tells the loops and
//! what fills them (`table`), `patch` puts in the tube, and `place` the vertices that some of this needs in
//! the interior of the cell.
//!
//! A cell whose answer is that of its case is left to the case; another is *special* (`special`). A slice's
//! special cells come after its other cells: their triangles after the triangles of the others, their
//! interior vertices after the vertices on edges, both row by row (`write`).
//!
//! # Sources
//!
//! Nielson & Hamann 1991 (faces); Chernyaev, "Marching Cubes 33", CERN CN 95-17, 1995 (that the interior is
//! to be asked too), and Custodio et al., "Practical considerations on Marching Cubes 33 topological
//! correctness", C&G 37, 2013 (what its test misses); Grosso 2016 (the inner hexagon).

mod cell;
mod decide;
mod long;
mod number;
mod patch;
mod place;
mod special;
mod table;
mod write;

pub(crate) use cell::Values;
pub(crate) use special::SpecialCells;
pub(crate) use write::{Filling, SpecialWriter};

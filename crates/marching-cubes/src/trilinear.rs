//! Cells whose signs leave open what the surface connects, decided as the trilinear interpolant does.

mod cell;
mod decide;
mod long;
mod number;
mod table;

//! The door: every room under one name.

pub mod pipeline;

pub use isokit_geom as geom;
pub use isokit_io as io;
pub use isokit_job as job;
pub use isokit_lanes as lanes;
pub use isokit_marching_cubes as marching_cubes;
pub use isokit_mesh as mesh;
pub use isokit_volume as volume;
pub use isokit_volume::for_any;

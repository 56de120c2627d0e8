//! Where a mesh goes.

use super::{MeshFormat, values};
use clap::Args;
use isokit::geom::Unit;
use std::path::PathBuf;

/// The output file and what only some formats need.
#[derive(Args, Clone, Debug)]
pub(crate) struct MeshOutputArgs {
    /// The file to write; its extension decides the format. - writes to stdout
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// Format of the mesh that -o - writes [default: ply]
    #[arg(long, value_enum)]
    pub(crate) format: Option<MeshFormat>,
    /// Unit to take coordinates in for glTF, which is in metres: m cm mm um nm angstrom [default: the
    /// input's, or m if it has none]
    #[arg(long, value_name = "UNIT", value_parser = values::unit)]
    pub(crate) gltf_unit: Option<Unit>,
}

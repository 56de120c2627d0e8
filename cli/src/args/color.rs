//! What vertices carry besides their place.

use super::{BetweenArg, ColorMapArg, TextureArg};
use clap::Args;
use std::path::PathBuf;

/// The colours of a mesh.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Colour")]
pub(crate) struct ColorArgs {
    /// Another volume: its value at each vertex goes into the file, in PLY as quality, in glTF as _VALUE. It may have
    /// any lattice in the same world. A vertex farther than half a sample outside of it has no value (NaN). Three or four
    /// bytes per sample are a colour, as `isokit voxelize --colors` writes them, and colour the vertex. Other vectors
    /// are converted first: `isokit convert --quantity`
    #[arg(long, value_name = "VOLUME")]
    pub(crate) attribute: Option<PathBuf>,
    /// What lies between samples of the other volume
    #[arg(long, value_enum, default_value_t, requires = "attribute")]
    pub(crate) attribute_kernel: BetweenArg,
    /// Colour vertices by that value, in PLY, glTF and OBJ: viridis, magma, gray or coolwarm, from the value LOW to
    /// HIGH [default: the least and the greatest at a vertex of any surface]. Without a value they keep the colour of
    /// their surface
    #[arg(long, value_name = "NAME[:LOW:HIGH]", requires = "attribute")]
    pub(crate) colormap: Option<ColorMapArg>,
    /// Colour vertices by a pattern that fills space: checker, marble, wood or granite, of the surface's colour and a
    /// darker one; SIZE in units of the mesh [default: an eighth of its longest side]
    #[arg(long, value_name = "PATTERN[:SIZE]", conflicts_with = "colormap")]
    pub(crate) texture: Option<TextureArg>,
}

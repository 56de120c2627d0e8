//! Options with a few named answers, and what they mean to the library.

use clap::ValueEnum;
use isokit::{
    field::Between,
    io::Format,
    marching_cubes::{Boundary, Degenerate, Diagonals, Gradient, Nan, Placement, Topology},
    pipeline::{Normals, TargetSpace},
};

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProgressArg {
    #[default]
    Auto,
    Always,
    Never,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum BoundaryArg {
    /// Outside: the surface is closed by caps along the border, which are not where the object ends
    #[default]
    Closed,
    /// Nothing: the surface ends at the border
    Open,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum TopologyArg {
    /// What the trilinear interpolant of a cell's samples connects, decided without rounding: always closed; two sheets
    /// within a cell may still cut through each other
    #[default]
    Trilinear,
    /// One fixed answer per case: always closed; may separate what the field joins
    Table,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum PlacementArg {
    /// Where the straight line between two samples has the value: error O(h^2)
    Linear,
    /// Where the cubic through the four nearest samples in line has it: O(h^4) with --degenerate exact, else but for
    /// vertices next to a sample; rougher in noise, and farther off in walls thinner than the four
    Cubic,
    /// The same with six samples: O(h^6)
    #[default]
    Quintic,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum DiagonalsArg {
    /// The same way in all cells of a case
    #[default]
    Table,
    /// Along the surface, by the normals of their vertices: as many triangles, nearer to that of a smooth field, not
    /// of noise
    Fitted,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum NormalsArg {
    /// The direction in which the samples fall, from central differences: error O(h^2), O(h) at the border
    #[default]
    Gradient,
    /// The same from differences as exact as the placement, where there are enough samples, and rougher in noise; always
    /// so where triangles are refined or balanced
    Matching,
    /// The mean of the triangles around a vertex
    Area,
    /// None: a viewer shades triangles flat or makes its own
    None,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum DegenerateArg {
    /// Vertices keep 2^-10 of an edge from samples, far from the origin up to 2^-4, so that every triangle has an area, if
    /// a thin one; GLB and STL cannot hold that everywhere, and a warning says where they do not
    #[default]
    Never,
    /// Vertices lie where interpolation puts them; samples equal to the isovalue give triangles
    /// without area
    Exact,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum NanArg {
    /// Stop, and say how many there are and where
    #[default]
    Error,
    /// They are outside: the surface closes around them
    Outside,
    /// Cells that touch them have no surface: it has an open border there
    Mask,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum SpaceArg {
    /// The file's own world
    #[default]
    Source,
    /// x to the right, y to anterior, z to superior
    Ras,
    /// x to the left, y to posterior, z to superior
    Lps,
    /// Sample numbers, without unit
    Index,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum BetweenArg {
    /// What is linear along each axis: for quantities
    #[default]
    Linear,
    /// The nearest sample: for labels
    Nearest,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum MeshFormat {
    Glb,
    Obj,
    Ply,
    Stl,
}

impl From<BoundaryArg> for Boundary {
    fn from(arg: BoundaryArg) -> Self {
        match arg {
            BoundaryArg::Closed => Self::Closed,
            BoundaryArg::Open => Self::Open,
        }
    }
}

impl From<TopologyArg> for Topology {
    fn from(arg: TopologyArg) -> Self {
        match arg {
            TopologyArg::Table => Self::Table,
            TopologyArg::Trilinear => Self::Trilinear,
        }
    }
}

impl From<DiagonalsArg> for Diagonals {
    fn from(arg: DiagonalsArg) -> Self {
        match arg {
            DiagonalsArg::Table => Self::Table,
            DiagonalsArg::Fitted => Self::Fitted,
        }
    }
}

impl From<NormalsArg> for Normals {
    fn from(arg: NormalsArg) -> Self {
        match arg {
            NormalsArg::Gradient | NormalsArg::Matching => Self::Gradient,
            NormalsArg::Area => Self::Area,
            NormalsArg::None => Self::None,
        }
    }
}

impl From<NormalsArg> for Gradient {
    fn from(arg: NormalsArg) -> Self {
        match arg {
            NormalsArg::Matching => Self::Matching,
            NormalsArg::Gradient | NormalsArg::Area | NormalsArg::None => Self::Central,
        }
    }
}

impl From<DegenerateArg> for Degenerate {
    fn from(arg: DegenerateArg) -> Self {
        match arg {
            DegenerateArg::Never => Self::Never,
            DegenerateArg::Exact => Self::Exact,
        }
    }
}

impl From<PlacementArg> for Placement {
    fn from(arg: PlacementArg) -> Self {
        match arg {
            PlacementArg::Linear => Self::Linear,
            PlacementArg::Cubic => Self::Cubic,
            PlacementArg::Quintic => Self::Quintic,
        }
    }
}

impl From<NanArg> for Nan {
    fn from(arg: NanArg) -> Self {
        match arg {
            NanArg::Error => Self::Error,
            NanArg::Outside => Self::Outside,
            NanArg::Mask => Self::Mask,
        }
    }
}

impl From<BetweenArg> for Between {
    fn from(arg: BetweenArg) -> Self {
        match arg {
            BetweenArg::Linear => Self::Linear,
            BetweenArg::Nearest => Self::Nearest,
        }
    }
}

impl From<SpaceArg> for TargetSpace {
    fn from(arg: SpaceArg) -> Self {
        match arg {
            SpaceArg::Source => Self::Source,
            SpaceArg::Ras => Self::Ras,
            SpaceArg::Lps => Self::Lps,
            SpaceArg::Index => Self::Index,
        }
    }
}

impl From<MeshFormat> for Format {
    fn from(arg: MeshFormat) -> Self {
        match arg {
            MeshFormat::Glb => Self::Glb,
            MeshFormat::Obj => Self::Obj,
            MeshFormat::Ply => Self::Ply,
            MeshFormat::Stl => Self::Stl,
        }
    }
}

//! Where the samples of a volume are in the world, and in which words the world is described.

use crate::{Affine, AffineError};
use std::fmt;

/// The unit of a world coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Unit {
    /// Nobody said.
    #[default]
    Unknown,
    /// m
    Metre,
    /// cm
    Centimetre,
    /// mm
    Millimetre,
    /// µm
    Micrometre,
    /// nm
    Nanometre,
    /// Å
    Angstrom,
}

impl Unit {
    /// Every unit with its symbol.
    pub const ALL: [(Self, &str); 7] = [
        (Self::Unknown, "unknown"),
        (Self::Metre, "m"),
        (Self::Centimetre, "cm"),
        (Self::Millimetre, "mm"),
        (Self::Micrometre, "um"),
        (Self::Nanometre, "nm"),
        (Self::Angstrom, "angstrom"),
    ];

    /// How many metres one unit is, if that is known.
    pub const fn metres(self) -> Option<f64> {
        match self {
            Self::Unknown => None,
            Self::Metre => Some(1.0),
            Self::Centimetre => Some(1e-2),
            Self::Millimetre => Some(1e-3),
            Self::Micrometre => Some(1e-6),
            Self::Nanometre => Some(1e-9),
            Self::Angstrom => Some(1e-10),
        }
    }

    /// The unit of a symbol as files write it: `mm`, `um` or `µm`, `angstrom` or `Å`, …
    pub fn from_symbol(symbol: &str) -> Option<Self> {
        let symbol = match symbol.trim() {
            "µm" | "\u{3bc}m" | "micron" | "microns" | "micrometer" => "um",
            "Å" | "A" => "angstrom",
            "millimeter" | "millimetre" => "mm",
            "centimeter" | "centimetre" => "cm",
            "meter" | "metre" => "m",
            "nanometer" | "nanometre" => "nm",
            other => other,
        };
        Self::ALL.into_iter().find(|&(_, name)| name == symbol).map(|(unit, _)| unit)
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = Self::ALL.into_iter().find(|(unit, _)| unit == self);
        f.write_str(named.map_or("unknown", |(_, name)| name))
    }
}

/// Which way the world's axes point in a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Space {
    /// Nobody said, or the data is not of a body.
    #[default]
    Unknown,
    /// x to the right, y to anterior, z to superior.
    Ras,
    /// x to the left, y to posterior, z to superior.
    Lps,
}

impl fmt::Display for Space {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Unknown => "unknown",
            Self::Ras => "RAS",
            Self::Lps => "LPS",
        })
    }
}

/// Index space to world space, with the world's unit and axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// From sample numbers to world coordinates. A sample's value sits at its lattice point.
    pub index_to_world: Affine,
    /// The unit of a world coordinate.
    pub unit: Unit,
    /// Which way the world's axes point.
    pub space: Space,
}

impl Default for Frame {
    fn default() -> Self {
        Self { index_to_world: Affine::IDENTITY, unit: Unit::Unknown, space: Space::Unknown }
    }
}

impl Frame {
    /// The same samples described in another space: between RAS and LPS, x and y change sign. `None`
    /// if either space is unknown and they differ, for then nobody can say where the axes point.
    pub fn in_space(self, space: Space) -> Option<Self> {
        if space == self.space {
            return Some(self);
        }
        if space == Space::Unknown || self.space == Space::Unknown {
            return None;
        }
        let index_to_world = self.index_to_world.scaled_world([-1.0, -1.0, 1.0]).ok()?;
        Some(Self { index_to_world, space, ..self })
    }

    /// The frame of a part whose first sample is sample `ijk` of the whole.
    ///
    /// # Errors
    ///
    /// If that sample's place is not finite.
    pub fn starting_at(self, ijk: [usize; 3]) -> Result<Self, AffineError> {
        let index_to_world = self.index_to_world.starting_at(ijk.map(|i| i as f64))?;
        Ok(Self { index_to_world, ..self })
    }
}

#[cfg(test)]
mod tests {
    use super::{Frame, Space, Unit};
    use crate::Affine;

    #[test]
    fn there_and_back_is_where_it_was() {
        let index_to_world = Affine::axis_aligned([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]).unwrap();
        let ras = Frame { index_to_world, unit: Unit::Millimetre, space: Space::Ras };
        let lps = ras.in_space(Space::Lps).unwrap();
        assert_eq!(lps.index_to_world.point([1.0; 3]), [-5.0, -7.0, 9.0]);
        assert_eq!(lps.in_space(Space::Ras), Some(ras));
    }

    #[test]
    fn an_unknown_space_becomes_no_other() {
        assert_eq!(Frame::default().in_space(Space::Ras), None);
        assert_eq!(Frame::default().in_space(Space::Unknown), Some(Frame::default()));
    }

    #[test]
    fn symbols_are_read_back() {
        for (unit, symbol) in Unit::ALL {
            assert_eq!(Unit::from_symbol(symbol), Some(unit));
            assert_eq!(unit.to_string(), symbol);
        }
        assert_eq!(Unit::from_symbol("µm"), Some(Unit::Micrometre));
        assert_eq!(Unit::from_symbol("furlong"), None);
    }
}

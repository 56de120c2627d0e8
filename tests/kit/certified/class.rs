//! Which of the configurations of a trilinear cell a cell falls into.

use super::cell;
use crate::chance::Chance;
use isokit::geom::cube::Face;

/// All that tells cells of different topology apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Class {
    /// Bit `k` is set if corner `k` is inside: at or above 0.
    pub code: usize,
    /// Bit `f` is set if face `f` is ambiguous and joins its inside corners.
    pub joins: usize,
    /// How many handles the patches have together: 1 if two loops on the border of the cell bound one patch.
    pub tunnels: usize,
}

impl Class {
    /// The class of a cell with these corner values, less the isovalue; none if it is undecided.
    pub fn of(corners: [i64; 8]) -> Option<Self> {
        let joins = face_joins(corners);
        let joins = (0..6).map(|f| usize::from(joins[f] == Some(true)) << f).sum();
        let lacking = cell(corners)?.patches.iter().map(|patch| 1 - patch.euler).sum::<i64>();
        let tunnels = usize::try_from(lacking).expect("every patch has a border");
        Some(Self { code: code(corners), joins, tunnels })
    }
}

/// Bit `k` is set if corner `k` is inside.
pub fn code(corners: [i64; 8]) -> usize {
    (0..8).map(|k| usize::from(corners[k] >= 0) << k).sum()
}

/// Whether each face joins its inside corners; none for a face that is not ambiguous.
///
/// With A and C the inside corners of a face and B and D the outside ones, the saddle of the field on it is
/// (AC − BD) / (A + C − B − D), whose denominator is positive. Where it is inside, a tie included, the inside
/// is joined: Nielson & Hamann, "The asymptotic decider", Visualization 1991.
pub fn face_joins(corners: [i64; 8]) -> [Option<bool>; 6] {
    std::array::from_fn(|f| {
        let values = Face::new(f as u8).corners().map(|k| i128::from(corners[k.index()]));
        let [a, b, c, d] = values;
        match values.map(|v| v >= 0) {
            [true, false, true, false] => Some(a * c - b * d >= 0),
            [false, true, false, true] => Some(b * d - a * c >= 0),
            _ => None,
        }
    })
}

/// A cell by chance: whole numbers from −`reach` to below `reach`.
pub fn random(reach: i64, chance: &mut Chance) -> [i64; 8] {
    [(); 8].map(|()| (chance.unit() * (2 * reach) as f64) as i64 - reach)
}

/// A cell by chance with this code: whole numbers from −`reach` to below `reach`.
pub fn random_with_code(code: usize, reach: i64, chance: &mut Chance) -> [i64; 8] {
    let sizes = [(); 8].map(|()| (chance.unit() * reach as f64) as i64);
    std::array::from_fn(|k| if code >> k & 1 == 1 { sizes[k] } else { !sizes[k] })
}

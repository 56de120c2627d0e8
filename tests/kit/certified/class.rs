//! Which of the configurations of a trilinear cell a cell falls into.

use super::{
    Cell, cell,
    classes::{pairs, regions},
};
use crate::chance::Chance;
use isokit::geom::cube::Face;

/// All that tells cells of different topology apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Class {
    /// Bit `k` is set if corner `k` is inside: at or above 0.
    pub code: usize,
    /// Bit `f` is set if face `f` is ambiguous and joins its inside corners.
    pub joins: usize,
    /// The two regions that are one only through the interior, each by its least corner. The patch between
    /// them and the rest is a tunnel.
    pub tunnel: Option<[usize; 2]>,
}

impl Class {
    /// The class of a cell with these corner values, less the isovalue; none if it is undecided.
    ///
    /// # Panics
    ///
    /// If the interior joins more than two regions, or two of them by anything but one tunnel.
    pub fn of(corners: [i64; 8]) -> Option<Self> {
        Some(Self::of_cell(corners, &cell(corners)?))
    }

    /// The class of a cell that is known already.
    ///
    /// # Panics
    ///
    /// The same.
    pub fn of_cell(corners: [i64; 8], cell: &Cell) -> Self {
        let joins = face_joins(corners);
        let joins = (0..6).map(|f| usize::from(joins[f] == Some(true)) << f).sum();
        let code = code(corners);
        let apart = regions(code, joins);
        let joined = |pair: &[usize; 2]| {
            cell.regions.iter().any(|region| pair.iter().all(|k| region.corners.contains(k)))
        };
        let tunnels: Vec<_> = pairs(apart).into_iter().filter(joined).collect();
        let lacking = cell.patches.iter().map(|patch| 1 - patch.euler).sum::<i64>();
        assert!(tunnels.len() < 2 && tunnels.len() as i64 == lacking, "{corners:?}: {cell:?}");
        Self { code, joins, tunnel: tunnels.first().copied() }
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

/// The same with sizes that are all like each other, or not, and then two opposite corners or all others up to
/// 16 times as far from 0: of the classes of a code none is rare.
pub fn random_for_classes(code: usize, reach: i64, chance: &mut Chance) -> [i64; 8] {
    let (least, far) =
        ([0, reach / 2, reach - reach / 8][chance.below(3) as usize], chance.below(8));
    let times = [4, 5, 6, 8, 16, 64][chance.below(6) as usize];
    let two = chance.below(2) == 0;
    let sizes = random_with_code(code, reach - least, chance);
    std::array::from_fn(|k| {
        let size = sizes[k] + if sizes[k] < 0 { -least } else { least };
        size * if [far as usize, 7 - far as usize].contains(&k) == two { times } else { 4 }
    })
}

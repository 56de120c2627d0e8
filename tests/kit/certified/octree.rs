//! A cell cut into boxes until every box is simple.

use isokit::geom::cube::Edge;

/// Boxes that one cell may be cut into, those that were cut again included.
const MOST_BOXES: usize = 1 << 16;

/// How often a box may be halved.
const DEEPEST: u32 = 64;

/// Whether the inside corners of each code hang together along edges, and the outside corners too.
static SIMPLE: std::sync::LazyLock<[bool; 256]> =
    std::sync::LazyLock::new(|| std::array::from_fn(|code| hangs(code) && hangs(!code & 0xFF)));

/// Boxes, each cut into eight or simple.
#[derive(Debug)]
pub(super) struct Octree {
    pub(super) boxes: Vec<Node>,
}

/// A box.
#[derive(Debug)]
pub(super) struct Node {
    /// Bit `k` is set if corner `k` is inside.
    pub(super) code: usize,
    /// How often the cell was halved to get here.
    pub(super) depth: u32,
    /// The boxes that it is cut into, each at the corner of its number; none if this one is simple.
    pub(super) parts: Option<[usize; 8]>,
}

impl Octree {
    /// Number of the box that is the whole cell.
    pub(super) const ROOT: usize = 0;

    /// Cuts the cell with these corner values; none if a limit is met.
    pub(super) fn of(values: &[i128; 8]) -> Option<Self> {
        let mut octree = Self { boxes: vec![] };
        octree.grow(values, 0)?;
        Some(octree)
    }

    fn grow(&mut self, values: &[i128; 8], depth: u32) -> Option<usize> {
        let code = code_of(values);
        let number = self.boxes.len();
        self.boxes.push(Node { code, depth, parts: None });
        if !SIMPLE[code] {
            if number >= MOST_BOXES || depth >= DEEPEST {
                return None;
            }
            let mut parts = [0; 8];
            for (part, values) in parts.iter_mut().zip(&halved(values)?) {
                *part = self.grow(values, depth + 1)?;
            }
            self.boxes[number].parts = Some(parts);
        }
        Some(number)
    }
}

/// The signs of corners.
pub(super) fn code_of(values: &[i128; 8]) -> usize {
    (0..8).map(|k| usize::from(values[k] >= 0) << k).sum()
}

/// The corner values of the eight halves of a box, times 8; none if one does not fit.
fn halved(values: &[i128; 8]) -> Option<[[i128; 8]; 8]> {
    // Eight times a mean of values: no sum on the way is larger.
    let fits = values.iter().all(|v| v.unsigned_abs() <= i128::MAX.unsigned_abs() / 8);
    fits.then(|| {
        std::array::from_fn(|part| std::array::from_fn(|corner| between(values, part, corner)))
    })
}

/// Eight times the value at a corner of a part of the box.
fn between(values: &[i128; 8], part: usize, corner: usize) -> i128 {
    // Where corner and part are on one side of an axis, it is that side of the box; else the middle.
    let fixed = !(part ^ corner) & 7;
    let ends = (0..8).filter(|end| (end ^ part) & fixed == 0);
    ends.map(|end| values[end]).sum::<i128>() << fixed.count_ones()
}

/// Whether the corners that are set can be reached from each other along edges between set corners.
fn hangs(code: usize) -> bool {
    let ends = || Edge::all().map(|edge| edge.ends().map(|end| 1 << end.index()));
    let mut reached = code & code.wrapping_neg();
    for _ in 0..8 {
        for [a, b] in ends().filter(|[a, b]| code & a != 0 && code & b != 0) {
            if reached & (a | b) != 0 {
                reached |= a | b;
            }
        }
    }
    reached == code
}

#[cfg(test)]
mod tests {
    use super::{Octree, SIMPLE, between};

    #[test]
    fn half_of_all_codes_are_simple() {
        assert_eq!(SIMPLE.iter().filter(|simple| **simple).count(), 128);
    }

    #[test]
    fn halves_are_the_trilinear_interpolant() {
        let values = [3, -5, 7, 11, -13, 17, 19, -23];
        for (part, corner) in (0..8).flat_map(|part| (0..8).map(move |corner| (part, corner))) {
            let weight = |end: usize| -> i128 {
                let at = |axis: usize| (part >> axis & 1) as i128 + (corner >> axis & 1) as i128;
                (0..3)
                    .map(|axis| if end >> axis & 1 == 1 { at(axis) } else { 2 - at(axis) })
                    .product()
            };
            let expected: i128 = (0..8).map(|end| weight(end) * values[end]).sum();
            assert_eq!(between(&values, part, corner), expected, "part {part}, corner {corner}");
        }
    }

    #[test]
    fn a_simple_cell_is_one_box_and_what_never_becomes_simple_is_none() {
        assert_eq!(Octree::of(&[1, 1, 1, 1, -1, -1, -1, -1]).unwrap().boxes.len(), 1);
        // A saddle line of value 0 at thirds, which halving never meets.
        assert!(Octree::of(&[4, -2, -2, 1, 4, -2, -2, 1]).is_none());
        assert!(Octree::of(&[i128::MAX, -1, -1, 1, 1, 1, 1, 1]).is_none());
    }
}

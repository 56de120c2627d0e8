//! How many triangles 64 cells have, by a few operations on bits: no case is looked up.
//!
//! A loop of *n* vertices is cut into *n* − 2 triangles, so a cell with *c* cut edges and *f* loops has
//! *c* − 2*f*. Where loops keep the inside corners of a face's diagonal apart, *f* follows from what is inside
//! by Euler's formula, and a cell has
//!
//! > corners − 2 · faces + 4 · cell
//!
//! triangles, where each term counts those that are inside completely; and four fewer if just two corners are
//! outside and these are opposite ones, since then the others lie around a hole that two triangles close.

use std::ops::{BitAnd, BitOr, BitXor, Not};

/// Bits of many cells at once.
pub(crate) trait Bits:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self> + Not<Output = Self>
{
}

impl Bits for u64 {}

/// For each of 64 cells, or more, a number of three binary digits, lowest first. Given are its corners, at
/// y, z = 00, 10, 01, 11 and each at x = 0, 1.
#[inline(always)]
pub(crate) fn triangles<B: Bits>(rows: [[B; 2]; 4]) -> [B; 3] {
    let [[a, a1], [b, b1], [c, c1], [d, d1]] = rows;
    // Corners inside: `ones` + 2 `twos` + 4 `fours`, modulo 8.
    let (s0, t0) = add(a, a1, b);
    let (s1, t1) = add(b1, c, c1);
    let (s2, t2) = add(s0, s1, d);
    let (ones, t3) = (s2 ^ d1, s2 & d1);
    let (t4, f0) = add(t0, t1, t2);
    let (twos, fours) = (t4 ^ t3, f0 ^ t4 & t3);
    // Faces inside: `single` + 2 `double`, modulo 4.
    // Of the edges along x those of a and d each have a face with those of b and c: sum times sum.
    let [along_a, along_b, along_c, along_d] = [a & a1, b & b1, c & c1, d & d1];
    let (one_of_a_d, both_of_a_d) = (along_a ^ along_d, along_a & along_d);
    let (one_of_b_c, both_of_b_c) = (along_b ^ along_c, along_b & along_c);
    let two_along_x = one_of_a_d & both_of_b_c | both_of_a_d & one_of_b_c;
    let (single, carry) = add(one_of_a_d & one_of_b_c, a & b & c & d, a1 & b1 & c1 & d1);
    let double = two_along_x ^ carry;
    let cell = both_of_a_d & both_of_b_c;
    // Six corners inside and no face: those outside are opposite.
    let hole = !ones & twos & fours & !single & !double;
    [ones, twos ^ single, fours ^ double ^ cell ^ hole ^ !twos & single]
}

/// Adds three binary digits: the sum's lower and higher one.
#[inline(always)]
pub(crate) fn add<B: Bits>(a: B, b: B, c: B) -> (B, B) {
    (a ^ b ^ c, a & b | c & (a ^ b))
}

/// Triangles by the loops of a cell: the cut edges less two for every loop, and of those there is one less
/// than there are parts; inside corners hang together along edges, outside ones across faces too.
#[cfg(test)]
pub(crate) fn by_loops(case: usize) -> u8 {
    let is_in = |corner: usize| case >> corner & 1 == 1;
    let mut part: [usize; 8] = std::array::from_fn(|corner| corner);
    let mut cut = 0;
    for (p, q) in (0..8_usize).flat_map(|p| (0..p).map(move |q| (p, q))) {
        let distance = (p ^ q).count_ones();
        cut += u8::from(distance == 1 && is_in(p) != is_in(q));
        let on_face = distance == 2 && !is_in(p) && !is_in(q);
        if distance == 1 && is_in(p) == is_in(q) || on_face {
            let (from, to) = (part[p], part[q]);
            part.iter_mut().filter(|part| **part == from).for_each(|part| *part = to);
        }
    }
    let mut parts = part.to_vec();
    parts.sort_unstable();
    parts.dedup();
    cut - 2 * (parts.len() as u8 - 1)
}

#[cfg(test)]
mod tests {
    use super::{by_loops, triangles};

    #[test]
    fn each_case_has_the_triangles_of_its_loops() {
        for case in 0..256 {
            let corner = |k: usize| if case >> k & 1 == 1 { u64::MAX } else { 0 };
            let digits = triangles([0, 2, 4, 6].map(|k| [corner(k), corner(k + 1)]));
            assert!(digits.iter().all(|&digit| digit == 0 || digit == u64::MAX));
            let found = (0..3).map(|n| u8::from(digits[n] != 0) << n).sum::<u8>();
            assert_eq!(found, by_loops(case), "case {case:#b}");
        }
    }
}

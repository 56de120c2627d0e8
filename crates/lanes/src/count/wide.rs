//! A pack of words at a time, of which nearly all blank ones are passed over.

use super::RowCounts;
use crate::{
    BitRows, Word,
    euler::triangles,
    word::wide::{Eight, Four, Group, Groups, OpenPlaces, Pack, PackRoom},
};
use std::ops::Range;

/// The function of a level.
macro_rules! level {
    ($name:ident $pack:ident $features:literal) => {
        #[target_feature(enable = $features)]
        pub(super) fn $name(
            bits: &BitRows<'_>,
            rows: Range<usize>,
            out: &mut [RowCounts],
            open: Option<&mut Vec<Word>>,
        ) {
            // SAFETY: this function runs only where the machine has the instructions.
            let groups = unsafe { Groups::<$pack>::new(bits, rows.clone()) };
            // One loop for each: what only the second needs would take registers in the first.
            match open {
                None => count_groups(groups, (bits, rows), out, None),
                Some(open) => count_groups(groups, (bits, rows), out, Some(open)),
            }
        }
    };
}

level!(count_rows_avx2 Four "avx2,bmi1,bmi2,lzcnt,popcnt");
level!(
    count_rows_avx512 Eight
    "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512vl,avx512vbmi2,avx512vpopcntdq"
);

#[inline(always)]
fn count_groups<P: Pack>(
    mut groups: Groups<'_, P>,
    (bits, rows): (&BitRows<'_>, Range<usize>),
    out: &mut [RowCounts],
    open: Option<&mut Vec<Word>>,
) {
    let mut room;
    let mut places = OpenPlaces::none();
    if open.is_some() {
        room = PackRoom::new();
        places = OpenPlaces::new(&groups, &mut room);
    }
    while let Some(mut stretch) = groups.next() {
        let mask = if stretch.has_cells() { u64::MAX } else { u64::MAX >> 16 };
        while let Some(group) = stretch.next() {
            if open.is_some() {
                places.add(&group);
            }
            let counts = counts(&group);
            let counts = counts.as_ref();
            // So few words fill no 16 bits.
            let sum = |some: Range<usize>| counts[some].iter().sum::<u64>() & mask;
            let [row, first] = group.place(0);
            if first + P::WORDS <= bits.words() {
                // All are of one row, as in most packs of long rows.
                out[row - rows.start].unpack(sum(0..P::WORDS));
            } else {
                let mut n = 0;
                while n < P::WORDS {
                    let [row, w] = group.place(n);
                    let Some(out) = out.get_mut(row - rows.start) else { break };
                    let end = (n + bits.words() - w).min(P::WORDS);
                    out.unpack(sum(n..end));
                    n = end;
                }
            }
        }
    }
    if let Some(open) = open {
        open.clear();
        bits.look_up(places.packs(), open);
    }
}

/// For each word a number of four times 16 bits.
#[inline(always)]
fn counts<P: Pack>(group: &Group<P>) -> P::Words {
    let Group { low: [a, b, c, d], high: [a1, b1, c1, d1], cells, .. } = *group;
    let digits = triangles([[a, a1], [b, b1], [c, c1], [d, d1]]);
    // No closures: those are not always inlined, and are not compiled for the level then.
    let [ones, twos, fours] = digits;
    let triangles = P::sums([ones & cells, twos & cells, fours & cells]);
    let (x, y, z) = ((a ^ a1) & cells, a ^ b, a ^ c);
    P::quarters([x.count_ones(), y.count_ones(), z.count_ones(), triangles]).words()
}

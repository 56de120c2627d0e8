//! The choice against its definition, and every level against the portable one.

use super::{
    CORNERS, DIAGONALS, LEAST, POLYGONS, Polygons, TRIPLES, WAYS, Way, diagonals, triples,
};
use crate::Level;

fn chance(state: &mut u64) -> f32 {
    *state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
    (*state >> 40) as f32 / (1 << 23) as f32 - 1.0
}

/// All ways to cut what lies between two corners, as triples.
fn cuts(first: usize, last: usize) -> Vec<Vec<[usize; 3]>> {
    if last - first < 2 {
        return vec![vec![]];
    }
    let tips = first + 1..last;
    tips.flat_map(|tip| {
        let after = cuts(tip, last);
        cuts(first, tip).into_iter().flat_map(move |before| {
            after.clone().into_iter().map({
                let before = before.clone();
                move |after| [&[[first, tip, last]], &before[..], &after[..]].concat()
            })
        })
    })
    .collect()
}

fn ways<const N: usize>() -> Vec<Way> {
    let way = |cut: Vec<[usize; 3]>| {
        let mut way = Way::default();
        for (number, triple) in way.triangles.iter_mut().zip(&cut) {
            *number = triples::<N>().iter().position(|t| t == triple).unwrap() as u8;
        }
        let sides = cut.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [a, c]]);
        let number = |side: [usize; 2]| diagonals::<N>().iter().position(|d| *d == side);
        let mut numbers: Vec<_> = sides.filter_map(number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), N - 3);
        way.diagonals.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = number as u8);
        way
    };
    cuts(0, N - 1).into_iter().map(way).collect()
}

/// Rings that are bent, some of them badly, with a number that is none here and there.
fn rings<const N: usize>(state: &mut u64, rough: f32) -> Polygons<N> {
    let mut polygons = Polygons::<N>::default();
    for n in 0..POLYGONS {
        for corner in 0..N {
            let angle = std::f32::consts::TAU * corner as f32 / N as f32;
            let place = [angle.cos(), angle.sin(), 0.3 * (2.0 * angle).cos()];
            for k in 0..3 {
                let first = [1.0, 0.0, 0.3][k];
                let away = if corner == 0 { 0.0 } else { rough * chance(state) };
                polygons.places[corner][k][n] = place[k] - first + away;
                let up = if k == 2 { 1.0 } else { 0.0 };
                polygons.normals[corner][k][n] = up + 0.4 * chance(state);
            }
        }
    }
    polygons.normals[1][0][3] = f32::NAN;
    polygons.places[2][1][5] = f32::INFINITY;
    polygons
}

/// By how much a way bends, and whether its triangles are sound: yes, no, or nobody knows.
fn judged<const N: usize>(polygons: &Polygons<N>, n: usize, way: &Way) -> (f64, Option<bool>) {
    let of = |list: &[[[f32; POLYGONS]; 3]; N], corner: usize| {
        [0, 1, 2].map(|k| f64::from(list[corner][k][n]))
    };
    let minus = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| a[k] - b[k]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let bend = |&d: &u8| {
        let [a, b] = diagonals::<N>()[usize::from(d)];
        let turn = minus(of(&polygons.normals, b), of(&polygons.normals, a));
        dot(minus(of(&polygons.places, b), of(&polygons.places, a)), turn).powi(2)
    };
    let mean = (0..N).fold([0.0; 3], |sum, c| minus(sum, of(&polygons.normals, c)));
    let size = (0..N).map(|c| dot(of(&polygons.places, c), of(&polygons.places, c))).sum::<f64>();
    let least = f64::from(LEAST) * N as f64 * size;
    let area = |&t: &u8| {
        let [a, b, c] = triples::<N>()[usize::from(t)].map(|corner| of(&polygons.places, corner));
        let ([x, y, z], [u, v, w]) = (minus(b, a), minus(c, a));
        -dot([y * w - z * v, z * u - x * w, x * v - y * u], mean)
    };
    let area = way.triangles[..N - 2].iter().map(area).fold(f64::INFINITY, f64::min);
    let is_near = (area - least).abs() < 1e-5 * size;
    (way.diagonals[..N - 3].iter().map(bend).sum(), (!is_near).then_some(area > least))
}

fn check<const N: usize>() {
    let (ways, mut state, mut moved) = (ways::<N>(), N as u64, 0);
    for round in 0..120 {
        let rough = [0.0, 0.2, 0.9][round % 3];
        let mut polygons = rings::<N>(&mut state, rough);
        let own = [(); POLYGONS].map(|()| (chance(&mut state).abs() * ways.len() as f32) as u32);
        let mut half = || (chance(&mut state).abs() * 65536.0) as u32;
        let mut bits = || half() << 16 | half();
        let forbidden = [[(); POLYGONS]; 2].map(|half| half.map(|()| bits()));
        let is_forbidden = |way: usize, n: usize| forbidden[way / 32][n] << (way % 32) >> 31 == 1;
        let of = |polygons: &Polygons<N>, level, mirrors| {
            polygons.best_at(level, (&ways, &forbidden), &own, mirrors)
        };
        let best = of(&polygons, Level::Portable, false);
        for &level in Level::available() {
            assert_eq!(of(&polygons, level, false), best, "{level:?}");
            assert_eq!(of(&polygons, level, true), of(&polygons, Level::Portable, true));
        }
        for n in 0..POLYGONS {
            let (found, own) = (best[n] as usize, own[n] as usize);
            moved += usize::from(found != own);
            if n == 3 || n == 5 {
                assert_eq!(found, own, "what is no number chooses nothing");
                continue;
            }
            let [sum, before] = [found, own].map(|way| judged(&polygons, n, &ways[way]).0);
            assert!(found == own || (sum < before * 1.0001 && !is_forbidden(found, n)));
            assert!(found == own || judged(&polygons, n, &ways[found]).1 != Some(false));
            for (other, way) in ways.iter().enumerate() {
                let (less, is_sound) = judged(&polygons, n, way);
                let is_allowed = !is_forbidden(other, n) && is_sound == Some(true);
                assert!(!(is_allowed && less < sum * 0.9999), "{other} rather than {found}");
            }
        }
        // The other way round they are as good.
        for list in [&mut polygons.places, &mut polygons.normals] {
            list.iter_mut().for_each(|axes| axes[0].iter_mut().for_each(|x| *x = -*x));
        }
        assert_eq!(of(&polygons, Level::current(), true), best);
    }
    assert!(moved > 200, "{moved}");
}

#[test]
fn polygons_get_the_best_way_that_is_allowed_and_sound() {
    check::<4>();
    check::<5>();
    check::<6>();
    check::<CORNERS>();
}

/// Places and normals as they are gathered from vertices of which the last are corners too, or not.
fn check_gathered<const N: usize>() {
    let mut state = 3 * N as u64;
    for (count, least) in [(1, 0), (2, 1), (40, 0), (40, 30), (900, 0)] {
        let mut vectors = || -> Vec<[f32; 3]> {
            (0..count).map(|_| [(); 3].map(|()| 10.0 * chance(&mut state))).collect()
        };
        let (mut places, normals) = (vectors(), vectors());
        let odd = [f32::INFINITY, -0.0, 0.0, f32::NAN, 1e-40, f32::MAX];
        places.iter_mut().step_by(3).zip(odd.into_iter().cycle()).for_each(|(p, x)| p[1] = x);
        let wide: Vec<_> = places.iter().map(|place| place.map(|x| f64::from(x) / 3.0)).collect();
        let corners: [[u32; POLYGONS]; N] = [[(); POLYGONS]; N].map(|polygons| {
            polygons.map(|()| least + ((count - least) as f32 * chance(&mut state).abs()) as u32)
        });
        for &level in Level::available() {
            let mut gathered = [Polygons::<N>::default(), Polygons::<N>::default()];
            gathered[0].gather_at(level, &corners, (&places, &normals));
            gathered[1].gather_at(level, &corners, (&wide, &normals));
            for (n, corner, k) in (0..POLYGONS)
                .flat_map(|n| (0..N).flat_map(move |corner| (0..3).map(move |k| (n, corner, k))))
            {
                let [vertex, first] = [corners[corner][n], corners[0][n]].map(|v| v as usize);
                let away = places[vertex][k] - places[first][k];
                let wide_away = (wide[vertex][k] - wide[first][k]) as f32;
                for (polygons, away) in gathered.iter().zip([away, wide_away]) {
                    let found = [&polygons.places, &polygons.normals].map(|all| all[corner][k][n]);
                    for (found, expected) in found.into_iter().zip([away, normals[vertex][k]]) {
                        let is_same = found.to_bits() == expected.to_bits();
                        assert!(is_same || (found.is_nan() && expected.is_nan()), "{level}");
                    }
                }
            }
        }
    }
}

#[test]
fn corners_are_gathered_from_the_vertices_of_their_numbers() {
    check_gathered::<4>();
    check_gathered::<5>();
    check_gathered::<6>();
    check_gathered::<CORNERS>();
}

#[test]
#[should_panic(expected = "out of bounds")]
fn a_number_of_no_vertex_is_no_corner() {
    let vertices = [[0.0_f32; 3]; 5];
    Polygons::<4>::default().gather(&[[5; POLYGONS]; 4], (&vertices, &vertices));
}

#[test]
fn diagonals_triples_and_ways_are_as_many_as_there_are() {
    assert_eq!(ways::<CORNERS>().len(), WAYS);
    let last = |[a, b]: [usize; 2]| b > a + 1;
    assert!(diagonals::<CORNERS>().into_iter().all(last) && DIAGONALS == 14);
    assert_eq!(triples::<CORNERS>()[TRIPLES - 1], [4, 5, 6]);
    assert_eq!(
        (diagonals::<4>()[..2].to_vec(), triples::<4>()[3]),
        (vec![[0, 2], [1, 3]], [1, 2, 3])
    );
}

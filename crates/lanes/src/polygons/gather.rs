//! Places and normals of corners, from where the vertices of a surface are, side by side.

use super::{POLYGONS, Polygons};
use crate::{Coordinate, Level};
#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::*;

impl<const N: usize> Polygons<N> {
    /// Takes over the vertices that are the corners of each polygon, whose numbers are given corner by corner.
    ///
    /// # Panics
    ///
    /// If there is no place or no normal of such a number.
    pub fn gather<C: Coordinate>(
        &mut self,
        corners: &[[u32; POLYGONS]; N],
        (places, normals): (&[[C; 3]], &[[f32; 3]]),
    ) {
        self.gather_at(Level::current(), corners, (places, normals));
    }

    pub(super) fn gather_at<C: Coordinate>(
        &mut self,
        level: Level,
        corners: &[[u32; POLYGONS]; N],
        (places, normals): (&[[C; 3]], &[[f32; 3]]),
    ) {
        match (level, C::as_f32(places)) {
            #[cfg(target_arch = "x86_64")]
            (Level::Avx512 | Level::Avx2, Some(places)) => {
                level.assert_available();
                // SAFETY: the machine has the level, asserted above, and with it what the lower one has; the function asks
                // nothing else.
                if unsafe { self.gather_by_four(corners, (places, normals)) } {
                    return;
                }
            }
            _ => {}
        }
        for (corner, vertices) in corners.iter().enumerate() {
            for (n, &vertex) in vertices.iter().enumerate() {
                let origin = places[corners[0][n] as usize];
                let (place, normal) = (places[vertex as usize], normals[vertex as usize]);
                for k in 0..3 {
                    self.places[corner][k][n] = place[k].offset_from(origin[k]);
                    self.normals[corner][k][n] = normal[k];
                }
            }
        }
    }

    /// Four polygons at a time: a load has the three numbers of a vertex and the next one's first, and four of them are
    /// transposed. Returns false, and does nothing, where a corner is the last vertex of all, or is not there.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn gather_by_four(
        &mut self,
        corners: &[[u32; POLYGONS]; N],
        (places, normals): (&[[f32; 3]], &[[f32; 3]]),
    ) -> bool {
        let greatest = corners.as_flattened().iter().fold(0, |most, &n| n.max(most));
        if greatest as usize + 1 >= places.len().min(normals.len()) {
            return false;
        }
        for group in 0..POLYGONS / 4 {
            let mut origin = [_mm_setzero_ps(); 3];
            for (corner, vertices) in corners.iter().enumerate() {
                let numbers = vertices.as_chunks::<4>().0[group];
                let of = |list: &[[f32; 3]]| {
                    let load = |n: u32| {
                        // SAFETY: four numbers from where a vertex begins are its own and of the next, which is there too,
                        // as was seen above. The load needs no alignment.
                        unsafe { _mm_loadu_ps(list.as_ptr().add(n as usize).cast()) }
                    };
                    transposed(numbers.map(load))
                };
                let (place, normal) = (of(places), of(normals));
                if corner == 0 {
                    origin = place;
                }
                for k in 0..3 {
                    let away = _mm_sub_ps(place[k], origin[k]);
                    for (list, numbers) in
                        [(&mut self.places, away), (&mut self.normals, normal[k])]
                    {
                        let room = &mut list[corner][k].as_chunks_mut::<4>().0[group];
                        // SAFETY: four numbers fill the register; the store needs no alignment.
                        unsafe { _mm_storeu_ps(room.as_mut_ptr(), numbers) };
                    }
                }
            }
        }
        true
    }
}

/// The first three numbers of each, side by side.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
#[inline]
fn transposed([a, b, c, d]: [__m128; 4]) -> [__m128; 3] {
    let (low, high) = (_mm_unpacklo_ps(a, b), _mm_unpacklo_ps(c, d));
    let last = (_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d));
    [_mm_movelh_ps(low, high), _mm_movehl_ps(high, low), _mm_movelh_ps(last.0, last.1)]
}

//! What a ray gathers: colours one behind the other, front to back.
//!
//! Each thing on the way emits a colour C and hides what is behind it by its opacity α. With colours
//! multiplied by their opacity (Porter & Duff 1984, "Compositing digital images"; Levoy 1988, "Display of
//! surfaces from volume data"), what comes next adds as much as is not yet hidden:
//!
//! C′ ← C′ + (1 − α) C′ᵢ and α ← α + (1 − α) αᵢ.
//!
//! Colours are linear light; what is written to a file is encoded in the end (`image.rs`).

/// A colour in linear light multiplied by its opacity, each from 0 to 1; brighter only in light that particles scatter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gathered {
    /// Red, green and blue, times the opacity.
    pub color: [f32; 3],
    /// How much of what is behind it is hidden.
    pub opacity: f32,
}

/// With so much opacity nothing behind is looked at: 8 bits show nothing of it, in the dark either.
pub(crate) const OPAQUE: f32 = 1.0 - 1.0 / 8192.0;

impl Gathered {
    /// Nothing: what is behind shows.
    pub const NOTHING: Self = Self { color: [0.0; 3], opacity: 0.0 };

    /// A colour that is not multiplied yet, and its opacity.
    #[inline(always)]
    pub fn new(color: [f32; 3], opacity: f32) -> Self {
        Self { color: color.map(|part| part * opacity), opacity }
    }

    /// This before what lies `behind` it.
    #[inline(always)]
    #[must_use]
    pub fn over(self, behind: Self) -> Self {
        let open = 1.0 - self.opacity;
        Self {
            color: std::array::from_fn(|n| self.color[n] + open * behind.color[n]),
            opacity: self.opacity + open * behind.opacity,
        }
    }

    /// So many times as much of the same.
    #[inline]
    #[must_use]
    pub(crate) fn stretched(self, times: f64) -> Self {
        if times == 1.0 || self.opacity <= 0.0 {
            return self;
        }
        let opacity = opacity_over(self.opacity.into(), times) as f32;
        let color = self.color.map(|part| part / self.opacity * opacity);
        Self { color, opacity }
    }

    /// This under a light, of which a surface has a share of its colour and a share of white.
    #[inline(always)]
    #[must_use]
    pub(crate) fn lit(self, [matt, gloss]: [f32; 2]) -> Self {
        let white = self.opacity * gloss;
        let part = |part: f32| (part * matt + white).min(self.opacity);
        Self { color: self.color.map(part), opacity: self.opacity }
    }

    /// This in so much light.
    #[inline(always)]
    #[must_use]
    pub(crate) fn dimmed(self, share: f32) -> Self {
        Self { color: self.color.map(|part| part * share), ..self }
    }

    /// The most by which a part of the colour, or the opacity, differs.
    pub(crate) fn differs(self, other: Self) -> f32 {
        let parts = |g: Self| [g.color[0], g.color[1], g.color[2], g.opacity];
        let pairs = parts(self).into_iter().zip(parts(other));
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    /// Both, side by side: for a mean.
    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        let color = std::array::from_fn(|n| self.color[n] + other.color[n]);
        Self { color, opacity: self.opacity + other.opacity }
    }

    /// A share of it.
    #[inline(always)]
    pub(crate) fn times(self, share: f32) -> Self {
        Self { color: self.color.map(|part| part * share), opacity: self.opacity * share }
    }

    /// The colour without its opacity; black where nothing was gathered.
    pub fn straight(self) -> [f32; 3] {
        match self.opacity > 0.0 {
            true => self.color.map(|part| part / self.opacity),
            false => [0.0; 3],
        }
    }
}

/// The opacity that is gathered over `share` of a reference length, where over the whole of it `opacity` is:
/// 1 − (1 − a)^share.
///
/// So a slab of one substance gathers the same in any number of steps.
pub fn opacity_over(opacity: f64, share: f64) -> f64 {
    -(share * (-opacity).ln_1p()).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::{Gathered, opacity_over};

    /// Three voxels from front to back.
    fn voxels() -> [Gathered; 3] {
        let of = |[r, g, b, a]: [f32; 4]| Gathered::new([r, g, b], a);
        [of([0.3, 0.1, 0.1, 0.2]), of([0.1, 0.3, 0.1, 0.3]), of([0.1, 0.3, 0.1, 0.3])]
    }

    #[track_caller]
    fn assert_near(found: Gathered, [r, g, b, a]: [f64; 4]) {
        let [x, y, z] = found.color;
        for (found, expected) in [x, y, z, found.opacity].into_iter().zip([r, g, b, a]) {
            assert!((f64::from(found) - expected).abs() <= 1e-7, "{found} for {expected}");
        }
    }

    #[test]
    fn three_voxels_gather_what_is_worked_out_by_hand() {
        let [first, second, third] = voxels();
        assert_near(Gathered::NOTHING.over(first), [0.06, 0.02, 0.02, 0.2]);
        assert_near(first.over(second), [0.084, 0.092, 0.044, 0.44]);
        let all = first.over(second).over(third);
        assert_near(all, [0.1008, 0.1424, 0.0608, 0.608]);
        let straight = Gathered { color: all.straight(), opacity: all.opacity };
        assert_near(straight, [0.1008 / 0.608, 0.1424 / 0.608, 0.1, 0.608]);
    }

    #[test]
    fn back_to_front_is_front_to_back() {
        let [first, second, third] = voxels();
        assert_near(first.over(second.over(third)), [0.1008, 0.1424, 0.0608, 0.608]);
    }

    #[test]
    fn nothing_is_black_and_what_is_opaque_hides_all() {
        assert_eq!(Gathered::NOTHING.straight(), [0.0; 3]);
        let wall = Gathered::new([0.5, 0.25, 1.0], 1.0);
        assert_eq!(wall.over(voxels()[0]), wall);
        assert_eq!(Gathered::NOTHING.over(wall), wall);
    }

    #[test]
    fn a_slab_gathers_the_same_in_any_number_of_steps() {
        for opacity in [0.0, 1e-9, 0.02, 0.5, 0.999, 1.0] {
            for length in [0.3, 1.0, 7.5] {
                let whole = 1.0 - (1.0_f64 - opacity).powf(length);
                for steps in [1, 2, 10, 1000] {
                    let step = opacity_over(opacity, length / f64::from(steps));
                    let open = (0..steps).fold(1.0, |open, _| open * (1.0 - step));
                    assert!((1.0 - open - whole).abs() < 1e-12, "{opacity}, {length}, {steps}");
                }
            }
        }
    }
}

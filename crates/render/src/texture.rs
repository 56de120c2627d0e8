//! Solid textures: colours that fill space, and show wherever a surface goes through them (Peachey 1985, "Solid texturing
//! of complex surfaces"; Perlin 1985, "An image synthesizer").

use isokit_geom::vector::Vector;
use noise::{NoiseFn, Perlin};
use std::sync::LazyLock;

/// A pattern of two colours that fills the world.
///
/// # Guarantees
///
/// Its size is above 0 and finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolidTexture {
    pattern: Pattern,
    colors: [[f32; 3]; 2],
    size: f64,
}

/// How two colours change by turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pattern {
    /// Cubes of one colour and of the other; their edges are as long as the size.
    Checker,
    /// Layers across x that are stirred up; as far apart as the size.
    Marble,
    /// Rings around z, not quite round; as far apart as the size.
    Wood,
    /// Grains about as large as the size.
    Granite,
}

/// Why there is no such texture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a texture has a size above 0, found {0}")]
pub struct TextureError(f64);

/// The same noise in every picture.
static NOISE: LazyLock<Perlin> = LazyLock::new(|| Perlin::new(1985));

impl SolidTexture {
    /// A pattern of two colours in linear light, so large in the world.
    ///
    /// # Errors
    ///
    /// If the size is not above 0.
    pub fn new(pattern: Pattern, colors: [[f32; 3]; 2], size: f64) -> Result<Self, TextureError> {
        if !(size > 0.0 && size.is_finite()) {
            return Err(TextureError(size));
        }
        Ok(Self { pattern, colors, size })
    }

    /// The colour at a place of the world.
    pub fn at(&self, place: Vector) -> [f32; 3] {
        let [x, y, z] = place.map(|c| c / self.size);
        // Beyond that noise has no cells left; a place that is no number is anywhere.
        let [x, y, z] = [x, y, z].map(|c| if c.abs() < 1e9 { c } else { 0.0 });
        let share = match self.pattern {
            Pattern::Checker => {
                let cubes = x.floor() + y.floor() + z.floor();
                if cubes.rem_euclid(2.0) < 1.0 { 0.0 } else { 1.0 }
            }
            Pattern::Marble => {
                let stirred = x + 1.2 * turbulence([x, y, z]);
                // Veins are thin.
                (0.5 + 0.5 * (stirred * std::f64::consts::TAU).sin()).powi(3)
            }
            Pattern::Wood => {
                let wavers = 0.25 * NOISE.get([0.6 * x, 0.6 * y, 0.15 * z]);
                let ring = ((x * x + y * y).sqrt() + wavers).rem_euclid(1.0);
                // Early wood grows slowly darker, and late wood ends soon.
                let late = 0.85;
                if ring < late { (ring / late).powi(2) } else { (1.0 - ring) / (1.0 - late) }
            }
            Pattern::Granite => turbulence([2.0 * x, 2.0 * y, 2.0 * z]).min(1.0),
        } as f32;
        let [a, b] = self.colors;
        std::array::from_fn(|n| a[n] * (1.0 - share) + b[n] * share)
    }
}

/// Noise of several sizes, folded (Perlin 1985): from 0 on, and seldom above 1.
fn turbulence(place: Vector) -> f64 {
    let octave = |n: i32| {
        let fine = 2.0_f64.powi(n);
        NOISE.get(place.map(|c| c * fine)).abs() / fine
    };
    (0..5).map(octave).sum()
}

#[cfg(test)]
mod tests {
    use super::{Pattern, SolidTexture};

    const COLORS: [[f32; 3]; 2] = [[0.1, 0.5, 0.9], [0.8, 0.2, 0.3]];
    const ALL: [Pattern; 4] = [Pattern::Checker, Pattern::Marble, Pattern::Wood, Pattern::Granite];

    #[test]
    fn cubes_of_a_checker_change_by_turns() {
        let checker = SolidTexture::new(Pattern::Checker, COLORS, 2.0).unwrap();
        for n in 0..1000_u32 {
            let cube = [n % 10, n / 10 % 10, n / 100].map(|c| f64::from(c) - 5.0);
            let found = checker.at(cube.map(|c| 2.0 * c + 0.7));
            assert_eq!(
                found,
                COLORS[usize::from(cube.iter().sum::<f64>() % 2.0 != 0.0)],
                "{cube:?}"
            );
        }
    }

    #[test]
    fn a_texture_is_between_its_colours_and_shows_both() {
        for pattern in ALL {
            let texture = SolidTexture::new(pattern, COLORS, 3.0).unwrap();
            let (mut least, mut greatest) = (1.0_f32, 0.0_f32);
            for n in 0..20_000 {
                let place = [n % 27, n / 27 % 28, n / 756].map(|c| 0.37 * f64::from(c) - 3.0);
                let [r, ..] = texture.at(place);
                (least, greatest) = (least.min(r), greatest.max(r));
            }
            assert!(least >= 0.0999 && greatest <= 0.8001, "{pattern:?}: {least} to {greatest}");
            assert!(least < 0.2 && greatest > 0.6, "{pattern:?}: {least} to {greatest}");
        }
    }

    #[test]
    fn a_texture_is_as_large_as_it_is_said_to_be() {
        for pattern in ALL {
            let of = |size| SolidTexture::new(pattern, COLORS, size).unwrap();
            for place in [[0.3, -0.6, 1.4], [5.25, 2.5, -7.0]] {
                let twice = place.map(|c| 2.0 * c);
                assert_eq!(of(1.5).at(place), of(3.0).at(twice), "{pattern:?}");
            }
            let finite = of(1.0).at([f64::INFINITY, f64::NAN, 1e300]);
            assert!(finite.iter().all(|part| part.is_finite()), "{pattern:?}");
        }
        assert!(SolidTexture::new(Pattern::Wood, COLORS, 0.0).is_err());
    }
}

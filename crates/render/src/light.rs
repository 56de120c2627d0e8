//! How a surface answers light: ambient, diffuse and specular parts (Blinn 1977, "Models of light reflection for
//! computer synthesized pictures"), both sides alike.

use isokit_geom::vector::{Vector, dot};

/// A light at the camera, and how matt or glossy everything is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// The share of its colour that everything has without light. All three shares are 0 or more.
    pub ambient: f32,
    /// The share that it has in addition where it faces the light.
    pub diffuse: f32,
    /// The white that it has in addition where it mirrors the light.
    pub specular: f32,
    /// How small that highlight is.
    pub shininess: u16,
}

impl Light {
    /// What shows shape without burning out: 0.25, 0.75, 0.15, and highlights of exponent 32.
    pub const DEFAULT: Self = Self { ambient: 0.25, diffuse: 0.75, specular: 0.15, shininess: 32 };

    /// A colour in linear light, not multiplied by an opacity, under the light: on a surface across `normal`, seen
    /// along `towards`, both of any length above 0. A surface without a normal keeps its colour.
    #[inline(always)]
    pub fn shade(&self, color: [f32; 3], normal: Vector, towards: Vector) -> [f32; 3] {
        let [matt, gloss] = self.answer(normal, towards);
        color.map(|part| (part * matt + gloss).min(1.0))
    }

    /// What share of its colour a surface has under the light, and how much white in addition.
    #[inline(always)]
    pub(crate) fn answer(&self, normal: Vector, towards: Vector) -> [f32; 2] {
        let square = dot(normal, normal) * dot(towards, towards);
        if !(square > 0.0 && square.is_finite()) {
            return [1.0, 0.0];
        }
        let cosine = (dot(normal, towards) / square.sqrt()).abs().min(1.0) as f32;
        self.shares([cosine]).map(|[share]| share)
    }

    /// The same for many surfaces, by the cosines, from 0 to 1, between their normals and where they are seen from.
    #[inline(always)]
    pub(crate) fn shares<const N: usize>(&self, cosines: [f32; N]) -> [[f32; N]; 2] {
        // The light is where the eye is: so is the half vector of the highlight. Its power by squares.
        let (mut gloss, mut power, mut left) = ([self.specular; N], cosines, self.shininess);
        while left != 0 {
            for n in 0..N {
                gloss[n] *= if left & 1 == 1 { power[n] } else { 1.0 };
                power[n] *= power[n];
            }
            left >>= 1;
        }
        [cosines.map(|cosine| self.ambient + self.diffuse * cosine), gloss]
    }
}

impl Default for Light {
    fn default() -> Self {
        Self::DEFAULT
    }
}

#[cfg(test)]
mod tests {
    use super::Light;

    #[test]
    fn what_faces_the_light_is_brightest_from_either_side() {
        let (light, color) = (Light { specular: 0.0, ..Light::DEFAULT }, [0.5, 0.2, 0.0]);
        let towards = [0.0, 0.0, -3.0];
        for normal in [[0.0, 0.0, 1e-9], [0.0, 0.0, -40.0]] {
            assert_eq!(light.shade(color, normal, towards), color);
        }
        let aside = light.shade(color, [1.0, 0.0, 0.0], towards);
        assert_eq!(aside, color.map(|part| part * light.ambient));
        let slanted = light.shade(color, [1.0, 0.0, 1.0], towards);
        assert!((slanted[0] - 0.5 * (0.25 + 0.75 * 0.5_f32.sqrt())).abs() < 1e-6);
    }

    #[test]
    fn without_a_normal_there_is_the_colour_alone() {
        let color = [0.5, 0.2, 0.0];
        for normal in [[0.0; 3], [f64::NAN, 0.0, 1.0], [f64::MAX; 3]] {
            assert_eq!(Light::DEFAULT.shade(color, normal, [0.0, 0.0, 1.0]), color);
        }
    }

    #[test]
    fn a_highlight_is_white_and_small() {
        let light = Light { ambient: 0.0, diffuse: 0.0, ..Light::DEFAULT };
        let at = |slope: f64| light.shade([0.0; 3], [slope, 0.0, 1.0], [0.0, 0.0, 1.0]);
        assert_eq!(at(0.0), [light.specular; 3]);
        assert!(at(0.5)[0] < 0.1 * light.specular);
    }
}

//! Mixtures of materials (Drebin, Carpenter & Hanrahan 1988, "Volume rendering").
//!
//! Each material is pure from one value to another, and between two of them a place is a mixture: of each a share, and
//! all shares together are 1. A mixture gives off and hides light in the measure of its shares. Where its density
//! changes there is a surface, across the gradient of the density, and stronger the more the density changes: a ray
//! that goes through it from one pure material to the next gathers its opacity, however thick the zone between them.
//! In each step a surface lies in the middle, between two halves of the mixture.

use super::{ControlPoint, TransferFunction};

/// A material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// From which value to which a place is made of nothing else. The first material is so from −∞ on, and the last
    /// up to +∞, whatever is said.
    pub values: [f64; 2],
    /// Its colour in linear light, not multiplied by its opacity.
    pub color: [f32; 3],
    /// What a ray gathers of it over the reference length, from 0 to 1.
    pub opacity: f32,
    /// How dense it is: 0 or more.
    pub density: f64,
}

/// Materials that fill a volume.
///
/// # Guarantees
///
/// There is one or more, their values rise, and between two of them there is room.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    materials: Vec<Material>,
    surface: f32,
    substance: TransferFunction,
}

/// Why materials are no mixture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MixtureError {
    /// There is none.
    #[error("a mixture is of one material at least")]
    Empty,
    /// A number is out of its range.
    #[error(
        "material {number} is pure from {} to {}: expected two values that do not fall, within 1e37, above those of \
         the material before, with room between them to mix", .values[0], .values[1]
    )]
    Values {
        /// Counted from 1.
        number: usize,
        /// Where it is pure.
        values: [f64; 2],
    },
    /// A colour, opacity or density is out of its range.
    #[error(
        "material {number}: expected colours and an opacity from 0 to 1, and a density from 0 to 1e6"
    )]
    Range {
        /// Counted from 1.
        number: usize,
    },
    /// The opacity of surfaces is out of its range.
    #[error("surfaces of materials have an opacity from 0 to 1, found {0}")]
    Surface(f32),
}

impl Mixture {
    /// The mixture of materials in the order of their values, where the surface between two whose densities differ by 1
    /// hides `surface` of what is behind it.
    ///
    /// # Errors
    ///
    /// If there is no material, or a number is out of its range.
    pub fn new(materials: Vec<Material>, surface: f32) -> Result<Self, MixtureError> {
        let mut end = f64::NEG_INFINITY;
        for (number, material) in (1..).zip(&materials) {
            let [low, high] = material.values;
            if !(low > end && low <= high && low >= -1e37 && high <= 1e37) {
                return Err(MixtureError::Values { number, values: material.values });
            }
            let mut shares = material.color.iter().chain([&material.opacity]);
            let are_shares = shares.all(|share| (0.0..=1.0).contains(share));
            if !(are_shares && (0.0..=1e6).contains(&material.density)) {
                return Err(MixtureError::Range { number });
            }
            end = high;
        }
        if !(0.0..=1.0).contains(&surface) {
            return Err(MixtureError::Surface(surface));
        }
        let points = materials.iter().flat_map(|material| {
            let Material { values, color, opacity, .. } = *material;
            values.map(|value| ControlPoint { value, color, opacity })
        });
        let substance = TransferFunction::new(points.collect()).map_err(|_| MixtureError::Empty)?;
        Ok(Self { substance: substance.weighted(), materials, surface })
    }

    /// The materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// What surfaces hide between materials whose densities differ by 1.
    pub fn surface(&self) -> f32 {
        self.surface
    }

    /// The shares of the materials in a place of a value: none below 0, and together 1.
    pub fn shares(&self, value: f64) -> impl Iterator<Item = f64> {
        let (low, share) = self.place(value);
        (0..self.materials.len()).map(move |n| match n {
            n if n == low => 1.0 - share,
            n if n == low + 1 => share,
            _ => 0.0,
        })
    }

    /// What is seen of a value, but for surfaces.
    pub fn substance(&self) -> &TransferFunction {
        &self.substance
    }

    /// How much the density changes with the value, without sign.
    pub fn change(&self, value: f64) -> f64 {
        let (low, _) = self.place(value);
        match self.materials.get(low..low + 2) {
            Some([a, b]) if value >= a.values[1] && value < b.values[0] => {
                ((b.density - a.density) / (b.values[0] - a.values[1])).abs()
            }
            _ => 0.0,
        }
    }

    /// The colour of a surface at a value: those of the materials in the measure of their shares and densities.
    pub fn surface_color(&self, value: f64) -> [f32; 3] {
        let weights = self.shares(value).zip(&self.materials);
        let (mut sum, mut all) = ([0.0; 3], 0.0);
        for (share, material) in weights {
            let weight = share * material.density;
            all += weight;
            for (sum, part) in sum.iter_mut().zip(material.color) {
                *sum += weight * f64::from(part);
            }
        }
        if all > 0.0 { sum.map(|part| (part / all) as f32) } else { [0.0; 3] }
    }

    /// What is hidden by surfaces where the density changes so much with the value, and the value so much per length,
    /// over such a length.
    #[inline]
    pub fn surface_opacity(&self, change: f64, slope: f64, length: f64) -> f32 {
        let over = change * slope * length;
        let hides = over > 0.0 && self.surface > 0.0;
        if hides { crate::opacity_over(self.surface.into(), over) as f32 } else { 0.0 }
    }

    pub(super) fn shows_any(&self, [least, greatest]: [f64; 2]) -> bool {
        let mut pairs = self.materials.windows(2);
        let has_surface = self.surface > 0.0
            && pairs.any(|pair| {
                let [low, high] = [pair[0].values[1], pair[1].values[0]];
                pair[0].density != pair[1].density && low <= greatest && high >= least
            });
        has_surface || self.substance.shows_any([least, greatest])
    }

    /// The last material that begins at a value or below, or else the first, and the share of the next.
    fn place(&self, value: f64) -> (usize, f64) {
        let begun = self.materials.partition_point(|material| material.values[0] <= value);
        let low = begun.saturating_sub(1);
        let share = self.materials.get(low + 1).map_or(0.0, |next| {
            let from = self.materials[low].values[1];
            ((value - from) / (next.values[0] - from)).clamp(0.0, 1.0)
        });
        (low, share)
    }
}

#[cfg(test)]
mod tests {
    use super::{Material, Mixture, MixtureError};

    fn material(values: [f64; 2], shade: f32, opacity: f32, density: f64) -> Material {
        Material { values, color: [shade; 3], opacity, density }
    }

    /// Air, fat and bone.
    fn body() -> [Material; 3] {
        [
            material([-1000.0, -500.0], 0.0, 0.0, 0.0),
            material([-100.0, 100.0], 0.5, 0.25, 1.0),
            material([300.0, 300.0], 1.0, 0.75, 3.0),
        ]
    }

    #[test]
    fn shares_are_none_below_nothing_and_together_one() {
        let body = Mixture::new(body().into(), 0.5).unwrap();
        for n in -400..400 {
            let value = f64::from(n) * 4.0;
            let shares: Vec<f64> = body.shares(value).collect();
            assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{value}: {shares:?}");
            assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{value}: {shares:?}");
        }
        let expect = |value, shares: [f64; 3]| assert!(body.shares(value).eq(shares), "{value}");
        expect(-3000.0, [1.0, 0.0, 0.0]);
        expect(-300.0, [0.5, 0.5, 0.0]);
        expect(0.0, [0.0, 1.0, 0.0]);
        expect(250.0, [0.0, 0.25, 0.75]);
        expect(9000.0, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_mixture_looks_like_its_materials_in_the_measure_of_their_shares() {
        let body = Mixture::new(body().into(), 0.5).unwrap();
        let found = body.substance().at(200.0);
        assert!((found.opacity - 0.5).abs() < 1e-6);
        // Half of 0.5 at 0.25, half of 1 at 0.75.
        assert!((found.color[0] * found.opacity - 0.4375).abs() < 1e-6, "{found:?}");
        // Air has no colour.
        assert_eq!(body.substance().at(-300.0).color[0], 0.5);
        assert_eq!(body.surface_color(-300.0), [0.5; 3]);
        assert_eq!(body.surface_color(200.0), [0.875; 3]);
    }

    #[test]
    fn a_pure_material_has_no_surface_and_a_zone_between_two_gathers_one() {
        let body = Mixture::new(body().into(), 0.25).unwrap();
        assert_eq!([-800.0, 0.0, 400.0].map(|value| body.change(value)), [0.0; 3]);
        for (slope, steps) in [(40.0, 1000), (400.0, 100)] {
            // A ramp from air to fat in steps of 0.01.
            let open = (0..steps).map(|n| -500.0 + 0.01 * slope * (f64::from(n) + 0.5));
            let open =
                open.map(|v| 1.0 - f64::from(body.surface_opacity(body.change(v), slope, 0.01)));
            assert!((1.0 - open.product::<f64>() - 0.25).abs() < 1e-4);
        }
        assert!(body.shows_any([-400.0, -400.0]) && !body.shows_any([-900.0, -600.0]));
    }

    #[test]
    fn what_hides_is_a_share_however_narrow_a_zone() {
        let values = [[0.0, 1.0], [1.0_f64.next_up(), 2.0]];
        let materials = values.map(|values| material(values, 0.5, 0.0, 4e5 * values[1]));
        for surface in [0.0, 0.5, 1.0] {
            let thin = Mixture::new(materials.into(), surface).unwrap();
            let change = thin.change(1.0);
            for slope in [0.0, 1.0, 1e300, f64::INFINITY] {
                let found = thin.surface_opacity(change, slope, 1e3);
                assert!((0.0..=1.0).contains(&found), "{surface}, {slope}: {found}");
                assert!(surface > 0.0 || found == 0.0);
            }
        }
    }

    #[test]
    fn materials_that_are_no_mixture_are_refused_by_number() {
        let new = |change: fn(&mut [Material; 3])| {
            let mut all = body();
            change(&mut all);
            Mixture::new(all.into(), 0.5).unwrap_err()
        };
        assert_eq!(Mixture::new(vec![], 0.5).unwrap_err(), MixtureError::Empty);
        assert_eq!(Mixture::new(body().into(), 2.0).unwrap_err(), MixtureError::Surface(2.0));
        let touching = new(|all| all[1].values = [-500.0, 0.0]);
        let falling = new(|all| all[1].values = [100.0, -100.0]);
        for found in [touching, falling] {
            assert!(matches!(found, MixtureError::Values { number: 2, .. }), "{found}");
        }
        assert_eq!(new(|all| all[2].density = -1.0), MixtureError::Range { number: 3 });
        assert_eq!(new(|all| all[0].opacity = f32::NAN), MixtureError::Range { number: 1 });
    }
}

//! What is seen where a plane cuts.

use super::{CapStyle, Clip, Scene, SceneError, SurfaceLook};
use isokit_geom::vector::Vector;
use isokit_render::{Cap, Gathered};

type Look<'a> = Box<dyn Fn(Vector) -> Gathered + Sync + 'a>;

/// The caps of a scene.
pub(super) struct Caps<'a>(Vec<(&'a Clip, Look<'a>)>);

impl<'a> Caps<'a> {
    /// `value` is that of a place; none beyond the scan and where it has no number.
    pub(super) fn new(
        scene: &'a Scene,
        value: &'a (dyn Fn(Vector) -> Option<f64> + Sync),
    ) -> Result<Self, SceneError> {
        let mut caps = vec![];
        for clip in &scene.clips {
            let surfaces: Vec<&SurfaceLook> =
                scene.surfaces.iter().filter(|look| clip.cuts(&look.name)).collect();
            // The innermost surface around a place, if the other planes have left it there.
            let innermost = move |place: Vector, value: f64| {
                let is_around = |look: &&&SurfaceLook| {
                    let others = scene.clips_of(look).filter(|other| *other != clip);
                    look.opacity > 0.0
                        && look.iso.is_some_and(|iso| value >= iso)
                        && others.into_iter().all(|other| other.half.keeps(place))
                };
                let around = surfaces.iter().filter(is_around);
                around
                    .max_by(|a, b| a.iso.partial_cmp(&b.iso).unwrap_or(std::cmp::Ordering::Equal))
                    .copied()
            };
            let look: Look<'a> = match clip.cap {
                CapStyle::None => continue,
                CapStyle::Solid => Box::new(move |place| {
                    let surface = value(place).and_then(|value| innermost(place, value));
                    surface
                        .map_or(Gathered::NOTHING, |look| Gathered::new(look.color_at(place), 1.0))
                }),
                CapStyle::Slice => {
                    let model = scene.model.as_ref().ok_or(SceneError::NoTransfer)?;
                    Box::new(move |place| {
                        let found = value(place);
                        let found = found.filter(|&value| innermost(place, value).is_some());
                        found.map_or(Gathered::NOTHING, |value| {
                            Gathered::new(model.at(value).color, 1.0)
                        })
                    })
                }
            };
            caps.push((clip, look));
        }
        Ok(Self(caps))
    }

    pub(super) fn all(&self) -> Vec<Cap<'_>> {
        self.0.iter().map(|(clip, look)| Cap { half: clip.half, look }).collect()
    }
}

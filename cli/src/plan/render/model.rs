//! What values look like, and how gradients are lit.

use crate::{
    fault::UsageError,
    scene_file::{
        Color, Fade, KernelWord, LightTable, MaterialTable, ModeWord, PeakTable, PresetWord,
        RowTable, SamplingTable, SceneFile, ShadingWord, TransferTable,
    },
};
use isokit::{
    render::{
        ControlPoint, Kernel, Light, Material, Mixture, Peak, RasterOptions, RaycastOptions,
        Scatter, SlopeFunction, TransferFunction,
    },
    scene::Preset,
};

/// What values look like.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ModelPlan {
    Points(TransferFunction, Option<FadePlan>),
    Preset(Preset, Option<FadePlan>),
    Rows(SlopeFunction),
    Mixture(Mixture),
}

/// How steep what does not fade is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FadePlan {
    /// As the borders of what is seen.
    Auto,
    Slope(f64),
}

/// What a surface between materials hides without other words.
const SURFACE: f32 = 0.8;

pub(super) fn of(
    typed: Option<PresetWord>,
    file: &SceneFile,
    mode: ModeWord,
) -> Result<ModelPlan, UsageError> {
    let table = file.transfer.clone().unwrap_or_default();
    let is_mixture = file.light.shading == ShadingWord::Mixture;
    let refuse = |says: &str| Err(UsageError(says.into()));
    if file.light.surface.is_some() && !is_mixture {
        return refuse("[light] surface: that of materials, for shading = \"mixture\"");
    }
    if is_mixture {
        if !mode.shows_values() {
            return refuse("[light]: a mixture is of values: add mode = \"raycast\" or \"splat\"");
        }
        if typed.is_some() || (TransferTable { unit: None, ..table }) != TransferTable::default() {
            return refuse(
                "a mixture looks like its materials: leave out presets, points, peaks, rows and gradient",
            );
        }
        return mixture(&file.material, file.light.surface.unwrap_or(SURFACE));
    }
    if !file.material.is_empty() {
        return refuse("[[material]]: materials are seen with [light] shading = \"mixture\"");
    }
    let fade = match table.gradient {
        None | Some(Fade::Word(false)) => None,
        Some(Fade::Word(true)) => Some(FadePlan::Auto),
        Some(Fade::Slope(slope)) if slope > 0.0 && slope < 1e37 => Some(FadePlan::Slope(slope)),
        Some(Fade::Slope(slope)) => {
            let says = format!("[transfer] gradient: expected a slope above 0, found {slope}");
            return Err(UsageError(says));
        }
    };
    let TransferTable { points, peaks, preset, rows, .. } = &table;
    let named = [points.is_some(), peaks.is_some(), preset.is_some(), rows.is_some()];
    if named.iter().filter(|is_there| **is_there).count() > 1 {
        return refuse("[transfer]: expected points, peaks, a preset or rows, found several");
    }
    match (typed, points, peaks, rows) {
        (None, Some(points), ..) => {
            Ok(ModelPlan::Points(function(points, "[transfer] points")?, fade))
        }
        (None, _, Some(peaks), _) => Ok(ModelPlan::Points(of_peaks(peaks)?, fade)),
        (None, .., Some(_)) if fade.is_some() => {
            refuse("[transfer]: rows say what slopes look like: leave out gradient")
        }
        (None, .., Some(rows)) => by_slopes(rows),
        _ => {
            let preset = match typed.or(*preset) {
                None | Some(PresetWord::Auto) => Preset::Auto,
                Some(PresetWord::CtBone) => Preset::CtBone,
                Some(PresetWord::CtSkin) => Preset::CtSkin,
                Some(PresetWord::Mr) => Preset::Mr,
                Some(PresetWord::Density) => Preset::Density,
            };
            Ok(ModelPlan::Preset(preset, fade))
        }
    }
}

fn function(points: &[(f64, Color)], place: &str) -> Result<TransferFunction, UsageError> {
    let points = points.iter().map(|&(value, Color(rgba))| ControlPoint::new(value, rgba));
    TransferFunction::new(points.collect()).map_err(|error| UsageError(format!("{place}: {error}")))
}

fn of_peaks(peaks: &[PeakTable]) -> Result<TransferFunction, UsageError> {
    let peaks = peaks.iter().map(|&PeakTable { value, width, color: Color(rgba) }| {
        let [r, g, b, opacity] = rgba.to_linear();
        Peak { value, width, color: [r, g, b], opacity }
    });
    let function = TransferFunction::of_peaks(&peaks.collect::<Vec<_>>());
    function.map_err(|error| UsageError(format!("[transfer] peaks: {error}")))
}

fn by_slopes(rows: &[RowTable]) -> Result<ModelPlan, UsageError> {
    let row = |(n, row): (usize, &RowTable)| {
        let place = format!("[transfer] rows, row {}", n + 1);
        Ok((row.gradient, function(&row.points, &place)?))
    };
    let rows = rows.iter().enumerate().map(row).collect::<Result<_, UsageError>>()?;
    let slopes = SlopeFunction::new(rows);
    slopes.map(ModelPlan::Rows).map_err(|error| UsageError(format!("[transfer] rows: {error}")))
}

/// Without other words the first material is as dense as nothing, and each one more by 1.
fn mixture(tables: &[MaterialTable], surface: f32) -> Result<ModelPlan, UsageError> {
    let material = |(n, table): (usize, &MaterialTable)| {
        let [r, g, b, opacity] = table.color.0.to_linear();
        let density = table.density.unwrap_or(n as f64);
        Material { values: table.values, color: [r, g, b], opacity, density }
    };
    let materials = tables.iter().enumerate().map(material).collect();
    let mixture = Mixture::new(materials, surface);
    mixture.map(ModelPlan::Mixture).map_err(|error| UsageError(format!("[[material]]: {error}")))
}

fn light(table: &LightTable) -> Result<Option<Light>, UsageError> {
    let LightTable { shading, ambient, diffuse, specular, shininess, .. } = table.clone();
    let default = Light::DEFAULT;
    let light = Light {
        ambient: ambient.unwrap_or(default.ambient),
        diffuse: diffuse.unwrap_or(default.diffuse),
        specular: specular.unwrap_or(default.specular),
        shininess: shininess.unwrap_or(default.shininess),
    };
    let shares = [light.ambient, light.diffuse, light.specular];
    if !shares.iter().all(|share| (0.0..=1.0).contains(share)) {
        let says = "[light]: expected ambient, diffuse and specular from 0 to 1, found";
        return Err(UsageError(format!("{says} {shares:?}")));
    }
    let is_lit = shading != ShadingWord::None;
    // Particles that scatter light have some without it.
    let ambient = ambient.filter(|_| table.scatter.is_none());
    let is_said = ambient.or(diffuse).or(specular).is_some() || shininess.is_some();
    if !is_lit && is_said {
        let says =
            "[light]: with shading = \"none\" there is no ambient, diffuse, specular or shininess";
        return Err(UsageError(says.into()));
    }
    Ok(is_lit.then_some(light))
}

/// How values are sampled and lit. Of a mode that was typed what the file says for another is left aside.
pub(super) fn raycast(
    file: &SceneFile,
    model: &ModelPlan,
    (mode, is_typed): (ModeWord, bool),
) -> Result<RaycastOptions, UsageError> {
    let SamplingTable { step, jitter, integrated, error, kernel } = file.sampling;
    let is_sampled = step.is_some() || file.transfer.as_ref().is_some_and(|t| t.unit.is_some());
    if !is_typed && !mode.shows_values() && is_sampled {
        let says = "[sampling] step and [transfer] unit: expected mode = \"raycast\" or \"splat\"";
        return Err(UsageError(says.into()));
    }
    let is_of_steps = jitter || integrated || error.is_some();
    if !is_typed && mode != ModeWord::Raycast && is_of_steps {
        let says = "[sampling] jitter, integrated and error: expected mode = \"raycast\"";
        return Err(UsageError(says.into()));
    }
    let has_rays = matches!(mode, ModeWord::Raycast | ModeWord::IsoRaycast);
    if !is_typed && !has_rays && kernel != KernelWord::Linear {
        let says = "[sampling] kernel: expected mode = \"raycast\" or \"iso-raycast\"";
        return Err(UsageError(says.into()));
    }
    let is_of_values = matches!(model, ModelPlan::Points(_, None) | ModelPlan::Preset(_, None));
    if integrated && !is_of_values {
        let says = "[sampling] integrated: expected a function of values alone, found";
        return Err(UsageError(format!("{says} gradient, rows or materials")));
    }
    if error.is_some_and(|error| !(1e-4..=1.0).contains(&error)) {
        let says = "[sampling] error: expected a share of a colour from 0.0001 to 1";
        return Err(UsageError(says.into()));
    }
    let LightTable { from, scatter, ahead, ambient, .. } = file.light.clone();
    let scatter = match (scatter, from) {
        (None, _) if ahead.is_some() => {
            return Err(UsageError(
                "[light] ahead: of light that is scattered: add scatter".into(),
            ));
        }
        (None, _) => None,
        (Some(_), None) => {
            let says = "[light] scatter: light comes from somewhere: add from = [x, y, z]";
            return Err(UsageError(says.into()));
        }
        (Some(strength), Some(from)) => {
            check_from(Some(from))?;
            let ambient = ambient.unwrap_or(Light::DEFAULT.ambient);
            let ahead = ahead.unwrap_or(0.0);
            if !((0.0..=100.0).contains(&strength) && (-0.99..=0.99).contains(&ahead)) {
                let says =
                    "[light]: expected scatter from 0 to 100 and ahead from -0.99 to 0.99, found";
                return Err(UsageError(format!("{says} {strength} and {ahead}")));
            }
            Some(Scatter { from, strength, ambient, ahead })
        }
    };
    Ok(RaycastOptions::DEFAULT
        .with_light(light(&file.light)?)
        .with_step(step.unwrap_or(RaycastOptions::DEFAULT.step))
        .with_unit(file.transfer.as_ref().and_then(|table| table.unit))
        .with_kernel(match kernel {
            KernelWord::Linear => Kernel::Linear,
            KernelWord::CatmullRom => Kernel::CatmullRom,
        })
        .with_jitter(jitter)
        .with_integrated(integrated)
        .with_error(error)
        .with_scatter(scatter))
}

fn check_from(from: Option<[f64; 3]>) -> Result<(), UsageError> {
    match from {
        Some(from) if from == [0.0; 3] || !from.iter().all(|c| c.is_finite()) => {
            let says =
                "[light] from: expected a direction, three finite numbers of which one is not 0";
            Err(UsageError(says.into()))
        }
        _ => Ok(()),
    }
}

/// How surfaces are lit.
pub(super) fn raster(table: &LightTable, mode: ModeWord) -> Result<RasterOptions, UsageError> {
    let LightTable { shading, from, shadows, occlusion, scatter, ahead, .. } = table.clone();
    let refuse = |says: &str| Err(UsageError(format!("[light] {says}")));
    if mode.shows_values() {
        return match (shadows.is_some() || occlusion.is_some(), from.is_some() && scatter.is_none())
        {
            (true, _) => refuse("shadows and occlusion: expected surfaces, found values"),
            (_, true) => refuse("from: particles of values scatter light: add scatter = 1.0"),
            _ => Ok(RasterOptions::DEFAULT.with_light(light(table)?)),
        };
    }
    if scatter.is_some() || ahead.is_some() {
        return refuse("scatter and ahead: expected values, found surfaces");
    }
    let is_wanted = from.is_some() || shadows.is_some() || occlusion.is_some();
    if is_wanted && shading == ShadingWord::None {
        return refuse("from, shadows and occlusion: expected shading, found shading = \"none\"");
    }
    check_from(from)?;
    if shadows == Some(true) && from.is_none() {
        return refuse("shadows: light that comes from the eye has none: add from = [x, y, z]");
    }
    let occlusion = occlusion.unwrap_or(0.0);
    if !(0.0..=1.0).contains(&occlusion) {
        return refuse(&format!("occlusion: expected a number from 0 to 1, found {occlusion}"));
    }
    Ok(RasterOptions::DEFAULT
        .with_light(light(table)?)
        .with_light_from(from, shadows.unwrap_or(false))
        .with_occlusion(occlusion))
}

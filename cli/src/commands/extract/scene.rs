//! The surfaces of an extraction as a scene.

use crate::{
    fault::UsageError,
    plan::{ExtractPlan, LevelPlan, color},
};
use anyhow::{Context, Result};
use isokit::pipeline::IsoChoice;
use std::{fmt::Write, path};
use toml::Value;

/// A scene file that shows what was asked for: the volume wherever the scene lies, and each surface.
pub(super) fn text(plan: &ExtractPlan) -> Result<String> {
    let input = path::absolute(&plan.input)
        .with_context(|| format!("{}: cannot find its place", plan.input.display()))?;
    let Some(input) = input.to_str() else {
        let says = "a scene is text, and the path of the volume is none";
        return Err(UsageError(format!("{}: {says}", input.display())).into());
    };
    let quoted = |text: &str| Value::String(text.to_owned()).to_string();
    let mut text = format!("[volume]\npath = {}\n", quoted(input));
    for (n, level) in plan.levels.iter().enumerate() {
        let LevelPlan { iso, name, color: own } = level;
        let iso = match iso {
            IsoChoice::Value(iso) => Value::Float(*iso).to_string(),
            other => quoted(&other.to_string()),
        };
        let name = name.as_ref().map_or(String::new(), |name| format!("name = {}\n", quoted(name)));
        let color = quoted(&own.unwrap_or(color(n)).to_string());
        write!(text, "\n[[surface]]\n{name}iso = {iso}\ncolor = {color}\n")?;
    }
    for plane in &plan.clips {
        let ([x, y, z], offset) = (plane.normal(), plane.offset());
        write!(text, "\n[[clip]]\nplane = [{x:?}, {y:?}, {z:?}, {offset:?}]\ncap = \"solid\"\n")?;
    }
    Ok(text + "\n[output]\nsize = [1024, 1024]\nmode = \"surfaces\"\n")
}

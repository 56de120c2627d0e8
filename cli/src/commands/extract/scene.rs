//! The surfaces of an extraction as a scene.

use crate::{
    args::{ClipArg, SampleType},
    fault::UsageError,
    plan::{ExtractPlan, LevelPlan, color},
};
use anyhow::{Context, Result};
use isokit::{
    io::RawLayout,
    pipeline::{Region, Span},
};
use std::{
    fmt::{Debug, Write},
    path,
};
use toml::Value;

/// A scene file that shows what was made: the volume wherever the scene lies, and each surface at its isovalue.
pub(super) fn text(plan: &ExtractPlan, isos: &[f64]) -> Result<String> {
    let input = path::absolute(&plan.input)
        .with_context(|| format!("{}: cannot find its place", plan.input.display()))?;
    let Some(input) = input.to_str() else {
        let says = "a scene is text, and the path of the volume is none";
        return Err(UsageError(format!("{}: {says}", input.display())).into());
    };
    let quoted = |text: &str| Value::String(text.to_owned()).to_string();
    let mut text = format!("[volume]\npath = {}\n", quoted(input));
    let options = &plan.volume;
    if let Some(RawLayout { dims, dtype, endian, skip }) = options.raw {
        let sample = quoted(&SampleType { dtype, endian }.to_string());
        write!(text, "dims = {dims:?}\ndtype = {sample}\nskip = {skip}\n")?;
    }
    for (name, three) in [("spacing", options.spacing), ("origin", options.origin)] {
        three.iter().try_for_each(|three| writeln!(text, "{name} = {three:?}"))?;
    }
    options.volume_index.iter().try_for_each(|index| writeln!(text, "index = {index}"))?;
    let quantity = options.quantity.map(|quantity| quoted(&quantity.to_string()));
    quantity.iter().try_for_each(|quantity| writeln!(text, "quantity = {quantity}"))?;
    match plan.region {
        Region::Whole => {}
        Region::Samples(spans) => writeln!(text, "roi = {}", quoted(&ranges(&spans)))?,
        Region::World(spans) => writeln!(text, "roi_mm = {}", quoted(&ranges(&spans)))?,
    }
    for (n, (level, iso)) in plan.levels.iter().zip(isos).enumerate() {
        let LevelPlan { name, color: own, .. } = level;
        let name = name.as_ref().map_or(String::new(), |name| format!("name = {}\n", quoted(name)));
        let color = quoted(&own.unwrap_or(color(n)).to_string());
        write!(text, "\n[[surface]]\n{name}iso = {iso:?}\ncolor = {color}\n")?;
    }
    for ClipArg { half, surfaces } in &plan.clips {
        let ([x, y, z], offset) = (half.normal(), half.offset());
        write!(text, "\n[[clip]]\nplane = [{x:?}, {y:?}, {z:?}, {offset:?}]\ncap = \"solid\"\n")?;
        if let Some(names) = surfaces {
            let names: Vec<_> = names.iter().map(|name| quoted(name)).collect();
            writeln!(text, "surfaces = [{}]", names.join(", "))?;
        }
    }
    Ok(text + "\n[output]\nsize = [1024, 1024]\nmode = \"surfaces\"\n")
}

/// As on the command line.
fn ranges<T: Debug>(spans: &[Span<T>; 3]) -> String {
    let end = |end: &Option<T>| end.as_ref().map_or(String::new(), |end| format!("{end:?}"));
    let ranges = spans.each_ref().map(|span| format!("{}:{}", end(&span.from), end(&span.to)));
    ranges.join(",")
}

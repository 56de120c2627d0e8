//! The shape file: a solid put together from others, as TOML or JSON. Unknown words are refused with their line.

use crate::fault::CallerError;
use anyhow::{Context, Result};
use isokit::solid::{Model, Solid};
use std::{fs, path::Path};

/// Whether a file is a shape, by its name.
pub(crate) fn is_shape(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|word| ["toml", "json"].contains(&word.to_ascii_lowercase().as_str()))
}

/// The solid in a file: JSON if its name ends so, otherwise TOML.
pub(crate) fn read_shape(path: &Path) -> Result<Solid> {
    let text = fs::read_to_string(path)
        .with_context(|| format!("{}: cannot read the shape", path.display()))?;
    let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let model: Result<Model, String> = match is_json {
        true => serde_json::from_str(&text).map_err(|error| error.to_string()),
        false => toml::from_str(&text).map_err(|error| error.to_string()),
    };
    let solid = model.and_then(|model| model.build().map_err(|error| error.to_string()));
    solid.map_err(|error| {
        let message = format!("{}: {}", path.display(), error.trim_end());
        CallerError { message, advice: "`isokit sample --help` shows a shape file" }.into()
    })
}

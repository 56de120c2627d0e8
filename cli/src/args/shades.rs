//! Words of colour with a shape of their own: a colour map with its range, a pattern with its size.

use isokit::render::{ColorMap, Pattern};
use std::str::FromStr;

/// `NAME` or `NAME:LOW:HIGH`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ColorMapArg {
    pub(crate) map: ColorMap,
    pub(crate) range: Option<[f64; 2]>,
}

impl FromStr for ColorMapArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, range) = text.split_once(':').map_or((text, None), |(n, rest)| (n, Some(rest)));
        let map = ColorMap::from_name(name).ok_or_else(|| {
            let known = ColorMap::ALL.map(|(_, name)| name).join(", ");
            format!("expected one of {known}, found {name:?}")
        })?;
        let ends = range.map(|range| {
            let ends =
                range.split_once(':').and_then(|(low, high)| Some([number(low)?, number(high)?]));
            ends.filter(|[low, high]| low != high)
                .ok_or_else(|| format!("expected two different values LOW:HIGH, found {range:?}"))
        });
        Ok(Self { map, range: ends.transpose()? })
    }
}

/// `PATTERN` or `PATTERN:SIZE`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TextureArg {
    pub(crate) pattern: Pattern,
    pub(crate) size: Option<f64>,
}

impl FromStr for TextureArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, size) = text.split_once(':').map_or((text, None), |(n, rest)| (n, Some(rest)));
        let pattern = match name {
            "checker" => Pattern::Checker,
            "marble" => Pattern::Marble,
            "wood" => Pattern::Wood,
            "granite" => Pattern::Granite,
            _ => return Err(format!("expected checker, marble, wood or granite, found {name:?}")),
        };
        let size = size.map(|size| {
            let found = number(size).filter(|size| *size > 0.0);
            found.ok_or_else(|| format!("expected a size above 0, found {size:?}"))
        });
        Ok(Self { pattern, size: size.transpose()? })
    }
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::{ColorMapArg, TextureArg};
    use isokit::render::{ColorMap, Pattern};

    #[test]
    fn a_map_may_have_a_range_and_a_pattern_a_size() {
        let map = |text: &str| text.parse::<ColorMapArg>();
        assert_eq!(map("magma"), Ok(ColorMapArg { map: ColorMap::Magma, range: None }));
        let coolwarm = ColorMapArg { map: ColorMap::Coolwarm, range: Some([2.5, -1.0]) };
        assert_eq!(map("coolwarm:2.5:-1"), Ok(coolwarm));
        assert!(
            map("jet").unwrap_err().starts_with("expected one of viridis, magma, gray, coolwarm")
        );
        for text in ["gray:1", "gray:1:1", "gray:1:2:3", "gray::", "gray:nan:1", "gray:0:inf"] {
            assert!(map(text).unwrap_err().starts_with("expected two different values"), "{text}");
        }
        let texture = |text: &str| text.parse::<TextureArg>();
        assert_eq!(texture("wood:2"), Ok(TextureArg { pattern: Pattern::Wood, size: Some(2.0) }));
        assert_eq!(texture("marble"), Ok(TextureArg { pattern: Pattern::Marble, size: None }));
        assert!(
            texture("bricks").is_err() && texture("wood:0").is_err() && texture("wood:").is_err()
        );
    }
}

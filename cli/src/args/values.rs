//! Words with a shape of their own: three numbers, a sample type, an isovalue with name and colour.

use isokit::{
    field::{Filter, Window},
    geom::Unit,
    io::Endian,
    mesh::Rgba,
    pipeline::IsoChoice,
    refine::Subdivision,
    render::Size,
    volume::Dtype,
};
use std::{any::type_name, fmt, num::NonZeroUsize, str::FromStr};

/// `x,y,z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Triple<T>(pub(crate) [T; 3]);

impl<T: FromStr> FromStr for Triple<T> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<T>> = text.split(',').map(|word| word.parse().ok()).collect();
        let kind = if type_name::<T>() == type_name::<u64>() { "whole numbers" } else { "numbers" };
        let triple = numbers.and_then(|numbers| numbers.try_into().ok()).map(Self);
        triple.ok_or_else(|| format!("expected three {kind} x,y,z, found {text:?}"))
    }
}

/// One distance for all axes, or one for each.
pub(crate) fn spacing(text: &str) -> Result<Triple<f64>, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|word| word.parse().ok()).collect();
    let triple = match numbers.as_deref() {
        Some(&[all]) => Some([all; 3]),
        Some(&[x, y, z]) => Some([x, y, z]),
        _ => None,
    };
    let sound = triple.filter(|all| all.iter().all(|one| *one > 0.0 && one.is_finite()));
    sound
        .map(Triple)
        .ok_or_else(|| format!("expected one distance above 0, or three x,y,z, found {text:?}"))
}

/// A filter by its name in the field.
pub(crate) fn filter(text: &str) -> Result<Filter, String> {
    let refusal = || {
        format!(
            "expected nearest, linear, quadratic-bspline, cubic-bspline, catmull-rom, mitchell, bc:B,C, or lanczosN, \
             hannN or blackmanN with N from 2 to 8, found {text:?}"
        )
    };
    let windows =
        [("lanczos", Window::Lanczos), ("hann", Window::Hann), ("blackman", Window::Blackman)];
    let windowed = windows.into_iter().find_map(|(name, window)| {
        let lobes = text.strip_prefix(name)?.parse().ok()?;
        (2..=8).contains(&lobes).then_some(Filter::Sinc { window, lobes })
    });
    let family = text.strip_prefix("bc:").and_then(|numbers| {
        let (b, c) = numbers.split_once(',')?;
        let [b, c]: [f64; 2] = [b.parse().ok()?, c.parse().ok()?];
        (b.is_finite() && c.is_finite()).then_some(Filter::Cubic { b, c })
    });
    match text {
        "nearest" => Ok(Filter::Nearest),
        "linear" => Ok(Filter::Linear),
        "quadratic-bspline" => Ok(Filter::QuadraticBSpline),
        "cubic-bspline" => Ok(Filter::CubicBSpline),
        "catmull-rom" => Ok(Filter::CATMULL_ROM),
        "mitchell" => Ok(Filter::MITCHELL),
        _ => windowed.or(family).ok_or_else(refusal),
    }
}

/// A sample type with its byte order: `u8`, `i16le`, `u16be`; little-endian if none is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleType {
    pub(crate) dtype: Dtype,
    pub(crate) endian: Endian,
}

impl FromStr for SampleType {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, endian) = match (text.strip_suffix("be"), text.strip_suffix("le")) {
            (Some(name), _) => (name, Endian::Big),
            (_, Some(name)) => (name, Endian::Little),
            _ => (text, Endian::Little),
        };
        let dtype = Dtype::from_name(name).ok_or_else(|| {
            let names = Dtype::ALL.map(Dtype::name).join(" ");
            format!("expected one of {names}, then le or be, found {text:?}")
        })?;
        Ok(Self { dtype, endian })
    }
}

impl fmt::Display for SampleType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let order = match self.endian {
            Endian::Little => "le",
            Endian::Big => "be",
        };
        write!(f, "{}{order}", self.dtype.name())
    }
}

/// `V`, `V:name`, `V:#rrggbb[aa]` or `V:name:#rrggbb[aa]`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LevelArg {
    pub(crate) iso: IsoChoice,
    pub(crate) name: Option<String>,
    pub(crate) color: Option<Rgba>,
}

impl FromStr for LevelArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (iso, rest) =
            text.split_once(':').map_or((text, None), |(iso, rest)| (iso, Some(rest)));
        let iso = iso.parse().map_err(|error| format!("{error}"))?;
        let (name, color) = match rest {
            None => (None, None),
            Some(color) if color.starts_with('#') => (None, Some(color)),
            Some(rest) => match rest.split_once(':') {
                None => (Some(rest), None),
                Some((name, color)) => (Some(name), Some(color)),
            },
        };
        let name = name.map(surface_name).transpose()?;
        let color = color.map(|color| color.parse().map_err(|error| format!("{error}")));
        Ok(Self { iso, name, color: color.transpose()? })
    }
}

fn surface_name(name: &str) -> Result<String, String> {
    match name.trim() {
        "" => Err("expected a name after the first colon, found none".into()),
        name if name.contains(char::is_control) => {
            Err(format!("expected a name in one line, found {name:?}"))
        }
        name => Ok(name.to_owned()),
    }
}

/// Three sizes of which none is 0.
pub(crate) fn sizes(text: &str) -> Result<Triple<u64>, String> {
    let sizes: Triple<u64> = text.parse()?;
    match sizes.0.contains(&0) {
        true => Err(format!("expected sizes of 1 or more, found {text:?}")),
        false => Ok(sizes),
    }
}

/// How often, or how many.
pub(crate) fn count(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| format!("expected 1 or more, found {text}"))
}

/// A number, such as a label.
pub(crate) fn finite(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| format!("expected a number, found {text:?}"))
}

/// A number that is not negative.
pub(crate) fn distance(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| format!("expected a distance, 0 or more, found {text:?}"))
}

/// A length above 0.
pub(crate) fn length(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| format!("expected a distance above 0, found {text:?}"))
}

/// An angle between faces.
pub(crate) fn angle_of_creases(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| *number > 0.0 && *number < 180.0);
    number.ok_or_else(|| format!("expected degrees above 0 and below 180, found {text:?}"))
}

/// How often triangles are divided.
pub(crate) fn levels(text: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| (1..=Subdivision::MOST).contains(number));
    number.ok_or_else(|| format!("expected 1 to {}, found {text:?}", Subdivision::MOST))
}

/// `WIDTHxHEIGHT` in pixels.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    let sides = text.split_once('x').and_then(|(width, height)| {
        Some(Size { width: width.parse().ok()?, height: height.parse().ok()? })
    });
    sides.ok_or_else(|| format!("expected WIDTHxHEIGHT such as 1024x768, found {text:?}"))
}

/// Any angle.
pub(crate) fn angle(text: &str) -> Result<f64, String> {
    finite(text).map_err(|_| format!("expected degrees, found {text:?}"))
}

/// How many pictures are made on the way around.
pub(crate) fn frames(text: &str) -> Result<NonZeroUsize, String> {
    const MOST: usize = 100_000;
    let number = text.parse().ok().filter(|number: &NonZeroUsize| number.get() <= MOST);
    number.ok_or_else(|| format!("expected a number of pictures from 1 to {MOST}, found {text:?}"))
}

/// The angle of a perspective.
pub(crate) fn fov(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && *number < 180.0);
    number.ok_or_else(|| format!("expected degrees above 0 and below 180, found {text:?}"))
}

/// A known unit by its symbol.
pub(crate) fn unit(text: &str) -> Result<Unit, String> {
    let unit = Unit::from_symbol(text).filter(|unit| unit.metres().is_some());
    unit.ok_or_else(|| {
        let known = Unit::ALL.into_iter().filter(|(unit, _)| unit.metres().is_some());
        let known: Vec<&str> = known.map(|(_, symbol)| symbol).collect();
        format!("expected one of {}, found {text:?}", known.join(" "))
    })
}

#[cfg(test)]
mod tests {
    use super::{
        LevelArg, SampleType, Triple, angle, count, distance, filter, fov, length, levels, size,
        sizes, spacing, unit,
    };
    use isokit::{
        field::{Filter, Window},
        geom::Unit,
        io::Endian,
        mesh::Rgba,
        pipeline::IsoChoice,
        volume::Dtype,
    };

    fn level(text: &str) -> Result<LevelArg, String> {
        text.parse()
    }

    #[test]
    fn a_level_is_a_value_with_or_without_name_and_colour() {
        let (iso, skin) = (IsoChoice::Value(-300.0), Some("skin".to_owned()));
        let color = Some(Rgba([0xd8, 0xa5, 0x80, 0x80]));
        let expected = LevelArg { iso, name: skin.clone(), color };
        assert_eq!(level("-300:skin:#d8a58080"), Ok(expected.clone()));
        assert_eq!(level("-300:skin"), Ok(LevelArg { color: None, ..expected.clone() }));
        assert_eq!(level("-300:#d8a58080"), Ok(LevelArg { name: None, ..expected }));
        let auto = LevelArg { iso: IsoChoice::Auto, name: None, color: None };
        assert_eq!(level("auto"), Ok(auto));
        let percent = level("50%:half").unwrap();
        assert_eq!(percent.iso, IsoChoice::Percent(50.0));
    }

    #[test]
    fn a_level_that_is_none_is_refused_part_by_part() {
        for (text, refusal) in [
            (
                "bone:300",
                "expected a number, a percentage from 0% to 100%, or auto, found \"bone\"",
            ),
            ("300:", "expected a name after the first colon, found none"),
            ("300:bone:red", "expected #rrggbb or #rrggbbaa, found \"red\""),
            ("300:#12345", "expected #rrggbb or #rrggbbaa, found \"#12345\""),
            ("300:a\nb", "expected a name in one line, found \"a\\nb\""),
        ] {
            assert_eq!(level(text).unwrap_err(), refusal);
        }
    }

    #[test]
    fn three_numbers_are_three_numbers() {
        assert_eq!("256,256,128".parse(), Ok(Triple([256_u64, 256, 128])));
        assert_eq!("0.7,-0.7,1e1".parse(), Ok(Triple([0.7, -0.7, 10.0])));
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1 2 3", "1.5,2,3", "-1,2,3"] {
            let refusal = format!("expected three whole numbers x,y,z, found {text:?}");
            assert_eq!(text.parse::<Triple<u64>>(), Err(refusal));
        }
        let refusal = "expected three numbers x,y,z, found \"1,2\"".to_owned();
        assert_eq!("1,2".parse::<Triple<f64>>(), Err(refusal));
    }

    #[test]
    fn sizes_and_counts_begin_with_one() {
        assert_eq!(sizes("1,2,3"), Ok(Triple([1, 2, 3])));
        for text in ["0,2,3", "1,0,3", "1,2,0"] {
            assert_eq!(sizes(text), Err(format!("expected sizes of 1 or more, found {text:?}")));
        }
        assert_eq!(count("7").map(usize::from), Ok(7));
        for text in ["0", "-1", "x", "", "1.5", "99999999999999999999"] {
            assert_eq!(count(text), Err(format!("expected 1 or more, found {text}")));
        }
    }

    #[test]
    fn a_sample_type_may_name_its_byte_order() {
        let read = |text: &str| text.parse().map(|t: SampleType| (t.dtype, t.endian));
        assert_eq!(read("u16be"), Ok((Dtype::U16, Endian::Big)));
        assert_eq!(read("i16le"), Ok((Dtype::I16, Endian::Little)));
        assert_eq!(read("u8"), Ok((Dtype::U8, Endian::Little)));
        let said = ["u16be", "f32"].map(|text| text.parse::<SampleType>().unwrap().to_string());
        assert_eq!(said, ["u16be", "f32le"]);
        let refusal = "expected one of u8 i8 u16 i16 u32 i32 f32 f64, then le or be, found \"i64\"";
        assert_eq!(read("i64"), Err(refusal.to_owned()));
    }

    #[test]
    fn units_and_distances_are_sound() {
        assert_eq!(unit("mm"), Ok(Unit::Millimetre));
        let refusal = "expected one of m cm mm um nm angstrom, found \"unknown\"";
        assert_eq!(unit("unknown"), Err(refusal.to_owned()));
        assert_eq!(distance("0"), Ok(0.0));
        for text in ["-1", "nan", "inf", "x"] {
            assert!(distance(text).unwrap_err().ends_with(&format!("found {text:?}")));
        }
    }

    #[test]
    fn one_distance_is_for_all_axes_and_kernels_have_the_names_of_the_field() {
        assert_eq!(
            (spacing("0.5"), spacing("1,2,3")),
            (Ok(Triple([0.5; 3])), Ok(Triple([1.0, 2.0, 3.0])))
        );
        for text in ["0", "-1", "1,2", "1,0,1", "nan", "inf", "x", ""] {
            let refusal = format!("expected one distance above 0, or three x,y,z, found {text:?}");
            assert_eq!(spacing(text), Err(refusal));
        }
        assert_eq!(filter("catmull-rom"), filter("bc:0,0.5"));
        assert_eq!(filter("hann4"), Ok(Filter::Sinc { window: Window::Hann, lobes: 4 }));
        for text in ["cubic", "lanczos", "lanczos1", "lanczos9", "bc:1", "bc:1,nan", ""] {
            assert!(filter(text).unwrap_err().ends_with(&format!("found {text:?}")), "{text}");
        }
    }

    #[test]
    fn lengths_are_above_0_and_levels_few() {
        assert_eq!((length("1e-3"), levels("1"), levels("6")), (Ok(1e-3), Ok(1), Ok(6)));
        for text in ["0", "-0", "-1", "nan", "inf", "x", ""] {
            let refusal = format!("expected a distance above 0, found {text:?}");
            assert_eq!(length(text), Err(refusal));
        }
        for text in ["0", "7", "-1", "1.5", "x", ""] {
            assert_eq!(levels(text), Err(format!("expected 1 to 6, found {text:?}")));
        }
    }

    #[test]
    fn pictures_have_two_sides_and_angles_are_degrees() {
        let found = size("1024x768").unwrap();
        assert_eq!((found.width.get(), found.height.get()), (1024, 768));
        for text in ["1024", "0x3", "3x0", "-1x2", "3x4x5", "x", "99999999999x1"] {
            let refusal = format!("expected WIDTHxHEIGHT such as 1024x768, found {text:?}");
            assert_eq!(size(text).unwrap_err(), refusal);
        }
        assert_eq!((angle("-30"), fov("179.5")), (Ok(-30.0), Ok(179.5)));
        assert!(angle("inf").is_err() && fov("180").is_err() && fov("0").is_err());
        assert!(fov("nan").is_err() && angle("x").is_err());
    }
}

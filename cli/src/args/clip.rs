//! Planes on the command line.

use isokit::geom::HalfSpace;
use std::str::FromStr;

/// `nx,ny,nz,d[:name...]`: a plane, and which surfaces it cuts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClipArg {
    /// What is kept: n · x <= d.
    pub(crate) half: HalfSpace,
    /// The names of the surfaces that are cut; none for all.
    pub(crate) surfaces: Option<Vec<String>>,
}

impl FromStr for ClipArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut words = text.split(':');
        let plane = words.next().unwrap_or_default();
        let numbers: Option<Vec<f64>> = plane.split(',').map(|word| word.parse().ok()).collect();
        let found = numbers.and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
        let [x, y, z, offset] =
            found.ok_or_else(|| format!("expected four numbers nx,ny,nz,d, found {plane:?}"))?;
        let half = HalfSpace::new([x, y, z], offset)
            .map_err(|error| format!("{error}, found {plane:?}"))?;
        let names: Vec<String> = words.map(str::to_owned).collect();
        match names.iter().any(String::is_empty) {
            true => Err("expected the name of a surface after each colon, found none".into()),
            false => Ok(Self { half, surfaces: (!names.is_empty()).then_some(names) }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ClipArg;
    use isokit::geom::HalfSpace;

    #[test]
    fn a_plane_cuts_all_surfaces_or_those_that_it_names() {
        let clip = |text: &str| text.parse::<ClipArg>();
        let half = HalfSpace::new([1.0, 0.0, -2.5], 12.0).unwrap();
        assert_eq!(clip("1,0,-2.5,12"), Ok(ClipArg { half, surfaces: None }));
        let surfaces = Some(vec!["skin".to_owned(), "iso_4,5".to_owned()]);
        assert_eq!(clip("1,0,-2.5,12:skin:iso_4,5"), Ok(ClipArg { half, surfaces }));
        for (text, refusal) in [
            ("1,2,3:skin", "expected four numbers nx,ny,nz,d, found \"1,2,3\""),
            ("1,0,0,5:", "expected the name of a surface after each colon, found none"),
            ("1,0,0,5::skin", "expected the name of a surface after each colon, found none"),
        ] {
            assert_eq!(clip(text).unwrap_err(), refusal);
        }
    }
}

//! STL as text: `solid`, `facet`, `outer loop`, three times `vertex`, and their ends.

use super::{
    corners::Corners,
    read::{Solid, add},
};
use crate::{Place, ReadFault, mesh::input::MeshFile, text::shown};

/// Reads all solids of a file. Keywords may be in any case; facet normals are passed over.
pub(super) fn read(file: MeshFile<'_>) -> Result<Vec<Solid>, ReadFault> {
    let text = String::from_utf8_lossy(file.bytes);
    let (mut solids, mut corners) = (Vec::<Solid>::new(), Vec::with_capacity(3));
    let (mut is_open, mut last) = (false, 0);
    for (number, line) in text.lines().enumerate() {
        file.pace(number)?;
        last = number as u64 + 1;
        let broken = |expected| file.broken(Place::Line(last), expected, shown(line.trim()));
        let (keyword, rest) = keyword(line);
        match keyword.to_ascii_lowercase().as_str() {
            "" => {}
            "solid" if !is_open => {
                solids.push(Solid { name: rest.to_owned(), corners: Corners::default() });
                is_open = true;
            }
            "endsolid" if is_open && corners.is_empty() => is_open = false,
            "facet" | "outer" if is_open && corners.is_empty() => {}
            "endloop" if corners.len() == 3 => {}
            "endfacet" => {
                let triangle = corners.as_slice().try_into();
                let triangle = triangle.map_err(|_| broken("three vertices before endfacet"))?;
                let solid = solids.last_mut().filter(|_| is_open);
                let solid = solid.ok_or_else(|| broken("solid"))?;
                add(file, &mut solid.corners, triangle)?;
                corners.clear();
            }
            "vertex" if is_open && corners.len() < 3 => {
                corners.push(vertex(rest).ok_or_else(|| broken("vertex and three numbers"))?);
            }
            _ => return Err(broken("solid, facet, outer loop, three vertices and their ends")),
        }
    }
    match is_open {
        true => Err(file.broken(Place::Line(last), "endsolid", "the end of the file")),
        false => Ok(solids),
    }
}

/// The first word of a line, and the rest.
fn keyword(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    (keyword, rest.trim())
}

fn vertex(text: &str) -> Option<[f32; 3]> {
    let mut words = text.split_whitespace();
    let mut number = || words.next()?.parse().ok();
    let xyz = [number()?, number()?, number()?];
    words.next().is_none().then_some(xyz)
}

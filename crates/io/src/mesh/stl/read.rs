//! Reads STL: binary by its size, else text if it begins with `solid`.

use super::{FACET, HEAD, corners::Corners, text};
use crate::{
    Place, ReadFault,
    mesh::{
        facts::Facts,
        input::{MeshFile, MeshInput, NO_UNIT},
    },
};
use isokit_geom::Unit;
use isokit_mesh::Surface;

/// A surface as it stands in the file.
pub(super) struct Solid {
    pub(super) name: String,
    pub(super) corners: Corners,
}

/// Reads all surfaces of a file: one if it is binary, of text one for each `solid`.
pub(in crate::mesh) fn read(file: MeshFile<'_>) -> Result<MeshInput, ReadFault> {
    let mut facts = Facts::default();
    let bytes = file.bytes;
    let is_exact = announced(bytes).is_some_and(|all| all == bytes.len() as u64);
    let is_text = !is_exact && bytes.trim_ascii_start().starts_with(b"solid");
    let solids = if is_text { text::read(file)? } else { vec![binary(file, &mut facts)?] };
    let mut shared = 0;
    let surfaces = solids.into_iter().map(|Solid { name, corners }| {
        let (mesh, more) = corners.finish();
        shared += more;
        let name = if name.is_empty() && !facts.is_ours { file.stem() } else { name };
        Surface { name, color: None, iso: facts.iso, mesh }
    });
    let surfaces = surfaces.collect();
    let mut notes = vec![];
    if shared > 0 {
        notes.push(format!(
            "STL repeats vertices: {shared} corners at exactly the place of another one share its vertex"
        ));
    }
    if facts.unit == Unit::Unknown {
        notes.push(NO_UNIT.to_owned());
    }
    let (format, unit, space) = (file.format, facts.unit, facts.space);
    Ok(MeshInput { surfaces, format, unit, space, notes })
}

/// Bytes of a binary file with as many triangles as this one announces.
fn announced(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..HEAD)?.try_into().ok().map(u32::from_le_bytes)?;
    Some(HEAD as u64 + FACET as u64 * u64::from(count))
}

fn binary(file: MeshFile<'_>, facts: &mut Facts) -> Result<Solid, ReadFault> {
    let held = file.bytes.len() as u64;
    let Some(announced) = announced(file.bytes) else {
        let found = format!("{held} bytes");
        return Err(file.broken(Place::Byte(0), "\"solid\" or a header of 84 bytes", found));
    };
    if announced > held {
        return Err(file.truncated("triangles", announced - HEAD as u64, held - HEAD as u64));
    }
    let header = String::from_utf8_lossy(&file.bytes[..80]);
    facts.take_header(header.trim_end_matches('\0').trim_end());
    let mut corners = Corners::default();
    let facets = file.bytes[HEAD..announced as usize].chunks_exact(FACET);
    for (number, facet) in facets.enumerate() {
        file.pace(number)?;
        let floats: [f32; 9] = std::array::from_fn(|k| {
            let at = 12 + 4 * k;
            f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]])
        });
        let [a, b, c, d, e, f, g, h, i] = floats;
        add(file, &mut corners, [[a, b, c], [d, e, f], [g, h, i]])?;
    }
    Ok(Solid { name: facts.name.clone().unwrap_or_default(), corners })
}

/// Adds a triangle, if the job allows one more.
pub(super) fn add(
    file: MeshFile<'_>,
    corners: &mut Corners,
    triangle: [[f32; 3]; 3],
) -> Result<(), ReadFault> {
    file.job.limits.allow("triangles", Some(corners.count() as u64 + 1), 12)?;
    let expected = "fewer places than 32 bits can number";
    let place = Place::Item("triangle", corners.count() as u64);
    if corners.add(triangle) { Ok(()) } else { Err(file.broken(place, expected, "more")) }
}

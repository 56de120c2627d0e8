//! Which axes are x, y, z, and where they lead.
//!
//! An axis is of space if it has a direction; without directions, unless its kind says otherwise. The
//! first three of space are x, y, z. Axes after them count volumes. An axis before or between them
//! means several numbers per sample, and is refused unless its size is 1.

use super::{
    super::place::{EXPECTED, completed},
    header::{Header, vectors},
};
use crate::{ReadFault, text::Field};
use isokit_geom::{Affine, Space};

/// What the header says of one axis.
pub(super) struct Axis {
    pub(super) size: u64,
    direction: Option<[f64; 3]>,
    spacing: Option<f64>,
    kind: String,
}

/// The axes put in their roles.
pub(super) struct Lattice {
    pub(super) dims: [u64; 3],
    pub(super) volumes: u64,
    /// Numbers of the axes that are x, y, z.
    pub(super) spatial: Vec<usize>,
}

/// As many axes as teem takes.
const MOST: usize = 16;

pub(super) fn read(header: &Header) -> Result<Vec<Axis>, ReadFault> {
    let dimension = header.need("dimension")?;
    let count: usize = dimension.number("1 to 16 axes")?;
    if !(1..=MOST).contains(&count) {
        return Err(dimension.broken("1 to 16 axes"));
    }
    let field = header.need("sizes")?;
    let sizes = field.numbers::<u64>("sizes above 0")?;
    if sizes.contains(&0) {
        return Err(field.broken("sizes above 0"));
    }
    as_many(field, sizes.len(), count)?;
    let directions = listed(header, "space directions", count, vectors)?;
    let spacings = listed(header, "spacings", count, |field| field.numbers("numbers"))?;
    let kinds = listed(header, "kinds", count, |field| field.numbers::<String>("kinds"))?;
    let axes = sizes.into_iter().enumerate().map(|(n, size)| Axis {
        size,
        direction: directions.get(n).copied().flatten(),
        // NaN is teem's word for "nobody knows".
        spacing: spacings.get(n).copied().filter(|step: &f64| !step.is_nan()),
        kind: kinds.get(n).map(|kind| kind.to_ascii_lowercase()).unwrap_or_default(),
    });
    Ok(axes.collect())
}

/// The values of a field with one for each axis; none if the field is not there.
fn listed<T>(
    header: &Header,
    name: &str,
    count: usize,
    read: impl Fn(&Field) -> Result<Vec<T>, ReadFault>,
) -> Result<Vec<T>, ReadFault> {
    let Some(field) = header.get(name) else { return Ok(vec![]) };
    let values = read(field)?;
    as_many(field, values.len(), count)?;
    Ok(values)
}

fn as_many(field: &Field, found: usize, count: usize) -> Result<(), ReadFault> {
    if found == count { Ok(()) } else { Err(field.broken(format!("{count} values, one per axis"))) }
}

pub(super) fn lattice(header: &Header, axes: &[Axis]) -> Result<Lattice, ReadFault> {
    let field = header.need("sizes")?;
    let with_directions = header.get("space directions").is_some();
    let is_spatial = |axis: &Axis| match with_directions {
        // Along time alone, a direction leads nowhere.
        true => axis.direction.is_some_and(|direction| direction != [0.0; 3]),
        false => matches!(axis.kind.as_str(), "" | "???" | "none" | "unknown" | "domain" | "space"),
    };
    let spatial = axes.iter().enumerate().filter(|(_, axis)| is_spatial(axis)).map(|(n, _)| n);
    let spatial: Vec<usize> = spatial.take(3).collect();
    let Some(&last) = spatial.last() else {
        return Err(field.unsupported("an array without an axis of space"));
    };
    let mut volumes = 1_u64;
    for (n, axis) in axes.iter().enumerate().filter(|(n, _)| !spatial.contains(n)) {
        if n > last {
            let product = volumes.checked_mul(axis.size);
            volumes = product.ok_or_else(|| field.broken("sizes that can be multiplied"))?;
        } else if axis.size > 1 {
            let kind = if axis.kind.is_empty() { "no kind" } else { &axis.kind };
            let feature = format!("{} numbers per sample (axis {n}, {kind})", axis.size);
            return Err(field.unsupported(feature));
        }
    }
    let dims = std::array::from_fn(|k| spatial.get(k).map_or(1, |&n| axes[n].size));
    Ok(Lattice { dims, volumes, spatial })
}

type Place = (Result<Affine, ReadFault>, Space);

/// From samples to the world.
pub(super) fn place(
    header: &Header,
    axes: &[Axis],
    lattice: &Lattice,
    notes: &mut Vec<String>,
) -> Result<Place, ReadFault> {
    let with_directions = header.get("space directions");
    let columns = std::array::from_fn(|k| {
        let axis = &axes[*lattice.spatial.get(k)?];
        let unit = |step: f64| std::array::from_fn(|row| if row == k { step } else { 0.0 });
        match with_directions {
            Some(_) => axis.direction,
            None => Some(unit(axis.spacing.unwrap_or(1.0))),
        }
    });
    let (space, factors) = space(header, notes)?;
    let origin = match header.get("space origin") {
        Some(field) => match vectors(field)?[..] {
            // NaN, too, is how teem says that there is none.
            [Some(origin)] if origin.iter().all(|x| !x.is_nan()) => origin,
            [Some(_)] | [None] => [0.0; 3],
            _ => return Err(field.broken("one vector like (0,0,0)")),
        },
        None => [0.0; 3],
    };
    let affine = Affine::new(completed(columns), origin);
    let affine = affine.and_then(|affine| affine.scaled_world(factors)).map_err(|error| {
        let named = with_directions.or(header.get("spacings")).or(header.get("space origin"));
        let found = error.to_string();
        named.map_or(ReadFault::Caller(found.clone().into()), |field| {
            field.broken_as(EXPECTED, found)
        })
    });
    Ok((affine, space))
}

/// The world's axes, and the reflection that leads to them from those of the file.
fn space(header: &Header, notes: &mut Vec<String>) -> Result<(Space, [f64; 3]), ReadFault> {
    const SAME: [f64; 3] = [1.0; 3];
    let Some(field) = header.get("space") else { return Ok((Space::Unknown, SAME)) };
    let name = field.value.to_ascii_lowercase();
    Ok(match name.strip_suffix("-time").unwrap_or(&name) {
        "right-anterior-superior" | "ras" | "rast" => (Space::Ras, SAME),
        "left-posterior-superior" | "lps" | "lpst" => (Space::Lps, SAME),
        "left-anterior-superior" | "las" | "last" => {
            notes.push("the space is LAS; x is reflected, which makes it RAS".into());
            (Space::Ras, [-1.0, 1.0, 1.0])
        }
        "3d-left-handed" => {
            let why = "so that the world is right-handed and nothing appears mirrored";
            notes.push(format!("the space is left-handed; z is reflected, {why}"));
            (Space::Unknown, [1.0, 1.0, -1.0])
        }
        "scanner-xyz" | "3d-right-handed" => (Space::Unknown, SAME),
        _ => return Err(field.broken("a space like left-posterior-superior")),
    })
}

//! Which axes are x, y, z, and where they lead.
//!
//! An axis is of space if it has a direction; without directions, unless its kind says otherwise. The
//! first three of space are x, y, z. Axes after them count volumes, and of colours are refused. An axis before or between them
//! means several numbers per sample, and is refused unless its size is 1, or it is the first, has size 3 and no kind
//! but that of a vector, or the size and kind of a colour in bytes.

use super::{
    super::{
        colors::Colored,
        place::{EXPECTED, completed},
        several,
        vectors::{ADVICE, ALONG_AXES, Layout, Triples},
    },
    header::{Header, vectors},
};
use crate::{ReadFault, text::Field};
use isokit_geom::{Affine, Space};
use isokit_volume::Dtype;

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
    /// Samples of three numbers, where an axis says so.
    pub(super) triples: Option<Triples>,
    /// Samples that are colours, or may be, where an axis says so.
    pub(super) colored: Option<Colored>,
}

/// Whether an axis may count the components of a vector; where it must, it says so.
fn is_vector(axis: &Axis, must: bool) -> bool {
    let names = ["vector", "covariant-vector", "normal", "3-vector", "3-gradient", "3-normal"];
    let any = ["", "???", "none", "unknown", "list"];
    let kind = axis.kind.as_str();
    axis.size == 3 && (names.contains(&kind) || !must && any.contains(&kind))
}

/// Whether an axis may count the numbers of a colour; where it must, it says so.
fn is_color(axis: &Axis, must: bool) -> bool {
    let kind = axis.kind.as_str();
    let any = ["", "???", "none", "unknown", "list", "vector", "3-vector", "4-vector"];
    let sizes = [("rgb-color", 3), ("3-color", 3), ("rgba-color", 4), ("4-color", 4)];
    sizes.contains(&(kind, axis.size)) || !must && any.contains(&kind)
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

pub(super) fn lattice(header: &Header, axes: &[Axis], dtype: Dtype) -> Result<Lattice, ReadFault> {
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
    let dims = std::array::from_fn(|k| spatial.get(k).map_or(1, |&n| axes[n].size));
    let triples = |layout, n: usize| {
        let axis = &axes[n];
        let says = format!("{}: {ADVICE}", numbers(axis, n));
        let (fault, are_volumes) = (Some(ReadFault::Caller(says.into())), layout == Layout::Apart);
        Triples { layout, dims, fault, are_volumes }
    };
    let (mut volumes, mut found, mut colored) = (1_u64, None, None);
    for (n, axis) in axes.iter().enumerate().filter(|(n, _)| !spatial.contains(n)) {
        if n > last {
            let product = volumes.checked_mul(axis.size);
            volumes = product.ok_or_else(|| field.broken("sizes that can be multiplied"))?;
            if is_color(axis, true) {
                let kind = &axis.kind;
                let says = format!("an axis of colours that is not the first (axis {n}, {kind})");
                return Err(header.need("kinds")?.unsupported(says));
            }
            if is_vector(axis, true) {
                found = Some(triples(Layout::Apart, n));
            }
            continue;
        }
        let is_first = n == 0;
        if is_first && is_color(axis, false) {
            colored = Colored::of(axis.size, dims, dtype, &numbers(axis, n));
        }
        if is_first && is_color(axis, true) && colored.is_none() {
            let kind = header.need("type")?;
            let found = &kind.value;
            let says = format!("colours are three or four unsigned bytes, found {found}, which");
            return Err(kind.unsupported(says));
        }
        if is_first && is_vector(axis, false) {
            found = Some(triples(Layout::Together, n));
        } else if axis.size > 1 && !(is_first && colored.is_some()) {
            return Err(field.unsupported(numbers(axis, n)));
        }
    }
    let together = found.as_ref().filter(|found| found.layout == Layout::Together);
    if let Some(says) = several(volumes, together, colored.as_ref()) {
        return Err(field.unsupported(says));
    }
    // Components of several volumes of vectors are a list of volumes, as others are.
    let triples = found.filter(|_| volumes <= 3);
    Ok(Lattice { dims, volumes, spatial, triples, colored })
}

/// What an axis counts that is none of space.
fn numbers(axis: &Axis, n: usize) -> String {
    let kind = if axis.kind.is_empty() { "no kind" } else { &axis.kind };
    format!("{} numbers per sample (axis {n}, {kind})", axis.size)
}

/// What takes vectors as they are stored to the world: the measurement frame, and the reflection of the space.
pub(super) fn vectors_to_world(
    header: &Header,
    factors: [f64; 3],
) -> Result<[[f64; 3]; 3], ReadFault> {
    const EXPECTED: &str = "three vectors like (1,0,0)";
    let columns = match header.get("measurement frame") {
        None => ALONG_AXES,
        Some(field) => {
            let columns: Option<Vec<_>> = vectors(field)?.into_iter().collect();
            let columns = columns.and_then(|columns| <[[f64; 3]; 3]>::try_from(columns).ok());
            let finite = columns.filter(|all| all.iter().flatten().all(|c| c.is_finite()));
            finite.ok_or_else(|| field.broken(EXPECTED))?
        }
    };
    Ok(columns.map(|column| std::array::from_fn(|k| column[k] * factors[k])))
}

/// From samples to the world, the world, and the reflection that led to it.
type Place = (Result<Affine, ReadFault>, Space, [f64; 3]);

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
    Ok((affine, space, factors))
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

//! MetaImage (MetaIO): `.mha` with the samples after the header, `.mhd` with the samples elsewhere.
//!
//! The world is LPS in millimetres, as ITK and all that is built on it read it. `AnatomicalOrientation`
//! only repeats what `TransformMatrix` says, in ITK's words (RAI: from right, anterior, inferior), and
//! is ignored, as ITK does. Intensities are taken as they are stored, as ITK does too.

use super::{
    Described,
    colors::Colored,
    files::DataFiles,
    place::{EXPECTED, completed},
    sample_feature, several,
    stored::{Coding, Skip, Stored},
    vectors::{ADVICE, ALONG_AXES, Layout, Triples},
};
use crate::{
    Endian, Format, ReadError, ReadFault,
    bytes::Bytes,
    text::{Field, Lines, shown},
};
use isokit_geom::{Affine, Space, Unit};
use isokit_volume::{Dtype, Scaling};
use std::path::Path;

pub(super) fn describe(path: &Path) -> Result<Described, ReadError> {
    let bytes = Bytes::open(path)?;
    let described = Header::read(bytes, path).and_then(|header| header.described(path));
    described.map_err(|fault| fault.at(path))
}

struct Header {
    fields: Vec<Field>,
    /// Where the samples are, with the number of axes per file where it is given; `None`: here.
    files: Option<(DataFiles, Option<usize>)>,
    /// Bytes up to the end of the line `ElementDataFile`.
    bytes: u64,
    /// The field that comes last.
    last: Field,
}

impl Header {
    fn read(bytes: Bytes, path: &Path) -> Result<Self, ReadFault> {
        let mut lines = Lines::new(Format::MetaImage, bytes);
        let mut fields = vec![];
        while let Some(line) = lines.next()? {
            if line.trim().is_empty() {
                continue;
            }
            let Some(last) = lines.field(&line, '=') else {
                return Err(lines.broken("Key = Value", shown(&line)));
            };
            if last.name != "elementdatafile" {
                fields.push(last);
                continue;
            }
            let bytes = lines.position();
            let local = last.value.eq_ignore_ascii_case("local");
            let files = if local { None } else { Some(DataFiles::parse(&last, path, &mut lines)?) };
            return Ok(Self { fields, files, bytes, last });
        }
        Err(lines.broken("ElementDataFile = …", "the end of the file".into()))
    }

    /// The first of these keys that there is.
    fn get(&self, names: &[&str]) -> Option<&Field> {
        names.iter().find_map(|name| {
            let is_it = |field: &&Field| field.name.eq_ignore_ascii_case(name);
            self.fields.iter().find(is_it)
        })
    }

    /// A key that no MetaImage lacks.
    fn need(&self, name: &'static str) -> Result<&Field, ReadFault> {
        let missing = || {
            let found = "ElementDataFile, which ends the header".into();
            self.last.broken_as(format!("{name} = … before it"), found)
        };
        self.get(&[name]).ok_or_else(missing)
    }

    fn truth(&self, names: &[&str]) -> Result<bool, ReadFault> {
        self.get(names).map_or(Ok(false), Field::truth)
    }

    fn described(&self, path: &Path) -> Result<Described, ReadFault> {
        let mut notes = vec![];
        if let Some(field) = self.get(&["ObjectType"])
            && !field.value.eq_ignore_ascii_case("image")
        {
            return Err(field.unsupported(format!("object type {}", shown(&field.value))));
        }
        let slope = self.get(&["ElementToIntensityFunctionSlope"]);
        let offset = self.get(&["ElementToIntensityFunctionOffset"]);
        if slope.is_some_and(|field| field.value.parse() != Ok(1.0))
            || offset.is_some_and(|field| field.value.parse() != Ok(0.0))
        {
            notes.push("ElementToIntensityFunction is not applied, as in ITK".into());
        }
        let sizes = self.sizes()?;
        let volumes = sizes.get(3).copied().unwrap_or(1);
        let dtype = self.dtype()?;
        let dims = std::array::from_fn(|axis| sizes.get(axis).copied().unwrap_or(1));
        let (triples, colored) = self.channels(dims, dtype)?;
        if let Some(says) = several(volumes, triples.as_ref(), colored.as_ref()) {
            return Err(self.need("DimSize")?.unsupported(says));
        }
        Ok(Described {
            dims,
            volumes,
            affine: self.affine(sizes.len()),
            has_geometry: true,
            unit: self.unit(&mut notes),
            space: Space::Lps,
            scaling: Scaling::IDENTITY,
            stored: self.stored(path, dtype, &sizes)?,
            triples,
            colored,
            to_world: Ok(ALONG_AXES),
            sample_unit: None,
            notes,
        })
    }

    fn sizes(&self) -> Result<Vec<u64>, ReadFault> {
        let axes = self.need("NDims")?;
        let count: usize = axes.number("1 to 4 axes")?;
        if !(1..=4).contains(&count) {
            return Err(axes.broken("1 to 4 axes"));
        }
        let field = self.need("DimSize")?;
        let sizes = field.numbers::<u64>("sizes above 0")?;
        if sizes.len() != count || sizes.contains(&0) {
            return Err(field.broken(format!("{count} sizes above 0")));
        }
        Ok(sizes)
    }

    /// Three channels are a vector; three or four of a byte each may be a colour.
    fn channels(
        &self,
        dims: [u64; 3],
        dtype: Dtype,
    ) -> Result<(Option<Triples>, Option<Colored>), ReadFault> {
        let Some(field) = self.get(&["ElementNumberOfChannels"]) else { return Ok((None, None)) };
        let what = format!("{} numbers per sample", field.value);
        let count = field.number::<u64>("a number of channels")?;
        let colored = Colored::of(count, dims, dtype, &what);
        match count {
            1 => Ok((None, None)),
            3 => {
                let fault = ReadFault::Caller(format!("{what}: {ADVICE}").into());
                let (layout, fault) = (Layout::Together, Some(fault));
                Ok((Some(Triples { layout, dims, fault, are_volumes: false }), colored))
            }
            _ if colored.is_some() => Ok((None, colored)),
            _ => Err(field.unsupported(what)),
        }
    }

    fn dtype(&self) -> Result<Dtype, ReadFault> {
        let field = self.need("ElementType")?;
        let refused = match field.value.to_ascii_uppercase().as_str() {
            "MET_CHAR" => return Ok(Dtype::I8),
            "MET_UCHAR" => return Ok(Dtype::U8),
            "MET_SHORT" => return Ok(Dtype::I16),
            "MET_USHORT" => return Ok(Dtype::U16),
            // Four bytes in MetaIO, wherever it runs.
            "MET_INT" | "MET_LONG" => return Ok(Dtype::I32),
            "MET_UINT" | "MET_ULONG" => return Ok(Dtype::U32),
            "MET_FLOAT" => return Ok(Dtype::F32),
            "MET_DOUBLE" => return Ok(Dtype::F64),
            "MET_LONG_LONG" => sample_feature("int64"),
            "MET_ULONG_LONG" => sample_feature("uint64"),
            other if other.starts_with("MET_") => sample_feature(&field.value),
            _ => return Err(field.broken("a type like MET_SHORT")),
        };
        Err(field.unsupported(refused))
    }

    fn unit(&self, notes: &mut Vec<String>) -> Unit {
        let Some(field) = self.get(&["DistanceUnits"]) else { return Unit::Millimetre };
        Unit::from_symbol(&field.value).unwrap_or_else(|| {
            notes.push(format!("the unit {} is not known; mm is used", shown(&field.value)));
            Unit::Millimetre
        })
    }

    /// Each `NDims` numbers of the matrix are the direction of one axis.
    fn affine(&self, axes: usize) -> Result<Affine, ReadFault> {
        let spacing = self.get(&["ElementSpacing", "ElementSize"]);
        let steps = spacing.map_or(Ok([1.0; 3]), |field| field.vector(1.0))?;
        let matrix = self.get(&["TransformMatrix", "Orientation", "Rotation"]);
        let entries = match matrix {
            Some(field) => {
                let entries = field.numbers::<f64>("numbers")?;
                if entries.len() != axes * axes {
                    return Err(field.broken(format!("{axes} x {axes} numbers")));
                }
                entries
            }
            None => (0..axes * axes).map(|n| f64::from(u8::from(n / axes == n % axes))).collect(),
        };
        let columns = std::array::from_fn(|axis| {
            let row = |k: usize| if k < axes { entries[axis * axes + k] } else { 0.0 };
            (axis < axes).then(|| std::array::from_fn(|k| row(k) * steps[axis]))
        });
        let place = self.get(&["Offset", "Position", "Origin"]);
        let origin = place.map_or(Ok([0.0; 3]), |field| field.vector(0.0))?;
        let affine = Affine::new(completed(columns), origin);
        let field = matrix.or(spacing).or(place).unwrap_or(&self.last);
        affine.map_err(|error| field.broken_as(EXPECTED, error.to_string()))
    }

    fn stored(&self, path: &Path, dtype: Dtype, sizes: &[u64]) -> Result<Stored, ReadFault> {
        let is_binary = self.get(&["BinaryData"]).map_or(Ok(true), Field::truth)?;
        let is_packed = self.truth(&["CompressedData"])?;
        let is_big = self.truth(&["ElementByteOrderMSB", "BinaryDataByteOrderMSB"])?;
        let coding = match (is_binary, is_packed) {
            (true, false) => Coding::Raw,
            (true, true) => Coding::Deflate,
            (false, _) => Coding::Text,
        };
        let skip = match self.get(&["HeaderSize"]) {
            Some(field) => match field.number::<i64>("a number of bytes, or -1")? {
                -1 => Skip::AllButSamples,
                skip => Skip::Bytes(
                    u64::try_from(skip).map_err(|_| field.broken("a number of bytes, or -1"))?,
                ),
            },
            None => Skip::Bytes(0),
        };
        let endian = if is_big { Endian::Big } else { Endian::Little };
        let attached = Stored::attached(Format::MetaImage, path, self.bytes, dtype);
        let stored = Stored { coding, skip, endian, ..attached };
        let Some((files, axes)) = &self.files else { return Ok(stored) };
        files.fit(&self.last, sizes, *axes)?;
        let (files, named_by) = (files.clone(), Some(path.to_owned()));
        Ok(Stored { files, named_by, header: 0, ..stored })
    }
}

#[cfg(test)]
mod tests;

//! The values of a PLY, one after the other, in text or in binary.

use super::header::{Element, Encoding, Header, Number};
use crate::{Endian, Place, ReadFault, bytes::Record, mesh::input::MeshFile, text::shown};

/// Where in the body we are.
pub(super) struct Values<'a> {
    file: MeshFile<'a>,
    encoding: Encoding,
    at: usize,
    line: u64,
}

impl<'a> Values<'a> {
    pub(super) fn new(file: MeshFile<'a>, header: &Header) -> Self {
        Self { file, encoding: header.encoding, at: header.bytes, line: header.lines + 1 }
    }

    /// Goes on if the rest of the file can hold all of an element.
    pub(super) fn expect(&self, element: &Element) -> Result<(), ReadFault> {
        let each = element.properties.iter().map(|property| match self.encoding {
            // A digit and a blank.
            Encoding::Text => 2,
            Encoding::Binary(_) => property.length.unwrap_or(property.number).size() as u64,
        });
        let announced = element.count.saturating_mul(each.sum());
        let held = (self.file.bytes.len() - self.at) as u64;
        let needed =
            if self.encoding == Encoding::Text { announced.saturating_sub(1) } else { announced };
        if needed <= held { Ok(()) } else { Err(self.file.truncated("elements", needed, held)) }
    }

    /// The next number.
    pub(super) fn next(&mut self, number: Number) -> Result<f64, ReadFault> {
        match self.encoding {
            Encoding::Text => self.next_text(number),
            Encoding::Binary(endian) => self.next_binary(number, endian),
        }
    }

    /// The next number, which must be whole and not below 0.
    pub(super) fn next_index(&mut self, number: Number) -> Result<u64, ReadFault> {
        let value = self.next(number)?;
        if value >= 0.0 && value.fract() == 0.0 && value < u64::MAX as f64 {
            return Ok(value as u64);
        }
        Err(self.broken("a whole number not below 0", value.to_string()))
    }

    /// The number that came last is wrong.
    pub(super) fn broken(&self, expected: &'static str, found: impl Into<String>) -> ReadFault {
        let place = match self.encoding {
            Encoding::Text => Place::Line(self.line),
            Encoding::Binary(_) => Place::Byte(self.at as u64),
        };
        self.file.broken(place, expected, found)
    }

    /// Bytes that are left.
    pub(super) fn left(&self) -> usize {
        self.file.bytes.len() - self.at
    }

    fn next_binary(&mut self, number: Number, endian: Endian) -> Result<f64, ReadFault> {
        let size = number.size();
        let Some(bytes) = self.file.bytes.get(self.at..self.at + size) else {
            return Err(self.broken("a number", "the end of the file"));
        };
        self.at += size;
        let record = Record { bytes, endian };
        Ok(match number {
            Number::I8 => f64::from(bytes[0] as i8),
            Number::U8 => bytes[0].into(),
            Number::I16 => record.i16(0).into(),
            Number::U16 => f64::from(record.i16(0) as u16),
            Number::I32 => record.i32(0).into(),
            Number::U32 => f64::from(record.i32(0) as u32),
            Number::F32 => record.f32(0).into(),
            Number::F64 => record.f64(0),
        })
    }

    fn next_text(&mut self, number: Number) -> Result<f64, ReadFault> {
        let rest = &self.file.bytes[self.at..];
        let start = rest.iter().position(|byte| !byte.is_ascii_whitespace()).unwrap_or(rest.len());
        self.line += rest[..start].iter().filter(|&&byte| byte == b'\n').count() as u64;
        let word = &rest[start..];
        let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        self.at += start + end;
        let word = String::from_utf8_lossy(&word[..end]);
        let value = match number {
            // Not by way of f64, which would round twice.
            Number::F32 => word.parse::<f32>().map(f64::from),
            _ => word.parse(),
        };
        let found = || if word.is_empty() { "the end of the file".into() } else { shown(&word) };
        value.map_err(|_| self.broken("a number", found()))
    }
}

//! The header of a PLY: which elements follow, how many, and of what each is made.

use crate::{
    Endian, Place, ReadFault,
    mesh::{facts::Facts, input::MeshFile},
    text::shown,
};

/// All that comes before the values.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) facts: Facts,
    /// Bytes of the header.
    pub(super) bytes: usize,
    /// Lines of the header.
    pub(super) lines: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    Binary(Endian),
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
    /// Where the header speaks of it.
    pub(super) place: Place,
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of the length, if it is a list.
    pub(super) length: Option<Number>,
    pub(super) number: Number,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Number {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of such a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl Header {
    /// Reads the header that a file begins with.
    pub(super) fn read(file: MeshFile<'_>) -> Result<Self, ReadFault> {
        let (mut encoding, mut elements) = (None, Vec::<Element>::new());
        let (mut facts, mut at, mut lines) = (Facts::default(), 0, 0);
        loop {
            let (line, next) = line(&file.bytes[at..]);
            at += next;
            lines += 1;
            let text = String::from_utf8_lossy(line);
            let broken = |expected| file.broken(Place::Line(lines), expected, shown(&text));
            let mut words = text.split_whitespace();
            let keyword = words.next().unwrap_or_default();
            let rest: Vec<&str> = words.collect();
            match (keyword, rest.as_slice()) {
                ("ply", []) if lines == 1 => {}
                _ if lines == 1 => return Err(broken("ply")),
                ("comment" | "obj_info", _) => {
                    facts.take_line(text.trim_start().split_once(' ').unwrap_or_default().1);
                }
                ("format", [name, "1.0"]) => {
                    encoding = Some(match *name {
                        "ascii" => Encoding::Text,
                        "binary_little_endian" => Encoding::Binary(Endian::Little),
                        "binary_big_endian" => Encoding::Binary(Endian::Big),
                        _ => return Err(broken("ascii or binary, little or big endian")),
                    });
                }
                ("element", [name, count]) => {
                    let count = count.parse().map_err(|_| broken("a number of elements"))?;
                    let (name, place) = ((*name).to_owned(), Place::Line(lines));
                    elements.push(Element { name, count, properties: vec![], place });
                }
                ("property", rest) => {
                    let property = property(rest).ok_or_else(|| broken("a type and a name"))?;
                    let element = elements.last_mut().ok_or_else(|| broken("an element first"))?;
                    element.properties.push(property);
                }
                ("end_header", []) => {
                    let encoding = encoding.ok_or_else(|| broken("a format before the end"))?;
                    return Ok(Self { encoding, elements, facts, bytes: at, lines });
                }
                ("", []) if at < file.bytes.len() => {}
                _ => return Err(broken("format, comment, element, property or end_header")),
            }
        }
    }
}

fn property(words: &[&str]) -> Option<Property> {
    let (length, number, name) = match *words {
        ["list", length, number, name] => (Some(Number::of(length)?), number, name),
        [number, name] => (None, number, name),
        _ => return None,
    };
    Some(Property { name: name.to_owned(), length, number: Number::of(number)? })
}

/// The first line, and how far it is to the next. Lines end with `\n`, `\r\n` or `\r`.
fn line(bytes: &[u8]) -> (&[u8], usize) {
    let end = bytes.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(bytes.len());
    let ending = match bytes[end..] {
        [b'\r', b'\n', ..] => 2,
        [_, ..] => 1,
        [] => 0,
    };
    (&bytes[..end], end + ending)
}

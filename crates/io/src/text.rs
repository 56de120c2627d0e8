//! Header lines that hold numbers, and samples written as text.

use crate::{Format, Place, ReadFault, bytes::Bytes};
use std::{
    borrow::Cow,
    io::{BufRead, Read},
    str::FromStr,
};

/// A header longer than this is none.
const MOST: u64 = 16 << 20;

/// The longest number: 17 digits, sign, point and exponent fit well.
const LONGEST_NUMBER: usize = 128;

/// The lines of a header, numbered from 1.
pub(crate) struct Lines {
    format: Format,
    bytes: Bytes,
    line: u64,
}

/// What one line of a header says.
#[derive(Clone, Debug)]
pub(crate) struct Field {
    pub(crate) format: Format,
    pub(crate) line: u64,
    /// In lower case.
    pub(crate) name: String,
    pub(crate) value: String,
}

impl Lines {
    pub(crate) fn new(format: Format, bytes: Bytes) -> Self {
        Self { format, bytes, line: 0 }
    }

    /// The next line without its end, be that `\n` or `\r\n`; `None` after the last.
    pub(crate) fn next(&mut self) -> Result<Option<String>, ReadFault> {
        let room = MOST.saturating_sub(self.bytes.position());
        let mut line = vec![];
        let read = (&mut self.bytes).take(room).read_until(b'\n', &mut line);
        let read = read.map_err(|error| self.bytes.fault(self.format, error))?;
        self.line += 1;
        if line.ends_with(b"\n") {
            line.pop();
            if line.ends_with(b"\r") {
                line.pop();
            }
        } else if read as u64 == room {
            return Err(self.broken("a header of at most 16 MiB", "more".into()));
        }
        Ok((read > 0).then(|| String::from_utf8_lossy(&line).into_owned()))
    }

    /// The number of the line that came last.
    pub(crate) fn line(&self) -> u64 {
        self.line
    }

    /// Bytes up to the end of the line that came last.
    pub(crate) fn position(&self) -> u64 {
        self.bytes.position()
    }

    /// The line that came last is wrong.
    pub(crate) fn broken(&self, expected: &'static str, found: String) -> ReadFault {
        let place = Place::Line(self.line);
        ReadFault::Broken { format: self.format, place, expected: expected.into(), found }
    }

    /// The line that came last, taken apart at `separator`; `None` if it is not there.
    pub(crate) fn field(&self, text: &str, separator: char) -> Option<Field> {
        let (name, value) = text.split_once(separator)?;
        Some(Field {
            format: self.format,
            line: self.line,
            name: name.trim().to_ascii_lowercase(),
            value: value.trim().to_owned(),
        })
    }
}

impl Field {
    /// The value breaks the format.
    pub(crate) fn broken(&self, expected: impl Into<Cow<'static, str>>) -> ReadFault {
        self.broken_as(expected, shown(&self.value))
    }

    /// The value breaks the format, in a way that is better put in words.
    pub(crate) fn broken_as(
        &self,
        expected: impl Into<Cow<'static, str>>,
        found: String,
    ) -> ReadFault {
        let place = Place::Line(self.line);
        ReadFault::Broken { format: self.format, place, expected: expected.into(), found }
    }

    /// The value is lawful, but cannot be read.
    pub(crate) fn unsupported(&self, feature: impl Into<Cow<'static, str>>) -> ReadFault {
        let place = Place::Line(self.line);
        ReadFault::Unsupported { format: self.format, place, feature: feature.into() }
    }

    /// The value as one number.
    pub(crate) fn number<T: FromStr>(&self, expected: &'static str) -> Result<T, ReadFault> {
        self.value.parse().map_err(|_| self.broken(expected))
    }

    /// The value as numbers between blanks.
    pub(crate) fn numbers<T: FromStr>(&self, expected: &'static str) -> Result<Vec<T>, ReadFault> {
        let numbers = self.value.split_whitespace().map(str::parse);
        numbers.collect::<Result<_, _>>().map_err(|_| self.broken(expected))
    }

    /// The value as three finite numbers; of more the first three, of fewer the rest from `absent`.
    pub(crate) fn vector(&self, absent: f64) -> Result<[f64; 3], ReadFault> {
        let expected = "a finite number for each axis";
        let numbers = self.numbers::<f64>(expected)?;
        if numbers.is_empty() || !numbers.iter().all(|number| number.is_finite()) {
            return Err(self.broken(expected));
        }
        Ok(std::array::from_fn(|axis| numbers.get(axis).copied().unwrap_or(absent)))
    }

    /// The value as `True` or `False`, or the first letter of either.
    pub(crate) fn truth(&self) -> Result<bool, ReadFault> {
        match self.value.as_bytes() {
            [b'T' | b't' | b'1', ..] => Ok(true),
            [b'F' | b'f' | b'0', ..] => Ok(false),
            _ => Err(self.broken("True or False")),
        }
    }
}

/// Text in quotes, as much of it as fits a message.
pub(crate) fn shown(text: &str) -> String {
    const ROOM: usize = 60;
    match text.char_indices().nth(ROOM) {
        Some((end, _)) => format!("{:?} …", &text[..end]),
        None => format!("{text:?}"),
    }
}

/// The next number of samples as text, between blanks or commas; empty at the end.
///
/// # Errors
///
/// If the file cannot be read, or if what stands there is too long for a number.
pub(crate) fn next_number<'a>(
    bytes: &mut Bytes,
    format: Format,
    number: &'a mut String,
) -> Result<&'a str, ReadFault> {
    let is_between = |byte: u8| byte.is_ascii_whitespace() || byte == b',' || byte == 0x0b;
    number.clear();
    loop {
        let place = Place::Byte(bytes.position());
        let buffer = match bytes.fill_buf() {
            Ok(buffer) => buffer,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(bytes.fault(format, error)),
        };
        if buffer.is_empty() {
            return Ok(number);
        }
        let blanks = match number.is_empty() {
            true => buffer.iter().take_while(|&&byte| is_between(byte)).count(),
            false => 0,
        };
        let rest = &buffer[blanks..];
        let digits = rest.iter().take_while(|&&byte| !is_between(byte)).count();
        let (whole, taken) = (digits < rest.len(), blanks + digits);
        number.push_str(&String::from_utf8_lossy(&rest[..digits.min(LONGEST_NUMBER)]));
        if number.len() >= LONGEST_NUMBER {
            let (expected, found) = ("a number".into(), shown(number));
            return Err(ReadFault::Broken { format, place, expected, found });
        }
        bytes.consume(taken);
        if whole && !number.is_empty() {
            return Ok(number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Lines, next_number, shown};
    use crate::{Format, bytes::Bytes};
    use std::fs;

    fn bytes_of(text: &str) -> Bytes {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), text).unwrap();
        Bytes::open(file.path()).unwrap()
    }

    #[test]
    fn lines_end_either_way_and_are_numbered() {
        let mut lines = Lines::new(Format::Nrrd, bytes_of("a: 1\r\n\nlast"));
        assert_eq!(lines.next().unwrap().as_deref(), Some("a: 1"));
        assert_eq!(lines.next().unwrap().as_deref(), Some(""));
        assert_eq!((lines.line(), lines.position()), (2, 7));
        assert_eq!(lines.next().unwrap().as_deref(), Some("last"));
        assert_eq!(lines.next().unwrap(), None);
    }

    #[test]
    fn a_field_says_where_it_stands_and_what_it_holds() {
        let mut lines = Lines::new(Format::Nrrd, bytes_of("\nSizes:  64 x\n"));
        lines.next().unwrap();
        let text = lines.next().unwrap().unwrap();
        let field = lines.field(&text, ':').unwrap();
        assert_eq!(field.name, "sizes");
        let fault = field.numbers::<u64>("sizes").unwrap_err().to_string();
        assert_eq!(fault, "NRRD, line 2: expected sizes, found \"64 x\"");
        assert!(lines.field("no separator", ':').is_none());
    }

    #[test]
    fn numbers_stand_between_blanks_and_commas() {
        let mut bytes = bytes_of(" 1,2 ,\t-3e4\n5");
        let (mut found, mut number) = (vec![], String::new());
        loop {
            match next_number(&mut bytes, Format::Nrrd, &mut number).unwrap() {
                "" => break,
                number => found.push(number.to_owned()),
            }
        }
        assert_eq!(found, ["1", "2", "-3e4", "5"]);
    }

    #[test]
    fn nothing_endless_is_held_or_shown() {
        let long = "7".repeat(100_000);
        let mut number = String::new();
        let fault = next_number(&mut bytes_of(&long), Format::Nrrd, &mut number);
        assert!(fault.unwrap_err().to_string().starts_with("NRRD, byte 0: expected a number"));
        assert!(shown(&"ü".repeat(1000)).len() < 130);
    }
}

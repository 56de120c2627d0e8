//! JSON that people can read too: a key a line, a list of numbers in one line.

use serde_json::ser::{Formatter, PrettyFormatter};
use std::io::{self, Write};

/// Objects as usual, arrays in one line.
#[derive(Default)]
pub(super) struct Layout<'a>(PrettyFormatter<'a>);

impl Formatter for Layout<'_> {
    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        out.write_all(if first { b"" } else { b", " })
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.0.begin_object(out)
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.0.end_object(out)
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> io::Result<()> {
        self.0.begin_object_key(out, first)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.0.begin_object_value(out)
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> io::Result<()> {
        self.0.end_object_value(out)
    }
}

#[cfg(test)]
mod tests {
    use crate::report::to_json;
    use serde_json::json;

    #[test]
    fn a_key_has_a_line_and_an_array_has_one_too() {
        let object = json!({"a": [1.5, null, 2], "b": [{"c": []}, {}]});
        let text = to_json(&object).unwrap();
        assert_eq!(text, "{\n  \"a\": [1.5, null, 2],\n  \"b\": [{\n    \"c\": []\n  }, {}]\n}\n");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).unwrap(), object);
    }
}

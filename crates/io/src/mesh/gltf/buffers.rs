//! The bytes of all buffers: inside the GLB, inside the JSON, or in files in the same folder.

use super::base64;
use crate::{
    Place, ReadError, ReadFault,
    mesh::input::{MeshFile, load},
    text::shown,
};
use gltf_json::{Buffer, Root};
use std::borrow::Cow;

/// The buffers of a document, each at least as long as it says.
pub(super) fn buffers<'a>(
    file: MeshFile<'a>,
    root: &Root,
    bin: Option<&'a [u8]>,
) -> Result<Vec<Cow<'a, [u8]>>, ReadError> {
    let one = |(number, buffer): (usize, &Buffer)| {
        let place = Place::Item("buffer", number as u64);
        let inside = bin.filter(|_| number == 0);
        let bytes = bytes(file, buffer, place, inside)?;
        let (announced, held) = (buffer.byte_length.0, bytes.len() as u64);
        match announced <= held {
            true => Ok(bytes),
            false => Err(file.truncated("a buffer", announced, held).at(file.path)),
        }
    };
    root.buffers.iter().enumerate().map(one).collect()
}

fn bytes<'a>(
    file: MeshFile<'a>,
    buffer: &Buffer,
    place: Place,
    bin: Option<&'a [u8]>,
) -> Result<Cow<'a, [u8]>, ReadError> {
    let broken = |expected, found: String| file.broken(place, expected, found).at(file.path);
    let Some(uri) = &buffer.uri else {
        let bin = bin.ok_or_else(|| broken("a URI, or a chunk BIN", "neither".into()))?;
        return Ok(Cow::Borrowed(bin));
    };
    if let Some(data) = uri.strip_prefix("data:") {
        let text = data.split_once(";base64,").map(|(_, text)| text);
        let bytes = text.and_then(base64::decode);
        return bytes.map(Cow::Owned).ok_or_else(|| broken("data in Base64", shown(uri)));
    }
    let path = decoded(uri).and_then(|name| file.sibling(&name));
    let path = path.ok_or_else(|| broken("a file in the same folder", shown(uri)))?;
    load(&path, file.job).map(Cow::Owned)
}

/// A URI (RFC 3986) as the name of a file; `None` if it names a scheme.
fn decoded(uri: &str) -> Option<String> {
    if uri.contains(':') {
        return None;
    }
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [byte, tail @ ..] = rest {
        let escaped = tail.get(..2).filter(|_| *byte == b'%');
        let escaped = escaped.and_then(|digits| str::from_utf8(digits).ok());
        let escaped = escaped.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(escaped.unwrap_or(*byte));
        rest = if escaped.is_some() { &tail[2..] } else { tail };
    }
    String::from_utf8(bytes).ok()
}

/// A buffer that is not there.
pub(super) fn missing(file: MeshFile<'_>, place: Place, what: &'static str) -> ReadFault {
    file.broken(place, what, "a number that none has")
}

#[cfg(test)]
mod tests {
    use super::decoded;

    #[test]
    fn escapes_are_undone_and_schemes_refused() {
        assert_eq!(decoded("a%20b%C3%BC.bin").as_deref(), Some("a bü.bin"));
        assert_eq!(decoded("50%.bin").as_deref(), Some("50%.bin"));
        assert_eq!(decoded("file:///etc/passwd"), None);
        assert_eq!(decoded("%ff"), None);
    }
}

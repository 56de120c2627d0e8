//! Base64 (RFC 4648, section 4), as data URIs have it.

/// The bytes of a text; `None` if it is not Base64.
pub(super) fn decode(text: &str) -> Option<Vec<u8>> {
    let text = text.trim_end_matches('=').as_bytes();
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 2);
    for four in text.chunks(4) {
        let mut bits = 0_u32;
        for &letter in four {
            bits = bits << 6 | sextet(letter)?;
        }
        bits <<= 6 * (4 - four.len());
        let [_, whole @ ..] = bits.to_be_bytes();
        // Two letters make one byte, three make two, four make three; one makes none.
        bytes.extend_from_slice(whole.get(..four.len().checked_sub(1).filter(|&n| n > 0)?)?);
    }
    Some(bytes)
}

fn sextet(letter: u8) -> Option<u32> {
    let value = match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    };
    Some(value.into())
}

#[cfg(test)]
mod tests {
    use super::decode;

    #[test]
    fn the_examples_of_the_standard_are_decoded() {
        let examples = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        for (length, text) in examples.into_iter().enumerate() {
            assert_eq!(decode(text).as_deref(), Some(&b"foobar"[..length]), "{text}");
        }
        assert_eq!(decode("/+8"), Some(vec![0xff, 0xef]));
        for text in ["Z", "Zm9vY", "Zm 9", "Zm9v\n", "Zg=x"] {
            assert_eq!(decode(text), None, "{text:?}");
        }
    }
}

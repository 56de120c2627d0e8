//! Amounts of memory.

/// The units, with their bytes.
const UNITS: [(&str, u64); 6] = [
    ("KiB", 1 << 10),
    ("MiB", 1 << 20),
    ("GiB", 1 << 30),
    ("KB", 1_000),
    ("MB", 1_000_000),
    ("GB", 1_000_000_000),
];

/// `512MiB`, `1.5 GB`: a number and a unit.
pub(super) fn bytes(text: &str) -> Result<u64, String> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let (number, name) = (digits.trim(), &text[digits.len()..]);
    let unit = UNITS.iter().find(|(unit, _)| unit.eq_ignore_ascii_case(name));
    let number: Option<f64> = number.parse().ok().filter(|n: &f64| n.is_finite() && *n >= 0.0);
    match (number, unit) {
        (Some(number), Some(&(_, bytes))) => Ok((number * bytes as f64) as u64),
        (Some(number), None) => {
            let meant = match name.as_bytes() {
                [b'k' | b'K'] => "KiB",
                [b'g' | b'G'] => "GiB",
                _ => "MiB",
            };
            let units = UNITS.map(|(unit, _)| unit).join(" ");
            Err(format!(
                "expected a size in one of {units}, found {text:?}; {number}{meant} may be meant"
            ))
        }
        (None, _) => Err(format!("expected a size such as 512MiB or 2GB, found {text:?}")),
    }
}

#[cfg(test)]
mod tests {
    use super::bytes;

    #[test]
    fn a_size_is_a_number_and_a_unit() {
        for (text, expected) in [
            ("512MiB", 512 << 20),
            ("512mib", 512 << 20),
            ("1.5 GiB", 3 << 29),
            ("2GB", 2_000_000_000),
            ("64KB", 64_000),
            ("0KiB", 0),
        ] {
            assert_eq!(bytes(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn a_size_that_is_none_is_refused_with_what_may_be_meant() {
        for (text, meant) in
            [("512", "512MiB"), ("512M", "512MiB"), ("2g", "2GiB"), ("8 kilos", "8MiB")]
        {
            let refusal = bytes(text).unwrap_err();
            assert!(
                refusal.ends_with(&format!("found {text:?}; {meant} may be meant")),
                "{refusal}"
            );
        }
        for text in ["", "MiB", "-1MiB", "nanMiB", "much", "é"] {
            let refusal = format!("expected a size such as 512MiB or 2GB, found {text:?}");
            assert_eq!(bytes(text), Err(refusal));
        }
    }
}

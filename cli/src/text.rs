//! Numbers and charts for people.

use isokit::volume::Histogram;

/// Whole numbers with a gap after every three digits: `1 976 543`.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> = digits.as_bytes().rchunks(3).rev().filter_map(ascii).collect();
    groups.join(" ")
}

fn ascii(digits: &[u8]) -> Option<&str> {
    str::from_utf8(digits).ok()
}

/// Numbers side by side: `0.7 0.7 1`.
pub(crate) fn listed<const N: usize>(numbers: [f64; N]) -> String {
    numbers.map(|number| number.to_string()).join(" ")
}

/// A number with six digits that mean something.
pub(crate) fn rounded(number: f64) -> String {
    let rounded: f64 = format!("{number:.5e}").parse().unwrap_or(number);
    rounded.to_string()
}

/// A number with `one` or `many` after it.
pub(crate) fn counted(number: u64, one: &str, many: &str) -> String {
    format!("{} {}", grouped(number), if number == 1 { one } else { many })
}

/// Lines of the chart.
const LINES: usize = 16;

/// Width of the longest bar.
const WIDTH: f64 = 48.0;

/// How often values occur, a line per range of values, the bar as long as the logarithm of the count.
pub(crate) fn chart(histogram: &Histogram) -> Vec<String> {
    let bins = histogram.counts.len();
    let bins_per_line = bins.div_ceil(LINES).max(1);
    let counts: Vec<u64> =
        histogram.counts.chunks(bins_per_line).map(|line| line.iter().sum()).collect();
    let most = (counts.iter().copied().max().unwrap_or(0) as f64).ln_1p();
    let from = |line: usize| histogram.middle(line * bins_per_line) - histogram.width / 2.0;
    let labels: Vec<String> = (0..counts.len()).map(|line| short(from(line))).collect();
    let widest = labels.iter().map(String::len).max().unwrap_or(0);
    let line = |(label, &count): (&String, &u64)| {
        let bar = bar((count as f64).ln_1p() / most);
        format!("{label:>widest$} {bar} {}", grouped(count))
    };
    labels.iter().zip(&counts).map(line).collect()
}

/// A bar of blocks, to the eighth.
fn bar(part: f64) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (part * WIDTH * 8.0).round() as usize;
    "█".repeat(eighths / 8) + EIGHTHS[eighths % 8]
}

/// A number in few digits.
fn short(number: f64) -> String {
    let digits = number.abs().log10().floor();
    if number == 0.0 || (-3.0..7.0).contains(&digits) {
        let decimals = (4.0 - digits.max(0.0)).max(0.0) as usize;
        let text = format!("{number:.decimals$}");
        let is_fraction = text.contains('.');
        return if is_fraction {
            text.trim_end_matches('0').trim_end_matches('.').into()
        } else {
            text
        };
    }
    format!("{number:.3e}")
}

#[cfg(test)]
mod tests {
    use super::{chart, counted, grouped, listed, rounded, short};
    use isokit::volume::Histogram;

    #[test]
    fn numbers_are_easy_to_read() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1_976_543), "1 976 543");
        assert_eq!(counted(1, "vertex", "vertices"), "1 vertex");
        assert_eq!(counted(1000, "vertex", "vertices"), "1 000 vertices");
        assert_eq!(listed([0.7, -1.0]), "0.7 -1");
        assert_eq!([23644773.897542, -0.1, 0.0].map(rounded), ["23644800", "-0.1", "0"]);
        let shortened = [0.0, -1024.5, 0.5, 1e-9, 3e12, 123.456_78].map(short);
        assert_eq!(shortened, ["0", "-1024.5", "0.5", "1.000e-9", "3.000e12", "123.46"]);
    }

    #[test]
    fn every_sample_is_in_the_chart() {
        let histogram =
            Histogram { range: [-1.0, 31.0], first: -1.0, width: 1.0, counts: vec![1; 33] };
        let lines = chart(&histogram);
        assert_eq!(lines.len(), 11);
        assert!(lines[0].starts_with("-1.5 █"), "{}", lines[0]);
        assert!(lines[0].ends_with("█ 3"), "{}", lines[0]);
    }

    #[test]
    fn few_values_make_few_lines() {
        let lines = chart(&Histogram {
            range: [0.0, 2.0],
            first: 0.0,
            width: 1.0,
            counts: vec![100, 0, 1],
        });
        assert_eq!(lines.len(), 3);
        assert_eq!(lines[1], " 0.5  0");
    }
}

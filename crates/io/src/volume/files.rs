//! The files in which a header says that the samples lie: one, a list, or a numbered series.

use crate::{
    ReadFault,
    text::{Field, Lines},
};
use std::path::{Path, PathBuf};

/// Names of data files, in the order of the samples.
#[derive(Clone, Debug)]
pub(super) enum DataFiles {
    One(PathBuf),
    List(Vec<PathBuf>),
    Series(Series),
}

/// `slice%03d.raw 1 93 1`: names are made when they are asked for, so a header cannot ask for a
/// billion of them at once.
#[derive(Clone, Debug)]
pub(super) struct Series {
    folder: PathBuf,
    before: String,
    after: String,
    width: usize,
    zeros: bool,
    first: i64,
    step: i64,
    count: u64,
}

impl DataFiles {
    /// What the value of a `data file` or `ElementDataFile` means, relative to the header's folder,
    /// with the number of axes per file where it is given. A list goes on to the end of the header.
    pub(super) fn parse(
        field: &Field,
        header: &Path,
        lines: &mut Lines,
    ) -> Result<(Self, Option<usize>), ReadFault> {
        let folder = header.parent().unwrap_or(Path::new(""));
        let mut words = field.value.split_whitespace();
        if words.next() == Some("LIST") {
            // `2` in NRRD, `2D` in MetaImage.
            let axes = words.next().map(|axes| axes.trim_end_matches(['d', 'D']).parse());
            let axes = axes.transpose().map_err(|_| field.broken("LIST and a number of axes"))?;
            return Ok((Self::List(Self::listed(folder, lines)?), axes));
        }
        match Series::parse(field, folder)? {
            Some((series, axes)) => Ok((Self::Series(series), axes)),
            None if field.value.is_empty() => Err(field.broken("the name of a data file")),
            None => Ok((Self::One(folder.join(&field.value)), None)),
        }
    }

    fn listed(folder: &Path, lines: &mut Lines) -> Result<Vec<PathBuf>, ReadFault> {
        let mut names = vec![];
        while let Some(name) = lines.next()? {
            if !name.trim().is_empty() {
                names.push(folder.join(name.trim()));
            }
        }
        Ok(names)
    }

    pub(super) fn count(&self) -> u64 {
        match self {
            Self::One(_) => 1,
            Self::List(names) => names.len() as u64,
            Self::Series(series) => series.count,
        }
    }

    /// Whether so many files can share an array of these `sizes`, fastest first, each with `axes`
    /// axes: by default all but the last. Files with all axes share the last.
    pub(super) fn fit(
        &self,
        field: &Field,
        sizes: &[u64],
        axes: Option<usize>,
    ) -> Result<(), ReadFault> {
        let count = self.count();
        let axes = axes.unwrap_or(sizes.len().saturating_sub(1)).min(sizes.len());
        let slices = sizes[axes..].iter().try_fold(1_u64, |count, &n| count.checked_mul(n));
        let whole = count > 0 && sizes.last().is_some_and(|last| last % count == 0);
        if count == 1 || slices == Some(count) || (axes == sizes.len() && whole) {
            return Ok(());
        }
        let slices = slices.map_or("fewer".into(), |slices| slices.to_string());
        Err(field.broken_as(format!("{slices} data files"), format!("{count}")))
    }

    /// The name of file `n`, counted from 0 and below [`count`](Self::count).
    pub(super) fn path(&self, n: u64) -> PathBuf {
        match self {
            Self::One(path) => path.clone(),
            Self::List(names) => names[n as usize].clone(),
            Self::Series(series) => series.path(n),
        }
    }
}

impl Series {
    /// `None` if the value is a plain name.
    fn parse(field: &Field, folder: &Path) -> Result<Option<(Self, Option<usize>)>, ReadFault> {
        let mut pattern = field.value.as_str();
        let mut numbers = vec![];
        while numbers.len() < 4
            && let Some((before, last)) = pattern.rsplit_once(char::is_whitespace)
            && let Ok(number) = last.parse::<i64>()
        {
            pattern = before.trim_end();
            numbers.insert(0, number);
        }
        let Some((before, conversion)) = pattern.split_once('%') else { return Ok(None) };
        let (first, last, step, axes) = match numbers[..] {
            [first, last] => (first, last, 1, None),
            [first, last, step] => (first, last, step, None),
            [first, last, step, axes] => (first, last, step, Some(axes)),
            _ => return Ok(None),
        };
        let expected = "a pattern like slice%03d.raw, first number, last number and step";
        let broken = || field.broken(expected);
        let end = conversion.find(['d', 'i', 'u']).ok_or_else(broken)?;
        let (width, after) = (&conversion[..end], &conversion[end + 1..]);
        let zeros = width.starts_with('0');
        let width = if width.is_empty() { 0 } else { width.parse().map_err(|_| broken())? };
        let steps = i128::from(last) - i128::from(first);
        let runs = step != 0 && (steps == 0 || (steps > 0) == (step > 0));
        if width > 32 || !runs {
            return Err(broken());
        }
        let count = (steps / i128::from(step)) as u64;
        let axes = axes.map(usize::try_from).transpose().map_err(|_| broken())?;
        let (before, after) = (before.to_owned(), after.to_owned());
        let folder = folder.to_owned();
        let count = count.saturating_add(1);
        Ok(Some((Self { folder, before, after, width, zeros, first, step, count }, axes)))
    }

    fn path(&self, n: u64) -> PathBuf {
        // Below `count`, so between the first number and the last.
        let number = i128::from(self.first) + i128::from(self.step) * i128::from(n);
        let width = self.width;
        let number =
            if self.zeros { format!("{number:0width$}") } else { format!("{number:width$}") };
        self.folder.join(format!("{}{number}{}", self.before, self.after))
    }
}

#[cfg(test)]
mod tests {
    use super::DataFiles;
    use crate::{
        Format,
        bytes::Bytes,
        text::{Field, Lines},
    };
    use std::{fs, path::Path};

    fn parse(value: &str, below: &str) -> Result<(Vec<String>, Option<usize>), String> {
        let file = tempfile::NamedTempFile::new().unwrap();
        fs::write(file.path(), below).unwrap();
        let mut lines = Lines::new(Format::Nrrd, Bytes::open(file.path()).unwrap());
        let (name, value) = ("data file".to_owned(), value.to_owned());
        let field = Field { format: Format::Nrrd, line: 1, name, value };
        let parsed = DataFiles::parse(&field, Path::new("d/head.nhdr"), &mut lines);
        let (files, axes) = parsed.map_err(|fault| fault.to_string())?;
        let names = (0..files.count()).map(|n| files.path(n).display().to_string());
        Ok((names.collect(), axes))
    }

    #[track_caller]
    fn check(value: &str, below: &str, expected: &[&str], axes: Option<usize>) {
        let expected = expected.iter().map(|name| name.to_string()).collect();
        assert_eq!(parse(value, below), Ok((expected, axes)), "{value}");
    }

    #[test]
    fn a_name_is_relative_to_the_header_and_may_hold_blanks() {
        check("my head 2.raw", "", &["d/my head 2.raw"], None);
        check("100% sure.raw", "", &["d/100% sure.raw"], None);
        check("/abs/head.raw", "", &["/abs/head.raw"], None);
    }

    #[test]
    fn a_list_goes_on_to_the_end() {
        check("LIST", "a.raw\r\nb c.raw\n\n", &["d/a.raw", "d/b c.raw"], None);
        check("LIST 2", "a.raw", &["d/a.raw"], Some(2));
        check("LIST 3D", "a.raw", &["d/a.raw"], Some(3));
        assert!(parse("LIST of files", "").is_err());
    }

    #[test]
    fn a_series_counts_up_or_down() {
        check("q.%d 1 3 1", "", &["d/q.1", "d/q.2", "d/q.3"], None);
        check("q%03d.raw 9 12 2", "", &["d/q009.raw", "d/q011.raw"], None);
        check("q%2d 3 1 -2 2", "", &["d/q 3", "d/q 1"], Some(2));
        check("q%d 5 6", "", &["d/q5", "d/q6"], None);
    }

    #[test]
    fn a_series_that_cannot_be_counted_is_refused() {
        for value in ["q%d 1 3 0", "q%d 3 1 1", "q%s 1 2 1", "q%99d 1 2 1", "q%xd 1 2 1"] {
            let fault = parse(value, "").unwrap_err();
            assert!(fault.contains("line 1: expected a pattern"), "{fault}");
        }
    }
}

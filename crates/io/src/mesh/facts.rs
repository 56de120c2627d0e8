//! What a header says of a mesh, in words that are read back.
//!
//! PLY, OBJ and STL have room for remarks only, so the facts stand there as `KEY=value`: one to a line, or
//! in STL all in the one header. `SPACE=RAS` and `SPACE=LPS` are 3D Slicer's; it reads ours, we read its.

use super::{MeshContext, SurfaceHead, name};
use isokit_geom::{Space, Unit};
use isokit_mesh::Rgba;

/// Who wrote it; the first line of every header, and `asset.generator` in glTF.
pub(super) const MAKER: &str = concat!("isokit ", env!("CARGO_PKG_VERSION"));

/// The keys; `NAME` and `COMMAND` may hold blanks, so in one line they come last.
const KEYS: [&str; 6] = ["SPACE", "UNIT", "ISO", "COLOR", "NAME", "COMMAND"];

/// The facts of a file, a line each.
pub(super) fn of_file(context: &MeshContext) -> Vec<String> {
    let mut lines = vec![
        MAKER.to_owned(),
        format!("SPACE={}", context.space),
        format!("UNIT={}", context.unit),
    ];
    if !context.command.is_empty() {
        lines.push(format!("COMMAND={}", name::line(&context.command)));
    }
    lines
}

/// The facts of a surface, a line each.
pub(super) fn of_surface(surface: &SurfaceHead) -> Vec<String> {
    let name = Some(&surface.name).filter(|name| !name.is_empty());
    let name = name.map(|text| format!("NAME={}", name::line(text)));
    let iso = surface.iso.map(|iso| format!("ISO={iso}"));
    let color = surface.color.map(|color| format!("COLOR={color}"));
    [name, iso, color].into_iter().flatten().collect()
}

/// All facts that one short line can hold; it never begins with `solid`.
pub(super) fn in_one_line(context: &MeshContext, surface: &SurfaceHead) -> String {
    let plain = |text: &str| name::line(text).replace('=', "_");
    let mut line = format!("{MAKER} SPACE={} UNIT={}", context.space, context.unit);
    if let Some(iso) = surface.iso {
        line += &format!(" ISO={iso}");
    }
    for (key, text) in [("NAME", &surface.name), ("COMMAND", &context.command)] {
        if !text.is_empty() {
            line += &format!(" {key}={}", plain(text));
        }
    }
    line
}

/// What was found so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Facts {
    /// Whether we wrote the file.
    pub(super) is_ours: bool,
    pub(super) space: Space,
    pub(super) unit: Unit,
    pub(super) name: Option<String>,
    pub(super) iso: Option<f64>,
    pub(super) color: Option<Rgba>,
}

impl Facts {
    /// Takes in a remark of one fact; any other remark says nothing.
    pub(super) fn take_line(&mut self, line: &str) {
        let line = line.trim();
        self.is_ours |= is_ours(line);
        match line.split_once('=') {
            Some((key, value)) if KEYS.contains(&key) => self.take(key, value),
            // 3D Slicer: "3D Slicer output. SPACE=RAS"
            _ => self.take_all(line, &["SPACE"]),
        }
    }

    /// Takes in a remark of many facts.
    pub(super) fn take_header(&mut self, line: &str) {
        self.is_ours |= is_ours(line);
        self.take_all(line, &KEYS);
    }

    fn take_all(&mut self, line: &str, keys: &[&'static str]) {
        let start = |&key: &&'static str| {
            let mark = format!("{key}=");
            let at = line.match_indices(&mark).map(|(at, _)| at);
            let mut at = at.filter(|&at| at == 0 || line[..at].ends_with([' ', ';']));
            at.next().map(|at| (at, at + mark.len(), key))
        };
        let mut starts: Vec<_> = keys.iter().filter_map(start).collect();
        starts.sort_unstable();
        for (number, &(_, from, key)) in starts.iter().enumerate() {
            let to = starts.get(number + 1).map_or(line.len(), |&(to, ..)| to);
            self.take(key, &line[from..to.max(from)]);
        }
    }

    fn take(&mut self, key: &str, value: &str) {
        let value = value.trim();
        let word = value.split([' ', ';', '\0']).next().unwrap_or_default();
        match key {
            "SPACE" => self.space = space(word),
            "UNIT" => self.unit = Unit::from_symbol(word).unwrap_or_default(),
            "ISO" => self.iso = word.parse().ok(),
            "COLOR" => self.color = word.parse().ok(),
            "NAME" => self.name = Some(value.to_owned()),
            _ => {}
        }
    }
}

fn is_ours(line: &str) -> bool {
    line.trim_start().starts_with("isokit ")
}

/// The space of a word as [`Space`] is shown.
pub(super) fn space(word: &str) -> Space {
    let known = [Space::Ras, Space::Lps].into_iter();
    known.clone().find(|space| space.to_string() == word).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::{Facts, in_one_line, of_file, of_surface};
    use crate::{MeshContext, SurfaceHead};
    use isokit_geom::{Space, Unit};
    use isokit_mesh::Rgba;

    fn example() -> (MeshContext, SurfaceHead, Facts) {
        let (unit, space) = (Unit::Millimetre, Space::Lps);
        let command = "isokit extract a=b.nii".to_owned();
        let context = MeshContext { unit, space, command, gltf_unit: None };
        let (color, iso) = (Some(Rgba([1, 2, 3, 4])), Some(-0.1));
        let name = "left SPACE=x lung".to_owned();
        let surface = SurfaceHead { name: name.clone(), color, iso };
        (context, surface, Facts { is_ours: true, space, unit, name: Some(name), iso, color })
    }

    #[test]
    fn lines_are_read_back() {
        let (context, surface, expected) = example();
        let mut facts = Facts::default();
        for line in of_file(&context).iter().chain(&of_surface(&surface)) {
            facts.take_line(line);
        }
        assert_eq!(facts, expected);
    }

    #[test]
    fn one_line_is_read_back_but_for_the_colour() {
        let (context, surface, expected) = example();
        let mut facts = Facts::default();
        facts.take_header(&in_one_line(&context, &surface));
        let name = Some("left SPACE_x lung".to_owned());
        assert_eq!(facts, Facts { name, color: None, ..expected });
    }

    #[test]
    fn the_space_that_slicer_writes_is_understood() {
        let mut facts = Facts::default();
        facts.take_line("3D Slicer output. SPACE=RAS");
        assert_eq!((facts.space, facts.is_ours), (Space::Ras, false));
        facts.take_line("Created by Blender");
        assert_eq!(facts.space, Space::Ras);
    }
}

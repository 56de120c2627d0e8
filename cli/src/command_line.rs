//! The command that a file says it was made by.
//!
//! Only what the content depends on: the same input and the same options give the same bytes, wherever the
//! files lie, whatever they are called, and however many threads there are. The folder of the input is
//! nobody else's business.

use clap::{ArgAction, ArgMatches, Command, parser::ValueSource};
use std::{ffi::OsStr, path::Path};

/// Options that change how a command is done, or what is said of it, but not the file it makes.
const WITHOUT_EFFECT: [&str; 13] = [
    "threads",
    "progress",
    "quiet",
    "verbose",
    "log_json",
    "output",
    "format",
    "index",
    "report",
    "dump_scene",
    "repeat",
    "repeat_warm",
    "max_memory",
];

/// Options that name a file that is read.
const FILES: [&str; 2] = ["attribute", "mask"];

/// The command as one would type it, each word quoted where a shell needs it.
pub(crate) fn canonical(command: &Command, matches: &ArgMatches) -> String {
    let mut words = vec![command.get_name().to_owned()];
    let Some((name, matches)) = matches.subcommand() else { return words.concat() };
    words.push(name.to_owned());
    let arguments = command.find_subcommand(name).into_iter().flat_map(Command::get_arguments);
    for argument in arguments {
        let id = argument.get_id().as_str();
        let was_typed = matches.try_contains_id(id).unwrap_or(false)
            && matches.value_source(id) == Some(ValueSource::CommandLine);
        if !was_typed || WITHOUT_EFFECT.contains(&id) {
            continue;
        }
        let is_flag = matches!(argument.get_action(), ArgAction::SetTrue);
        for value in matches.get_raw(id).into_iter().flatten() {
            words.extend(argument.get_long().map(|long| format!("--{long}")));
            let is_path = argument.get_long().is_none() || FILES.contains(&id);
            if !is_flag {
                words.push(quoted(if is_path { file_name(value) } else { value }));
            }
        }
    }
    words.join(" ")
}

fn file_name(path: &OsStr) -> &OsStr {
    Path::new(path).file_name().unwrap_or(path)
}

/// The word as a POSIX shell takes it back.
fn quoted(word: &OsStr) -> String {
    let word = word.to_string_lossy();
    let is_plain = |c: char| c.is_alphanumeric() || "-_.,:%+/=@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.into_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::canonical;
    use crate::args::Cli;
    use clap::CommandFactory;

    fn of(line: &str) -> String {
        let command = Cli::command();
        let matches = command.clone().try_get_matches_from(line.split('|')).unwrap();
        canonical(&command, &matches)
    }

    #[test]
    fn only_what_the_content_depends_on_is_told() {
        let line = "isokit|extract|a b/head.nii.gz|--iso=-300:skin:#d8a580|-o|x/y.glb|--iso|300\
                    |--threads|3|--index|--report|r.json|-v|--boundary|open";
        let told = "isokit extract head.nii.gz --iso '-300:skin:#d8a580' --iso 300 --boundary open";
        assert_eq!(of(line), told);
        let others = "isokit|extract|a.nii|--iso|5|-o|a.stl|--attribute|x/pet.nii|--mask|../y/m.nii|--dump-scene|z/s.toml";
        assert_eq!(of(others), "isokit extract a.nii --iso 5 --mask m.nii --attribute pet.nii");
        let spaced = "isokit|convert|it's.stl|--weld|0|-o|x.glb";
        assert_eq!(of(spaced), r"isokit convert 'it'\''s.stl' --weld 0");
    }
}

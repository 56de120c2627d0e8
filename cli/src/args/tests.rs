//! What is taken and what is refused, word by word.

use super::{Cli, Command, ExtractArgs};
use clap::{CommandFactory, Parser};
use isokit::pipeline::{IsoChoice, Region};

fn parse(line: &str) -> Result<Command, String> {
    let words = format!("isokit {line}");
    let parsed = Cli::try_parse_from(words.split(' ')).map(|cli| cli.command);
    parsed.map_err(|error| error.to_string())
}

fn extract(line: &str) -> ExtractArgs {
    match parse(&format!("extract {line}")) {
        Ok(Command::Extract(args)) => *args,
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn refused(line: &str, because: &str) {
    let refusal = parse(line).unwrap_err();
    assert!(refusal.contains(because), "{line}: {refusal}");
}

#[test]
fn the_definition_is_consistent() {
    Cli::command().debug_assert();
}

#[test]
fn every_command_has_an_example_in_its_help() {
    for command in Cli::command().get_subcommands_mut() {
        let help = command.render_long_help().to_string();
        assert!(help.contains("Example"), "{}: {help}", command.get_name());
        assert!(help.contains("  isokit "), "{}: {help}", command.get_name());
    }
}

#[test]
fn negative_numbers_are_values_and_not_options() {
    let args = extract(
        "a.nii --iso -300:skin:#d8a58080 --iso 300 -o a.glb --origin -1,-2,-3 --roi-mm -9:9,:,:",
    );
    assert_eq!(args.iso[0].iso, IsoChoice::Value(-300.0));
    assert_eq!(args.iso[0].name.as_deref(), Some("skin"));
    assert_eq!(args.iso[1].iso, IsoChoice::Value(300.0));
    assert_eq!(args.roi_mm, Region::parse_world("-9:9,:,:").ok());
}

#[test]
fn an_option_swallowed_as_a_value_is_noticed() {
    refused("extract a.nii -o a.glb --iso -v", "found \"-v\"");
}

#[test]
fn options_common_to_all_stand_before_or_after_the_command() {
    for line in ["--threads 2 check a.ply", "check a.ply --threads 2"] {
        let cli = Cli::try_parse_from(format!("isokit {line}").split(' ')).unwrap();
        assert_eq!(cli.common.threads.unwrap().get(), 2);
    }
}

#[test]
fn what_is_not_built_is_not_accepted() {
    for option in ["--keep largest", "--simplify 1", "--labels all"] {
        refused(&format!("extract a.nii --iso 1 -o a.glb {option}"), "unexpected argument");
    }
    refused("extract a.nii --iso 1 -o a.glb --placement spline", "invalid value 'spline'");
}

#[test]
fn what_is_missing_or_excluded_is_named() {
    refused("extract a.nii --iso 1", "--output <FILE>");
    refused("extract a.raw --dims 1,2,3 --iso 1 -o a.glb", "--dtype <TYPE>");
    refused("extract a.nii --iso 1 -o a.glb --roi :,:,: --roi-mm :,:,:", "cannot be used with");
    refused("extract a.nii --iso 1 -o a.glb --repeat 3", "--report <FILE>");
    refused("check a.ply -q -v", "cannot be used with");
}

#[test]
fn a_count_is_one_or_more() {
    for option in ["--threads", "--repeat", "--repeat-warm"] {
        let line = format!("extract a.nii --iso 1 -o a.glb --report r.json {option} 0");
        refused(&line, ": expected 1 or more, found 0");
    }
}

#[test]
fn a_percentage_is_between_the_least_and_the_greatest() {
    for percent in ["0%", "12.5%", "100%"] {
        let args = extract(&format!("a.nii -o a.glb --iso {percent}"));
        assert_eq!(args.iso[0].iso.to_string(), percent);
    }
    for percent in ["150%", "-5%", "1e308%", "100.0001%", "nan%"] {
        let line = format!("extract a.nii -o a.glb --iso {percent}");
        refused(&line, &format!("a percentage from 0% to 100%, or auto, found {percent:?}"));
    }
}

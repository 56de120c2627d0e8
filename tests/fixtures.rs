//! The committed fixtures are what their makers make.

use isokit_tests::{fixtures, workspace};
use std::{env, fs};

/// `UPDATE=1 cargo test -p isokit-tests --test fixtures` writes the files again.
#[test]
fn fixtures_are_what_the_generator_makes() {
    let folder = workspace::root().join("fixtures/volumes");
    let made = fixtures::all();
    for fixture in &made {
        let path = folder.join(fixture.name);
        let is_current = || fs::read(&path).is_ok_and(|file| fixture.is_held_by(&file));
        if env::var_os("UPDATE").is_some() && !is_current() {
            fs::write(&path, fixture.file()).unwrap();
        }
        assert!(is_current(), "{}: run scripts/fixtures", fixture.name);
    }
    for entry in fs::read_dir(&folder).unwrap() {
        let name = entry.unwrap().file_name();
        let is_made = made.iter().any(|fixture| name == fixture.name);
        assert!(is_made, "fixtures/volumes/{} is made by nobody", name.display());
    }
}

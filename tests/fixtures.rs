//! The committed fixtures are what their makers make, and the library reads in them what was put there.

use isokit::{
    io::{VolumeOptions, read_volume},
    job::Job,
};
use isokit_tests::{fixtures, workspace};
use std::{env, fs};

/// `UPDATE=1 cargo test -p isokit-tests --test fixtures` writes the files again.
#[test]
fn fixtures_are_what_the_generator_makes() {
    let folder = workspace::root().join("fixtures/volumes");
    let made = fixtures::all();
    for fixture in made {
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

/// Samples, sizes and meaning to the bit, the lattice's place to the bit too.
#[test]
fn every_fixture_is_read_as_it_was_made() {
    let folder = workspace::root().join("fixtures/volumes");
    for fixture in fixtures::all() {
        let path = folder.join(fixture.name);
        let found = read_volume(&path, &VolumeOptions::default(), &Job::default()).unwrap();
        let (found, made) = (found.volume, &fixture.volume);
        assert_eq!(found.grid(), made.grid(), "{}", fixture.name);
        assert_eq!(found.scaling(), made.scaling(), "{}", fixture.name);
        // Not `assert_eq`: two volumes fill a screen.
        assert!(found == *made, "{}: samples differ", fixture.name);
    }
}

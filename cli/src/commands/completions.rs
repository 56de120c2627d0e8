//! `completions`: a script for a shell, made from the definition of the command line.

use crate::{
    Exit, Session,
    args::{Cli, CompletionsArgs},
};
use anyhow::Result;
use clap::CommandFactory;

pub(crate) fn run(args: &CompletionsArgs, session: &mut Session<'_, '_>) -> Result<Exit> {
    // The generator panics if it cannot write, so it writes to memory.
    let mut script = vec![];
    clap_complete::generate(args.shell, &mut Cli::command(), "isokit", &mut script);
    session.out.write_all(&script)?;
    Ok(Exit::Done)
}

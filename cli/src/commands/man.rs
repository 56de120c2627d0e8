//! `man`: manual pages, made from the definition of the command line.

use crate::{
    Exit, Session,
    args::{Cli, ManArgs},
};
use anyhow::{Context, Result};
use clap::CommandFactory;
use clap_mangen::Man;

pub(crate) fn run(args: &ManArgs, session: &mut Session<'_, '_>) -> Result<Exit> {
    let mut main = Cli::command();
    main.build();
    let Some(dir) = &args.dir else {
        let mut page = vec![];
        Man::new(main).render(&mut page)?;
        session.out.write_all(&page)?;
        return Ok(Exit::Done);
    };
    let commands = main.get_subcommands().filter(|command| command.get_name() != "help");
    for command in commands.chain([&main]) {
        let page = Man::new(command.clone());
        let path = dir.join(page.get_filename());
        let mut output = isokit::io::Output::create(&path)?;
        page.render(&mut output).with_context(|| format!("{}: cannot write", path.display()))?;
        output.finish()?;
        session.console.info(&format!("wrote {}", path.display()));
    }
    Ok(Exit::Done)
}

//! Runs `wetcor completions` and `wetcor man`: prints what a shell and a reader of manual pages find of the command line.

use clap_complete::Shell;
use clap_mangen::Man;
use wetcor::error::Error;

use super::arguments;
use super::messages::print_result;

/// Prints the script by which a shell completes the command line.
pub(super) fn completions(shell: Shell) -> Result<u8, Error> {
    let mut command = arguments::definition();
    let name = command.get_name().to_owned();
    let mut script = vec![];
    clap_complete::generate(shell, &mut command, name, &mut script);
    print_result(&String::from_utf8_lossy(&script))?;
    Ok(0)
}

/// Prints the manual page of the program or of one of its commands.
pub(super) fn man(command: Option<&str>) -> Result<u8, Error> {
    let mut program = arguments::definition();
    program.build();
    // only names of commands are read
    let described = command
        .and_then(|name| program.find_subcommand(name))
        .unwrap_or(&program);
    let source = format!("{} {}", program.get_name(), program.get_version().unwrap_or_default());
    let mut page = vec![];
    let rendered = Man::new(described.clone()).source(source).render(&mut page);
    rendered.map_err(Error::internal("write a manual page"))?;
    print_result(&String::from_utf8_lossy(&page))?;
    Ok(0)
}

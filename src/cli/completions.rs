//! Runs `wetcor completions`: prints the script by which a shell completes the command line.

use clap_complete::Shell;
use wetcor::error::Error;

use super::arguments;
use super::messages::print_result;

pub(super) fn completions(shell: Shell) -> Result<u8, Error> {
    let mut command = arguments::definition();
    let name = command.get_name().to_owned();
    let mut script = vec![];
    clap_complete::generate(shell, &mut command, name, &mut script);
    print_result(&String::from_utf8_lossy(&script))?;
    Ok(0)
}

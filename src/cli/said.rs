//! Says things to the user: notices on standard error, results on standard output.

use std::io::{IsTerminal, Write};
use std::path::Path;

use wetcor::error::Error;
use wetcor::notice::Notice;

/// A word before a message, coloured on a terminal only.
pub(super) fn label(word: &str, colour: &str) -> String {
    let plain = !std::io::stderr().is_terminal() || std::env::var_os("NO_COLOR").is_some();
    if plain {
        word.to_owned()
    } else {
        format!("{colour}{word}\u{1b}[0m")
    }
}

pub(super) fn warn(text: &str) {
    let _ = writeln!(std::io::stderr(), "{}: {text}", label("notice", "\u{1b}[1;33m"));
}

pub(super) fn tell(notices: &[Notice], quiet: bool) {
    if !quiet {
        for notice in notices {
            warn(&notice.text);
        }
    }
}

/// Prints to standard output. A reader that has left is no error.
pub(super) fn say(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::io(Path::new("standard output"), "write", error))
        }
        _ => Ok(()),
    }
}

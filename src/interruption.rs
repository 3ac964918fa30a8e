//! Ends the process when it is interrupted: what was being written is gone, what was written stands.

use std::io;

use crate::staging;

/// What an interrupted command could not do: run.
pub const STATUS: i32 = 2;

/// Waits for SIGINT, SIGTERM and SIGHUP from now on, and has `say` told what the interruption leaves.
///
/// Fails where the system refuses a signal or a thread; an interruption then leaves a folder for the next run to clear.
pub fn watch(say: impl Fn(&str) + Send + 'static) -> io::Result<()> {
    // a file beyond the user's limit is then refused as on a full disk is, and no longer the end of the process
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default())?;
    let end = move || {
        let abandoned = staging::abandon();
        say(if abandoned.was_put() {
            "interrupted; what was written stands"
        } else {
            "interrupted; nothing was written"
        });
        std::process::exit(STATUS);
    };
    ctrlc::set_handler(end).map_err(io::Error::other)
}

//! Shows on a terminal what takes longer than half a second.

use std::sync::mpsc::{channel, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);

/// A line on the terminal that names the work under way; silent off a terminal.
pub struct Progress {
    bar: ProgressBar,
    started: Instant,
    /// the thread that shows again and again that work of unknown length goes on, until its sender is dropped
    ticker: Option<(Sender<()>, JoinHandle<()>)>,
}

/// `None` where there is no terminal to show it on, or no thread is to be had: the work goes on without.
fn ticker(bar: &ProgressBar) -> Option<(Sender<()>, JoinHandle<()>)> {
    if bar.is_hidden() {
        return None;
    }
    let (work, ended) = channel::<()>();
    let bar = bar.clone();
    let tick = move || {
        // the first tick comes after one interval: short work never draws
        while ended.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
            bar.tick();
        }
    };
    let thread = std::thread::Builder::new().spawn(tick).ok()?;
    Some((work, thread))
}

impl Progress {
    /// Work of unknown length.
    pub fn spinner(what: &'static str, quiet: bool) -> Progress {
        let bar = ProgressBar::with_draw_target(None, target(quiet)).with_message(what);
        bar.set_style(ProgressStyle::default_spinner());
        Progress {
            ticker: ticker(&bar),
            bar,
            started: Instant::now(),
        }
    }

    /// Work of known length.
    pub fn bar(what: &'static str, length: u64, quiet: bool) -> Progress {
        let bar = ProgressBar::with_draw_target(Some(length), target(quiet)).with_message(what);
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {human_pos}/{human_len} {eta}") {
            bar.set_style(style);
        }
        Progress {
            bar,
            started: Instant::now(),
            ticker: None,
        }
    }

    /// Says that the work is longer than was known.
    pub fn lengthen(&self, length: u64) {
        self.bar.set_length(length);
    }

    /// Says how far the work has come.
    pub fn at(&self, position: u64) {
        if self.started.elapsed() >= PATIENCE {
            self.bar.set_position(position);
        }
    }

    /// Says something beside the name of the work.
    pub fn say(&self, text: String) {
        if self.started.elapsed() >= PATIENCE {
            self.bar.set_message(text);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        // before the line is cleared, so that no tick draws it again
        if let Some((work, thread)) = self.ticker.take() {
            drop(work);
            // one that ended in a panic has ended, too
            let _ = thread.join();
        }
        self.bar.finish_and_clear();
    }
}

fn target(quiet: bool) -> ProgressDrawTarget {
    if quiet {
        ProgressDrawTarget::hidden()
    } else {
        // hides itself where standard error is no terminal
        ProgressDrawTarget::stderr()
    }
}

//! Shows on a terminal what takes longer than half a second, unless only errors are to be told.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{channel, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_millis(500);

/// Whether only errors are to be told.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on only errors are to be told.
pub fn be_quiet() {
    QUIET.store(true, Relaxed);
}

/// Whether only errors are to be told.
pub fn is_quiet() -> bool {
    QUIET.load(Relaxed)
}

/// A line on the terminal that names the work under way; silent off a terminal.
pub struct Progress {
    bar: ProgressBar,
    started: Instant,
    /// how much of the work [`Progress::add`] has counted
    done: AtomicU64,
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
    pub fn spinner(what: &'static str) -> Progress {
        let bar = ProgressBar::with_draw_target(None, target()).with_message(what);
        bar.set_style(ProgressStyle::default_spinner());
        let ticker = ticker(&bar);
        Progress::new(bar, ticker)
    }

    /// Work of known length.
    pub fn bar(what: &'static str, length: u64) -> Progress {
        let bar = ProgressBar::with_draw_target(Some(length), target()).with_message(what);
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {human_pos}/{human_len} {eta}") {
            bar.set_style(style);
        }
        Progress::new(bar, None)
    }

    fn new(bar: ProgressBar, ticker: Option<(Sender<()>, JoinHandle<()>)>) -> Progress {
        Progress {
            bar,
            started: Instant::now(),
            done: AtomicU64::new(0),
            ticker,
        }
    }

    /// How long the work is, as far as is known.
    pub fn length(&self) -> u64 {
        self.bar.length().unwrap_or_default()
    }

    /// Says how far the work has come.
    pub fn at(&self, position: u64) {
        if self.started.elapsed() >= PATIENCE {
            self.bar.set_position(position);
        }
    }

    /// Says that so much more of the work is done.
    pub fn add(&self, more: u64) {
        self.at(more + self.done.fetch_add(more, Relaxed));
    }

    /// The same of work that may be longer than was known: at its end it is taken to go on for so much.
    pub fn add_beyond(&self, more: u64, longer: u64) {
        self.add(more);
        let done = self.done.load(Relaxed);
        if done > self.length() {
            self.bar.set_length(done.saturating_add(longer));
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

fn target() -> ProgressDrawTarget {
    if is_quiet() {
        ProgressDrawTarget::hidden()
    } else {
        // hides itself where standard error is no terminal
        ProgressDrawTarget::stderr()
    }
}

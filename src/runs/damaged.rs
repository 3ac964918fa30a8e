//! Catches the panic of a library that reads a damaged file, and passes a panic of our own on.
//!
//! Tables are read on several threads at once, and the panic hook is one for the process: it is set once and asks which
//! thread panicked, and in whose source.

use std::cell::Cell;
use std::panic::{catch_unwind, resume_unwind, set_hook, take_hook, AssertUnwindSafe, PanicHookInfo};
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::Once;

/// Where the sources of this crate lie, as a panic names them.
const OWN_SOURCES: &str = file!().split_at(file!().len() - "runs/damaged.rs".len()).0;

/// How the threads are called that polars reads with.
const OF_POLARS: &str = "polars";

/// Readings in progress, on all threads.
static READINGS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    /// readings in progress on this thread
    static HERE: Cell<usize> = const { Cell::new(0) };
    /// whether the last panic here was our own
    static OWN: Cell<bool> = const { Cell::new(false) };
}

/// Does a step of reading; `None` where a library panicked in it, which is not printed.
pub(super) fn unless_damaged<T>(step: impl FnOnce() -> T) -> Option<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |info| {
            if !is_of_library(info) {
                before(info);
            }
        }));
    });
    READINGS.fetch_add(1, SeqCst);
    HERE.set(HERE.get() + 1);
    OWN.set(false);
    let done = catch_unwind(AssertUnwindSafe(step));
    READINGS.fetch_sub(1, SeqCst);
    HERE.set(HERE.get() - 1);
    match done {
        Ok(done) => Some(done),
        Err(own) if OWN.get() => resume_unwind(own),
        Err(_) => None,
    }
}

/// Whether it is a library that panics, in a reading.
fn is_of_library(info: &PanicHookInfo) -> bool {
    let here = HERE.get() > 0;
    let own = info.location().is_some_and(|at| at.file().starts_with(OWN_SOURCES));
    if here {
        OWN.set(own);
    }
    let reads_for_us = || {
        let thread = std::thread::current();
        READINGS.load(SeqCst) > 0 && thread.name().is_some_and(|name| name.starts_with(OF_POLARS))
    };
    !own && (here || reads_for_us())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// What a library does with a file that claims more than it holds.
    fn library_panics() {
        nalgebra::DMatrix::<f64>::zeros(1, 1).swap_rows(std::hint::black_box(5), 0);
    }

    #[test]
    fn a_library_may_panic_and_we_may_not() {
        assert_eq!(unless_damaged(|| 7), Some(7));
        assert_eq!(unless_damaged(library_panics), None);
        let own = catch_unwind(|| unless_damaged(|| [1, 2][std::hint::black_box(2)]));
        assert!(own.is_err(), "a defect of ours is no damaged file");
        assert_eq!(unless_damaged(library_panics), None, "the one before is forgotten");
        let beside = catch_unwind(|| unless_damaged(|| catch_unwind(|| panic!("ours")).is_err()));
        assert_eq!(
            beside.ok().flatten(),
            Some(true),
            "what was caught inside is not passed on"
        );
    }

    /// With a hook that each reading swaps, two at once leave the wrong one in place.
    #[test]
    fn readings_at_once_silence_nobody_else() {
        unless_damaged(|| ());
        let seen = Arc::new(AtomicUsize::new(0));
        let (count, before) = (Arc::clone(&seen), take_hook());
        set_hook(Box::new(move |info| {
            if info.payload().downcast_ref::<&str>() == Some(&"somebody else") {
                count.fetch_add(1, SeqCst);
            } else {
                before(info);
            }
        }));
        let alone = || {
            std::thread::spawn(|| std::panic::panic_any("somebody else"))
                .join()
                .is_err()
        };
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| (0..200).for_each(|_| assert_eq!(unless_damaged(library_panics), None)));
            }
            assert!((0..50).all(|_| alone()));
        });
        assert!(alone());
        assert_eq!(seen.load(SeqCst), 51);
    }
}

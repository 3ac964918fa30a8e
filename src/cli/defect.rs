//! Makes one line of a panic: it says what happened and where, and asks for a report.

use std::panic::{catch_unwind, set_hook, take_hook, AssertUnwindSafe, PanicHookInfo};
use std::sync::{Arc, Mutex, PoisonError};

use wetcor::error::{plain, Error};

/// Does some work; the first panic in it, of whatever thread, is an error.
///
/// What was begun is unwound, so that temporary files go with what stands for them. What a library panics over as it reads a
/// damaged file is caught further down and does not come here.
pub(super) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, Error> {
    let first: Arc<Mutex<Option<Error>>> = Arc::default();
    let seen = Arc::clone(&first);
    let before = take_hook();
    set_hook(Box::new(move |info| {
        let mut first = seen.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert_with(|| defect(info));
    }));
    let done = catch_unwind(AssertUnwindSafe(work));
    set_hook(before);
    let defect = first.lock().unwrap_or_else(PoisonError::into_inner).take();
    match (done, defect) {
        (Ok(done), None) => Ok(done),
        (_, Some(defect)) => Err(defect),
        // a panic that calls no hook, as one that is only passed on from another thread
        (Err(payload), None) => Err(line(text(payload.as_ref()), "")),
    }
}

fn defect(info: &PanicHookInfo) -> Error {
    let place = info.location().map(|at| format!(" ({}:{})", at.file(), at.line()));
    line(text(info.payload()), &place.unwrap_or_default())
}

fn line(message: &str, place: &str) -> Error {
    let message = plain(message, usize::MAX);
    Error::Usage(format!(
        "a defect of wetcor: {message}{place}; please report it with the scene and the runs"
    ))
}

/// What a panic says.
fn text(payload: &(dyn std::any::Any + Send)) -> &str {
    let owned = payload.downcast_ref::<String>().map(String::as_str);
    owned
        .or(payload.downcast_ref::<&str>().copied())
        .unwrap_or("no message")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sets a flag when it goes, as a temporary folder removes itself.
    struct Temporary<'f>(&'f std::sync::atomic::AtomicBool);

    impl Drop for Temporary<'_> {
        fn drop(&mut self) {
            self.0.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    }

    /// One test: the hook is one for the whole process.
    #[test]
    fn a_panic_becomes_one_line_and_what_was_begun_is_unwound() {
        let message_of = |outcome: Result<u8, Error>| outcome.expect_err("a panic").to_string();
        assert_eq!(caught(|| 7).expect("no panic"), 7);

        let gone = std::sync::atomic::AtomicBool::new(false);
        let message = message_of(caught(|| {
            let _temporary = Temporary(&gone);
            panic!("two\nlines \u{1b}[2J of {}", "it")
        }));
        assert!(
            message.starts_with("a defect of wetcor: two\\nlines \\u{1b}[2J of it (src/cli/defect.rs:"),
            "{message}"
        );
        assert!(
            message.ends_with("); please report it with the scene and the runs"),
            "{message}"
        );
        assert!(!message.chars().any(char::is_control) && gone.load(std::sync::atomic::Ordering::Relaxed));

        // of several threads the first one is reported
        use rayon::prelude::*;
        let in_threads = || {
            (0..64)
                .into_par_iter()
                .map(|i: u8| if i % 2 == 1 { panic!("thread {i}") } else { i })
                .sum()
        };
        let message = message_of(caught(in_threads));
        assert!(
            message.contains("a defect of wetcor: thread ") && message.matches("thread").count() == 1,
            "{message}"
        );

        // of a thread that nobody waits for
        let alone = || std::thread::spawn(|| panic!("alone")).join().map_or(1, |()| 0);
        assert!(message_of(caught(alone)).contains("alone"));
    }
}

//! Starts the threads of every pool, or fewer where the system gives no more.
//!
//! A pool that cannot start all of its threads panics, and that of the table reader is not ours to build. So it is tried
//! first how many the system gives.

use std::io;
use std::sync::RwLock;

use wetcor::error::Error;

use super::messages::warn;

/// Threads that may be used on any machine; more than that only where it runs more at once. Idle ones look for work at
/// each other: on two processors a small fit takes 1.2 s with 64, 3.5 s with 256 and more than a minute with 1,024.
const MOST: usize = 64;

/// Threads besides those of the pools: the one that hears signals, and the one that shows that work is under way.
const BESIDE: usize = 2;

/// How many of so many threads the system gives at once, and why not more.
fn given(most: usize) -> (usize, Option<io::Error>) {
    let gate = RwLock::new(());
    std::thread::scope(|scope| {
        // all of them last until it opens
        let _closed = gate.write();
        for started in 0..most {
            let waiting = std::thread::Builder::new().spawn_scoped(scope, || drop(gate.read()));
            if let Err(error) = waiting {
                return (started, Some(error));
            }
        }
        (most, None)
    })
}

/// Address space that a fit of the example, 2,000 runs, takes with up to eight threads, bytes: in 512 MB one of six was ended
/// by the system, in 640 MB none.
#[cfg(unix)]
const LEAST_ADDRESS_SPACE: u64 = 640 << 20;

/// Refuses to begin where the system was told to give less memory than any fit takes: what is refused later ends a program
/// there and then.
pub(super) fn check_address_space() -> Result<(), Error> {
    #[cfg(unix)]
    {
        let limit = rustix::process::getrlimit(rustix::process::Resource::As).current;
        if let Some(limit) = limit.filter(|limit| *limit < LEAST_ADDRESS_SPACE) {
            return Err(Error::Usage(format!(
                "the system gives a process {} MB of address space (`ulimit -v`); wetcor takes {} MB to fit a laboratory's table",
                limit >> 20,
                LEAST_ADDRESS_SPACE >> 20
            )));
        }
    }
    Ok(())
}

/// Starts our pool and bounds the table reader's, which is its own and reads its size from the environment when it is first
/// used: both with so many threads, or with as many as the machine runs at once.
///
/// Fails where the system does not even give one to each.
pub(super) fn start(requested: Option<u16>) -> Result<(), Error> {
    let machine = std::thread::available_parallelism().map_or(1, usize::from);
    let requested = requested.map_or(machine, usize::from);
    let wanted = requested.min(MOST.max(machine));
    if wanted < requested {
        warn(&format!(
            "{wanted} in place of {requested} threads: this machine runs {machine} at once, more would only wait"
        ));
    }
    let (started, refused) = given(2 * wanted + BESIDE);
    let each = started.saturating_sub(BESIDE) / 2;
    let reason = refused.map(|error| error.to_string()).unwrap_or_default();
    if each == 0 {
        let least = 2 + BESIDE;
        return Err(Error::Usage(format!(
            "cannot start the {least} threads that the least work takes: {reason}"
        )));
    }
    if each < wanted {
        warn(&format!(
            "{each} in place of {wanted} threads: no more could be started ({reason})"
        ));
        // the system counts a thread a moment longer than it lasts
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::env::set_var("POLARS_MAX_THREADS", each.to_string());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(each);
    pool.build_global().map_err(Error::internal("start the threads"))
}

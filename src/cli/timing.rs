//! Times the stages of a fit, and shows which is running.

use std::sync::OnceLock;
use std::time::Instant;

use crate::progress::Progress;

/// Seconds each stage took, for `timing.json`.
pub(super) struct Timing {
    pub(super) started: Instant,
    pub(super) stages: Vec<(&'static str, f64)>,
}

impl Timing {
    /// A stage that shows that it is running.
    pub(super) fn stage<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let _progress = Progress::spinner(name);
        self.time(name, work)
    }

    /// A stage that shows by itself how far it is.
    pub(super) fn time<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let started = Instant::now();
        let done = work();
        self.stages.push((name, started.elapsed().as_secs_f64()));
        done
    }

    /// Least squares, and the bootstrap from the first replicate it hears of.
    pub(super) fn fits<T>(&mut self, replicates: u64, work: impl FnOnce(&(dyn Fn(usize) + Sync)) -> T) -> T {
        let started = Instant::now();
        let progress = Progress::bar("bootstrap", replicates);
        let bootstrap = OnceLock::new();
        let done = work(&|more| {
            bootstrap.get_or_init(Instant::now);
            progress.add(more as u64);
        });
        let ended = Instant::now();
        let fitted = *bootstrap.get().unwrap_or(&ended);
        self.stages.push(("least_squares", (fitted - started).as_secs_f64()));
        if fitted != ended {
            self.stages.push(("bootstrap", (ended - fitted).as_secs_f64()));
        }
        done
    }

    pub(super) fn json(&self) -> String {
        let mut stages: Vec<String> = self
            .stages
            .iter()
            .map(|(name, seconds)| format!("  \"{name}\": {seconds:.6}"))
            .collect();
        stages.push(format!("  \"all\": {:.6}", self.started.elapsed().as_secs_f64()));
        format!("{{\n{}\n}}\n", stages.join(",\n"))
    }
}

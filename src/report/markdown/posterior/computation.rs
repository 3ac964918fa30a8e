//! Tells how the posterior was sampled, by which software, and whether the chains agree.

use super::super::super::numbers;
use super::super::super::{figures, Told};
use super::super::page::Page;
use super::{checks, of_prediction};
use crate::findings::posterior::Posterior;
use crate::inference::sampling::CHECKED;

/// The crate that samples, in the version in use.
const SAMPLER: (&str, &str) = ("nuts-rs", "0.19.1");

/// Software, sampling, compression and the table of convergence.
pub(super) fn computation(page: &mut Page, told: Told, posterior: &Posterior) {
    let found = &posterior.findings;
    page.subheading("Computation");
    let (sampler, version) = SAMPLER;
    page.paragraph(&format!(
        "wetcor {}, with the No-U-Turn sampler of {sampler} {version}: {} chains × ({} to adapt + {} kept) draws, seed \
         {}. Bounded parameters are mapped onto the whole line, and the space is made round by the curvature at the mode, \
         which is sought from least squares and from the medians of the priors; the chains start about it.",
        told.findings.wetcor, found.chains, found.warmup, found.draws, told.findings.seed
    ));
    page.paragraph(&match &found.compression {
        Some(made) if made.rows == 0 => {
            format!("Without wet runs the likelihood is a sum in closed form (method `{}`).", found.method)
        }
        Some(made) => format!(
            "The likelihood was evaluated at {} nodes in place of {} wet runs (method `{}`). The allowed error of the log \
             density is {}; the largest difference from the sum over every run, at up to {CHECKED} of the kept draws, is \
             {}.",
            made.nodes,
            made.rows,
            found.method,
            numbers::short(made.bound),
            numbers::significant(made.max_log_density_error, 2)
        ),
        None => format!("Every run entered every evaluation of the likelihood (method `{}`).", found.method),
    });
    checks(page, posterior.checks.iter().filter(|check| !of_prediction(check)));
    page.figure(
        figures::RANKS,
        "ranks by chain",
        "How often each chain falls into equal bins of the ranks of all draws, over its even share of 1. Chains that agree \
         stay near 1; grey is two standard deviations of as many independent draws.",
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sampler_is_told_in_the_version_the_lock_file_has() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock");
        let lock = std::fs::read_to_string(path).expect("the lock file is there");
        let (name, version) = SAMPLER;
        let entry = format!("name = \"{name}\"\nversion = \"{version}\"\n");
        assert!(lock.replace('\r', "").contains(&entry), "{entry}");
    }
}

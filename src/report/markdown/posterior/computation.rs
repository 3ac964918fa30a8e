//! Writes how the posterior was sampled, and by which software.

use super::super::super::numbers;
use super::super::super::ReportInput;
use super::super::page::Page;
use crate::findings::posterior::{AccuracySummary, Posterior, PosteriorFindings, CHECKED_RUNS};
use crate::inference::sampling::{Method, MOST_TIMES};

/// The crate that samples, in the version in use.
const SAMPLER: (&str, &str) = ("nuts-rs", "0.19.1");

/// Software, sampling, and what stood for very many runs.
pub(super) fn computation(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    let found = &posterior.findings;
    page.subheading("Computation");
    page.paragraph(&format!(
        "wetcor {}, {}, seed {}. Bounded parameters are mapped onto the whole line; the mode is sought from least squares \
         and from the medians of the priors.{}",
        input.findings.wetcor,
        method(found),
        input.findings.seed,
        if found.method == Method::Nuts {
            " Parameters are rescaled by the Hessian at the mode, near which the chains start."
        } else {
            ""
        }
    ));
    if let Some(accuracy) = &found.accuracy {
        page.paragraph(&chosen_for(accuracy, found.method));
    }
    page.paragraph(&match &found.compression {
        Some(few) => format!(
            "{} wet runs stand for {} (method `{}`). The allowed error of the log density is {}; the largest difference from \
             the sum over every run{}, at up to {CHECKED_RUNS} of the kept draws and a constant apart, is {}.",
            few.nodes,
            few.rows,
            found.method.name(),
            numbers::short(few.bound),
            match few.held_against {
                None => "",
                Some(_) => ", in proportion from that over an even sample of them",
            },
            numbers::significant(few.max_log_density_error, 2)
        ),
        None => format!(
            "The likelihood takes every run each time (method `{}`).",
            found.method.name()
        ),
    });
}

/// How the draws were made.
fn method(found: &PosteriorFindings) -> String {
    let (chains, draws) = (found.chains, found.draws);
    match found.method {
        Method::Laplace => {
            format!("draws from the normal with the mode and the curvature of the posterior, {chains} × {draws}")
        }
        Method::LaplacePsis => format!(
            "draws from Student's t with the mode and the curvature of the posterior, weighed by what the posterior has \
             there (Pareto-smoothed importance weights) and resampled to {chains} × {draws}"
        ),
        Method::Nuts => {
            let (sampler, version) = SAMPLER;
            let asked = match found.draws_asked {
                Some(asked) if asked < draws => {
                    format!(" ({asked} were asked for; the chains were drawn on until they agreed, or to {MOST_TIMES} times that)")
                }
                _ => String::new(),
            };
            format!(
                "with the No-U-Turn sampler of {sampler} {version}: {chains} chains × ({} to adapt + {draws} kept) \
                 draws{asked}",
                found.warmup
            )
        }
    }
}

/// What accuracy was asked for, and why this method was taken.
fn chosen_for(accuracy: &AccuracySummary, method: Method) -> String {
    let vouched = match accuracy.vouched {
        Some(error) => format!("vouches for {}", numbers::significant(error, 2)),
        None => "cannot vouch for any".to_owned(),
    };
    let tried: Vec<String> = accuracy
        .tried
        .iter()
        .map(|tried| format!("`{}`: {}", tried.method.name(), tried.why))
        .collect();
    let before = if tried.is_empty() {
        "No method is cheaper.".to_owned()
    } else {
        format!("Cheaper methods did not do: {}.", tried.join("; "))
    };
    format!(
        "An accuracy of {} was asked for: the largest error of any mean, in posterior sds, and of any sd, relative. \
         `{}` {vouched}. {before}",
        numbers::short(accuracy.requested),
        method.name()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sampler_is_named_in_the_version_the_lock_file_has() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.lock");
        let lock = std::fs::read_to_string(path).expect("the lock file is there");
        let (name, version) = SAMPLER;
        let entry = format!("name = \"{name}\"\nversion = \"{version}\"\n");
        assert!(lock.replace('\r', "").contains(&entry), "{entry}");
    }
}

//! Runs `wetcor fit`: every stage asked for, and the report of what was found.

use std::path::{Path, PathBuf};
use std::time::Instant;

use wetcor::error::{named, Error};
use wetcor::findings::posterior::Way;
use wetcor::findings::{self, overview, verdicts};
use wetcor::model::parameters::Parameters;
use wetcor::report::folder::{Contents, Destination};
use wetcor::report::{self, markdown, Told};
use wetcor::{runs, scene};

use super::arguments::Stage;
use super::draws::Draws;
use super::said::{say_of, tell};
use super::timing::Timing;

/// Models that are sampled besides the scene's own: forms of the law, and trends with the film.
const COMPARED: u64 = 10;

/// Ran, and a gating verdict failed.
const NOT_QUOTABLE: u8 = 1;

pub(super) fn fit(
    path: &Path,
    out: Option<PathBuf>,
    seed: u64,
    (stages, way): (&[Stage], Way),
    quiet: bool,
) -> Result<u8, Error> {
    let mut timing = Timing {
        started: Instant::now(),
        stages: vec![],
    };
    let wanted = |stage: Stage| stages.is_empty() || stages.contains(&stage);
    if !wanted(Stage::LeastSquares) {
        return Err(Error::Usage(
            "every stage starts from the fits: add least_squares to --stages".to_owned(),
        ));
    }
    if wanted(Stage::Compare) && !wanted(Stage::Posterior) {
        return Err(Error::Usage(
            "compare starts from the posterior: add posterior to --stages".to_owned(),
        ));
    }
    let scene = scene::read(path)?;
    let out = out.unwrap_or_else(|| Path::new("reports").join(&scene.name));
    let destination = Destination::prepare(&out, Contents::Fit, &scene.title, &[path, &scene.data.runs])?;
    let table = timing.stage("read", quiet, || runs::read(&scene))?;
    if wanted(Stage::Posterior) {
        // a prior without room is told now, not after the bootstrap
        Parameters::of(&scene, &table.runs, scene.model.form())?;
    }
    let mut findings = timing.fits(scene.bootstrap.replicates, quiet, |done| {
        findings::find_watched(&scene, &table, seed, wanted(Stage::Bootstrap), done)
    });
    let overview = overview::find(&scene, &table, &findings);
    let mut posterior = None;
    if wanted(Stage::Posterior) {
        let draws = Draws::of(&scene, quiet, "posterior", 1);
        let runs = &table.runs;
        posterior = timing.stage("posterior", true, || {
            findings.add_posterior(&scene, runs, way, &|kept, diverging| draws.one(kept, diverging))
        })?;
        drop(draws);
        if let Some(posterior) = &posterior {
            let parts = ["posterior_compressing", "posterior_sampling", "posterior_checking"];
            timing.stages.extend(parts.into_iter().zip(posterior.sampled.seconds));
        }
    }
    if let Some(posterior) = posterior.as_ref().filter(|_| wanted(Stage::Compare)) {
        let draws = Draws::of(&scene, quiet, "compare", COMPARED);
        timing.stage("compare", true, || {
            let watcher = |kept, diverging| draws.one(kept, diverging);
            findings.add_comparison(&scene, &table.runs, posterior, &watcher)
        })?;
    }
    let told = Told {
        scene: &scene,
        runs: &table.runs,
        overview: &overview,
        findings: &findings,
        posterior: posterior.as_ref(),
    };
    let files = timing.stage("report", quiet, || report::files(told, wanted(Stage::Figures)));
    let mut files = files?;
    let began = Instant::now();
    files.last = Some(Box::new(move || {
        timing.stages.push(("write", began.elapsed().as_secs_f64()));
        ("timing.json".to_owned(), timing.json().into_bytes())
    }));
    destination.write(files)?;
    tell(&findings.notices, quiet);
    if !quiet {
        let report = out.join("report.md");
        let text = format!("{}report: {}\n", markdown::summary(told), named(&report));
        say_of(&report, &text)?;
    }
    Ok(if verdicts::quotable(&findings.verdicts) {
        0
    } else {
        NOT_QUOTABLE
    })
}

//! Judges what must hold before the numbers are quoted, and collects what wants a second look.

use super::balance::EnergyBalance;
use super::dry::{self, Dry};
use super::fit_columns::speeds_err;
use super::fit_verdict::f_words;
use super::noise::{Noise, WetAlternative};
use super::remarks::{self, shortened, Kind};
use super::scaling::Scaling;
use super::series::SeriesFit;
use super::wet_fit::FitSetup;
use super::which_law::LineAgainstRoot;
use crate::inference::effective_variance::ErrorSummary;
use crate::inference::lack_of_fit::Alternative;
use crate::inference::nested::FTest;
use crate::model::parameters::ParameterKind;
use crate::physics::DrySpeed;
use crate::remark::{Level, Remark};
use crate::rounding::{by_number, significant};
use crate::runs::{Runs, Screened, Table, NOTHING_USES, OTHER_LABEL};
use crate::scene::{Scene, WetLaw};

/// Every check of a least-squares analysis.
pub fn check_least_squares(
    FitSetup { scene, dry, .. }: FitSetup,
    table: &Table,
    scaling: &[Scaling],
    balance: Option<&EnergyBalance>,
    line: Option<&LineAgainstRoot>,
) -> Vec<Remark> {
    let mut checks = vec![];
    checks.extend(dry_laws(dry));
    match line.filter(|line| line.favours_line()) {
        Some(line) => checks.push(linear_law(line)),
        None => {
            checks.extend(scaling_laws(scaling, balance));
            checks.extend(line.map(linear_law));
        }
    }
    checks.extend(balance.into_iter().flat_map(of_balance));
    checks.extend(no_runs_in_use(table));
    checks.extend(dry.iter().filter_map(one_dry_k));
    checks.extend(dry.iter().filter_map(dry_law_holds));
    checks.extend(stated_errors(scene, dry, balance));
    checks
}

/// The check of a table whose every run is left out, with what would use those left out for the most frequent reason.
fn no_runs_in_use(table: &Table) -> Option<Remark> {
    if !table.runs.is_empty() {
        return None;
    }
    let check = |text: String| remarks::RUNS_IN_USE.check(0.0, text);
    let most = table.screened.iter().max_by_key(|screened| screened.runs);
    Some(match most {
        Some(Screened { reason, next_step, .. }) => match table.screened.len() {
            1 => check(format!("every run is left out ({reason})")).then(*next_step),
            _ => check(format!("every run is left out, most of them as {reason}")).then(*next_step),
        },
        None => check("no run is in use".to_owned()),
    })
}

fn dry_laws(dry: &[Dry]) -> Option<Remark> {
    let failed = dry.iter().filter(|d| !d.verdict.passed);
    let names = failed.map(|d| format!("{}: {}", d.words(), d.verdict.reason));
    let names: Vec<String> = names.collect();
    (!dry.is_empty()).then(|| check_usable(remarks::DRY_LAW, "dry law", dry.len(), &names))
}

/// The square-root laws of film ratios. None of them at all gates, unless no film ratio has runs enough for its law to be
/// quoted and the energy balance stands, which takes them together.
fn scaling_laws(scaling: &[Scaling], balance: Option<&EnergyBalance>) -> Option<Remark> {
    // groups without a film ratio have a check of their own
    let is_told = |fit: &&Scaling| fit.film_ratio.is_some() && !fit.is_withheld;
    let laws = || scaling.iter().filter(|fit| fit.law == WetLaw::Sqrt).filter(is_told);
    let all = laws().count();
    let stands = balance.is_some_and(|balance| balance.verdict.passed);
    let failed = laws().filter(|fit| !fit.verdict.passed);
    let names = failed.map(|fit| {
        let ratio = fit.film_ratio.unwrap_or_default();
        format!("{} at film ratio {ratio:.3}: {}", fit.words(), fit.verdict.reason)
    });
    let names: Vec<String> = names.collect();
    // a film ratio without a law is a gap; only none at all leaves no main number
    let forbids = names.len() == all && !(stands && laws().all(|fit| !fit.tells_its_spread()));
    let check = check_usable(remarks::SCALING_LAW, "square-root law of a film ratio", all, &names);
    (all > 0).then(|| check.forbidding_if(forbids))
}

fn of_balance(balance: &EnergyBalance) -> Vec<Remark> {
    let reason = (!balance.verdict.passed).then(|| balance.verdict.reason.clone());
    let what = "energy balance over all rebounds";
    let fit = check_usable(remarks::ENERGY_BALANCE, what, 1, reason.as_slice());
    let shift = balance.dry_k_shift_in_se.map(|shift| {
        let text = "largest shift of k by the wet runs, in combined standard errors";
        remarks::DRY_CONSISTENCY.check(shift, text)
    });
    [fit].into_iter().chain(shift).collect()
}

fn one_dry_k(dry: &Dry) -> Option<Remark> {
    let test = dry.heterogeneity.as_ref()?;
    let shift = dry.shift_by_diameter();
    let text = format!(
        "{}: one k for all diameters, {}, k of one off by up to {} of its ±",
        dry.particle,
        f_words(test, 1),
        share(shift)
    );
    Some(gating_where_felt(remarks::ONE_DRY_K, test, shift, text))
}

fn dry_law_holds(dry: &Dry) -> Option<Remark> {
    let found = dry.lack_of_fit.as_ref()?;
    let shift = dry.shift_by_speed();
    let against = match found.against {
        Alternative::RepeatedSpeeds => "scatter at each speed",
        Alternative::NextPower => "a law with one more power of v",
    };
    let text = format!(
        "{}: the dry law against {against}, {}, k of slow, middle or fast runs off by up to {} of its ±",
        dry.particle,
        f_words(&found.test, 1),
        share(shift)
    );
    Some(gating_where_felt(remarks::DRY_LAW_HOLDS, &found.test, shift, text))
}

/// Whether the wet law describes the runs of each particle, liquid and film from slow to fast ones.
pub fn wet_law_holds(noise: &Noise, line: Option<&LineAgainstRoot>) -> Option<Remark> {
    let found = noise.wet_law.as_ref()?;
    let text = format!(
        "{} beyond the wet law, most of it in {}: {}, {} off by up to {:.1} of its ±",
        found.against.words(),
        found.group,
        f_words(&found.test, 1),
        remarks::in_symbols(&found.moves),
        found.moves_in_se
    );
    // what moves a number by many of its ± wants no such certainty
    let far = found.moves_in_se > remarks::FAR;
    let criterion = |p: f64| remarks::WET_LAW_HOLDS.at(p).then(after_wet_law(found.against));
    let p = if far { remarks::SELDOM } else { remarks::BEYOND_CHANCE };
    let mut check = gating_where_felt(criterion(p), &found.test, Some(found.moves_in_se), text.clone());
    if check.passed && found.moves_in_se > 1.0 && found.test.p < remarks::DOUBTED {
        check = criterion(remarks::DOUBTED).check(found.test.p, text);
    }
    if let Some(line) = line.filter(|line| !check.passed && line.gain > 0.0) {
        let [of_line, of_root] = line.residual_sds.map(|sd| significant(sd, 2));
        check.text += &format!(
            "; the linear law e = e_inf (1 − St_c/St) is nearer to the runs than the square root: residual sd {of_line} against \
             {of_root}"
        );
    }
    Some(check)
}

/// What to do where the wet law does not hold, by what describes the runs better.
fn after_wet_law(against: WetAlternative) -> &'static str {
    match against {
        WetAlternative::SlopeOfOneLiquid | WetAlternative::FallOfOneLiquid | WetAlternative::FilmLossOfOneLiquid => {
            "check the viscosity and the films of that liquid, then fit the liquids apart: leave the rows of one out by a reason \
             in the column exclude, fit, and compare its L with that of the other; where they differ, quote each liquid's own"
        }
        WetAlternative::SlopeOfOneParticle | WetAlternative::FilmLossOfOneParticle => {
            "check the densities, the diameters and the films of all particles, since the runs do not say which of two is off; where they are \
             right, fit the particles apart: leave the rows of one out by a reason in the column exclude, and compare their L"
        }
        WetAlternative::SlopeOfOneDiameter => {
            "check the diameters and films of all spheres; where they are right, fit the diameters apart: leave the rows of one \
             out by a reason in the column exclude, and compare their L"
        }
        WetAlternative::SlopeOfOneGroup | WetAlternative::FallOfOneFilm => {
            "check the films and speeds of these runs, or leave them out ([data] min_film_um, max_film_ratio, a column exclude)"
        }
        WetAlternative::DriftOfViscousLoss | WetAlternative::DriftOfFilmLoss => {
            "if the rows stand in the order of recording, the liquid may have warmed, mixed or dried meanwhile: name \
             a liquid of its own, with its own viscosity, for each part of the table, or leave out what was recorded after it changed"
        }
        WetAlternative::CurvatureInInverseStokes | WetAlternative::SlopeInSpeed => remarks::WET_LAW_HOLDS.next_step,
    }
}

/// The linear law against the square root.
fn linear_law(found: &LineAgainstRoot) -> Remark {
    const LINE: &str = "the linear law e = e_inf (1 − St_c/St)";
    let [line, root] = found.residual_sds.map(|sd| significant(sd, 2));
    let over = by_number(found.groups, "group of runs", "groups of runs");
    let over = format!("{} {over}", found.groups);
    let mut kind = remarks::LINEAR_LAW;
    let text = match found.bend.filter(|_| !found.line_holds()) {
        _ if !found.favours_line() => format!(
            "the runs do not prefer the linear law over {over}: residual sd {line} against {root} of the square root"
        ),
        Some(bend) => {
            kind = kind.then(remarks::NEITHER_LAW);
            format!(
                "neither law describes the runs: over {over} {LINE} is nearer than the square root, residual sd {line} against \
                 {root}, but e bends with 1/St beside it: {}",
                f_words(&bend, 1)
            )
        }
        None => format!(
            "{LINE} describes {over} better than the square root: residual sd {line} against {root}, and a higher log density"
        ),
    };
    kind.check(found.gain, text)
}

/// Whether runs are as independent as standard errors take them to be; `None` where the model has offsets of series, or none
/// are seen beyond chance.
pub fn independent_runs(scene: &Scene, noise: &Noise) -> Option<Remark> {
    let offsets = noise.offsets.as_ref().filter(|_| !scene.model.series_offsets)?;
    let worst = offsets.affected_standard_error();
    let worst = worst.filter(|_| offsets.test.p < remarks::BEYOND_CHANCE)?;
    let text = format!(
        "series lie apart by an sd of {:.4} in e, {:.2} of the spread of single runs, {} most of all: the standard error of {} \
         is too small by a factor of {:.2}",
        offsets.sd, offsets.share, offsets.farthest, remarks::in_symbols(&worst.parameter), worst.ratio
    );
    Some(remarks::INDEPENDENT_RUNS.check(worst.ratio, text))
}

/// Whether the stated errors explain the scatter of the runs that nothing else scatters.
fn stated_errors(scene: &Scene, dry: &[Dry], balance: Option<&EnergyBalance>) -> Vec<Remark> {
    let check = |(kind, criterion): (ParameterKind, Kind), law: &str, errors: Option<ErrorSummary>| {
        let errors = errors.filter(|_| scene.errors_are_all(kind.key()))?;
        let text = format!(
            "{law} with {} = 0: χ² of {:.2} a degree of freedom ({}) against the stated errors",
            kind.symbol(),
            errors.reduced_chi_squared,
            errors.degrees_of_freedom
        );
        Some(criterion.check(errors.p, text))
    };
    let of_dry = dry.iter().filter_map(|fitted| {
        let law = format!("{}: the dry law", fitted.words());
        let of_sigma = (ParameterKind::SigmaDry, remarks::DRY_ERRORS);
        check(of_sigma, &law, fitted.measurement_errors)
    });
    let of_wet = balance.and_then(|balance| {
        let law = "the energy balance over all rebounds";
        let of_sigma = (ParameterKind::SigmaWet, remarks::WET_ERRORS);
        check(of_sigma, law, balance.measurement_errors)
    });
    of_dry.chain(of_wet).collect()
}

fn share(shift: Option<f64>) -> String {
    shift.map_or("an unknown share".to_owned(), |shift| format!("{shift:.1}"))
}

/// A check that forbids quoting where chance does not explain what was found and a main number moves by it.
fn gating_where_felt(criterion: Kind, test: &FTest, shift: Option<f64>, text: String) -> Remark {
    let forbids = !criterion.holds(test.p) && shift.is_none_or(|shift| shift > remarks::FELT);
    let check = criterion.check(test.p, text).forbidding_if(forbids);
    if !check.passed && shift.is_some_and(|shift| shift <= remarks::BIAS) {
        return check.concerning([]);
    }
    check
}

/// The check that every fit of a kind, of so many, is usable; `failed` names those that are not, each with the reason.
fn check_usable(criterion: Kind, what: &str, all: usize, failed: &[String]) -> Remark {
    let text = match failed.len() {
        0 => format!("{what}: usable"),
        1 if all == 1 => format!("{what}: not usable ({})", shortened(failed)),
        n => format!("{what}: {n} of {all} fits not usable ({})", shortened(failed)),
    };
    criterion.check(failed.len() as f64, text)
}

/// What a reader of the estimates should look at: runs left out, fits that lack something, and settings that the model does
/// not read.
pub fn fit_notices(setup: FitSetup, table: &Table, series: &[SeriesFit], scaling: &[Scaling]) -> Vec<Remark> {
    let FitSetup { scene, runs, dry } = setup;
    let mut found = vec![];
    // a remark of its own names those with such a label
    let screened = || table.screened.iter().filter(|one| one.next_step != OTHER_LABEL);
    let left_out: usize = screened().map(|one| one.runs).sum();
    if left_out > 0 {
        let reason = |one: &Screened| format!("{} with {}", one.runs, one.reason);
        let reasons: Vec<String> = screened().map(reason).collect();
        let reasons = reasons.join(", ");
        let text = format!("{left_out} {} left out: {reasons}", by_number(left_out, "run", "runs"));
        let mut next: Vec<&str> = screened().map(|one| one.next_step).collect();
        next.dedup();
        // what the scene did not ask for is told with the checks, where it is much
        let unasked = screened().filter(|one| one.next_step == NOTHING_USES);
        let unasked: usize = unasked.map(|one| one.runs).sum();
        let share = unasked as f64 / (left_out + runs.all_measured()) as f64;
        let told = match remarks::MUCH_SCREENED.holds(share) {
            true => remarks::SCREENED.notice(left_out, text),
            false => remarks::MUCH_SCREENED.check(share, text),
        };
        found.push(told.then(next.join("; ")));
    }
    let stuck: usize = series.iter().map(|s| s.stuck).sum();
    if stuck > 0 {
        let wet = stuck + series.iter().map(|s| s.runs).sum::<usize>();
        let text = format!(
            "{stuck} of {wet} wet runs stuck, which least squares leaves out. Where the noise is on the restitution this \
             leaves the square-root law nearly unbiased and takes the linear law too high in e_inf and St_c; where the \
             energy balance itself fluctuates, the square-root estimates tend to fall"
        );
        found.push(remarks::STUCK_LEFT_OUT.notice(stuck, text));
    }
    let dry_stuck: usize = dry.iter().map(|d| d.stuck).sum();
    if dry_stuck > 0 {
        let text = format!(
            "left out, without a rebound: {dry_stuck} of the dry runs; were it noise that kept them down, k is too small"
        );
        found.push(remarks::DRY_RUN_WITHOUT_REBOUND.notice(dry_stuck, text));
    }
    let without: Vec<String> = (0..runs.spheres.len())
        // fits come in the order of the spheres
        .filter(|s| scaling.binary_search_by_key(s, |fit| fit.sphere).is_ok())
        .filter(|s| dry::fit_of_sphere(dry, *s).is_none())
        .map(|s| runs.spheres[s].words(scene))
        .collect();
    if !without.is_empty() {
        let own_speed = match scene.model.dry_speed {
            DrySpeed::Impact => ", and the run's own dry speed is not used for it",
            DrySpeed::Reference(_) => "",
        };
        let text = format!(
            "no dry runs of {}: films alone tell the inertial loss from the dry loss{own_speed}",
            without.join(", ")
        );
        found.push(remarks::NO_DRY_RUNS.notice(without.len(), text));
    }
    if !scene.unused.is_empty() {
        let text = format!("settings that this model does not read: {}", scene.unused.join(", "));
        found.push(remarks::SETTINGS_UNUSED.notice(scene.unused.len(), text));
    }
    found
}

/// The error of v, as a share of it, below which nothing is said: calibrating a speed better is hard.
const SPEED_ERROR: f64 = 0.01;

/// Squares over the errors' own this many standard deviations below what they should be tell errors that are too large.
const TOO_SMALL: f64 = 3.0;

/// The error of v, as a share of it, that would move β of a usable square-root law of a film ratio by a tenth of its standard
/// error.
fn error_that_matters(row: &Scaling) -> Option<f64> {
    let share = row.speed_error_of_a_tenth_se;
    share.filter(|_| row.film_ratio.is_some() && row.verdict.passed)
}

/// What of the measurement errors wants a second look. A law that `is_main` says no main number of cautions of nothing.
pub(super) fn measurement_error_notices(
    runs: &Runs,
    scaling: &[Scaling],
    is_main: impl Fn(&Scaling) -> bool,
) -> Vec<Remark> {
    let mut found = vec![];
    let shares = scaling.iter().filter_map(|row| Some((row, error_that_matters(row)?)));
    let all: Vec<(&Scaling, f64)> = shares.filter(|(_, share)| *share < SPEED_ERROR).collect();
    let main: Vec<(&Scaling, f64)> = all.iter().copied().filter(|(row, _)| is_main(row)).collect();
    let (level, told) = match main.is_empty() {
        true => (Level::Informs, all),
        false => (Level::Cautions, main),
    };
    let count = told.len();
    // the law that the smallest error would move
    let most_sensitive = told.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
    // where they are given they are asked for no more
    if let Some((row, share)) = most_sensitive.filter(|_| !speeds_err(runs)) {
        let at = match count {
            1 => "one film ratio".to_owned(),
            some => format!("{some} film ratios"),
        };
        let text = format!(
            "an error of {:.2} % in the impact speeds would move β of the square-root law of {} at film ratio {:.3} by a \
             tenth of its standard error; at {at} less than {} % would",
            100.0 * share,
            row.words(),
            row.film_ratio.unwrap_or(f64::NAN),
            100.0 * SPEED_ERROR
        );
        found.push(remarks::SPEED_ERROR_MATTERS.notice(count, text).at(level));
    }
    let weighed = scaling.iter().filter_map(|row| {
        let weighed = row.measurement_errors.filter(|_| row.film_ratio.is_some())?;
        let df = row.runs.checked_sub(weighed.runs_left_out + 2).filter(|df| *df > 0)?;
        Some((weighed.reduced_chi_squared, df as f64))
    });
    let is_too_large = |(reduced, df): &(f64, f64)| *reduced < 1.0 - TOO_SMALL * (2.0 / df).sqrt();
    let too_large: Vec<f64> = weighed.clone().filter(is_too_large).map(|own| own.0).collect();
    if let Some(least) = too_large.iter().copied().reduce(f64::min) {
        let text = format!(
            "in {} of {} fits to a film ratio the runs scatter less than their measurement errors say (χ² per degree of \
             freedom down to {least:.2}); the errors are taken as given, and standard errors follow them",
            too_large.len(),
            weighed.count()
        );
        found.push(remarks::MEASUREMENT_ERRORS_TOO_LARGE.notice(too_large.len(), text));
    }
    found
}

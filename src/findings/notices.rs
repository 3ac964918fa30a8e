//! Words what wants a second look: the table of codes with what to do about each, and one sentence a code.
//!
//! Stages decide whether a notice stands and hand over what they found; what a reader is given is worded here alone.

use super::checks::{self, Check, BIAS};
use super::form_choice::GAIN;
use crate::notice::{Level, Notice};
use crate::physics::form::Term;
use crate::physics::Form;
use crate::rounding::{by_number, probability, with_se};
use crate::runs::{Screened, OF_READING};
use crate::scene::{ResamplingScheme, Sticking};

/// One entry of the table of notices.
struct Entry {
    /// a fixed word a script can test for
    code: &'static str,
    /// whether it bears on the main numbers, unless the data say otherwise
    level: Level,
    /// what to do about it, unless the data say something more particular
    next_step: &'static str,
}

impl Entry {
    fn notice(&self, count: usize, text: String) -> Notice {
        self.with_next_step(count, text, self.next_step)
    }

    fn with_next_step(&self, count: usize, text: String, next_step: impl Into<String>) -> Notice {
        Notice::new(self.code, count, text, next_step).at(self.level)
    }
}

/// A caution.
const fn entry(code: &'static str, next_step: &'static str) -> Entry {
    let level = Level::Cautions;
    Entry { code, level, next_step }
}

/// What moves no main number by more than a quarter of its ±.
const fn informing(code: &'static str, next_step: &'static str) -> Entry {
    let level = Level::Informs;
    Entry { code, level, next_step }
}

const SCREENED: Entry = entry("screened", "see the reasons");
const REPEATED_ROWS: Entry = entry("repeated_rows", "look whether a row was entered twice");
const COLUMNS_DISAGREE: Entry = entry("columns_disagree", "look for a slip in these rows");
const STUCK_LEFT_OUT: Entry = entry(
    "stuck_left_out",
    "quote the square-root law, and compare film ratios by how many of their runs stuck",
);
const DRY_RUN_WITHOUT_REBOUND: Entry = entry(
    "dry_run_without_rebound",
    "check that they were dry: nothing in the dry law makes a sphere stick",
);
const SERIES_FAILED: Entry = informing(
    "series_failed",
    "their runs still count in the scaling with St; more speeds or more rebounds would give them their own",
);
const NO_DRY_RUNS: Entry = entry("no_dry_runs", "add dry runs over the same speeds");
const VISCOUS_FORM: Entry = entry(
    "viscous_form",
    "measure the roughness, and give roughness_rel_sd; the model comparison says what one L for all would predict",
);
const SETTINGS_UNUSED: Entry = informing(
    "settings_unused",
    "nothing: they were checked and wait for the stage that reads them; intervals here are delta-method ones",
);
const TERM_NOT_HELD: Entry = entry("term_not_held", "name it in [model] terms to hold it");
const TERM_LEFT_OUT: Entry = informing("term_left_out", "name it in [model] terms to hold it");
const TERM_TOO_SMALL: Entry = informing("term_too_small", "terms = \"auto\" would decide by the size");
const SPEED_ERROR_MATTERS: Entry = entry(
    "speed_error_matters",
    "give impact_speed_sd_m_s for each run, or leave out the runs nearest to sticking",
);
const MEASUREMENT_ERRORS_TOO_LARGE: Entry = entry(
    "measurement_errors_too_large",
    "check whether errors that all runs share, as of a scale, were given as errors of each run",
);
const OUTLIER: Entry = entry(
    "outlier",
    "check the rows: a mistake in one is to be mended there; likelihood = \"student\" keeps what cannot be from \
     moving the parameters",
);
const UNEQUAL_SPREAD: Entry = entry(
    "unequal_spread",
    "look at the group that scatters most; the fits of single film ratios have spreads of their own, and the `cases` \
     bootstrap does not take spreads as equal",
);
/// The code of noise of wet runs that grows with what changes from run to run.
pub(crate) const NOISE_GROWS_CODE: &str = "noise_grows";
const NOISE_GROWS: Entry = entry(
    NOISE_GROWS_CODE,
    "quote no bands of single runs (in figures, run_q05 to run_q95 of predict) near either end, or fit slow and fast runs \
     apart by [data] min_impact_speed_m_s and max_impact_speed_m_s; where it is the measurement, give restitution_sd for \
     each run",
);
const DRY_NOISE_GROWS: Entry = entry(
    "dry_noise_grows",
    "quote the `cases` bootstrap of k, which does not take the spread as even; where it is the measurement, give \
     restitution_sd for each run",
);
const SERIES_OFFSETS: Entry = entry(
    "series_offsets",
    "set [model] series_offsets = true: the posterior then has an offset for each series, and every main number is its own",
);
const SLOW_REBOUNDS: Entry = entry(
    "slow_rebounds",
    "measure speeds and films of these rows again, or give their errors: impact_speed_sd_m_s, and film_sd_um in [data]",
);
/// The code of the notice that says which single runs carry a main number.
pub const SINGLE_RUN_CODE: &str = "single_run";
const SINGLE_RUN: Entry = entry(
    SINGLE_RUN_CODE,
    "check these rows, and repeat their settings: until then the numbers rest on them",
);
const BOOTSTRAP_FEWER_REPLICATES: Entry = informing(
    "bootstrap_fewer_replicates",
    "ask for fewer replicates, or fit fewer series in one scene",
);
const BOOTSTRAP_FEW_RUNS: Entry = informing("bootstrap_few_runs", "take such intervals as rough, or repeat the runs");
const BOOTSTRAP_PARTLY_STUCK: Entry = entry(
    "bootstrap_partly_stuck",
    "compare with film ratios whose runs all rebound; the delta interval does not know of it either",
);
const BOOTSTRAP_SINGLE_RUN_STRATA: Entry = informing(
    "bootstrap_single_run_strata",
    "a second run of such a series would tell its noise",
);
const BOOTSTRAP_BY_SANDWICH: Entry = informing("bootstrap_by_sandwich", "nothing: of so many runs both give the same");
const BOOTSTRAP_ONE_SERIES: Entry = informing(
    "bootstrap_one_series",
    "choose scheme = \"cases\" for their bootstrap interval",
);
/// The code of constants taken as exact whose errors matter.
pub(super) const CONSTANTS_EXACT_CODE: &str = "constants_exact";
const CONSTANTS_EXACT: Entry = entry(CONSTANTS_EXACT_CODE, "say how well it is known, and the report adds it");
const UNSEEN: Entry = entry("unseen", "add the runs it names");
const PRIOR_RULES: Entry = entry("prior_rules", "quote it beside its prior, or add runs that tell it");
const COMPARE_LEFT_OUT: Entry = informing("compare_left_out", "compare on a part of the runs");
/// The code of a form of inertia that the runs chose.
pub(super) const FORM_CHOSEN_CODE: &str = "form_chosen";
const FORM_CHOSEN: Entry = entry(FORM_CHOSEN_CODE, "name the form in [model] to fix it");
const FORM_NOT_COMPARED: Entry = informing(
    "form_not_compared",
    "see whether its parameters have room under their priors",
);

/// Those that bear on the main numbers, the one that bears most on them first.
const FIRST: [&Entry; 18] = [
    &REPEATED_ROWS,
    &COLUMNS_DISAGREE,
    &SLOW_REBOUNDS,
    &SINGLE_RUN,
    &MEASUREMENT_ERRORS_TOO_LARGE,
    &SERIES_OFFSETS,
    &OUTLIER,
    &DRY_RUN_WITHOUT_REBOUND,
    &TERM_NOT_HELD,
    &SPEED_ERROR_MATTERS,
    &UNSEEN,
    &NO_DRY_RUNS,
    &PRIOR_RULES,
    &UNEQUAL_SPREAD,
    &NOISE_GROWS,
    &DRY_NOISE_GROWS,
    &SCREENED,
    &STUCK_LEFT_OUT,
];

/// The notices in the order of how much they bear on the main numbers: cautions about how the table was read first, since
/// everything rests on it, then the other cautions; what only informs comes last.
pub fn by_weight(notices: &[Notice]) -> Vec<&Notice> {
    let codes = FIRST.iter().map(|entry| entry.code);
    let codes: Vec<&str> = OF_READING.into_iter().chain(codes).collect();
    let place = |notice: &&Notice| codes.iter().position(|code| *code == notice.code);
    let mut sorted: Vec<&Notice> = notices.iter().collect();
    sorted.sort_by_key(|notice| (!notice.cautions(), place(notice).unwrap_or(codes.len())));
    sorted
}

/// A list cut to what can be read.
pub(super) fn shortened(items: &[String]) -> String {
    const SHOWN: usize = 3;
    let mut text = items.iter().take(SHOWN).cloned().collect::<Vec<_>>().join("; ");
    if items.len() > SHOWN {
        text.push_str(&format!("; and {} more", items.len() - SHOWN));
    }
    text
}

/// Runs left out while reading.
pub(super) fn screened(by_reason: &[Screened]) -> Notice {
    let runs: usize = by_reason.iter().map(|one| one.runs).sum();
    let reasons = by_reason.iter().map(|one| format!("{} with {}", one.runs, one.reason));
    let reasons: Vec<String> = reasons.collect();
    let mut next: Vec<&str> = by_reason.iter().map(|one| one.next_step).collect();
    next.dedup();
    SCREENED.with_next_step(
        runs,
        format!(
            "{runs} {} left out: {}",
            by_number(runs, "run", "runs"),
            reasons.join(", ")
        ),
        next.join("; "),
    )
}

/// Rows that repeat others, perhaps by chance.
pub(super) fn repeated_rows(rows: usize, text: String) -> Notice {
    REPEATED_ROWS.notice(rows, text)
}

/// Rows in which columns that tell the same thing lie apart.
pub(super) fn columns_disagree(rows: usize, text: String) -> Notice {
    COLUMNS_DISAGREE.notice(rows, text)
}

/// Runs of the wet ones that stuck, which least squares leaves out.
pub(super) fn stuck_left_out(stuck: usize, wet: usize) -> Notice {
    let text = format!(
        "{stuck} of {wet} wet runs stuck, which least squares leaves out. Where the noise is on the restitution this \
         leaves the square-root law nearly unbiased and takes the linear law too high in e_inf and St_c; where the energy \
         balance itself fluctuates, the square-root estimates tend to fall"
    );
    STUCK_LEFT_OUT.notice(stuck, text)
}

/// Settles a notice once the posterior is sampled, which the main numbers of film ratios with stuck runs come from.
pub(super) fn after_sampling(notice: &mut Notice, sticking: Sticking) {
    if sticking != Sticking::Censored {
        return;
    }
    if notice.code == STUCK_LEFT_OUT.code {
        notice.level = Level::Informs;
        notice.next_step =
            "nothing: the main numbers of their film ratios come from the posterior, which counts them".into();
    }
    if notice.code == BOOTSTRAP_PARTLY_STUCK.code {
        notice.level = Level::Informs;
        notice.next_step = "nothing: the main numbers of these film ratios come from the posterior".into();
    }
}

/// Whether a check says of a failure what a notice says, too.
pub(super) fn says_the_same(check: &Check, notice: &Notice) -> bool {
    check.check == checks::INDEPENDENT_RUNS.code && notice.code == SERIES_OFFSETS.code
}

/// Whether a notice that only informs says what a table of the report has: that of the terms, or that of the series without
/// a law.
pub(crate) fn stands_in_a_table(notice: &Notice) -> bool {
    [TERM_NOT_HELD, TERM_LEFT_OUT, TERM_TOO_SMALL, SERIES_FAILED]
        .iter()
        .any(|entry| entry.code == notice.code)
}

/// Whether a notice says that the inertial loss is not in the model.
pub(super) fn leaves_out_inertia(notice: &Notice) -> bool {
    let is_of_term = [TERM_NOT_HELD.code, TERM_LEFT_OUT.code].contains(&notice.code);
    is_of_term && notice.text.starts_with(Term::Inertia.in_words())
}

/// Whether a notice says what the runs tell less of than priors do.
pub(super) fn is_of_priors(notice: &Notice) -> bool {
    [UNSEEN.code, PRIOR_RULES.code].contains(&notice.code)
}

/// Dry runs that stuck.
pub(super) fn dry_run_without_rebound(stuck: usize) -> Notice {
    let text = format!(
        "left out, without a rebound: {stuck} of the dry runs; were it noise that kept them down, k is too small"
    );
    DRY_RUN_WITHOUT_REBOUND.notice(stuck, text)
}

/// A form of the viscous loss that has something to say wherever it is told; `None` of one that has not.
pub(super) fn viscous_form(form: Form, wet: usize) -> Option<Notice> {
    let text = |caution: &str| format!("viscous loss \"{}\": {caution}", form.viscous.name());
    let caution = form.viscous.caution()?;
    Some(VISCOUS_FORM.notice(wet, text(caution)))
}

/// Series of so many without a law of their own, each with its reason.
pub(super) fn series_failed(failed: &[String], all: usize) -> Notice {
    let text = format!(
        "{} of {all} series {} no square-root law: {}",
        failed.len(),
        by_number(failed.len(), "gives", "give"),
        shortened(failed)
    );
    SERIES_FAILED.notice(failed.len(), text)
}

/// Particles with wet runs but no dry ones; `own_speed`: the scene wants e_dry at each run's own speed.
pub(super) fn no_dry_runs(particles: &[String], own_speed: bool) -> Notice {
    let mut text = format!(
        "no dry runs of {}: films alone tell the inertial loss from the dry loss",
        particles.join(", ")
    );
    if own_speed {
        text.push_str(", and the run's own dry speed is not used for it");
    }
    NO_DRY_RUNS.notice(particles.len(), text)
}

/// Keys of the scene that no stage reads.
pub(super) fn settings_unused(keys: &[String]) -> Notice {
    let text = format!("settings that no stage of this run reads: {}", keys.join(", "));
    SETTINGS_UNUSED.notice(keys.len(), text)
}

/// What leaving a term out does.
#[derive(Clone, Copy)]
pub(super) struct LeavingOut<'a> {
    /// the term
    pub(super) term: Term,
    /// the parameter that it moves most; `None` where there is none
    pub(super) moves: Option<&'a str>,
    /// by how many of its standard errors
    pub(super) size: f64,
    /// largest change of a restitution
    pub(super) largest_effect: f64,
    /// share of its full effect that the runs show, with its standard error
    pub(super) shown: Option<(f64, f64)>,
    /// by how much log density the runs prefer the model without it
    pub(super) gain_without: Option<f64>,
}

impl LeavingOut<'_> {
    fn far(&self) -> String {
        let digits = if self.size < 10.0 { 2 } else { 0 };
        format!(
            "{} by {:.digits$} standard errors, a restitution by up to {:.3}",
            self.moves.unwrap_or("no parameter"),
            self.size,
            self.largest_effect
        )
    }
}

/// A term that would matter and is not in the model.
pub(super) fn term_not_held(out: LeavingOut) -> Notice {
    let name = out.term.in_words();
    let shown = out.shown.map_or(String::new(), |(share, se)| {
        format!(
            "the runs show {} of its full effect (0: it is absent, 1: it acts in full)",
            with_se(share, se)
        )
    });
    if out.gain_without.is_some_and(|gain| gain > GAIN) {
        let text = format!("{name}: not in the model, and the runs speak against it; {shown}");
        return TERM_NOT_HELD.with_next_step(1, text, "nothing").at(Level::Informs);
    }
    let mut text = format!(
        "{name}: not in the model; if it acts, leaving it out moves {}",
        out.far()
    );
    if !shown.is_empty() {
        text.push_str(&format!("; {shown}"));
    }
    if out.term == Term::OwnDrySpeed {
        return TERM_NOT_HELD.with_next_step(1, text, COMPARE_DRY_SPEEDS);
    }
    TERM_NOT_HELD.notice(1, text)
}

const COMPARE_DRY_SPEEDS: &str = "compare the forms: dry_speed_m_s = \"impact\" holds it";

/// Whether a notice is settled by the comparison of forms.
pub(super) fn awaits_comparison(notice: &Notice) -> bool {
    notice.next_step == COMPARE_DRY_SPEEDS
}

/// Settles what was said of the dry speed once the forms are compared: the scene's own with e_dry at each run's own speed
/// falls behind by so much log density, with its standard error, where that is clear.
pub(super) fn after_comparison(notice: &mut Notice, falls_behind: Option<(f64, f64)>) {
    if !awaits_comparison(notice) {
        return;
    }
    let Some((loss, se)) = falls_behind else {
        notice.next_step =
            "see Other forms of the law: dry_speed_m_s = \"impact\" holds it where it predicts better".into();
        return;
    };
    notice.level = Level::Informs;
    notice.text = format!(
        "{}: not in the model, and the comparison of forms speaks against it: with it the runs are predicted worse by {} \
         in log density",
        Term::OwnDrySpeed.in_words(),
        with_se(loss, se)
    );
    notice.next_step = "nothing".into();
}

/// A term that was left out for its size, which is below a line.
pub(super) fn term_left_out(out: LeavingOut, line: f64) -> Notice {
    let name = out.term.in_words();
    let text = format!("{name}: left out, since that moves {}: less than {line}", out.far());
    TERM_LEFT_OUT.notice(1, text)
}

/// A term held by name that does not matter, and by how much it widens another standard error.
pub(super) fn term_too_small(out: LeavingOut, widens: f64) -> Notice {
    let text = format!(
        "{}: held as the scene asks; leaving it out moves {}, holding it makes another standard error {widens:.2} times as \
         wide",
        out.term.in_words(),
        out.far()
    );
    TERM_TOO_SMALL.notice(1, text)
}

/// Film ratios whose β bears a smaller error of v than a line; and the one that bears least.
pub(super) struct SpeedErrors<'a> {
    /// how many
    pub(super) film_ratios: usize,
    /// the line, as a share of v
    pub(super) line: f64,
    /// the particle of the one that bears least
    pub(super) particle: &'a str,
    /// its film ratio
    pub(super) film_ratio: f64,
    /// the error that would move its β by a tenth of its standard error, as a share of v
    pub(super) share: f64,
}

/// Speeds that matter to less than they can be calibrated to.
pub(super) fn speed_error_matters(found: &SpeedErrors) -> Notice {
    let at = match found.film_ratios {
        1 => "one film ratio".to_owned(),
        some => format!("{some} film ratios"),
    };
    let text = format!(
        "an error of {:.2} % in the impact speeds would move β of the square-root law of {} at film ratio {:.3} by a tenth \
         of its standard error; at {at} less than {} % would",
        100.0 * found.share,
        found.particle,
        found.film_ratio,
        100.0 * found.line
    );
    SPEED_ERROR_MATTERS.notice(found.film_ratios, text)
}

/// Fits, of so many, whose runs scatter less than their measurement errors; the least χ² per degree of freedom.
pub(super) fn measurement_errors_too_large(fits: usize, of: usize, least: f64) -> Notice {
    let text = format!(
        "in {fits} of {of} fits to a film ratio the runs scatter less than their measurement errors say (χ² per degree of \
         freedom down to {least:.2}); the errors are taken as given, and standard errors follow them"
    );
    MEASUREMENT_ERRORS_TOO_LARGE.notice(fits, text)
}

/// Outliers found among the runs, which move a main number by a quarter of its ± or not; the first of them in words.
pub(super) fn outlier(found: usize, runs: usize, first: &[String], felt: bool) -> Notice {
    let mut rows = first.join("; ");
    if found > first.len() {
        rows.push_str(&format!("; and {} more", found - first.len()));
    }
    let text = format!(
        "{found} {} so far from the law that normal noise would take any of {runs} runs there in one table of a hundred: {rows}",
        by_number(found, "run lies", "runs lie")
    );
    let level = if felt { Level::Cautions } else { Level::Informs };
    OUTLIER.notice(found, text).at(level)
}

/// Runs that rebound barely, how their energy is allowed to scatter, and the number that differs most by that, before and
/// after.
pub(super) fn slow_rebounds(
    (runs, rows): (usize, &str),
    how: &str,
    name: &str,
    [before, after]: [String; 2],
) -> Notice {
    let text = format!(
        "{rows}: with noise on e alone such runs fix the energy more tightly than errors of 1 % in speed and 3 % in film \
         allow. With these allowed for, {how}, {name} is {after} in place of {before}: the numbers here allow for them"
    );
    SLOW_REBOUNDS.notice(runs, text)
}

/// Runs without which a main number moves by more than its ±, each in words.
pub(super) fn single_run(runs: &[String]) -> Notice {
    let text = format!(
        "one run carries a main number, which moves by more than its ± without it: {}",
        shortened(runs)
    );
    SINGLE_RUN.notice(runs.len(), text)
}

/// A standard error that is too small, and by which factor.
#[derive(Clone, Copy)]
pub(super) struct UnderstatedError<'a> {
    /// the parameter
    pub(super) parameter: &'a str,
    /// the factor
    pub(super) ratio: f64,
}

/// Groups whose spreads differ; the narrowest and the widest in words.
pub(super) fn unequal_spread(groups: usize, narrowest: &str, widest: &str, worst: UnderstatedError) -> Notice {
    let text = format!(
        "the runs do not scatter alike: from {narrowest} to {widest} about the fit, where every interval takes one spread \
         for all dry and one for all wet runs; the standard error of {} is too small by a factor of {:.2}",
        worst.parameter, worst.ratio
    );
    UNEQUAL_SPREAD.notice(groups, text)
}

/// Noise that grows with what changes from run to run.
pub(super) struct GrowingNoise<'a> {
    /// whether of wet runs, not dry ones
    pub(super) of_wet: bool,
    /// what it grows with, in words
    pub(super) with: &'a str,
    /// the smallest and the largest of that over the runs, in words
    pub(super) ends: [&'a str; 2],
    /// sd at the largest over that at the smallest
    pub(super) factor: f64,
    /// the larger sd of both ends over the one sd that every interval takes
    pub(super) largest_over_one: f64,
    /// probability of so much by chance
    pub(super) p: f64,
    /// what a 90 % band of single runs would hold at the ends
    pub(super) band_holds: [f64; 2],
    /// whether noise on the energy kept, which grows so, is not in the model
    pub(super) energy_may_scatter: bool,
}

/// Noise of so many runs that grows.
pub(super) fn noise_grows(runs: usize, found: &GrowingNoise) -> Notice {
    let [from, to] = found.ends;
    let (kind, entry) = if found.of_wet {
        ("wet", NOISE_GROWS)
    } else {
        ("dry", DRY_NOISE_GROWS)
    };
    let text = format!(
        "the noise of {kind} runs grows with {}: their sd is {:.1} times as large at {to} as at {from} (by chance with probability {}), where \
         every interval takes one; a 90 % band of single runs would hold about {:.0} % of them at {from} and {:.0} % at {to}",
        found.with,
        found.factor,
        probability(found.p),
        100.0 * found.band_holds[0],
        100.0 * found.band_holds[1]
    );
    let level = if found.largest_over_one > 1.0 + BIAS {
        Level::Cautions
    } else {
        Level::Informs
    };
    if found.energy_may_scatter {
        let next = format!(
            "try [model] noise = \"both\", which scatters so; else {}",
            entry.next_step
        );
        return entry.with_next_step(runs, text, next).at(level);
    }
    entry.notice(runs, text).at(level)
}

/// Offsets that the runs of a series share.
pub(super) struct SharedOffsets<'a> {
    /// series
    pub(super) series: usize,
    /// their sd, in e
    pub(super) sd: f64,
    /// that over the spread of single runs
    pub(super) share: f64,
    /// the standard error that suffers most
    pub(super) worst: UnderstatedError<'a>,
}

/// Which intervals resampling whole series changes.
pub(crate) const SERIES_SCHEME_CHANGES: &str =
    "changes the bootstrap intervals of the dry law's k and of e_inf, St_c, α and β of the laws, each where its runs are of \
     several series (or diameters, of k), and nothing else: neither k, L and C of the energy balance nor the posterior";

/// Runs of a series that are not independent.
pub(super) fn series_offsets(found: &SharedOffsets, scheme: ResamplingScheme) -> Notice {
    let text = format!(
        "runs of a series share an offset: over {} series it has an sd of {:.4} in e, {:.2} of the spread of single runs; \
         taking runs as independent makes the standard error of {} too small by a factor of {:.2}. It may be the film or \
         the alignment, set once for a series, or the law itself where it does not fit",
        found.series, found.sd, found.share, found.worst.parameter, found.worst.ratio
    );
    if scheme == ResamplingScheme::Series {
        let next = format!(
            "{}. scheme = \"series\" {SERIES_SCHEME_CHANGES}",
            SERIES_OFFSETS.next_step
        );
        return SERIES_OFFSETS.with_next_step(found.series, text, next);
    }
    SERIES_OFFSETS.notice(found.series, text)
}

/// Fewer replicates made than wanted, where only so many are held at once.
pub(super) fn bootstrap_fewer_replicates(wanted: u64, made: usize, fits: usize, most: usize) -> Notice {
    let text = format!(
        "[bootstrap] replicates: found {wanted}, of {fits} fits; made {made}, since at most {most} replicates of all fits \
         together are held at once"
    );
    let next = format!("set it to at most {made}, or fit fewer series in one scene");
    BOOTSTRAP_FEWER_REPLICATES.with_next_step(made, text, next)
}

/// Bootstrapped fits with fewer runs than a line, where the scene names the interval and where not.
pub(super) fn bootstrap_few_runs(few: usize, all: usize, line: usize, named: bool) -> Notice {
    let rest = format!(
        "{few} of {all} bootstrapped fits {} on fewer than {line} runs",
        by_number(few, "rests", "rest")
    );
    if named {
        let text = format!("{rest}: the interval that the scene names may be too short for them");
        return BOOTSTRAP_FEW_RUNS.notice(few, text).at(Level::Cautions);
    }
    let text = format!(
        "{rest}: their interval is that of least squares with Student's t, since resampling so few makes intervals too short"
    );
    BOOTSTRAP_FEW_RUNS.notice(few, text)
}

/// Series of so many in which some runs stuck no slower than others rebounded.
pub(super) fn bootstrap_partly_stuck(partly: usize, series: usize) -> Notice {
    let text = format!(
        "in {partly} of {series} series some runs stuck at speeds at which others rebounded; those left spread less than \
         the noise, which makes intervals of St_c that rest on them too short"
    );
    BOOTSTRAP_PARTLY_STUCK.notice(partly, text)
}

/// Strata of so many with a single run.
pub(super) fn bootstrap_single_run_strata(single: usize, strata: usize) -> Notice {
    let hold = by_number(single, "holds", "hold");
    let text = format!("{single} of {strata} strata {hold} a single run, which no resample can vary");
    BOOTSTRAP_SINGLE_RUN_STRATA.notice(single, text)
}

/// Fits of one series, where series are drawn.
pub(super) fn bootstrap_one_series(fits: usize) -> Notice {
    let rest = by_number(fits, "fit rests", "fits rest");
    let text = format!("{fits} {rest} on one series, for which none can be drawn: the delta interval stands there");
    BOOTSTRAP_ONE_SERIES.notice(fits, text)
}

/// Runs too many to resample: how many, the most that are, and of all fits those that were resampled all the same.
pub(super) fn bootstrap_by_sandwich(runs: usize, most: usize, [resampled, all]: [usize; 2]) -> Notice {
    let rest = match resampled {
        0 => String::new(),
        some => format!("; {some} of {all} fits were resampled, which have few runs"),
    };
    let text = format!(
        "{runs} runs, more than the {most} that are resampled: the intervals are made with the sandwich covariance, which \
         that of replicates tends to{rest}"
    );
    BOOTSTRAP_BY_SANDWICH.notice(runs, text)
}

/// A constant taken as exact, and the result that an error of it would move most.
pub(super) struct ExactConstant<'a> {
    /// how many constants matter so much
    pub(super) matter: usize,
    /// this one, in words
    pub(super) constant: &'a str,
    /// its key in a scene
    pub(super) key: &'a str,
    /// an error of it, as a share
    pub(super) error: f64,
    /// the result
    pub(super) result: &'a str,
    /// by which share it would move
    pub(super) moved: f64,
    /// by how many of its standard errors
    pub(super) in_se: f64,
}

/// Constants whose uncertainty nobody gave.
pub(super) fn constants_exact(found: &ExactConstant) -> Notice {
    let text = format!(
        "the {} is taken as exact: were it off by {} %, {} would be off by {:.1} %, {:.1} times its ±",
        found.constant,
        100.0 * found.error,
        found.result,
        100.0 * found.moved.abs(),
        found.in_se
    );
    let next = format!(
        "say how well it is known ({}), and the report adds it; the others stand under Constants taken as exact",
        found.key
    );
    CONSTANTS_EXACT.with_next_step(found.matter, text, next)
}

/// Directions of the parameters that the runs say less of than the priors; `add`: the runs that would show each.
pub(super) fn unseen(directions: usize, reasons: &[String], add: &[&str]) -> Notice {
    UNSEEN.with_next_step(directions, reasons.join("; "), add.join("; "))
}

/// Parameters that keep more than half of their prior sd, in words; `add`: the runs that would tell one of them.
pub(super) fn prior_rules(wide: &[String], add: Option<&str>) -> Notice {
    let text = format!("more than half of the prior sd is left of {}", wide.join(", "));
    PRIOR_RULES.with_next_step(wide.len(), text, add.unwrap_or(PRIOR_RULES.next_step))
}

/// Why forms of the law are not compared, with wet runs in use or without.
pub(super) fn compare_left_out(why: &str, any_wet: bool) -> Notice {
    if any_wet {
        let text = format!("forms of the law are not compared: {why}");
        return COMPARE_LEFT_OUT.notice(1, text).at(Level::Cautions);
    }
    let text = "no wet runs: there are no forms of the wet law to compare";
    COMPARE_LEFT_OUT.with_next_step(1, text.to_owned(), "nothing")
}

/// A form of inertia that the runs chose, clearly before every other or not.
pub(super) fn form_chosen(chosen: &str, clearly: bool) -> Notice {
    let text = format!("inertia = \"auto\" took {chosen}: the intervals ignore that the same runs chose it");
    let level = if clearly { Level::Informs } else { Level::Cautions };
    FORM_CHOSEN.notice(1, text).at(level)
}

/// A form that could not be sampled or compared.
pub(super) fn form_not_compared(model: &str, why: &str) -> Notice {
    FORM_NOT_COMPARED.notice(1, format!("{model} is not compared: {why}"))
}

/// A form that reads the roughness of particles, one of which has none.
pub(super) fn form_without_roughness(model: &str, why: &str) -> Notice {
    let next = "give roughness_um in [particles], and it is compared";
    FORM_NOT_COMPARED.with_next_step(1, format!("{model} is not compared: {why}"), next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_bears_most_on_the_main_numbers_comes_first_and_the_rest_keeps_its_order() {
        let given = ["form_chosen", "screened", "constants_exact", "outlier", OF_READING[2]];
        let mut notices = given.map(|code| Notice::new(code, 1, "", "")).to_vec();
        notices.insert(0, Notice::new(OF_READING[0], 1, "", "").at(Level::Informs));
        let codes: Vec<&str> = by_weight(&notices).iter().map(|notice| notice.code).collect();
        let expected = [
            OF_READING[2],
            "outlier",
            "screened",
            "form_chosen",
            "constants_exact",
            OF_READING[0],
        ];
        assert_eq!(codes, expected);
    }

    fn left_out(term: Term, share: f64, gain: f64) -> Notice {
        term_not_held(LeavingOut {
            term,
            moves: Some("dry_k[PTFE]"),
            size: 15.0,
            largest_effect: 0.15,
            shown: Some((share, 0.1)),
            gain_without: Some(gain),
        })
    }

    #[test]
    fn a_term_that_the_runs_or_the_comparison_reject_is_no_caution() {
        let rejected = left_out(Term::DrySecondOrder, 0.02, 48.0);
        assert!(
            !rejected.cautions() && rejected.text.contains("speak against it"),
            "{rejected:?}"
        );
        let open = left_out(Term::DrySecondOrder, 0.4, 3.9);
        assert!(
            open.cautions() && open.text.contains("leaving it out moves dry_k[PTFE] by 15"),
            "{open:?}"
        );
        let told = |falls_behind: Option<(f64, f64)>| {
            let mut notice = left_out(Term::OwnDrySpeed, 0.4, 3.9);
            after_comparison(&mut notice, falls_behind);
            notice
        };
        assert!(told(None).cautions());
        let beaten = told(Some((367.2, 28.1)));
        assert!(
            !beaten.cautions() && beaten.text.contains("worse by 367 ± 28"),
            "{beaten:?}"
        );
        assert!(!beaten.text.contains("if it acts"), "{beaten:?}");
    }

    #[test]
    fn stuck_runs_caution_only_where_no_posterior_counts_them() {
        let after = |sticking: Sticking| {
            let mut notice = stuck_left_out(5, 40);
            after_sampling(&mut notice, sticking);
            notice
        };
        assert!(stuck_left_out(5, 40).cautions() && after(Sticking::Excluded).cautions());
        let counted = after(Sticking::Censored);
        assert!(!counted.cautions() && !counted.next_step.contains("quote the square-root law"));
    }

    #[test]
    fn advice_on_screened_runs_goes_by_their_reasons() {
        let screened_for = |reasons: &[&'static str]| {
            let all = reasons.iter().copied().map(|next_step| Screened {
                reason: "some reason".to_owned(),
                runs: 2,
                next_step,
            });
            screened(&all.collect::<Vec<_>>()).next_step
        };
        assert_eq!(screened_for(&["widen"]), "widen");
        assert_eq!(
            screened_for(&["widen", "widen", "clear the word"]),
            "widen; clear the word"
        );
    }
}

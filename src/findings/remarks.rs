//! Lists every remark of a fit: its code, its level, the line it is held against with where that comes from, and what to do;
//! and says in which order they are told.
//!
//! The sentence is made where what it says was found.

use super::form_choice::GAIN;
use crate::error::and_more;
use crate::inference::mixing::{FEWEST_EFFECTIVE, LARGEST_RHAT};
use crate::physics::quantity::Described;
use crate::physics::{Coefficient, Quantity};
use crate::remark::Line::{self, AtLeast, AtMost};
use crate::remark::{Level, Remark};
use crate::runs::OF_READING;

/// A line that only the settings or the number of draws say, see [`Kind::at`]; unless given, nothing holds.
const GIVEN: f64 = f64::NAN;

/// One row of the table of remarks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kind {
    /// a fixed word a script can test for
    pub code: &'static str,
    /// how much it bears on the main numbers, unless the data say otherwise
    pub level: Level,
    /// what a value is held against; `None` of what is only told where it is found
    pub line: Option<Line>,
    /// where the line comes from
    pub source: &'static str,
    /// what to do about it, unless the data say something more particular
    pub next_step: &'static str,
}

impl Kind {
    /// The same with where its line comes from.
    const fn by(self, source: &'static str) -> Kind {
        Kind { source, ..self }
    }

    /// The same with what to do about it.
    pub(super) const fn then(self, next_step: &'static str) -> Kind {
        Kind { next_step, ..self }
    }

    /// The same with another line on the same side, for data that ask for one of their own.
    #[must_use]
    pub fn at(self, line: f64) -> Kind {
        Kind {
            line: self.line.map(|own| own.at(line)),
            ..self
        }
    }

    /// Whether a remark is of this kind.
    pub fn is(&self, remark: &Remark) -> bool {
        remark.code == self.code
    }

    /// The number of its line.
    pub fn threshold(&self) -> f64 {
        self.line.map_or(GIVEN, Line::threshold)
    }

    /// Whether a value lies on the right side of its line; NaN does not.
    pub fn holds(&self, value: f64) -> bool {
        self.line.is_some_and(|line| line.holds(value))
    }

    /// What was found, `None` where nothing could be, which fails; `text` says what it concerns.
    pub fn check(self, value: impl Into<Option<f64>>, text: impl Into<String>) -> Remark {
        let value = value.into();
        Remark {
            value,
            line: self.line,
            passed: value.is_some_and(|value| self.holds(value)),
            source: self.source,
            ..self.notice(0, text.into())
        }
    }

    /// What was found, of so many.
    pub(super) fn notice(&self, count: usize, text: String) -> Remark {
        Remark::new(self.code, count, text, self.next_step).at(self.level)
    }
}

const fn kind(code: &'static str, level: Level, line: Option<Line>) -> Kind {
    Kind {
        code,
        level,
        line,
        source: "",
        next_step: "",
    }
}

/// A row whose failure forbids quoting the main numbers.
const fn forbids(code: &'static str, line: Line) -> Kind {
    kind(code, Level::Forbids, Some(line))
}

/// One whose failure tells that a main number, or what may be concluded from it, wants a look.
const fn cautions(code: &'static str, line: Line) -> Kind {
    kind(code, Level::Cautions, Some(line))
}

/// A caution that is told where it is found.
const fn found(code: &'static str) -> Kind {
    kind(code, Level::Cautions, None)
}

/// The same of what moves no main number by more than a quarter of its ±.
const fn informing(code: &'static str) -> Kind {
    kind(code, Level::Informs, None)
}

const USABLE: &str = "every fit must converge, with a standard error and the sign the physics has";
const NESTED: &str = "F test of nested fits; probability of so large a difference by chance";
const VEHTARI: &str = "Vehtari et al. 2021";
const VEHTARI_PSIS: &str = "Vehtari et al. 2024: min(1 − 1/log10 S, 0.7)";
const FEW_RUNS: &str = "5 points, or 3.5 standard errors where there are too few runs to tell";

const LONGER: &str = "raise draws and warmup in [sampler]";
const OTHER_NOISE: &str = "try [model] likelihood = \"student\" or noise = \"both\"";

/// A bias above this share of the standard error spoils a 95 % interval by more than a point of coverage.
pub const BIAS: f64 = 0.25;

/// Dry laws without a usable k.
pub const DRY_LAW: Kind = forbids("dry_law", AtMost(0.0))
    .by(USABLE)
    .then("check the dry runs of the particle, or add some at other speeds");

/// Square-root laws of a film ratio that are not usable; gates only where none is.
pub const SCALING_LAW: Kind = forbids("scaling_law", AtMost(0.0))
    .by(USABLE)
    .then("add rebounds over a wider range of speeds at these film ratios");

/// Constants, diameters and films outside what such experiments have.
pub const PLAUSIBLE_INPUT: Kind = forbids("plausible_input", AtMost(0.0))
    .by("no experiment with spheres on wetted plates has such")
    .then("correct the number, or the unit in its name");

/// Probability that so many rebounds, or such a block of rows, repeat others in every measured cell by chance.
pub const REPEATED_ROWS: Kind = forbids("repeated_rows", AtLeast(BEYOND_CHANCE))
    .by("two runs at one setting agree to the last digit with a probability that their scatter and that digit tell")
    .then("take out what was pasted or listed twice, or give the digits that tell the runs apart");

/// Probability that so many rows are the mean of other rows of their setting by chance.
pub const MEAN_ROWS: Kind = forbids("mean_rows", AtLeast(BEYOND_CHANCE))
    .by("another run seldom equals the mean of the others to the last digit")
    .then(
        "leave them out by a reason in the column `exclude`; a mean of runs that the table does not have is read with \
         a column `runs`",
    );

/// Probability that so many wet runs fall with the rebound speed of the row before by chance.
pub const SECOND_IMPACTS: Kind = forbids("second_impacts", AtLeast(BEYOND_CHANCE))
    .by("the law is that of a film at rest, which the first impact of a drop has thinned and set in motion")
    .then("leave second impacts out by a reason in the column `exclude`, or write the film that each met");

/// Distance of the speeds that one column gives from those of another, as a share.
pub const COLUMNS_AGREE: Kind = forbids("columns_agree", AtMost(0.03))
    .by(
        "both are of one impact, and air slows a falling sphere by 2 % at most; a nominal δ/D is near that of its \
         runs",
    )
    .then("correct the unit of one of them, or take the wrong one out of the table");

/// Results outside what such experiments have.
pub const PLAUSIBLE_RESULT: Kind = forbids("plausible_result", AtMost(0.0))
    .by("no experiment with spheres on wetted plates gives such")
    .then("check the units of densities, viscosities, films, roughness and speeds");

/// Film groups without a film ratio of their own; gates only where there are no others and nothing else to quote.
pub const FILM_GROUPS: Kind = cautions("film_groups", AtMost(0.0))
    .by("a law at one film ratio takes the films of its runs as one")
    .then(
        "name the film ratios that were meant, as film_ratios in [data] or in a column film_ratio; the energy balance \
         and the posterior use each run's own film and stand",
    );

/// Whether the energy balance over all rebounds has no usable fit.
pub const ENERGY_BALANCE: Kind = forbids("energy_balance", AtMost(0.0)).by(USABLE).then(
    "look for a wrong density, viscosity or film, for series that lie apart (series_offsets = true), and for \
         another [model] inertia or viscous; else add runs at other film ratios and speeds",
);

/// Root mean square over the wet runs of what the true impact speed is not known by, as a share of it: beyond this L comes
/// out low where speeds are not repeated.
pub const SPEED_ERRORS: Kind = forbids("speed_errors", AtMost(0.03))
    .by("bias of L on simulated runs: a third of a standard deviation or less at 2 %, a whole one at 5 %")
    .then("measure speeds better, or repeat each and give the errors in impact_speed_sd_m_s");

/// Distance of the wet runs' k from the dry runs', in combined standard errors: further off it is another k.
pub const DRY_CONSISTENCY: Kind = forbids("dry_consistency", AtMost(3.0))
    .by("misfit of the wet law leaks into k")
    .then("the wet law does not fit: try another form of inertia or dry_speed_m_s");

/// Distance of what the runs alone say of a parameter from its prior, in sds of the two together, on the scale of the prior;
/// gates where the posterior then lies more than [`FELT`] of its ± from what the runs say.
pub const PRIOR_CONFLICT: Kind = cautions("prior_conflict", AtMost(3.0))
    .by("chance puts 1 in 370 so far apart")
    .then("write another prior in [priors], or look for what is wrong in all runs: a unit, the films, a constant");

/// Distance of a main number with noise on the energy, too, from that without, or of its ±, in the smaller ±: beyond this the
/// wider stands, and where it is no wider or could not be sampled nothing is quoted.
pub const SLOW_REBOUNDS: Kind = forbids("slow_rebounds", AtMost(1.0))
    .by("an error of 1 % in speed or of 3 % in film moves the energy of a run of e < 0.15 by more than its noise")
    .then("give impact_speed_sd_m_s for each run, or write noise = \"both\" in [model]");

/// Share of the runs that a film ratio leaves out which nothing can use.
pub const MUCH_SCREENED: Kind = cautions("screened", AtMost(0.2))
    .by("a table that is read as it was measured has few runs that no law is for")
    .then("check films and diameters, and their units");

/// By how much a run that stuck moves a main number, in the larger ±, where no run rebounds slowly.
pub const UNSEEN_REBOUNDS: Kind = forbids("unseen_rebounds", AtMost(2.5))
    .by("a run that stuck agrees with those that rebound, unless small rebounds are not seen")
    .then("write in [data] the smallest_restitution that is seen, or check that these runs stuck");

/// By how many of its ± an outlier moves a main number.
pub const CARRYING_OUTLIER: Kind = forbids("carrying_outlier", AtMost(1.0))
    .by("normal noise would take a run so far in one table of a hundred")
    .then(
        "look at that row again: a reason in the column exclude leaves it out, and likelihood = \"student\" has room for \
         outliers",
    );

/// Runs that were not screened.
pub const RUNS_IN_USE: Kind = forbids("runs_in_use", AtLeast(1.0))
    .by("no runs, no numbers")
    .then("widen the limits in [data], or clear the column `exclude`");

/// Probability of so large a difference between diameters by chance; gates where it is below [`BEYOND_CHANCE`] and moves k
/// by more than [`FELT`].
pub const ONE_DRY_K: Kind = cautions("one_dry_k_for_all_diameters", AtLeast(BEYOND_CHANCE))
    .by(NESTED)
    .then("write [model] dry_k = \"diameter\", which gives each diameter its own k");

/// Probability of so large a misfit of the dry law to its own runs by chance; gates as [`ONE_DRY_K`] does.
pub const DRY_LAW_HOLDS: Kind = cautions("dry_law_holds", AtLeast(BEYOND_CHANCE)).by(NESTED).then(
    "keep to speeds at which it holds ([data] min_impact_speed_m_s, max_impact_speed_m_s), or try \
         \"dry_second_order\" in [model] terms",
);

/// Probability of so large a misfit of the wet law inside a particle, liquid and film by chance; a failure gates where it
/// moves a parameter by more than [`FELT`].
pub const WET_LAW_HOLDS: Kind = cautions("wet_law_holds", AtLeast(BEYOND_CHANCE)).by(NESTED).then(
    "leave out the films or speeds at which it does not hold ([data] min_film_um, min_impact_speed_m_s, a column \
         exclude), or try another [model] dry_speed_m_s, viscous or terms",
);

/// What the linear law gains in log density over the square root, the parameters of both free at every film ratio.
pub const LINEAR_LAW: Kind = forbids("linear_law", AtMost(GAIN))
    .by("where the square root holds, chance gains 4 in less than one table of 400")
    .then(
        "take e_inf and St_c of the linear laws, which the report has under Film thickness and laws.csv in full; L, C \
         and δc are those of the square root and say nothing here",
    );

/// What to do where the linear law serves better than the square root and does not hold either.
pub const NEITHER_LAW: &str =
    "quote no e_inf, St_c, L or C: check how films and speeds were measured, or leave out those at which no law holds ([data] \
     min_film_um, min_impact_speed_m_s, a column exclude)";

/// Factor by which offsets that series share may make a standard error too small.
const TOO_SMALL: f64 = 1.5;

/// Factor by which the standard errors of independent runs are too small, where series differ beyond chance
/// (p < [`BEYOND_CHANCE`]).
pub const INDEPENDENT_RUNS: Kind = forbids("independent_runs", AtMost(TOO_SMALL))
    .by("above it a 95 % interval covers less than 81 %")
    .then(
        "set [model] series_offsets = true, which gives each series an offset; look first whether another form of the \
         law, or the films, make it",
    );

const STATED: &str = "χ² against the stated measurement errors; probability of so large a one by chance";
const ESTIMATED: &str = "let the spread be estimated: take its `fixed = 0` out of [priors]";

/// Whether the stated errors of dry runs explain their scatter, where they are said to be all that scatters them.
pub const DRY_ERRORS: Kind = forbids("stated_errors_dry", AtLeast(BEYOND_CHANCE))
    .by(STATED)
    .then(ESTIMATED);

/// The same of the wet runs.
pub const WET_ERRORS: Kind = forbids("stated_errors_wet", AtLeast(BEYOND_CHANCE))
    .by(STATED)
    .then(ESTIMATED);

/// A probability below which a difference is not chance.
pub const BEYOND_CHANCE: f64 = 0.001;

/// Share of its ± by which a main number may move unsaid.
pub const FELT: f64 = 0.5;

/// A misfit that moves a main number by more than so many of its ± forbids quoting where chance makes it this seldom.
pub const FAR: f64 = 2.0;

/// See [`FAR`].
pub const SELDOM: f64 = 0.01;

/// A misfit that chance makes no more often than this, and that moves a main number by its ±, is a caution.
pub const DOUBTED: f64 = 0.1;

/// Share of the replicates of a main number without a number.
pub const BOOTSTRAP_FAILURES: Kind = forbids("bootstrap_failures", AtMost(0.01))
    .by("an interval is made of the replicates that gave a number")
    .then("add runs there, or screen them");

/// Parameters left to be sampled.
pub const PARAMETERS_LEFT: Kind = forbids("posterior", AtLeast(1.0))
    .by("a posterior needs parameters")
    .then("widen the limits in [data], or leave a prior open");

/// Runs beyond the parameters that they have to tell.
pub const RUNS_TO_SPARE: Kind = forbids("runs_to_spare", AtLeast(1.0))
    .by("parameters that can pass through every run leave no spread to tell their uncertainty by")
    .then("add runs, at other speeds or again at the same");

/// Draws of a sampling that could begin.
pub const DRAWS_MADE: Kind = forbids("posterior", AtLeast(1.0))
    .by("a posterior needs draws")
    .then("give the parameters narrower priors, or quote least squares");

/// Smallest spread of the runs: below it there is no noise to speak of.
pub const NOISE: Kind = forbids("noise", AtLeast(1e-12))
    .by("a likelihood needs a spread")
    .then("write every digit that was measured; runs that a formula gave have no uncertainty to quote");

/// Runs that rebounded.
pub const REBOUNDS: Kind = forbids("rebounds", AtLeast(1.0))
    .by("stuck runs alone give one bound only")
    .then("add faster runs");

/// Error of the log density of the few runs that stand for very many, against what it may be.
pub const COMPRESSION_ERROR: Kind = forbids("compression_error", AtMost(GIVEN))
    .by("an error of the log density below 0.001 moves no probability by 0.1 %")
    .then("run again with --exact-rows");

/// Largest R-hat of chains that have mixed.
pub const RHAT: Kind = forbids("rhat", AtMost(LARGEST_RHAT))
    .by(VEHTARI)
    .then("raise draws and warmup in [sampler], or give it a narrower prior");

/// Effective draws for the centre; the line is for one chain.
pub const ESS_BULK: Kind = forbids("ess_bulk", AtLeast(FEWEST_EFFECTIVE)).by(VEHTARI).then(LONGER);

/// Effective draws for the 5 % and 95 % points; the line is for one chain.
pub const ESS_TAIL: Kind = forbids("ess_tail", AtLeast(FEWEST_EFFECTIVE)).by(VEHTARI).then(LONGER);

/// Energy fraction of a chain that explores its energies.
pub const E_BFMI: Kind = forbids("e_bfmi", AtLeast(0.3))
    .by("Betancourt 2016")
    .then("the posterior has heavy tails; narrower priors help");

/// Kept draws whose trajectory diverged.
pub const DIVERGENCES: Kind = forbids("divergences", AtMost(0.0))
    .by("Betancourt 2017")
    .then("a region of the posterior is too sharp to be followed even in short steps; a narrower prior may help");

/// Kept draws whose trajectory was cut.
pub const TRAJECTORIES_CUT: Kind = kind("trajectories_cut", Level::Informs, Some(AtMost(0.0)))
    .by("slow, not wrong")
    .then("nothing, if R-hat and the effective draws hold; narrower priors shorten the trajectories");

/// Shape of the weights of the normal about the mode, against what so many draws bear.
pub const KHAT: Kind = forbids("khat", AtMost(GIVEN))
    .by(VEHTARI_PSIS)
    .then("leave --accuracy out: the posterior is then sampled by trajectories");

/// Error that a method vouches for, against what was asked.
pub const ACCURACY: Kind = forbids("accuracy", AtMost(GIVEN))
    .by("what was asked for")
    .then("no method could vouch for what was asked; ask for less");

/// Distance of the 50 % band's coverage from its level; the line is for many runs.
pub const PREDICTIVE_50: Kind = forbids("predictive_50", AtMost(0.05)).by(FEW_RUNS).then(OTHER_NOISE);

/// Distance of the 90 % band's coverage from its level; the line is for many runs.
pub const PREDICTIVE_90: Kind = forbids("predictive_90", AtMost(0.05)).by(FEW_RUNS).then(OTHER_NOISE);

/// Mean residual of a group, in σ; the line is for many runs.
pub const PREDICTIVE_RESIDUAL: Kind = forbids("predictive_residual", AtMost(0.5))
    .by("half σ, or 3.5 standard errors where there are too few runs to tell")
    .then("the law does not hold there: try another form of inertia, or screen it");

/// Probability of so many stuck runs in the worst series; the line is for one series.
pub const PREDICTIVE_STUCK: Kind = forbids("predictive_stuck", AtLeast(0.01))
    .by("1 %, shared among the series that could stick")
    .then(OTHER_NOISE);

/// What another form of the law gains in log density over the scene's own; fails where it is also more than
/// [`super::form_choice::GAIN_IN_SE`] of its standard errors.
pub const BETTER_FORM: Kind = forbids("better_form", AtMost(GAIN))
    .by("log density of runs left out one by one; clear beyond 4 and beyond 2 of its standard errors")
    .then("hold the form that predicts better");

/// What is to be done about e_dry at each run's own speed until forms that have it are compared.
pub(super) const COMPARE_DRY_SPEEDS: &str = "compare the forms: dry_speed_m_s = \"impact\" holds it";

/// What e_dry at each run's own speed gains in log density over its being absent, by a joint fit; fails where it would also
/// move a main number by more than its ±.
pub const DRY_SPEED: Kind = forbids("dry_speed", AtMost(3.0))
    .by("20 to 1 for it; at most 7 of 1,000 right tables gain so much by chance")
    .then(COMPARE_DRY_SPEEDS);

/// What another term that is not held gains so, where it may act in full; forbids quoting where leaving it out would move a main
/// number by more than [`FELT`] of its ±.
pub const TERM_ACTS: Kind = forbids("term_acts", AtMost(3.0))
    .by("20 to 1 for it; chance gains so much for one term or another in 2 of 1,000 right tables");

/// Posterior sds that a trend with the film lies from zero by chance in one table of 700.
pub const CLEAR_TREND: f64 = 3.2;

/// Posterior sds that a trend of L or C with the film lies from zero; fails where the trend is answered to be there.
pub const FILM_TREND: Kind = forbids("film_trend", AtMost(CLEAR_TREND))
    .by("posterior sds of the trend; chance takes 1 in 700 so far")
    .then(
        "fit films apart by [data] min_film_um and max_film_ratio, or try another [model] inertia or viscous; where \
         series lie apart for another reason, series_offsets = true",
    );

/// What to do about such a trend where series lie apart, too: what a series shares may feign a trend, or hide it.
const TREND_BESIDE_OFFSETS: &str =
    "set [model] series_offsets = true first, since series lie apart, too; if the trend stays, fit films apart by [data] \
     min_film_um and max_film_ratio, or try another [model] inertia or viscous";

/// What to do about such a trend, or series that lie apart, where the law itself does not hold: it makes either.
pub(super) const LAW_FIRST: &str =
    "see first to what the check of the wet law names, which lets series lie apart and feigns trends; [model] series_offsets = \
     true looks inside the series alone: where that check then holds, it was offsets";

/// What fails, what else may fail by it, and what to see to first then; what stands above goes before what stands below.
const FIRST_STEPS: [(&[Kind], &[Kind], &str); 6] = [
    (
        &[PRIOR_CONFLICT],
        &OF_A_PRIOR,
        "mend the prior first: this may come of it",
    ),
    // another law or form that is known to be nearer to the runs
    (&[LINEAR_LAW], &[WET_LAW_HOLDS], "see what is said of the linear law"),
    (
        &[BETTER_FORM],
        &[WET_LAW_HOLDS, PLAUSIBLE_RESULT],
        "take the form that predicts better first: this may come of it",
    ),
    (
        &[TERM_ACTS],
        &[ENERGY_BALANCE, WET_LAW_HOLDS, BETTER_FORM, FILM_TREND, INDEPENDENT_RUNS],
        "hold the term that the runs show first: this may come of it",
    ),
    (&[WET_LAW_HOLDS, LINEAR_LAW], &[FILM_TREND, INDEPENDENT_RUNS], LAW_FIRST),
    (&[INDEPENDENT_RUNS], &[FILM_TREND], TREND_BESIDE_OFFSETS),
];

/// Whether the wet law stands.
const LAWS: [Kind; 4] = [ENERGY_BALANCE, WET_LAW_HOLDS, LINEAR_LAW, BETTER_FORM];

const OF_A_PRIOR: [Kind; 7] = [
    DRY_CONSISTENCY,
    BETTER_FORM,
    FILM_TREND,
    PREDICTIVE_50,
    PREDICTIVE_90,
    PREDICTIVE_RESIDUAL,
    PREDICTIVE_STUCK,
];

/// Says what to see to first where several checks fail that one cause may explain.
pub(super) fn order_advice(remarks: &mut Vec<Remark>) {
    let fails = |kind: &Kind| remarks.iter().any(|remark| kind.is(remark) && remark.forbids());
    // what a law makes of stuck runs says nothing where it does not hold itself
    let law_stands = !LAWS.iter().any(fails);
    let found = FIRST_STEPS.into_iter().filter(|(causes, ..)| causes.iter().any(fails));
    let found: Vec<_> = found.collect();
    remarks.retain(|remark| law_stands || !UNSEEN_REBOUNDS.is(remark));
    for remark in remarks.iter_mut().filter(|remark| !remark.passed) {
        let first = found
            .iter()
            .find(|(_, others, _)| others.iter().any(|kind| kind.is(remark)));
        if let Some((.., first)) = first {
            remark.next_step = (*first).to_owned();
        }
    }
}

pub(crate) const SCREENED: Kind = found("screened").then("see the reasons");
pub(crate) const SPEEDS_PERHAPS: Kind = found("plausible_input")
    .then("nothing, if they were meant so; else correct the speeds: L and St_c are off by the same factor");
pub(crate) const REPEATS_PERHAPS: Kind = found("repeated_rows").then("look whether a row was entered twice");
pub(crate) const COLUMNS_DISAGREE: Kind = found("columns_disagree").then("look for a slip in these rows");
pub(crate) const STUCK_LEFT_OUT: Kind =
    found("stuck_left_out").then("quote the square-root law, and compare film ratios by how many of their runs stuck");
pub(crate) const DRY_RUN_WITHOUT_REBOUND: Kind =
    found("dry_run_without_rebound").then("check that they were dry: nothing in the dry law makes a sphere stick");
pub(crate) const NO_DRY_RUNS: Kind = found("no_dry_runs").then("add dry runs over the same speeds");
pub(crate) const VISCOUS_FORM: Kind = found("viscous_form").then(
    "measure the roughness, and give roughness_rel_sd; the model comparison says what one L for all would predict",
);
pub(crate) const SETTINGS_UNUSED: Kind =
    informing("settings_unused").then("nothing: they were checked, and are read where [model] asks for them");
pub(crate) const TERM_NOT_HELD: Kind = found("term_not_held");
pub(crate) const SPEED_ERROR_MATTERS: Kind = found("speed_error_matters")
    .then("give impact_speed_sd_m_s for each run, or leave out the runs nearest to sticking");
pub(crate) const MEASUREMENT_ERRORS_TOO_LARGE: Kind = found("measurement_errors_too_large")
    .then("check whether errors that all runs share, as of a scale, were given as errors of each run");
pub(crate) const OUTLIER: Kind = found("outlier").then(
    "check the rows: a mistake in one is to be mended there; likelihood = \"student\" keeps what cannot be from \
     moving the parameters",
);
pub(crate) const UNEQUAL_SPREAD: Kind = found("unequal_spread").then(
    "look at the group that scatters most; the fits of single film ratios have spreads of their own, and the \
     `cases` bootstrap does not take spreads as equal",
);
pub(crate) const NOISE_GROWS: Kind = found("noise_grows").then(
    "quote no bands of single runs (in figures, run_q05 to run_q95 of predict) near either end, or fit slow and \
     fast runs apart by [data] min_impact_speed_m_s and max_impact_speed_m_s; where it is the measurement, give \
     restitution_sd for each run",
);
pub(crate) const DRY_NOISE_GROWS: Kind = found("dry_noise_grows").then(
    "quote the `cases` bootstrap of k, which does not take the spread as even; where it is the measurement, give \
     restitution_sd for each run",
);
pub(crate) const SERIES_OFFSETS: Kind = found("series_offsets").then(
    "set [model] series_offsets = true: the posterior then has an offset for each series, and every main number is \
     its own",
);
pub(crate) const SLOW_REBOUNDS_ALLOWED: Kind = found("slow_rebounds")
    .then("measure speeds and films of these rows again, or give the errors of speeds: impact_speed_sd_m_s");
pub(crate) const SINGLE_RUN: Kind =
    found("single_run").then("check these rows, and repeat their settings: until then the numbers rest on them");
pub(crate) const BOOTSTRAP_FEWER_REPLICATES: Kind =
    informing("bootstrap_fewer_replicates").then("ask for fewer replicates, or fit fewer series in one scene");
pub(crate) const CONSTANTS_EXACT: Kind =
    found("constants_exact").then("say how well it is known, and the report adds it");
pub(crate) const UNSEEN: Kind = found("unseen").then("add the runs it names");
pub(crate) const PRIOR_RULES: Kind = found("prior_rules").then("quote it beside its prior, or add runs that tell it");
pub(crate) const COMPARE_LEFT_OUT: Kind = informing("compare_left_out").then("compare on a part of the runs");
pub(crate) const FORM_CHOSEN: Kind = found("form_chosen").then("name the form in [model] to fix it");
pub(crate) const FORM_NOT_COMPARED: Kind =
    informing("form_not_compared").then("see whether its parameters have room under their priors");

/// Those that bear on the main numbers, the one that bears most on them first.
const FIRST: [&Kind; 19] = [
    &SPEEDS_PERHAPS,
    &REPEATS_PERHAPS,
    &COLUMNS_DISAGREE,
    &SLOW_REBOUNDS_ALLOWED,
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

/// The remarks in the order in which they are told: by their level; at one level what was held against a line first, then
/// cautions about how the table was read, since everything rests on it, then the others by how much they bear on the main
/// numbers.
pub fn in_order(remarks: &[Remark]) -> Vec<&Remark> {
    let codes = FIRST.iter().map(|kind| kind.code);
    let codes: Vec<&str> = OF_READING.into_iter().chain(codes).collect();
    let weight = |remark: &&Remark| {
        let place = codes.iter().position(|code| *code == remark.code);
        let place = place.filter(|_| remark.line.is_none());
        (remark.level, remark.line.is_none(), place.unwrap_or(codes.len()))
    };
    let mut sorted: Vec<&Remark> = remarks.iter().filter(|remark| !remark.passed).collect();
    sorted.sort_by_key(weight);
    sorted
}

/// What the shared parameter of this name, or one of these quantities, is called; `None` where none has it.
pub(super) fn described(name: &str, others: [Quantity; 3]) -> Option<Described> {
    let shared = Coefficient::ALL.into_iter().map(Quantity::Shared);
    let mut all = shared.chain(others).map(Quantity::describe);
    all.find(|quantity| quantity.name == name)
}

/// A parameter or a main number by its symbol, as tables have it: `dry_k[PTFE]` is k of PTFE; one without keeps its name.
pub(crate) fn in_symbols(name: &str) -> String {
    let (key, of) = match name.split_once('[') {
        Some((key, of)) => (key, Some(of.trim_end_matches(']'))),
        None => (name, None),
    };
    let described = described(key, [Quantity::DryK, Quantity::EInf, Quantity::StC]);
    let of_noise = crate::scene::NOISE.iter().find(|own| own.name == key);
    match (described, of) {
        (None, _) => of_noise.map_or(name, |own| own.symbol).to_owned(),
        (Some(quantity), None) => quantity.symbol.to_owned(),
        (Some(quantity), Some(of)) => {
            // a film ratio comes last, a diameter before it; k has no film
            let films = usize::from(quantity.name != Quantity::DryK.describe().name);
            let first_film = of.split(',').count() - films;
            let word = |(place, part): (usize, &str)| match part.parse::<f64>() {
                Ok(_) if place >= first_film => format!("δ/D = {part}"),
                Ok(_) => format!("D = {part} mm"),
                Err(_) => part.to_owned(),
            };
            let words: Vec<String> = of.split(',').enumerate().map(word).collect();
            format!("{} of {}", quantity.symbol, words.join(", "))
        }
    }
}

/// A list cut to what can be read.
pub(super) fn shortened(items: &[String]) -> String {
    shortened_by(items, String::clone)
}

/// A list cut to what can be read, whose items take some looking up to be put into words.
pub(super) fn shortened_by<T>(items: &[T], words: impl Fn(&T) -> String) -> String {
    const SHOWN: usize = 3;
    let shown = items.iter().take(SHOWN).map(words).collect();
    and_more(shown, items.len(), "; ")
}

/// The one that, where it only informs, the report's table of terms tells.
pub(crate) const IN_TABLES: [&str; 1] = [TERM_NOT_HELD.code];

/// Which intervals resampling whole series changes.
pub(crate) const SERIES_SCHEME_CHANGES: &str =
    "changes the bootstrap intervals of the dry law's k and of e_inf, St_c, α and β of the laws, each where its runs are of \
     several series (or diameters, of k), and nothing else: neither k, L and C of the energy balance nor the posterior";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remark::ALL;

    #[test]
    fn a_value_on_its_line_holds_and_none_fails() {
        assert!(RHAT.check(1.01, "").passed && !RHAT.check(1.010_001, "").passed);
        assert!(ONE_DRY_K.check(0.001, "").passed && !ONE_DRY_K.check(0.000_999, "").passed);
        assert!(!RHAT.check(None, "").passed && !RHAT.check(f64::NAN, "").passed);
        // a line that nobody gave
        assert!(!KHAT.check(0.0, "").passed && KHAT.at(0.7).check(0.0, "").passed);
        assert!(ESS_BULK.at(400.0).check(400.0, "").passed && !ESS_BULK.at(400.0).check(399.0, "").passed);
    }

    #[test]
    fn a_check_that_no_main_number_rests_on_forbids_nothing() {
        let failed = || BOOTSTRAP_FAILURES.check(0.5, "");
        assert!(failed().forbids() && failed().concerns == [ALL]);
        let of_k = failed().concerning(["dry_k[PTFE]".to_owned()]);
        assert!(of_k.forbids() && of_k.concerns == ["dry_k[PTFE]"]);
        assert!(failed().concerning([]).informs());
    }

    #[test]
    fn where_another_form_is_better_it_is_advised_before_units_and_no_stuck_run_is_doubted() {
        let small = || PLAUSIBLE_RESULT.check(1.0, "L is too small");
        let mut remarks = vec![small(), UNSEEN_REBOUNDS.check(9.0, "a run stuck by the table")];
        order_advice(&mut remarks);
        assert!(remarks.len() == 2 && remarks[0] == small());
        remarks.push(BETTER_FORM.check(9.0, "another form predicts better"));
        order_advice(&mut remarks);
        assert!(remarks.iter().all(|remark| !UNSEEN_REBOUNDS.is(remark)));
        assert!(remarks[0]
            .next_step
            .starts_with("take the form that predicts better first"));
    }

    /// Where each diameter has its own k.
    #[test]
    fn sentences_name_parameters_by_their_symbols() {
        assert_eq!(in_symbols("dry_k[PTFE,4.762]"), "k of PTFE, D = 4.762 mm");
        let st_c = "St_c of PTFE, D = 4.762 mm, AK10, δ/D = 0.06";
        assert_eq!(in_symbols("st_c[PTFE,4.762,AK10,0.06]"), st_c);
    }

    #[test]
    fn what_bears_most_on_the_main_numbers_comes_first_and_the_rest_keeps_its_order() {
        let given = ["form_chosen", "screened", "constants_exact", "outlier", OF_READING[2]];
        let mut remarks = given.map(|code| Remark::new(code, 1, "", "")).to_vec();
        remarks.insert(0, Remark::new(OF_READING[0], 1, "", "").at(Level::Informs));
        remarks.extend([ONE_DRY_K.check(0.0, ""), RHAT.check(2.0, ""), RHAT.check(1.0, "")]);
        let codes: Vec<&str> = in_order(&remarks).iter().map(|remark| remark.code).collect();
        let expected = [
            "rhat",
            "one_dry_k_for_all_diameters",
            OF_READING[2],
            "outlier",
            "screened",
            "form_chosen",
            "constants_exact",
            OF_READING[0],
        ];
        assert_eq!(codes, expected);
    }
}

//! Lists what must hold before numbers are quoted: each check with its line, where that comes from, and what to do.

use serde::Serialize;
use Line::{AtLeast, AtMost};

use super::form_choice::GAIN;
use crate::inference::mixing::{FEWEST_EFFECTIVE, LARGEST_RHAT};

/// On which side of its line a value must lie; the line itself counts as holding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Line {
    /// no larger than this
    AtMost(f64),
    /// no smaller than this
    AtLeast(f64),
}

/// A line that only the settings or the number of draws say, see [`Criterion::at`]; unless given, nothing holds.
const GIVEN: f64 = f64::NAN;

/// One entry of the table of checks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// a fixed word a script can test for
    pub code: &'static str,
    /// what the value is held against
    pub line: Line,
    /// whether a failure forbids quoting the main numbers
    pub gates: bool,
    /// whether no main number rests on it, so that a failure is no caution either
    pub informs: bool,
    /// where the line comes from
    pub source: &'static str,
    /// what to do where it fails
    pub advice: &'static str,
}

/// What was found of one criterion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// a fixed word a script can test for
    pub check: &'static str,
    /// what was found; `None` where nothing could be
    pub value: Option<f64>,
    /// the line it is held against
    pub threshold: f64,
    /// whether it holds
    pub passed: bool,
    /// whether a failure forbids quoting the main numbers
    pub gates: bool,
    /// where the line comes from
    pub source: &'static str,
    /// what it concerns, in words
    pub text: String,
    /// what to do where it fails
    pub advice: &'static str,
    /// names of the main numbers that rest on it, or `all`; empty where no main number does
    pub concerns: Vec<String>,
}

impl Criterion {
    /// The same criterion with another line on the same side, for data that ask for one of their own.
    #[must_use]
    pub fn at(self, line: f64) -> Criterion {
        let line = match self.line {
            AtMost(_) => AtMost(line),
            AtLeast(_) => AtLeast(line),
        };
        Criterion { line, ..self }
    }

    /// The number of its line.
    pub fn threshold(&self) -> f64 {
        match self.line {
            AtMost(line) | AtLeast(line) => line,
        }
    }

    /// Whether a value lies on the right side; NaN does not.
    pub fn holds(&self, value: f64) -> bool {
        match self.line {
            AtMost(line) => value <= line,
            AtLeast(line) => value >= line,
        }
    }

    /// What was found, `None` where nothing could be, which fails; `text` says what it concerns.
    pub fn check(self, value: impl Into<Option<f64>>, text: impl Into<String>) -> Check {
        let value = value.into();
        Check {
            check: self.code,
            value,
            threshold: self.threshold(),
            passed: value.is_some_and(|value| self.holds(value)),
            gates: self.gates,
            source: self.source,
            text: text.into(),
            advice: self.advice,
            concerns: if self.informs { vec![] } else { vec![ALL.to_owned()] },
        }
    }
}

/// What a check concerns that every main number rests on.
pub const ALL: &str = "all";

impl Check {
    /// That only these main numbers rest on; where there are none, a failure forbids nothing.
    #[must_use]
    pub fn concerning(self, names: impl IntoIterator<Item = String>) -> Check {
        let concerns: Vec<String> = names.into_iter().collect();
        Check {
            gates: self.gates && !concerns.is_empty(),
            concerns,
            ..self
        }
    }

    /// Whether it failed without forbidding to quote, and bears on a main number.
    pub fn cautions(&self) -> bool {
        !self.passed && !self.gates && !self.concerns.is_empty()
    }

    /// What was found, without the advice that some texts end with.
    pub fn found(&self) -> &str {
        let found = self.text.strip_suffix(self.advice).unwrap_or(&self.text);
        found.trim_end_matches([';', ' ', '.'])
    }

    /// With more words where it fails.
    #[must_use]
    pub fn if_failed(mut self, words: &str) -> Check {
        if !self.passed {
            self.text.push_str("; ");
            self.text.push_str(words);
        }
        self
    }

    /// With its advice among the words where it fails.
    #[must_use]
    pub fn with_advice(self) -> Check {
        let advice = self.advice;
        self.if_failed(advice)
    }

    /// Takes other advice, also among the words.
    pub(super) fn advise(&mut self, advice: &'static str) {
        if let Some(found) = self.text.strip_suffix(self.advice) {
            self.text = format!("{found}{advice}");
        }
        self.advice = advice;
    }
}

const USABLE: &str = "every fit must converge, with a standard error and the sign the physics has";
const COVERS: &str = "a bias of 0.25 standard errors leaves a 95 % interval covering 94 %";
const NESTED: &str = "F test of nested fits; probability of so large a difference by chance";
const LEAKS: &str = "misfit of the wet law leaks into k";
const VEHTARI: &str = "Vehtari et al. 2021";
const VEHTARI_PSIS: &str = "Vehtari et al. 2024: min(1 − 1/log10 S, 0.7)";
const FEW_RUNS: &str = "5 points, or 3.5 standard errors where there are too few runs to tell";

const BETTER: &str = "log density of runs left out one by one; clear beyond 4 and beyond 2 of its standard errors";

const LONGER: &str = "raise draws and warmup in [sampler]";
const OTHER_NOISE: &str = "try [model] likelihood = \"student\" or noise = \"both\"";

/// A bias above this share of the standard error spoils a 95 % interval by more than a point of coverage.
pub const BIAS: f64 = 0.25;

/// A check whose failure forbids quoting the main numbers.
const fn gates(code: &'static str, line: Line, source: &'static str, advice: &'static str) -> Criterion {
    Criterion {
        code,
        line,
        gates: true,
        informs: false,
        source,
        advice,
    }
}

/// A check whose failure tells that a main number, or what may be concluded from it, wants a look.
const fn cautions(code: &'static str, line: Line, source: &'static str, advice: &'static str) -> Criterion {
    Criterion {
        gates: false,
        ..gates(code, line, source, advice)
    }
}

/// A check that no main number rests on.
const fn informs(code: &'static str, line: Line, source: &'static str, advice: &'static str) -> Criterion {
    Criterion {
        informs: true,
        ..cautions(code, line, source, advice)
    }
}

/// Dry laws without a usable k.
pub const DRY_LAW: Criterion = gates(
    "dry_law",
    AtMost(0.0),
    USABLE,
    "check the dry runs of the particle, or add some at other speeds",
);

/// Square-root laws of a film ratio that are not usable; gates only where none is.
pub const SCALING_LAW: Criterion = gates(
    "scaling_law",
    AtMost(0.0),
    USABLE,
    "add rebounds over a wider range of speeds at these film ratios",
);

/// Constants, diameters and films outside what such experiments have.
pub const PLAUSIBLE_INPUT: Criterion = gates(
    "plausible_input",
    AtMost(0.0),
    "no experiment with spheres on wetted plates has such",
    "correct the number, or the unit in its name",
);

/// Probability that so many rebounds, or such a block of rows, repeat others in every measured cell by chance.
pub const REPEATED_ROWS: Criterion = gates(
    "repeated_rows",
    AtLeast(BEYOND_CHANCE),
    "two runs at one setting agree to the last digit with a probability that their scatter and that digit tell",
    "take out what was pasted or listed twice, or give the digits that tell the runs apart",
);

/// Probability that so many rows are the mean of other rows of their setting by chance.
pub const MEAN_ROWS: Criterion = gates(
    "mean_rows",
    AtLeast(BEYOND_CHANCE),
    "another run seldom equals the mean of the others to the last digit",
    "leave them out by a reason in the column `exclude`; a mean of runs that the table does not have is read with a column `runs`",
);

/// Distance of the speeds that one column gives from those of another, as a share.
pub const COLUMNS_AGREE: Criterion = gates(
    "columns_agree",
    AtMost(0.03),
    "both are of one impact, and air slows a falling sphere by 2 % at most; a nominal δ/D is near that of its runs",
    "correct the unit of one of them, or take the wrong one out of the table",
);

/// Results outside what such experiments have.
pub const PLAUSIBLE_RESULT: Criterion = gates(
    "plausible_result",
    AtMost(0.0),
    "no experiment with spheres on wetted plates gives such",
    "check the units of densities, viscosities, films, roughness and speeds",
);

/// Film groups without a film ratio of their own; gates only where there are no others and nothing else to quote.
pub const FILM_GROUPS: Criterion = cautions(
    "film_groups",
    AtMost(0.0),
    "a law at one film ratio takes the films of its runs as one",
    "name the film ratios that were meant, as film_ratios in [data] or in a column film_ratio; the energy balance and the \
     posterior use each run's own film and stand",
);

/// Whether the energy balance over all rebounds has no usable fit.
pub const ENERGY_BALANCE: Criterion = gates(
    "energy_balance",
    AtMost(0.0),
    USABLE,
    "add runs at other film ratios and speeds, or name fewer terms in [model]",
);

/// Root mean square over the wet runs of what the true impact speed is not known by, as a share of it: beyond this L comes
/// out low where speeds are not repeated.
pub const SPEED_ERRORS: Criterion = gates(
    "speed_errors",
    AtMost(0.03),
    "bias of L on simulated runs: a third of a standard deviation or less at 2 %, a whole one at 5 %",
    "measure speeds better, or repeat each and give the errors in impact_speed_sd_m_s",
);

/// Distance of the wet runs' k from the dry runs', in combined standard errors: further off it is another k.
pub const DRY_CONSISTENCY: Criterion = gates(
    "dry_consistency",
    AtMost(3.0),
    LEAKS,
    "the wet law does not fit: try another form of inertia or dry_speed_m_s",
);

/// Distance of what the runs alone say of a parameter from its prior, in sds of the two together, on the scale of the prior;
/// gates where the posterior then lies more than [`FELT`] of its ± from what the runs say.
pub const PRIOR_CONFLICT: Criterion = cautions(
    "prior_conflict",
    AtMost(3.0),
    "chance puts 1 in 370 so far apart",
    "widen or drop the prior in [priors], or look for what is wrong in all runs: a unit, the films, a constant",
);

/// Distance of a main number with noise on the energy, too, from that without, in the smaller ±: beyond this the wider
/// stands, and where it could not be sampled nothing is quoted.
pub const SLOW_REBOUNDS: Criterion = gates(
    "slow_rebounds",
    AtMost(1.0),
    "an error of 1 % in speed or of 3 % in film moves the energy of a run of e < 0.15 by more than its noise",
    "give impact_speed_sd_m_s and film_sd_um, or leave out these rows",
);

/// Runs that were not screened.
pub const RUNS_IN_USE: Criterion = gates(
    "runs_in_use",
    AtLeast(1.0),
    "no runs, no numbers",
    "widen the limits in [data], or clear the column `exclude`",
);

/// Series without a square-root law of their own.
pub const SERIES: Criterion = informs(
    "series",
    AtMost(0.0),
    USABLE,
    "nothing: their runs count in every fit of several series; more speeds or rebounds would give each its own law",
);

/// Probability of so large a difference between diameters by chance; gates where it is below [`BEYOND_CHANCE`] and moves k
/// by more than [`FELT`].
pub const ONE_DRY_K: Criterion = cautions(
    "one_dry_k_for_all_diameters",
    AtLeast(BEYOND_CHANCE),
    NESTED,
    "write [model] dry_k = \"diameter\", which gives each diameter its own k",
);

/// Probability of so large a misfit of the dry law to its own runs by chance; gates as [`ONE_DRY_K`] does.
pub const DRY_LAW_HOLDS: Criterion = cautions(
    "dry_law_holds",
    AtLeast(BEYOND_CHANCE),
    NESTED,
    "keep to speeds at which it holds ([data] min_impact_speed_m_s, max_impact_speed_m_s), or try \"dry_second_order\" in \
     [model] terms",
);

/// Probability of so large a misfit of the wet law inside a particle, liquid and film by chance; a failure gates where it
/// moves a parameter by more than [`FELT`].
pub const WET_LAW_HOLDS: Criterion = cautions(
    "wet_law_holds",
    AtLeast(BEYOND_CHANCE),
    NESTED,
    "leave out the films or speeds at which it does not hold ([data] min_film_um, min_impact_speed_m_s, a column exclude), \
     or try another [model] dry_speed_m_s, viscous or terms",
);

/// Factor by which offsets that series share may make a standard error too small.
const TOO_SMALL: f64 = 1.5;

/// Factor by which the standard errors of independent runs are too small, where series differ beyond chance
/// (p < [`BEYOND_CHANCE`]).
pub const INDEPENDENT_RUNS: Criterion = gates(
    "independent_runs",
    AtMost(TOO_SMALL),
    "above it a 95 % interval covers less than 81 %",
    "set [model] series_offsets = true, which gives each series an offset; look first whether another form of the law, or the \
     films, make it",
);

const STATED: &str = "χ² against the stated measurement errors; probability of so large a one by chance";
const ESTIMATED: &str = "let the spread be estimated: take its `fixed = 0` out of [priors]";

/// Whether the stated errors of dry runs explain their scatter, where they are said to be all that scatters them.
pub const DRY_ERRORS: Criterion = gates("stated_errors_dry", AtLeast(BEYOND_CHANCE), STATED, ESTIMATED);

/// The same of the wet runs.
pub const WET_ERRORS: Criterion = gates("stated_errors_wet", AtLeast(BEYOND_CHANCE), STATED, ESTIMATED);

/// A probability below which a difference is not chance.
pub const BEYOND_CHANCE: f64 = 0.001;

/// Share of its ± by which a main number may move unsaid.
pub const FELT: f64 = 0.5;

/// Bias of the square-root law by pooling liquids, in standard errors.
pub const SQUARE_ROOT_LAW_BIAS: Criterion = informs(
    "square_root_law_bias",
    AtMost(BIAS),
    COVERS,
    "nothing: where the liquids of a film ratio differ so much, its main numbers are not this law's",
);

/// Bias of the linear law at a film ratio, in standard errors.
pub const LINEAR_LAW_BIAS: Criterion = informs(
    "linear_law_bias",
    AtMost(BIAS),
    COVERS,
    "nothing: no main number is the linear law's",
);

/// Share of the replicates of a main number without a number.
pub const BOOTSTRAP_FAILURES: Criterion = gates(
    "bootstrap_failures",
    AtMost(0.01),
    "an interval is made of the replicates that gave a number",
    "add runs there, or screen them",
);

/// Parameters left to be sampled.
pub const PARAMETERS_LEFT: Criterion = gates(
    "posterior",
    AtLeast(1.0),
    "a posterior needs parameters",
    "widen the limits in [data], or leave a prior open",
);

/// Runs beyond the parameters that they have to tell.
pub const RUNS_TO_SPARE: Criterion = gates(
    "runs_to_spare",
    AtLeast(1.0),
    "parameters that can pass through every run leave no spread to tell their uncertainty by",
    "add runs, at other speeds or again at the same",
);

/// Draws of a sampling that could begin.
pub const DRAWS_MADE: Criterion = gates(
    "posterior",
    AtLeast(1.0),
    "a posterior needs draws",
    "give the parameters narrower priors, or quote least squares",
);

/// Smallest spread of the runs: below it there is no noise to speak of.
pub const NOISE: Criterion = gates(
    "noise",
    AtLeast(1e-12),
    "a likelihood needs a spread",
    "quote least squares",
);

/// Runs that rebounded.
pub const REBOUNDS: Criterion = gates(
    "rebounds",
    AtLeast(1.0),
    "stuck runs alone give one bound only",
    "add faster runs",
);

/// Error of the log density of the few runs that stand for very many, against what it may be.
pub const COMPRESSION_ERROR: Criterion = gates(
    "compression_error",
    AtMost(GIVEN),
    "an error of the log density below 0.001 moves no probability by 0.1 %",
    "run again with --exact-rows",
);

/// Largest R-hat of chains that have mixed.
pub const RHAT: Criterion = gates(
    "rhat",
    AtMost(LARGEST_RHAT),
    VEHTARI,
    "raise draws and warmup in [sampler], or give it a narrower prior",
);

/// Effective draws for the centre; the line is for one chain.
pub const ESS_BULK: Criterion = gates("ess_bulk", AtLeast(FEWEST_EFFECTIVE), VEHTARI, LONGER);

/// Effective draws for the 5 % and 95 % points; the line is for one chain.
pub const ESS_TAIL: Criterion = gates("ess_tail", AtLeast(FEWEST_EFFECTIVE), VEHTARI, LONGER);

/// Energy fraction of a chain that explores its energies.
pub const E_BFMI: Criterion = gates(
    "e_bfmi",
    AtLeast(0.3),
    "Betancourt 2016",
    "the posterior has heavy tails; narrower priors help",
);

/// Kept draws whose trajectory diverged.
pub const DIVERGENCES: Criterion = gates(
    "divergences",
    AtMost(0.0),
    "Betancourt 2017",
    "a region of the posterior is too sharp to be followed even in short steps; a narrower prior may help",
);

/// Kept draws whose trajectory was cut.
pub const TRAJECTORIES_CUT: Criterion = informs(
    "trajectories_cut",
    AtMost(0.0),
    "slow, not wrong",
    "nothing, if R-hat and the effective draws hold; narrower priors shorten the trajectories",
);

/// Shape of the weights of the normal about the mode, against what so many draws bear.
pub const KHAT: Criterion = gates(
    "khat",
    AtMost(GIVEN),
    VEHTARI_PSIS,
    "leave --accuracy out: the posterior is then sampled by trajectories",
);

/// Error that a method vouches for, against what was asked.
pub const ACCURACY: Criterion = gates(
    "accuracy",
    AtMost(GIVEN),
    "what was asked for",
    "no method could vouch for what was asked; ask for less",
);

/// Distance of the 50 % band's coverage from its level; the line is for many runs.
pub const PREDICTIVE_50: Criterion = gates("predictive_50", AtMost(0.05), FEW_RUNS, OTHER_NOISE);

/// Distance of the 90 % band's coverage from its level; the line is for many runs.
pub const PREDICTIVE_90: Criterion = gates("predictive_90", AtMost(0.05), FEW_RUNS, OTHER_NOISE);

/// Mean residual of a group, in σ; the line is for many runs.
pub const PREDICTIVE_RESIDUAL: Criterion = gates(
    "predictive_residual",
    AtMost(0.5),
    "half σ, or 3.5 standard errors where there are too few runs to tell",
    "the law does not hold there: try another form of inertia, or screen it",
);

/// Probability of so many stuck runs in the worst series; the line is for one series.
pub const PREDICTIVE_STUCK: Criterion = gates(
    "predictive_stuck",
    AtLeast(0.01),
    "1 %, shared among the series that could stick",
    OTHER_NOISE,
);

/// What another form of the law gains in log density over the scene's own; fails where it is also more than
/// [`super::form_choice::GAIN_IN_SE`] of its standard errors.
pub const BETTER_FORM: Criterion = gates(
    "better_form",
    AtMost(GAIN),
    BETTER,
    "hold the form that predicts better",
);

/// What a trend of L or C with the film gains in log density; fails where the trend is answered to be there.
pub const FILM_TREND: Criterion = gates(
    "film_trend",
    AtMost(GAIN),
    "log density of runs left out one by one; a trend 3.2 sds from zero gains 4, as chance makes 1 in 700",
    "fit films apart by [data] min_film_um and max_film_ratio, or try another [model] inertia or viscous; where series lie \
     apart for another reason, series_offsets = true",
);

/// Shape of the leave-one-out weights, against what so many draws bear.
pub const LOO_KHAT: Criterion = informs(
    "loo_khat",
    AtMost(GIVEN),
    VEHTARI_PSIS,
    "take the comparison of forms as rough, and check the runs of largest weight",
);

#[cfg(test)]
mod tests {
    use super::*;

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
        assert!(failed().gates && failed().concerns == [ALL]);
        let of_k = failed().concerning(["dry_k[PTFE]".to_owned()]);
        assert!(of_k.gates && of_k.concerns == ["dry_k[PTFE]"]);
        assert!(!failed().concerning([]).gates);
    }

    #[test]
    fn advice_is_added_where_it_fails() {
        assert_eq!(ACCURACY.at(0.1).check(0.05, "error").with_advice().text, "error");
        assert_eq!(ESS_TAIL.check(5.0, "few").with_advice().text, format!("few; {LONGER}"));
    }
}

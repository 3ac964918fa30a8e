//! Lists what wants a second look: the table of codes with what to do about each, and in which order they are told.
//!
//! The sentence is made where what it says was found.

use crate::notice::{Level, Notice};
use crate::runs::OF_READING;

/// One entry of the table of notices.
pub(crate) struct Entry {
    /// a fixed word a script can test for
    pub(crate) code: &'static str,
    /// whether it bears on the main numbers, unless the data say otherwise
    level: Level,
    /// what to do about it, unless the data say something more particular
    pub(super) next_step: &'static str,
}

impl Entry {
    /// What was found, of so many.
    pub(super) fn notice(&self, count: usize, text: String) -> Notice {
        self.with_next_step(count, text, self.next_step)
    }

    /// The same with something more particular to do.
    pub(super) fn with_next_step(&self, count: usize, text: String, next_step: impl Into<String>) -> Notice {
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

pub(super) const SCREENED: Entry = entry("screened", "see the reasons");
pub(super) const REPEATED_ROWS: Entry = entry("repeated_rows", "look whether a row was entered twice");
pub(super) const COLUMNS_DISAGREE: Entry = entry("columns_disagree", "look for a slip in these rows");
pub(super) const STUCK_LEFT_OUT: Entry = entry(
    "stuck_left_out",
    "quote the square-root law, and compare film ratios by how many of their runs stuck",
);
pub(super) const DRY_RUN_WITHOUT_REBOUND: Entry = entry(
    "dry_run_without_rebound",
    "check that they were dry: nothing in the dry law makes a sphere stick",
);
pub(super) const SERIES_FAILED: Entry = informing(
    "series_failed",
    "their runs still count in the scaling with St; more speeds or more rebounds would give them their own",
);
pub(super) const NO_DRY_RUNS: Entry = entry("no_dry_runs", "add dry runs over the same speeds");
pub(super) const VISCOUS_FORM: Entry = entry(
    "viscous_form",
    "measure the roughness, and give roughness_rel_sd; the model comparison says what one L for all would predict",
);
pub(super) const SETTINGS_UNUSED: Entry = informing(
    "settings_unused",
    "nothing: they were checked and wait for the stage that reads them; intervals here are delta-method ones",
);
pub(super) const TERM_NOT_HELD: Entry = entry("term_not_held", "name it in [model] terms to hold it");
pub(super) const TERM_LEFT_OUT: Entry = informing("term_left_out", "name it in [model] terms to hold it");
pub(super) const TERM_TOO_SMALL: Entry = informing("term_too_small", "terms = \"auto\" would decide by the size");
pub(super) const SPEED_ERROR_MATTERS: Entry = entry(
    "speed_error_matters",
    "give impact_speed_sd_m_s for each run, or leave out the runs nearest to sticking",
);
pub(super) const MEASUREMENT_ERRORS_TOO_LARGE: Entry = entry(
    "measurement_errors_too_large",
    "check whether errors that all runs share, as of a scale, were given as errors of each run",
);
pub(super) const OUTLIER: Entry = entry(
    "outlier",
    "check the rows: a mistake in one is to be mended there; likelihood = \"student\" keeps what cannot be from \
     moving the parameters",
);
pub(super) const UNEQUAL_SPREAD: Entry = entry(
    "unequal_spread",
    "look at the group that scatters most; the fits of single film ratios have spreads of their own, and the `cases` \
     bootstrap does not take spreads as equal",
);
pub(crate) const NOISE_GROWS: Entry = entry(
    "noise_grows",
    "quote no bands of single runs (in figures, run_q05 to run_q95 of predict) near either end, or fit slow and fast runs \
     apart by [data] min_impact_speed_m_s and max_impact_speed_m_s; where it is the measurement, give restitution_sd for \
     each run",
);
pub(super) const DRY_NOISE_GROWS: Entry = entry(
    "dry_noise_grows",
    "quote the `cases` bootstrap of k, which does not take the spread as even; where it is the measurement, give \
     restitution_sd for each run",
);
pub(super) const SERIES_OFFSETS: Entry = entry(
    "series_offsets",
    "set [model] series_offsets = true: the posterior then has an offset for each series, and every main number is its own",
);
pub(super) const SLOW_REBOUNDS: Entry = entry(
    "slow_rebounds",
    "measure speeds and films of these rows again, or give their errors: impact_speed_sd_m_s, and film_sd_um in [data]",
);
pub(crate) const SINGLE_RUN: Entry = entry(
    "single_run",
    "check these rows, and repeat their settings: until then the numbers rest on them",
);
pub(super) const BOOTSTRAP_FEWER_REPLICATES: Entry = informing(
    "bootstrap_fewer_replicates",
    "ask for fewer replicates, or fit fewer series in one scene",
);
pub(super) const BOOTSTRAP_FEW_RUNS: Entry =
    informing("bootstrap_few_runs", "take such intervals as rough, or repeat the runs");
pub(super) const BOOTSTRAP_PARTLY_STUCK: Entry = entry(
    "bootstrap_partly_stuck",
    "compare with film ratios whose runs all rebound; the delta interval does not know of it either",
);
pub(super) const BOOTSTRAP_SINGLE_RUN_STRATA: Entry = informing(
    "bootstrap_single_run_strata",
    "a second run of such a series would tell its noise",
);
pub(super) const BOOTSTRAP_BY_SANDWICH: Entry =
    informing("bootstrap_by_sandwich", "nothing: of so many runs both give the same");
pub(super) const BOOTSTRAP_ONE_SERIES: Entry = informing(
    "bootstrap_one_series",
    "choose scheme = \"cases\" for their bootstrap interval",
);
pub(super) const CONSTANTS_EXACT: Entry = entry("constants_exact", "say how well it is known, and the report adds it");
pub(super) const UNSEEN: Entry = entry("unseen", "add the runs it names");
pub(super) const PRIOR_RULES: Entry = entry("prior_rules", "quote it beside its prior, or add runs that tell it");
pub(super) const COMPARE_LEFT_OUT: Entry = informing("compare_left_out", "compare on a part of the runs");
pub(super) const FORM_CHOSEN: Entry = entry("form_chosen", "name the form in [model] to fix it");
pub(super) const FORM_NOT_COMPARED: Entry = informing(
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

/// Those of them that, where they only inform, a table of the report tells: that of the terms, or that of the series without
/// a law.
pub(crate) const IN_TABLES: [&str; 4] = [
    TERM_NOT_HELD.code,
    TERM_LEFT_OUT.code,
    TERM_TOO_SMALL.code,
    SERIES_FAILED.code,
];

/// Which intervals resampling whole series changes.
pub(crate) const SERIES_SCHEME_CHANGES: &str =
    "changes the bootstrap intervals of the dry law's k and of e_inf, St_c, α and β of the laws, each where its runs are of \
     several series (or diameters, of k), and nothing else: neither k, L and C of the energy balance nor the posterior";

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
}

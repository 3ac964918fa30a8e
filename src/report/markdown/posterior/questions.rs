//! Writes whether L and C are the same at every film ratio.

use super::super::super::figures::RESIDUALS;
use super::super::super::numbers;
use super::super::super::ReportInput;
use super::super::page::Page;
use super::super::table::ReportTable;
use crate::findings::form_choice::{GAIN, GAIN_IN_SE};
use crate::findings::questions::{Answer, Question, SMALL};

/// Both questions with their answers; nothing where they were not asked.
pub(super) fn questions(page: &mut Page, input: ReportInput) {
    let asked = input.findings.questions.as_ref();
    let Some(questions) = asked.filter(|_| !input.runs.series.is_empty()) else {
        return;
    };
    page.subsection("Questions the paper leaves", &format!(
        "The paper takes L as constant for δ/D below 0.10, and its inertial loss levels off where its formulas do not. Each \
         is asked by a second model of the same runs with a trend: L + L′ ln(δ̃/δ̃_m), or C (δ̃/δ̃_m)^C′, δ̃_m being the \
         geometric mean of their film ratios. {}Gain: log density of each run as predicted from the others (PSIS-LOO), summed, \
         with the trend less without it. A trend is there where its 95 % interval excludes zero and it gains more than {GAIN} \
         and {GAIN_IN_SE} standard errors, without runs whose k-hat is above the line. The parameter is constant where neither \
         end of that interval moves an e_inf or a St_c at a film ratio of the runs by more than {:.0} %; otherwise the \
         question is open.",
        priors(questions),
        100.0 * SMALL
    ));
    page.table(&table(questions));
    for question in questions {
        if let Some(why) = &question.why_open {
            page.paragraph(&format!("{} Open: {why}.", question.question));
        }
    }
    page.figure(
        RESIDUALS,
        "mean residuals against the film ratio",
        "Mean of (e − predicted)/σ at each film ratio under this scene's own model, without a trend, with its standard error from \
         the spread between runs; a stuck run counts as the mean of what stuck runs have. A loss that grows less with the film \
         than the model says shows as residuals that rise with it.",
    );
}

/// What was believed of each trend that was sampled.
fn priors(questions: &[Question]) -> String {
    let sampled = questions.iter().filter_map(|question| question.trend.as_ref());
    let texts = sampled.map(|trend| format!("{}: {} ({}). ", trend.symbol, trend.prior, trend.source));
    let texts: String = texts.collect();
    if texts.is_empty() {
        texts
    } else {
        format!("Priors, {texts}")
    }
}

fn table(questions: &[Question]) -> ReportTable<&Question> {
    ReportTable::of(questions)
        .column("question", |question| question.question)
        .column_if_any("wet runs", |question| (question.runs > 0).then_some(question.runs))
        .column_if_any("film ratios", |question| question.film_ratios)
        .column_if_any("gain ± se", |question| match (question.gain, question.gain_se) {
            (Some(gain), Some(se)) => numbers::with_se(gain, se),
            (gain, _) => numbers::optional(gain, 3),
        })
        .column_if_any("trend, mean ± sd", |question| {
            let trend = question.trend.as_ref()?;
            Some(format!("{} = {}", trend.symbol, numbers::with_se(trend.mean, trend.sd)))
        })
        .column_if_any("its 95 % interval", |question| {
            let trend = question.trend.as_ref()?;
            Some(numbers::between(trend.interval[0], trend.interval[1], trend.sd))
        })
        .column_if_any("it moves e_inf or St_c by up to / %", |question| {
            let change = question.trend.as_ref()?.largest_change?;
            Some(numbers::significant(100.0 * change, 2))
        })
        .column_if_any("largest k-hat", |question| {
            let khat = question.models.iter().filter_map(|model| model.khat_max);
            numbers::optional(khat.reduce(f64::max), 2)
        })
        .column("answer", |question| match question.answer {
            Answer::Constant => "yes",
            Answer::Rises => "no, it rises",
            Answer::Falls => "no, it falls",
            Answer::Open => "open",
        })
}

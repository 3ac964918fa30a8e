//! Tells whether L and C are the same at every film ratio, with the residuals at each.

use super::super::super::figures::RESIDUALS;
use super::super::super::numbers::{self, NONE};
use super::super::super::Told;
use super::super::page::Page;
use crate::findings::posterior::Posterior;
use crate::findings::questions::{Answer, Question};

/// Both questions with their answers; nothing where they were not asked.
pub(super) fn questions(page: &mut Page, told: Told, posterior: &Posterior) {
    let Some(questions) = &told.findings.questions else {
        return;
    };
    page.subheading("Questions the paper leaves");
    page.paragraph(&format!(
        "The paper takes L as constant for δ/D below 0.10, and its inertial loss levels off where its formulas do not. Each \
         is asked of the runs by a second model of the same runs, this scene's form with a trend: L + L′ ln(δ̃/δ̃_m), or \
         C (δ̃/δ̃_m)^C′, δ̃_m being the geometric mean of their film ratios. {}The gain is the log density of each run as \
         predicted from the others (PSIS-LOO), summed, with the trend less without it, and its standard error that of the \
         differences run by run. A trend is there where it gains more than 4 and more than 4 standard errors; one value \
         serves where it gains no more than 4 and its 95 % interval lies within ±0.5; otherwise the question is open, as it is \
         where chains do not agree, or where a k-hat of a trend that gains is above the line.",
        priors(questions)
    ));
    let rows: Vec<Vec<String>> = questions.iter().map(row).collect();
    let header = [
        "question",
        "wet runs",
        "film ratios",
        "gain ± se",
        "trend, mean ± sd",
        "its 95 % interval",
        "largest k-hat",
        "answer",
    ];
    page.table(&header, &rows);
    for question in questions {
        page.paragraph(&format!("{} {}.", question.question, capital(&question.text)));
    }
    residuals(page, posterior);
}

/// What was believed of each trend that was sampled.
fn priors(questions: &[Question]) -> String {
    let sampled = questions.iter().filter_map(|question| question.trend.as_ref());
    let told = sampled.map(|trend| format!("{}: {} ({}). ", trend.symbol, trend.prior, trend.source));
    let told: String = told.collect();
    if told.is_empty() {
        told
    } else {
        format!("Priors, {told}")
    }
}

fn row(question: &Question) -> Vec<String> {
    let gain = match (question.gain, question.gain_se) {
        (Some(gain), Some(se)) => numbers::with_se(gain, se),
        (gain, _) => numbers::optional(gain, 3),
    };
    let trend = question.trend.as_ref();
    let khat = question.models.iter().filter_map(|model| model.khat_max);
    vec![
        question.question.to_owned(),
        if question.runs > 0 {
            question.runs.to_string()
        } else {
            NONE.to_owned()
        },
        question.film_ratios.map_or(NONE.to_owned(), |count| count.to_string()),
        gain,
        trend.map_or(NONE.to_owned(), |trend| {
            format!("{} = {}", trend.symbol, numbers::with_se(trend.mean, trend.sd))
        }),
        trend.map_or(NONE.to_owned(), |trend| {
            numbers::between(trend.interval[0], trend.interval[1], trend.sd)
        }),
        numbers::optional(khat.reduce(f64::max), 2),
        match question.answer {
            Answer::Constant => "yes, one serves",
            Answer::Rises => "no, it rises",
            Answer::Falls => "no, it falls",
            Answer::Open => "open",
        }
        .to_owned(),
    ]
}

/// Mean residual of each particle and film ratio.
fn residuals(page: &mut Page, posterior: &Posterior) {
    let groups = posterior.findings.predictive.groups.iter();
    let rows: Vec<Vec<String>> = groups
        .filter_map(|group| {
            Some(vec![
                group.particle.clone(),
                numbers::short(group.film_ratio?),
                group.runs.to_string(),
                match group.mean_residual_se {
                    Some(se) => numbers::with_se(group.mean_residual, se),
                    None => numbers::significant(group.mean_residual, 2),
                },
            ])
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    page.paragraph(
        "What this scene's own model, without a trend, leaves at each film ratio: the mean of (e − predicted)/σ, a stuck run \
         counting as the mean of what stuck runs have, and its standard error from the spread between runs. A loss that \
         grows less with the film than the model says shows as residuals that rise with it.",
    );
    page.table(&["particle", "δ/D", "wet runs", "mean residual ± se, in σ"], &rows);
    page.figure(
        RESIDUALS,
        "mean residuals against the film ratio",
        "Mean residual of each particle and film ratio under this scene's own model, in σ, with its standard error.",
    );
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

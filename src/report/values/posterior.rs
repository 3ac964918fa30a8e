//! Gathers the model in words, the sampled parameters beside their priors, and the offsets of series.

use minijinja::{context, Value};

use super::super::draws::every_run::stores_every_run;
use super::super::draws::posterior::stores_runs;
use super::super::quantities::{parameter_label, unit_in_brackets};
use super::super::template::{serialized, with};
use super::super::{figures, ReportInput};
use crate::findings::posterior::{refusal, Posterior, SeriesOffset, CHECKED_RUNS};
use crate::findings::questions::SMALL;
use crate::findings::remarks::CLEAR_TREND;
use crate::inference::diagnostics::pareto::khat_threshold;
use crate::inference::sampling::MOST_TIMES;
use crate::model::parameters::ParameterKind;
use crate::physics::rebound::TURN;
use crate::physics::Viscous;
use crate::runs::{RunsWithErrors, GAP};

/// The crate that samples, in the version in use.
const SAMPLER: (&str, &str) = ("nuts-rs", "0.19.1");

/// Correlations beyond this are told.
const STRONG: f64 = 0.5;

pub(super) fn values(input: ReportInput) -> Value {
    let Some(posterior) = input.posterior else {
        let refusal = refusal(&input.findings.remarks);
        return context! { refused => refusal.map(|why| why.text.clone()) };
    };
    let (scene, findings) = (input.scene, input.findings);
    let sampled = sampled(input, posterior);
    let parameters = &posterior.sampled.parameters.sampled;
    let has_roughness = scene.why_no_roughness(input.runs.wet_particles()).is_none();
    let viscous = Viscous::NAMED.iter().skip(1);
    let viscous = viscous.filter(|form| has_roughness || !form.reads_roughness());
    let viscous = viscous.map(|form| context! { name => form.name(), words => form.words() });
    let own_form = findings.compare.iter().flatten().find(|model| model.own);
    let open = findings.questions.iter().flatten();
    let open = open.filter_map(|own| Some(context! { question => own.question, why => own.why_open.as_ref()? }));
    context! {
        found => serialized(&posterior.findings),
        model => model(input, posterior),
        turn => TURN,
        correlated => correlated(posterior, &sampled),
        strong => STRONG,
        sampled,
        any_dry_k => parameters.iter().any(|own| matches!(own.kind, ParameterKind::DryK(_))),
        most_paired => figures::MOST_PAIRED,
        sampler => format!("{} {}", SAMPLER.0, SAMPLER.1),
        most_times => MOST_TIMES,
        checked_runs => CHECKED_RUNS,
        offsets_shown => offsets_shown(posterior),
        true_sigma_series => scene.truth.as_ref().map(|truth| truth.sigma_series.unwrap_or(0.0)),
        viscous_forms => viscous.collect::<Vec<_>>(),
        khat_line => own_form.map(|model| khat_threshold(model.draws)),
        open_questions => open.collect::<Vec<_>>(),
        clear_trend => CLEAR_TREND,
        small => 100.0 * SMALL,
        stores_runs => stores_runs(input.runs),
        stores_every_run => stores_every_run(input.runs, posterior),
    }
}

/// What the model says besides the scene's keys.
fn model(input: ReportInput, posterior: &Posterior) -> Value {
    let form = posterior.setup.form;
    let errors = input.runs.errors_with_medians();
    let speeds = errors.iter().flat_map(|errors| {
        let of_run = input.runs.true_speeds(input.scene, errors).of_run;
        let all = of_run.into_iter().zip(errors);
        all.filter(|(_, error)| error.impact_speed_sd > 0.0)
            .map(|(speed, _)| speed)
            .collect::<Vec<_>>()
    });
    let speeds: Vec<_> = speeds.collect();
    context! {
        kept => form.formula("δ̃"),
        definitions => form.definitions("δ̃"),
        dry_at_own => form.dry.formula("v_d"),
        dry => form.dry.formula("v"),
        has_dry => !input.runs.dry.is_empty(),
        likelihood => input.scene.model.likelihood.name(),
        runs => input.runs.len(),
        errors => RunsWithErrors::of(&input.runs.errors).map(|counted| counted.runs),
        erring => speeds.len(),
        repeated => speeds.iter().filter(|speed| speed.repeats > 1).count(),
        gap => GAP,
    }
}

/// The sampled parameters, each with its prior.
fn sampled(input: ReportInput, posterior: &Posterior) -> Vec<Value> {
    let sampled = posterior.sampled.parameters.sampled.iter();
    let both = sampled.zip(&posterior.findings.parameters);
    let rows = both.filter_map(|(parameter, found)| {
        let label = parameter_label(input.scene, input.runs, parameter.kind, parameter.kind.symbol());
        let from = found.from.map_or(String::new(), |from| format!(" (from {from})"));
        let prior = found.prior.as_ref()?;
        let more = context! {
            label => label + &from,
            unit => unit_in_brackets(prior.unit),
            contradicts_runs => prior.runs_alone.is_some_and(|alone| alone.contradicts_prior()),
        };
        Some(with(found, more))
    });
    rows.collect()
}

/// Pairs of parameters that the runs do not tell well apart, the strongest first.
fn correlated(posterior: &Posterior, sampled: &[Value]) -> Vec<Value> {
    let mut pairs = vec![];
    for (i, row) in posterior.findings.correlation.iter().enumerate() {
        let strong = row.iter().enumerate().take(i).filter(|(_, value)| value.abs() > STRONG);
        pairs.extend(strong.map(|(j, value)| (*value, j, i)));
    }
    pairs.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let label = |place: usize| sampled[place].get_attr("label").ok();
    let of = |(value, j, i): &(f64, usize, usize)| context! { value, first => label(*j), second => label(*i) };
    pairs.iter().map(of).collect()
}

/// The offsets that are told one by one: all, or of many the largest.
fn offsets_shown(posterior: &Posterior) -> Vec<Value> {
    const MOST: usize = 60;
    const LARGEST: usize = 12;
    let mut shown: Vec<&SeriesOffset> = posterior.findings.series_offsets.iter().collect();
    if shown.len() > MOST {
        let size = |own: &SeriesOffset| own.offset.mean.map_or(0.0, f64::abs);
        shown.sort_by(|a, b| size(b).total_cmp(&size(a)));
        shown.truncate(LARGEST);
    }
    shown.into_iter().map(serialized).collect()
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

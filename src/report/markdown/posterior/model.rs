//! Writes how the runs are taken to come about.

use super::super::super::numbers;
use super::super::super::ReportInput;
use super::super::page::Page;
use crate::findings::posterior::Posterior;
use crate::physics::rebound::TURN;
use crate::runs::GAP;
use crate::scene::{DryKOf, LikelihoodFamily, NoiseOn, Sticking};

/// The generative statement with this scene's form of inertia and dry speed.
pub(super) fn model(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    page.subheading("Model");
    if !input.runs.series.is_empty() {
        page.paragraph(&wet(input, posterior));
    }
    let own = match input.scene.model.dry_k {
        DryKOf::Particle => "Each particle has its own k; every other parameter is one for all runs.",
        DryKOf::Diameter => "Each diameter of a particle has its own k; every other parameter is one for all runs.",
    };
    if input.runs.dry.is_empty() {
        page.paragraph(own);
    } else {
        page.paragraph(&format!(
            "A dry run has e = {} + σ_dry z, at its own speed. {own}",
            posterior.setup.form.dry.formula("v")
        ));
    }
    if let Some(words) = input.scene.model.likelihood.words() {
        page.paragraph(words);
    }
    if let Some(errors) = &input.runs.errors {
        page.paragraph(&format!(
            "{} of {} runs carry measurement errors; one that does not is taken to err like the median of the others. A \
             restitution errs by u beyond its share of the impact speed, so that a rebound has the spread √(σ² + u²); σ is \
             then what the errors do not explain. A stuck run has only the error of its speed.",
            errors.counts()[0],
            input.runs.len()
        ));
        true_speeds(page, input);
    }
}

/// How the true speeds of the runs are distributed, where the measured ones err.
fn true_speeds(page: &mut Page, input: ReportInput) {
    let Some(errors) = input.runs.errors_with_medians() else {
        return;
    };
    let erring = |run: &usize| errors.impact_speed_sd[*run] > 0.0;
    let speeds = input.runs.true_speeds(input.scene, &errors);
    let of_runs: Vec<_> = (0..input.runs.len())
        .filter(erring)
        .map(|run| speeds.of_run[run])
        .collect();
    if of_runs.is_empty() {
        return;
    }
    let repeated = of_runs.iter().filter(|speed| speed.repeats > 1).count();
    let of_whom = if input.scene.model.series_offsets {
        "Runs of one series"
    } else {
        "Runs with a liquid, whatever their diameters and films, and in the same way dry ones,"
    };
    page.paragraph(&format!(
        "The true impact speed of a run is integrated over: the rebound speed is measured about e* times the true speed, and \
         whether a run sticks depends on the true speed alone. {of_whom} are repeats of one speed where their measured speeds \
         follow one another without a gap of more than {} standard deviations of their errors. Repeats that scatter by no \
         more than errors alone do in 19 of 20 groups have one true speed: its distribution is normal, about the mean of the \
         measured ones, with the standard error of this mean. Where repeats scatter more, those of one setting are looked at by themselves in the \
         same way; else their true speeds are normal about the mean of the repeats, with what these scatter by beyond their \
         errors for a spread, and the standard error of the mean widens each. Means and spreads are estimated from the speeds \
         alone. {repeated} of {} runs have a repeat; that of a run that has none is drawn to the mean of all runs of its \
         kind, dry or wet, with what these scatter by, and as good as any other where they scatter by no more than their \
         errors.",
        numbers::short(GAP),
        of_runs.len()
    ));
}

fn wet(input: ReportInput, posterior: &Posterior) -> String {
    let limit = numbers::short(input.scene.data.smallest_restitution);
    let findings = &posterior.findings;
    let form = posterior.setup.form;
    let (cdf, law) = if input.scene.model.likelihood == LikelihoodFamily::Normal {
        ("Φ", "is standard normal and")
    } else {
        ("F", "is")
    };
    let stuck = match input.scene.model.sticking {
        Sticking::Censored => format!(
            "A stuck run therefore counts with its probability {cdf}(({limit} − m(r))/σ_wet) instead of being left out as in \
             least squares."
        ),
        Sticking::Truncated => format!(
            "Stuck runs were not logged, so the density of a rebound is divided by its probability \
             {cdf}((m(r) − {limit})/σ_wet)."
        ),
        Sticking::Excluded => "Stuck runs are left out, as the scene asks: what rebounds near the threshold is then a \
             choice of the luckier ones, which the model does not know."
            .to_owned(),
    };
    let both = input.scene.model.noise == NoiseOn::Both;
    let (kept, offsets) = if input.scene.model.series_offsets {
        (
            "r + o_s",
            " The runs of a series share o_s, an offset of the energy kept (film and alignment are set once for a series): \
             normal about 0 with the standard deviation σ_series, independent from series to series; where runs stick, too, r + o_s \
             stands in the place of r. Dry runs have none.",
        )
    } else {
        ("r", "")
    };
    let (restitution, stuck) = if both {
        let text = "Noise acts on the energy kept, too: z′ is standard normal and independent of z. What is known of a run is \
                    integrated over z′ numerically, to 1e-6 of its logarithm.";
        let restitution = format!("e* = m({kept} + σ_r z′) + σ_wet z");
        (restitution, format!("{text} {}", where_stuck(input)))
    } else {
        (format!("e* = m({kept}) + σ_wet z"), stuck)
    };
    let definitions: String = form.definitions("δ̃").iter().map(|text| format!(" {text},")).collect();
    let speed = match findings.dry_speed_m_s {
        Some(speed) => format!("v_d = {} m/s for every run", numbers::short(speed)),
        None => "v_d = v, the run's own speed".to_owned(),
    };
    format!(
        "A wet run of impact speed v, diameter D and film ratio δ̃ = δ/D has the restitution {restitution}. Here \
         z {law} independent from run to run, r = {} is the energy kept,{definitions} \
         e_dry = {} with {speed}, and m(r) = r (r² + τ⁴)^(−1/4) with τ = {}, which is √r except close to \
         r = 0. The run rebounds with e = e* where e* > {limit}; otherwise it sticks. {stuck}{offsets} Every run enters with \
         its own v, D and δ.",
        form.formula("δ̃"),
        form.dry.formula("v_d"),
        numbers::short(TURN)
    )
}

/// What becomes of stuck runs where noise acts on the energy kept, too.
fn where_stuck(input: ReportInput) -> &'static str {
    match input.scene.model.sticking {
        Sticking::Censored => "A stuck run counts with its probability.",
        Sticking::Truncated => "Stuck runs were not logged, so the density of a rebound is divided by its probability.",
        Sticking::Excluded => "Stuck runs are left out, as the scene asks.",
    }
}

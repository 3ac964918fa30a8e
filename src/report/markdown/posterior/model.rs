//! Writes what was assumed: how the runs came about, what was believed of the parameters before, what was left out.

use super::super::super::numbers;
use super::super::super::quantities::unit_in_brackets;
use super::super::super::ReportInput;
use super::super::page::Page;
use super::super::table::ReportTable;
use super::cells::parameters;
use crate::findings::posterior::{HeldParameter, Posterior};
use crate::model::parameters::ParameterKind;
use crate::physics::rebound::TURN;
use crate::runs::GAP;
use crate::scene::{DryKOf, LikelihoodFamily, NoiseOn, Prior, Sticking};

/// The generative statement with this scene's form of inertia and dry speed.
pub(super) fn model(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    page.subsection("Model", "How a run is taken to come about.");
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

/// What was believed before, and which parameters were not sampled.
pub(super) fn priors(page: &mut Page, input: ReportInput, posterior: &Posterior) {
    page.subsection("Priors", "The priors and their rationale.");
    let parameters = parameters(input, posterior);
    let table = ReportTable::of(&parameters)
        .column("parameter", |one| &one.label)
        .column("name in files", |one| format!("`{}`", one.found.name))
        .column("unit", |one| unit_in_brackets(one.prior.unit))
        .column("bounds", |one| match one.prior.upper {
            Some(upper) => format!("{} to {}", bound(one.prior.lower), bound(upper)),
            None => format!("above {}", bound(one.prior.lower)),
        })
        .column("prior", |one| &one.prior.density)
        .column("why", |one| one.prior.source);
    page.table(&table);
    let sampled = &posterior.sampled.parameters.sampled;
    let of_k = if sampled
        .iter()
        .any(|parameter| matches!(parameter.kind, ParameterKind::DryK(_)))
    {
        "; that of k keeps e_dry above zero at every speed in use, since e_dry² would grow again beyond"
    } else {
        ""
    };
    page.paragraph(&format!(
        "Written as a scene writes them: {}. Each ends at its bounds{of_k}.",
        families(posterior)
    ));
    left_out(page, &posterior.findings.left_out);
}

fn bound(x: f64) -> String {
    if x == 0.0 || x.abs() >= 0.01 {
        numbers::short(x)
    } else {
        numbers::significant(x, 3)
    }
}

/// The families in use, each with the meaning of its numbers.
fn families(posterior: &Posterior) -> String {
    let mut used: Vec<&str> = vec![];
    for parameter in &posterior.sampled.parameters.sampled {
        let words = match parameter.prior {
            Prior::LogNormal(..) => "lognormal [median, sd of the logarithm]",
            Prior::HalfNormal(_) => "half_normal scale",
            Prior::Normal(..) => "normal [mean, sd]",
            Prior::Gamma(..) => "gamma [shape, rate]",
            Prior::Uniform(..) => "uniform [lower, upper]",
            Prior::StudentT(..) => "student_t [degrees of freedom, location, scale]",
            // held, not sampled
            Prior::Fixed(_) => continue,
        };
        if !used.contains(&words) {
            used.push(words);
        }
    }
    used.join(", ")
}

fn left_out(page: &mut Page, left_out: &[HeldParameter]) {
    if left_out.is_empty() {
        page.paragraph("No parameter of this model was left out.");
        return;
    }
    page.paragraph("Not sampled:");
    let table = ReportTable::of(left_out)
        .column("parameter", |left| format!("`{}`", left.name))
        .column("held at", |left| {
            left.value
                .map_or("not read".to_owned(), |value| numbers::significant(value, 4))
        })
        .column("why", |left| &left.reason);
    page.table(&table);
    if let Some(text) = held(left_out) {
        page.paragraph(&text);
    }
}

/// What the posterior takes as known; nothing where all that it reads was sampled.
pub(in super::super) fn held(left_out: &[HeldParameter]) -> Option<String> {
    let held: Vec<String> = left_out
        .iter()
        .filter_map(|left| Some(format!("{} at {}", left.name, numbers::significant(left.value?, 3))))
        .collect();
    (!held.is_empty()).then(|| {
        format!(
            "The posterior holds {}: what is not known of that is not in its ±.",
            held.join(" and ")
        )
    })
}

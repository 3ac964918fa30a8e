//! Gathers the rows of the fits by least squares, as far as they are told, with their words.

use minijinja::value::merge_maps;
use minijinja::{context, Value};

use super::super::template::{serialized, with};
use super::super::{quantities, ReportInput};
use crate::findings::balance::{EnergyBalance, ParameterEstimate};
use crate::findings::bootstrap::MOST_RESAMPLED;
use crate::findings::constants::Sensitivity;
use crate::findings::dry::{Dry, DryOfDiameter};
use crate::findings::noise::{GrowthTest, Noise, FALSE_ALARM};
use crate::findings::remarks::SERIES_SCHEME_CHANGES;
use crate::findings::scaling::{Energy, Scaling};
use crate::findings::Findings;
use crate::inference::effective_variance::ErrorSummary;
use crate::physics::Quantity;
use crate::rounding;
use crate::scene::WetLaw;

pub(super) fn values(input: ReportInput) -> Value {
    let (scene, findings) = (input.scene, input.findings);
    let of_one_film = || findings.series.iter().filter(|own| !own.is_withheld);
    let failed: Vec<_> = of_one_film().filter(|own| !own.verdict.passed).collect();
    let scaling = findings.scaling.iter().filter(|law| is_told(findings, law));
    let drawn = |row: &Scaling| row.law == WetLaw::Linear && row.film_ratio.is_some() && row.verdict.passed;
    let of_form = scene.model.viscous.why_no_critical_separation();
    let of_roughness = || {
        let why = scene.why_no_roughness(input.runs.wet_particles())?;
        Some(format!("{why}, and so no δc"))
    };
    let mut wet = input.runs.wet_particles();
    let has_roughness = wet.any(|particle| scene.particles[particle].roughness.is_some());
    let laws = context! {
        dry => findings.dry.iter().map(dry_row).collect::<Vec<_>>(),
        series => context! {
            all => of_one_film().count(),
            with_law => of_one_film().count() - failed.len(),
            failed => serialized(&failed),
        },
        scaling => scaling.map(scaling_row).collect::<Vec<_>>(),
        linear_drawn => findings.scaling.iter().any(drawn),
        has_delta_c => of_form.is_none() && has_roughness,
        why_no_delta_c => of_form.map(str::to_owned).or_else(of_roughness),
        label_k => quantities::label(Quantity::DryK),
        label_inertial_loss => quantities::label(Quantity::InertialLoss),
        label_st_c_e_inf2 => quantities::label(Quantity::StCEInf2),
        cross_check => findings.energy_balance.as_ref().map(|balance| cross_check(input, balance)),
        most_resampled => MOST_RESAMPLED,
        series_scheme_changes => SERIES_SCHEME_CHANGES,
        with_errors => with_errors(findings),
        constants => constants(&findings.constants),
    };
    merge_maps([laws, findings.noise.as_ref().map_or(context! {}, noise)])
}

fn dry_row(own: &Dry) -> Value {
    let of_diameter = |one: &DryOfDiameter| with(one, context! { dry_k => serialized(&one.dry_k) });
    let more = context! {
        words => own.words(),
        dry_k => serialized(&own.dry_k),
        by_diameter => own.by_diameter.iter().map(of_diameter).collect::<Vec<_>>(),
    };
    with(own, more)
}

fn scaling_row(own: &Scaling) -> Value {
    let energy = |own: &Energy| {
        let more = context! {
            loss_over_density_ratio => serialized(&own.loss_over_density_ratio),
            st_c_e_inf2 => serialized(&own.st_c_e_inf2),
            delta_c_m => serialized(&own.delta_c_m),
        };
        with(own, more)
    };
    let more = context! {
        words => own.words(),
        e_inf => serialized(&own.e_inf),
        st_c => serialized(&own.st_c),
        energy => own.energy.as_ref().map(energy),
    };
    with(own, more)
}

/// Whether a law of some runs tells what stands nowhere else: not where these have no film ratio of their own, and the linear
/// law only where the square root does not stand and is not what biases it.
fn is_told(findings: &Findings, law: &Scaling) -> bool {
    let is_root = |own: &&Scaling| {
        own.law == WetLaw::Sqrt
            && own.particle == law.particle
            && (own.diameter_m, own.film_ratio) == (law.diameter_m, law.film_ratio)
    };
    match law.law {
        WetLaw::Sqrt => !law.is_withheld,
        WetLaw::Linear => {
            let stands = findings
                .scaling
                .iter()
                .find(is_root)
                .is_some_and(|root| root.verdict.passed);
            !stands && law.e_inf.value.is_some() && (law.verdict.passed || law.bias.is_none())
        }
    }
}

/// The fits of runs that carry errors.
fn with_errors(findings: &Findings) -> Vec<Value> {
    let row = |particle: String, law: &str, film_ratio: Option<String>, runs: usize, errors: Option<ErrorSummary>| {
        Some(context! { particle, law, film_ratio, runs, errors => serialized(errors?) })
    };
    let dry = findings.dry.iter();
    let dry = dry.filter_map(|own| row(own.words(), "dry", None, own.runs, own.measurement_errors));
    let scaling = findings.scaling.iter().filter_map(|own| {
        let ratio = rounding::short(own.film_ratio?);
        row(
            own.words(),
            law_name(own.law),
            Some(ratio),
            own.runs,
            own.measurement_errors,
        )
    });
    let balance = findings.energy_balance.iter().filter_map(|own| {
        let (all, particles) = (Some("all".to_owned()), own.particles.join(", "));
        row(particles, "energy balance", all, own.runs, own.measurement_errors)
    });
    dry.chain(scaling).chain(balance).collect()
}

pub(super) fn law_name(law: WetLaw) -> &'static str {
    match law {
        WetLaw::Sqrt => "square root",
        WetLaw::Linear => law.name(),
    }
}

/// Least squares over all rebounds beside the posterior.
fn cross_check(input: ReportInput, balance: &EnergyBalance) -> Value {
    /// posterior sds by which least squares may lie off without a word
    const FAR: f64 = 1.0;
    let main = &input.findings.main;
    let sampled = |row: &ParameterEstimate| {
        let mut all = main.parameters.iter().filter(|_| !main.provisional);
        all.find(|own| own.name() == row.name)
    };
    let difference = |row: &ParameterEstimate| {
        let number = &sampled(row)?.number;
        let sd = number.se.filter(|sd| *sd > 0.0)?;
        Some((row.estimate.value? - number.value?) / sd)
    };
    let label =
        |row: &ParameterEstimate, symbol: &str| quantities::parameter_label(input.scene, input.runs, row.kind, symbol);
    let rows = balance.parameters.iter().map(|row| {
        let quantity = row.kind.quantity().unwrap_or(Quantity::DryK);
        context! {
            label => label(row, &quantities::label(quantity)),
            estimate => serialized(&row.estimate),
            factor => quantities::factor(quantity),
            difference => difference(row),
        }
    });
    let far = balance.parameters.iter();
    let far = far.filter(|row| difference(row).is_some_and(|difference| difference.abs() > FAR));
    context! {
        rows => rows.collect::<Vec<_>>(),
        far => far.map(|row| label(row, row.kind.symbol())).collect::<Vec<_>>(),
    }
}

/// What the scatter of the runs is like, as far as `findings.json` does not have it.
fn noise(noise: &Noise) -> Value {
    let spread = noise.spread.as_ref();
    let growth = noise.growth.as_ref();
    context! {
        spread_labels => spread.map(|own| [own.narrowest.label(), own.widest.label()].to_vec()),
        false_alarm => 100.0 * FALSE_ALARM,
        growth => growth.and_then(|own| own.of_wet_runs()).map(grown),
        strongest_growth => growth.and_then(|own| own.strongest()).map(grown),
    }
}

/// A growth of the noise with the words of what it goes with.
fn grown(growth: &GrowthTest) -> Value {
    with(growth, context! { words => growth.with.words(), ends => growth.ends() })
}

/// How results move with the constants, in columns of constants in the order of the scene; `None` where nothing is told.
fn constants(rows: &[Sensitivity]) -> Option<Value> {
    if rows.is_empty() {
        return None;
    }
    let order = |constant: &str| {
        let kinds = ["viscosity", "liquid_density", "particle_density", "roughness", "film"];
        let kind = constant.split('[').next();
        kinds.iter().position(|name| kind == Some(*name)).unwrap_or(kinds.len())
    };
    let mut names: Vec<&str> = vec![];
    let mut known: Vec<Value> = vec![];
    for moves in rows.iter().flat_map(|row| &row.by) {
        if names.contains(&moves.constant.as_str()) {
            continue;
        }
        names.push(&moves.constant);
        known.extend(moves.rel_sd.map(|_| serialized(moves)));
    }
    // stable: those of one kind keep the order they were met in
    names.sort_by_key(|name| order(name));
    let row = |row: &Sensitivity| {
        let elasticity = |name: &&str| Some(row.by.iter().find(|moves| moves.constant == *name)?.elasticity);
        let is_length = row.result == Quantity::DeltaC.describe().name;
        let more = context! {
            label => row.label(),
            elasticities => names.iter().map(elasticity).collect::<Vec<_>>(),
            factor => if is_length { quantities::factor(Quantity::DeltaC) } else { 1.0 },
        };
        with(row, more)
    };
    let rows: Vec<Value> = rows.iter().map(row).collect();
    Some(context! { names => serialized(names), rows, known })
}

//! Gathers the rows of the fits by least squares, as far as they are told, with their words.

use minijinja::value::merge_maps;
use minijinja::{context, Value};

use super::super::template::{serialized, with};
use super::super::{quantities, ReportInput};
use crate::findings::balance::{EnergyBalance, ParameterEstimate};
use crate::findings::bootstrap::MOST_RESAMPLED;
use crate::findings::constants::{Elasticity, Sensitivity};
use crate::findings::dry::{Dry, DryOfDiameter};
use crate::findings::noise::{GrowthTest, Noise, FALSE_ALARM};
use crate::findings::remarks::SERIES_SCHEME_CHANGES;
use crate::findings::scaling::Scaling;
use crate::physics::Quantity;

pub(super) fn values(input: ReportInput) -> Value {
    let (scene, findings) = (input.scene, input.findings);
    let of_one_film = || findings.series.iter().filter(|own| !own.is_withheld);
    let failed: Vec<_> = of_one_film().filter(|own| !own.verdict.passed).collect();
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
        scaling => scaling_rows(&findings.scaling),
        has_delta_c => of_form.is_none() && has_roughness,
        why_no_delta_c => of_form.map(str::to_owned).or_else(of_roughness),
        label_k => quantities::label(Quantity::DryK),
        label_inertial_loss => quantities::label(Quantity::InertialLoss),
        label_st_c_e_inf2 => quantities::label(Quantity::StCEInf2),
        cross_check => findings.energy_balance.as_ref().map(|balance| cross_check(input, balance)),
        most_resampled => MOST_RESAMPLED,
        series_scheme_changes => SERIES_SCHEME_CHANGES,
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

/// The laws over 1/St. A law of some runs is told where it says what stands nowhere else: not where these have no film ratio of
/// their own, and the linear law only where the square root does not stand and is not what biases it.
fn scaling_rows(laws: &[Scaling]) -> Vec<Value> {
    let row = |own: &Scaling, is_told: bool| {
        let estimates = own.estimates.iter();
        let estimates = estimates.map(|(quantity, own)| (quantity.describe().name, serialized(own)));
        let more = context! { words => own.words(), is_told };
        merge_maps([with(own, more), Value::from_pairs(estimates)])
    };
    let of_runs = |[root, line]: &[Scaling; 2]| {
        let has_line = line.estimates[Quantity::EInf].value.is_some() && (line.verdict.passed || line.bias.is_none());
        [
            row(root, !root.is_withheld),
            row(line, !root.verdict.passed && has_line),
        ]
    };
    // two of the same runs
    laws.as_chunks::<2>().0.iter().flat_map(of_runs).collect()
}

/// Least squares over all rebounds beside the posterior.
fn cross_check(input: ReportInput, balance: &EnergyBalance) -> Vec<Value> {
    let main = &input.findings.main;
    let difference = |row: &ParameterEstimate| {
        let mut sampled = main.parameters.iter().filter(|_| !main.provisional);
        let number = &sampled.find(|own| own.name() == row.name)?.number;
        let sd = number.se.filter(|sd| *sd > 0.0)?;
        Some((row.estimate.value? - number.value?) / sd)
    };
    let row = |row: &ParameterEstimate| {
        let quantity = row.kind.quantity().unwrap_or(Quantity::DryK);
        let label = |symbol: &str| quantities::parameter_label(input.scene, input.runs, row.kind, symbol);
        context! {
            label => label(&quantities::label(quantity)),
            words => label(row.kind.symbol()),
            estimate => serialized(&row.estimate),
            factor => quantities::factor(quantity),
            difference => difference(row),
        }
    };
    balance.parameters.iter().map(row).collect()
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
    let mut moves: Vec<&Elasticity> = vec![];
    for own in rows.iter().flat_map(|row| &row.by) {
        if moves.iter().all(|other| other.constant != own.constant) {
            moves.push(own);
        }
    }
    let known = serialized(&moves);
    // stable: those of one kind keep the order they were met in
    moves.sort_by_key(|own| order(&own.constant));
    let names: Vec<&str> = moves.iter().map(|own| own.constant.as_str()).collect();
    let rows = rows.iter().map(|row| with(row, context! { label => row.label() }));
    let rows: Vec<Value> = rows.collect();
    Some(context! { names => serialized(names), rows, known })
}

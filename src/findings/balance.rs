//! Estimates L, the inertial prefactor and the film scale from every rebound at once.

use std::ops::Range;

use serde::Serialize;

use super::dry::FittedDry;
use super::energy::density_ratio;
use super::erring::{Columns, Weighed};
use super::estimate::{Estimate, Quoting, Scale};
use super::judge::{one_against, spread, uncertain, why_stopped, Verdict};
use super::own_dry_speed::reference_dry_speed;
use super::pooling::tell_bias;
use super::scaling::FittedScaling;
use crate::inference::balance::{fit_balance, Balance, Block};
use crate::inference::delta::Uncertain;
use crate::inference::effective_variance::{chi_squared, weigh, Weighing};
use crate::inference::least_squares::{Fit, Stop};
use crate::inference::nested::{FTest, Spread};
use crate::physics::impact::Form;
use crate::physics::inertia::Inertia;
use crate::physics::{numbers, viscous};
use crate::runs::{FilmGroup, Runs, Series};
use crate::scene::{Law, Scene};

/// The energy balance over particles, liquids, diameters, films and speeds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EnergyBalance {
    /// form of the inertial loss
    pub inertia: &'static str,
    /// particles with a usable k; the others are left out
    pub particles: Vec<String>,
    /// rebounds used
    pub runs: usize,
    /// lubrication_log, inertial_prefactor and film_scale where the form has them, and k with what the wet runs say of it
    pub parameters: Vec<Parameter>,
    /// δc/ε = exp(L)
    pub delta_c_over_roughness: Estimate,
    /// e_inf and St_c that follow from the parameters, for each particle and film ratio
    pub derived: Vec<Derived>,
    /// largest distance of a k here from that of the dry runs alone, in combined standard errors
    pub dry_k_shift_in_se: Option<f64>,
    /// spread of the restitutions about the law
    pub residual_sd: Option<f64>,
    /// how measurement errors entered; `None` where no run carries one
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measurement_errors: Option<Weighed>,
    /// this law for all against a square-root law for each particle and film ratio
    pub lack_of_fit: Option<FTest>,
    /// how the fit ended
    pub stop: &'static str,
    /// whether it may be quoted
    pub verdict: Verdict,
    /// what a refit starts from
    #[serde(skip)]
    pub(super) held: Held,
}

/// What a refit of the energy balance keeps of the fit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Held {
    pub(super) form: Form,
    /// the spread that weighs the dry runs' k
    pub(super) spread: f64,
    pub(super) parameters: Vec<f64>,
}

/// A parameter of the energy balance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    /// its name
    pub name: String,
    /// its value
    pub estimate: Estimate,
}

/// e_inf and St_c of one particle at one film ratio, as they follow from the energy balance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Derived {
    /// name of the particle
    pub particle: String,
    /// film ratio
    pub film_ratio: f64,
    /// ρ̃, mean over the rebounds
    pub density_ratio: f64,
    /// √(e_dry² − C ρ̃ g), at the reference dry speed
    pub e_inf: Estimate,
    /// 2 L/e_inf²
    pub st_c: Estimate,
    /// their correlation
    pub correlation: Option<f64>,
}

/// Why there is no St_c and no δc.
const NO_VISCOUS: &str = "the viscous loss is left out of the model";

/// Probability of the lack-of-fit test below which the balance does not describe the runs.
pub const MISFIT: f64 = 0.001;

/// Fits the balance of this form, with the form of inertia `open` or not, and measures with it what pooling liquids does to the square-root law of each film ratio.
///
/// `None` without wet runs of a particle whose k is known; the biases then stay unknown, too.
pub fn find(
    scene: &Scene,
    runs: &Runs,
    fitted_dry: &[FittedDry],
    scaling: &mut [FittedScaling],
    (form, open): (Form, bool),
    quoting: Quoting,
) -> Option<EnergyBalance> {
    let known = known(runs, fitted_dry);
    let place = |particle: usize| place_of(&known, particle);
    let blocks = blocks(scene, runs, place);
    if blocks.is_empty() {
        return None;
    }
    let separate: Vec<(Spread, Option<Weighing>)> = scaling
        .iter()
        .filter(|fitted| fitted.law == Law::Sqrt && fitted.scaling.film_ratio.is_some())
        .filter(|fitted| fitted.scaling.runs > 0 && place(fitted.particle).is_some())
        .map(|fitted| (fitted.spread, fitted.weighing.clone()))
        .collect();
    let dry_k: Vec<(f64, f64)> = known.iter().map(|(_, k)| *k).collect();
    let of_form = |inertia: Inertia| {
        fit_weighed(Balance {
            blocks: &blocks,
            form: Form { inertia, ..form },
            dry_k: &dry_k,
            spread: pooled_sd(&separate),
        })
    };
    let (balance, fit) = if open { closest(of_form) } else { of_form(form.inertia) };
    let (balance, (fit, weighing)) = match errors(runs, place) {
        Some(errors) => {
            let in_errors = in_standard_errors(balance.clone(), 1.0);
            let (fit, weighing) = weigh(&errors.erring(), fit, |_| in_errors.clone());
            let balance = if weighing.is_some() { in_errors } else { balance };
            (balance, (fit, weighing))
        }
        None => (balance, (fit, None)),
    };
    let uncertain = uncertain(&fit);
    let converged = fit.stop == Stop::Converged;
    let estimate = |j: usize, value: f64, slope: f64, how: Scale| {
        if !converged {
            return quoting.none(why_stopped(&fit));
        }
        let mut gradient = vec![0.0; fit.parameters.len()];
        gradient[j] = slope;
        quoting.of(&uncertain, value, &gradient, how)
    };
    let wet = balance.names();
    if converged {
        tell_bias(scene, runs, fitted_dry, scaling, &balance, &fit.parameters, &known);
    }
    let names = wet.iter().map(|name| (*name).to_owned());
    let dry_names = known
        .iter()
        .map(|(p, _)| format!("dry_k[{}]", scene.particles[*p].name));
    let parameters: Vec<Parameter> = names
        .chain(dry_names)
        .zip(&fit.parameters)
        .enumerate()
        .map(|(j, (name, value))| Parameter {
            name,
            estimate: estimate(j, *value, 1.0, Scale::Plain),
        })
        .collect();
    let l = balance.unpack(&fit.parameters).0;
    let viscous = balance.form.viscous;
    let derived = if converged {
        runs.film_groups
            .iter()
            .filter_map(|group| {
                let at = place(group.particle)?;
                derive((scene, runs, group), &balance, at, &fit.parameters, &uncertain, quoting)
            })
            .collect()
    } else {
        vec![]
    };
    let one = Spread {
        parameters: wet.len(),
        ..spread(&fit)
    };
    // the residuals that hold k cancel the parameters they belong to
    let one = Spread {
        runs: one.runs - known.len(),
        ..one
    };
    let each = separate.iter().map(|(spread, weighing)| (*spread, weighing.as_ref()));
    let lack_of_fit = one_against(one, each, |mut variance| {
        variance.resize(fit.degrees_of_freedom + fit.parameters.len(), 1.0);
        chi_squared(&balance, &variance, &fit.parameters)
    });
    let lack_of_fit = lack_of_fit.filter(|_| converged);
    let shifts = parameters[wet.len()..]
        .iter()
        .zip(&dry_k)
        .filter_map(|(joint, (k, se))| {
            let (value, joint_se) = joint.estimate.pair()?;
            Some((value - k).abs() / se.hypot(joint_se))
        });
    Some(EnergyBalance {
        inertia: balance.form.inertia.name(),
        particles: known.iter().map(|(p, _)| scene.particles[*p].name.clone()).collect(),
        runs: one.runs,
        delta_c_over_roughness: if viscous {
            estimate(0, l.exp(), l.exp(), Scale::Log)
        } else {
            quoting.none(NO_VISCOUS)
        },
        verdict: judge(&fit, Some(l).filter(|_| viscous), lack_of_fit.as_ref()),
        dry_k_shift_in_se: shifts.reduce(f64::max),
        parameters,
        derived,
        residual_sd: fit.residual_sd,
        measurement_errors: weighing.as_ref().map(Weighed::of),
        lack_of_fit,
        stop: fit.stop.as_str(),
        held: Held {
            form: balance.form,
            spread: balance.spread,
            parameters: fit.parameters,
        },
    })
}

/// The particles with rebounds and a usable k, with that k.
pub(super) fn known(runs: &Runs, fitted_dry: &[FittedDry]) -> Vec<(usize, (f64, f64))> {
    let has_rebounds = |p: usize| runs.series_of(p).iter().any(|series| !series.rebounds.is_empty());
    fitted_dry
        .iter()
        .filter(|d| has_rebounds(d.particle))
        .filter_map(|d| Some((d.particle, d.usable?)))
        .collect()
}

/// Place of a particle among those of [`known`].
pub(super) fn place_of(known: &[(usize, (f64, f64))], particle: usize) -> Option<usize> {
    known.binary_search_by_key(&particle, |(p, _)| *p).ok()
}

/// The rebounds of the particles that have a place, block by block.
pub(super) fn blocks<'r>(scene: &Scene, runs: &'r Runs, place: impl Fn(usize) -> Option<usize>) -> Vec<Block<'r>> {
    let rebounding = runs.series.iter().filter(|series| !series.rebounds.is_empty());
    rebounding
        .filter_map(|series| block(scene, runs, series, &place))
        .collect()
}

/// What the rebounds of [`blocks`] err by; `None` where no run of the table does.
pub(super) fn errors(runs: &Runs, place: impl Fn(usize) -> Option<usize>) -> Option<Columns> {
    let placed = runs.series.iter().filter(|series| place(series.particle).is_some());
    Columns::of(runs, placed.map(|series| series.rebounds.clone()), None)
}

/// The balance with the dry runs' k in their standard errors, as runs weighed by their own errors want them; `share` of
/// the rebounds are among these runs, which are held by as much less.
pub(super) fn in_standard_errors(balance: Balance, share: f64) -> Balance {
    Balance {
        spread: share.sqrt(),
        ..balance
    }
}

/// The rebounds of one series; `None` where its particle has no place.
pub(super) fn block<'r>(
    scene: &Scene,
    runs: &'r Runs,
    series: &Series,
    place: impl Fn(usize) -> Option<usize>,
) -> Option<Block<'r>> {
    let place = place(series.particle)?;
    Some(block_of(scene, runs, series, series.rebounds.clone(), place))
}

/// A range of the runs of one series, whose particle has this place.
pub(super) fn block_of<'r>(
    scene: &Scene,
    runs: &'r Runs,
    series: &Series,
    range: Range<usize>,
    place: usize,
) -> Block<'r> {
    let particle = &scene.particles[series.particle];
    let liquid = &scene.liquids[series.liquid];
    Block {
        particle: place,
        density_ratio: liquid.density / particle.density,
        stokes_factor: numbers::stokes(particle.density, 1.0, 1.0, liquid.viscosity),
        tension_over_density: liquid.surface_tension.unwrap_or(0.0) / particle.density,
        diameter: &runs.diameter[range.clone()],
        film: &runs.film[range.clone()],
        impact_speed: &runs.impact_speed[range.clone()],
        restitution: &runs.restitution[range],
    }
}

/// e_inf² of a density ratio and a film ratio.
pub(super) fn e_inf2(
    scene: &Scene,
    balance: &Balance,
    place: usize,
    parameters: &[f64],
    (density, film): (f64, f64),
) -> f64 {
    let (_, c, scale, dry_k) = balance.unpack(parameters);
    let e_dry = balance.form.dry.restitution(dry_k[place], reference_dry_speed(scene));
    e_dry * e_dry - c * density * balance.form.inertia.shape(film, scale)
}

/// Fits the balance, and again with its own spread where that is far below the one that weighed the dry runs' k: the
/// separate laws pool liquids, and where noise is small their misfit would hold k too fast and its error too small.
fn fit_weighed(mut balance: Balance) -> (Balance, Fit) {
    /// a weight this near moves no standard error that matters
    const NEAR: f64 = 0.5;
    /// each time the spread is nearer by orders of magnitude
    const TRIES: usize = 8;
    let mut fit = fit_balance(&balance);
    for _ in 0..TRIES {
        let own = fit.residual_sd.filter(|_| fit.stop == Stop::Converged);
        match own.filter(|own| *own > 0.0 && *own < NEAR * balance.spread) {
            Some(own) => balance.spread = own,
            None => break,
        }
        fit = fit_balance(&balance);
    }
    (balance, fit)
}

/// With the form left open: the one that leaves the smallest spread, the default one if none converges.
fn closest<'b>(of_form: impl Fn(Inertia) -> (Balance<'b>, Fit)) -> (Balance<'b>, Fit) {
    let fits = Inertia::ALL.map(&of_form);
    let spread = |fit: &Fit| {
        let converged = fit.residual_sd.filter(|_| fit.stop == Stop::Converged);
        converged.unwrap_or(f64::INFINITY)
    };
    let best = fits
        .into_iter()
        .reduce(|a, b| if spread(&b.1) < spread(&a.1) { b } else { a });
    best.unwrap_or_else(|| of_form(Inertia::Stepwise))
}

/// e_inf and St_c of a film ratio; `None` where none of its runs rebounded or nothing is left for e_inf.
fn derive(
    setting: (&Scene, &Runs, &FilmGroup),
    balance: &Balance,
    place: usize,
    parameters: &[f64],
    uncertain: &Uncertain,
    quoting: Quoting,
) -> Option<Derived> {
    let (scene, runs, group) = setting;
    let series = &runs.series[group.series.clone()];
    if series.iter().all(|s| s.rebounds.is_empty()) {
        return None;
    }
    let density_ratio = density_ratio(scene, group.particle, series);
    let (l, c, scale, dry_k) = balance.unpack(parameters);
    let v = reference_dry_speed(scene);
    let law = balance.form.dry;
    let e_dry = law.restitution(dry_k[place], v);
    let (form, ratio) = (balance.form.inertia, group.film_ratio);
    let e_inf2 = e_inf2(scene, balance, place, parameters, (density_ratio, ratio));
    if e_inf2 <= 0.0 {
        return None;
    }
    let e_inf = e_inf2.sqrt();
    // slopes of e_inf² in the parameters, in their order
    let wet = [
        0.0,
        -density_ratio * form.shape(ratio, scale),
        -c * density_ratio * form.slope_film_scale(ratio, scale),
    ];
    let mut slopes = vec![0.0; parameters.len()];
    let names = balance.names().len();
    let viscous = balance.form.viscous;
    let first = usize::from(!viscous);
    slopes[..names].copy_from_slice(&wet[first..first + names]);
    slopes[names + place] = 2.0 * e_dry * law.slope_dry_k(dry_k[place], v);
    let e_inf_slopes: Vec<f64> = slopes.iter().map(|slope| 0.5 * slope / e_inf).collect();
    let st_c = viscous::st_c(l, e_inf);
    let mut st_c_slopes: Vec<f64> = slopes.iter().map(|slope| -st_c * slope / e_inf2).collect();
    if viscous {
        st_c_slopes[0] += 2.0 / e_inf2;
    }
    Some(Derived {
        particle: scene.particles[group.particle].name.clone(),
        film_ratio: ratio,
        density_ratio,
        correlation: uncertain.correlation(&e_inf_slopes, &st_c_slopes).filter(|_| viscous),
        e_inf: quoting.of(uncertain, e_inf, &e_inf_slopes, Scale::Plain),
        st_c: if viscous {
            quoting.of(uncertain, st_c, &st_c_slopes, Scale::Plain)
        } else {
            quoting.none(NO_VISCOUS)
        },
    })
}

/// Spread of the restitutions about the separate laws that could be fitted; 1 where they leave none, which holds k at
/// its dry fit.
fn pooled_sd(separate: &[(Spread, Option<Weighing>)]) -> f64 {
    let separate = || {
        separate
            .iter()
            .map(|(spread, _)| spread)
            .filter(|group| group.sum_of_squares.is_finite())
    };
    let squares: f64 = separate().map(|group| group.sum_of_squares).sum();
    let freedom: usize = separate()
        .map(|group| group.runs.saturating_sub(group.parameters))
        .sum();
    if squares > 0.0 && freedom > 0 {
        (squares / freedom as f64).sqrt()
    } else {
        1.0
    }
}

fn judge(fit: &Fit, l: Option<f64>, misfit: Option<&FTest>) -> Verdict {
    if fit.stop != Stop::Converged || fit.covariance.is_none() {
        Verdict::failed(why_stopped(fit))
    } else if l.is_some_and(|l| l <= 0.0) {
        Verdict::failed("L is not positive: the restitution does not fall with 1/St")
    } else if let Some(test) = misfit.filter(|test| test.p < MISFIT) {
        Verdict::failed(format!(
            "the film ratios do not follow this form of the inertial loss (lack of fit, F({}, {}) = {:.3})",
            test.df_between, test.df_within, test.f
        ))
    } else {
        Verdict::passed("converged")
    }
}

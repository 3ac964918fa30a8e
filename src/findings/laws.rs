//! Gives the law e(v) of every pair of the runs in the few numbers that a simulation code can take.
//!
//! A pair is a sphere in a liquid under a film, or on the dry plate. With a posterior its numbers are means over the draws,
//! of a new series where series have offsets; without one they are those of the square-root law of the series, and k of the
//! dry law.

use rayon::prelude::*;
use serde::Serialize;

use super::document::Findings;
use super::main_numbers::Source;
use super::posterior::Posterior;
use super::predict::ParticleLaw;
use super::quantities::{variables, PARAMETERS};
use super::range::range;
use super::series::SeriesFit;
use super::verdicts::quotable;
use crate::inference::diagnostics::quantile;
use crate::physics::jet::{Jet, Number};
use crate::physics::numbers::stokes;
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::{DrySpeed, LawNumbers, Plateau, Restitution};
use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// Draws that means and covariances are taken over.
const DRAWS: usize = 4000;

/// Speeds of a table, from the slowest to the fastest run.
const SPEEDS: usize = 25;

/// How e depends on the speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LawKind {
    /// e² = α + β/v − κ/v², e_dry being taken at a reference speed
    Reference,
    /// e² = e_dry(v)² − loss + β/v − κ/v²
    Impact,
    /// e = e_dry(v)
    Dry,
}

impl LawKind {
    /// Its word in files.
    pub fn name(self) -> &'static str {
        match self {
            LawKind::Reference => "reference",
            LawKind::Impact => "impact",
            LawKind::Dry => "dry",
        }
    }
}

/// The law of one pair. Field names are those of `findings.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PairLaw {
    /// name of the particle
    pub particle: String,
    /// name of the liquid; `None`: the dry plate
    pub liquid: Option<String>,
    /// mean D, m; `None` where the dry law is that of all diameters
    pub diameter_m: Option<f64>,
    /// mean δ, m
    pub film_m: Option<f64>,
    /// δ/D of its film group
    pub film_ratio: Option<f64>,
    /// how e depends on the speed
    pub law: LawKind,
    /// the same as a formula
    pub formula: String,
    /// k of e_dry = 1 − k v^(1/5), where e_dry is taken at the impact speed
    pub dry_k: Option<f64>,
    /// its standard error
    pub dry_k_se: Option<f64>,
    /// order of the dry law
    pub dry_order: Option<u8>,
    /// what the liquid's inertia takes, where e_dry is taken at the impact speed
    pub inertial_loss: Option<f64>,
    /// α, at the reference dry speed
    pub alpha: Option<f64>,
    /// β, m/s
    pub beta: Option<f64>,
    /// κ, m²/s²
    pub kappa: Option<f64>,
    /// speed below which nothing rebounds, m/s
    pub threshold_speed_m_s: Option<f64>,
    /// √α
    pub e_inf: Option<f64>,
    /// 2 L/e_inf²
    pub st_c: Option<f64>,
    /// St over v, s/m
    pub stokes_per_m_s: Option<f64>,
    /// covariances; `None` where there are none
    pub covariance: Option<LawCovariance>,
    /// slowest and fastest of its runs, m/s
    pub speeds: Option<[f64; 2]>,
    /// their Stokes numbers
    pub stokes: Option<[f64; 2]>,
    /// where the numbers come from
    pub source: Source,
    /// whether they may be quoted
    pub quotable: bool,
    /// why there are none; stands exactly then
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_none: Option<String>,
    /// e at some speeds, where it is not √(α + β/v)
    #[serde(skip)]
    pub table: Vec<LawPoint>,
}

/// Covariances of the numbers of a law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LawCovariance {
    /// of α and β
    pub alpha_beta: [[f64; 2]; 2],
    /// of e_inf and St_c; `None` where a draw leaves none
    pub e_inf_st_c: Option<[[f64; 2]; 2]>,
}

/// A law at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LawPoint {
    /// v, m/s
    pub impact_speed: f64,
    /// e; 0: no rebound
    pub restitution: f64,
    /// 5 % and 95 % points, from the parameters' uncertainty; `None` without draws
    pub band: Option<[f64; 2]>,
}

/// The numbers of the law of a series by least squares; `None` where it has no usable one.
pub(crate) fn numbers_of_series(
    scene: &Scene,
    findings: &Findings,
    series: &Series,
    fit: &SeriesFit,
) -> Option<LawNumbers> {
    if !fit.verdict.passed {
        return None;
    }
    let model = &scene.model;
    let (alpha, order) = (fit.alpha.value?, model.form().dry);
    let own = (model.dry_speed == DrySpeed::Impact).then(|| dry_k(findings, series.sphere));
    let plateau = match own.flatten() {
        None => Plateau::Constant(alpha),
        Some((dry_k, _)) => {
            let at_reference = LawNumbers::dry(dry_k, order).plateau_at(model.dry_speed.reference());
            let loss = at_reference - alpha;
            Plateau::OfSpeed { dry_k, order, loss }
        }
    };
    Some(LawNumbers {
        plateau,
        beta: fit.beta.value?,
        kappa: 0.0,
    })
}

/// k of a sphere by least squares, with its standard error.
fn dry_k(findings: &Findings, sphere: usize) -> Option<(f64, Option<f64>)> {
    let dry = findings.dry.iter().find(|dry| dry.sphere == sphere)?;
    Some((dry.dry_k.value?, dry.dry_k.se))
}

/// The law of every pair: of each sphere the dry one, then those of its series.
pub fn list_laws(scene: &Scene, runs: &Runs, findings: &Findings, posterior: Option<&Posterior>) -> Vec<PairLaw> {
    let listing = Listing {
        scene,
        runs,
        findings,
        quotable: quotable(&findings.verdicts),
    };
    let of_sphere = |sphere: usize| {
        let law = posterior.map(|posterior| posterior.law(scene, runs, sphere, DRAWS));
        let of_series = (0..runs.series.len()).filter(|place| runs.series[*place].sphere == sphere);
        let wet = of_series.map(|place| listing.wet(place, law.as_ref()));
        listing
            .dry(sphere, law.as_ref())
            .into_iter()
            .chain(wet)
            .collect::<Vec<PairLaw>>()
    };
    let spheres = (0..runs.spheres.len()).into_par_iter();
    spheres.flat_map_iter(of_sphere).collect()
}

/// What the laws are listed from.
struct Listing<'a> {
    scene: &'a Scene,
    runs: &'a Runs,
    findings: &'a Findings,
    quotable: bool,
}

impl Listing<'_> {
    /// The dry law of a sphere; `None` where nothing tells its k.
    fn dry(&self, sphere: usize, law: Option<&ParticleLaw>) -> Option<PairLaw> {
        let Listing { scene, runs, .. } = self;
        let order = scene.model.form().dry;
        let (k, se, source) = match law {
            Some(law) => {
                let k = law.draws.iter().map(|draw| [draw.parameters.dry_k; 2]);
                let ([k, _], [[variance, _], _]) = moments(k.collect::<Vec<_>>().as_slice());
                (k, Some(variance.sqrt()), Source::Posterior)
            }
            None => {
                let (k, se) = dry_k(self.findings, sphere)?;
                (k, se, Source::DryLaw)
            }
        };
        let fit = self.findings.dry.iter().find(|dry| dry.sphere == sphere);
        let stands = law.is_some() || fit.is_some_and(|fit| fit.verdict.passed);
        let groups = runs.dry_of(sphere).iter();
        let speeds = range(groups.flat_map(|group| &runs.impact_speed[group.runs()]).copied());
        let curves = law.map(ParticleLaw::dry_restitutions);
        let numbers = LawNumbers::dry(k, order);
        let own = runs.spheres[sphere];
        Some(PairLaw {
            diameter_m: own.diameter,
            source,
            quotable: self.quotable && stands,
            dry_k: Some(k),
            dry_k_se: se,
            dry_order: Some(order.number()),
            threshold_speed_m_s: Some(0.0),
            table: table(numbers, curves.as_deref(), speeds),
            speeds,
            ..PairLaw::empty(&scene.particles[own.particle].name, LawKind::Dry)
        })
    }

    /// The law of a series.
    fn wet(&self, place: usize, law: Option<&ParticleLaw>) -> PairLaw {
        let Listing {
            scene, runs, findings, ..
        } = self;
        let series = &runs.series[place];
        let particle = &scene.particles[series.particle];
        let liquid = &scene.liquids[series.liquid];
        let speeds = range(runs.impact_speed[series.runs()].iter().copied());
        let kind = match scene.model.dry_speed {
            DrySpeed::Reference(_) => LawKind::Reference,
            DrySpeed::Impact => LawKind::Impact,
        };
        let pair = PairLaw {
            liquid: Some(liquid.name.clone()),
            diameter_m: Some(series.diameter),
            film_m: Some(series.film),
            film_ratio: Some(series.film_ratio),
            stokes_per_m_s: Some(stokes(particle.density, series.diameter, 1.0, liquid.viscosity)),
            stokes: range(series.runs().map(|run| 1.0 / runs.inverse_stokes(run))),
            speeds,
            ..PairLaw::empty(&particle.name, kind)
        };
        match law {
            Some(law) => {
                let setting = scene.setting(series.particle, series.liquid, series.diameter, series.film);
                let curves = law.restitutions(&setting);
                let all: Vec<LawNumbers> = curves.iter().map(Restitution::numbers).collect();
                PairLaw {
                    quotable: self.quotable,
                    source: Source::Posterior,
                    ..pair.with_draws(&all, scene.model.dry_speed.reference(), &curves)
                }
            }
            None => {
                let fit = &findings.series[place];
                let pair = PairLaw {
                    quotable: self.quotable && fit.verdict.passed,
                    source: Source::SquareRootLaw,
                    ..pair
                };
                let Some(numbers) = numbers_of_series(scene, findings, series, fit) else {
                    let why_none = fit.verdict.reason.clone();
                    return PairLaw {
                        why_none: Some(why_none),
                        ..pair
                    };
                };
                let se = dry_k(findings, series.sphere).and_then(|(_, se)| se);
                pair.with_fit(numbers, scene.model.dry_speed.reference(), fit.covariance, se)
            }
        }
    }
}

impl PairLaw {
    fn empty(particle: &str, law: LawKind) -> PairLaw {
        PairLaw {
            particle: particle.to_owned(),
            liquid: None,
            diameter_m: None,
            film_m: None,
            film_ratio: None,
            law,
            formula: String::new(),
            dry_k: None,
            dry_k_se: None,
            dry_order: None,
            inertial_loss: None,
            alpha: None,
            beta: None,
            kappa: None,
            threshold_speed_m_s: None,
            e_inf: None,
            st_c: None,
            stokes_per_m_s: None,
            covariance: None,
            speeds: None,
            stokes: None,
            source: Source::Posterior,
            quotable: false,
            why_none: None,
            table: vec![],
        }
        .with_formula()
    }

    /// The formula in the letters of the other fields.
    fn with_formula(mut self) -> PairLaw {
        let kappa = if self.kappa.is_some_and(|kappa| kappa != 0.0) {
            " - kappa/v^2"
        } else {
            ""
        };
        let dry = match self.dry_order {
            Some(2) => "1 - dry_k v^(1/5) + (3/5) dry_k^2 v^(2/5)",
            _ => "1 - dry_k v^(1/5)",
        };
        self.formula = match self.law {
            LawKind::Dry => format!("e = {dry}"),
            LawKind::Reference => format!("e = sqrt(alpha + beta/v{kappa})"),
            LawKind::Impact => format!("e = sqrt(({dry})^2 - inertial_loss + beta/v{kappa})"),
        };
        self
    }

    /// The same with its numbers; those that follow from α and β among them.
    fn with_numbers(self, numbers: LawNumbers, reference: f64) -> PairLaw {
        let alpha = numbers.plateau_at(reference);
        let per_speed = self.stokes_per_m_s.unwrap_or(f64::NAN);
        let [e_inf, st_c] = e_inf_and_st_c(alpha, numbers.beta, per_speed).map(|x| Some(x).filter(|x| x.is_finite()));
        let threshold = numbers.threshold_speed();
        let (law, dry_k, dry_order, inertial_loss) = match numbers.plateau {
            Plateau::Constant(_) => (LawKind::Reference, None, None, None),
            Plateau::OfSpeed { dry_k, order, loss } => (LawKind::Impact, Some(dry_k), Some(order.number()), Some(loss)),
        };
        PairLaw {
            law,
            dry_k,
            dry_order,
            inertial_loss,
            alpha: Some(alpha),
            beta: Some(numbers.beta),
            kappa: Some(numbers.kappa),
            threshold_speed_m_s: Some(threshold).filter(|v| v.is_finite()),
            e_inf,
            st_c,
            ..self
        }
        .with_formula()
    }

    /// The same with the numbers that a fit by least squares has.
    fn with_fit(
        self,
        numbers: LawNumbers,
        reference: f64,
        covariance: Option<[[f64; 2]; 2]>,
        dry_k_se: Option<f64>,
    ) -> PairLaw {
        let per_speed = self.stokes_per_m_s.unwrap_or(f64::NAN);
        let [alpha, beta] = variables([numbers.plateau_at(reference), numbers.beta]);
        let follows = e_inf_and_st_c(alpha, beta, per_speed);
        let carried = |covariance: &[[f64; 2]; 2]| {
            let slopes = follows.map(|x: Jet<PARAMETERS>| x.slopes);
            let product = |i: usize, j: usize| {
                let terms = (0..2).flat_map(|a| (0..2).map(move |b| (a, b)));
                terms
                    .map(|(a, b)| slopes[i][a] * covariance[a][b] * slopes[j][b])
                    .sum::<f64>()
            };
            let all: [[f64; 2]; 2] = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
            all.iter().flatten().all(|x| x.is_finite()).then_some(all)
        };
        let covariance = covariance.map(|alpha_beta| LawCovariance {
            alpha_beta,
            e_inf_st_c: carried(&alpha_beta),
        });
        let mut pair = self.with_numbers(numbers, reference);
        pair.covariance = covariance;
        pair.dry_k_se = dry_k_se.filter(|_| pair.dry_k.is_some());
        pair.table = pair.own_table(numbers, None);
        pair
    }

    /// The same with the means of the numbers of all draws.
    fn with_draws(self, all: &[LawNumbers], reference: f64, curves: &[Restitution]) -> PairLaw {
        let per_speed = self.stokes_per_m_s.unwrap_or(f64::NAN);
        let mean = |of: &dyn Fn(&LawNumbers) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        let of_speed = |numbers: &LawNumbers| match numbers.plateau {
            Plateau::Constant(alpha) => [alpha, 0.0],
            Plateau::OfSpeed { dry_k, loss, .. } => [loss, dry_k],
        };
        let [kept, dry_k] = [0, 1].map(|place| mean(&|numbers| of_speed(numbers)[place]));
        let numbers = LawNumbers {
            plateau: match all.first().map(|first| first.plateau) {
                Some(Plateau::OfSpeed { order, .. }) => Plateau::OfSpeed {
                    dry_k,
                    order,
                    loss: kept,
                },
                _ => Plateau::Constant(kept),
            },
            beta: mean(&|numbers| numbers.beta),
            kappa: mean(&|numbers| numbers.kappa),
        };
        let alpha_beta: Vec<[f64; 2]> = all
            .iter()
            .map(|numbers| [numbers.plateau_at(reference), numbers.beta])
            .collect();
        let follows: Vec<[f64; 2]> = alpha_beta
            .iter()
            .map(|[alpha, beta]| e_inf_and_st_c(*alpha, *beta, per_speed))
            .collect();
        let (_, e_inf_st_c) = moments(&follows);
        let of_k: Vec<[f64; 2]> = all.iter().map(of_speed).collect();
        let (_, [_, [_, variance]]) = moments(&of_k);
        let covariance = LawCovariance {
            alpha_beta: moments(&alpha_beta).1,
            e_inf_st_c: Some(e_inf_st_c).filter(|all| all.iter().flatten().all(|x| x.is_finite())),
        };
        let mut pair = self.with_numbers(numbers, reference);
        pair.covariance = Some(covariance);
        pair.dry_k_se = pair.dry_k.map(|_| variance.sqrt());
        pair.table = pair.own_table(numbers, Some(curves));
        pair
    }

    /// Its table, where e is not √(α + β/v).
    fn own_table(&self, numbers: LawNumbers, curves: Option<&[Restitution]>) -> Vec<LawPoint> {
        if self.law == LawKind::Reference && numbers.kappa == 0.0 {
            return vec![];
        }
        table(numbers, curves, self.speeds)
    }
}

/// e_inf and St_c of e = √(α + β/v), `per_speed` being St over v in s/m; NaN where there are none.
fn e_inf_and_st_c<T: Number>(alpha: T, beta: T, per_speed: f64) -> [T; 2] {
    let wetted = Wetted::of_square_root(alpha, beta * per_speed);
    [Quantity::EInf, Quantity::StC].map(|quantity| quantity.value(&Place::NONE, &wetted))
}

/// Means and covariance of pairs of numbers.
fn moments(pairs: &[[f64; 2]]) -> ([f64; 2], [[f64; 2]; 2]) {
    let n = pairs.len() as f64;
    let mean = [0, 1].map(|place| pairs.iter().map(|pair| pair[place]).sum::<f64>() / n);
    let product = |i: usize, j: usize| {
        let terms = pairs.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j]));
        terms.sum::<f64>() / (n - 1.0)
    };
    (mean, [[product(0, 0), product(0, 1)], [product(1, 0), product(1, 1)]])
}

/// A law at even speeds between those of its runs.
fn table(numbers: LawNumbers, curves: Option<&[Restitution]>, speeds: Option<[f64; 2]>) -> Vec<LawPoint> {
    let Some([slowest, fastest]) = speeds else {
        return vec![];
    };
    let law = Restitution::from(numbers);
    let count = if slowest < fastest { SPEEDS } else { 1 };
    let point = |place: usize| {
        let share = place as f64 / (SPEEDS - 1) as f64;
        let v = slowest + share * (fastest - slowest);
        let sorted = curves.map(|curves| quantile::sorted(curves.iter().map(|curve| curve.at(v)).collect()));
        LawPoint {
            impact_speed: v,
            restitution: law.at(v),
            band: sorted.map(|sorted| [0.05, 0.95].map(|p| quantile::of_sorted(&sorted, p))),
        }
    };
    (0..count).map(point).collect()
}

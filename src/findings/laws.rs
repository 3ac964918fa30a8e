//! Gives the law e(v) of every pair of the runs in the few numbers that a simulation code can take.
//!
//! A pair is a sphere in a liquid under a film, or on the dry plate. With a posterior its numbers are means over the draws,
//! of a new series where series have offsets; without one they are those of the square-root law of the series, and k of the
//! dry law.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::document::Findings;
use super::dry::fit_of_sphere;
use super::estimates::Source;
use super::posterior::Posterior;
use super::predict::{Curve, ParticleLaw};
use super::quantities::{variables, PARAMETERS};
use super::range::range;
use crate::physics::jet::{Jet, Number};
use crate::physics::quantity::{Place, Quantity, Wetted};
use crate::physics::{DrySpeed, LawNumbers, Plateau, Restitution, Setting};
use crate::runs::Runs;
use crate::scene::Scene;

/// Draws that means and covariances are taken over.
const DRAWS: usize = 4000;

/// Speeds of a table, from the slowest to the fastest run.
const SPEEDS: usize = 25;

/// How e depends on the speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LawKind {
    /// e² = α + β/v − κ/v², e_dry being taken at a reference speed
    Reference,
    /// e² = e_dry(v)² − loss + β/v − κ/v²
    Impact,
    /// e = e_dry(v)
    Dry,
}

/// The law of one pair. Field names are those of `findings.json`.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
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
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct LawCovariance {
    /// of α and β
    pub alpha_beta: [[f64; 2]; 2],
    /// of e_inf and St_c; `None` where a draw leaves none
    pub e_inf_st_c: Option<[[f64; 2]; 2]>,
}

/// A law at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LawPoint {
    /// v, m/s
    pub impact_speed: f64,
    /// e; 0: no rebound
    pub restitution: f64,
    /// 5 % and 95 % points, from the parameters' uncertainty; `None` without draws
    pub band: Option<[f64; 2]>,
}

/// A sphere on the dry plate, or in one of its series.
#[derive(Clone, Copy)]
pub(crate) struct Pair {
    pub sphere: usize,
    /// index into [`Runs::series`]; `None`: the dry plate
    pub series: Option<usize>,
}

impl Pair {
    /// The dry pair of a sphere, then those of its series.
    pub fn of_sphere(sphere: usize, runs: &Runs) -> impl Iterator<Item = Pair> + use<'_> {
        let wet = (0..runs.series.len()).filter(move |place| runs.series[*place].sphere == sphere);
        let all = std::iter::once(None).chain(wet.map(Some));
        all.map(move |series| Pair { sphere, series })
    }

    /// The wetted plate; `None`: the dry one.
    pub fn setting(&self, scene: &Scene, runs: &Runs) -> Option<Setting> {
        let own = &runs.series[self.series?];
        Some(scene.setting(own.particle, own.liquid, own.diameter, own.film))
    }

    /// Its law by least squares; `None` without a usable one.
    pub fn fitted(&self, scene: &Scene, findings: &Findings) -> Option<LawNumbers> {
        let (model, order) = (&scene.model, scene.model.form().dry);
        let dry_k = fit_of_sphere(&findings.dry, self.sphere).and_then(|dry| dry.dry_k.value);
        let Some(place) = self.series else {
            return Some(LawNumbers::dry(dry_k?, order));
        };
        let fit = &findings.series[place];
        let [alpha, beta] = fit.parameters().filter(|_| fit.verdict.passed)?;
        let plateau = match dry_k.filter(|_| model.dry_speed == DrySpeed::Impact) {
            None => Plateau::Constant(alpha),
            Some(dry_k) => {
                let at_reference = LawNumbers::dry(dry_k, order).plateau_at(model.dry_speed.reference());
                let loss = at_reference - alpha;
                Plateau::OfSpeed { dry_k, order, loss }
            }
        };
        let kappa = 0.0;
        Some(LawNumbers { plateau, beta, kappa })
    }
}

/// The law of every pair: of each sphere the dry one, then those of its series.
pub fn list_laws(scene: &Scene, runs: &Runs, findings: &Findings, posterior: Option<&Posterior>) -> Vec<PairLaw> {
    let listing = Listing {
        scene,
        runs,
        findings,
        reference: scene.model.dry_speed.reference(),
        quotable: findings.main.verdict.passed,
    };
    let of_sphere = |sphere: usize| {
        let law = posterior.map(|posterior| posterior.law(scene, runs, sphere, DRAWS));
        let pairs = Pair::of_sphere(sphere, runs);
        let laws = pairs.filter_map(|pair| listing.law(pair, law.as_ref()));
        laws.collect::<Vec<PairLaw>>()
    };
    let spheres = (0..runs.spheres.len()).into_par_iter();
    spheres.flat_map_iter(of_sphere).collect()
}

/// What the laws are listed from.
struct Listing<'a> {
    scene: &'a Scene,
    runs: &'a Runs,
    findings: &'a Findings,
    /// the reference dry speed, m/s
    reference: f64,
    quotable: bool,
}

/// The numbers of a law, from draws or a fit.
struct Found {
    numbers: LawNumbers,
    covariance: Option<LawCovariance>,
    dry_k_se: Option<f64>,
}

impl Listing<'_> {
    /// The law of a series, or the dry one of a sphere; `None` of a sphere where nothing tells its k.
    fn law(&self, pair: Pair, law: Option<&ParticleLaw>) -> Option<PairLaw> {
        let Listing { scene, runs, .. } = self;
        let fit = pair.series.map(|place| &self.findings.series[place]);
        let own = pair.series.map(|place| &runs.series[place]);
        let (sphere, setting) = (runs.spheres[pair.sphere], pair.setting(scene, runs));
        let per_speed = setting.map(|setting| setting.stokes(1.0));
        let curve = law.map(|law| law.curve(setting.as_ref()));
        let (found, source, stands) = match (&curve, fit) {
            (Some(curve), _) => (Some(self.of_draws(curve, per_speed)), Source::Posterior, true),
            (None, Some(fit)) => {
                let found = self.of_fits(pair, fit.covariance(), per_speed);
                (found, Source::SquareRootLaw, fit.verdict.passed)
            }
            (None, None) => {
                let dry = fit_of_sphere(&self.findings.dry, pair.sphere)?;
                (
                    Some(self.of_fits(pair, None, per_speed)?),
                    Source::DryLaw,
                    dry.verdict.passed,
                )
            }
        };
        let numbers = found.as_ref().map(|found| found.numbers);
        let wet = numbers.filter(|_| own.is_some());
        let of_speed = numbers.and_then(|numbers| match numbers.plateau {
            Plateau::Constant(_) => None,
            Plateau::OfSpeed { dry_k, order, loss } => Some((dry_k, order, loss)),
        });
        let kind = match (own, numbers) {
            (None, _) => LawKind::Dry,
            (Some(_), None) if scene.model.dry_speed == DrySpeed::Impact => LawKind::Impact,
            (Some(_), _) if of_speed.is_some() => LawKind::Impact,
            (Some(_), _) => LawKind::Reference,
        };
        let alpha = wet.map(|numbers| numbers.plateau_at(self.reference));
        let follows = wet.map(|numbers| self.follow(&numbers, per_speed));
        let [e_inf, st_c] = [0, 1].map(|place| Some(follows?[place]).filter(|x| x.is_finite()));
        let speeds = match own {
            Some(own) => range(runs.impact_speed[own.runs()].iter().copied()),
            None => {
                let groups = runs.dry_of(pair.sphere).iter();
                range(groups.flat_map(|group| &runs.impact_speed[group.runs()]).copied())
            }
        };
        let kappa = wet.map(|wet| wet.kappa);
        let in_table = numbers.filter(|own| kind != LawKind::Reference || own.kappa != 0.0);
        let order = of_speed.map(|(_, order, _)| order.number());
        Some(PairLaw {
            particle: scene.particles[sphere.particle].name.clone(),
            liquid: own.map(|own| scene.liquids[own.liquid].name.clone()),
            diameter_m: own.map_or(sphere.diameter, |own| Some(own.diameter)),
            film_m: own.map(|own| own.film),
            film_ratio: own.map(|own| own.film_ratio),
            law: kind,
            formula: formula(kind, order, kappa),
            dry_k: of_speed.map(|(dry_k, ..)| dry_k),
            dry_k_se: of_speed.and(found.as_ref()).and_then(|found| found.dry_k_se),
            dry_order: order,
            inertial_loss: of_speed.filter(|_| wet.is_some()).map(|(_, _, loss)| loss),
            alpha,
            beta: wet.map(|wet| wet.beta),
            kappa,
            threshold_speed_m_s: numbers.map(|own| own.threshold_speed()).filter(|v| v.is_finite()),
            e_inf,
            st_c,
            stokes_per_m_s: per_speed,
            covariance: found.and_then(|found| found.covariance),
            speeds,
            stokes: own.and_then(|own| range(own.runs().map(|run| 1.0 / runs.inverse_stokes(run)))),
            source,
            quotable: self.quotable && stands,
            why_none: fit.filter(|_| numbers.is_none()).map(|fit| fit.verdict.reason.clone()),
            table: in_table.map_or(vec![], |numbers| table(numbers, curve.as_ref(), speeds)),
        })
    }

    /// What least squares found, with the covariance of α and β of a series; `None` without a usable law.
    fn of_fits(&self, pair: Pair, covariance: Option<[[f64; 2]; 2]>, per_speed: Option<f64>) -> Option<Found> {
        let dry = fit_of_sphere(&self.findings.dry, pair.sphere);
        let numbers = pair.fitted(self.scene, self.findings)?;
        Some(Found {
            numbers,
            covariance: covariance.map(|own| self.carried(numbers, own, per_speed)),
            dry_k_se: dry.and_then(|dry| dry.dry_k.se),
        })
    }

    /// e_inf and St_c that follow from α and β.
    fn follow(&self, numbers: &LawNumbers, per_speed: Option<f64>) -> [f64; 2] {
        e_inf_and_st_c(
            numbers.plateau_at(self.reference),
            numbers.beta,
            per_speed.unwrap_or(f64::NAN),
        )
    }

    /// The covariance of a fit's α and β, and what it carries on to e_inf and St_c.
    fn carried(&self, numbers: LawNumbers, alpha_beta: [[f64; 2]; 2], per_speed: Option<f64>) -> LawCovariance {
        let [alpha, beta] = variables([numbers.plateau_at(self.reference), numbers.beta]);
        let follows = e_inf_and_st_c(alpha, beta, per_speed.unwrap_or(f64::NAN));
        let slopes = follows.map(|x: Jet<PARAMETERS>| x.slopes);
        let product = |i: usize, j: usize| {
            let terms = (0..2).flat_map(|a| (0..2).map(move |b| (a, b)));
            terms
                .map(|(a, b)| slopes[i][a] * alpha_beta[a][b] * slopes[j][b])
                .sum::<f64>()
        };
        let all: [[f64; 2]; 2] = std::array::from_fn(|i| std::array::from_fn(|j| product(i, j)));
        LawCovariance {
            alpha_beta,
            e_inf_st_c: Some(all).filter(|all| all.iter().flatten().all(|x| x.is_finite())),
        }
    }

    /// Means and covariances of the numbers of all draws.
    fn of_draws(&self, curve: &Curve, per_speed: Option<f64>) -> Found {
        let all = curve.numbers();
        let kept = |numbers: &LawNumbers| match numbers.plateau {
            Plateau::Constant(alpha) => [alpha, 0.0],
            Plateau::OfSpeed { dry_k, loss, .. } => [loss, dry_k],
        };
        let of = |of: &dyn Fn(&LawNumbers) -> [f64; 2]| moments(&all.iter().map(of).collect::<Vec<_>>());
        let ([kept, dry_k], [_, [_, variance]]) = of(&kept);
        let ([beta, kappa], _) = of(&|numbers| [numbers.beta, numbers.kappa]);
        let plateau = match all.first().map(|first| first.plateau) {
            Some(Plateau::OfSpeed { order, .. }) => Plateau::OfSpeed {
                dry_k,
                order,
                loss: kept,
            },
            _ => Plateau::Constant(kept),
        };
        let covariance = per_speed.map(|_| LawCovariance {
            alpha_beta: of(&|numbers| [numbers.plateau_at(self.reference), numbers.beta]).1,
            e_inf_st_c: Some(of(&|numbers| self.follow(numbers, per_speed)).1)
                .filter(|all| all.iter().flatten().all(|x| x.is_finite())),
        });
        Found {
            numbers: LawNumbers { plateau, beta, kappa },
            covariance,
            dry_k_se: Some(variance.sqrt()),
        }
    }
}

/// How e depends on the speed, in the names of the columns.
fn formula(kind: LawKind, dry_order: Option<u8>, kappa: Option<f64>) -> String {
    let kappa = match kappa {
        Some(kappa) if kappa != 0.0 => " - kappa/v^2",
        _ => "",
    };
    let dry = match dry_order {
        Some(2) => "1 - dry_k v^(1/5) + (3/5) dry_k^2 v^(2/5)",
        _ => "1 - dry_k v^(1/5)",
    };
    match kind {
        LawKind::Dry => format!("e = {dry}"),
        LawKind::Reference => format!("e = sqrt(alpha + beta/v{kappa})"),
        LawKind::Impact => format!("e = sqrt(({dry})^2 - inertial_loss + beta/v{kappa})"),
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
fn table(numbers: LawNumbers, curve: Option<&Curve>, speeds: Option<[f64; 2]>) -> Vec<LawPoint> {
    let Some([slowest, fastest]) = speeds else {
        return vec![];
    };
    let law = Restitution::from(numbers);
    let count = if slowest < fastest { SPEEDS } else { 1 };
    let point = |place: usize| {
        let v = slowest + place as f64 / (SPEEDS - 1) as f64 * (fastest - slowest);
        let at = curve.map(|curve| curve.at(v));
        LawPoint {
            impact_speed: v,
            restitution: law.at(v),
            band: at.map(|at| [at.q05, at.q95]),
        }
    };
    (0..count).map(point).collect()
}

//! Puts every estimate in a row of one table, which `findings.json` writes and frames of data are made from.
//!
//! Of one place and source a quantity has one row.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::balance::{EnergyBalance, NO_VISCOUS};
use super::constants::Sensitivity;
use super::dry::Dry;
use super::estimate::{Estimate, QuantityEstimates, Quoting};
use super::least_squares::LeastSquares;
use super::places::EstimatePlace;
use super::posterior::derived::DerivedDraws;
use super::posterior::{Posterior, PriorSummary, QuantitySummary};
use super::scaling::Scaling;
use crate::inference::diagnostics::quantile::central_interval;
use crate::physics::{Coefficient, Quantity};
use crate::rounding::short;
use crate::runs::{sphere_label, Runs};
use crate::scene::{Scene, WetLaw};

/// Where an estimate comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// the posterior of all runs at once
    Posterior,
    /// the square-root law at one film ratio
    SquareRootLaw,
    /// the linear law at one film ratio
    LinearLaw,
    /// least squares over all rebounds at once
    EnergyBalance,
    /// the law of the dry runs
    DryLaw,
}

impl Source {
    fn of_law(law: WetLaw) -> Source {
        match law {
            WetLaw::Sqrt => Source::SquareRootLaw,
            WetLaw::Linear => Source::LinearLaw,
        }
    }
}

/// One estimate: a main number as it is quoted, others with the standard error of their fit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct EstimateRow {
    /// name of the quantity
    pub quantity: &'static str,
    /// the quantity; `None` of a parameter of the noise
    #[serde(skip)]
    pub kind: Option<Quantity>,
    /// what it is of
    #[serde(flatten)]
    pub of: EstimatePlace,
    /// whether it is one of the numbers that are quoted first
    pub main: bool,
    /// where it comes from
    pub source: Source,
    /// the number, in the unit of the quantity
    #[serde(flatten)]
    pub number: Estimate,
    /// whether the prior leads: the runs leave more than half of its sd
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub prior_led: bool,
    /// where a k comes from that no dry run tells: `wet runs`
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<&'static str>,
    /// what its draws say, of what follows from the parameters of the posterior
    #[serde(flatten)]
    pub draws: Option<DrawsOfRow>,
    /// index into [`Runs::spheres`]: whose k it goes by; `None` of what spheres share
    #[serde(skip)]
    pub(super) sphere: Option<usize>,
}

/// Where the draws of an estimate lie, and how reliable they are.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DrawsOfRow {
    /// 50 % point of the draws
    pub median: Option<f64>,
    /// R-hat: 1 where all chains look alike, above 1.01 not reliable
    pub rhat: Option<f64>,
    /// effective draws in the bulk
    pub ess_bulk: Option<f64>,
    /// effective draws in the tails
    pub ess_tail: Option<f64>,
}

impl EstimateRow {
    pub(super) fn new(
        quantity: Quantity,
        of: EstimatePlace,
        sphere: Option<usize>,
        number: Estimate,
        source: Source,
    ) -> EstimateRow {
        EstimateRow {
            quantity: quantity.describe().name,
            kind: Some(quantity),
            of,
            main: false,
            source,
            number,
            prior_led: false,
            from: None,
            draws: None,
            sphere,
        }
    }

    /// Whether it is of this quantity.
    pub fn is(&self, quantity: Quantity) -> bool {
        self.kind == Some(quantity)
    }

    /// Its name, as those of the posterior's parameters and of what follows from them are named: `dry_k[PTFE,4.762]`,
    /// `e_inf[PTFE,AK10,0.06]`; several liquids that are taken as one are left out of it.
    pub fn name(&self) -> String {
        let of = match (&self.of.particle, self.of.film_ratio) {
            (None, _) => return self.quantity.to_owned(),
            (Some(particle), None) => sphere_label(particle, self.of.diameter_m),
            (Some(particle), Some(film_ratio)) => {
                let parts = [Some(particle.clone()), self.of.liquid.clone(), Some(short(film_ratio))];
                parts.into_iter().flatten().collect::<Vec<_>>().join(",")
            }
        };
        format!("{}[{of}]", self.quantity)
    }

    /// Whether it comes from this law.
    pub(super) fn is_of_law(&self, law: &Scaling) -> bool {
        (self.source, self.sphere, self.of.film_ratio) == (Source::of_law(law.law), Some(law.sphere), law.film_ratio)
    }

    /// Whether a sensitivity is of it, by the fit that it comes from or is checked by.
    pub fn is_result(&self, result: &Sensitivity) -> bool {
        result.result == self.quantity
            && result.of == self.of.of_all_liquids()
            && result.is_of_balance() == (self.source != Source::SquareRootLaw)
    }
}

/// What estimates are put in rows from.
#[derive(Clone, Copy)]
pub(super) struct EstimateSources<'a> {
    pub scene: &'a Scene,
    pub runs: &'a Runs,
    pub least_squares: &'a LeastSquares,
    /// `None` if nothing was sampled
    pub posterior: Option<&'a Posterior>,
}

impl EstimateSources<'_> {
    /// Every estimate, those of the same source together.
    pub fn rows(self) -> Vec<EstimateRow> {
        let fits = self.least_squares;
        let mut rows = self.posterior.map_or(vec![], |posterior| self.by_posterior(posterior));
        rows.extend(fits.dry.iter().flat_map(by_dry_law));
        rows.extend(fits.energy_balance.iter().flat_map(|own| self.by_balance(own)));
        rows.extend(fits.scaling.iter().flat_map(by_law));
        for own in &fits.series {
            let of = EstimatePlace {
                liquid: Some(own.liquid.clone()),
                ..EstimatePlace::of_particle(&own.particle, Some(own.diameter_m)).at(Some(own.film_ratio))
            };
            rows.extend(rows_of(own.sphere, of, Source::SquareRootLaw, &own.estimates));
        }
        rows
    }

    /// The sampled parameters, and what follows from them.
    fn by_posterior(self, posterior: &Posterior) -> Vec<EstimateRow> {
        let parameters = posterior.sampled.parameters.sampled.iter();
        let with_draws = parameters.zip(&posterior.sampled.values);
        let all = with_draws.zip(&posterior.findings.parameters);
        let sampled = all.map(|((own, draws), summary)| EstimateRow {
            quantity: own.kind.key(),
            kind: own.kind.quantity(),
            of: self.of_sphere(own.kind.sphere()),
            main: false,
            source: Source::Posterior,
            number: self.of_draws(summary, draws),
            prior_led: summary.prior.as_ref().is_some_and(PriorSummary::leads),
            from: summary.from,
            draws: None,
            sphere: own.kind.sphere(),
        });
        let mut rows: Vec<EstimateRow> = sampled.collect();
        let l = Quantity::Shared(Coefficient::LubricationLog);
        let prior_led = rows.iter().any(|own| own.is(l) && own.prior_led);
        // each is sorted for its interval
        let derived = posterior.derived.par_iter().zip(&posterior.findings.derived);
        rows.par_extend(derived.map(|(draws, summary)| EstimateRow {
            prior_led: prior_led && draws.quantity == Quantity::DeltaCOverRoughness,
            ..self.derived(draws, summary)
        }));
        // without a viscous loss there is no St_c
        if rows.iter().all(|own| !own.is(Quantity::StC)) {
            let of_e_inf = rows.iter().filter(|own| own.is(Quantity::EInf));
            let number = no_draws(Quoting::of(self.scene), NO_VISCOUS);
            let none = of_e_inf.map(|own| {
                let (place, number) = (own.of.clone(), number.clone());
                EstimateRow::new(Quantity::StC, place, own.sphere, number, Source::Posterior)
            });
            let none: Vec<EstimateRow> = none.collect();
            rows.extend(none);
        }
        rows
    }

    /// What follows from the sampled parameters.
    fn derived(self, draws: &DerivedDraws, summary: &QuantitySummary) -> EstimateRow {
        let (number, place) = (self.of_draws(summary, &draws.values), draws.of.clone());
        EstimateRow {
            draws: Some(DrawsOfRow {
                median: summary.median,
                rhat: summary.rhat,
                ess_bulk: summary.ess_bulk,
                ess_tail: summary.ess_tail,
            }),
            ..EstimateRow::new(draws.quantity, place, draws.sphere, number, Source::Posterior)
        }
    }

    /// The parameters of the energy balance, δc/ε, and e_inf and St_c of its places.
    fn by_balance(self, balance: &EnergyBalance) -> Vec<EstimateRow> {
        let row = |quantity, sphere, estimate: &Estimate| {
            let place = self.of_sphere(sphere);
            EstimateRow::new(quantity, place, sphere, estimate.clone(), Source::EnergyBalance)
        };
        let parameters = balance.parameters.iter();
        let parameters = parameters.filter_map(|own| Some(row(own.kind.quantity()?, own.kind.sphere(), &own.estimate)));
        let ratio = row(Quantity::DeltaCOverRoughness, None, &balance.delta_c_over_roughness);
        let derived = balance.derived.iter().flat_map(|own| {
            let of = EstimatePlace::of_particle(&own.particle, own.diameter_m).at(Some(own.film_ratio));
            rows_of(own.sphere, of, Source::EnergyBalance, &own.estimates)
        });
        parameters.chain([ratio]).chain(derived).collect()
    }

    /// From a summary and its draws, chain by chain.
    fn of_draws(self, summary: &QuantitySummary, draws: &[Vec<f64>]) -> Estimate {
        // what follows from a parameter that the scene holds has no spread
        let mut all = draws.iter().flatten();
        let first = all.next();
        let is_held = all.all(|draw| Some(draw) == first);
        let quoting = Quoting::of(self.scene);
        Estimate {
            value: summary.mean,
            se: summary.sd.filter(|_| !is_held),
            interval: central_interval(draws, quoting.level).filter(|_| !is_held),
            mcse: summary.mcse_mean,
            why_none: if is_held {
                Some("the scene holds what it follows from".to_owned())
            } else {
                summary.why_none.clone().filter(|_| summary.sd.is_none())
            },
            ..no_draws(quoting, "")
        }
    }

    /// A sphere by its index; `None`: what all share.
    fn of_sphere(self, sphere: Option<usize>) -> EstimatePlace {
        sphere.map_or_else(EstimatePlace::default, |sphere| {
            let sphere = &self.runs.spheres[sphere];
            EstimatePlace::of_particle(&self.scene.particles[sphere.particle].name, sphere.diameter)
        })
    }
}

/// A number that the posterior does not give, for a reason.
pub(super) fn no_draws(quoting: Quoting, why: &str) -> Estimate {
    Estimate {
        method: "posterior_quantiles",
        ..quoting.none(why)
    }
}

/// k by the dry law, and of several diameters that of each after it.
fn by_dry_law(dry: &Dry) -> Vec<EstimateRow> {
    let row = |diameter_m, dry_k: &Estimate| {
        let of = EstimatePlace::of_particle(&dry.particle, diameter_m);
        EstimateRow::new(Quantity::DryK, of, Some(dry.sphere), dry_k.clone(), Source::DryLaw)
    };
    let several = dry.by_diameter.len() > 1;
    let each = dry.by_diameter.iter().filter(|_| several);
    let each = each.map(|one| row(Some(one.diameter_m), &one.dry_k));
    std::iter::once(row(dry.diameter_m, &dry.dry_k)).chain(each).collect()
}

/// Everything that a law over 1/St gives.
fn by_law(own: &Scaling) -> impl Iterator<Item = EstimateRow> + use<'_> {
    let of = EstimatePlace::of_particle(&own.particle, own.diameter_m).at(own.film_ratio);
    rows_of(own.sphere, of, Source::of_law(own.law), &own.estimates)
}

/// The estimates of a place by a fit.
fn rows_of(
    sphere: usize,
    of: EstimatePlace,
    source: Source,
    estimates: &QuantityEstimates,
) -> impl Iterator<Item = EstimateRow> + use<'_> {
    let each = estimates.iter();
    each.map(move |(quantity, own)| EstimateRow::new(quantity, of.clone(), Some(sphere), own.clone(), source))
}

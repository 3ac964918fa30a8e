//! Puts every estimate in a row of one table, which `findings.json` writes and frames of data are made from.
//!
//! Of one place and source a quantity has one row.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::balance::{DerivedEstimate, EnergyBalance};
use super::constants::Sensitivity;
use super::dry::Dry;
use super::estimate::{Estimate, QuantityEstimates, Quoting};
use super::least_squares::LeastSquares;
use super::posterior::derived::DerivedDraws;
use super::posterior::{Posterior, PriorSummary, QuantitySummary};
use super::scaling::Scaling;
use super::series::SeriesFit;
use crate::inference::diagnostics::quantile::central_interval;
use crate::physics::Quantity;
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
    /// Its name in a text.
    pub fn name(self) -> &'static str {
        match self {
            Source::Posterior => "posterior",
            Source::SquareRootLaw => "square-root law",
            Source::LinearLaw => "linear law",
            Source::EnergyBalance => "energy balance",
            Source::DryLaw => "dry law",
        }
    }

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
}

/// What an estimate is of.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct EstimatePlace {
    /// name of the particle; `None` of what particles share
    pub particle: Option<String>,
    /// name of the liquid; `None` of what liquids share, and of several that are taken as one
    pub liquid: Option<String>,
    /// D, m; `None` of what diameters share
    pub diameter_m: Option<f64>,
    /// δ/D; `None` of what films share
    pub film_ratio: Option<f64>,
}

impl EstimatePlace {
    fn of_particle(particle: &str, diameter_m: Option<f64>) -> EstimatePlace {
        EstimatePlace {
            particle: Some(particle.to_owned()),
            diameter_m,
            ..EstimatePlace::default()
        }
    }

    fn at(self, film_ratio: Option<f64>) -> EstimatePlace {
        EstimatePlace { film_ratio, ..self }
    }
}

impl EstimateRow {
    pub(super) fn new(quantity: Quantity, of: EstimatePlace, number: Estimate, source: Source) -> EstimateRow {
        EstimateRow {
            quantity: quantity.describe().name,
            kind: Some(quantity),
            of,
            main: false,
            source,
            number,
            prior_led: false,
            from: None,
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
        self.source == Source::of_law(law.law)
            && self.of.film_ratio == law.film_ratio
            && (self.of.particle.as_ref(), self.of.diameter_m) == (Some(&law.particle), law.diameter_m)
    }

    /// Whether a sensitivity is of it, by the fit that it comes from or is checked by.
    pub fn is_result(&self, result: &Sensitivity) -> bool {
        let of = &self.of;
        result.result == self.quantity
            && result.particle == of.particle
            && (result.film_ratio, result.diameter_m) == (of.film_ratio, of.diameter_m)
            && result.is_of_balance() == (self.source != Source::SquareRootLaw)
    }
}

/// What estimates are put in rows from.
#[derive(Clone, Copy)]
pub(super) struct EstimateSources<'a> {
    pub scene: &'a Scene,
    pub runs: &'a Runs,
    pub least_squares: LeastSquares<'a>,
    /// `None` if nothing was sampled
    pub posterior: Option<&'a Posterior>,
}

impl<'a> EstimateSources<'a> {
    /// Every estimate, those of the same source together.
    pub fn rows(self) -> Vec<EstimateRow> {
        let mut rows = vec![];
        if let Some(posterior) = self.posterior {
            rows.extend(self.sampled(posterior));
            // each is sorted for its interval
            let derived = posterior.derived.par_iter().zip(&posterior.findings.derived);
            rows.par_extend(derived.map(|(draws, summary)| self.derived(draws, summary)));
        }
        let fits = self.least_squares;
        rows.extend(fits.dry.iter().flat_map(of_diameters));
        if let Some(balance) = fits.energy_balance {
            rows.extend(self.fitted(balance));
            rows.extend(balance.derived.iter().flat_map(of_balance));
        }
        let by_laws = || fits.scaling.iter().flat_map(by_law);
        let is_of_energy = |row: &EstimateRow| OF_ENERGY.iter().any(|quantity| row.is(*quantity));
        rows.extend(by_laws().filter(|row| !is_of_energy(row)));
        rows.extend(by_laws().filter(is_of_energy));
        rows.extend(fits.series.iter().flat_map(of_series));
        rows
    }

    /// The sampled parameters.
    pub fn sampled(self, posterior: &'a Posterior) -> impl Iterator<Item = EstimateRow> + 'a {
        let parameters = posterior.sampled.parameters.sampled.iter();
        let with_draws = parameters.zip(&posterior.sampled.values);
        let all = with_draws.zip(&posterior.findings.parameters);
        all.map(move |((own, draws), summary)| EstimateRow {
            quantity: own.kind.key(),
            kind: own.kind.quantity(),
            of: self.of_sphere(own.kind.sphere()),
            main: false,
            source: Source::Posterior,
            number: self.of_draws(summary, draws),
            prior_led: summary.prior.as_ref().is_some_and(PriorSummary::leads),
            from: summary.from,
        })
    }

    /// What follows from the sampled parameters.
    pub fn derived(self, draws: &DerivedDraws, summary: &QuantitySummary) -> EstimateRow {
        let of = match &draws.setting {
            Some(setting) => EstimatePlace {
                particle: Some(self.scene.particles[setting.particle].name.clone()),
                liquid: Some(self.scene.liquids[setting.liquid].name.clone()),
                diameter_m: setting.diameter,
                film_ratio: Some(setting.film_ratio),
            },
            None => EstimatePlace {
                particle: draws.label.clone(),
                ..EstimatePlace::default()
            },
        };
        let number = self.of_draws(summary, &draws.values);
        EstimateRow::new(draws.quantity, of, number, Source::Posterior)
    }

    /// The parameters of the energy balance, and δc/ε after them.
    pub fn fitted(self, balance: &'a EnergyBalance) -> impl Iterator<Item = EstimateRow> + 'a {
        let row =
            |quantity, of, estimate: &Estimate| EstimateRow::new(quantity, of, estimate.clone(), Source::EnergyBalance);
        let parameters = balance.parameters.iter().filter_map(move |own| {
            let of = self.of_sphere(own.kind.sphere());
            Some(row(own.kind.quantity()?, of, &own.estimate))
        });
        let ratio = &balance.delta_c_over_roughness;
        let ratio = row(Quantity::DeltaCOverRoughness, EstimatePlace::default(), ratio);
        parameters.chain([ratio])
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

/// k by the dry law.
pub(super) fn of_dry_law(dry: &Dry) -> EstimateRow {
    let of = EstimatePlace::of_particle(&dry.particle, dry.diameter_m);
    EstimateRow::new(Quantity::DryK, of, dry.dry_k.clone(), Source::DryLaw)
}

/// k by the dry law, and of several diameters that of each after it.
fn of_diameters(dry: &Dry) -> impl Iterator<Item = EstimateRow> + use<'_> {
    let several = dry.by_diameter.len() > 1;
    let each = dry.by_diameter.iter().filter(move |_| several).map(move |one| {
        let of = EstimatePlace::of_particle(&dry.particle, Some(one.diameter_m));
        EstimateRow::new(Quantity::DryK, of, one.dry_k.clone(), Source::DryLaw)
    });
    std::iter::once(of_dry_law(dry)).chain(each)
}

/// e_inf and St_c of a place by the energy balance.
pub(super) fn of_balance(own: &DerivedEstimate) -> [EstimateRow; 2] {
    let of = EstimatePlace::of_particle(&own.particle, own.diameter_m).at(Some(own.film_ratio));
    e_inf_and_st_c(of, Source::EnergyBalance, &own.estimates)
}

/// e_inf and St_c by a law over 1/St.
pub(super) fn of_law(own: &Scaling) -> [EstimateRow; 2] {
    e_inf_and_st_c(place_of(own), Source::of_law(own.law), &own.estimates)
}

/// Of what a law over 1/St gives the quantities that tell where the energy went.
const OF_ENERGY: [Quantity; 3] = [Quantity::InertialLoss, Quantity::StCEInf2, Quantity::DeltaC];

/// Everything that a law over 1/St gives.
fn by_law(own: &Scaling) -> impl Iterator<Item = EstimateRow> + use<'_> {
    rows_of(place_of(own), Source::of_law(own.law), &own.estimates)
}

fn place_of(law: &Scaling) -> EstimatePlace {
    EstimatePlace::of_particle(&law.particle, law.diameter_m).at(law.film_ratio)
}

fn of_series(own: &SeriesFit) -> impl Iterator<Item = EstimateRow> + use<'_> {
    let of = EstimatePlace {
        liquid: Some(own.liquid.clone()),
        ..EstimatePlace::of_particle(&own.particle, Some(own.diameter_m)).at(Some(own.film_ratio))
    };
    rows_of(of, Source::SquareRootLaw, &own.estimates)
}

/// The estimates of a place by a fit.
fn rows_of(
    of: EstimatePlace,
    source: Source,
    estimates: &QuantityEstimates,
) -> impl Iterator<Item = EstimateRow> + use<'_> {
    let each = estimates.iter();
    each.map(move |(quantity, own)| EstimateRow::new(quantity, of.clone(), own.clone(), source))
}

/// e_inf and St_c among them.
fn e_inf_and_st_c(of: EstimatePlace, source: Source, estimates: &QuantityEstimates) -> [EstimateRow; 2] {
    let row = |quantity| EstimateRow::new(quantity, of.clone(), estimates[quantity].clone(), source);
    [Quantity::EInf, Quantity::StC].map(row)
}

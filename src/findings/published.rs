//! Sets numbers from the literature beside ours.

use schemars::JsonSchema;
use serde::Serialize;

use super::dry;
use super::estimate::Estimate;
use super::scaling::Scaling;
use super::wet_fit::FitSetup;
use crate::physics::Quantity;
use crate::scene::{Published, WetLaw};

/// A published number beside ours.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PublishedComparison {
    /// `e_inf`, `st_c` or `dry_k`
    pub quantity: &'static str,
    /// its letter
    #[serde(skip)]
    pub symbol: &'static str,
    /// name of the particle
    pub particle: String,
    /// film ratio; `None`: over all
    pub film_ratio: Option<f64>,
    /// law it was fitted with; `None` for k
    pub law: Option<WetLaw>,
    /// published value
    pub value: f64,
    /// published standard error
    pub se: f64,
    /// where it stands
    pub source: String,
    /// our value
    pub ours: Option<f64>,
    /// our standard error
    pub ours_se: Option<f64>,
    /// (ours − published)/√(se² + ours_se²)
    pub difference_in_se: Option<f64>,
    /// whether the law that ours comes from is usable
    #[serde(skip)]
    pub usable: bool,
    /// why there is nothing to compare
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_none: Option<String>,
}

/// Every published number of the scene beside ours.
pub fn compare_with_published(setup: FitSetup, scaling: &[Scaling]) -> Vec<PublishedComparison> {
    let published = setup.scene.published.iter();
    published.map(|published| compare(setup, scaling, published)).collect()
}

fn compare(setup: FitSetup, scaling: &[Scaling], published: &Published) -> PublishedComparison {
    let FitSetup { scene, runs, dry } = setup;
    let spheres = runs.spheres_of(published.particle);
    // a published number is of all diameters
    let several = spheres.len() > 1;
    let sphere = Some(spheres.start).filter(|_| !several);
    let laws = scaling.iter();
    let laws = laws.filter(|fit| Some(fit.sphere) == sphere && Some(fit.law) == published.law);
    let law = nearest(laws, published.film_ratio, scene.data.film_ratio_gap);
    let ours = match published.quantity {
        Quantity::DryK => sphere.and_then(|sphere| Some(&dry::fit_of_sphere(dry, sphere)?.dry_k)),
        quantity => law.map(|law| &law.estimates[quantity]),
    };
    let pair = ours.and_then(Estimate::pair);
    let difference = pair.map(|(value, se)| (value - published.value) / published.se.hypot(se));
    let why = match (pair, ours) {
        (Some(_), _) => None,
        (None, Some(estimate)) => estimate.why_none.clone(),
        (None, None) if several => Some("each diameter has its own k here".to_owned()),
        (None, None) => Some("no runs of this particle and film ratio".to_owned()),
    };
    PublishedComparison {
        quantity: published.quantity.describe().name,
        symbol: published.quantity.describe().symbol,
        particle: scene.particles[published.particle].name.clone(),
        film_ratio: published.film_ratio,
        law: published.law,
        value: published.value,
        se: published.se,
        source: published.source.clone(),
        ours: ours.and_then(|estimate| estimate.value),
        ours_se: ours.and_then(|estimate| estimate.se),
        difference_in_se: difference,
        usable: law.is_none_or(|law| law.verdict.passed),
        why_none: why,
    }
}

/// The fit at the nearest film ratio, no further off than groups are told apart; `None`: that over all film ratios.
fn nearest<'a>(mut laws: impl Iterator<Item = &'a Scaling>, film_ratio: Option<f64>, gap: f64) -> Option<&'a Scaling> {
    match film_ratio {
        None => laws.find(|fit| fit.film_ratio.is_none()),
        Some(wanted) => laws
            .filter_map(|fit| Some(((fit.film_ratio? - wanted).abs(), fit)))
            .filter(|(distance, _)| *distance <= gap)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, fit)| fit),
    }
}

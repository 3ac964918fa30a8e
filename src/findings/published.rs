//! Sets numbers from the literature beside ours.

use serde::Serialize;

use super::dry::{self, FittedDry};
use super::estimate::Estimate;
use super::scaling::FittedScaling;
use crate::physics::Quantity;
use crate::runs::Runs;
use crate::scene::{Published, Scene, WetLaw};

/// A published number beside ours.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PublishedComparison {
    /// `e_inf`, `st_c` or `dry_k`
    pub quantity: &'static str,
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
    /// why there is nothing to compare
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why_none: Option<String>,
}

/// What published numbers are compared with.
#[derive(Clone, Copy)]
pub struct OwnFits<'a> {
    /// what was held fixed
    pub scene: &'a Scene,
    /// what was measured
    pub runs: &'a Runs,
    /// k of each sphere by its dry runs
    pub dry: &'a [FittedDry],
    /// e_inf and St_c by both laws
    pub scaling: &'a [FittedScaling],
}

/// Every published number of the scene beside ours.
pub fn compare_with_published(own: OwnFits) -> Vec<PublishedComparison> {
    let published = own.scene.published.iter();
    published.map(|published| compare(own, published)).collect()
}

fn compare(own: OwnFits, published: &Published) -> PublishedComparison {
    let OwnFits { scene, runs, dry, .. } = own;
    let spheres = runs.spheres_of(published.particle);
    // a published number is of all diameters
    let several = spheres.len() > 1;
    let sphere = Some(spheres.start).filter(|_| !several);
    let ours = sphere.and_then(|sphere| match published.quantity {
        Quantity::DryK => dry::fit_of_sphere(dry, sphere).map(|d| &d.dry.dry_k),
        quantity => group(own, sphere, published).and_then(|fitted| fitted.scaling.estimate(quantity)),
    });
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
        particle: scene.particles[published.particle].name.clone(),
        film_ratio: published.film_ratio,
        law: published.law,
        value: published.value,
        se: published.se,
        source: published.source.clone(),
        ours: ours.and_then(|estimate| estimate.value),
        ours_se: ours.and_then(|estimate| estimate.se),
        difference_in_se: difference,
        why_none: why,
    }
}

/// Our fit of the sphere and law at the nearest film ratio, no further off than groups are told apart.
fn group<'a>(own: OwnFits<'a>, sphere: usize, published: &Published) -> Option<&'a FittedScaling> {
    let same = own.scaling.iter();
    let same = same.filter(|fit| fit.sphere == sphere && Some(fit.law) == published.law);
    match published.film_ratio {
        None => same.into_iter().find(|fit| fit.scaling.film_ratio.is_none()),
        Some(wanted) => same
            .filter_map(|fit| Some(((fit.scaling.film_ratio? - wanted).abs(), fit)))
            .filter(|(distance, _)| *distance <= own.scene.data.film_ratio_gap)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, fit)| fit),
    }
}

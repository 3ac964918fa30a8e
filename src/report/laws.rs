//! Writes the laws of a scene's pairs as CSV, a line a pair, at full precision and in SI.

use super::json::word;
use crate::findings::laws::{LawPoint, PairLaw};
use crate::scene::DRY;

/// The laws, a line a pair.
pub(super) const LAWS: &str = "laws.csv";
/// Those that are not √(α + β/v) at some speeds, a line a speed.
pub(super) const TABLE: &str = "laws_table.csv";

/// A column's name with what of a law stands in it.
type Column = (&'static str, fn(&PairLaw) -> String);

fn number(x: Option<f64>) -> String {
    // a number that is not finite is none
    let finite = x.filter(|x| x.is_finite());
    finite.map_or(String::new(), |x| format!("{x:?}"))
}

/// A variance or covariance of α and β.
fn alpha_beta(law: &PairLaw, i: usize, j: usize) -> Option<f64> {
    Some(law.covariance?.alpha_beta[i][j])
}

/// A variance or covariance of e_inf and St_c.
fn e_inf_st_c(law: &PairLaw, i: usize, j: usize) -> Option<f64> {
    Some(law.covariance?.e_inf_st_c?[i][j])
}

fn liquid(law: &PairLaw) -> String {
    law.liquid.as_deref().unwrap_or(DRY).to_owned()
}

const COLUMNS: [Column; 29] = [
    ("particle", |law| law.particle.clone()),
    ("liquid", liquid),
    ("diameter_m", |law| number(law.diameter_m)),
    ("film_m", |law| number(law.film_m)),
    ("film_ratio", |law| number(law.film_ratio)),
    ("law", |law| word(&law.law)),
    ("dry_k", |law| number(law.dry_k)),
    ("dry_k_se", |law| number(law.dry_k_se)),
    ("dry_order", |law| {
        law.dry_order.map(|order| order.to_string()).unwrap_or_default()
    }),
    ("inertial_loss", |law| number(law.inertial_loss)),
    ("alpha", |law| number(law.alpha)),
    ("beta_m_s", |law| number(law.beta)),
    ("kappa_m2_s2", |law| number(law.kappa)),
    ("threshold_speed_m_s", |law| number(law.threshold_speed_m_s)),
    ("e_inf", |law| number(law.e_inf)),
    ("st_c", |law| number(law.st_c)),
    ("stokes_per_m_s", |law| number(law.stokes_per_m_s)),
    ("alpha_se", |law| number(alpha_beta(law, 0, 0).map(f64::sqrt))),
    ("beta_se_m_s", |law| number(alpha_beta(law, 1, 1).map(f64::sqrt))),
    ("alpha_beta_covariance_m_s", |law| number(alpha_beta(law, 0, 1))),
    ("e_inf_se", |law| number(e_inf_st_c(law, 0, 0).map(f64::sqrt))),
    ("st_c_se", |law| number(e_inf_st_c(law, 1, 1).map(f64::sqrt))),
    ("e_inf_st_c_covariance", |law| number(e_inf_st_c(law, 0, 1))),
    ("min_speed_m_s", |law| number(law.speeds.map(|[slowest, _]| slowest))),
    ("max_speed_m_s", |law| number(law.speeds.map(|[_, fastest]| fastest))),
    ("min_stokes", |law| number(law.stokes.map(|[least, _]| least))),
    ("max_stokes", |law| number(law.stokes.map(|[_, most]| most))),
    ("source", |law| word(&law.source)),
    ("quotable", |law| law.quotable.to_string()),
];

const TABLE_COLUMNS: [&str; 8] = [
    "particle",
    "liquid",
    "diameter_m",
    "film_m",
    "impact_speed_m_s",
    "restitution",
    "restitution_q05",
    "restitution_q95",
];

/// The laws; names have no comma.
pub(super) fn laws(laws: &[PairLaw]) -> String {
    let lines = laws.iter().map(|law| COLUMNS.map(|(_, of)| of(law)));
    text(COLUMNS.map(|(name, _)| name), lines)
}

/// Their restitution at some speeds, where it is not √(α + β/v).
pub(super) fn table(laws: &[PairLaw]) -> String {
    let line = |law: &PairLaw, point: &LawPoint| {
        [
            law.particle.clone(),
            liquid(law),
            number(law.diameter_m),
            number(law.film_m),
            number(Some(point.impact_speed)),
            number(Some(point.restitution)),
            number(point.band.map(|[low, _]| low)),
            number(point.band.map(|[_, high]| high)),
        ]
    };
    let lines = laws
        .iter()
        .flat_map(|law| law.table.iter().map(move |point| line(law, point)));
    text(TABLE_COLUMNS, lines)
}

fn text<const N: usize>(names: [&str; N], lines: impl Iterator<Item = [String; N]>) -> String {
    let names = names.map(str::to_owned);
    std::iter::once(names)
        .chain(lines)
        .map(|cells| cells.join(",") + "\n")
        .collect()
}

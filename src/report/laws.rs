//! Writes the laws of a scene's pairs as CSV, a line a pair, at full precision and in SI.

use crate::findings::laws::{LawCovariance, LawPoint, PairLaw};
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

fn of_covariance(law: &PairLaw, of: impl Fn(&LawCovariance) -> Option<f64>) -> String {
    number(law.covariance.as_ref().and_then(of))
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
    ("law", |law| law.law.name().to_owned()),
    ("dry_k", |law| number(law.dry_k)),
    ("dry_k_se", |law| number(law.dry_k_se)),
    ("dry_order", |law| {
        law.dry_order.map_or(String::new(), |order| order.to_string())
    }),
    ("inertial_loss", |law| number(law.inertial_loss)),
    ("alpha", |law| number(law.alpha)),
    ("beta_m_s", |law| number(law.beta)),
    ("kappa_m2_s2", |law| number(law.kappa)),
    ("threshold_speed_m_s", |law| number(law.threshold_speed_m_s)),
    ("e_inf", |law| number(law.e_inf)),
    ("st_c", |law| number(law.st_c)),
    ("stokes_per_m_s", |law| number(law.stokes_per_m_s)),
    ("alpha_se", |law| {
        of_covariance(law, |of| Some(of.alpha_beta[0][0].sqrt()))
    }),
    ("beta_se_m_s", |law| {
        of_covariance(law, |of| Some(of.alpha_beta[1][1].sqrt()))
    }),
    ("alpha_beta_covariance_m_s", |law| {
        of_covariance(law, |of| Some(of.alpha_beta[0][1]))
    }),
    ("e_inf_se", |law| {
        of_covariance(law, |of| Some(of.e_inf_st_c?[0][0].sqrt()))
    }),
    ("st_c_se", |law| {
        of_covariance(law, |of| Some(of.e_inf_st_c?[1][1].sqrt()))
    }),
    ("e_inf_st_c_covariance", |law| {
        of_covariance(law, |of| Some(of.e_inf_st_c?[0][1]))
    }),
    ("min_speed_m_s", |law| number(law.speeds.map(|[slowest, _]| slowest))),
    ("max_speed_m_s", |law| number(law.speeds.map(|[_, fastest]| fastest))),
    ("min_stokes", |law| number(law.stokes.map(|[least, _]| least))),
    ("max_stokes", |law| number(law.stokes.map(|[_, most]| most))),
    ("source", |law| law.source.name().replace([' ', '-'], "_")),
    ("quotable", |law| law.quotable.to_string()),
];

/// The laws; names have no comma.
pub(super) fn laws(laws: &[PairLaw]) -> String {
    let names = COLUMNS.map(|(name, _)| name.to_owned());
    let lines = laws.iter().map(|law| COLUMNS.map(|(_, of)| of(law)));
    text(std::iter::once(names).chain(lines))
}

/// Their restitution at some speeds, where it is not √(α + β/v).
pub(super) fn table(laws: &[PairLaw]) -> String {
    let names = [
        "particle",
        "liquid",
        "diameter_m",
        "film_m",
        "impact_speed_m_s",
        "restitution",
        "restitution_q05",
        "restitution_q95",
    ];
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
    text(std::iter::once(names.map(str::to_owned)).chain(lines))
}

fn text<const N: usize>(lines: impl Iterator<Item = [String; N]>) -> String {
    lines.map(|cells| cells.join(",") + "\n").collect()
}

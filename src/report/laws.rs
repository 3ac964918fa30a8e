//! Writes the laws of a scene's pairs as CSV, a line a pair, at full precision and in SI.

use minijinja::{context, Value};

use super::template::{self, serialized, with};
use crate::error::Error;
use crate::findings::laws::PairLaw;

/// The laws, a line a pair.
pub(super) const LAWS: &str = "laws.csv";
/// Those that are not √(α + β/v) at some speeds, a line a speed.
pub(super) const TABLE: &str = "laws_table.csv";

/// Both files by their names; names of particles and liquids have no comma.
pub(super) fn files(laws: &[PairLaw]) -> Result<[(String, String); 2], Error> {
    let values = context! { laws => laws.iter().map(row).collect::<Vec<_>>() };
    let file = |name: &str| Ok((name.to_owned(), template::plain(name, &values)?));
    Ok([file(LAWS)?, file(TABLE)?])
}

fn row(law: &PairLaw) -> Value {
    let of_both = |both: Option<[[f64; 2]; 2]>| match both {
        Some([[first, covariance], [_, second]]) => [Some(first.sqrt()), Some(second.sqrt()), Some(covariance)],
        None => [None; 3],
    };
    let alpha_beta = law.covariance.map(|own| own.alpha_beta);
    let e_inf_st_c = law.covariance.and_then(|own| own.e_inf_st_c);
    let more = context! {
        errors => [of_both(alpha_beta), of_both(e_inf_st_c)].concat(),
        table => serialized(&law.table),
    };
    with(law, more)
}

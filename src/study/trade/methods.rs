//! Names the methods for the parameters, the cheapest kind first.

use crate::inference::prepared_posterior::{Evaluation, LARGEST_ERROR};
use crate::inference::sampling::Method;
use crate::model::likelihood::Resolution;
use crate::scene::WetLaw;

/// A method for the parameters.
#[derive(Debug, Clone, Copy)]
pub(super) enum TradedMethod {
    /// read off a law fitted by least squares
    Law(WetLaw),
    /// the normal about the posterior's mode
    Laplace,
    /// the same with importance weights
    LaplacePsis,
    /// trajectories
    Nuts(Evaluation),
}

impl TradedMethod {
    pub(super) const ALL: [TradedMethod; 10] = [
        TradedMethod::Law(WetLaw::Linear),
        TradedMethod::Law(WetLaw::Sqrt),
        TradedMethod::Laplace,
        TradedMethod::LaplacePsis,
        TradedMethod::Nuts(Evaluation::Compressed(Resolution::Nodes(4))),
        TradedMethod::Nuts(Evaluation::Compressed(Resolution::Nodes(8))),
        TradedMethod::Nuts(Evaluation::Compressed(Resolution::Nodes(12))),
        TradedMethod::Nuts(Evaluation::Compressed(Resolution::Nodes(16))),
        TradedMethod::Nuts(Evaluation::Compressed(Resolution::Bound(LARGEST_ERROR))),
        TradedMethod::Nuts(Evaluation::Rows),
    ];

    pub(super) fn name(self) -> String {
        match self {
            TradedMethod::Law(law) => law.name().to_owned(),
            TradedMethod::Laplace => Method::Laplace.name().to_owned(),
            TradedMethod::LaplacePsis => Method::LaplacePsis.name().to_owned(),
            TradedMethod::Nuts(Evaluation::Rows) => Method::NutsExact.name().to_owned(),
            TradedMethod::Nuts(Evaluation::Compressed(Resolution::Nodes(nodes))) => {
                format!("{}/{nodes}", Method::NutsCompressed.name())
            }
            TradedMethod::Nuts(Evaluation::Compressed(Resolution::Bound(_))) => {
                Method::NutsCompressed.name().to_owned()
            }
        }
    }
}

/// How many methods there are, the reference included.
pub const PATHS: u64 = 1 + TradedMethod::ALL.len() as u64;

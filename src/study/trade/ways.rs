//! Names the ways to the parameters, the cheapest kind first.

use crate::inference::posed::{Evaluation, LARGEST_ERROR};
use crate::inference::sampling::Method;
use crate::model::likelihood::Resolution;
use crate::scene::WetLaw;

/// A way to the parameters.
#[derive(Debug, Clone, Copy)]
pub(super) enum Path {
    /// read off a law fitted by least squares
    Law(WetLaw),
    /// the normal about the posterior's mode
    Laplace,
    /// the same with importance weights
    LaplacePsis,
    /// trajectories
    Nuts(Evaluation),
}

impl Path {
    pub(super) const ALL: [Path; 10] = [
        Path::Law(WetLaw::Linear),
        Path::Law(WetLaw::Sqrt),
        Path::Laplace,
        Path::LaplacePsis,
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(4))),
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(8))),
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(12))),
        Path::Nuts(Evaluation::Compressed(Resolution::Nodes(16))),
        Path::Nuts(Evaluation::Compressed(Resolution::Bound(LARGEST_ERROR))),
        Path::Nuts(Evaluation::Rows),
    ];

    pub(super) fn name(self) -> String {
        match self {
            Path::Law(law) => law.name().to_owned(),
            Path::Laplace => Method::Laplace.name().to_owned(),
            Path::LaplacePsis => Method::LaplacePsis.name().to_owned(),
            Path::Nuts(Evaluation::Rows) => Method::NutsExact.name().to_owned(),
            Path::Nuts(Evaluation::Compressed(Resolution::Nodes(nodes))) => {
                format!("{}/{nodes}", Method::NutsCompressed.name())
            }
            Path::Nuts(Evaluation::Compressed(Resolution::Bound(_))) => Method::NutsCompressed.name().to_owned(),
        }
    }
}

/// How many ways there are, the reference included.
pub const PATHS: u64 = 1 + Path::ALL.len() as u64;

//! Writes how runs were resampled for the intervals of the laws of single film ratios.

use super::super::ReportInput;
use super::page::Page;
use crate::findings::bootstrap::{Resampling, MOST_RESAMPLED};
use crate::findings::remarks::SERIES_SCHEME_CHANGES;
use crate::scene::ResamplingScheme;

/// The section; nothing where nothing was resampled.
pub(super) fn bootstrap(page: &mut Page, input: ReportInput) {
    let resampling = input.findings.bootstrap.as_ref();
    let Some(resampling) = resampling.filter(|own| own.by_sandwich || own.resampled_fits > 0) else {
        return;
    };
    let made = if resampling.by_sandwich {
        by_sandwich(resampling)
    } else {
        by_replicates(input.scene.bootstrap.scheme, resampling)
    };
    page.heading("Bootstrap");
    page.paragraph(&format!(
        "{made} `findings.json` has the intervals beside the delta method's, and the `method` of each that is quoted."
    ));
}

fn by_replicates(scheme: ResamplingScheme, resampling: &Resampling) -> String {
    let replicates = resampling.replicates;
    match scheme {
        ResamplingScheme::Cases => format!(
            "{replicates} replicates, n − 1 of n runs drawn inside each series and impact speed with the weight n/(n − 1)."
        ),
        ResamplingScheme::Series => format!(
            "{replicates} replicates, n − 1 of n series drawn with the weight n/(n − 1). That {SERIES_SCHEME_CHANGES}."
        ),
    }
}

/// What stands for replicates where runs are too many to be resampled.
fn by_sandwich(resampling: &Resampling) -> String {
    let rest = match resampling.resampled_fits {
        0 => String::new(),
        fits => format!(
            " {fits} fits of fewer runs were resampled, {} replicates each.",
            resampling.replicates
        ),
    };
    format!(
        "Of more than {MOST_RESAMPLED} runs the standard error is that of the sandwich covariance, which resampling inside \
         each series and impact speed tends to; the intervals are normal.{rest}"
    )
}

//! Counts over simulated data sets how often the interval of a number covers the truth.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::Serialize;

use crate::error::Error;
use crate::model::simulate::Simulation;
use crate::ranks::Ranks;
use crate::runs::{self, Runs};
use crate::scene::{self, Scene};
use crate::seed::stream;

/// The data sets that are drawn of each design, and who draws them.
#[derive(Clone, Copy)]
pub struct DrawnSets<'a> {
    /// how many a design
    pub sets: u64,
    /// seed of every use of chance
    pub seed: u64,
    /// the processes that share them
    pub ranks: &'a Ranks,
    /// called after each data set of this process
    pub progress: &'a (dyn Fn() + Sync),
}

impl DrawnSets<'_> {
    /// Of each number that data sets tell, how many quote an interval of it, and how many of these intervals cover the truth.
    /// A set tells `None` of a number that it does not quote, else whether the interval covers.
    pub(super) fn count_over_sets<Number>(
        &self,
        of_set: impl Fn(u64) -> Result<Vec<(Number, Option<bool>)>, Error> + Sync,
    ) -> Result<BTreeMap<Number, [u64; 2]>, Error>
    where
        Number: Ord + Send + Serialize + DeserializeOwned,
    {
        let told = |set| of_set(set).inspect(|_| (self.progress)());
        let each = self
            .ranks
            .gather(self.sets, |own| own.into_par_iter().map(told).collect())?;
        let mut counts: BTreeMap<Number, [u64; 2]> = BTreeMap::new();
        for (number, covers) in each.into_iter().flatten() {
            let [quoted, covered] = counts.entry(number).or_default();
            *quoted += u64::from(covers.is_some());
            *covered += u64::from(covers == Some(true));
        }
        Ok(counts)
    }
}

/// The runs of one data set, from the random stream of this name.
pub(super) fn draw(scene: &Scene, seed: u64, name: &'static str, set: u64) -> Result<Runs, Error> {
    let drawn = Simulation::new(scene, None)?.draw_from(stream(seed, name, set));
    Ok(runs::arrange(scene, &drawn))
}

/// Whether an interval covers a number.
pub(super) fn covers([lo, hi]: [f64; 2], truth: f64) -> bool {
    lo <= truth && truth <= hi
}

/// A design whose intervals are put to the test.
pub(super) struct CoverageDesign {
    pub name: &'static str,
    /// in words
    pub what: &'static str,
    pub diameter_mm: &'static str,
    /// the other lines of `[design]`
    pub design: &'static str,
    /// lines of `[truth]` in which designs differ
    pub truth: &'static str,
}

impl CoverageDesign {
    /// Its scene; `common` are the lines that all designs of a study have, `[truth]` the last section of them.
    pub(super) fn scene(&self, common: &str) -> Result<Scene, Error> {
        let text = format!(
            "title = \"{}\"\n[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n\
             {common}{}[design]\ndiameter_mm = {{ PTFE = [{}] }}\n{}",
            self.name, self.truth, self.diameter_mm, self.design
        );
        scene::parse(&text, Path::new("calibration/scene.toml"), String::new())
    }

    /// The line that explains it on a page.
    pub(super) fn explained(&self) -> String {
        format!("{}: {}", self.name, self.what)
    }
}

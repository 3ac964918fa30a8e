//! Holds what is said of the scatter of the runs against simulated runs whose scatter is known.

mod alarms;
mod growth;
mod outliers;
mod spreads;

use std::collections::BTreeMap;

use crate::common::scenes::{scene_of, AK10, PE, PTFE};
use crate::common::{normal, Place};
use wetcor::findings::noise::Noise;
use wetcor::findings::{self, Findings};
use wetcor::runs::{arrange, NewRun, Table};
use wetcor::scene::Scene;
use wetcor::seed::stream;

/// Two particles, two liquids, two film ratios, three diameters, five speeds clear of the threshold.
struct Design {
    model: &'static str,
    bootstrap: &'static str,
    particles: &'static [&'static str],
    films: &'static str,
    diameters: &'static str,
    speeds: &'static str,
    dry_speeds: &'static str,
    repeats: u32,
    /// sd of the truth's own noise on wet runs
    sigma: f64,
}

const USUAL: Design = Design {
    model: "inertia = \"stepwise\"",
    bootstrap: "",
    particles: &["PTFE", "PE"],
    films: "0.06, 0.1",
    diameters: "4.0, 5.0, 6.0",
    speeds: "1.8, 2.1, 2.4, 2.7, 3.0",
    dry_speeds: "0.4, 0.8, 1.2, 1.6, 2.0",
    repeats: 5,
    sigma: 1e-12,
};

/// One particle, film ratio and diameter.
const ONE_SERIES: Design = Design {
    particles: &["PE"],
    films: "0.06",
    diameters: "5.0",
    ..USUAL
};

/// What may be told of noise.
const ALARMS: [&str; 3] = ["outlier", "unequal_spread", "series_offsets"];

const SIGMA: f64 = 0.02;

impl Design {
    /// The scene. Its truth usually has no noise to speak of: a test adds its own.
    fn place(&self) -> Place {
        let each = |what: &str| -> String {
            let of = |name: &&str| format!("{name} = [{what}]");
            self.particles.iter().map(of).collect::<Vec<_>>().join(", ")
        };
        let text = format!(
            "[model]\n{}\n[bootstrap]\n{}\n\
             [truth]\ndry_k = {{ PTFE = 0.15, PE = 0.12 }}\nlubrication_log = 1.85\ninertia = \"stepwise\"\n\
             inertial_prefactor = 1.0\nsigma_dry = {}\nsigma_wet = {}\n\
             [design]\ndiameter_mm = {{ {} }}\nliquids = [\"AK10\", \"AK20\"]\nfilm_ratio = {{ {} }}\n\
             impact_speed_m_s = [{}]\ndry_impact_speed_m_s = [{}]\nrepeats = {}\n",
            self.model,
            self.bootstrap,
            0.5 * self.sigma,
            self.sigma,
            each(self.diameters),
            each(self.films),
            self.speeds,
            self.dry_speeds,
            self.repeats
        );
        let second = "[liquids.AK20]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 18.6\n";
        Place::new(&scene_of("noise", &[PTFE, PE, AK10, second, &text]))
    }
}

/// The same with normal noise whose sd each run is asked for.
fn scattered<'s>(exact: &[NewRun<'s>], seed: u64, sd: impl Fn(&NewRun) -> f64) -> Vec<NewRun<'s>> {
    let mut rng = stream(seed, "noise of a test", 0);
    let scatter = |run: &NewRun<'s>| {
        let z = normal(&mut rng);
        let mut run = *run;
        run.restitution = f64::max(run.restitution + sd(&run) * z, 0.0);
        run
    };
    exact.iter().map(scatter).collect()
}

fn plain(run: &NewRun) -> f64 {
    if run.liquid.is_some() {
        SIGMA
    } else {
        0.5 * SIGMA
    }
}

/// Fits them.
fn fit(scene: &Scene, runs: &[NewRun]) -> Findings {
    findings::fit_least_squares(scene, &Table::of(arrange(scene, runs)), 1, false)
}

fn noise_of(findings: &Findings) -> &Noise {
    findings.noise.as_ref().expect("a fit with scatter")
}

/// The name of a run's series; `None` for dry runs.
fn series_of(run: &NewRun) -> Option<String> {
    let (_, ratio) = run.film?;
    Some(format!("{} {:?} {:.6} {ratio}", run.particle, run.liquid, run.diameter))
}

/// Adds an offset to each series, normal of this sd.
fn offset(runs: &mut [NewRun], seed: u64, sd: f64) {
    let mut rng = stream(seed, "offsets of a test", 0);
    let mut known: BTreeMap<String, f64> = BTreeMap::new();
    for run in runs {
        let Some(name) = series_of(run) else { continue };
        run.restitution += *known.entry(name).or_insert_with(|| sd * normal(&mut rng));
    }
}

//! Integrates over a hidden number z, standard normal: the true impact speed of a run whose measured one errs, or of repeats
//! that share one.
//!
//! q = v_t/v = q̄ + s̄ z moves r(q). At a true speed the rebound speed is measured about m(r(q)) v_t with σ v_t and its own error,
//! of which the error of the impact speed, then known, explains a part where both are correlated: e = v_r/v is distributed about
//! M = m(r(q)) q + c (1 − q) with S² = σ² q² + (1 − ρ²) u², c = ρ u v/s. Whether a run sticks depends on its true speed alone.
//! Repeats of one true speed have one z, and their densities at it are multiplied: what their mean errs by is an error of all of
//! them. Of other films and diameters each has its own r(z).
//!
//! What a run adds at a z is `run_noise.rs`'s, or with noise on the energy kept `energy.rs`'s; where the nodes lie is `rule.rs`'s.

mod at_nodes;
mod gauss;
mod rule;

use self::gauss::has_converged;
use super::energy::over_energy;
use super::errors::Errors;
use super::run_density::{RunDensity, Seen};
use super::run_noise::{MeasuredRun, RunNoise};
use crate::distributions::LN_ROOT_TWO_PI;
use crate::physics::balance::{Balance, Impact};

/// Runs of one setting, with what is known of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct SettingRuns<'b> {
    pub balance: &'b Balance,
    /// at the measured speed of the first
    pub impact: Impact,
    /// at least one
    pub runs: &'b [MeasuredRun],
}

/// Runs of one true speed.
#[derive(Clone, Copy)]
pub(super) struct Hidden<'b> {
    pub noise: RunNoise,
    /// at least one
    pub settings: &'b [SettingRuns<'b>],
}

/// Slopes of a log density in what a setting keeps: in r, or in e_dry of dry runs, in −L and in k.
pub(super) type SettingSlopes = [f64; 3];

/// The logarithm falls by this much from its largest value to where the rest is nothing.
const FALL: f64 = 25.0;

/// Distance in z from where a probability is largest, beyond which nothing is left.
const REACH: f64 = 9.0;

/// Nodes of one call.
const MOST_NODES: usize = 16;

/// A number at each of these nodes.
type Column = [f64; MOST_NODES];

/// What a setting has at each node.
#[derive(Debug, Clone, Copy, Default)]
struct SettingNodes {
    /// r, or e_dry of dry runs
    kept: Column,
    /// 4/St
    over_stokes: Column,
    /// slope of what is kept in k
    slope_k: Column,
    /// slope of the logarithm in what is kept
    of_kept: Column,
}

/// What the integrand is at some nodes.
#[derive(Default)]
struct AtNodes {
    /// its logarithm, as a function of z
    ln: Column,
    /// slope of z along the path
    stretch: Column,
    /// what a node adds to the mass; of a bell the nodes on both sides follow one another
    parts: Column,
}

/// Sums over nodes, all divided by the exponential of a value that the logarithm of the integrand has near its largest.
struct Sums {
    reference: f64,
    /// mass, and slopes in σ, σ_r and the shape of the noise
    of: [f64; 4],
    /// slopes in what each setting keeps
    settings: Vec<SettingSlopes>,
    /// what each setting has at the nodes that were asked for last
    at: Vec<SettingNodes>,
    /// what the integrand is there
    nodes: AtNodes,
    /// z of every node, with what it adds to the mass, where these are wanted
    trace: Option<Vec<[f64; 2]>>,
}

impl Sums {
    /// None yet, with room for so many settings.
    fn of(settings: usize) -> Sums {
        Sums {
            reference: f64::NEG_INFINITY,
            of: [0.0; 4],
            settings: vec![SettingSlopes::default(); settings],
            at: vec![SettingNodes::default(); settings],
            nodes: AtNodes::default(),
            trace: None,
        }
    }

    fn clear(&mut self) {
        self.reference = f64::NEG_INFINITY;
        self.of = [0.0; 4];
        self.settings.fill(SettingSlopes::default());
        self.trace.iter_mut().for_each(Vec::clear);
    }

    /// Makes this logarithm the reference where its exponential would else be beyond all numbers.
    fn refer_to(&mut self, ln: f64) {
        /// well below what overflows
        const MOST: f64 = 300.0;
        if ln > self.reference + MOST {
            self.scale((self.reference - ln).exp());
            self.reference = ln;
        }
    }

    /// The log density with its slopes, those of the settings by themselves.
    fn density(mut self) -> (RunDensity, Vec<SettingSlopes>) {
        let [mass, sigma, energy, shape] = self.of;
        self.scale(1.0 / mass);
        let all = RunDensity {
            value: self.reference + mass.ln() - LN_ROOT_TWO_PI,
            sigma: sigma / mass,
            energy: energy / mass,
            shape: shape / mass,
            ..RunDensity::default()
        };
        (all, self.settings)
    }

    fn scale(&mut self, factor: f64) {
        let each = self.of.iter_mut().chain(self.settings.iter_mut().flatten());
        let traced = self.trace.iter_mut().flatten().map(|[_, part]| part);
        each.chain(traced).for_each(|sum| *sum *= factor);
    }
}

impl SettingRuns<'_> {
    /// The true speed over the measured one of the first run, which impacts are counted from.
    #[inline(always)]
    fn ratio(&self, z: f64) -> f64 {
        self.runs[0].errors.ratio(z)
    }

    fn at(&self, z: f64) -> Impact {
        self.balance.at_speed_ratio(&self.impact, self.ratio(z))
    }

    /// r.
    fn kept(&self, z: f64) -> f64 {
        self.balance.kept(&self.at(z)).0
    }

    /// dr/dz.
    fn kept_slope(&self, z: f64) -> f64 {
        self.balance.in_log_speed(&self.at(z))[0] * self.runs[0].errors.true_speed.sd / self.ratio(z)
    }

    /// The same setting with these of its runs.
    fn with<'r>(&self, runs: &'r [MeasuredRun]) -> SettingRuns<'r>
    where
        Self: 'r,
    {
        // speeds are as the mean of the true one over them
        let ratio = self.runs[0].errors.true_speed.mean / runs[0].errors.true_speed.mean;
        SettingRuns {
            balance: self.balance,
            impact: self.balance.at_speed_ratio(&self.impact, ratio),
            runs,
        }
    }
}

impl Hidden<'_> {
    /// The log density or probability, with slopes but for those in what is kept, which come setting by setting.
    pub fn integrate(&self) -> (RunDensity, Vec<SettingSlopes>) {
        let mut sums = Sums::of(self.settings.len());
        // an integral that stops before its end is none
        if !self.over_bell(&mut sums) && self.over_panels(&mut sums).is_none() {
            sums.of = [f64::NAN; 4];
        }
        sums.density()
    }

    /// The log density alone.
    pub fn value(&self) -> f64 {
        self.integrate().0.value
    }

    /// The log density of each run given the others, in their order: by the nodes of all runs where these do, else by an
    /// integral over the others.
    pub fn given_the_others(&self) -> Vec<f64> {
        let mut sums = Sums {
            trace: Some(vec![]),
            ..Sums::of(self.settings.len())
        };
        let is_bell = self.over_bell(&mut sums);
        if !is_bell && self.over_panels(&mut sums).is_none() {
            return vec![f64::NAN; self.runs().count()];
        }
        let (mass, trace) = (sums.of[0], sums.trace.take().unwrap_or_default());
        let all = sums.density().0.value;
        let mut found = vec![];
        for setting in self.settings {
            let kept: Vec<f64> = trace.iter().map(|[z, _]| setting.kept(*z)).collect();
            for run in setting.runs {
                let own = trace.iter().zip(&kept);
                let own: Vec<f64> = own
                    .map(|([z, _], kept)| self.density_at(run, *kept, *z).value)
                    .collect();
                let by_nodes = over_own(&trace, &own, is_bell).map(|others| mass.ln() - others);
                found.push(by_nodes.unwrap_or_else(|| all - self.without(found.len())));
            }
        }
        found
    }

    /// Every run, setting by setting.
    fn runs(&self) -> impl Iterator<Item = &MeasuredRun> + Clone {
        self.settings.iter().flat_map(|setting| setting.runs)
    }

    /// The log density of all runs but one.
    fn without(&self, place: usize) -> f64 {
        let mut first = 0;
        let others = self.settings.iter().map(|setting| {
            let mut runs = setting.runs.to_vec();
            if (first..first + runs.len()).contains(&place) {
                runs.remove(place - first);
            }
            first += setting.runs.len();
            runs
        });
        let others: Vec<Vec<MeasuredRun>> = others.collect();
        let settings = self.settings.iter().zip(&others).filter(|(_, runs)| !runs.is_empty());
        let settings: Vec<SettingRuns> = settings.map(|(setting, runs)| setting.with(runs)).collect();
        if settings.is_empty() {
            return 0.0;
        }
        let others = Hidden {
            settings: &settings,
            ..*self
        };
        others.value()
    }

    /// What a run adds at a z, whose setting keeps this there.
    fn density_at(&self, run: &MeasuredRun, kept: f64, z: f64) -> RunDensity {
        let errors = run.errors;
        let ratio = errors.ratio(z);
        if !self.noise.acts_on_energy(kept) {
            return self.noise.density(run, kept, ratio);
        }
        let of_true = |e: f64| (e - errors.shared() * (1.0 - ratio)) / ratio;
        let (seen, stretch) = match run.seen {
            Seen::Rebound(e) => (Seen::Rebound(of_true(e)), ratio.ln()),
            Seen::Measured(side, e) => (Seen::Measured(side, of_true(e)), 0.0),
            Seen::On(..) => (run.seen, 0.0),
        };
        let known = MeasuredRun {
            seen,
            errors: Errors {
                restitution: errors.variance(0.0).sqrt() / ratio,
                ..Errors::NONE
            },
        };
        let of = over_energy(self.noise, kept, &known);
        RunDensity {
            value: of.value - stretch,
            ..of
        }
    }

    /// The log density of one run by itself, with its slopes. No part of what calls it, so that runs of which
    /// nothing is hidden wait for none of it.
    #[inline(never)]
    pub fn of_run(noise: RunNoise, at: (&Balance, Impact), run: &MeasuredRun) -> RunDensity {
        let (balance, impact) = at;
        let hidden = Hidden {
            noise,
            settings: &[SettingRuns {
                balance,
                impact,
                runs: std::slice::from_ref(run),
            }],
        };
        let (of, slopes) = hidden.integrate();
        let [kept, viscous, dry_k] = slopes[0];
        RunDensity {
            kept,
            viscous,
            dry_k,
            ..of
        }
    }
}

/// The logarithm of the mass of all runs but one, whose own log density at the nodes is this: their integrand is that of all
/// over its density. `None` where the nodes do not do for that.
fn over_own(trace: &[[f64; 2]], own: &[f64], is_bell: bool) -> Option<f64> {
    /// what one of the outermost nodes may have of the mass
    const NOTHING: f64 = 1e-10;
    let least = own.iter().copied().fold(f64::INFINITY, f64::min);
    let others = trace.iter().zip(own).map(|([_, part], own)| part * (least - own).exp());
    let others: Vec<f64> = others.collect();
    let mass: f64 = others.iter().sum();
    let does = if is_bell {
        has_converged(others.as_chunks().0)
    } else {
        let by_z = |a: &(&[f64; 2], &f64), b: &(&[f64; 2], &f64)| a.0[0].total_cmp(&b.0[0]);
        let nodes = || trace.iter().zip(&others);
        let ends = [nodes().min_by(by_z), nodes().max_by(by_z)];
        ends.into_iter().flatten().all(|(_, part)| *part < NOTHING * mass)
    };
    does.then(|| mass.ln() - least)
}

#[cfg(test)]
mod tests;

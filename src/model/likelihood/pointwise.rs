//! Computes what each run contributes to the log likelihood, its expected restitution, and a new draw of it.

mod at_draws;

pub use at_draws::AtDraws;

use std::ops::Range;
use std::sync::OnceLock;

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::errors::{Errors, RunErrors};
use super::hidden::Hidden;
use super::normal::normal_score;
use super::run_density::{Seen, Side, Spreads};
use super::run_law::RunImpact;
use super::run_noise::RunNoise;
use super::shared_speed::SharedRuns;
use super::tails::Tails;
use super::trend::{middle_film_ratio, FilmParameters};
use crate::model::parameters::{offset_slot, ParameterKind, COMMON_SLOTS, SHAPE_SLOT};
use crate::physics::balance::{Balance, Impact};
use crate::physics::loss::Share;
use crate::physics::{rebound, Form};
use crate::runs::{Conditions, Runs};
use crate::scene::{LikelihoodFamily, NoiseOn, Scene, Sticking};

/// The runs of a scene, in the order of [`Runs`], ready for one run at a time.
#[derive(Debug)]
pub struct Pointwise<'r> {
    form: Form,
    limit: f64,
    /// whether runs that stuck were not logged
    truncated: bool,
    /// whether noise acts on the energy kept, too
    both: bool,
    /// what distribution noise has
    family: LikelihoodFamily,
    /// runs of one setting that follow one another share an entry
    settings: Vec<RunSetting>,
    /// the setting of each run
    setting: Vec<u32>,
    /// runs without a liquid, which come first
    dry: usize,
    stuck: Vec<bool>,
    runs: &'r Runs,
    /// of the measurement of each run
    errors: Option<RunErrors>,
    /// runs that share a true speed, by their settings
    shared: Vec<SharedRuns<usize>>,
}

/// What a run's restitution depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RunSetting {
    sphere: usize,
    impact: Impact,
    wet: Option<WetConditions>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct WetConditions {
    density_ratio: f64,
    film_ratio: f64,
    /// its logarithm over the middle one of the runs
    ln_film: f64,
    /// place in a full vector of the offset of its series, where series have one
    offset: Option<usize>,
}

/// The law at one full vector of parameters, for runs of some settings that follow one another.
#[derive(Debug, Clone)]
pub struct EvaluatedLaw<'p, 'r> {
    pointwise: &'p Pointwise<'r>,
    /// the first of the settings
    first: usize,
    /// mean of e* at each setting
    means: Vec<f64>,
    /// the energy balance of each setting
    balances: Vec<Balance>,
    noise: Noise,
    /// log density of each run given those that share its true speed, where some do
    given_the_others: OnceLock<Vec<f64>>,
}

/// The noise of all runs at one full vector of parameters.
#[derive(Debug, Clone, Copy)]
struct Noise {
    tails: Tails,
    dry: NoiseSd,
    wet: NoiseSd,
    /// σ_r, where noise acts on the energy kept, too
    energy: Option<f64>,
}

/// A spread with its logarithm.
#[derive(Debug, Clone, Copy)]
struct NoiseSd {
    sigma: f64,
    ln: f64,
}

impl NoiseSd {
    fn of(sigma: f64) -> NoiseSd {
        NoiseSd { sigma, ln: sigma.ln() }
    }
}

/// Whether the density of a run is an integral: over the noise on the energy kept, or over the true impact speed.
pub fn is_integrated(scene: &Scene, runs: &Runs) -> bool {
    runs.errors.is_some() || scene.model.noise == NoiseOn::Both
}

impl<'r> Pointwise<'r> {
    /// The runs under this form of the energy balance.
    pub fn new(scene: &Scene, runs: &'r Runs, form: Form) -> Pointwise<'r> {
        let mut pointwise = Pointwise {
            form,
            limit: scene.data.smallest_restitution,
            truncated: scene.model.sticking == Sticking::Truncated,
            both: scene.model.noise == NoiseOn::Both,
            family: scene.model.likelihood,
            settings: vec![],
            setting: Vec::with_capacity(runs.len()),
            dry: 0,
            stuck: Vec::with_capacity(runs.len()),
            runs,
            errors: RunErrors::of(scene, runs),
            shared: vec![],
        };
        let conditions = Conditions::new(scene, runs, form);
        for group in &runs.dry {
            for run in group.rebounds.start..group.stuck.end {
                let setting = RunSetting {
                    sphere: group.sphere,
                    impact: conditions.dry(run),
                    wet: None,
                };
                pointwise.add(setting, group.stuck.contains(&run));
            }
        }
        pointwise.dry = pointwise.len();
        let middle = middle_film_ratio(runs);
        // neighbours mostly share a film ratio
        let mut film = (f64::NAN, f64::NAN);
        for (index, series) in runs.series.iter().enumerate() {
            let offset = scene.model.series_offsets.then(|| offset_slot(runs, index));
            let density_ratio = series.density_ratio(scene);
            for run in series.runs() {
                let film_ratio = runs.impacts.film_ratio[run];
                if film.0 != film_ratio {
                    film = (film_ratio, (film_ratio / middle).ln());
                }
                let setting = RunSetting {
                    sphere: series.sphere,
                    impact: conditions.wet(run),
                    wet: Some(WetConditions {
                        density_ratio,
                        film_ratio,
                        ln_film: film.1,
                        offset,
                    }),
                };
                pointwise.add(setting, series.stuck.contains(&run));
            }
        }
        if let Some(errors) = &pointwise.errors {
            let setting = |run: usize| pointwise.setting[run] as usize;
            let place = |run: usize| Some((setting(run), pointwise.settings[setting(run)].impact));
            pointwise.shared = errors.shared_runs(scene, runs, place);
        }
        pointwise
    }

    fn add(&mut self, setting: RunSetting, stuck: bool) {
        if self.settings.last() != Some(&setting) {
            self.settings.push(setting);
        }
        // runs are counted in 32 bits where they are read
        self.setting
            .push(u32::try_from(self.settings.len() - 1).unwrap_or(u32::MAX));
        self.stuck.push(stuck);
    }

    /// Runs.
    pub fn len(&self) -> usize {
        self.stuck.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.stuck.is_empty()
    }

    /// Whether a run's density is an integral over what is hidden of it.
    pub fn is_integrated(&self) -> bool {
        self.errors.is_some() || self.both
    }

    /// Whether a run stuck.
    pub fn is_stuck(&self, run: usize) -> bool {
        self.stuck[run]
    }

    /// The energy balance at each setting in turn.
    fn balances<'f>(&'f self, full: &'f [f64]) -> impl FnMut(&RunSetting) -> Balance + 'f {
        // neighbours mostly share a film ratio, and an exponential costs more than the rest
        let mut film: Option<(f64, Share)> = None;
        let parameters = FilmParameters::new(self.form, full);
        move |setting| {
            let k = full[COMMON_SLOTS + setting.sphere];
            let Some(wet) = setting.wet else {
                return Balance::dry(self.form.dry, k);
            };
            let share = match film {
                Some((ratio, share)) if ratio == wet.film_ratio => share,
                _ => {
                    let new = parameters.share(wet.film_ratio, wet.ln_film);
                    film.insert((wet.film_ratio, new)).1
                }
            };
            let balance = Balance::at(self.form, k, share, wet.density_ratio);
            wet.offset.map_or(balance, |slot| balance.with_offset(full[slot]))
        }
    }

    /// The law at a full vector of parameters.
    pub fn at<'p>(&'p self, full: &[f64]) -> EvaluatedLaw<'p, 'r> {
        self.at_settings(full, self.noise(full), 0..self.settings.len())
    }

    /// The same for the runs of some settings, with the noise at these parameters.
    fn at_settings<'p>(&'p self, full: &[f64], noise: Noise, settings: Range<usize>) -> EvaluatedLaw<'p, 'r> {
        let first = settings.start;
        let settings = &self.settings[settings];
        let balances: Vec<Balance> = settings.iter().map(self.balances(full)).collect();
        let mean = |(setting, balance): (&RunSetting, &Balance)| match setting.wet {
            None => balance.e_dry(setting.impact.dry_root)[0],
            Some(_) => rebound::mean_restitution(balance.kept(&setting.impact).0),
        };
        EvaluatedLaw {
            pointwise: self,
            first,
            means: settings.iter().zip(&balances).map(mean).collect(),
            balances,
            noise,
            given_the_others: OnceLock::new(),
        }
    }

    fn noise(&self, full: &[f64]) -> Noise {
        let of = |kind: ParameterKind| full[kind.slot()];
        Noise {
            tails: Tails::of(self.family, full[SHAPE_SLOT]),
            dry: NoiseSd::of(of(ParameterKind::SigmaDry)),
            wet: NoiseSd::of(of(ParameterKind::SigmaWet)),
            energy: self.both.then(|| of(ParameterKind::SigmaEnergy)),
        }
    }
}

impl EvaluatedLaw<'_, '_> {
    fn spread(&self, run: usize) -> NoiseSd {
        if run < self.pointwise.dry {
            self.noise.dry
        } else {
            self.noise.wet
        }
    }

    /// The place of a run's setting among those of the law.
    fn place(&self, run: usize) -> usize {
        self.pointwise.setting[run] as usize - self.first
    }

    fn mean_and_spread(&self, run: usize) -> (f64, NoiseSd) {
        (self.means[self.place(run)], self.spread(run))
    }

    /// σ_r, where noise acts on the energy this run keeps, too.
    fn energy(&self, run: usize) -> Option<f64> {
        self.noise.energy.filter(|_| run >= self.pointwise.dry)
    }

    fn impact(&self, run: usize) -> Impact {
        self.pointwise.settings[self.pointwise.setting[run] as usize].impact
    }

    /// What a run's measurement errs by; nothing where no run's does.
    fn errors_of(&self, run: usize) -> Errors {
        let runs = self.pointwise.runs;
        let errors = self.pointwise.errors.as_ref();
        errors.map_or(Errors::NONE, |errors| errors.at(run, runs.impact_speed[run]))
    }

    fn run_noise(&self, run: usize) -> RunNoise {
        RunNoise {
            tails: self.noise.tails,
            spreads: Spreads {
                sigma: self.spread(run).sigma,
                energy: self.energy(run).unwrap_or(0.0),
            },
            wet: run >= self.pointwise.dry,
        }
    }

    /// Log density or probability of what is known of a run, integrated over what is hidden of it.
    fn integrated(&self, run: usize, seen: Seen) -> f64 {
        let at = RunImpact {
            balance: &self.balances[self.place(run)],
            impact: self.impact(run),
            errors: self.errors_of(run),
        };
        at.density(self.run_noise(run), seen).value
    }

    /// What is known of a run: its restitution, or that it stuck.
    fn seen(&self, run: usize) -> Seen {
        if self.pointwise.stuck[run] {
            Seen::On(Side::Below, self.pointwise.limit)
        } else {
            Seen::Rebound(self.pointwise.runs.restitution[run])
        }
    }

    /// Gives runs that share a true speed to a function of their integral.
    fn hidden<T>(&self, shared: &SharedRuns<usize>, of: impl FnOnce(Hidden) -> T) -> T {
        let first = &shared.settings[0];
        let balances: Vec<&Balance> = shared.settings.iter().map(|of| &self.balances[of.place]).collect();
        shared.hidden(self.run_noise(first.runs[0]), &balances, of)
    }

    /// Log density of each run given those that share its true speed; 0 of a run that shares it with none.
    fn given_the_others(&self) -> &[f64] {
        self.given_the_others.get_or_init(|| {
            let mut found = vec![0.0; self.pointwise.len()];
            for shared in &self.pointwise.shared {
                let each = self.hidden(shared, |hidden| hidden.given_the_others());
                let runs = shared.settings.iter().flat_map(|of| &of.runs);
                for (run, own) in runs.zip(each) {
                    found[*run] += shared.sign * own;
                }
            }
            found
        })
    }

    /// z of a restitution, of which `seen` says what is asked; where it is integrated over what is hidden of the run, the z
    /// of as large a normal probability.
    fn score(&self, run: usize, restitution: f64, seen: fn(Side, f64) -> Seen) -> f64 {
        if !self.pointwise.is_integrated() {
            let (mean, spread) = self.mean_and_spread(run);
            return (restitution - mean) / spread.sigma;
        }
        let on = |side: Side| self.integrated(run, seen(side, restitution));
        normal_score(on(Side::Below), on(Side::Above))
    }

    /// The tails of [`EvaluatedLaw::z`].
    pub fn tails(&self) -> Tails {
        if self.pointwise.is_integrated() {
            Tails::Normal
        } else {
            self.noise.tails
        }
    }

    /// By how many spreads the smallest restitution that is a rebound lies above the mean: F of it is the probability of
    /// sticking. Where stuck runs were not logged, that of a run not being there.
    pub fn limit_z(&self, run: usize) -> f64 {
        self.score(run, self.pointwise.limit, Seen::On)
    }

    /// By how many spreads a measured restitution lies above the mean.
    pub fn z(&self, run: usize, restitution: f64) -> f64 {
        self.score(run, restitution, Seen::Measured)
    }

    /// Mean of e* and its spread σ: m(r) and σ_wet, or e_dry and σ_dry.
    pub fn mean_and_sigma(&self, run: usize) -> (f64, f64) {
        let (mean, spread) = self.mean_and_spread(run);
        (mean, spread.sigma)
    }

    /// Log likelihood of a run: a density where it rebounded, a probability where it stuck; given the other runs where some
    /// share its true speed.
    pub fn ln_likelihood(&self, run: usize) -> f64 {
        if self.errors_of(run).is_shared {
            self.given_the_others()[run]
        } else {
            self.ln_likelihood_alone(run)
        }
    }

    /// The same of a run that shares its true speed with none.
    fn ln_likelihood_alone(&self, run: usize) -> f64 {
        let restitution = self.pointwise.runs.restitution[run];
        if self.pointwise.is_integrated() {
            let density = self.integrated(run, self.seen(run));
            return if self.pointwise.truncated && !self.pointwise.stuck[run] {
                density - self.integrated(run, Seen::On(Side::Above, self.pointwise.limit))
            } else {
                density
            };
        }
        let tails = self.noise.tails;
        let ln_below = |z| tails.ln_probability_and_slope(z).0;
        if self.pointwise.stuck[run] {
            return ln_below(self.limit_z(run));
        }
        let density = tails.ln_unit_density(self.z(run, restitution)) - self.spread(run).ln;
        if self.pointwise.truncated {
            density - ln_below(-self.limit_z(run))
        } else {
            density
        }
    }

    /// Log likelihood of some runs together, of which none shares its true speed with another one.
    pub fn ln_likelihood_of(&self, runs: Range<usize>) -> f64 {
        let alone = runs.clone().filter(|run| !self.errors_of(*run).is_shared);
        let alone: f64 = alone.map(|run| self.ln_likelihood(run)).sum();
        let shared = self.pointwise.shared.iter();
        let together = shared.filter(|shared| runs.contains(&shared.settings[0].runs[0]));
        let together = together.map(|shared| shared.sign * self.hidden(shared, |hidden| hidden.value()));
        alone + together.sum::<f64>()
    }

    /// Whether runs that stuck were not logged.
    pub fn is_truncated(&self) -> bool {
        self.pointwise.truncated
    }

    /// A new draw of every run's restitution, as [`EvaluatedLaw::predict`] gives.
    pub fn predictions<R: Rng + ?Sized>(&self, rng: &mut R) -> Vec<f64> {
        (0..self.pointwise.len()).map(|run| self.predict(run, rng)).collect()
    }

    /// A new draw of a run's restitution, as it would be measured; 0 where it would have stuck. Where stuck runs were not
    /// logged, of one that rebounds.
    pub fn predict<R: Rng + ?Sized>(&self, run: usize, rng: &mut R) -> f64 {
        let mut draw = || self.draw(run, rng);
        let mut e = draw();
        if self.pointwise.truncated {
            /// a run that hardly ever rebounds is given up after so many
            const MOST_TRIES: usize = 10_000;
            for _ in 0..MOST_TRIES {
                if e > self.pointwise.limit {
                    break;
                }
                e = draw();
            }
        }
        if e <= self.pointwise.limit {
            0.0
        } else {
            e
        }
    }

    /// A new draw of e* as it would be measured. Where the impact speed errs, at a true speed drawn from what is known of
    /// it, and measured with the impact speed that the run has.
    fn draw<R: Rng + ?Sized>(&self, run: usize, rng: &mut R) -> f64 {
        let (mean, sigma) = self.mean_and_sigma(run);
        let noise = sigma * self.noise.tails.draw(rng);
        if !self.pointwise.is_integrated() {
            return mean + noise;
        }
        let errors = self.errors_of(run);
        let mut normal = |sd: f64| {
            if sd > 0.0 {
                let z: f64 = StandardNormal.sample(rng);
                sd * z
            } else {
                0.0
            }
        };
        let (balance, mut at) = (&self.balances[self.place(run)], self.impact(run));
        let mut ratio = 1.0;
        if errors.speed > 0.0 {
            ratio = (errors.true_speed.mean + normal(errors.true_speed.sd)).max(0.01);
            at = balance.at_speed_ratio(&at, ratio);
        }
        let mean = if run < self.pointwise.dry {
            balance.e_dry(at.dry_root)[0]
        } else {
            let lucky = normal(self.energy(run).unwrap_or(0.0));
            rebound::mean_restitution(balance.kept(&at).0 + lucky)
        };
        let e = mean + noise;
        if e <= self.pointwise.limit {
            return e;
        }
        let own = errors.restitution * (1.0 - errors.correlation * errors.correlation).sqrt();
        // never written as less than what is a rebound
        (e * ratio + errors.shared() * (1.0 - ratio) + normal(own)).max(self.pointwise.limit)
    }
}

//! Computes what each run contributes to the log likelihood, its expected restitution, and a new draw of it.

mod by_run;
mod columns;

pub use by_run::AtDraws;
pub use columns::Stretch;

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::errors::{Errors, MeanKept};
use super::placed::{place_dry, place_restitution, EnergyScale, Spreads};
use super::tails::Tails;
use super::trend::{middle_film_ratio, FilmParameters};
use crate::model::parameters::{offset_slot, ParameterKind, COMMON_SLOTS};
use crate::physics::balance::{Balance, Impact};
use crate::physics::loss::Share;
use crate::physics::{rebound, Form};
use crate::runs::{Conditions, MeasurementErrors, Runs};
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
    /// whether noise has Student's tails
    student: bool,
    /// runs of one setting that follow one another share an entry
    settings: Vec<RunSetting>,
    /// the setting of each run
    setting: Vec<u32>,
    /// runs without a liquid, which come first
    dry: usize,
    stuck: Vec<bool>,
    runs: &'r Runs,
    /// of the measurement of each run
    errors: Option<MeasurementErrors>,
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

/// The law at one full vector of parameters.
#[derive(Debug, Clone)]
pub struct EvaluatedLaw<'p, 'r> {
    pointwise: &'p Pointwise<'r>,
    /// mean of e* at each setting
    means: Vec<f64>,
    /// of each setting, where runs have errors of their own
    speed_slopes: Vec<SpeedSlope>,
    tails: Tails,
    dry: NoiseSd,
    wet: NoiseSd,
    /// σ_r, where noise acts on the energy kept, too
    energy: Option<f64>,
}

/// How the energy kept at a setting changes with the impact speed.
#[derive(Debug, Clone, Copy)]
struct SpeedSlope {
    /// v dr/dv; 0 of a dry run
    in_log_speed: f64,
    /// k of the sphere
    dry_k: f64,
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

/// How far a restitution lies from what a run is expected to have, on the scale its noise is symmetric on.
#[derive(Debug, Clone, Copy)]
struct Deviation {
    distance: f64,
    /// S on that scale, with the logarithm of S on the restitution's
    spread: NoiseSd,
}

impl Deviation {
    fn z(&self) -> f64 {
        self.distance / self.spread.sigma
    }
}

impl<'r> Pointwise<'r> {
    /// The runs under this form of the energy balance.
    pub fn new(scene: &Scene, runs: &'r Runs, form: Form) -> Pointwise<'r> {
        let mut pointwise = Pointwise {
            form,
            limit: scene.data.smallest_restitution,
            truncated: scene.model.sticking == Sticking::Truncated,
            both: scene.model.noise == NoiseOn::Both,
            student: scene.model.likelihood == LikelihoodFamily::Student,
            settings: vec![],
            setting: Vec::with_capacity(runs.len()),
            dry: 0,
            stuck: Vec::with_capacity(runs.len()),
            runs,
            errors: runs.errors_with_medians(),
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

    /// Whether runs depend on their mean and on one of two spreads alone, with normal noise and no run left unlogged.
    fn is_plain(&self) -> bool {
        self.errors.is_none() && !self.both && !self.truncated && !self.student
    }

    /// Whether a run stuck.
    pub fn is_stuck(&self, run: usize) -> bool {
        self.stuck[run]
    }

    /// The mean of e* at each setting in turn.
    fn means<'f>(&'f self, full: &'f [f64]) -> impl FnMut(&RunSetting) -> f64 + 'f {
        let mut balance = self.balances(full);
        move |setting| {
            let balance = balance(setting);
            match setting.wet {
                None => balance.e_dry(setting.impact.dry_root)[0],
                Some(_) => rebound::mean_restitution(balance.kept(&setting.impact).0),
            }
        }
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

    /// How the energy kept changes with the speed at each setting; none where no run has errors of its own.
    fn speed_slopes(&self, full: &[f64]) -> Vec<SpeedSlope> {
        if self.errors.is_none() {
            return vec![];
        }
        let mut balance = self.balances(full);
        let of = |setting: &RunSetting| {
            let balance = balance(setting);
            // per 1/v: runs of one setting may differ in v where the dry speed is held
            SpeedSlope {
                in_log_speed: setting.wet.map_or(0.0, |_| balance.in_log_speed(&setting.impact)[0]),
                dry_k: balance.dry_k,
            }
        };
        self.settings.iter().map(of).collect()
    }

    /// Whether a run that stuck is as good as certain to, where its limit lies between these z.
    ///
    /// With Student's tails none is.
    pub fn is_certain(&self, (lo, hi): (f64, f64), same: f64) -> bool {
        let ln = |z| Tails::Normal.ln_probability_and_slope(z).0;
        !self.student && ln(hi) - ln(lo) <= same
    }

    /// The law at a full vector of parameters.
    pub fn at<'p>(&'p self, full: &[f64]) -> EvaluatedLaw<'p, 'r> {
        EvaluatedLaw {
            means: self.settings.iter().map(self.means(full)).collect(),
            ..self.without_means(full)
        }
    }

    /// The law but for what each setting has.
    fn without_means<'p>(&'p self, full: &[f64]) -> EvaluatedLaw<'p, 'r> {
        let of = |kind: ParameterKind| full[kind.slot()];
        EvaluatedLaw {
            pointwise: self,
            means: vec![],
            speed_slopes: self.speed_slopes(full),
            tails: Tails::of(self.student.then(|| of(ParameterKind::Nu))),
            dry: NoiseSd::of(of(ParameterKind::SigmaDry)),
            wet: NoiseSd::of(of(ParameterKind::SigmaWet)),
            energy: self.both.then(|| of(ParameterKind::SigmaEnergy)),
        }
    }
}

impl EvaluatedLaw<'_, '_> {
    fn spread(&self, run: usize) -> NoiseSd {
        if run < self.pointwise.dry {
            self.dry
        } else {
            self.wet
        }
    }

    fn mean_and_spread(&self, run: usize) -> (f64, NoiseSd) {
        (self.means[self.pointwise.setting[run] as usize], self.spread(run))
    }

    /// σ_r, where noise acts on the energy this run keeps, too.
    fn energy(&self, run: usize) -> Option<f64> {
        self.energy.filter(|_| run >= self.pointwise.dry)
    }

    /// What the measurement of a run errs by; `None` where no run has any.
    fn errors(&self, run: usize) -> Option<Errors> {
        let runs = self.pointwise.runs;
        Errors::of(self.pointwise.errors.as_ref(), run, runs.impact_speed[run])
    }

    /// How far a restitution lies from what a run is expected to have; `measured` whether its own measurement errs.
    fn deviation(&self, run: usize, restitution: f64, measured: bool) -> Deviation {
        let (mean, spread) = self.mean_and_spread(run);
        let errors = self.errors(run);
        let energy = self.energy(run);
        if errors.is_none() && energy.is_none() {
            let distance = restitution - mean;
            return Deviation { distance, spread };
        }
        let errors = errors.unwrap_or_default();
        let (mean, variance, stretch, y) = match energy {
            Some(energy) => {
                let at = EnergyScale::of(restitution);
                let spreads = Spreads {
                    sigma: spread.sigma,
                    energy,
                };
                let errors = if measured { errors } else { errors.of_speed_alone() };
                let placed = at.place(spreads, self.mean_kept(run, errors), errors);
                (placed.mean, placed.variance, at.stretch, at.kept)
            }
            None => {
                let (mean, variance) = self.placed(run, errors, measured);
                (mean, variance, 1.0, restitution)
            }
        };
        Deviation {
            distance: y - mean,
            spread: NoiseSd {
                sigma: variance.sqrt(),
                ln: 0.5 * (variance / stretch).ln(),
            },
        }
    }

    /// What a wet run keeps on average.
    fn mean_kept(&self, run: usize, errors: Errors) -> MeanKept {
        let setting = self.pointwise.setting[run] as usize;
        let slopes = self.speed_slopes.get(setting);
        MeanKept {
            r: rebound::kept_of_mean_restitution(self.means[setting]),
            speed_slope: slopes.map_or(0.0, |slopes| slopes.in_log_speed * errors.slowness),
        }
    }

    /// Mean and S² of a run on the scale of the restitution.
    fn placed(&self, run: usize, errors: Errors, measured: bool) -> (f64, f64) {
        let (mean, NoiseSd { sigma, .. }) = self.mean_and_spread(run);
        let setting = self.pointwise.setting[run] as usize;
        let errors = if measured { errors } else { errors.of_speed_alone() };
        if run < self.pointwise.dry {
            let k = self.speed_slopes.get(setting).map_or(f64::NAN, |slopes| slopes.dry_k);
            let balance = Balance::dry(self.pointwise.form.dry, k);
            let root = self.pointwise.settings[setting].impact.dry_root;
            return (mean, place_dry(&balance, root, sigma, errors, measured).variance);
        }
        let placed = place_restitution(sigma, self.mean_kept(run, errors), errors, measured);
        (mean, placed.variance)
    }

    /// The tails of noise.
    pub fn tails(&self) -> Tails {
        self.tails
    }

    /// By how many spreads the smallest restitution that is a rebound lies above the mean: F of it is the probability of
    /// sticking. Where stuck runs were not logged, that of a run not being there.
    pub fn limit_z(&self, run: usize) -> f64 {
        let measured = self.pointwise.truncated && !self.pointwise.stuck[run];
        self.deviation(run, self.pointwise.limit, measured).z()
    }

    /// By how many spreads a measured restitution lies above the mean.
    pub fn z(&self, run: usize, restitution: f64) -> f64 {
        self.deviation(run, restitution, true).z()
    }

    /// Mean of e* and its spread σ: m(r) and σ_wet, or e_dry and σ_dry.
    pub fn mean_and_sigma(&self, run: usize) -> (f64, f64) {
        let (mean, spread) = self.mean_and_spread(run);
        (mean, spread.sigma)
    }

    /// Log likelihood of a run: a density where it rebounded, a probability where it stuck.
    pub fn ln_likelihood(&self, run: usize) -> f64 {
        let ln_below = |z| self.tails.ln_probability_and_slope(z).0;
        if self.pointwise.stuck[run] {
            return ln_below(self.limit_z(run));
        }
        let deviation = self.deviation(run, self.pointwise.runs.restitution[run], true);
        let density = self.tails.ln_unit_density(deviation.z()) - deviation.spread.ln;
        if self.pointwise.truncated {
            density - ln_below(-self.limit_z(run))
        } else {
            density
        }
    }

    /// Whether runs that stuck were not logged.
    pub fn is_truncated(&self) -> bool {
        self.pointwise.truncated
    }

    /// A new draw of a run's restitution, as it would be measured; 0 where it would have stuck. Where stuck runs were not
    /// logged, of one that rebounds.
    pub fn predict<R: Rng + ?Sized>(&self, run: usize, rng: &mut R) -> f64 {
        let (mean, mut sigma) = self.mean_and_sigma(run);
        if let Some(errors) = self.errors(run) {
            sigma = self.placed(run, errors, true).1.sqrt();
        }
        let energy = self
            .energy(run)
            .map(|energy| (rebound::kept_of_mean_restitution(mean), energy));
        let mut draw = || {
            let wide = self.tails.draw_scale(rng);
            let z: f64 = StandardNormal.sample(rng);
            let mean = energy.map_or(mean, |(kept, sigma)| {
                let lucky: f64 = StandardNormal.sample(rng);
                rebound::mean_restitution(kept + wide * sigma * lucky)
            });
            mean + wide * sigma * z
        };
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
}

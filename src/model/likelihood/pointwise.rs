//! Computes what each run contributes to the log likelihood, its expected restitution, and a new draw of it.

mod columns;

pub use columns::Stretch;

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use super::errors::Errors;
use super::placed::{place, place_dry, Energy, Spreads};
use super::tails::Tails;
use super::trend::{middle_film_ratio, Film};
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::physics::balance::{Balance, Impact};
use crate::physics::{rebound, Form};
use crate::runs::{Conditions, MeasurementErrors, Runs};
use crate::scene::{Likelihood, NoiseOn, Scene, Sticking};

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
    settings: Vec<Setting>,
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
struct Setting {
    particle: usize,
    impact: Impact,
    wet: Option<Wet>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Wet {
    density_ratio: f64,
    film_ratio: f64,
    /// its logarithm over the middle one of the runs
    ln_film: f64,
}

/// The law at one full vector of parameters.
#[derive(Debug, Clone)]
pub struct At<'p, 'r> {
    pointwise: &'p Pointwise<'r>,
    /// mean of e* at each setting
    means: Vec<f64>,
    /// v dr/dv at each setting and the k of its particle, where runs have errors of their own
    moved: Vec<(f64, f64)>,
    tails: Tails,
    dry: Spread,
    wet: Spread,
    /// σ_r, where noise acts on the energy kept, too
    energy: Option<f64>,
}

/// A spread with its logarithm.
#[derive(Debug, Clone, Copy)]
struct Spread {
    sigma: f64,
    ln: f64,
}

impl Spread {
    fn of(sigma: f64) -> Spread {
        Spread { sigma, ln: sigma.ln() }
    }
}

/// How a restitution lies beside what a run is expected to have, on the scale its noise is symmetric on.
#[derive(Debug, Clone, Copy)]
struct Beside {
    distance: f64,
    /// S on that scale, with the logarithm of S on the restitution's
    spread: Spread,
}

impl Beside {
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
            student: scene.model.likelihood == Likelihood::Student,
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
                let setting = Setting {
                    particle: group.particle,
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
        for series in &runs.series {
            let density_ratio = series.density_ratio(scene);
            for run in series.runs() {
                let film_ratio = runs.impacts.film_ratio[run];
                if film.0 != film_ratio {
                    film = (film_ratio, (film_ratio / middle).ln());
                }
                let setting = Setting {
                    particle: series.particle,
                    impact: conditions.wet(run),
                    wet: Some(Wet {
                        density_ratio,
                        film_ratio,
                        ln_film: film.1,
                    }),
                };
                pointwise.add(setting, series.stuck.contains(&run));
            }
        }
        pointwise
    }

    fn add(&mut self, setting: Setting, stuck: bool) {
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

    /// Whether a run stuck.
    pub fn is_stuck(&self, run: usize) -> bool {
        self.stuck[run]
    }

    /// The mean of e* at each setting asked for, in turn.
    fn means<'f>(&'f self, full: &'f [f64]) -> impl FnMut(&Setting) -> f64 + 'f {
        let mut balance = self.balances(full);
        move |setting| {
            let balance = balance(setting);
            match setting.wet {
                None => balance.e_dry(setting.impact.dry_root)[0],
                Some(_) => rebound::mean_restitution(balance.kept(&setting.impact).0),
            }
        }
    }

    /// The energy balance at each setting asked for, in turn.
    fn balances<'f>(&'f self, full: &'f [f64]) -> impl FnMut(&Setting) -> Balance + 'f {
        // neighbours mostly share a film ratio, and an exponential costs more than the rest
        let mut film: Option<(f64, Film)> = None;
        move |setting| {
            let k = full[COMMON_SLOTS + setting.particle];
            let Some(wet) = setting.wet else {
                return Balance::dry(self.form.dry, k);
            };
            let of_film = match film {
                Some((ratio, of_film)) if ratio == wet.film_ratio => of_film,
                _ => {
                    let new = Film::of(self.form, wet.film_ratio, wet.ln_film, full);
                    film.insert((wet.film_ratio, new)).1
                }
            };
            of_film.balance(self.form, k, wet.density_ratio)
        }
    }

    /// v dr/dv of each setting with its k; none where no run has errors of its own.
    fn moved(&self, full: &[f64]) -> Vec<(f64, f64)> {
        if self.errors.is_none() {
            return vec![];
        }
        let mut balance = self.balances(full);
        let of = |setting: &Setting| {
            let balance = balance(setting);
            // per 1/v: runs of one setting may differ in v where the dry speed is held
            let by_speed = setting.wet.map_or(0.0, |_| balance.in_log_speed(&setting.impact)[0]);
            (by_speed, balance.dry_k)
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
    pub fn at<'p>(&'p self, full: &[f64]) -> At<'p, 'r> {
        At {
            means: self.settings.iter().map(self.means(full)).collect(),
            ..self.without_means(full)
        }
    }

    /// The law but for what each setting has.
    fn without_means<'p>(&'p self, full: &[f64]) -> At<'p, 'r> {
        let of = |kind: Kind| full[kind.slot()];
        At {
            pointwise: self,
            means: vec![],
            moved: self.moved(full),
            tails: Tails::of(self.student.then(|| of(Kind::Nu))),
            dry: Spread::of(of(Kind::SigmaDry)),
            wet: Spread::of(of(Kind::SigmaWet)),
            energy: self.both.then(|| of(Kind::SigmaEnergy)),
        }
    }
}

impl At<'_, '_> {
    fn spread(&self, run: usize) -> Spread {
        if run < self.pointwise.dry {
            self.dry
        } else {
            self.wet
        }
    }

    fn mean_and_spread(&self, run: usize) -> (f64, Spread) {
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

    /// How a restitution lies beside what a run is expected to have; `measured` whether its own measurement errs.
    fn beside(&self, run: usize, restitution: f64, measured: bool) -> Beside {
        let (mean, spread) = self.mean_and_spread(run);
        let errors = self.errors(run);
        let energy = self.energy(run);
        if errors.is_none() && energy.is_none() {
            let distance = restitution - mean;
            return Beside { distance, spread };
        }
        let errors = errors.unwrap_or_default();
        let (mean, variance, stretch, y) = match energy {
            Some(energy) => {
                let at = Energy::of(restitution);
                let spreads = Spreads {
                    sigma: spread.sigma,
                    energy,
                };
                let errors = if measured { errors } else { errors.of_speed_alone() };
                let placed = at.place(spreads, self.kept_and_by_speed(run, errors), errors);
                (placed.mean, placed.variance, at.stretch, at.kept)
            }
            None => {
                let (mean, variance) = self.placed(run, errors, measured);
                (mean, variance, 1.0, restitution)
            }
        };
        Beside {
            distance: y - mean,
            spread: Spread {
                sigma: variance.sqrt(),
                ln: 0.5 * (variance / stretch).ln(),
            },
        }
    }

    /// r and dr/dv of a wet run.
    fn kept_and_by_speed(&self, run: usize, errors: Errors) -> (f64, f64) {
        let setting = self.pointwise.setting[run] as usize;
        let moved = self
            .moved
            .get(setting)
            .map_or(0.0, |(moved, _)| moved * errors.slowness);
        (rebound::kept_of_mean_restitution(self.means[setting]), moved)
    }

    /// Mean and S² of a run on the scale of the restitution.
    fn placed(&self, run: usize, errors: Errors, measured: bool) -> (f64, f64) {
        let (mean, Spread { sigma, .. }) = self.mean_and_spread(run);
        let setting = self.pointwise.setting[run] as usize;
        let errors = if measured { errors } else { errors.of_speed_alone() };
        if run < self.pointwise.dry {
            let k = self.moved.get(setting).map_or(f64::NAN, |(_, k)| *k);
            let balance = Balance::dry(self.pointwise.form.dry, k);
            let root = self.pointwise.settings[setting].impact.dry_root;
            return (mean, place_dry(&balance, root, sigma, errors, measured).1);
        }
        let placed = place(sigma, self.kept_and_by_speed(run, errors), errors, measured);
        (mean, placed.variance)
    }

    /// The tails of noise.
    pub fn tails(&self) -> Tails {
        self.tails
    }

    /// By how many spreads the smallest restitution told from sticking lies above the mean: F of it is the probability of
    /// sticking. Where stuck runs were not logged, that of a run not being there.
    pub fn limit_z(&self, run: usize) -> f64 {
        let measured = self.pointwise.truncated && !self.pointwise.stuck[run];
        self.beside(run, self.pointwise.limit, measured).z()
    }

    /// By how many spreads a measured restitution lies above the mean.
    pub fn z(&self, run: usize, restitution: f64) -> f64 {
        self.beside(run, restitution, true).z()
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
        let beside = self.beside(run, self.pointwise.runs.restitution[run], true);
        let density = self.tails.ln_unit_density(beside.z()) - beside.spread.ln;
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

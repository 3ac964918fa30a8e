//! Holds the runs of a scene one by one, and says what each adds to the log likelihood, its expected restitution, and a new
//! draw of it.

mod at_draws;

pub use at_draws::AtDraws;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::OnceLock;

use rand::Rng;

use super::errors::{errors_of, Errors};
use super::hidden::Hidden;
use super::nodes::{Block, Film, RunSetting};
use super::normal::normal_score;
use super::run_density::{RunDensity, Seen, Side};
use super::run_law::RunImpact;
use super::run_noise::{normal_number, MeasuredRun, RunNoise};
use super::shared_speed::{SharedRuns, SharedSetting};
use super::tails::Tails;
use super::trend::{middle_film_ratio, FilmLaw, FilmParameters};
use crate::model::parameters::{offset_slot, ParameterKind, SHAPE_SLOT};
use crate::physics::balance::Balance;
use crate::physics::rebound::mean_restitution;
use crate::physics::Form;
use crate::runs::{Conditions, Runs, SharedSpeed};
use crate::scene::{LikelihoodFamily, NoiseOn, Scene, Sticking};

/// Of factors of a density, and of those that divide it.
const SIGNS: [f64; 2] = [1.0, -1.0];

/// The runs of a scene, in the order of [`Runs`], ready for one run at a time.
#[derive(Debug, Clone)]
pub struct Pointwise {
    pub(super) form: Form,
    /// at or below this e* the run stuck
    pub(super) limit: f64,
    /// whether runs that stuck were not logged, so that a rebound's density is that of runs that rebound
    pub(super) truncated: bool,
    /// the distribution of the noise
    pub(super) family: LikelihoodFamily,
    /// whether it acts on the energy kept, too
    both: bool,
    pub(super) blocks: Vec<Block>,
    /// runs of one setting that follow one another share an entry
    settings: Vec<RunSetting>,
    /// the setting of each run
    setting: Vec<u32>,
    /// runs without a liquid, which come first
    pub(super) dry: usize,
    stuck: Vec<bool>,
    pub(super) restitution: Vec<f64>,
    /// how many runs each stands for; empty where that is itself
    count: Vec<f64>,
    /// of the measurement of each run; empty where no run has any
    pub(super) errors: Vec<Errors>,
    /// runs that share a true speed
    pub(super) shared: Vec<SharedRuns>,
}

/// The law at one full vector of parameters, for runs of some settings that follow one another.
#[derive(Debug, Clone)]
pub struct EvaluatedLaw<'p> {
    pointwise: &'p Pointwise,
    /// the first of the settings
    first: usize,
    /// the energy balance of each setting
    balances: Vec<Balance>,
    /// of dry and of wet runs
    noise: [RunNoise; 2],
    /// log density of each run given those that share its true speed, where some do
    given_the_others: OnceLock<Vec<f64>>,
}

/// Whether the density of a run is an integral: over the noise on the energy kept, or over the true impact speed.
pub fn is_integrated(scene: &Scene, runs: &Runs) -> bool {
    !runs.errors.is_empty() || scene.model.noise == NoiseOn::Both
}

impl Pointwise {
    /// The runs under this form of the energy balance.
    pub fn new(scene: &Scene, runs: &Runs, form: Form) -> Pointwise {
        /// film ratios differ beyond the rounding of a quotient
        const ROUNDING: f64 = 1e-14;
        let (errors, shared) = errors_of(scene, runs);
        let mut pointwise = Pointwise {
            form,
            limit: scene.data.smallest_restitution,
            truncated: scene.model.sticking == Sticking::Truncated,
            family: scene.model.likelihood,
            both: scene.model.noise == NoiseOn::Both,
            blocks: vec![],
            settings: vec![],
            setting: Vec::with_capacity(runs.len()),
            dry: 0,
            stuck: Vec::with_capacity(runs.len()),
            restitution: runs.restitution.clone(),
            count: runs.count.clone(),
            errors,
            shared: vec![],
        };
        let conditions = Conditions::new(scene, runs, form);
        for group in &runs.dry {
            let block = pointwise.block(Block {
                sphere: group.sphere,
                wet: false,
                density_ratio: 0.0,
                offset: None,
            });
            for run in group.runs() {
                let setting = RunSetting {
                    block,
                    film: Film::default(),
                    impact: conditions.dry(run),
                };
                pointwise.add(setting, group.stuck.contains(&run));
            }
        }
        pointwise.dry = pointwise.len();
        let middle = middle_film_ratio(runs);
        let mut films = HashMap::new();
        for (index, series) in runs.series.iter().enumerate() {
            let block = pointwise.block(Block {
                sphere: series.sphere,
                wet: true,
                density_ratio: series.density_ratio(scene),
                offset: scene.model.series_offsets.then(|| offset_slot(runs, index)),
            });
            for run in series.runs() {
                let ratio = runs.impacts.film_ratio[run];
                let film = films.entry((ratio / ROUNDING).round() as i64).or_insert_with(|| Film {
                    ratio,
                    ln: (ratio / middle).ln(),
                    shape: (!form.inertia.has_film_scale()).then(|| form.inertia.shape(ratio, 0.0)),
                });
                let setting = RunSetting {
                    block,
                    film: *film,
                    impact: conditions.wet(run),
                };
                pointwise.add(setting, series.stuck.contains(&run));
            }
        }
        pointwise.shared = pointwise.shared_runs(&shared);
        pointwise
    }

    /// The place of a block among those there are, or at their end.
    fn block(&mut self, block: Block) -> usize {
        let known = self.blocks.iter().position(|other| *other == block);
        known.unwrap_or_else(|| {
            self.blocks.push(block);
            self.blocks.len() - 1
        })
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

    /// The groups that share a true speed.
    fn shared_runs(&self, groups: &[SharedSpeed]) -> Vec<SharedRuns> {
        let mut found = vec![];
        for (group, sign) in groups.iter().flat_map(|group| SIGNS.map(|sign| (group, sign))) {
            let known = |run: &usize| {
                let errors = self.errors[*run];
                let seen = self.factor(*run, sign)?;
                Some((*run, MeasuredRun { seen, errors }))
            };
            let settings = group.settings.iter().filter_map(|of| {
                let (runs, known): (Vec<usize>, Vec<MeasuredRun>) = of.iter().filter_map(known).unzip();
                let impact = self.setting(*runs.first()?).impact;
                Some(SharedSetting { impact, runs, known })
            });
            found.push(SharedRuns {
                sign,
                settings: settings.collect(),
            });
        }
        found.retain(|shared| !shared.settings.is_empty());
        found
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
        !self.errors.is_empty() || self.both
    }

    /// Whether a run stuck.
    pub fn is_stuck(&self, run: usize) -> bool {
        self.stuck[run]
    }

    /// How many runs one stands for.
    pub(super) fn count(&self, run: usize) -> f64 {
        self.count.get(run).copied().unwrap_or(1.0)
    }

    pub(super) fn setting(&self, run: usize) -> &RunSetting {
        &self.settings[self.setting[run] as usize]
    }

    /// What a run's measurement errs by; nothing where no run's does.
    fn errors_of(&self, run: usize) -> Errors {
        self.errors.get(run).copied().unwrap_or(Errors::NONE)
    }

    /// Whether a run shares its true speed with others.
    pub(super) fn is_shared(&self, run: usize) -> bool {
        self.errors.get(run).is_some_and(|errors| errors.is_shared)
    }

    /// What is known of a run, a factor of its density by one of [`SIGNS`]: its restitution or that it stuck, divided by the
    /// probability that it rebounded where other runs were not logged.
    fn factor(&self, run: usize, sign: f64) -> Option<Seen> {
        match (self.stuck[run], sign > 0.0) {
            (true, true) => Some(Seen::On(Side::Below, self.limit)),
            (false, true) => Some(Seen::Rebound(self.restitution[run])),
            (stuck, false) => (self.truncated && !stuck).then_some(Seen::On(Side::Above, self.limit)),
        }
    }

    pub(super) fn impact<'b>(&self, run: usize, balance: &'b Balance) -> RunImpact<'b> {
        RunImpact {
            balance,
            impact: self.setting(run).impact,
            errors: self.errors_of(run),
        }
    }

    /// What a run adds to the log likelihood that shares its true speed with none.
    #[inline(always)] // where slopes are not read they are not computed
    pub(super) fn alone(&self, run: usize, at: RunImpact, noise: &RunNoise) -> RunDensity {
        let mut all = RunDensity::default();
        for (seen, sign) in SIGNS.iter().filter_map(|sign| Some((self.factor(run, *sign)?, *sign))) {
            all.add(at.density(noise, seen), sign);
        }
        all
    }

    /// The energy balance at each setting in turn.
    pub(super) fn laws<'f>(&'f self, full: &'f [f64]) -> impl FnMut(&RunSetting) -> FilmLaw + 'f {
        // neighbours mostly share a film, and an exponential costs more than the rest
        let mut last: Option<((usize, Film), FilmLaw)> = None;
        let films = FilmParameters::new(self.form, full);
        move |setting| match last {
            Some((same, law)) if same == (setting.block, setting.film) => law,
            _ => {
                let law = self.blocks[setting.block].law(films, full).at(setting.film);
                last = Some(((setting.block, setting.film), law));
                law
            }
        }
    }

    /// The noise of dry runs and that of wet ones at a full vector of parameters.
    pub(super) fn noise_at(&self, full: &[f64]) -> [RunNoise; 2] {
        let tails = Tails::of(self.family, full[SHAPE_SLOT]);
        let of = |kind: ParameterKind| full[kind.slot()];
        let energy = if self.both { of(ParameterKind::SigmaEnergy) } else { 0.0 };
        let kinds = [(ParameterKind::SigmaDry, 0.0), (ParameterKind::SigmaWet, energy)];
        kinds.map(|(sigma, energy)| RunNoise {
            tails,
            sigma: of(sigma),
            energy,
        })
    }

    /// The law at a full vector of parameters.
    pub fn at<'p>(&'p self, full: &[f64]) -> EvaluatedLaw<'p> {
        self.at_settings(full, self.noise_at(full), 0..self.settings.len())
    }

    /// The same for the runs of some settings, with the noise at these parameters.
    fn at_settings<'p>(&'p self, full: &[f64], noise: [RunNoise; 2], settings: Range<usize>) -> EvaluatedLaw<'p> {
        let mut laws = self.laws(full);
        EvaluatedLaw {
            pointwise: self,
            first: settings.start,
            balances: self.settings[settings].iter().map(|of| laws(of).balance).collect(),
            noise,
            given_the_others: OnceLock::new(),
        }
    }
}

impl EvaluatedLaw<'_> {
    /// Of a dry or a wet run.
    fn noise(&self, run: usize) -> &RunNoise {
        &self.noise[usize::from(run >= self.pointwise.dry)]
    }

    fn balance(&self, run: usize) -> &Balance {
        &self.balances[self.pointwise.setting[run] as usize - self.first]
    }

    fn impact(&self, run: usize) -> RunImpact<'_> {
        self.pointwise.impact(run, self.balance(run))
    }

    /// Gives runs that share a true speed to a function of their integral.
    fn hidden<T>(&self, shared: &SharedRuns, of: impl FnOnce(Hidden) -> T) -> T {
        let balances: Vec<Balance> = shared.firsts().map(|run| *self.balance(run)).collect();
        shared.hidden(*self.noise(shared.settings[0].runs[0]), &balances, of)
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
            let (mean, sigma) = self.mean_and_sigma(run);
            return (restitution - mean) / sigma;
        }
        let on = |side: Side| self.impact(run).density(self.noise(run), seen(side, restitution)).value;
        normal_score(on(Side::Below), on(Side::Above))
    }

    /// The tails of [`EvaluatedLaw::z`].
    pub fn tails(&self) -> Tails {
        if self.pointwise.is_integrated() {
            Tails::Normal
        } else {
            self.noise[0].tails
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

    /// Mean of e*, m(r), and its spread σ.
    pub fn mean_and_sigma(&self, run: usize) -> (f64, f64) {
        let noise = self.noise(run);
        let (kept, _) = self.impact(run).kept();
        (mean_restitution(kept), noise.sigma)
    }

    /// Log likelihood of a run: a density where it rebounded, a probability where it stuck; given the other runs where some
    /// share its true speed.
    pub fn ln_likelihood(&self, run: usize) -> f64 {
        if self.pointwise.is_shared(run) {
            self.given_the_others()[run]
        } else {
            self.ln_likelihood_alone(run)
        }
    }

    /// The same of a run that shares its true speed with none.
    fn ln_likelihood_alone(&self, run: usize) -> f64 {
        self.pointwise.alone(run, self.impact(run), self.noise(run)).value
    }

    /// Log likelihood of some runs together, of which none shares its true speed with another one.
    pub fn ln_likelihood_of(&self, runs: Range<usize>) -> f64 {
        let alone = runs.clone().filter(|run| !self.pointwise.is_shared(*run));
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
        let (noise, mut at) = (self.noise(run), self.impact(run));
        let scatter = noise.tails.draw(rng);
        let errors = at.errors;
        let mut ratio = 1.0;
        if errors.speed > 0.0 {
            ratio = (errors.true_speed.mean + normal_number(errors.true_speed.sd, rng)).max(0.01);
            at.impact = at.balance.at_speed_ratio(&at.impact, ratio);
        }
        let e = noise.restitution(at.kept().0, normal_number(noise.energy, rng), scatter);
        if e <= self.pointwise.limit {
            return e;
        }
        let own = errors.restitution * (1.0 - errors.correlation * errors.correlation).sqrt();
        // never written as less than what is a rebound
        (e * ratio + errors.shared() * (1.0 - ratio) + normal_number(own, rng)).max(self.pointwise.limit)
    }
}

//! Integrates over many true speeds of wet runs side by side, each of a few rebounds, where the integrands are all but normal.
//!
//! What one integral by itself waits for, others fill. Integrals of as many rebounds go together: their bells are found by one
//! step for all, and each node of a rule is taken of all before the next. Those of rebounds alone are gathered once for all
//! parameters. What came out on its side for certain wherever the true speed may be has no part in an integral; one with another
//! side, or near a turn, is left to [`HiddenSpeed::integrate`](super::HiddenSpeed::integrate).

mod batch;
mod found;
mod rebounds;
mod together;

pub(in crate::model::likelihood) use found::SpeedRuns;
pub(in crate::model::likelihood) use together::Together;

use batch::{Batch, DryForm, State, MOST_REBOUNDS};
use found::Found;

use super::reach::REACH;
use super::SettingRuns;
use crate::model::likelihood::normal::CERTAIN;
use crate::model::likelihood::normal_nodes::Order;
use crate::model::likelihood::run_density::{Seen, Side, Spreads};
use crate::model::likelihood::run_law::RunNoise;
use crate::model::likelihood::tails::Tails;
use crate::physics::balance::Balance;
use crate::physics::rebound::kept_of_mean_restitution;

/// Integrals over true speeds, gathered until there are enough of them.
pub(in crate::model::likelihood) struct ManySpeeds<'b> {
    sigma: f64,
    balances: &'b [Balance],
    /// whether the noise of the runs lets integrals go together
    go_together: bool,
    /// by the rule and the number of rebounds
    batches: [[Option<Box<Batch>>; MOST_REBOUNDS]; 2],
    /// r at which the last side asked for becomes certain
    edge: Option<((Side, f64), f64)>,
    found: Found,
}

impl<'b> ManySpeeds<'b> {
    /// Of wet runs with these energy balances.
    pub fn new(noise: &RunNoise, balances: &'b [Balance]) -> ManySpeeds<'b> {
        /// the inverse of as many spreads as an integral has rebounds is then a number, and so is its square
        const SIGMA: std::ops::Range<f64> = 1e-15..1e15;
        let Spreads { sigma, energy } = noise.spreads;
        ManySpeeds {
            sigma,
            balances,
            go_together: noise.tails == Tails::Normal && energy == 0.0 && SIGMA.contains(&sigma),
            batches: Default::default(),
            edge: None,
            found: Found::new(balances.len()),
        }
    }

    /// Takes integrals that go together, or leaves them.
    pub fn take(&mut self, together: &Together) {
        for batch in &together.batches {
            if self.go_together {
                self.integrate(batch);
            } else {
                self.found.left.extend(&batch.numbers[..batch.count]);
            }
        }
    }

    /// Takes an integral in, or leaves it.
    pub fn push(&mut self, runs: SpeedRuns) {
        let rebounds = self.go_together.then(|| self.rebounds(runs.settings));
        match rebounds.flatten() {
            Some((0, _)) => {}
            Some((rebounds, has_sides)) if rebounds <= MOST_REBOUNDS => {
                let balance = runs.settings[0].balance;
                let form = (balance.order, balance.own_speed);
                let batch = self.batch(Order::Eight, rebounds, form);
                batch.push(&runs, has_sides);
                if batch.is_full() {
                    self.empty(Order::Eight, rebounds);
                }
            }
            _ => self.found.left.push(runs.number),
        }
    }

    /// How many rebounds there are, and whether others beside them; `None` where one of these is not certain.
    fn rebounds(&mut self, settings: &[SettingRuns]) -> Option<(usize, bool)> {
        let (mut rebounds, mut has_sides) = (0, false);
        for setting in settings {
            let mut kept = None;
            for run in setting.runs {
                match run.seen {
                    Seen::Rebound(_) => rebounds += 1,
                    Seen::On(side, limit) => {
                        has_sides = true;
                        let kept = kept.get_or_insert_with(|| kept_within_reach(setting));
                        if !self.is_certain((side, limit), *kept) {
                            return None;
                        }
                    }
                    Seen::Measured(..) => return None,
                }
            }
        }
        Some((rebounds, has_sides))
    }

    /// What all came to.
    pub fn finish(mut self) -> Found {
        for order in [Order::Eight, Order::Sixteen] {
            for rebounds in 1..=MOST_REBOUNDS {
                self.empty(order, rebounds);
            }
        }
        self.found
    }

    /// Those of so many rebounds that take this rule.
    fn batch(&mut self, order: Order, rebounds: usize, form: DryForm) -> &mut Batch {
        let place = &mut self.batches[order as usize][rebounds - 1];
        place.get_or_insert_with(|| Box::new(Batch::new(rebounds, order, form)))
    }

    /// Integrates what has been gathered for a rule.
    fn empty(&mut self, order: Order, rebounds: usize) {
        let is_filled = |batch: &mut Box<Batch>| batch.count > 0;
        if let Some(mut batch) = self.batches[order as usize][rebounds - 1].take_if(is_filled) {
            self.integrate(&batch);
            batch.count = 0;
            self.batches[order as usize][rebounds - 1] = Some(batch);
        }
    }

    /// What eight nodes do not do for goes on to sixteen.
    fn integrate(&mut self, batch: &Batch) {
        let integrated = batch.integrate(self.sigma, self.balances);
        for integral in 0..batch.count {
            #[cfg(test)]
            if integrated.states[integral] != State::Left {
                batch.count_nodes(integral);
            }
            match integrated.states[integral] {
                State::Found => batch.write(&integrated, integral, &mut self.found),
                State::TooFewNodes if batch.order == Order::Eight => {
                    let next = self.batch(Order::Sixteen, batch.rebounds, batch.form);
                    next.put(batch.taken(&integrated, integral));
                    if next.is_full() {
                        self.empty(Order::Sixteen, batch.rebounds);
                    }
                }
                _ => self.found.left.push(batch.numbers[integral]),
            }
        }
    }

    /// Whether a run that keeps no less and no more came out on its side for certain.
    fn is_certain(&mut self, (side, limit): (Side, f64), [least, most]: [f64; 2]) -> bool {
        let edge = match self.edge {
            Some((known, edge)) if known == (side, limit) => edge,
            _ => {
                let edge = kept_of_mean_restitution(limit - side.sign() * CERTAIN * self.sigma);
                self.edge.insert(((side, limit), edge)).1
            }
        };
        match side {
            Side::Below => most < edge,
            Side::Above => least > edge,
        }
    }
}

/// The least and the largest r of a setting within reach.
fn kept_within_reach(setting: &SettingRuns) -> [f64; 2] {
    // r grows or falls with the speed, or has its largest value between
    let [a, b, c] = [-REACH, 0.0, REACH].map(|z| setting.balance.kept(&setting.impact(z)).0);
    if (a + b + c).is_nan() {
        return [f64::NAN; 2];
    }
    [a.min(b).min(c), a.max(b).max(c)]
}

//! Computes what rebounds are at their true speeds, several at a time.

use std::ops::Range;

use crate::exponential::{exponential, logarithm};
use crate::model::likelihood::errors::Errors;
use crate::model::likelihood::hidden_speed::SettingRuns;
use crate::physics::balance::{Balance, Impact, Lost};
use crate::physics::dry::{Order, POWER};
use crate::physics::rebound::{mean_and_slope_over, mean_denominator};

/// Rebounds of a batch.
pub(super) const MOST_ROWS: usize = 64;

/// Integrals are taken in multiples of this.
pub(super) const LANES: usize = 8;

/// A number of each rebound, or of each integral.
pub(super) type Column = [f64; MOST_ROWS];

/// What is known of a rebound.
const NUMBERS: usize = 11;

/// What is known of a rebound, whatever the parameters.
#[derive(Clone, Copy)]
pub(super) struct Row([f64; NUMBERS]);

impl Row {
    pub fn of(setting: &SettingRuns, errors: &Errors, e: f64) -> Row {
        let impact = &setting.impact;
        let of_setting = setting.first().true_speed;
        let [share, slope] = impact.fixed;
        Row([
            e,
            errors.shared(),
            (1.0 - errors.correlation * errors.correlation) * errors.restitution * errors.restitution,
            errors.true_speed.mean,
            errors.true_speed.sd,
            of_setting.mean,
            of_setting.sd,
            impact.dry_root,
            impact.over_stokes,
            share,
            slope,
        ])
    }
}

/// Rebounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Columns([Column; NUMBERS]);

impl Columns {
    pub const NONE: Columns = Columns([[0.0; MOST_ROWS]; NUMBERS]);

    #[inline(always)]
    pub fn set(&mut self, place: usize, row: Row) {
        for (column, number) in self.0.iter_mut().zip(row.0) {
            column[place] = number;
        }
    }

    /// Copies some rebounds of others, a multiple of [`LANES`], to a place and those after it.
    #[inline(always)]
    pub fn copy(&mut self, to: usize, from: &Columns, places: Range<usize>) {
        for (column, from) in self.0.iter_mut().zip(&from.0) {
            let to = column[to..to + places.len()].as_chunks_mut::<LANES>().0;
            for (to, from) in to.iter_mut().zip(from[places.clone()].as_chunks::<LANES>().0) {
                *to = *from;
            }
        }
    }

    /// Whether one was measured exactly but for the impact speed.
    pub fn is_exact(&self, place: usize) -> bool {
        let [_, _, own_variance, ..] = &self.0;
        own_variance[place] == 0.0
    }

    pub fn get(&self, place: usize) -> Row {
        Row(self.0.each_ref().map(|column| column[place]))
    }
}

/// What the setting of each takes: k, and of the losses that parameters move the constant share and that over 4/St.
pub(super) struct Laws(pub [Column; 3]);

/// Rebounds, with what their settings take.
pub(super) struct Rebounds<'n> {
    pub known: &'n Columns,
    pub laws: &'n Laws,
}

/// What each adds to the slope of the logarithm and to minus its curvature, and what of that M leaves where it moves evenly.
pub(super) struct Moves<'n> {
    pub slope: &'n mut Column,
    pub curvature: &'n mut Column,
    pub even: &'n mut Column,
}

/// What each is at a node.
pub(super) struct AtNode<'n> {
    /// the logarithm of its density, without that of 1/S and without the constant
    pub ln: &'n mut Column,
    /// 1/S
    pub over_spread: &'n mut Column,
    /// slopes in what is kept and in σ
    pub of_kept: &'n mut Column,
    pub of_sigma: &'n mut Column,
    /// 4/St
    pub over_stokes: &'n mut Column,
    /// slope of what is kept in k
    pub of_k: &'n mut Column,
}

// Every loop ends at or before the end of a column, which is said where it is seen: with a way out of a loop its last
// rebounds would be taken one at a time. Divisions and roots that wait for one another are in loops of their own, so that
// more rebounds are under way at once.

/// How wet rebounds come out, with e_dry at a speed of their own or at one of all, to second order or not, and
/// measured exactly but for the impact speed or not.
#[derive(Clone, Copy)]
pub(super) struct Law<const OWN: bool, const SECOND: bool, const EXACT: bool> {
    pub sigma: f64,
    pub fused: bool,
}

/// A rebound at a true speed.
struct At {
    /// the measured speed of its setting's first run over the true one
    inverse: f64,
    ratio: f64,
    balance: Balance,
    impact: Impact,
    kept: f64,
    of_k: f64,
}

/// How a rebound comes out at a true speed.
struct ComeOut {
    /// m and its slope in what is kept
    mean: f64,
    slope: f64,
    /// 1/S
    over_spread: f64,
    /// e − M
    distance: f64,
}

impl<const OWN: bool, const SECOND: bool, const EXACT: bool> Law<OWN, SECOND, EXACT> {
    /// The fifth root of the true speed over the measured one, of a setting's first run.
    #[inline(always)]
    fn roots(&self, of: &Rebounds, places: &Column, count: usize) -> Column {
        let mut roots = [1.0; MOST_ROWS];
        if OWN {
            let [_, _, _, _, _, mean, sd, ..] = &of.known.0;
            for i in 0..count {
                let ratio = (mean[i] + sd[i] * places[i]).max(0.01);
                roots[i] = exponential(POWER * logarithm(ratio, self.fused), self.fused);
            }
        }
        roots
    }

    #[inline(always)]
    fn at(&self, of: &Rebounds, i: usize, z: f64, root: f64) -> At {
        let [_, _, _, mean, sd, mean_of_setting, sd_of_setting, dry_root, over_stokes, share, slope] = &of.known.0;
        let [dry_k, constant, viscous] = &of.laws.0;
        let of_setting = (mean_of_setting[i] + sd_of_setting[i] * z).max(0.01);
        let balance = Balance {
            order: if SECOND { Order::Second } else { Order::First },
            dry_k: dry_k[i],
            own_speed: OWN,
            lost: Lost {
                constant: constant[i],
                over_stokes: viscous[i],
            },
        };
        let measured = Impact {
            dry_root: dry_root[i],
            over_stokes: over_stokes[i],
            fixed: [share[i], slope[i]],
        };
        let impact = measured.at_speed_ratio(of_setting, root);
        let (kept, of_k) = balance.kept(&impact);
        At {
            inverse: 1.0 / of_setting,
            ratio: (mean[i] + sd[i] * z).max(0.01),
            balance,
            impact,
            kept,
            of_k,
        }
    }

    #[inline(always)]
    pub fn kept(&self, of: &Rebounds, places: &Column, count: usize, to: &mut Column) {
        let count = count.min(MOST_ROWS);
        let roots = self.roots(of, places, count);
        for i in 0..count {
            to[i] = self.at(of, i, places[i], roots[i]).kept;
        }
    }

    /// What m and its slope are divided by where so much is kept.
    #[inline(always)]
    fn denominators(kept: &Column, count: usize) -> Column {
        let mut denominators = [0.0; MOST_ROWS];
        for i in 0..count {
            denominators[i] = mean_denominator(kept[i]);
        }
        denominators
    }

    /// At z = 0.
    #[inline(always)]
    pub fn moved(&self, of: &Rebounds, count: usize, to: Moves) {
        let count = count.min(MOST_ROWS);
        let roots = self.roots(of, &[0.0; MOST_ROWS], count);
        let (slopes, curvatures, evens) = (to.slope, to.curvature, to.even);
        let [e, shared, own_variance, _, sd, _, sd_of_setting, ..] = &of.known.0;
        let [mut ratio, mut kept, mut kept_slope, mut kept_bend] = [[0.0; MOST_ROWS]; 4];
        for i in 0..count {
            let at = self.at(of, i, 0.0, roots[i]);
            (ratio[i], kept[i]) = (at.ratio, at.kept);
            let [first, second] = at.balance.in_log_speed(&at.impact);
            let of_log = sd_of_setting[i] * at.inverse;
            kept_slope[i] = first * of_log;
            kept_bend[i] = second * of_log * of_log;
        }
        let denominators = Self::denominators(&kept, count);
        for i in 0..count {
            let of_run = [e[i], shared[i], own_variance[i]];
            let come_out = self.come_out(ratio[i], [kept[i], denominators[i]], of_run);
            // of m: far from the turn its second slope is −2 m′³
            let first = come_out.slope * kept_slope[i];
            let second = come_out.slope * (kept_bend[i] - 2.0 * first * first);
            // of M
            let moved = ratio[i] * first + (come_out.mean - shared[i]) * sd[i];
            let bent = ratio[i] * second + 2.0 * sd[i] * first;
            let inverse = come_out.over_spread * come_out.over_spread;
            let square = come_out.distance * come_out.distance * inverse;
            // half of that of S², and of its second
            let of_variance = self.sigma * self.sigma * ratio[i] * sd[i];
            let bend_of_variance = self.sigma * self.sigma * sd[i] * sd[i];
            slopes[i] = (come_out.distance * moved + (square - 1.0) * of_variance) * inverse;
            let even = moved * moved * inverse;
            evens[i] = even;
            let with_distance = come_out.distance * (4.0 * moved * of_variance * inverse - bent);
            let of_spread = (4.0 * square - 2.0) * of_variance * of_variance * inverse;
            curvatures[i] = even + (with_distance + of_spread - (square - 1.0) * bend_of_variance) * inverse;
        }
    }

    /// How a rebound comes out that keeps this on average, whose m has this denominator, of these e, c and variance beside
    /// σ².
    #[inline(always)]
    fn come_out(&self, ratio: f64, [kept, denominator]: [f64; 2], [e, shared, own_variance]: [f64; 3]) -> ComeOut {
        let spread = self.sigma * ratio;
        let spread = if EXACT {
            spread
        } else {
            (spread * spread + own_variance).sqrt()
        };
        // one division for both
        let inverse = 1.0 / (spread * denominator);
        let (mean, slope) = mean_and_slope_over(kept, inverse * spread);
        ComeOut {
            mean,
            slope,
            over_spread: inverse * denominator,
            distance: e - shared * (1.0 - ratio) - mean * ratio,
        }
    }

    #[inline(always)]
    pub fn at_node(&self, of: &Rebounds, places: &Column, count: usize, to: AtNode) {
        let count = count.min(MOST_ROWS);
        let roots = self.roots(of, places, count);
        let AtNode {
            ln,
            over_spread,
            of_kept,
            of_sigma,
            over_stokes,
            of_k,
        } = to;
        let [e, shared, own_variance, ..] = &of.known.0;
        let [mut ratio, mut kept] = [[0.0; MOST_ROWS]; 2];
        for i in 0..count {
            let at = self.at(of, i, places[i], roots[i]);
            (ratio[i], kept[i]) = (at.ratio, at.kept);
            (over_stokes[i], of_k[i]) = (at.impact.over_stokes, at.of_k);
        }
        let denominators = Self::denominators(&kept, count);
        for i in 0..count {
            let of_run = [e[i], shared[i], own_variance[i]];
            let come_out = self.come_out(ratio[i], [kept[i], denominators[i]], of_run);
            let inverse = come_out.over_spread * come_out.over_spread;
            let square = come_out.distance * come_out.distance * inverse;
            ln[i] = -0.5 * square;
            over_spread[i] = come_out.over_spread;
            of_kept[i] = come_out.distance * inverse * ratio[i] * come_out.slope;
            of_sigma[i] = (square - 1.0) * inverse * self.sigma * ratio[i] * ratio[i];
        }
    }
}

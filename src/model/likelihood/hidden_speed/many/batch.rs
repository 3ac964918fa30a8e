//! Holds integrals of as many rebounds each, and takes them by one rule.

use pulp::{Arch, Simd, WithSimd};

use super::found::{Found, SpeedRuns};
use super::rebounds::{AtNode, Column, Columns, Law, Laws, Moves, Rebounds, Row, LANES, MOST_ROWS};
use crate::distributions::LN_ROOT_TWO_PI;
use crate::exponential::{exponential, is_fused, logarithm};
use crate::model::likelihood::hidden_speed::bell::{most_of_last, FAR, LEAST};
use crate::model::likelihood::hidden_speed::reach::REACH;
use crate::model::likelihood::normal_nodes::Order;
use crate::model::likelihood::run_density::Seen;
use crate::physics::balance::Balance;
use crate::physics::dry;

/// Rebounds of an integral that goes with others.
pub(super) const MOST_REBOUNDS: usize = 8;

/// The order of the dry law, and whether e_dry is that of the run's own speed.
pub(super) type DryForm = (dry::Order, bool);

/// Integrals of as many rebounds each: the first rebound of all, the second of all, and so on.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Batch {
    pub rebounds: usize,
    pub order: Order,
    pub form: DryForm,
    pub count: usize,
    /// integrals that it has room for
    room: usize,
    rows: Columns,
    /// whether no rebound of it errs but in its impact speed
    is_exact: bool,
    /// the place of the balance of each rebound's setting
    balances: [usize; MOST_ROWS],
    pub numbers: [usize; MOST_ROWS],
    times: Column,
    /// runs of each, and whether some came out on a side
    runs: [usize; MOST_ROWS],
    has_sides: [bool; MOST_ROWS],
    /// known where the rule is of sixteen nodes
    bells: Bells,
}

/// About where integrands are largest, and how wide they are there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bells {
    z: Column,
    width: Column,
    /// whether nothing turns within reach
    are_bells: [bool; MOST_ROWS],
}

impl Bells {
    const NONE: Bells = Bells {
        z: [0.0; MOST_ROWS],
        width: [0.0; MOST_ROWS],
        are_bells: [true; MOST_ROWS],
    };
}

/// An integral on its way from one batch to another.
pub(super) struct Taken {
    rows: Vec<(Row, usize)>,
    number: usize,
    times: f64,
    runs: usize,
    bell: [f64; 2],
}

/// What became of an integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum State {
    Found,
    /// a rule of more may do
    TooFewNodes,
    /// it is no bell
    Left,
}

/// What integrals came to.
pub(super) struct Integrated {
    pub states: [State; MOST_ROWS],
    bells: Bells,
    value: Column,
    sigma: Column,
    /// of each rebound, in r, −L and k
    slopes: [Column; 3],
    /// rebounds of a rank
    filled: usize,
}

impl Batch {
    pub fn new(rebounds: usize, order: Order, form: DryForm) -> Batch {
        Batch {
            rebounds,
            order,
            form,
            count: 0,
            room: MOST_ROWS / rebounds / LANES * LANES,
            rows: Columns::NONE,
            is_exact: true,
            balances: [0; MOST_ROWS],
            numbers: [0; MOST_ROWS],
            times: [0.0; MOST_ROWS],
            runs: [0; MOST_ROWS],
            has_sides: [false; MOST_ROWS],
            bells: Bells::NONE,
        }
    }

    pub fn is_full(&self) -> bool {
        self.count == self.room
    }

    pub fn push(&mut self, runs: &SpeedRuns, has_sides: bool) {
        let mut row = self.count;
        let mut all = 0;
        for (setting, balance) in runs.settings.iter().zip(runs.balances) {
            all += setting.runs.len();
            for run in setting.runs {
                if let Seen::Rebound(e) = run.seen {
                    self.rows.set(row, Row::of(setting, &run.errors, e));
                    self.balances[row] = *balance;
                    self.is_exact &= self.rows.is_exact(row);
                    row += self.room;
                }
            }
        }
        (self.numbers[self.count], self.times[self.count]) = (runs.number, runs.times);
        (self.runs[self.count], self.has_sides[self.count]) = (all, has_sides);
        self.count += 1;
    }

    /// One of its integrals, of which this was found.
    pub fn taken(&self, of: &Integrated, integral: usize) -> Taken {
        let row = |rank: usize| integral + rank * self.room;
        Taken {
            rows: (0..self.rebounds)
                .map(row)
                .map(|row| (self.rows.get(row), self.balances[row]))
                .collect(),
            number: self.numbers[integral],
            times: self.times[integral],
            runs: self.runs[integral],
            bell: [of.bells.z[integral], of.bells.width[integral]],
        }
    }

    pub fn put(&mut self, taken: Taken) {
        let to = self.count;
        for (rank, (row, balance)) in taken.rows.into_iter().enumerate() {
            let place = to + rank * self.room;
            self.rows.set(place, row);
            self.balances[place] = balance;
            self.is_exact &= self.rows.is_exact(place);
        }
        (self.numbers[to], self.times[to], self.runs[to]) = (taken.number, taken.times, taken.runs);
        [self.bells.z[to], self.bells.width[to]] = taken.bell;
        self.count += 1;
    }

    /// Adds what an integral came to.
    pub fn write(&self, of: &Integrated, integral: usize, found: &mut Found) {
        let times = self.times[integral];
        found.all.value += times * of.value[integral];
        found.all.sigma += times * of.sigma[integral];
        for rank in 0..self.rebounds {
            let row = integral + rank * of.filled;
            let [kept, viscous, dry_k] = &of.slopes;
            let sum = &mut found.slopes[self.balances[integral + rank * self.room]];
            sum.kept += times * kept[row];
            sum.viscous += times * viscous[row];
            sum.dry_k += times * dry_k[row];
        }
    }

    /// Counts the nodes of an integral, each as often as it is of a run.
    #[cfg(test)]
    pub fn count_nodes(&self, integral: usize) {
        crate::model::likelihood::tests::nodes::count(2 * self.order.pairs().len() * self.runs[integral]);
    }

    /// The integrals by the batch's rule.
    pub fn integrate(&self, sigma: f64, balances: &[Balance]) -> Integrated {
        let of = (sigma, balances);
        match (self.form, self.is_exact) {
            ((dry::Order::First, false), false) => self.dispatch::<false, false, false>(of),
            ((dry::Order::First, false), true) => self.dispatch::<false, false, true>(of),
            ((dry::Order::First, true), false) => self.dispatch::<true, false, false>(of),
            ((dry::Order::First, true), true) => self.dispatch::<true, false, true>(of),
            // seldom, so that no code of its own is made for what was measured exactly
            ((dry::Order::Second, false), _) => self.dispatch::<false, true, false>(of),
            ((dry::Order::Second, true), _) => self.dispatch::<true, true, false>(of),
        }
    }

    fn dispatch<const OWN: bool, const SECOND: bool, const EXACT: bool>(
        &self,
        (sigma, balances): (f64, &[Balance]),
    ) -> Integrated {
        Arch::new().dispatch(Integrals::<OWN, SECOND, EXACT> {
            batch: self,
            sigma,
            balances,
        })
    }

    /// Its rebounds without room for more, in whole registers: what fills the last one is not read.
    #[inline(always)]
    fn gathered<'n>(&self, balances: &[Balance], known: &'n mut Columns, laws: &'n mut Laws) -> Gathered<'n> {
        let filled = self.count.next_multiple_of(LANES);
        let [dry_k, constant, viscous] = &mut laws.0;
        for rank in 0..self.rebounds {
            let from = rank * self.room..rank * self.room + filled;
            let to = rank * filled..(rank + 1) * filled;
            known.copy(to.start, &self.rows, from.clone());
            let laws = dry_k[to.clone()]
                .iter_mut()
                .zip(&mut constant[to.clone()])
                .zip(&mut viscous[to]);
            for (((dry_k, constant), viscous), place) in laws.zip(&self.balances[from]) {
                let balance = &balances[*place];
                (*dry_k, *constant, *viscous) = (balance.dry_k, balance.lost.constant, balance.lost.over_stokes);
            }
        }
        Gathered {
            of: Rebounds { known, laws },
            rebounds: self.rebounds,
            filled,
        }
    }
}

/// Rebounds of a batch: the first of all integrals, the second of all, and so on.
struct Gathered<'n> {
    of: Rebounds<'n>,
    rebounds: usize,
    filled: usize,
}

impl Gathered<'_> {
    /// Gives each rebound its integral's number.
    #[inline(always)]
    fn spread(&self, of: &Column, to: &mut Column) {
        let of = of.as_chunks::<LANES>().0;
        let ranks = to.as_chunks_mut::<LANES>().0.chunks_exact_mut(self.filled / LANES);
        for to in ranks.take(self.rebounds) {
            for (to, of) in to.iter_mut().zip(of) {
                *to = *of;
            }
        }
    }

    /// The numbers of one rebound of each integral.
    #[inline(always)]
    fn rank<'n>(&self, of: &'n Column, rank: usize) -> &'n [f64] {
        &of[rank * self.filled..][..self.filled]
    }

    #[inline(always)]
    fn rows(&self) -> usize {
        (self.rebounds * self.filled).min(MOST_ROWS)
    }
}

#[inline(always)]
fn add(to: &mut Column, more: &[f64]) {
    for (to, more) in to.iter_mut().zip(more) {
        *to += more;
    }
}

/// The integrals of a batch.
struct Integrals<'b, const OWN: bool, const SECOND: bool, const EXACT: bool> {
    batch: &'b Batch,
    sigma: f64,
    balances: &'b [Balance],
}

impl<const OWN: bool, const SECOND: bool, const EXACT: bool> WithSimd for Integrals<'_, OWN, SECOND, EXACT> {
    type Output = Integrated;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Integrated {
        let Integrals { batch, sigma, balances } = self;
        let law = Law::<OWN, SECOND, EXACT> {
            sigma,
            fused: is_fused::<S>(),
        };
        // a copy on the stack, so that no loop has to ask whether what it reads is what it writes
        let (mut known, mut laws) = (Columns::NONE, Laws([[0.0; MOST_ROWS]; 3]));
        let gathered = batch.gathered(balances, &mut known, &mut laws);
        let bells = match batch.order {
            Order::Eight => find_bells(&law, &gathered, batch),
            Order::Sixteen => batch.bells,
        };
        over_bells(&law, &gathered, bells, batch.order)
    }
}

/// Finds about where each integrand is largest, by one step of Newton's, and says whether it is a bell: whether nothing turns
/// within reach.
#[inline(always)]
fn find_bells<const OWN: bool, const SECOND: bool, const EXACT: bool>(
    law: &Law<OWN, SECOND, EXACT>,
    gathered: &Gathered,
    batch: &Batch,
) -> Bells {
    let filled = gathered.filled.min(MOST_ROWS);
    let [slope, curvature, even] = moved(law, gathered);
    let [mut z, mut width, mut bell] = [[0.0; MOST_ROWS]; 3];
    for g in 0..filled {
        let over_curvature = 1.0 / curvature[g];
        z[g] = slope[g] * over_curvature;
        width[g] = over_curvature.sqrt();
        bell[g] = if curvature[g] >= LEAST * even[g] { 1.0 } else { 0.0 };
    }
    let [mut lo, mut hi] = [[0.0; MOST_ROWS]; 2];
    for g in 0..filled {
        lo[g] = z[g] - FAR * width[g];
        hi[g] = z[g] + FAR * width[g];
    }
    let (lo, hi) = (kept(law, gathered, &lo), kept(law, gathered, &hi));
    for rank in 0..gathered.rebounds {
        let (lo, hi) = (gathered.rank(&lo, rank), gathered.rank(&hi, rank));
        for (bell, (lo, hi)) in bell.iter_mut().zip(lo.iter().zip(hi)) {
            // also where one is no number
            *bell = if lo * hi > 0.0 { *bell } else { 0.0 };
        }
    }
    let mut are_bells = [false; MOST_ROWS];
    for g in 0..filled {
        // sides are certain no farther than within reach
        let is_within = z[g].abs() + FAR * width[g] < REACH;
        are_bells[g] = bell[g] > 0.0 && (is_within || !batch.has_sides[g]);
    }
    Bells { z, width, are_bells }
}

/// How the logarithm of each integrand moves at z = 0: its slope, minus its curvature, and what of that M leaves where it moves
/// evenly.
#[inline(always)]
fn moved<const OWN: bool, const SECOND: bool, const EXACT: bool>(
    law: &Law<OWN, SECOND, EXACT>,
    gathered: &Gathered,
) -> [Column; 3] {
    let [mut slopes, mut curvatures, mut evens] = [[0.0; MOST_ROWS]; 3];
    let to = Moves {
        slope: &mut slopes,
        curvature: &mut curvatures,
        even: &mut evens,
    };
    law.moved(&gathered.of, gathered.rows(), to);
    // those of φ
    let mut sums = [[0.0; MOST_ROWS], [1.0; MOST_ROWS], [1.0; MOST_ROWS]];
    for rank in 0..gathered.rebounds {
        for (sum, of_rows) in sums.iter_mut().zip([&slopes, &curvatures, &evens]) {
            add(sum, gathered.rank(of_rows, rank));
        }
    }
    sums
}

/// What each rebound's setting keeps at a z of each integral.
#[inline(always)]
fn kept<const OWN: bool, const SECOND: bool, const EXACT: bool>(
    law: &Law<OWN, SECOND, EXACT>,
    gathered: &Gathered,
    z: &Column,
) -> Column {
    let [mut places, mut of_rows] = [[0.0; MOST_ROWS]; 2];
    gathered.spread(z, &mut places);
    law.kept(&gathered.of, &places, gathered.rows(), &mut of_rows);
    of_rows
}

/// The integrals by a rule about the bells.
#[inline(always)]
fn over_bells<const OWN: bool, const SECOND: bool, const EXACT: bool>(
    law: &Law<OWN, SECOND, EXACT>,
    gathered: &Gathered,
    bells: Bells,
    order: Order,
) -> Integrated {
    /// of which [`logarithm`] gives the logarithm
    const MASS: std::ops::Range<f64> = 1e-300..1e300;
    /// the largest number of which [`exponential`] gives the exponential
    const MOST: f64 = 700.0;
    let filled = gathered.filled.min(MOST_ROWS);
    let rows = gathered.rows();
    let [mut mass, mut odd, mut even, mut sigma] = [[0.0; MOST_ROWS]; 4];
    let [mut kept, mut sigmas, mut viscous, mut dry_k] = [[0.0; MOST_ROWS]; 4];
    let mut reference = [0.0; MOST_ROWS];
    let [mut z, mut places, mut ln, mut factor, mut part] = [[0.0; MOST_ROWS]; 5];
    let [mut ln_of_row, mut over_spread, mut of_kept, mut of_sigma, mut over_stokes, mut of_k] = [[0.0; MOST_ROWS]; 6];
    let pairs = order.pairs().iter().zip(order.last_polynomial());
    let nodes = pairs.flat_map(|([node, weight], last)| [-1.0, 1.0].map(|sign| (sign * node, *weight, sign * last)));
    for (index, (node, weight, last)) in nodes.enumerate() {
        for g in 0..filled {
            z[g] = bells.z[g] + node * bells.width[g];
            ln[g] = -0.5 * z[g] * z[g];
            factor[g] = weight * bells.width[g];
        }
        gathered.spread(&z, &mut places);
        let to = AtNode {
            ln: &mut ln_of_row,
            over_spread: &mut over_spread,
            of_kept: &mut of_kept,
            of_sigma: &mut of_sigma,
            over_stokes: &mut over_stokes,
            of_k: &mut of_k,
        };
        law.at_node(&gathered.of, &places, gathered.rows(), to);
        for rank in 0..gathered.rebounds {
            add(&mut ln, gathered.rank(&ln_of_row, rank));
            for (factor, over_spread) in factor.iter_mut().zip(gathered.rank(&over_spread, rank)) {
                *factor *= over_spread;
            }
        }
        // about the largest
        if index == 0 {
            reference = ln;
        }
        for g in 0..filled {
            let exponent = ln[g] - reference[g];
            // no number where the logarithm is none, whose exponential is one here
            part[g] = factor[g] * exponential(exponent.min(MOST), law.fused) + 0.0 * exponent;
            mass[g] += part[g];
            odd[g] += last * part[g];
            // at a node the polynomial of the degree before is this one times x/√degree
            even[g] += last * node * part[g];
        }
        gathered.spread(&part, &mut places);
        for row in 0..rows {
            let of_kept = places[row] * of_kept[row];
            kept[row] += of_kept;
            sigmas[row] += places[row] * of_sigma[row];
            viscous[row] += of_kept * over_stokes[row];
            dry_k[row] += of_kept * of_k[row];
        }
    }
    let degree = 2.0 * order.pairs().len() as f64 - 1.0;
    let constant = (gathered.rebounds + 1) as f64 * LN_ROOT_TWO_PI;
    let over_root = 1.0 / degree.sqrt();
    let most = most_of_last(order);
    let mut states = [State::TooFewNodes; MOST_ROWS];
    for g in 0..filled {
        let last = odd[g].abs().max(even[g].abs() * over_root);
        if !bells.are_bells[g] {
            states[g] = State::Left;
        } else if last < most * mass[g] && MASS.contains(&mass[g]) {
            states[g] = State::Found;
        }
    }
    for rank in 0..gathered.rebounds {
        add(&mut sigma, gathered.rank(&sigmas, rank));
    }
    let mut value = [0.0; MOST_ROWS];
    let mut inverse = [0.0; MOST_ROWS];
    for g in 0..filled {
        inverse[g] = 1.0 / mass[g];
        sigma[g] *= inverse[g];
        value[g] = reference[g] + logarithm(mass[g], law.fused) - constant;
    }
    gathered.spread(&inverse, &mut places);
    for row in 0..rows {
        kept[row] *= places[row];
        viscous[row] *= places[row];
        dry_k[row] *= places[row];
    }
    Integrated {
        states,
        bells,
        value,
        sigma,
        slopes: [kept, viscous, dry_k],
        filled,
    }
}

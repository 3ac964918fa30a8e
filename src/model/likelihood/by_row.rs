//! Computes the log likelihood a run at a time, where runs have spreads or tails that a sum of squares does not hold.
//!
//! On the restitution: e* = m(r) + S z, with S² = σ² + u² + t². Here u is what the run's own restitution errs by, and t
//! what its impact speed does, which e = v_r/v shares: t = s m(r)/v + ½ (m(r + h) − m(r − h)), h = s dr/dv. Half a
//! difference in place of a slope, because m turns more sharply at the threshold than a speed is known.
//!
//! On the energy kept as well: e* = m(r + σ_r z′) + σ z. A rebound e is taken to the energy's scale, y = m⁻¹(e), where it
//! has the spread S² = σ_r² + (σ² + u²)/m′(y)² + s² (e/(v m′(y)) + dr/dv)² about r: exact without σ, and to first order
//! in σ with it. A run sticks with the probability F((y_l − r)/S_l), y_l and S_l belonging to the limit. A restitution at
//! or below zero has no place where the limit is not negative, so that a rebound's y is always above y_l.
//!
//! F is normal, or Student's with one ν for all runs. A stuck run was not measured, so that only its impact speed errs.

use std::ops::Range;

use super::sums::Sums;
use super::tails::Tails;
use super::{mean_and_slope, DryRow, Law, Likelihood, Nodes};
use crate::model::parameters::{Kind, COMMON_SLOTS};
use crate::physics::rebound::{kept_of_mean_restitution, slope_mean_restitution};
use crate::runs::MeasurementErrors;

/// What runs have of their own.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ByRow {
    /// whether noise has Student's tails
    pub student: bool,
    /// the rebounds on the scale of the energy kept, where noise acts there, too
    pub energies: Option<Energies>,
    /// measurement errors of the rebounds and of the stuck runs; empty where there are none
    pub rebounds: Vec<Errors>,
    pub stuck: Vec<Errors>,
    /// dry runs; empty where their sums say the same
    pub dry: Vec<DryRow>,
}

/// The rebounds on the scale of the energy kept.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Energies {
    rebounds: Vec<Energy>,
    limit: Energy,
}

/// A restitution on the scale of the energy kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Energy {
    /// y = m⁻¹(e)
    pub kept: f64,
    /// e
    restitution: f64,
    /// 1/m′(y)²
    pub stretch: f64,
}

/// What the measurement of a run errs by.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Errors {
    /// 1/v, s/m
    pub slowness: f64,
    /// s, the standard deviation of the impact speed, m/s
    pub speed: f64,
    /// u², of the restitution beyond its share of the speed
    pub restitution: f64,
}

impl Errors {
    /// Those of a run with this impact speed; `None` where no run has any.
    pub fn of(errors: Option<&MeasurementErrors>, run: usize, impact_speed: f64) -> Option<Errors> {
        let [speed, own] = errors?.of(run);
        Some(Errors {
            slowness: 1.0 / impact_speed,
            speed,
            restitution: own * own,
        })
    }

    /// Those of a run whose restitution was not measured.
    pub fn of_speed_alone(self) -> Errors {
        Errors {
            restitution: 0.0,
            ..self
        }
    }
}

/// The spreads of wet runs.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spreads {
    /// σ
    pub sigma: f64,
    /// σ_r; 0 where noise acts on the restitution alone
    pub energy: f64,
}

/// Where a run lies on the scale its noise is symmetric on, and how wide, with slopes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    /// m(r), or r
    pub mean: f64,
    /// slope of the mean in r
    mean_slope: f64,
    /// S²
    pub variance: f64,
    /// slopes of S² in r and in dr/dv
    variance_slopes: [f64; 2],
    /// slopes of S² in σ and σ_r
    of_spreads: [f64; 2],
}

impl ByRow {
    /// Whether all rebounds have σ for their spread, so that they may be summed together.
    pub fn spreads_are_one(&self) -> bool {
        self.energies.is_none() && self.rebounds.is_empty()
    }
}

impl Energy {
    pub fn of(restitution: f64) -> Energy {
        let kept = kept_of_mean_restitution(restitution);
        let slope = slope_mean_restitution(kept);
        Energy {
            kept,
            restitution,
            stretch: 1.0 / (slope * slope),
        }
    }

    /// A run that keeps r on average, seen from here.
    pub fn place(self, spreads: Spreads, (r, by_speed): (f64, f64), errors: Errors) -> Placed {
        let Spreads { sigma, energy } = spreads;
        // a restitution of 0 shares nothing with the speed
        let moved = self.restitution * errors.slowness * self.stretch.sqrt() + by_speed;
        let square = errors.speed * errors.speed;
        Placed {
            mean: r,
            mean_slope: 1.0,
            variance: energy * energy + (sigma * sigma + errors.restitution) * self.stretch + square * moved * moved,
            variance_slopes: [0.0, 2.0 * square * moved],
            of_spreads: [2.0 * sigma * self.stretch, 2.0 * energy],
        }
    }
}

impl Energies {
    pub fn new(rebounds: &Nodes, limit: f64) -> Energies {
        Energies {
            rebounds: rebounds.restitution.iter().map(|e| Energy::of(*e)).collect(),
            limit: Energy::of(limit),
        }
    }
}

/// A run on the scale of the restitution that keeps r on average; `shares` whether its restitution was measured with the
/// same speed.
pub(super) fn place(sigma: f64, (r, by_speed): (f64, f64), errors: Errors, shares: bool) -> Placed {
    let (mean, mean_slope) = mean_and_slope(r);
    let mut placed = Placed {
        mean,
        mean_slope,
        variance: sigma * sigma + errors.restitution,
        variance_slopes: [0.0; 2],
        of_spreads: [2.0 * sigma, 0.0],
    };
    if errors.speed > 0.0 {
        let step = errors.speed * by_speed;
        let ((above, above_slope), (below, below_slope)) = (mean_and_slope(r + step), mean_and_slope(r - step));
        let share = if shares { errors.speed * errors.slowness } else { 0.0 };
        let moved = share * mean + 0.5 * (above - below);
        placed.variance += moved * moved;
        placed.variance_slopes = [
            2.0 * moved * (share * mean_slope + 0.5 * (above_slope - below_slope)),
            moved * errors.speed * (above_slope + below_slope),
        ];
    }
    placed
}

/// A dry run's mean e_dry and S² = σ² + u² + s² (e_dry/v + de_dry/dv)², as (mean, variance, slope of the variance in k).
pub(super) fn place_dry(law: &Law, p: f64, sigma: f64, errors: Errors, shares: bool) -> (f64, f64, f64) {
    let (e_dry, fall, bend) = law.dry(p);
    let own = sigma * sigma + errors.restitution;
    if errors.speed == 0.0 {
        return (e_dry, own, 0.0);
    }
    let share = f64::from(u8::from(shares));
    let moved = errors.speed * errors.slowness * (share * e_dry - 0.2 * law.k * fall);
    let slope = errors.speed * errors.slowness * (-share * fall - 0.2 * (fall + law.k * bend));
    (e_dry, own + moved * moved, 2.0 * moved * slope)
}

/// z of a restitution, (y − r)/S: a run that keeps r on average, with these spreads σ and σ_r, comes out lower with the
/// probability F(z).
pub fn on_energies(restitution: f64, kept: f64, (sigma, energy): (f64, f64)) -> f64 {
    let at = Energy::of(restitution);
    let placed = at.place(Spreads { sigma, energy }, (kept, 0.0), Errors::default());
    (at.kept - kept) / placed.variance.sqrt()
}

impl Likelihood {
    /// Log likelihood of some rebounds and some stuck runs of a block; adds its slopes in the spreads and in ν, and in r to
    /// `sums`.
    pub(super) fn one_by_one(
        &self,
        own: &ByRow,
        (rebounds, stuck): (Range<usize>, Range<usize>),
        law: &Law,
        (tails, spreads): (Tails, Spreads),
        slopes: &mut [f64],
        sums: &mut Sums,
    ) -> f64 {
        let none = Errors::default();
        let (mut value, mut of_spreads, mut of_nu) = (0.0, [0.0; 2], 0.0);
        let mut add = |nodes: &Nodes, node: usize, errors: Errors, placed: Placed, of_mean: f64, of_variance: f64| {
            let at = nodes.abscissa(node);
            let slope = of_mean * placed.mean_slope + of_variance * placed.variance_slopes[0];
            sums.kept += slope;
            sums.viscous += slope * at.viscous;
            sums.dry += slope * law.kept(&at).1;
            let slope = of_variance * placed.variance_slopes[1];
            if slope != 0.0 {
                let of_k = law.by_speed(&at, errors.slowness).1;
                sums.viscous -= slope * at.viscous * errors.slowness;
                sums.dry -= 0.5 * slope * of_k;
            }
            for (sum, of_spread) in of_spreads.iter_mut().zip(placed.of_spreads) {
                *sum += of_variance * of_spread;
            }
        };
        for node in rebounds {
            let errors = own.rebounds.get(node).copied().unwrap_or(none);
            let kept = law.kept_and_by_speed(&self.rebounds.abscissa(node), errors);
            let (placed, e, stretch) = match &own.energies {
                Some(energies) => {
                    let at = energies.rebounds[node];
                    (at.place(spreads, kept, errors), at.kept, at.stretch)
                }
                None => {
                    let placed = place(spreads.sigma, kept, errors, true);
                    (placed, self.rebounds.restitution[node], 1.0)
                }
            };
            let density = tails.ln_density(e - placed.mean, placed.variance, stretch);
            value += density.value;
            of_nu += density.nu;
            add(&self.rebounds, node, errors, placed, density.mean, density.variance);
            if self.truncated {
                let placed = self.place_limit(own, spreads, kept, errors, true);
                let limit = own.energies.as_ref().map_or(self.limit, |energies| energies.limit.kept);
                let side = Side::of(tails, -1.0, limit, &placed);
                value -= side.value;
                of_nu -= side.nu;
                add(&self.rebounds, node, errors, placed, -side.mean, -side.variance);
            }
        }
        for node in stuck {
            let errors = own.stuck.get(node).copied().unwrap_or(none).of_speed_alone();
            let kept = law.kept_and_by_speed(&self.stuck.abscissa(node), errors);
            let placed = self.place_limit(own, spreads, kept, errors, false);
            let limit = own.energies.as_ref().map_or(self.limit, |energies| energies.limit.kept);
            let side = Side::of(tails, 1.0, limit, &placed);
            let count = self.stuck.count[node];
            value += count * side.value;
            of_nu += count * side.nu;
            add(
                &self.stuck,
                node,
                errors,
                placed,
                count * side.mean,
                count * side.variance,
            );
        }
        slopes[Kind::SigmaWet.slot()] += of_spreads[0];
        slopes[Kind::SigmaEnergy.slot()] += of_spreads[1];
        slopes[Kind::Nu.slot()] += of_nu;
        value
    }

    /// A run as seen from the limit.
    fn place_limit(&self, own: &ByRow, spreads: Spreads, kept: (f64, f64), errors: Errors, shares: bool) -> Placed {
        let errors = if shares { errors } else { errors.of_speed_alone() };
        match &own.energies {
            Some(energies) => energies.limit.place(spreads, kept, errors),
            None => place(spreads.sigma, kept, errors, shares),
        }
    }

    /// Log likelihood of the dry runs, with slopes.
    pub(super) fn of_dry_rows(&self, own: &ByRow, tails: Tails, full: &[f64], slopes: &mut [f64]) -> f64 {
        let sigma = full[Kind::SigmaDry.slot()];
        let mut value = 0.0;
        for row in &own.dry {
            let place_of_k = COMMON_SLOTS + row.particle;
            let law = Law {
                order: self.form.dry,
                k: full[place_of_k],
                ..Law::DRY
            };
            let rebounded = row.restitution.is_some();
            let errors = if rebounded {
                row.errors
            } else {
                row.errors.of_speed_alone()
            };
            let (mean, variance, variance_slope) = place_dry(&law, row.dry_power, sigma, errors, rebounded);
            let (_, fall, _) = law.dry(row.dry_power);
            let mut add = |sign: f64, of: (f64, f64, f64, f64)| {
                let (told, of_mean, of_variance, of_nu) = of;
                value += sign * told;
                slopes[place_of_k] += sign * (of_variance * variance_slope - of_mean * fall);
                slopes[Kind::SigmaDry.slot()] += sign * of_variance * 2.0 * sigma;
                slopes[Kind::Nu.slot()] += sign * of_nu;
            };
            let placed = Placed {
                mean,
                mean_slope: 1.0,
                variance,
                variance_slopes: [0.0; 2],
                of_spreads: [0.0; 2],
            };
            let side = |sign: f64| {
                let side = Side::of(tails, sign, self.limit, &placed);
                (side.value, side.mean, side.variance, side.nu)
            };
            match row.restitution {
                Some(e) => {
                    let density = tails.ln_density(e - mean, variance, 1.0);
                    add(1.0, (density.value, density.mean, density.variance, density.nu));
                    if self.truncated {
                        add(-1.0, side(-1.0));
                    }
                }
                None => add(1.0, side(1.0)),
            }
        }
        value
    }
}

/// ln F(± (limit − mean)/S), with its slopes in the mean, in S² and in ν.
struct Side {
    value: f64,
    mean: f64,
    variance: f64,
    nu: f64,
}

impl Side {
    fn of(tails: Tails, sign: f64, limit: f64, placed: &Placed) -> Side {
        let spread = placed.variance.sqrt();
        let z = sign * (limit - placed.mean) / spread;
        let probability = tails.ln_probability(z);
        Side {
            value: probability.value,
            mean: -sign * probability.z / spread,
            variance: -0.5 * probability.z * z / placed.variance,
            nu: probability.nu,
        }
    }
}

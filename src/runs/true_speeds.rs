//! Says how the true impact speed of each run is distributed where the measured one errs.
//!
//! Runs of one series, film ratio and diameter are repeats of one speed where their measured speeds follow one another without
//! a gap of more than [`GAP`] of their errors. True speeds of repeats are normal; their mean is the mean of the measured ones,
//! their spread what these scatter by beyond their errors, by moments, where it is more than errors alone leave in 19 of 20
//! groups. Where it is not, the repeats have one true speed, and what its mean errs by is an error they share. Else, given what
//! was measured, a true speed is normal, too: its measured value drawn towards the mean of the repeats, whose own standard
//! error widens it. Of a speed without a repeat as much is known as of any that runs of its kind, dry or wet, were made at: it
//! is normal with the mean and the spread of all of these; where they scatter by no more than their errors, it is as good as
//! any other before it is measured.

use std::ops::Range;

use super::errors::MeasurementErrors;
use super::series::Runs;
use crate::distributions::gamma_quantile;

/// Measured speeds farther apart than so many standard deviations of their errors are no repeats of one speed.
pub const GAP: f64 = 2.5;

/// The true impact speed of a run over the measured one: normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueSpeed {
    /// mean
    pub mean: f64,
    /// standard deviation
    pub sd: f64,
    /// runs at this speed, itself among them; 1 where none repeats it
    pub repeats: usize,
}

impl TrueSpeed {
    /// Of a speed that was measured without an error.
    pub const EXACT: TrueSpeed = TrueSpeed {
        mean: 1.0,
        sd: 0.0,
        repeats: 1,
    };
}

/// The true impact speeds of runs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrueSpeeds {
    /// of each run
    pub of_run: Vec<TrueSpeed>,
    /// repeats of one setting that have one true speed, by the places of the runs: the standard normal of all of a group is
    /// the same
    pub shared: Vec<Vec<usize>>,
}

impl Runs {
    /// The true speed of every run, given these errors.
    pub fn true_speeds(&self, errors: &MeasurementErrors) -> TrueSpeeds {
        let mut found = TrueSpeeds {
            of_run: vec![TrueSpeed::EXACT; self.len()],
            shared: vec![],
        };
        let wet: Vec<Range<usize>> = self.series.iter().map(|series| series.runs()).collect();
        let dry = self.dry.iter().map(|group| group.rebounds.start..group.stuck.end);
        for kind in [wet, dry.collect()] {
            let err = |run: &usize| errors.impact_speed_sd[*run] > 0.0;
            let all: Vec<usize> = kind.iter().cloned().flatten().filter(err).collect();
            let each = all
                .iter()
                .map(|run| [self.impact_speed[*run], errors.impact_speed_sd[*run]]);
            let of_kind = Repeats::of(each);
            for runs in kind {
                self.find_true_speeds(errors, runs, &of_kind, &mut found);
            }
        }
        found
    }

    fn find_true_speeds(
        &self,
        errors: &MeasurementErrors,
        runs: Range<usize>,
        of_kind: &Repeats,
        found: &mut TrueSpeeds,
    ) {
        let speed = |run: usize| self.impact_speed[run];
        let sd = |run: usize| errors.impact_speed_sd[run];
        let setting = |run: &usize| [self.impacts.film_ratio[*run], self.diameter[*run]].map(f64::to_bits);
        let mut order: Vec<usize> = runs.filter(|run| sd(*run) > 0.0).collect();
        order.sort_by(|a, b| setting(a).cmp(&setting(b)).then(speed(*a).total_cmp(&speed(*b))));
        let near =
            |a: &usize, b: &usize| setting(a) == setting(b) && speed(*b) - speed(*a) <= GAP * 0.5 * (sd(*a) + sd(*b));
        for repeats in order.chunk_by(near) {
            let group = Repeats::of(repeats.iter().map(|run| [speed(*run), sd(*run)]));
            for &run in repeats {
                found.of_run[run] = if group.runs > 1 {
                    group.true_speed(speed(run), sd(run))
                } else {
                    of_kind.true_speed_of_one(speed(run), sd(run))
                };
            }
            if group.runs > 1 && group.spread == 0.0 {
                found.shared.push(repeats.to_vec());
            }
        }
    }
}

/// What repeats of one speed say of it.
struct Repeats {
    runs: usize,
    mean: f64,
    /// square of the standard error of the mean
    mean_variance: f64,
    /// square of the spread of the true speeds
    spread: f64,
}

impl Repeats {
    /// From measured speeds and their standard deviations.
    fn of(measured: impl Iterator<Item = [f64; 2]> + Clone) -> Repeats {
        /// groups of errors alone that stay below the line
        const LEVEL: f64 = 0.95;
        let runs = measured.clone().count();
        let n = runs as f64;
        let average = |of: &dyn Fn([f64; 2]) -> f64| measured.clone().map(of).sum::<f64>() / n;
        let (mean, error) = (average(&|[v, _]| v), average(&|[_, sd]| sd * sd));
        let squares = n * average(&|[v, _]| (v - mean).powi(2));
        let freedom = n - 1.0;
        // χ² of this freedom is twice a gamma of half of it
        let line = gamma_quantile(LEVEL, 0.5 * freedom).map_or(f64::INFINITY, |half| 2.0 * half);
        let spread = if runs > 1 && squares > line * error {
            squares / freedom - error
        } else {
            0.0
        };
        Repeats {
            runs,
            mean,
            mean_variance: (spread + error) / n,
            spread,
        }
    }

    /// The true speed of one of them, given what was measured.
    fn true_speed(&self, measured: f64, sd: f64) -> TrueSpeed {
        let error = sd * sd;
        let to_mean = error / (error + self.spread);
        let variance = self.spread * to_mean + to_mean * to_mean * self.mean_variance;
        TrueSpeed {
            mean: 1.0 + to_mean * (self.mean / measured - 1.0),
            sd: variance.sqrt() / measured,
            repeats: self.runs,
        }
    }
}

impl Repeats {
    /// The true speed of a run that none repeats, these being all runs of its kind.
    fn true_speed_of_one(&self, measured: f64, sd: f64) -> TrueSpeed {
        if self.spread > 0.0 {
            return TrueSpeed {
                repeats: 1,
                ..self.true_speed(measured, sd)
            };
        }
        TrueSpeed {
            sd: sd / measured,
            ..TrueSpeed::EXACT
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeats_draw_a_speed_to_their_mean() {
        let of = |speeds: &[f64], sd: f64| Repeats::of(speeds.iter().map(|v| [*v, sd]));
        // errors explain the scatter: all are one speed
        let group = of(&[0.98, 1.0, 1.02, 1.0], 0.02);
        let one = group.true_speed(0.98, 0.02);
        assert!((one.mean * 0.98 - 1.0).abs() < 1e-15);
        assert!((one.sd * 0.98 - 0.01).abs() < 1e-15);
        assert_eq!(one.repeats, 4);
        // they do not: variance 0.0667, of which 0.0004 are errors
        let group = of(&[0.8, 1.0, 1.2, 1.4, 0.6], 0.02);
        assert!((group.spread - (0.1 - 0.0004)).abs() < 1e-15);
        let one = group.true_speed(0.8, 0.02);
        let to_mean = 0.0004 / 0.1;
        assert!((one.mean * 0.8 - (0.8 + to_mean * 0.2)).abs() < 1e-15);
        // alone
        let one = of(&[0.8], 0.02).true_speed_of_one(0.8, 0.02);
        assert_eq!((one.mean, one.sd, one.repeats), (1.0, 0.02 / 0.8, 1));
        // one of many speeds
        let one = group.true_speed_of_one(0.8, 0.02);
        assert_eq!((one.mean, one.repeats), (group.true_speed(0.8, 0.02).mean, 1));
    }
}

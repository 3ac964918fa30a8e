//! Says how the true impact speed of each run is distributed where the measured one errs.
//!
//! Runs of a kind, dry or wet, are repeats of one speed where their measured speeds follow one another without a gap of more
//! than [`GAP`] of their errors. True speeds of repeats are normal; their mean is the mean of the measured ones, their spread
//! what these scatter by beyond their errors, by moments, where it is more than errors alone leave in 19 of 20 groups. Where
//! it is not, the repeats have one true speed whatever their diameters and films, and what its mean errs by is an error they
//! share. Else runs of one series, film ratio and diameter are looked at in the same way by themselves: a common speed of
//! theirs is one, and else a true speed, given what was measured, is normal, its measured value drawn towards the mean of the
//! repeats, whose own standard error widens it. Of a speed without a repeat as much is known as of any that runs of its kind
//! were made at: it is normal with the mean and the spread of all of these; where they scatter by no more than their errors,
//! it is as good as any other before it is measured.

use std::ops::Range;

use super::errors::RunError;
use super::series::Runs;
use crate::distributions::gamma_quantile;
use crate::scene::Scene;

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
    /// repeats that have one true speed: the standard normal of all of a group is the same
    pub shared: Vec<SharedSpeed>,
}

/// Runs that have one true speed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SharedSpeed {
    /// by their places, those of one series, film ratio and diameter together
    pub settings: Vec<Vec<usize>>,
}

impl SharedSpeed {
    /// By their places.
    pub fn runs(&self) -> impl Iterator<Item = usize> + '_ {
        self.settings.iter().flatten().copied()
    }
}

/// Runs of one series, film ratio and diameter whose speeds err.
type Setting = Vec<usize>;

impl Runs {
    /// The true speed of every run, given these errors. Where series have offsets, runs of different series share none: they
    /// are left out a series at a time.
    pub fn true_speeds(&self, scene: &Scene, errors: &[RunError]) -> TrueSpeeds {
        let mut found = TrueSpeeds {
            of_run: vec![TrueSpeed::EXACT; self.len()],
            shared: vec![],
        };
        let measured = MeasuredSpeeds { runs: self, errors };
        let wet: Vec<Range<usize>> = self.series.iter().map(|series| series.runs()).collect();
        let dry = self.dry.iter().map(|group| group.rebounds.start..group.stuck.end);
        for kind in [wet, dry.collect()] {
            let series: Vec<Vec<Setting>> = kind.into_iter().map(|runs| measured.settings(runs)).collect();
            let of_kind = measured.repeats(series.iter().flatten().flatten());
            if scene.model.series_offsets {
                for settings in series {
                    measured.find(settings, &of_kind, &mut found);
                }
            } else {
                measured.find(series.concat(), &of_kind, &mut found);
            }
        }
        found
    }
}

/// Speeds with what they err by.
struct MeasuredSpeeds<'r> {
    runs: &'r Runs,
    errors: &'r [RunError],
}

impl MeasuredSpeeds<'_> {
    fn speed(&self, run: usize) -> f64 {
        self.runs.impact_speed[run]
    }

    fn sd(&self, run: usize) -> f64 {
        self.errors[run].impact_speed_sd
    }

    /// The settings of some runs, ordered by film ratio and diameter.
    fn settings(&self, runs: Range<usize>) -> Vec<Setting> {
        let setting = |run: &usize| [self.runs.impacts.film_ratio[*run], self.runs.diameter[*run]].map(f64::to_bits);
        let mut order: Vec<usize> = runs.filter(|run| self.sd(*run) > 0.0).collect();
        order.sort_by_key(setting);
        order
            .chunk_by(|a, b| setting(a) == setting(b))
            .map(<[usize]>::to_vec)
            .collect()
    }

    /// Runs, told by any key beside them, that follow one another without a gap.
    fn without_gaps<K: Copy>(&self, mut order: Vec<(usize, K)>) -> Vec<Vec<(usize, K)>> {
        order.sort_by(|(a, _), (b, _)| self.speed(*a).total_cmp(&self.speed(*b)));
        let near = |(a, _): &(usize, K), (b, _): &(usize, K)| {
            self.speed(*b) - self.speed(*a) <= GAP * 0.5 * (self.sd(*a) + self.sd(*b))
        };
        order.chunk_by(near).map(<[(usize, K)]>::to_vec).collect()
    }

    fn repeats<'r>(&self, runs: impl Iterator<Item = &'r usize> + Clone) -> Repeats {
        Repeats::of(runs.map(|run| [self.speed(*run), self.sd(*run)]))
    }

    /// Finds the true speeds of runs that may share one.
    fn find(&self, settings: Vec<Setting>, of_kind: &Repeats, found: &mut TrueSpeeds) {
        let all = settings.iter().enumerate();
        let all = all.flat_map(|(place, runs)| runs.iter().map(move |run| (*run, place)));
        for mut near in self.without_gaps(all.collect()) {
            let repeats = self.repeats(near.iter().map(|(run, _)| run));
            if repeats.runs == 1 {
                let (run, _) = near[0];
                found.of_run[run] = of_kind.true_speed_of_one(self.speed(run), self.sd(run));
                continue;
            }
            // a stable order: runs of a setting follow one another by their speeds
            near.sort_by_key(|(_, setting)| *setting);
            let by_setting = near.chunk_by(|(_, a), (_, b)| a == b);
            let settings = by_setting.map(|runs| runs.iter().map(|(run, _)| *run).collect());
            if repeats.spread == 0.0 {
                self.share(settings.collect(), found);
            } else {
                settings.for_each(|setting: Setting| self.find_in_setting(setting, &repeats, found));
            }
        }
    }

    /// Finds the true speeds of runs of one setting, which are among those that have these as repeats.
    fn find_in_setting(&self, setting: Setting, of_all: &Repeats, found: &mut TrueSpeeds) {
        for near in self.without_gaps(setting.into_iter().map(|run| (run, ())).collect()) {
            let runs: Setting = near.into_iter().map(|(run, ())| run).collect();
            let own = self.repeats(runs.iter());
            if own.runs > 1 && own.spread == 0.0 {
                self.share(vec![runs], found);
                continue;
            }
            let repeats = if own.runs > 1 { &own } else { of_all };
            for run in runs {
                found.of_run[run] = repeats.true_speed(self.speed(run), self.sd(run));
            }
        }
    }

    /// Gives one true speed to runs of which errors explain the scatter.
    fn share(&self, settings: Vec<Setting>, found: &mut TrueSpeeds) {
        let one = Repeats {
            spread: 0.0,
            ..self.repeats(settings.iter().flatten())
        };
        for &run in settings.iter().flatten() {
            found.of_run[run] = one.true_speed(self.speed(run), self.sd(run));
        }
        found.shared.push(SharedSpeed { settings });
    }
}

/// What repeats of one speed say of it.
struct Repeats {
    runs: usize,
    mean: f64,
    /// mean square of their errors
    error: f64,
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
            error,
            spread,
        }
    }

    /// The true speed of one of them, given what was measured.
    fn true_speed(&self, measured: f64, sd: f64) -> TrueSpeed {
        let error = sd * sd;
        let to_mean = error / (error + self.spread);
        let of_mean = (self.spread + self.error) / self.runs as f64;
        let variance = self.spread * to_mean + to_mean * to_mean * of_mean;
        TrueSpeed {
            mean: 1.0 + to_mean * (self.mean / measured - 1.0),
            sd: variance.sqrt() / measured,
            repeats: self.runs,
        }
    }

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
    use std::path::Path;

    use super::*;
    use crate::runs::NewRun;
    use crate::scene;

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

    const SCENE: &str =
        "title = \"speeds\"\n[data]\nruns = \"runs.csv\"\n[particles.PE]\ndensity_kg_m3 = 940\nroughness_um = 5\n[liquids.oil]\n\
                         density_kg_m3 = 965\nviscosity_mPa_s = 50\n";

    /// Runs of these diameters, mm, at these speeds, m/s, that err by 1 cm/s, with a dry run.
    fn found(extra: &str, runs: &[(f64, f64)]) -> (Runs, TrueSpeeds) {
        let scene = scene::parse(&format!("{SCENE}{extra}"), Path::new("a/scene.toml"), String::new()).expect("valid");
        let row = |(diameter, impact_speed): &(f64, f64), wet: bool| NewRun {
            particle: "PE",
            liquid: wet.then_some("oil"),
            diameter: 1e-3 * diameter,
            film: wet.then_some((6e-5 * diameter, 0.06)),
            impact_speed: *impact_speed,
            restitution: 0.5,
        };
        let mut rows = vec![row(&(5.0, 1.0), false)];
        rows.extend(runs.iter().map(|run| row(run, true)));
        let runs = crate::runs::arrange(&scene, &rows);
        let error = RunError {
            impact_speed_sd: 0.01,
            ..RunError::default()
        };
        let errors = vec![error; runs.len()];
        let speeds = runs.true_speeds(&scene, &errors);
        (runs, speeds)
    }

    fn sizes(of: &TrueSpeeds) -> Vec<Vec<usize>> {
        let each = |shared: &SharedSpeed| shared.settings.iter().map(Vec::len).collect();
        of.shared.iter().map(each).collect()
    }

    #[test]
    fn repeats_of_any_diameter_have_one_true_speed() {
        let three = [
            (5.0, 0.99),
            (5.0, 1.01),
            (6.0, 1.0),
            (7.0, 1.01),
            (7.0, 2.0),
            (6.0, 2.01),
        ];
        let (runs, speeds) = found("", &three);
        assert_eq!(sizes(&speeds), [vec![2, 1, 1], vec![1, 1]]);
        // the dry run at 1 m/s is of another kind
        assert!(speeds.shared.iter().flat_map(SharedSpeed::runs).all(|run| run > 0));
        let first = speeds.shared[0]
            .runs()
            .map(|run| runs.impact_speed[run] * speeds.of_run[run].mean);
        assert!(first.into_iter().all(|true_speed| (true_speed - 1.0025).abs() < 1e-12));
        // but not where a series is left out at a time
        let (_, speeds) = found("[model]\nseries_offsets = true\n", &three);
        assert_eq!(sizes(&speeds), [vec![2]]);
    }

    #[test]
    fn speeds_that_scatter_beyond_their_errors_are_told_apart_by_setting() {
        // two drop heights, not a gap apart, each the one of a diameter; and a run of a third
        let apart = [0.99, 1.0, 1.01].map(|v| [(5.0, v), (6.0, v + 0.03)]).concat();
        let (runs, speeds) = found("", &[apart, vec![(7.0, 1.02)]].concat());
        assert_eq!(sizes(&speeds), [vec![3], vec![3]]);
        let alone = (0..runs.len()).find(|run| runs.diameter[*run] == 7e-3).expect("there");
        // drawn to the mean of all, with their spread
        assert_eq!(speeds.of_run[alone].repeats, 7);
    }
}

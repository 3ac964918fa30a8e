//! Tests of the integral over the true speed against a rule of so many nodes that it needs no care.

use rand::rngs::ChaCha8Rng;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;

use super::reach::REACH;
use super::*;
use crate::model::likelihood::run_law::RunNoise;
use crate::physics::dry::Order;
use crate::physics::loss::Share;
use crate::physics::rebound::mean_restitution;
use crate::physics::{DrySpeed, Form, Inertia};
use crate::runs::TrueSpeed;

/// A run with all that its density reads.
#[derive(Debug, Clone, Copy)]
struct Case {
    balance: Balance,
    impact: Impact,
    wet: bool,
    spreads: Spreads,
    errors: Errors,
    e: f64,
}

impl Case {
    fn measured(&self, seen: Seen) -> MeasuredRun {
        MeasuredRun {
            seen,
            errors: self.errors,
        }
    }

    /// Runs of this setting.
    fn setting<'c>(&'c self, runs: &'c [MeasuredRun]) -> SettingRuns<'c> {
        SettingRuns {
            balance: &self.balance,
            impact: self.impact,
            runs,
        }
    }

    /// Runs of settings that share the true speed of this one.
    fn hidden<'c>(&'c self, tails: Tails, settings: &'c [SettingRuns<'c>]) -> HiddenSpeed<'c> {
        HiddenSpeed {
            tails,
            spreads: self.spreads,
            wet: self.wet,
            settings,
        }
    }

    /// The log density of one run, with its slopes.
    fn density(&self, tails: Tails, seen: Seen) -> RunDensity {
        let run = [self.measured(seen)];
        let mut slopes = [SettingSlopes::default()];
        let found = self.hidden(tails, &[self.setting(&run)]).integrate(&mut slopes);
        found.with(slopes[0])
    }

    /// The same at a film or diameter at which the liquid takes so many times as much.
    fn at_other_film(&self, times: f64) -> Case {
        let mut other = *self;
        other.impact.over_stokes *= times;
        other.balance.lost.constant *= times;
        if self.wet {
            let mean = |case: &Case| mean_restitution(case.balance.kept(&case.impact).0);
            other.e += mean(&other) - mean(self);
        }
        other
    }

    /// Repeats of this one, whose measured speeds and restitutions are a little apart.
    fn repeats(&self, count: usize) -> Vec<MeasuredRun> {
        let repeat = |index: usize| {
            let apart = index as f64 / count as f64 - 0.5;
            let moved = 1.0 + self.errors.speed * apart;
            let true_speed = self.errors.true_speed;
            MeasuredRun {
                seen: if index % 4 == 3 && self.wet {
                    Seen::On(Side::Below, 0.0)
                } else {
                    Seen::Rebound(self.e + 2.0 * self.spreads.sigma * apart)
                },
                errors: Errors {
                    true_speed: TrueSpeed {
                        mean: true_speed.mean / moved,
                        sd: true_speed.sd / moved,
                        ..true_speed
                    },
                    ..self.errors
                },
            }
        };
        (0..count).map(repeat).collect()
    }
}

/// Runs from well above the threshold to below it, at speeds that err by 0.3 to 10 %.
fn case(rng: &mut ChaCha8Rng, index: usize, energy: f64) -> Case {
    let dry_speed = [DrySpeed::Impact, DrySpeed::Reference(2.0)][index % 2];
    let form = Form::new(Inertia::Saturating, dry_speed);
    let share = Share {
        inertial: rng.random_range(0.0..0.3),
        viscous: 1.85,
    };
    let wet = !index.is_multiple_of(5);
    let balance = if wet {
        Balance::at(form, 0.15, share, 0.5)
    } else {
        Balance::dry(Order::First, 0.15)
    };
    let at_rest = balance.kept(&Impact {
        dry_root: 1.1,
        over_stokes: 0.0,
        fixed: [0.0; 2],
    });
    // the share kept is this
    let r = if index.is_multiple_of(3) {
        rng.random_range(-0.1..0.5)
    } else {
        rng.random_range(-0.06..0.06)
    };
    let impact = Impact {
        dry_root: 1.1,
        over_stokes: (at_rest.0 - r) / 1.85,
        fixed: [0.0; 2],
    };
    let speed = 10f64.powf(rng.random_range(-2.5..-1.0));
    let errors = Errors {
        speed,
        restitution: rng.random_range(0.0..0.02) * f64::from(u8::from(!index.is_multiple_of(4))),
        correlation: rng.random_range(-0.9..0.9) * f64::from(u8::from(!index.is_multiple_of(2))),
        true_speed: TrueSpeed {
            mean: 1.0 + speed * rng.random_range(-1.0..1.0),
            sd: speed * rng.random_range(0.2..1.0),
            repeats: 5,
        },
        is_shared: false,
    };
    let spreads = Spreads {
        sigma: 10f64.powf(rng.random_range(-2.7..-1.3)),
        energy: if wet { energy } else { 0.0 },
    };
    let case = Case {
        balance,
        impact,
        wet,
        spreads,
        errors,
        e: 0.0,
    };
    let mut z = || -> f64 { StandardNormal.sample(rng) };
    let (of_speed, of_noise) = (z(), z());
    let run = [case.measured(Seen::Rebound(0.0))];
    let setting = [case.setting(&run)];
    let hidden = case.hidden(Tails::Normal, &setting);
    let ratio = errors.ratio(of_speed);
    let mean = hidden.mean(hidden.kept(&setting[0], &setting[0].impact(of_speed)).0).0;
    let e = mean * ratio + errors.shared() * (1.0 - ratio) + hidden.variance(&errors, ratio).sqrt() * of_noise;
    Case { e, ..case }
}

fn cases(name: &str, count: usize, energy: f64) -> Vec<Case> {
    let mut rng = crate::seed::stream(1, name, 0);
    (0..count).map(|index| case(&mut rng, index, energy)).collect()
}

/// The same integral with so many steps, in one variable for the whole line.
fn brute(hidden: &HiddenSpeed, steps: usize) -> f64 {
    let mode = hidden.mode();
    let (lo, hi) = (mode.min(0.0) - REACH, mode.max(0.0) + REACH);
    let step = (hi - lo) / steps as f64;
    let lns: Vec<f64> = (0..=steps)
        .map(|index| hidden.at(lo + step * index as f64).ln)
        .collect();
    let most = lns.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + (lns.iter().map(|ln| (ln - most).exp()).sum::<f64>() * step).ln() - LN_ROOT_TWO_PI
}

fn worst(cases: &[Case], tails: Tails, steps: usize) -> f64 {
    let gap = |case: &Case| {
        let all = [
            Seen::Rebound(case.e),
            Seen::On(Side::Below, 0.05),
            Seen::On(Side::Above, 0.0),
            Seen::Measured(Side::Below, case.e),
            Seen::Measured(Side::Above, case.e),
        ];
        let of = |seen: Seen| {
            let run = [case.measured(seen)];
            let setting = [case.setting(&run)];
            let hidden = case.hidden(tails, &setting);
            let (found, expected) = (hidden.value(), brute(&hidden, steps));
            let gap = (found - expected).abs() / expected.abs().max(1.0);
            assert!(gap < 1e-6, "{case:?} {seen:?}: {found} {expected}");
            gap
        };
        all.into_iter().map(of).fold(0.0, f64::max)
    };
    cases.par_iter().map(gap).reduce(|| 0.0, f64::max)
}

#[test]
fn the_density_is_that_of_very_many_nodes() {
    let cases = cases("speeds_the_density_is_that_of_very_many_nodes", 200, 0.0);
    let gap = worst(&cases, Tails::Normal, 200_000);
    assert!(gap < 1e-7, "{gap:e}");
    let gap = worst(&cases[..60], Tails::of(Some(4.0)), 50_000);
    assert!(gap < 1e-6, "{gap:e}");
}

/// Where a setting turns nearby one rule does for most, alone and repeated, whatever was seen of the runs, unless speeds err by
/// much or spreads are narrow beside the turn.
#[test]
fn near_its_turn_a_setting_takes_one_rule() {
    let (mut near, mut done, mut worst) = (0, 0, 0.0_f64);
    for case in cases("near_its_turn_a_setting_takes_one_rule", 150, 0.0) {
        let one = |seen: Seen| vec![case.measured(seen)];
        let all = [
            one(Seen::Rebound(case.e)),
            one(Seen::On(Side::Below, 0.05)),
            one(Seen::On(Side::Above, 0.0)),
            case.repeats(5),
        ];
        for runs in all {
            let setting = [case.setting(&runs)];
            let hidden = case.hidden(Tails::Normal, &setting);
            if hidden.reach(FALL).turns.is_empty() || hidden.is_certain_within_reach() {
                continue;
            }
            near += 1;
            if let Some(found) = hidden.near_turn(REACH, &mut [SettingSlopes::default()]) {
                let expected = brute(&hidden, 200_000);
                done += 1;
                worst = worst.max((found.value - expected).abs() / expected.abs().max(1.0));
            }
        }
    }
    assert!(near > 200 && 2 * done > near, "{done} of {near}");
    assert!(worst < 1e-7, "{worst:e}");
}

/// Noise on the energy kept besides: in two dimensions.
#[test]
fn the_density_in_two_dimensions_is_that_of_very_many_nodes() {
    for energy in [0.003, 0.04] {
        let cases = cases("the_density_in_two_dimensions", 30, energy);
        let gap = worst(&cases, Tails::Normal, 3000);
        assert!(gap < 1e-6, "{gap:e}");
    }
}

/// The measured numbers have the densities they are drawn from: the mean over e of the density is one, and the error of the
/// rebound speed that goes with that of the impact speed is in it.
#[test]
fn the_density_is_one_in_all_and_has_the_moments_of_its_draws() {
    for case in cases("the_density_is_one_in_all", 12, 0.0) {
        let density = |e: f64| case.density(Tails::Normal, Seen::Rebound(e)).value.exp();
        let (lo, hi, steps) = (-1.5, 2.0, 6000);
        let step = (hi - lo) / f64::from(steps);
        let at = |index: i32| lo + step * f64::from(index);
        let mass: f64 = (0..=steps).map(|index| density(at(index)) * step).sum();
        assert!((mass - 1.0).abs() < 1e-6, "{case:?}: {mass}");
    }
}

#[test]
fn slopes_agree_with_differences() {
    for case in cases("slopes_of_speeds_agree_with_differences", 60, 0.0) {
        for (seen, tails) in [
            (Seen::Rebound(case.e), None),
            (Seen::On(Side::Below, 0.05), None),
            (Seen::On(Side::Above, 0.05), None),
            (Seen::Rebound(case.e), Some(4.0)),
        ] {
            let at = |place: usize, step: f64| {
                let mut moved = case;
                let mut nu = tails;
                match place {
                    0 => moved.spreads.sigma += step,
                    1 => moved.balance.lost.over_stokes += step,
                    2 => moved.balance.dry_k += step,
                    _ => nu = nu.map(|nu| nu + step),
                }
                moved.density(Tails::of(nu), seen)
            };
            let found = at(0, 0.0);
            let slopes = [found.sigma, -found.viscous, found.dry_k, found.nu];
            for (place, (slope, h)) in slopes
                .into_iter()
                .zip([1e-3 * case.spreads.sigma, 4e-6, 4e-6, 1e-2])
                .enumerate()
            {
                if place == 1 && !case.wet || place == 3 && tails.is_none() {
                    continue;
                }
                let of = |step: f64| at(place, step * h).value;
                let difference = (8.0 * (of(1.0) - of(-1.0)) - (of(2.0) - of(-2.0))) / (12.0 * h);
                let unit = h * 500.0;
                let gap = (slope - difference).abs() * unit / (1.0 + (difference * unit).abs());
                assert!(gap < 1e-6, "{case:?} {seen:?} {place}: {slope} {difference}");
            }
        }
    }
}

/// Holds runs of one true speed to brute force, and each of them to what the others say.
fn share_their_true_speed(case: &Case, settings: &[SettingRuns]) {
    let hidden = case.hidden(Tails::Normal, settings);
    let (found, expected) = (hidden.value(), brute(&hidden, 200_000));
    let gap = (found - expected).abs() / expected.abs().max(1.0);
    assert!(gap < 1e-6, "{settings:?}: {found} {expected}");
    let given = hidden.given_the_others();
    for (left_out, own) in given.into_iter().enumerate() {
        let expected = found - hidden.without(left_out);
        // what is left of both is as sure as they are
        let gap = (own - expected).abs() / found.abs().max(1.0);
        assert!(gap < 1e-6, "{settings:?} {left_out}: {own} {expected}");
    }
}

/// Runs of one true speed: their product is integrated over it, once, and each is told given the others.
#[test]
fn repeats_share_their_true_speed() {
    for case in cases("repeats_share_their_true_speed", 60, 0.0) {
        let runs = case.repeats(7);
        share_their_true_speed(&case, &[case.setting(&runs)]);
    }
}

/// The same at films and diameters of their own, which turn at speeds of their own: near one another, far apart, or as one.
#[test]
fn repeats_of_other_settings_share_their_true_speed() {
    let (mut turns, mut most) = (0, 0);
    for (index, case) in cases("repeats_of_other_settings", 90, 0.0).into_iter().enumerate() {
        let apart = [1e-9, 1e-4, 1e-3, 5e-3][index % 4];
        let others: Vec<Case> = (0..MOST_SETTINGS)
            .map(|place| case.at_other_film(1.0 + apart * place as f64))
            .collect();
        let runs: Vec<Vec<MeasuredRun>> = others
            .iter()
            .enumerate()
            .map(|(place, other)| other.repeats(1 + 3 * (place % 2)))
            .collect();
        let settings: Vec<SettingRuns> = others
            .iter()
            .zip(&runs)
            .map(|(other, runs)| other.setting(runs))
            .collect();
        share_their_true_speed(&case, &settings);
        let found = case.hidden(Tails::Normal, &settings).reach(FALL).turns.len();
        turns += usize::from(found > 1);
        most = most.max(found);
    }
    assert!(turns > 10 && most == MOST_SETTINGS, "{turns} {most}");
}

/// The slopes are told setting by setting.
#[test]
fn slopes_of_settings_agree_with_differences() {
    for case in cases("slopes_of_settings_agree_with_differences", 40, 0.0) {
        let of = |moved: usize, step: f64| {
            let others = [1.0, 1.01, 1.02].map(|film| case.at_other_film(film));
            let mut others: Vec<Case> = others.to_vec();
            others[moved].balance.dry_k += step;
            let runs: Vec<Vec<MeasuredRun>> = others.iter().map(|other| other.repeats(2)).collect();
            let settings: Vec<SettingRuns> = others
                .iter()
                .zip(&runs)
                .map(|(other, runs)| other.setting(runs))
                .collect();
            let mut slopes = [SettingSlopes::default(); 3];
            let found = case.hidden(Tails::Normal, &settings).integrate(&mut slopes);
            (found.value, slopes[moved].dry_k)
        };
        for moved in 0..3 {
            const STEP: f64 = 4e-6;
            let value = |steps: f64| of(moved, steps * STEP).0;
            let difference = (8.0 * (value(1.0) - value(-1.0)) - (value(2.0) - value(-2.0))) / (12.0 * STEP);
            let slope = of(moved, 0.0).1;
            let gap = (slope - difference).abs() / (500.0 + difference.abs());
            assert!(gap < 1e-6, "{case:?} {moved}: {slope} {difference}");
        }
    }
}

/// Where a search for the mode may try them: nothing is returned that could pass for a density, and nothing panics.
#[test]
fn parameters_beyond_all_numbers_have_no_density() {
    let mut rng = crate::seed::stream(1, "parameters_beyond_all_numbers_have_no_density", 0);
    for index in 0..8 {
        let good = case(&mut rng, index, if index % 2 == 0 { 0.03 } else { 0.0 });
        for odd in [f64::NAN, f64::INFINITY] {
            let mut bad = [good; 4];
            bad[0].spreads.sigma = odd;
            bad[1].spreads.energy = odd;
            bad[2].balance.lost.over_stokes = odd;
            bad[3].balance.dry_k = odd;
            for (place, case) in bad.into_iter().enumerate() {
                let seen = [
                    Seen::Rebound(case.e),
                    Seen::On(Side::Below, 0.05),
                    Seen::On(Side::Above, 0.05),
                ];
                for tails in [Tails::Normal, Tails::of(Some(4.0))] {
                    for seen in seen {
                        let found = case.density(tails, seen);
                        let all = found.value + found.kept + found.sigma;
                        // what is certain to stick may say so, and what a run does not feel is none of it
                        let no_noise = place == 1 && odd.is_nan() || !case.wet && (place == 1 || place == 2);
                        let is_side = matches!(seen, Seen::On(..)) || no_noise;
                        assert!(
                            is_side || !all.is_finite(),
                            "{place} {odd} {tails:?} {seen:?} {found:?}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn integrals_side_by_side_are_those_by_themselves() {
    let spreads = Spreads {
        sigma: 0.012,
        energy: 0.0,
    };
    let noise = RunNoise {
        tails: Tails::Normal,
        spreads,
        wet: true,
    };
    let all = cases("integrals_side_by_side", 900, 0.0);
    for own_speed in [false, true] {
        let some = all
            .iter()
            .filter(|case| case.wet && case.balance.own_speed == own_speed);
        let some: Vec<Case> = some.map(|case| Case { spreads, ..*case }).collect();
        // each alone, or with others at other films
        let films = |case: &Case, number: usize| -> Vec<Case> {
            let other = |film: usize| case.at_other_film(1.0 - 0.1 * film as f64);
            (0..1 + number % 4).map(other).collect()
        };
        let with = |number: usize, of: &mut dyn FnMut(&[SettingRuns])| {
            let films = films(&some[number], number);
            let runs: Vec<[MeasuredRun; 1]> = films
                .iter()
                .map(|film| [film.measured(Seen::Rebound(film.e))])
                .collect();
            let settings = films.iter().zip(&runs).map(|(film, runs)| film.setting(runs));
            of(&settings.collect::<Vec<SettingRuns>>());
        };
        // four places for each, of which those that are not filled are not asked for
        let mut balances = vec![];
        for (number, case) in some.iter().enumerate() {
            balances.extend(films(case, number).iter().map(|film| film.balance));
            balances.resize(4 * number + 4, case.balance);
        }
        let mut many = ManySpeeds::new(&noise, &balances);
        let mut together = Together::default();
        for number in 0..some.len() {
            let places: Vec<usize> = (4 * number..4 * number + 4).collect();
            with(number, &mut |settings| {
                let runs = SpeedRuns {
                    settings,
                    balances: &places,
                    number,
                    times: -1.0,
                };
                // half of them are gathered once
                if number % 2 == 0 || !together.push(&runs) {
                    many.push(runs);
                }
            });
        }
        many.take(&together);
        let found = many.finish();
        assert!(
            found.left.len() < some.len() / 2,
            "{} of {}",
            found.left.len(),
            some.len()
        );
        let mut expected = RunDensity::default();
        for number in (0..some.len()).filter(|number| !found.left.contains(number)) {
            with(number, &mut |settings| {
                let mut each = [SettingSlopes::default(); 4];
                let each = &mut each[..settings.len()];
                let of = noise.hidden(settings).integrate(each);
                expected.value -= of.value;
                expected.sigma -= of.sigma;
                for (found, of) in found.slopes[4 * number..].iter().zip(each) {
                    for (found, of) in [
                        (found.kept, of.kept),
                        (found.viscous, of.viscous),
                        (found.dry_k, of.dry_k),
                    ] {
                        assert!((found + of).abs() < 1e-7 * (1.0 + of.abs()), "{number}: {found} {of}");
                    }
                }
            });
        }
        for (found, of) in [(found.all.value, expected.value), (found.all.sigma, expected.sigma)] {
            assert!((found - of).abs() < 1e-8 * of.abs(), "{found} {of}");
        }
    }
}

//! Holds what is said of the scatter of the runs against simulated runs whose scatter is known.

mod common;

use common::{binomial_z, seed_of, Place};
use rand_distr::{Distribution, StandardNormal};
use wetcor::findings::noise::{Noise, Outlier, FALSE_ALARM, LINE};
use wetcor::findings::{self, Findings};
use wetcor::model::simulate::Simulation;
use wetcor::runs::{self, MeasurementErrors, NewRun, Table};
use wetcor::scene::Scene;
use wetcor::seed::stream;

/// Two particles, two liquids, two film ratios, three diameters, five speeds clear of the threshold.
struct Design {
    model: &'static str,
    bootstrap: &'static str,
    particles: &'static [&'static str],
    films: &'static str,
    diameters: &'static str,
    speeds: &'static str,
    dry_speeds: &'static str,
    repeats: u32,
    /// sd of the truth's own noise on wet runs
    sigma: f64,
}

const USUAL: Design = Design {
    model: "inertia = \"stepwise\"",
    bootstrap: "",
    particles: &["PTFE", "PE"],
    films: "0.06, 0.1",
    diameters: "4.0, 5.0, 6.0",
    speeds: "1.8, 2.1, 2.4, 2.7, 3.0",
    dry_speeds: "0.4, 0.8, 1.2, 1.6, 2.0",
    repeats: 5,
    sigma: 1e-12,
};

const SIGMA: f64 = 0.02;

impl Design {
    /// The scene. Its truth usually has no noise to speak of: a test adds its own.
    fn place(&self) -> Place {
        let each = |what: &str| -> String {
            let of = |name: &&str| format!("{name} = [{what}]");
            self.particles.iter().map(of).collect::<Vec<_>>().join(", ")
        };
        Place::new(&format!(
            "title = \"noise\"\n[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n\
             [particles.PE]\ndensity_kg_m3 = 940\nroughness_um = 5\n[liquids.AK10]\ndensity_kg_m3 = 930\n\
             viscosity_mPa_s = 9.3\n[liquids.AK20]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 18.6\n\
             [model]\n{}\n[bootstrap]\n{}\n\
             [truth]\ndry_k = {{ PTFE = 0.15, PE = 0.12 }}\nlubrication_log = 1.85\ninertia = \"stepwise\"\n\
             inertial_prefactor = 1.0\nsigma_dry = {}\nsigma_wet = {}\n\
             [design]\ndiameter_mm = {{ {} }}\nliquids = [\"AK10\", \"AK20\"]\nfilm_ratio = {{ {} }}\n\
             impact_speed_m_s = [{}]\ndry_impact_speed_m_s = [{}]\nrepeats = {}\n",
            self.model,
            self.bootstrap,
            0.5 * self.sigma,
            self.sigma,
            each(self.diameters),
            each(self.films),
            self.speeds,
            self.dry_speeds,
            self.repeats
        ))
    }
}

/// The runs of the design, with the truth's own noise.
fn drawn(scene: &Scene, seed: u64) -> Vec<NewRun<'_>> {
    let simulation = Simulation::new(scene, None).expect("a truth and a design");
    let mut drawn = vec![];
    let keep = |run| {
        drawn.push(run);
        Ok(())
    };
    simulation.draw(seed, keep).expect("a place in memory");
    drawn
}

/// The same with normal noise whose sd each run is asked for.
fn scattered<'s>(exact: &[NewRun<'s>], seed: u64, sd: impl Fn(&NewRun) -> f64) -> Vec<NewRun<'s>> {
    let mut rng = stream(seed, "noise of a test", 0);
    let scatter = |run: &NewRun<'s>| {
        let z: f64 = StandardNormal.sample(&mut rng);
        let mut run = *run;
        run.restitution = f64::max(run.restitution + sd(&run) * z, 0.0);
        run
    };
    exact.iter().map(scatter).collect()
}

fn plain(run: &NewRun) -> f64 {
    if run.liquid.is_some() {
        SIGMA
    } else {
        0.5 * SIGMA
    }
}

/// Fits runs as if a file had held them.
fn fit(scene: &Scene, runs: &[NewRun], (seed, bootstrap): (u64, bool)) -> Findings {
    let table = Table {
        runs: runs::arrange(scene, runs),
        rows: runs.len(),
        screened: vec![],
        notices: vec![],
        sha256: String::new(),
    };
    findings::find(scene, &table, seed, bootstrap)
}

fn noise_of(findings: &Findings) -> &Noise {
    findings.noise.as_ref().expect("a fit with scatter")
}

fn tells(findings: &Findings, code: &str) -> bool {
    findings.notices.iter().any(|notice| notice.code == code)
}

/// Series of a run, as a number; `None` for dry runs.
fn series_of(run: &NewRun) -> Option<String> {
    let (_, ratio) = run.film?;
    Some(format!("{} {:?} {:.6} {ratio}", run.particle, run.liquid, run.diameter))
}

/// Adds an offset to each series, normal of this sd.
fn offset(runs: &mut [NewRun], seed: u64, sd: f64) {
    let mut rng = stream(seed, "offsets of a test", 0);
    let mut known: Vec<(String, f64)> = vec![];
    for run in runs {
        let Some(name) = series_of(run) else { continue };
        let at = known.iter().position(|(other, _)| *other == name).unwrap_or_else(|| {
            let z: f64 = StandardNormal.sample(&mut rng);
            known.push((name, sd * z));
            known.len() - 1
        });
        run.restitution += known[at].1;
    }
}

/// The claims under the noise every interval assumes: alarms as rare as they are said to be, and an exact test of the
/// offsets whose probabilities are even over [0, 1].
#[test]
fn plain_noise_alarms_as_rarely_as_claimed() {
    const SETS: u64 = 600;
    let place = USUAL.place();
    let exact = drawn(&place.scene, 1);
    let (mut outliers, mut notices) = (0, [0; 2]);
    let mut below: [[usize; 3]; 2] = [[0; 3]; 2];
    let levels = [0.01, 0.1, 0.5];
    for set in 0..SETS {
        let seed = seed_of("plain_noise_alarms_as_rarely_as_claimed").wrapping_add(set);
        let found = fit(&place.scene, &scattered(&exact, seed, plain), (1, false));
        let noise = noise_of(&found);
        outliers += usize::from(noise.outliers_found > 0);
        assert_eq!(tells(&found, "outlier"), noise.outliers_found > 0);
        let [spread, offsets] = [
            &noise.spread.as_ref().expect("groups").test,
            &noise.offsets.as_ref().expect("series").test,
        ];
        for (below, test) in below.iter_mut().zip([spread, offsets]) {
            for (below, level) in below.iter_mut().zip(levels) {
                *below += usize::from(test.p < level);
            }
        }
        for (count, code) in notices.iter_mut().zip(["unequal_spread", "series_offsets"]) {
            *count += usize::from(tells(&found, code));
        }
    }
    println!("outliers {outliers}, p of spreads and offsets below {levels:?}: {below:?}, notices {notices:?}");
    let z = |count: usize, level: f64| binomial_z(count, SETS as usize, level);
    assert!(z(outliers, FALSE_ALARM).abs() < 4.0, "{outliers}");
    for (level, count) in levels.into_iter().zip(below[1]) {
        assert!(z(count, level).abs() < 4.0, "offsets: {count} below {level}");
    }
    for (level, count) in levels.into_iter().zip(below[0]) {
        assert!(z(count, level) < 4.0, "spreads: {count} below {level}");
    }
    for count in notices {
        assert!(z(count, 0.01) < 4.0, "{count}");
    }
}

/// Few runs: the scale by medians is off by a third or more, and no more of the tables have an outlier for it.
#[test]
fn few_runs_raise_no_more_alarms() {
    const SETS: u64 = 1500;
    for repeats in [1, 2] {
        let design = Design {
            particles: &["PE"],
            films: "0.06",
            diameters: "5.0",
            repeats,
            ..USUAL
        };
        let place = design.place();
        let exact = drawn(&place.scene, 1);
        let mut outliers = 0;
        for set in 0..SETS {
            let seed = seed_of("few_runs_raise_no_more_alarms").wrapping_add(set);
            let found = fit(&place.scene, &scattered(&exact, seed, plain), (1, false));
            outliers += usize::from(noise_of(&found).outliers_found > 0);
        }
        println!("{outliers} of {SETS} tables of {} runs", exact.len());
        let z = binomial_z(outliers, SETS as usize, FALSE_ALARM);
        assert!(z.abs() < 4.0, "{outliers}: {z}");
    }
}

/// Wherever it lies in [0, 1], and stuck or not.
#[test]
fn an_outlier_is_named() {
    let place = USUAL.place();
    let exact = drawn(&place.scene, 1);
    let seed = seed_of("an_outlier_is_named");
    for (index, e) in [0.0, 0.05, 0.3, 0.6, 1.0].into_iter().enumerate() {
        for dry in [true, false] {
            let mut runs = scattered(&exact, seed.wrapping_add(index as u64), plain);
            let fits = |run: &NewRun| run.liquid.is_none() == dry && (run.restitution - e).abs() > 8.0 * plain(run);
            // not the first: a row that is always the same is no proof
            let at = (0..runs.len())
                .filter(|run| fits(&runs[*run]))
                .nth(30 + index)
                .expect("such a run");
            let expected = exact[at].restitution;
            runs[at].restitution = e;
            let found = fit(&place.scene, &runs, (1, false));
            let noise = noise_of(&found);
            assert_eq!(noise.outliers_found, 1, "{e}: {:?}", noise.outliers);
            let one = &noise.outliers[0];
            assert_eq!((one.row as usize, one.restitution), (at + 1, e), "{one:?}");
            assert!((one.expected - expected).abs() < 0.01, "{one:?} {expected}");
            let sds = (e - expected) / plain(&runs[at]);
            assert!(
                (one.sds / sds - 1.0).abs() < 0.2 && one.moves_in_se > 0.0,
                "{one:?} {sds}"
            );
            let notice = found
                .notices
                .iter()
                .find(|notice| notice.code == "outlier")
                .expect("it is told");
            assert!(
                notice.text.contains(&format!("row {} of the table", at + 1)),
                "{}",
                notice.text
            );
        }
    }
}

/// Where no k is known, or the runs cannot tell all parameters apart, there are restitutions to be expected all the same.
#[test]
fn an_outlier_is_named_where_not_every_parameter_is_known() {
    const SETS: u64 = 200;
    let one_film = Design {
        model: "inertia = \"saturating\"",
        films: "0.06",
        ..USUAL
    };
    for (design, has_dry) in [(USUAL, false), (one_film, true)] {
        let place = design.place();
        let mut exact = drawn(&place.scene, 1);
        exact.retain(|run| has_dry || run.liquid.is_some());
        let mut alarms = [0; 3];
        for set in 0..SETS {
            let seed = seed_of("an_outlier_is_named_where_not_every_parameter_is_known").wrapping_add(set);
            let mut runs = scattered(&exact, seed, plain);
            let found = fit(&place.scene, &runs, (1, false));
            for (count, code) in alarms.iter_mut().zip(["outlier", "unequal_spread", "series_offsets"]) {
                *count += usize::from(tells(&found, code));
            }
            let at = runs.len() / 2;
            runs[at].restitution -= 0.25;
            let found = fit(&place.scene, &runs, (1, false));
            let named = |one: &Outlier| one.row as usize == at + 1;
            assert!(
                noise_of(&found).outliers.iter().any(named),
                "{set}: {:?}",
                noise_of(&found)
            );
        }
        println!("{alarms:?} of {SETS}");
        for count in alarms {
            assert!(binomial_z(count, SETS as usize, 0.01) < 4.0, "{alarms:?}");
        }
    }
}

/// What is said of the parameter it moves most is what a fit without the run does.
#[test]
fn the_move_is_that_of_a_fit_without_the_run() {
    let design = Design { repeats: 2, ..USUAL };
    let place = design.place();
    let exact = drawn(&place.scene, 1);
    let mut runs = scattered(&exact, seed_of("the_move_is_that_of_a_fit_without_the_run"), plain);
    let at = 110;
    runs[at].restitution -= 0.2;
    let with = fit(&place.scene, &runs, (1, false));
    let one = noise_of(&with).outliers[0].clone();
    assert_eq!(one.row as usize, at + 1);
    runs.remove(at);
    let without = fit(&place.scene, &runs, (1, false));
    let of = |findings: &Findings| {
        let balance = findings.energy_balance.as_ref().expect("a balance");
        let found = balance.parameters.iter().find(|parameter| parameter.name == one.moves);
        found.expect("its parameter").estimate.pair().expect("a number")
    };
    let (after, se) = of(&without);
    let moved = (of(&with).0 - after).abs() / se;
    assert!((one.moves_in_se / moved - 1.0).abs() < 0.1, "{one:?} {moved}");
}

/// Twelve mistakes, half of them in one series of fifteen runs: none hides another.
#[test]
fn outliers_do_not_hide_each_other() {
    let place = USUAL.place();
    let exact = drawn(&place.scene, 1);
    let mut runs = scattered(&exact, seed_of("outliers_do_not_hide_each_other"), plain);
    let one = series_of(&exact[400]);
    let of_one = (0..runs.len()).filter(|run| series_of(&exact[*run]) == one).step_by(4);
    let mut bad: Vec<usize> = of_one.take(6).chain([10, 31, 200, 250, 300, 350]).collect();
    for (index, run) in bad.iter().enumerate() {
        runs[*run].restitution += [0.25, -0.3, 0.2][index % 3];
    }
    let found = fit(&place.scene, &runs, (1, false));
    let noise = noise_of(&found);
    assert_eq!(noise.outliers_found, 12, "{:?}", noise.outliers);
    bad.sort_unstable();
    for outlier in &noise.outliers {
        assert!(bad.binary_search(&(outlier.row as usize - 1)).is_ok(), "{outlier:?}");
    }
    let notice = found
        .notices
        .iter()
        .find(|notice| notice.code == "outlier")
        .expect("they are told");
    assert!(
        notice.count == 12 && notice.text.ends_with("and 9 more"),
        "{}",
        notice.text
    );
    // they are taken out before spreads and offsets are looked at
    assert!(!tells(&found, "unequal_spread") && !tells(&found, "series_offsets"));
}

/// Student's t has room for them.
#[test]
fn under_a_student_likelihood_no_outlier_is_told() {
    let design = Design {
        model: "inertia = \"stepwise\"\nlikelihood = \"student\"",
        ..USUAL
    };
    let place = design.place();
    let mut runs = scattered(&drawn(&place.scene, 1), seed_of("under_a_student_likelihood"), plain);
    runs[200].restitution -= 0.3;
    let found = fit(&place.scene, &runs, (1, false));
    assert_eq!((noise_of(&found).outliers_found, tells(&found, "outlier")), (0, false));
}

/// A run whose table says that it was measured badly is not far for lying further away; without that it would be.
#[test]
fn runs_are_held_against_their_own_measurement_errors() {
    let place = USUAL.place();
    let exact = drawn(&place.scene, 1);
    let own = 8.0 * SIGMA;
    // every seventh run
    let badly = |row: u32| row.is_multiple_of(7);
    let mut count = 0;
    let wider = |run: &NewRun| f64::hypot(plain(run), own);
    let all = scattered(
        &exact,
        seed_of("runs_are_held_against_their_own_measurement_errors"),
        plain,
    );
    let wide = scattered(
        &exact,
        seed_of("runs_are_held_against_their_own_measurement_errors"),
        wider,
    );
    let mut runs = all;
    for (index, (run, wide)) in runs.iter_mut().zip(wide).enumerate() {
        if badly(index as u32 + 1) {
            *run = wide;
            count += 1;
        }
    }
    let mut table = Table {
        runs: runs::arrange(&place.scene, &runs),
        rows: runs.len(),
        screened: vec![],
        notices: vec![],
        sha256: String::new(),
    };
    let unknown = findings::find(&place.scene, &table, 1, false);
    let outliers = noise_of(&unknown).outliers_found;
    assert!(outliers > count / 6, "{outliers} of {count}");
    let of_run = |row: &u32| if badly(*row) { own } else { 0.0 };
    table.runs.errors = Some(MeasurementErrors {
        impact_speed_sd: vec![0.0; runs.len()],
        restitution_sd: table.runs.row.iter().map(of_run).collect(),
    });
    let known = findings::find(&place.scene, &table, 1, false);
    assert_eq!(noise_of(&known).outliers_found, 0, "{:?}", noise_of(&known).outliers);
}

/// Near the threshold runs stick or bounce by luck, which is no mistake; one that sticks far above it is.
#[test]
fn runs_that_stick_near_the_threshold_raise_no_alarm() {
    const SETS: u64 = 200;
    let design = Design {
        speeds: "0.35, 0.45, 0.55, 0.7, 0.9, 1.2, 1.6",
        sigma: SIGMA,
        ..USUAL
    };
    let place = design.place();
    let (mut alarms, mut stuck, mut all) = ([0; 3], 0, 0);
    for set in 0..SETS {
        let seed = seed_of("runs_that_stick_near_the_threshold_raise_no_alarm").wrapping_add(set);
        let mut runs = drawn(&place.scene, seed);
        all += runs.len();
        stuck += runs.iter().filter(|run| run.restitution == 0.0).count();
        let found = fit(&place.scene, &runs, (1, false));
        for (count, code) in alarms.iter_mut().zip(["outlier", "unequal_spread", "series_offsets"]) {
            *count += usize::from(tells(&found, code));
        }
        let fast = |run: &NewRun| run.liquid.is_some() && run.restitution > 0.5;
        let at = runs.iter().position(fast).expect("a fast run");
        runs[at].restitution = 0.0;
        let found = fit(&place.scene, &runs, (1, false));
        let named = |one: &Outlier| one.row as usize == at + 1;
        assert!(noise_of(&found).outliers.iter().any(named), "{set}");
    }
    println!("{alarms:?} of {SETS} tables, in which {stuck} of {all} runs stuck");
    assert!(stuck * 50 > all);
    for count in alarms {
        assert!(binomial_z(count, SETS as usize, 0.01) < 4.0, "{alarms:?}");
    }
}

/// Three times the spread for one particle is told, with the sds; a twentieth more is none of the reader's business.
#[test]
fn unequal_spreads_are_told_when_they_matter() {
    const SETS: u64 = 50;
    let place = USUAL.place();
    let exact = drawn(&place.scene, 1);
    let told = |factor: f64| {
        let count = |set: &u64| {
            let seed = seed_of("unequal_spreads_are_told_when_they_matter").wrapping_add(*set);
            let wider = |run: &NewRun| {
                if run.particle == "PE" {
                    factor * plain(run)
                } else {
                    plain(run)
                }
            };
            let found = fit(&place.scene, &scattered(&exact, seed, wider), (1, false));
            let noise = noise_of(&found);
            let spread = noise.spread.as_ref().expect("groups");
            if factor > 2.0 {
                let ends = (spread.widest.particle.as_str(), spread.narrowest.particle.as_str());
                assert_eq!(ends, ("PE", "PTFE"));
                let sd = if spread.widest.liquid.is_some() {
                    SIGMA
                } else {
                    0.5 * SIGMA
                };
                assert!((spread.widest.sd / (factor * sd) - 1.0).abs() < 0.4, "{spread:?}");
                assert!(spread.worst().expect("a parameter").ratio > LINE, "{spread:?}");
                // each group has a spread of its own: its tails are no outliers
                assert!(noise.outliers_found < 3, "{:?}", noise.outliers);
            }
            tells(&found, "unequal_spread")
        };
        (0..SETS).filter(count).count()
    };
    assert_eq!(told(3.0), SETS as usize);
    let slight = told(1.05);
    assert!(binomial_z(slight, SETS as usize, 0.01) < 4.0, "{slight}");
}

/// The factor is what the standard error lacks: the spread of the estimate over many tables.
#[test]
fn the_factor_is_what_a_standard_error_lacks() {
    const SETS: u64 = 600;
    let place = USUAL.place();
    let exact = drawn(&place.scene, 1);
    let name = seed_of("the_factor_is_what_a_standard_error_lacks");
    // for unequal spreads, and for shared offsets
    for offsets in [false, true] {
        let names = ["lubrication_log", "inertial_prefactor"];
        let mut values: [Vec<f64>; 2] = Default::default();
        let (mut ses, mut ratios) = (values.clone(), values.clone());
        for set in 0..SETS {
            let seed = name.wrapping_add(set);
            let wider = |run: &NewRun| match run.particle {
                "PE" if !offsets && run.liquid.is_some() => 3.0 * SIGMA,
                _ => plain(run),
            };
            let mut runs = scattered(&exact, seed, wider);
            if offsets {
                offset(&mut runs, seed, 0.5 * SIGMA);
            }
            let found = fit(&place.scene, &runs, (1, false));
            let balance = found.energy_balance.as_ref().expect("a balance");
            let noise = noise_of(&found);
            let lacking = if offsets {
                &noise.offsets.as_ref().expect("series").standard_errors
            } else {
                &noise.spread.as_ref().expect("groups").standard_errors
            };
            for (index, name) in names.into_iter().enumerate() {
                let of = balance.parameters.iter().find(|parameter| parameter.name == name);
                let (value, se) = of.expect("a parameter").estimate.pair().expect("a number");
                values[index].push(value);
                ses[index].push(se);
                let of = lacking.iter().find(|lacking| lacking.parameter == name);
                ratios[index].push(of.expect("a parameter").ratio);
            }
        }
        for (index, name) in names.into_iter().enumerate() {
            let sd = common::mean(&values[index]).1 * (SETS as f64).sqrt();
            let lacks = sd / common::mean(&ses[index]).0;
            let told = common::mean(&ratios[index]).0;
            println!("offsets {offsets}, {name}: lacks {lacks:.3}, told {told:.3}");
            // one standard error of an sd of so many sets
            let se = lacks / (2.0 * SETS as f64).sqrt();
            assert!(((lacks - told) / se).abs() < 4.0, "{name}: {lacks} {told}");
            // the planted fault: nothing lacking
            assert!((lacks - 1.0) / se > 5.0, "{name}: {lacks}");
        }
    }
}

/// Where series share offsets this is told, and what is recommended helps: intervals of the `series` bootstrap cover,
/// those of the `cases` bootstrap, the planted fault, do not.
#[test]
fn shared_offsets_are_told_and_the_series_bootstrap_covers_them() {
    const SETS: u64 = 200;
    let of_scheme = |scheme: &'static str| {
        let design = Design {
            bootstrap: scheme,
            particles: &["PE"],
            films: "0.06",
            diameters: "3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0",
            repeats: 3,
            ..USUAL
        };
        let place = design.place();
        let exact = drawn(&place.scene, 1);
        // without noise the law returns its own truth
        let truth = fit(&place.scene, &scattered(&exact, 1, |_| 1e-9), (1, false));
        let of = |findings: &Findings| {
            let laws = findings.scaling.iter();
            let law = laws
                .filter(|row| row.law == "sqrt")
                .find(|row| row.film_ratio.is_some());
            let law = law.expect("the film ratio");
            [law.e_inf.clone(), law.st_c.clone()]
        };
        let truth = of(&truth).map(|estimate| estimate.value.expect("a number"));
        let (mut covered, mut told) = ([0; 2], 0);
        for set in 0..SETS {
            let seed = seed_of("shared_offsets_are_told").wrapping_add(set);
            let mut runs = scattered(&exact, seed, plain);
            offset(&mut runs, seed, 0.5 * SIGMA);
            let found = fit(&place.scene, &runs, (seed, true));
            told += usize::from(tells(&found, "series_offsets"));
            for ((covered, truth), estimate) in covered.iter_mut().zip(truth).zip(of(&found)) {
                let [lo, hi] = estimate.interval.expect("an interval");
                *covered += usize::from((lo..=hi).contains(&truth));
            }
        }
        println!("{scheme}: told {told}, covered {covered:?} of {SETS}");
        (told, covered)
    };
    let (told, series) = of_scheme("scheme = \"series\"\nreplicates = 400");
    let (_, cases) = of_scheme("scheme = \"cases\"\nreplicates = 400");
    assert!(told * 20 > SETS as usize * 19, "{told}");
    for (series, cases) in series.into_iter().zip(cases) {
        let z = |count| binomial_z(count, SETS as usize, 0.95);
        assert!(z(series).abs() < 4.0, "{series}: {}", z(series));
        assert!(z(cases) < -8.0, "{cases}: {}", z(cases));
    }
}

/// One series, series of one run, a handful of runs, none that scatter: no test where there is nothing to test.
#[test]
fn where_nothing_can_be_told_nothing_is() {
    let one = Design {
        particles: &["PE"],
        films: "0.06",
        diameters: "5.0",
        ..USUAL
    };
    let single = Design {
        speeds: "2.4",
        repeats: 1,
        ..USUAL
    };
    let seed = seed_of("where_nothing_can_be_told_nothing_is");
    for design in [one, single] {
        let place = design.place();
        let exact = drawn(&place.scene, 1);
        let mut runs = scattered(&exact, seed, plain);
        runs.retain(|run| run.liquid != Some("AK20"));
        let found = fit(&place.scene, &runs, (1, false));
        let noise = noise_of(&found);
        assert!(
            noise.offsets.as_ref().is_none_or(|offsets| offsets.test.p > 0.001),
            "{noise:?}"
        );
        assert!(
            !tells(&found, "series_offsets") && !tells(&found, "unequal_spread"),
            "{noise:?}"
        );
        for few in 1..12 {
            let found = fit(&place.scene, &runs[runs.len() - few..], (1, false));
            assert!(found.noise.is_none_or(|noise| noise.outliers_found == 0));
            fit(&place.scene, &runs[..few], (1, false));
        }
    }
    let place = USUAL.place();
    let found = fit(&place.scene, &drawn(&place.scene, 1), (1, false));
    assert!(found
        .noise
        .is_none_or(|noise| noise.outliers_found == 0 && noise.offsets.is_none_or(|one| one.share < 1.0)));
}

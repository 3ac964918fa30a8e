//! Holds how rows are taken that are no single runs: means of several, totals, repeats, and columns that say a thing twice.

use std::fmt::Write;

use crate::common::scenes::{design, scene_of, truth, STEPWISE, THIN};
use crate::common::{self, cells, rows, Folder, Place, Says, Told};
use wetcor::findings::posterior::MethodChoice;
use wetcor::findings::verdicts::quotable;
use wetcor::findings::Findings;
use wetcor::physics::Quantity::{EInf, StC};
use wetcor::runs::NewRun;
use wetcor::scene::Scene;

/// Two liquids and three films, six runs of each setting.
fn scene_text() -> String {
    let thick = "[liquids.thick]\ndensity_kg_m3 = 960\nviscosity_mPa_s = 20\n";
    let sampler = "[sampler]\nwarmup = 400\ndraws = 500\n";
    let truth = truth([1.85, 0.8, 0.008, 0.015], "");
    let speeds = ["30, 60, 90, 120, 150", "0.4, 0.8, 1.2, 1.6, 2.0"];
    let design = design(
        ["4.762", "0.04, 0.06, 0.08"],
        &["thin", "thick"],
        speeds,
        "repeats = 6\n",
    );
    let parts = [
        "columns = { run = \"trial\" }\n",
        "[particles.PTFE]\ndensity_kg_m3 = 2150\n",
        THIN,
        thick,
    ];
    scene_of("rows", &[&parts.concat(), STEPWISE, sampler, &truth, &design])
}

const REPEATS: usize = 6;

fn place() -> Place {
    Place::new(&scene_text().replace("columns = { run = \"trial\" }\n", ""))
}

const HEADER: &str = "particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution";

/// The runs of each setting of the design, those of which none stuck.
fn settings(scene: &Scene, seed: u64) -> Vec<Vec<NewRun<'_>>> {
    let all = rows(scene, seed);
    let mut settings: Vec<Vec<NewRun>> = vec![];
    for run in all {
        let is_same = |own: &&mut Vec<NewRun>| cells(&own[0]) == cells(&run);
        match settings.iter_mut().find(is_same) {
            Some(own) => own.push(run),
            None => settings.push(vec![run]),
        }
    }
    assert!(settings.iter().all(|own| own.len() == REPEATS));
    settings.retain(|own| own.iter().all(|run| run.restitution > 0.15));
    assert!(settings.len() > 25, "{}", settings.len());
    settings
}

fn single_runs(settings: &[Vec<NewRun>]) -> String {
    let lines = settings.iter().flatten();
    let lines: Vec<String> = lines.map(|run| format!("{},{}", cells(run), run.restitution)).collect();
    format!("{HEADER}\n{}\n", lines.join("\n"))
}

/// The same as means, with a spread in a column of this name.
fn means(settings: &[Vec<NewRun>], column: &str, of_sd: impl Fn(f64) -> f64) -> String {
    let mut text = format!("{HEADER},{column},runs\n");
    for own in settings {
        let n = own.len() as f64;
        let mean = own.iter().map(|run| run.restitution).sum::<f64>() / n;
        let squares: f64 = own.iter().map(|run| (run.restitution - mean).powi(2)).sum();
        let sd = (squares / (n - 1.0)).sqrt();
        writeln!(text, "{},{mean},{},{n}", cells(&own[0]), of_sd(sd)).expect("a text");
    }
    text
}

/// Every main estimate of least squares with its standard error.
fn estimates(found: &Findings) -> Vec<(f64, f64)> {
    let dry = found.dry.iter().map(|dry| (dry.dry_k.value, dry.dry_k.se));
    let scaling = found.scaling.iter().flat_map(|law| {
        let both = [EInf, StC].map(|quantity| &law.estimates[quantity]);
        both.map(|estimate| (estimate.value, estimate.se))
    });
    let both = dry.chain(scaling).filter_map(|(value, se)| Some((value?, se?)));
    let main = found.main.parameters.iter();
    let main = main.filter_map(|parameter| Some((parameter.number.value?, parameter.number.se?)));
    both.chain(main).collect()
}

#[test]
fn means_give_what_the_single_runs_give() {
    let place = place();
    let settings = settings(&place.scene, common::seed_of("means of runs"));
    let root = (REPEATS as f64).sqrt();
    let mut single = place.fit_rows(&single_runs(&settings));
    let expected = estimates(&single);
    assert!(expected.len() > 10, "{expected:?}");
    let far = |found: &Findings| {
        let each = estimates(found).into_iter().zip(&expected);
        let each = each.map(|(own, other)| {
            let value = (own.0 - other.0).abs() / other.1;
            value.max((own.1 / other.1 - 1.0).abs())
        });
        each.fold(0.0, f64::max)
    };
    for text in [
        means(&settings, "restitution_sd_of_runs", |sd| sd),
        means(&settings, "restitution_se", |sd| sd / root),
    ] {
        let found = place.fit_rows(&text);
        assert_eq!(found.counts.runs, single.counts.runs);
        assert_eq!(found.counts.used, single.counts.used);
        assert!(far(&found) < 1e-9, "{}", far(&found));
        let (rows, runs) = (settings.len(), single.counts.runs);
        let words = format!("{rows} rows are means and stand for {runs} runs");
        assert!(found.notices().any(|notice| notice.text.contains(&words)), "{words}");
    }
    // a standard error taken for the sd of single runs
    let twin = place.fit_rows(&means(&settings, "restitution_sd_of_runs", |sd| sd / root));
    assert!(far(&twin) > 0.3, "{}", far(&twin));

    let sample = |text: &str, found: &mut Findings| {
        std::fs::write(&place.scene.data.runs[0].path, text).expect("the folder is writable");
        let sampled = found.add_posterior(&place.scene, &place.read().runs, MethodChoice::Sampler, &|_, _| ());
        assert!(sampled.is_ok_and(|sampled| sampled.is_some()));
    };
    sample(&single_runs(&settings), &mut single);
    let text = means(&settings, "restitution_se", |sd| sd / root);
    let mut averaged = place.fit_rows(&text);
    sample(&text, &mut averaged);
    assert!(quotable(&single.remarks) && quotable(&averaged.remarks));
    for (own, other) in estimates(&averaged).iter().zip(estimates(&single)) {
        assert!((own.0 - other.0).abs() < 0.2 * other.1, "{own:?} {other:?}");
        assert!((own.1 / other.1 - 1.0).abs() < 0.15, "{own:?} {other:?}");
    }
}

#[test]
fn a_draft_takes_the_number_of_runs_where_it_finds_their_spread() {
    let folder = Folder::new();
    let drafted = |header: &str, row: &str| {
        let text = format!("particle,diameter_mm,impact_speed_m_s,e,{header}\nPTFE,4.762,0.8,0.82,{row}\n");
        folder.write("table.csv", text);
        folder.succeed("new table.csv");
        let text = folder.read("scene.toml");
        std::fs::remove_file(folder.join("scene.toml")).expect("removable");
        text
    };
    let both = drafted("SD,n", "0.01,5");
    assert!(both.contains("restitution_sd_of_runs = \"SD\", runs = \"n\""), "{both}");
    let number = drafted("remark,n", "wet,5");
    number.lacks("runs = \"n\"");
    number.says("`n` is not read: where each row");
}

/// Dry runs in blocks of three; after each block stands what is given.
fn blocks(after: impl Fn(usize, f64) -> Option<String>) -> String {
    let mut text = "trial,particle,liquid,diameter_mm,impact_speed_m_s,restitution,remark\n".to_owned();
    let offsets = [
        0.011, -0.014, 0.004, -0.009, 0.012, -0.005, 0.003, -0.002, 0.013, -0.012, 0.006, -0.007,
    ];
    for block in 0..4 {
        let speed = 0.6 + 0.45 * block as f64;
        for (run, offset) in offsets[3 * block..][..3].iter().enumerate() {
            let v = speed + 0.003 * run as f64;
            let e = 1.0 - 0.18 * v.powf(0.2) + offset;
            writeln!(text, "{},PTFE,dry,4.762,{v:.3},{e:.3},", 3 * block + run + 1).expect("a text");
        }
        text.extend(after(block, speed));
    }
    text
}

#[test]
fn rows_that_say_they_are_means_are_left_out_and_named() {
    let place = Place::new(&scene_text());
    let plain = place.fit_rows(&blocks(|_, _| None));
    for (label, remark) in [
        ("mean", ""),
        ("Mittelwert 1-3", ""),
        ("std", ""),
        ("", "Moyenne"),
        ("", "Summe"),
    ] {
        let found = place.fit_rows(&blocks(|_, speed| {
            Some(format!("{label},PTFE,dry,4.762,{speed},0.8,{remark}\n"))
        }));
        assert_eq!(found.dry[0].dry_k.value, plain.dry[0].dry_k.value, "{label}");
        assert_eq!(found.counts.screened.iter().map(|one| one.runs).sum::<usize>(), 4);
        assert_eq!(found.counts.runs, plain.counts.runs + 4);
        // one fact, one caution
        assert_eq!(found.notice("screened"), None);
        assert_once(&notices(&found, "labelled_rows"), "line 5 `; line 17 `");
    }
    // a remark is none, nor is a name of the scene; what such a row has else is not read
    let found = place.fit_rows(&blocks(|_, speed| {
        Some(format!("9,PTFE,dry,4.762,{speed},0.8,total darkness\n"))
    }));
    assert_eq!(found.counts.screened.len(), 0);
    place.fit_rows(&blocks(|_, _| Some("mean,,,,,x,\n".to_owned())));
    let total = Place::new(&scene_text().replace("PTFE", "total"));
    let found = total.fit_rows(&blocks(|_, _| None).replace("PTFE", "total"));
    assert_eq!(found.counts.screened.len(), 0);
}

/// A film beside a run that is called dry says that one of both is wrong.
#[test]
fn a_film_beside_a_dry_run_is_told() {
    let place = place();
    let rows = |film: &str| {
        let rows = ["0.5,0.841", "1.0,0.822", "1.5,0.802", "2.0,0.795"];
        let rows = rows.map(|row| format!("PTFE,dry,4.762,{film},{row}\n"));
        format!("{HEADER}\n{}", rows.concat())
    };
    let found = place.fit_rows(&rows("286"));
    let notice = found.notice("dry_beside_film").expect("told");
    let told = "4 rows are called dry beside a film, which is not read: ";
    notice.text.begins(told);
    notice.text.says("line 2");
    for film in ["", "0", "-", "none"] {
        assert_eq!(place.fit_rows(&rows(film)).notice("dry_beside_film"), None, "{film}");
    }
}

#[test]
fn a_file_listed_twice_is_not_quoted() {
    let text = scene_text().replace("runs = \"runs.csv\"", "runs = [\"runs.csv\", \"copy.csv\"]");
    let place = Place::new(&text);
    std::fs::write(place.path("copy.csv"), blocks(|_, _| None).replace("\n1", "\n5")).expect("writable");
    let found = place.fit_rows(&blocks(|_, _| None));
    let check = found.check("repeated_rows");
    check
        .text
        .says("copy.csv, lines 2 to 13 repeat runs.csv, lines 2 to 13");
    assert!(!quotable(&found.remarks));
}

/// Wet runs of films that `film` gives, and a column of film ratios that `ratio` makes a cell of for a run and its film.
fn with_ratios(film: impl Fn(usize) -> f64, ratio: impl Fn(usize, f64) -> f64) -> String {
    let mut text = format!("{HEADER},film_ratio\n");
    for run in 0..120 {
        let film_ratio = film(run);
        let v = 0.5 + 0.011 * run as f64;
        let e = 1.0 - 0.18 * v.powf(0.2) - 0.06 / v + 0.01 * ((11 * run) % 17) as f64 / 17.0;
        let film = 1e3 * 4.762 * film_ratio;
        let ratio = ratio(run, film_ratio);
        writeln!(text, "PTFE,thin,4.762,{film},{v},{e:.4},{ratio:.5}").expect("a text");
    }
    text
}

/// Of films about two values, each its own.
fn own_films(ratio: impl Fn(usize, f64) -> f64) -> String {
    let film = |run: usize| [0.05, 0.08][run % 2] * (1.0 + 0.0005 * ((37 * run) % 101) as f64);
    with_ratios(film, ratio)
}

#[test]
fn film_ratios_of_each_run_are_no_nominal_ones() {
    let place = place();
    let own = place.fit_rows(&own_films(|_, ratio| ratio));
    let notice = own.notice("film_ratio_of_each_run");
    assert_eq!(notice.map(|notice| notice.count()), Some(120));
    assert_eq!(own.film_groups.len(), 2);
    // nominal ratios stay, those that films were made of exactly among them
    for nominal in [[0.05, 0.08], [0.051, 0.082]] {
        let found = place.fit_rows(&own_films(|run, _| nominal[run % 2]));
        assert!(!found.tells("film_ratio_of_each_run"));
        assert_eq!(found.film_groups.len(), 2);
    }
}

/// Holds that one text is told, and what it says; parts with `; ` between them.
#[track_caller]
fn assert_once(told: &[String], parts: &str) {
    assert_eq!(told.len(), 1, "{told:?}");
    parts.split("; ").for_each(|part| told[0].says(part));
}

#[track_caller]
fn assert_none(told: &[String]) {
    assert!(told.is_empty(), "{told:?}");
}

/// The texts of notices of a code.
fn notices(found: &Findings, code: &str) -> Vec<String> {
    let own = found.notices().filter(|notice| notice.code == code);
    own.map(|notice| notice.text.clone()).collect()
}

/// What is said of columns that contradict each other, which forbids quoting.
fn contradictions(found: &Findings) -> Vec<String> {
    let checks = found.checks().filter(|check| check.code == "columns_agree");
    let checks = checks.inspect(|check| assert!(check.gates() && !check.passed));
    checks.map(|check| check.text.clone()).collect()
}

/// Heights to a whole centimetre, which give speeds that are off by up to a fifth.
#[test]
fn columns_agree_as_far_as_their_digits_tell() {
    let place = place();
    let of = |column: &str, cell: &dyn Fn(f64, f64) -> String| -> Vec<String> {
        let mut text = format!("{HEADER},{column}\n");
        for run in 0..60 {
            let height = [1.3_f64, 1.35, 2.4, 3.4, 5.4, 8.4][run / 10];
            let v = (0.1962 * height).sqrt();
            let e = 1.0 - 0.183 * v.powf(0.2) + 0.01 * ((11 * run) % 17) as f64 / 17.0;
            writeln!(text, "PTFE,dry,4.762,,{v:.3},{e:.4},{}", cell(height, e)).expect("a text");
        }
        contradictions(&place.fit_rows(&text))
    };
    assert_none(&of("drop_height_cm", &|height, _| format!("{height:.0}")));
    let rebound = |height: f64, e: f64| format!("{:.0}", height * e * e);
    assert_none(&of("rebound_height_cm", &rebound));
    // the twins: with the digits that would tell, and off by a factor of 10
    assert_once(&of("drop_height_cm", &|height, _| format!("{height:.0}.0")), "0.9");
    let slip = of("drop_height_cm", &|height, _| format!("{:.0}", 10.0 * height));
    assert_once(&slip, "a factor of 10");
}

#[test]
fn a_column_of_the_film_over_the_radius_forbids_quoting() {
    let place = place();
    let of = |ratio: &dyn Fn(usize, f64) -> f64| -> Vec<String> { contradictions(&place.fit_rows(&own_films(ratio))) };
    let nominal = [0.05, 0.08];
    let radius = of(&|run, _| 2.0 * nominal[run % 2]);
    assert_once(
        &radius,
        "`film_ratio` is 1.9; runs.csv, lines 2 to 121; as of the film over the radius",
    );
    assert_once(&of(&|run, _| 0.5 * nominal[run % 2]), "half the film ratio");
    assert_once(&of(&|_, own| 2.0 * own), "over the radius");
    // a part of the table, of one film and of both
    assert_once(
        &of(&|run, _| nominal[run % 2] * if run % 2 == 0 { 2.0 } else { 1.0 }),
        "is 1.98",
    );
    let part = of(&|run, _| nominal[run % 2] * if run < 20 { 0.5 } else { 1.0 });
    assert_once(&part, "is 0.");
    assert!(part[0].contains("is 0.4") || part[0].contains("is 0.5"), "{part:?}");
    // a slip in few rows is none of the column
    assert_none(&of(&|run, _| nominal[run % 2] * if run % 40 == 0 { 2.0 } else { 1.0 }));
    // nominal ratios are only near the films
    assert_none(&of(&|run, _| nominal[run % 2]));
    assert_none(&of(&|run, _| [0.06, 0.09][run % 2]));
}

#[test]
fn film_ratios_that_are_nearly_each_runs_own_are_told() {
    let place = place();
    // films that go over a wide range
    let film = |run: usize| 0.03 + 0.0004 * ((37 * run) % 101) as f64;
    let wide = |ratio: &dyn Fn(usize, f64) -> f64| place.fit_rows(&with_ratios(film, ratio));
    // rounded to three decimals: 41 values of 101 films
    let rounded = wide(&|_, own| (1e3 * own).round() / 1e3);
    assert_eq!(notices(&rounded, "film_ratio_of_each_run").len(), 1);
    assert_eq!(rounded.film_groups.len(), 1);
    // about nominal, by a few per cent
    let scattered = wide(&|run, own| own * (1.0 + 0.04 * (((13 * run) % 29) as f64 / 14.0 - 1.0)));
    assert_none(&notices(&scattered, "film_ratio_of_each_run"));
    assert_once(
        &notices(&scattered, "many_film_ratios"),
        "the column `film_ratio` has; by their films there is 1 group: each value is a film group of its own",
    );
    // a few nominal ones are what the column is for
    let nominal = wide(&|_, own| (50.0 * own).round() / 50.0);
    assert!(!nominal.tells("many_film_ratios") && !nominal.tells("film_ratio_of_each_run"));
}

/// Dry and wet runs whose heights and Stokes numbers are made for their speeds.
fn said_twice(height: impl Fn(usize, f64) -> f64, stokes: impl Fn(f64) -> f64) -> String {
    let mut text = format!("{HEADER},drop_height_mm,stokes\n");
    for run in 0..24 {
        let v = 0.5 + 0.05 * run as f64;
        let (liquid, film, loss) = if run < 8 {
            ("dry", "", 0.0)
        } else {
            ("thin", "286", 0.06 / v)
        };
        let e = 1.0 - 0.18 * v.powf(0.2) - loss + 0.01 * ((5 * run) % 7) as f64 / 7.0;
        let above = if run < 8 { 0.0 } else { 0.286 };
        let height = height(run, 1e3 * v * v / (2.0 * 9.81)) + above;
        let stokes = stokes(2150.0 * 4.762e-3 * v / (9.0 * 9.3e-3));
        writeln!(text, "PTFE,{liquid},4.762,{film},{v:.4},{e:.4},{height:.2},{stokes:.2}").expect("a text");
    }
    text
}

#[test]
fn columns_that_tell_the_same_thing_are_compared() {
    let place = Place::new(&scene_text().replace("columns = { run = \"trial\" }", "heights_to = \"plate\""));
    let fit = |height: &dyn Fn(usize, f64) -> f64, stokes: f64| place.fit_rows(&said_twice(height, |st| stokes * st));
    let right = fit(&|_, h| h, 1.0);
    assert_none(&contradictions(&right));
    assert!(!right.tells("columns_disagree"));
    // air slows a sphere a little
    assert_none(&contradictions(&fit(&|_, h| 1.04 * h, 1.0)));

    let ten = contradictions(&fit(&|_, h| 10.0 * h, 1.0));
    assert_once(&ten, "`drop_height_mm` gives 3.1; a factor of 10 in the height");
    assert_once(&contradictions(&fit(&|_, h| h, 9.0)), "without its 9");

    let slip = fit(&|run, h| if run == 4 { 2.0 * h } else { h }, 1.0);
    assert_none(&contradictions(&slip));
    assert_once(&notices(&slip, "columns_disagree"), "line 6 (1.41 times)");
}

/// Heights in cm, or off by a tenth, in one series, and in none of the others.
#[test]
fn a_series_whose_heights_contradict_its_speeds_forbids_quoting() {
    let place = Place::new(&scene_text().replace("columns = { run = \"trial\" }", "heights_to = \"plate\""));
    let of = |height: &dyn Fn(usize) -> f64| -> Vec<String> {
        let mut text = format!("{HEADER},drop_height_mm\n");
        for run in 0..60 {
            let (series, v) = (run / 12, 0.6 + 0.1 * (run % 12) as f64);
            let (liquid, film) = [
                ("dry", 0.0),
                ("thin", 190.0),
                ("thin", 286.0),
                ("thick", 190.0),
                ("thick", 286.0),
            ][series];
            let loss = if film > 0.0 { 0.06 / v } else { 0.0 };
            let e = 1.0 - 0.18 * v.powf(0.2) - loss + 0.01 * ((5 * run) % 7) as f64 / 7.0;
            // read to a millimetre
            let own = (height(run) * 1e3 * v * v / 19.62 + 1e-3 * film).round();
            writeln!(text, "PTFE,{liquid},4.762,{film},{v:.3},{e:.4},{own}").expect("a text");
        }
        contradictions(&place.fit_rows(&text))
    };
    assert_none(&of(&|_| 1.0));
    assert_none(&of(&|run| if run % 7 == 3 { 1.05 } else { 1.0 }));
    let in_cm = of(&|run| if run / 12 == 2 { 0.1 } else { 1.0 });
    assert_once(
        &in_cm,
        "in a part of the table: 0.3; runs.csv, lines 26 to 37; a factor of 10 in the height",
    );
    let off = of(&|run| if run / 12 == 4 { 1.2 } else { 1.0 });
    assert_once(&off, "runs.csv, lines 50 to 61");
    // of two series in a row, and of single rows in no order
    let two = of(&|run| if run >= 36 { 1.25 } else { 1.0 });
    assert_once(&two, "runs.csv, lines 38 to 61");
    let rows = of(&|run| if run % 5 == 1 { 4.0 } else { 1.0 });
    assert_once(
        &rows,
        "in 12 of 60 runs, nearly all on one side (the first: runs.csv, line 3",
    );
}

//! Holds that numbers in a wrong unit are questioned in words and not quoted, and that right scenes are left alone.

use crate::common::{in_project, read_in_project, sample, table_of, Place, Says, Told};
use wetcor::findings::verdicts::quotable;
use wetcor::findings::{overview, Findings};
use wetcor::{findings, runs, scene};

const RUNS: &str = "datasets/mueller2016/runs.csv";
const SCENE: &str = "datasets/mueller2016/scene.toml";

/// Columns of the example's runs.
const DIAMETER: usize = 2;
const FILM: usize = 3;
const SPEED: usize = 5;
const RESTITUTION: usize = 6;

/// The example's runs, with the numbers of a column changed in those whose cells are such.
fn rows(column: usize, change: impl Fn(f64) -> f64, is_such: impl Fn(&[&str]) -> bool) -> String {
    let changed = |line: &str| {
        let mut cells: Vec<&str> = line.split(',').collect();
        let number = cells[column].parse().map(|number| change(number).to_string());
        if let (Ok(number), true) = (&number, is_such(&cells)) {
            cells[column] = number;
        }
        cells.join(",")
    };
    let text = read_in_project(RUNS);
    let lines: Vec<String> = text.lines().map(changed).collect();
    lines.join("\n")
}

fn all(_: &[&str]) -> bool {
    true
}

/// The texts of the checks that question what was read or found; with any, nothing may be quoted.
fn questions(findings: &Findings) -> String {
    let asked = findings.checks();
    let asked = asked.filter(|check| check.code.starts_with("plausible") && !check.passed);
    let texts: Vec<&str> = asked
        .inspect(|check| assert!(check.gates()))
        .map(|check| check.text.as_str())
        .collect();
    assert!(texts.is_empty() || !quotable(&findings.remarks), "{texts:?}");
    texts.join("; ")
}

/// Each of some parts with `; ` between them.
fn assert_asked(text: &str, expected: &str) {
    expected.split("; ").for_each(|part| text.says(part));
}

#[test]
fn the_examples_are_not_questioned() {
    for name in ["mueller2016", "sticking"] {
        let path = in_project(&format!("datasets/{name}/scene.toml"));
        let scene = scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let table = runs::read(&scene).unwrap_or_else(|error| panic!("{error}"));
        let found = findings::fit_least_squares(&scene, &table, 1, false);
        assert_eq!(questions(&found), "");
        for code in ["plausible_input", "plausible_result"] {
            assert!(found.checks().any(|check| check.code == code && check.passed));
        }
    }
}

/// A hollow ball: its dry law reads neither density nor diameter, its wet one both.
#[test]
fn the_density_of_a_sphere_without_wet_runs_forbids_nothing() {
    let text = read_in_project(SCENE).replace("= 940", "= 84");
    let place = Place::new(&text);
    let of_dry = read_in_project(RUNS);
    let dry: Vec<&str> = of_dry
        .lines()
        .filter(|line| !line.starts_with("PE,") || line.contains(",dry,"))
        .collect();
    assert!(dry.iter().any(|line| line.starts_with("PE,")));
    assert_eq!(questions(&place.fit_rows(&dry.join("\n"))), "");
    assert_asked(&questions(&place.fit_rows(&of_dry)), "density of PE is 84 kg/m³");
}

/// The example's scene with densities in g/cm³.
fn in_grams() -> Place {
    let text = read_in_project(SCENE).replace("= 2150", "= 2.15");
    Place::new(&text.replace("= 940", "= 0.94"))
}

#[test]
fn densities_in_grams_are_named_as_such() {
    let place = in_grams();
    let found = place.fit_rows(&read_in_project(RUNS));
    let asked = questions(&found);
    assert_asked(
        &asked,
        "density of PTFE is 2.15 kg/m³, outside 300 to 25000 kg/m³: 2.15 looks like g/cm³; 0.94 looks like g/cm³; \
         is below 0.3; St of every wet run is below 1",
    );
    // the cause comes before what follows from it
    assert_eq!(found.remarks[0].code, "plausible_input");
    let seen = overview::summarise_runs(&place.scene, &place.read(), &found);
    let mut notices = seen.notices.iter();
    assert!(notices.any(|notice| notice.code == "plausible_input" && notice.text.contains("g/cm³")));
}

/// Without dry runs there is no energy balance: L and k come from the posterior alone.
#[test]
fn what_the_posterior_alone_tells_is_questioned_too() {
    let place = in_grams();
    let rows = read_in_project(RUNS);
    let wet: Vec<&str> = rows.lines().filter(|line| !line.contains(",dry,")).collect();
    let mut found = place.fit_rows(&wet.join("\n"));
    let asked = |found: &Findings| found.check("plausible_result").text.clone();
    asked(&found).lacks("L = ");
    let posterior = sample(&mut found, &place.scene, &place.read().runs);
    assert!(posterior.is_some());
    asked(&found).says(" by the posterior is below 0.3");
}

/// The example's scene or table with numbers in another unit, and what is asked.
#[test]
fn numbers_in_another_unit_are_questioned() {
    let scene = read_in_project(SCENE);
    let own = read_in_project(RUNS);
    for [from, to, expected] in table_of(
        "roughness_um  = 5 | roughness_um  = 5000 | roughness of PTFE is 5000 µm, outside; δc of PE = ; larger than the sphere
         viscosity_mPa_s = 9.3 | viscosity_mPa_s = 0.0093 | viscosity of AK10 is 0.0093 mPa s, outside; 0.0093 looks like Pa s",
    ) {
        let place = Place::new(&scene.replace(from, to));
        assert_asked(&questions(&place.fit_rows(&own)), expected);
    }
    let asked = |rows: &str, expected: &str| assert_asked(&questions(&unscreened().fit_rows(rows)), expected);
    let thousandth = |film: f64| film / 1000.0;
    let of_series = |cells: &[&str]| cells[..3] == ["PTFE", "AK10", "4.762"] && cells[4] == "0.06";
    asked(
        &rows(FILM, thousandth, of_series),
        "film of 25 runs of PTFE in AK10, the first in runs.csv, line ; some 1000 times thinner; mm for µm?",
    );
    asked(
        &rows(FILM, thousandth, all),
        "film of PTFE is 0.24 to 1.2 µm, outside 2 to 20000 µm: 0.24 to 1.2 looks like mm",
    );
    // δc is as thick as most of these films, and thinner than the thickest
    asked(
        &rows(FILM, |film| film / 20.0, all),
        "δc of PTFE = ; is larger than half of its films",
    );
    // heights in mm that are read as cm, in one of two files under one header: the speeds are √10 times the others
    asked(
        &rows(SPEED, |v| v * 10f64.sqrt(), |cells| cells[..2] == ["PTFE", "M50"]),
        "impact speeds of PTFE in M50, ; are 3.16 times those ; heights in mm for cm?",
    );
    asked(
        &rows(SPEED, |v| 3.6 * v, |cells| cells[..2] == ["PE", "AK10"]),
        "impact speeds of PE in AK10, ; are 3.6 times those ; km/h for m/s?",
    );
    // the radius for the diameter, of wet runs alone; of all runs it is as it may be
    asked(
        &rows(DIAMETER, |d| 0.5 * d, |cells| cells[0] == "PTFE" && cells[1] != "dry"),
        " wet runs of PTFE, the first in runs.csv, line ; exactly 2 times off from the dry ones; the radius for the diameter?",
    );
    let radii = rows(DIAMETER, |d| 0.5 * d, |cells| cells[0] == "PTFE");
    questions(&unscreened().fit_rows(&radii)).lacks("times off from the dry ones");
}

/// Without a roughness L has an end, too: a δc as thick as the film, of the smoothest sphere there is.
#[test]
fn an_l_beyond_every_film_is_questioned() {
    let text = read_in_project(SCENE);
    let text = text.replace("roughness_um", "# roughness_um");
    let own = read_in_project(RUNS);
    assert_eq!(questions(&Place::new(&text).fit_rows(&own)), "");
    // viscosities a tenth of what they are: L is ten times as large
    let thin = text.replace("= 9.3", "= 0.93").replace("= 48.3", "= 4.83");
    assert_asked(
        &questions(&Place::new(&thin).fit_rows(&own)),
        "δc of PTFE = ; where ε were only 0.01 µm is larger than the sphere",
    );
}

/// Fractions under a name that says per cent, as a spreadsheet keeps what it shows as such; those of the example are let be.
#[test]
fn restitutions_of_a_hundredth_are_questioned() {
    let text = read_in_project(SCENE);
    let place = Place::new(&text.replace("smallest_restitution", "# smallest_restitution"));
    let asked = questions(&place.fit_rows(&rows(RESTITUTION, |e| e / 100.0, all)));
    assert_asked(
        &asked,
        "no restitution is above 0.00; fractions in a column that is read as per cent?",
    );
}

/// The example's scene without the limit that would screen films of the wrong unit.
fn unscreened() -> Place {
    Place::new(&read_in_project(SCENE).replace("min_film_um", "# min_film_um"))
}

#[test]
fn a_k_that_no_sphere_has_is_questioned() {
    // a marble on something soft: it keeps a tenth of its speed
    let rows = rows(RESTITUTION, |e| 0.05 + 0.1 * e, |cells| cells[1] == "dry");
    let found = unscreened().fit_rows(&rows);
    let k = found.dry[0].dry_k.value.expect("it converged");
    let asked = found.check("plausible_result");
    assert!(k > 0.7 && !asked.passed, "{k} {asked:?}");
    asked.text.says("k of PTFE = ");
}

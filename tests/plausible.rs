//! Holds that numbers in a wrong unit are questioned in words and not quoted, and that right scenes are left alone.

use crate::common::{in_project, read_in_project, sample, table_of, Place, Says, Told};
use wetcor::findings::verdicts::quotable;
use wetcor::findings::{overview, Findings};
use wetcor::{findings, runs, scene};

/// The example's runs with some of their cells changed.
fn rows(change: impl Fn(&mut Vec<String>)) -> String {
    let text = read_in_project("datasets/mueller2016/runs.csv");
    let mut lines = text.lines();
    let mut changed = vec![lines.next().expect("a header").to_owned()];
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        change(&mut cells);
        changed.push(cells.join(","));
    }
    changed.join("\n")
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
    let text = read_in_project("datasets/mueller2016/scene.toml").replace("= 940", "= 84");
    let place = Place::new(&text);
    let of_dry = rows(|_| ());
    let dry: Vec<&str> = of_dry
        .lines()
        .filter(|line| !line.starts_with("PE,") || line.contains(",dry,"))
        .collect();
    assert!(dry.iter().any(|line| line.starts_with("PE,")));
    assert_eq!(questions(&place.fit_rows(&dry.join("\n"))), "");
    assert_asked(&questions(&place.fit_rows(&of_dry)), "density of PE is 84 kg/m³");
}

#[test]
fn densities_in_grams_are_named_as_such() {
    let text = read_in_project("datasets/mueller2016/scene.toml")
        .replace("= 2150", "= 2.15")
        .replace("= 940", "= 0.94");
    let place = Place::new(&text);
    let found = place.fit_rows(&read_in_project("datasets/mueller2016/runs.csv"));
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
    let text = read_in_project("datasets/mueller2016/scene.toml")
        .replace("= 2150", "= 2.15")
        .replace("= 940", "= 0.94");
    let place = Place::new(&text);
    let rows = read_in_project("datasets/mueller2016/runs.csv");
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
    let scene = read_in_project("datasets/mueller2016/scene.toml");
    let own = read_in_project("datasets/mueller2016/runs.csv");
    for [from, to, expected] in table_of(
        "roughness_um  = 5 | roughness_um  = 5000 | roughness of PTFE is 5000 µm, outside; δc of PE = ; larger than the sphere
         viscosity_mPa_s = 9.3 | viscosity_mPa_s = 0.0093 | viscosity of AK10 is 0.0093 mPa s, outside; 0.0093 looks like Pa s",
    ) {
        let place = Place::new(&scene.replace(from, to));
        assert_asked(&questions(&place.fit_rows(&own)), expected);
    }
    let asked = |rows: &str, expected: &str| assert_asked(&questions(&unscreened().fit_rows(rows)), expected);
    let one_series = rows(|cells| {
        let key: Vec<&str> = cells[..3].iter().map(String::as_str).collect();
        if key == ["PTFE", "AK10", "4.762"] && cells[4] == "0.06" {
            thousandth(&mut cells[3]);
        }
    });
    asked(
        &one_series,
        "film of 25 runs of PTFE in AK10, the first in runs.csv, line ; some 1000 times thinner; mm for µm?",
    );
    asked(
        &rows(|cells| thousandth(&mut cells[3])),
        "film of PTFE is 0.24 to 1.2 µm, outside 2 to 20000 µm: 0.24 to 1.2 looks like mm",
    );
    // heights in mm that are read as cm, in one of two files under one header: the speeds are √10 times the others
    let one_liquid = rows(|cells| {
        if cells[0] == "PTFE" && cells[1] == "M50" {
            let speed: f64 = cells[5].parse().expect("a speed");
            cells[5] = (speed * 10f64.sqrt()).to_string();
        }
    });
    asked(
        &one_liquid,
        "impact speeds of PTFE in M50, ; are 3.16 times those ; heights in mm for cm?",
    );
}

/// Speeds of one liquid in km/h, and the radius for the diameter of its wet runs alone; of all runs both are as they may be.
#[test]
fn runs_of_another_unit_than_the_others_are_questioned() {
    let asked = |rows: &str| questions(&unscreened().fit_rows(rows));
    let in_km_h = rows(|cells| {
        if cells[0] == "PE" && cells[1] == "AK10" {
            cells[5] = (3.6 * cells[5].parse::<f64>().expect("a speed")).to_string();
        }
    });
    assert_asked(
        &asked(&in_km_h),
        "impact speeds of PE in AK10, ; are 3.6 times those ; km/h for m/s?",
    );
    let halved = |is_of: fn(&str) -> bool| {
        rows(|cells| {
            if cells[0] == "PTFE" && is_of(&cells[1]) {
                cells[2] = (0.5 * cells[2].parse::<f64>().expect("a diameter")).to_string();
            }
        })
    };
    assert_asked(
        &asked(&halved(|liquid| liquid != "dry")),
        " wet runs of PTFE, the first in runs.csv, line ; exactly 2 times off from the dry ones; the radius for the diameter?",
    );
    asked(&halved(|_| true)).lacks("times off from the dry ones");
}

/// Without a roughness L has an end, too: a δc as thick as the film, of the smoothest sphere there is.
#[test]
fn an_l_beyond_every_film_is_questioned() {
    let text = read_in_project("datasets/mueller2016/scene.toml");
    let text = text.replace("roughness_um", "# roughness_um");
    let own = read_in_project("datasets/mueller2016/runs.csv");
    assert_eq!(questions(&Place::new(&text).fit_rows(&own)), "");
    // viscosities a tenth of what they are: L is ten times as large
    let thin = text.replace("= 9.3", "= 0.93").replace("= 48.3", "= 4.83");
    assert_asked(
        &questions(&Place::new(&thin).fit_rows(&own)),
        "δc of PTFE = ; where ε were only 0.01 µm is larger than the sphere",
    );
}

/// Films a twentieth of what they were: δc is as thick as most of them, and thinner than the thickest.
#[test]
fn a_delta_c_beyond_half_of_the_films_is_questioned() {
    let rows = rows(|cells| {
        if let Ok(film) = cells[3].parse::<f64>() {
            cells[3] = (film / 20.0).to_string();
        }
    });
    let asked = questions(&unscreened().fit_rows(&rows));
    assert_asked(&asked, "δc of PTFE = ; is larger than half of its films");
}

/// Fractions under a name that says per cent, as a spreadsheet keeps what it shows as such; those of the example are let be.
#[test]
fn restitutions_of_a_hundredth_are_questioned() {
    let text = read_in_project("datasets/mueller2016/scene.toml");
    let place = Place::new(&text.replace("smallest_restitution", "# smallest_restitution"));
    let rows = rows(|cells| {
        if let Some(Ok(e)) = cells.last().map(|cell| cell.parse::<f64>()) {
            *cells.last_mut().expect("a cell") = (e / 100.0).to_string();
        }
    });
    let asked = questions(&place.fit_rows(&rows));
    assert_asked(
        &asked,
        "no restitution is above 0.00; fractions in a column that is read as per cent?",
    );
}

/// The example's scene without the limit that would screen films of the wrong unit.
fn unscreened() -> Place {
    Place::new(&read_in_project("datasets/mueller2016/scene.toml").replace("min_film_um", "# min_film_um"))
}

fn thousandth(cell: &mut String) {
    if let Ok(film) = cell.parse::<f64>() {
        *cell = (film / 1000.0).to_string();
    }
}

#[test]
fn a_k_that_no_sphere_has_is_questioned() {
    // a marble on something soft: it keeps a tenth of its speed
    let rows = rows(|cells| {
        if cells[1] == "dry" {
            let last = cells.len() - 1;
            cells[last] = (0.05 + 0.1 * cells[last].parse::<f64>().expect("a restitution")).to_string();
        }
    });
    let found = unscreened().fit_rows(&rows);
    let k = found.dry[0].dry_k.value.expect("it converged");
    let asked = found.check("plausible_result");
    assert!(k > 0.7 && !asked.passed, "{k} {asked:?}");
    asked.text.says("k of PTFE = ");
}

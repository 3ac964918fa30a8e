//! Holds the laws of pairs that a report writes to the predictions, fits and formulas they stand for.

use crate::common::{fitted_example, read_in_project, Folder};
use std::collections::HashMap;
use std::path::PathBuf;

use serde_json::Value;

/// Cells of a row by the names of their columns.
pub type Row = HashMap<String, String>;

/// A fit of the example's runs, its scene changed.
struct Fitted {
    place: Folder,
    folder: PathBuf,
}

impl Fitted {
    fn new(stages: &str, change: impl Fn(&str) -> String) -> Fitted {
        let place = Folder::new();
        let scene = read_in_project("datasets/mueller2016/scene.toml");
        place.write(
            "scene.toml",
            change(&scene) + "\n[sampler]\nchains = 2\nwarmup = 300\ndraws = 300\n",
        );
        place.write("runs.csv", read_in_project("datasets/mueller2016/runs.csv"));
        let (status, _, err) = place.run(&format!("fit scene.toml --out report --stages {stages} --quiet"));
        // a fit that is not to be quoted is one that is written
        assert!(matches!(status, Some(0 | 1)), "{err}");
        let folder = place.join("report");
        Fitted { place, folder }
    }

    fn committed() -> Fitted {
        Fitted {
            place: Folder::new(),
            folder: fitted_example().to_owned(),
        }
    }

    fn rows(&self, file: &str) -> Vec<Row> {
        rows(&std::fs::read_to_string(self.folder.join(file)).expect("it is written"))
    }

    /// What is predicted at settings given as lines of a table.
    fn predict(&self, settings: &str) -> Vec<Row> {
        self.place.write("settings.csv", settings);
        let folder = self.folder.display();
        let asked = format!("predict {folder} --settings settings.csv --quiet --anyway");
        rows(&self.place.succeed(&asked))
    }
}

pub fn rows(text: &str) -> Vec<Row> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), header.len(), "{line}");
        let named = header.iter().zip(cells);
        named
            .map(|(name, cell)| ((*name).to_owned(), cell.to_owned()))
            .collect()
    };
    lines.map(row).collect()
}

pub fn number(row: &Row, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name}: {:?}", row[name]))
}

/// e of a law by its line alone, as the page of predictions says.
fn restitution(law: &Row, v: f64) -> f64 {
    let or_zero = |name: &str| law[name].parse().unwrap_or(0.0);
    let e_dry = |v: f64| {
        let z = number(law, "dry_k") * v.powf(0.2);
        let second = if law["dry_order"] == "2" { 0.6 * z * z } else { 0.0 };
        1.0 - z + second
    };
    let falling = or_zero("beta_m_s") / v - or_zero("kappa_m2_s2") / (v * v);
    match law["law"].as_str() {
        "dry" => e_dry(v),
        "reference" => (number(law, "alpha") + falling).max(0.0).sqrt(),
        "impact" => {
            let kept = e_dry(v).powi(2) - number(law, "inertial_loss") + falling;
            kept.max(0.0).sqrt()
        }
        other => panic!("{other}"),
    }
}

/// Speeds that each law is asked at.
const SPEEDS: usize = 3;

/// Settings at these speeds of each law, and their laws.
fn settings(laws: &[Row]) -> (String, Vec<(&Row, f64)>) {
    let mut text = "particle,liquid,diameter_mm,film_um,impact_speed_cm_s\n".to_owned();
    let mut asked = vec![];
    for law in laws {
        let [lo, hi] = ["min_speed_m_s", "max_speed_m_s"].map(|name| number(law, name));
        for i in 0..SPEEDS {
            let v = lo + (hi - lo) * i as f64 / (SPEEDS - 1) as f64;
            let [millimetres, film] = ["diameter_m", "film_m"].map(|name| law[name].parse::<f64>());
            let millimetres = millimetres.map_or(4.762, |d| 1e3 * d);
            let film = film.map_or(String::new(), |film| (1e6 * film).to_string());
            let (particle, liquid) = (&law["particle"], &law["liquid"]);
            text.push_str(&format!("{particle},{liquid},{millimetres},{film},{}\n", 100.0 * v));
            asked.push((law, v));
        }
    }
    (text, asked)
}

fn band(row: &Row) -> [f64; 2] {
    ["restitution_q05", "restitution_q95"].map(|name| number(row, name))
}

/// How far a law lies from the medians that are predicted, as a share of the band: the most of all, where it rebounds.
fn farthest(laws: &[Row], predicted: &[Row], asked: &[(&Row, f64)]) -> f64 {
    assert_eq!(
        (predicted.len(), asked.len()),
        (SPEEDS * laws.len(), SPEEDS * laws.len())
    );
    let shares = predicted.iter().zip(asked).filter_map(|(row, (law, v))| {
        let [low, high] = band(row);
        let off = (restitution(law, *v) - number(row, "restitution")).abs();
        (low > 0.05).then(|| off / (high - low))
    });
    shares.fold(0.0, f64::max)
}

#[test]
#[ignore = "slow: run with --ignored"]
fn a_law_is_the_curve_that_is_predicted_there() {
    let at_own_speed = |scene: &str| scene.replace("dry_speed_m_s = 2.0", "dry_speed_m_s = \"impact\"");
    let bridge = |scene: &str| {
        let terms = "[model]\nterms = [\"inertia\", \"viscous\", \"bridge\", \"dry_second_order\"]";
        let scene = scene.replace("[model]", terms);
        scene.replace("viscosity_mPa_s = ", "surface_tension_mN_m = 20.5\nviscosity_mPa_s = ")
    };
    for (change, fitted) in [
        ("", Fitted::committed()),
        ("impact", Fitted::new("least_squares,posterior", at_own_speed)),
        ("bridge", Fitted::new("least_squares,posterior", bridge)),
    ] {
        let laws = fitted.rows("laws.csv");
        // a dry pair for each particle, and one for each of the 54 series
        assert_eq!(laws.len(), 56, "{change}");
        let (text, asked) = settings(&laws);
        let predicted = fitted.predict(&text);
        let worst = farthest(&laws, &predicted, &asked);
        // the mean of the numbers against the median of the curves: 3 % of the band
        assert!(worst > 0.0 && worst < 0.1, "{change}: {worst}");
        // the planted fault: the law of the pair before
        let others = asked.iter().cycle().skip(SPEEDS);
        let shifted: Vec<(&Row, f64)> = asked.iter().zip(others).map(|(own, other)| (other.0, own.1)).collect();
        assert!(farthest(&laws, &predicted, &shifted) > 10.0);
        // nothing is extrapolated where the runs were made
        assert!(predicted.iter().all(|row| row["extrapolated"] == "false"));
        let table = fitted.rows("laws_table.csv");
        let of_table = if change.is_empty() { 2 } else { 56 };
        assert_eq!(table.len(), 25 * of_table, "{change}");
        for row in &table {
            let place = ["particle", "liquid", "diameter_m", "film_m"];
            let same = |law: &&Row| place.iter().all(|name| law[*name] == row[*name]);
            let law = laws.iter().find(same).expect("its law");
            let e = restitution(law, number(row, "impact_speed_m_s"));
            assert!((number(row, "restitution") - e).abs() < 1e-12, "{row:?}");
            let [low, high] = band(row);
            assert!(low <= e + 1e-12 && e <= high + 1e-12);
        }
        // the speed below which nothing rebounds
        for law in &laws {
            let threshold = number(law, "threshold_speed_m_s");
            let [below, above] = [0.999999 * threshold, 1.000001 * threshold + 1e-9].map(|v| restitution(law, v));
            assert!((threshold == 0.0 || below == 0.0) && above > 0.0, "{law:?}");
        }
    }
}

#[test]
fn without_a_posterior_the_numbers_are_those_of_the_series_own_fits() {
    let fitted = Fitted::new("least_squares", str::to_owned);
    let laws = fitted.rows("laws.csv");
    let findings = fitted.place.json("report/findings.json");
    let wet = laws.iter().filter(|law| law["law"] == "reference");
    let mut series = findings["series"].as_array().expect("a list").iter();
    let estimates = findings["estimates"].as_array().expect("a list");
    let mut usable = 0;
    for law in wet {
        let own = series.next().expect("as many");
        assert_eq!(law["source"], "square_root_law");
        if own["verdict"]["passed"] == false {
            assert_eq!((law["alpha"].as_str(), law["quotable"].as_str()), ("", "false"));
            continue;
        }
        usable += 1;
        let value = |name: &str, key: &str| {
            let place = ["particle", "liquid", "diameter_m", "film_ratio"];
            let is_it = |row: &&Value| row["quantity"] == name && place.iter().all(|key| row[*key] == own[*key]);
            let row = estimates.iter().find(is_it).expect("its row");
            row[key].as_f64().expect("a number")
        };
        for (cell, name, key) in [
            ("alpha", "alpha", "value"),
            ("alpha_se", "alpha", "se"),
            ("beta_m_s", "beta", "value"),
            ("beta_se_m_s", "beta", "se"),
            ("e_inf", "e_inf", "value"),
            ("threshold_speed_m_s", "threshold_speed_m_s", "value"),
        ] {
            let (found, expected) = (number(law, cell), value(name, key));
            assert!((found / expected - 1.0).abs() < 1e-9, "{cell} {found} {expected}");
        }
        // carried on from α and β by the slopes: e_inf = √α, St_c = −β (St/v)/(2 α)
        let [alpha, beta, per] = ["alpha", "beta_m_s", "stokes_per_m_s"].map(|name| number(law, name));
        let st_c = -0.5 * beta * per / alpha;
        assert!((number(law, "st_c") / st_c - 1.0).abs() < 1e-12);
        let [a, b] = ["alpha_se", "beta_se_m_s"].map(|name| number(law, name).powi(2));
        let c = number(law, "alpha_beta_covariance_m_s");
        let [of_a, of_b] = [-st_c / alpha, st_c / beta];
        let variance = of_a * of_a * a + of_b * of_b * b + 2.0 * of_a * of_b * c;
        assert!((number(law, "st_c_se").powi(2) / variance - 1.0).abs() < 1e-9);
        assert!((number(law, "e_inf_se") / (0.5 * a.sqrt() / alpha.sqrt()) - 1.0).abs() < 1e-9);
    }
    assert!(usable > 40, "{usable}");
}

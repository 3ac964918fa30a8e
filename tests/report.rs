//! Holds how a report opens, what it says of a posterior and of a sphere without roughness, and what a terminal has of it.

use crate::common::scenes::{scene_of, AK10, DESIGN, M50, PTFE, SATURATING};
use crate::common::{self, read_in_project, Folder, Says};

use serde_json::Value;

fn scene_text() -> String {
    let sampler = "repeats = 4\n[sampler]\nchains = 2\nwarmup = 200\ndraws = 200\n";
    scene_of("report", &[PTFE, AK10, M50, SATURATING, DESIGN, sampler])
}

/// What a fit wrote.
struct Written {
    status: Option<i32>,
    report: String,
    /// where scene and runs lie, and in `out` what was written
    folder: Folder,
}

/// Simulates the scene and fits it.
fn fit(scene: &str, flags: &str) -> Written {
    let folder = Folder::new();
    folder.write("scene.toml", scene);
    folder.succeed("simulate scene.toml --out runs.csv");
    let (status, ..) = folder.run(&format!("fit scene.toml --out out {flags}"));
    Written {
        status,
        report: folder.read("out/report.md"),
        folder,
    }
}

fn is_dry(row: &str) -> bool {
    row.split(',').nth(1) == Some("dry")
}

/// The cells of the first row of a table that starts with `first`.
fn cells(report: &str, first: &str) -> Vec<String> {
    let line = report.lines().find(|line| line.starts_with(&format!("| {first} |")));
    let line = line.unwrap_or_else(|| panic!("no row {first}"));
    line.trim_matches('|')
        .split('|')
        .map(|cell| cell.trim().to_owned())
        .collect()
}

/// A report opens with its verdict, the main numbers and two figures; then come the sentences of what the runs tell, and all
/// of that is short.
#[test]
fn the_report_opens_with_the_verdict_and_is_short_before_its_appendix() {
    const MOST_WORDS: [usize; 2] = [1200, 7000];
    for name in ["mueller2016", "sticking"] {
        let read = |file: &str| read_in_project(&format!("reports/{name}/{file}"));
        let (report, findings) = (read("report.md"), read("findings.json"));
        let findings: Value = serde_json::from_str(&findings).expect("JSON");
        let learnt = entries(&findings, "/main/learnt").iter().filter_map(Value::as_str);
        let listed: Vec<String> = learnt.map(|sentence| format!("* {sentence}\n")).collect();
        assert!(listed.len() >= 4, "{listed:?}");
        report.says(&format!(
            "\n\n## What the runs tell\n\n{}\n## Cautions\n",
            listed.concat()
        ));
        let mut lines = report.lines().filter(|line| !line.is_empty());
        let verdict = lines.nth(1).unwrap_or_default();
        assert!(verdict.starts_with("**Verdict: "), "{name}: {verdict}");
        let (front, rest) = report.split_once("\n## Appendix\n").expect("an appendix");
        for (part, most) in [front, &report].into_iter().zip(MOST_WORDS) {
            let words = part.split_whitespace().count();
            assert!(words <= most, "{name}: {words} words of at most {most}");
        }
        assert!(!report.contains(" -0"), "{name}: a hyphen for a minus");
        assert!(!rest.contains("\n## "), "{name}: a section after the appendix");
        assert_eq!(front.matches("](figures/").count(), 2, "{name}");
    }
}

#[test]
fn a_posterior_is_told_step_by_step_and_its_figure_is_drawn() {
    let written = fit(&scene_text(), "");
    let report = &written.report;
    let steps = [
        "## Cautions",
        "## Appendix",
        "### Posterior",
        "#### Model",
        "#### Parameters",
        "#### Computation",
        "#### Predictive check",
        "#### Other forms of the law",
        "#### Draws",
        "### Checks",
    ];
    let places: Vec<Option<usize>> = steps.iter().map(|step| report.find(&format!("\n{step}\n"))).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}");
    let pairs = "posterior-pairs.svg";
    assert!(written.folder.join("out/figures").join(pairs).exists());
    assert!(report.contains(&format!("(figures/{pairs})")));
    // k stands in the main numbers from the posterior, and the truth lies where it says
    let k = cells(report, "k / (m/s)^(−1/5), PTFE");
    let (value, error) = k[1].split_once(" ± ").expect("a value and what it is uncertain by");
    let number = |text: &str| text.parse::<f64>().expect("a number");
    assert!((number(value) - 0.183).abs() < 4.0 * number(error), "{k:?}");
    assert_eq!(k[3], "posterior");
    assert!(report.contains("which is √r except close to r = 0"));
    assert!(!report.contains("Not sampled:"));
    // 6 settings of 2 liquids and 3 film ratios, all of them among the main numbers
    assert_eq!(report.matches("\n| PTFE | 0.04 | AK10 |").count(), 1);
    assert!(!report.contains("### Other film ratios"));
}

#[test]
fn a_terminal_has_the_verdict_first_and_three_cautions_unless_all_are_asked_for() {
    let folder = fit(&scene_text(), "--stages least_squares").folder;
    // without dry runs there is more to mind, and a column of notes that nothing reads
    let runs = folder.join("runs.csv");
    let text = std::fs::read_to_string(&runs).expect("just written");
    let kept = text.lines().enumerate().filter(|(_, row)| !is_dry(row));
    let noted = kept.map(|(line, row)| format!("{row},{}\n", if line == 0 { "notes" } else { "x" }));
    std::fs::write(&runs, noted.collect::<String>()).expect("writable");
    let said = |flags: &str| {
        let stages = "--stages least_squares";
        let (_, out, err) = folder.run(&format!("fit scene.toml --out out {stages} {flags}"));
        [out, err]
    };
    let [out, err] = said("");
    out.begins("Verdict: ");
    let last = "report: out/report.md (in a browser: out/report.html)\n";
    assert!(out.ends_with(last), "{out}");
    let findings = folder.json("out/findings.json");
    let informs = entries(&findings, "/remarks").iter();
    let informing = informs.filter(|one| one["line"].is_null() && one["level"] == "informs");
    let informing: Vec<&Value> = informing.collect();
    let cautions = cautions(&findings).len();
    assert!(cautions > 3 && !informing.is_empty(), "{}", findings["remarks"]);
    // what is counted is what is shown
    let count = |text: &str, begins: &str| text.lines().filter(|line| line.starts_with(begins)).count();
    assert_eq!(count(&err, "notice: "), 3, "{err}");
    let last = err.lines().last().expect("it counts the others");
    last.begins(&format!("{} more caution", cautions - 3));
    let report = folder.read("out/report.md");
    let (_, rest) = report.split_once("\n## Cautions\n").expect("its section");
    let (listed, _) = rest.split_once("\n## ").expect("a section after it");
    assert_eq!(count(listed, "* "), cautions);
    report.says(&format!("** {cautions} cautions stand under Cautions."));
    let (_, noted) = report.split_once("\n### Also noted\n").expect("the last section");
    let others = informing.iter().filter(|one| one["code"] != "term_not_held");
    assert_eq!(count(noted, "* "), others.count());
    let [same, all] = said("--verbose");
    assert_eq!((same, count(&all, "notice: ")), (out, cautions + informing.len()));
    assert_eq!(said("--quiet"), ["", ""]);
}

/// What cautions of a fit's `findings.json`, by its codes.
fn cautions(findings: &Value) -> Vec<&str> {
    let remarks = entries(findings, "/remarks").iter();
    let cautions = remarks.filter(|one| one["passed"] == false && one["level"] == "cautions");
    cautions.filter_map(|one| one["code"].as_str()).collect()
}

#[test]
fn at_most_five_cautions_stand_on_a_right_scene_of_the_papers_design() {
    let path = common::fitted_example().join("findings.json");
    let findings: Value = serde_json::from_str(&std::fs::read_to_string(path).expect("written")).expect("JSON");
    let told = cautions(&findings);
    assert!(told.len() <= 5, "{told:?}");
    // the posterior counts stuck runs, and nothing that is quoted is the linear law's
    assert!(!told.contains(&"stuck_left_out"), "{told:?}");
    assert!(told.contains(&"constants_exact"), "{told:?}");
}

/// The scene with PE beside PTFE, whose roughness it does not give.
fn with_pe() -> String {
    scene_text()
        .replace("[liquids.AK10]", "[particles.PE]\ndensity_kg_m3 = 940\n[liquids.AK10]")
        .replace("PTFE = 0.183", "PTFE = 0.183, PE = 0.123")
        .replace("{ PTFE = [3.175, 8.0] }", "[3.175, 8.0]")
        .replace("{ PTFE = [0.04, 0.08, 0.15] }", "[0.04, 0.08, 0.15]")
}

/// The entries of a list of findings.
fn entries<'f>(findings: &'f Value, list: &str) -> &'f Vec<Value> {
    let found = findings.pointer(list).and_then(Value::as_array);
    found.unwrap_or_else(|| panic!("no list {list}"))
}

#[test]
fn a_particle_without_roughness_lacks_the_length_of_its_critical_separation_alone() {
    let why = "no roughness is given for PE";
    let written = fit(&with_pe(), "");
    assert!(matches!(written.status, Some(0 | 1)), "{:?}", written.status);
    let findings = written.folder.json("out/findings.json");
    let of_laws = |quantity: &str| {
        let rows = entries(&findings, "/estimates").iter();
        let rows = rows.filter(|row| row["quantity"] == quantity && row["source"] != "posterior");
        rows.collect::<Vec<_>>()
    };
    let products = of_laws("st_c_e_inf2");
    assert!(products.len() == 12 && products.iter().all(|row| row["value"].is_f64()));
    let lengths = of_laws("delta_c_m");
    assert_eq!(lengths.len(), 12);
    for row in lengths {
        let of_pe = row["particle"] == "PE";
        assert_eq!((row["value"].is_null(), row["reason"] == why), (of_pe, of_pe), "{row}");
    }
    let derived = entries(&findings, "/posterior/derived").iter();
    let lengths = derived.filter_map(|one| one["name"].as_str().filter(|name| name.starts_with("delta_c")));
    assert_eq!(
        lengths.collect::<Vec<_>>(),
        ["delta_c_over_roughness", "delta_c_m[PTFE]"]
    );
    // lubrication over the whole film cannot be tried
    let forms = entries(&findings, "/compare");
    assert!(!forms.is_empty() && forms.iter().all(|form| form["model"] != "saturating/2+film"));
    let mut notices = entries(&findings, "/remarks").iter();
    let told = format!("saturating/2+film is not compared: {why}");
    assert!(notices.any(|notice| notice["text"] == told.as_str()), "{told}");
    let energy = written.report.split("\n### Energy\n").nth(1).expect("a section");
    let lengths = |row: &str| cells(energy, row).into_iter().rev().take(2).collect::<Vec<_>>();
    assert_eq!(lengths("PE | 0.08"), ["–", "–"]);
    assert!(lengths("PTFE | 0.08")[1].contains('±'));
    let asked = "predict out --anyway --liquid AK10 --diameter-mm 8 --film-um 640 --speed-m-s 0.8:1.6:3";
    written.folder.succeed(&format!("{asked} --particle PE"));
}

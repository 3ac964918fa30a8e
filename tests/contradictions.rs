//! Looks through what `fit` says of the committed scenes for two remarks that say opposite things, or one that its own findings
//! have decided.

use crate::common::{in_project, read_in_project, table_of, Folder};
use serde_json::{json, Value};

/// A failed check or a notice.
struct Told<'f> {
    code: &'f str,
    text: &'f str,
    next_step: &'f str,
    forbids: bool,
    cautions: bool,
}

fn text<'f>(of: &'f Value, key: &str) -> &'f str {
    of[key].as_str().unwrap_or_default()
}

fn rows<'f>(of: &'f Value, key: &str) -> impl Iterator<Item = &'f Value> {
    of[key].as_array().into_iter().flatten()
}

fn told(findings: &Value) -> Vec<Told<'_>> {
    let failed = rows(findings, "remarks").filter(|remark| remark["passed"] == false);
    let told = failed.map(|remark| Told {
        code: text(remark, "code"),
        text: text(remark, "text"),
        next_step: text(remark, "next_step"),
        forbids: remark["level"] == "forbids",
        cautions: remark["line"].is_null() && remark["level"] == "cautions",
    });
    told.collect()
}

/// Every `key = value` of a text.
fn settings(text: &str) -> Vec<[&str; 2]> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let pairs = words.windows(3).filter(|three| three[1] == "=");
    pairs
        .map(|three| [three[0], three[2]].map(|word| word.trim_end_matches([',', ';', ':', '.', ')'])))
        .collect()
}

/// A term of the energy balance, and what remarks call it.
const TERMS: [[&str; 2]; 5] = [
    ["inertia", "inertia of the liquid"],
    ["viscous", "viscous loss"],
    ["bridge", "rupture of the bridge"],
    ["own_dry_speed", "e_dry at the run's own speed"],
    ["dry_second_order", "second order of the dry law"],
];

/// Each contradiction in some findings; `given` is the scene with the header of its runs.
fn contradictions(findings: &Value, given: &str) -> Vec<String> {
    let told = told(findings);
    let [of_terms, of_keys] = [against_terms(findings, &told), against_keys(&told, given)];
    [of_terms, of_keys, against_numbers(findings, &told)].concat()
}

/// Cautions about a term that is in the model, or that the runs have answered.
fn against_terms(findings: &Value, told: &[Told]) -> Vec<String> {
    let mut found = vec![];
    let own = rows(findings, "compare").find(|form| form["own"] == true);
    for [term, words] in TERMS {
        let held = rows(findings, "terms").any(|row| row["term"] == term && row["held"] == true);
        for remark in told.iter().filter(|remark| remark.text.starts_with(words)) {
            if held && remark.text.contains("not in the model") {
                found.push(format!("{words} is in the model: {}", remark.text));
            }
            if remark.cautions && remark.text.contains("the runs speak against it") {
                found.push(format!("a caution of what the runs speak against: {}", remark.text));
            }
        }
    }
    // of the dry speed the comparison has a form of its own for each form of inertia
    let rejected = own.is_some_and(|own| {
        let name = text(own, "model");
        let twin = name.replace("/2", "/impact");
        let twin = rows(findings, "compare").find(|form| text(form, "model") == twin && twin != name);
        twin.is_some_and(|twin| {
            let of = |form: &Value, key: &str| form[key].as_f64().unwrap_or(f64::NAN);
            let behind = of(own, "delta") - of(twin, "delta");
            behind > 4.0 && behind > 2.0 * of(twin, "delta_se")
        })
    });
    let cautioned = |remark: &&Told| remark.cautions && remark.text.starts_with(TERMS[3][1]);
    if rejected && told.iter().any(|remark| cautioned(&remark)) {
        found.push("a caution of the dry speed that the comparison rejects".to_owned());
    }
    for remark in told.iter().filter(|remark| remark.code == "form_not_compared") {
        let form = remark.text.split(' ').next().unwrap_or_default();
        if rows(findings, "compare").any(|compared| text(compared, "model") == form) {
            found.push(format!("compared all the same: {}", remark.text));
        }
    }
    found
}

/// Advice that the scene follows already, and two remarks that name opposite values of one key.
fn against_keys(told: &[Told], given: &str) -> Vec<String> {
    let mut found = vec![];
    let scene = settings(given);
    let advised = |remark: &Told| -> Vec<[String; 2]> {
        settings(remark.next_step)
            .iter()
            .map(|pair| pair.map(str::to_owned))
            .collect()
    };
    for (place, remark) in told.iter().enumerate() {
        for [key, value] in advised(remark) {
            if scene.contains(&[key.as_str(), value.as_str()]) {
                found.push(format!("{} advises {key} = {value}, which the scene has", remark.code));
            }
            for other in &told[..place] {
                if advised(other).iter().any(|[own, to]| *own == key && *to != value) {
                    found.push(format!("{} and {} name opposite {key}", other.code, remark.code));
                }
            }
        }
        let words = remark.next_step.split(|c: char| !c.is_alphanumeric() && c != '_');
        for key in words.filter(|word| word.contains("_sd")) {
            if remark.next_step.starts_with("give") && given.contains(key) {
                found.push(format!("{} asks for {key}, which is given", remark.code));
            }
        }
        if scene.contains(&["series_offsets", "true"])
            && remark.text.contains("series")
            && remark.text.contains("too small")
        {
            found.push(format!("the model has offsets of series: {}", remark.text));
        }
    }
    found
}

/// Numbers that are quoted and called unusable, and texts that say opposite things of one.
fn against_numbers(findings: &Value, told: &[Told]) -> Vec<String> {
    let mut found = vec![];
    let main = &findings["main"];
    let quoted = main["verdict"]["passed"] == true;
    if quoted == told.iter().any(|remark| remark.forbids) {
        found.push(format!("quoted: {quoted}, against the checks"));
    }
    let numbers = || rows(findings, "estimates").filter(|row| row["main"] == true);
    for place in numbers().filter(|row| row["source"] == "square_root_law") {
        let same = |law: &&Value| {
            ["particle", "film_ratio", "diameter_m"]
                .iter()
                .all(|key| law[key] == place[key])
                && law["law"] == "sqrt"
        };
        let law = rows(findings, "scaling").find(same);
        if quoted && law.is_some_and(|law| law["verdict"]["passed"] == false) {
            found.push(format!("quoted from a law that is not usable: {place}"));
        }
    }
    for remark in told.iter().filter(|remark| remark.code == "energy_balance") {
        let by_least_squares = numbers().any(|row| row["source"] == "energy_balance");
        if quoted && (by_least_squares || !remark.text.contains("by least squares, which")) {
            found.push(format!("quoted, and not usable: {}", remark.text));
        }
    }
    let learnt: Vec<&str> = rows(main, "learnt").filter_map(Value::as_str).collect();
    for remark in told.iter().filter(|remark| remark.code == "film_trend") {
        let symbol = remark.text.split(' ').next().unwrap_or_default();
        let denied = format!("{symbol} is independent of the film");
        found.extend(
            learnt
                .iter()
                .filter(|one| one.starts_with(&denied))
                .map(|one| format!("{one} | {}", remark.text)),
        );
    }
    let unseen = rows(&findings["identifies"], "unseen").next().is_some();
    if learnt.iter().any(|one| one.contains("determine every parameter")) {
        if unseen || told.iter().any(|remark| remark.code == "unseen") {
            found.push("every parameter is determined, and some are not".to_owned());
        }
        let led = numbers().filter(|own| own["prior_led"] == true);
        found.extend(led.map(|own| format!("every parameter is determined, but {own} is led by its prior")));
    }
    let scatters_as_stated = rows(findings, "remarks")
        .any(|check| text(check, "code").starts_with("stated_errors") && check["passed"] == true);
    for remark in told {
        if scatters_as_stated && remark.code == "measurement_errors_too_large" {
            found.push(format!("the runs scatter as stated: {}", remark.text));
        }
        let chosen = remark.text.strip_prefix("inertia = \"auto\" took ");
        if chosen.is_some_and(|rest| !rest.starts_with(text(&findings["inertia"], "inertia"))) {
            found.push(format!("another form was chosen: {}", remark.text));
        }
        // no film is half as thick as its sphere
        for part in remark.text.split("δ/D = ").skip(1) {
            let number: String = part.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
            if number
                .trim_end_matches('.')
                .parse::<f64>()
                .is_ok_and(|ratio| ratio > 0.5)
            {
                found.push(format!("no film ratio: {}", remark.text));
            }
        }
        if told.iter().filter(|other| other.text == remark.text).count() > 1 {
            found.push(format!("said twice: {}", remark.text));
        }
    }
    found
}

/// A committed scene in a folder of its own, with further lines of `[model]`.
fn copied(from: &str, model: &str) -> (Folder, String) {
    let folder = Folder::new();
    for entry in std::fs::read_dir(in_project(from)).expect("a folder") {
        let path = entry.expect("readable").path();
        let name = path.file_name().and_then(|name| name.to_str()).expect("a name");
        folder.write(name, std::fs::read(&path).expect("readable"));
    }
    let scene = folder.read("scene.toml");
    let scene = match model {
        "" => scene,
        _ => scene + "\n[model]\n" + model + "\n",
    };
    folder.write("scene.toml", &scene);
    let runs = std::fs::read_to_string(folder.join("runs.csv")).unwrap_or_default();
    let header = runs.lines().next().unwrap_or_default();
    (folder, format!("{scene}\n{header}"))
}

fn fitted(from: &str, model: &str) -> (Value, String) {
    let (folder, given) = copied(from, model);
    let (status, _, stderr) = folder.run("fit scene.toml --out out --quiet");
    assert!(matches!(status, Some(0 | 1)), "{from} {model}: {stderr}");
    (folder.json("out/findings.json"), given)
}

const PLAIN: &str = "tests/data/good/plain";

#[test]
fn no_two_remarks_on_a_committed_report_contradict_each_other() {
    for name in ["mueller2016", "sticking"] {
        let findings = read_in_project(&format!("reports/{name}/findings.json"));
        let findings = serde_json::from_str(&findings).expect("JSON");
        let given = read_in_project(&format!("datasets/{name}/scene.toml"));
        assert_eq!(contradictions(&findings, &given), Vec::<String>::new(), "{name}");
    }
}

#[test]
#[ignore = "slow: fits 22 scenes, every stage"]
fn no_two_remarks_on_a_scene_contradict_each_other() {
    let mut found = vec![];
    let mut judge = |name: &str, (findings, given): (Value, String)| {
        let contradictions = contradictions(&findings, &given);
        found.extend(contradictions.iter().map(|one| format!("{name}: {one}")));
    };
    let posterior = ["cap", "none", "other_priors", "saturating", "stepwise", "weak"];
    let posterior = posterior.map(|name| format!("tests/data/posterior/{name}"));
    let good = ["no_film_ratio", "stokes_numbers", "uncertain_constants"].map(|name| format!("tests/data/good/{name}"));
    for folder in posterior.iter().chain(&good) {
        judge(folder, fitted(folder, ""));
    }
    for model in [
        "",
        "viscous = \"film\"",
        "series_offsets = true",
        "noise = \"both\"",
        "noise = \"both\"\nseries_offsets = true",
        "likelihood = \"student\"",
        "dry_speed_m_s = \"impact\"",
        "dry_k = \"diameter\"",
        "inertia = \"none\"",
        "inertia = \"cap\"",
        "terms = [\"viscous\"]",
        "terms = [\"inertia\", \"viscous\", \"bridge\", \"dry_second_order\"]",
        "sticking = \"excluded\"",
    ] {
        judge(model, fitted(PLAIN, model));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[track_caller]
fn assert_found(found: &[String], words: &str) {
    assert!(found.iter().any(|one| one.contains(words)), "{words}: {found:?}");
}

/// The twin: each contradiction that is planted in good findings is found.
#[test]
fn planted_contradictions_are_found() {
    let (findings, given) = fitted(PLAIN, "");
    assert_eq!(contradictions(&findings, &given), Vec::<String>::new());
    let with = |remark: Value| {
        let mut planted = findings.clone();
        planted["remarks"].as_array_mut().expect("a list").push(remark);
        planted
    };
    let notice = |code: &str, text: &str, next_step: &str| {
        with(json!({"code": code, "level": "cautions", "passed": false, "text": text, "next_step": next_step}))
    };
    for [words, code, text] in table_of(
        "is in the model | term_not_held | inertia of the liquid: not in the model
         speak against | term_not_held | second order of the dry law: the runs speak against it
         the comparison rejects | term_not_held | e_dry at the run's own speed: not in the model
         some are not | unseen | one film ratio
         another form was chosen | form_chosen | inertia = \"auto\" took none: the intervals
         no film ratio | outlier | moves k of PTFE, δ/D = 4.762, by 1
         compared all the same | form_not_compared | cap/2 is not compared",
    ) {
        assert_found(&contradictions(&notice(code, text, ""), &given), words);
    }
    for [words, code, level, text] in table_of(
        "against the checks | better_form | forbids | none/2 predicts better
         quoted, and not usable | energy_balance | cautions | energy balance: not usable
         C is independent | film_trend | cautions | C rises with the film",
    ) {
        let failed = json!({"code": code, "line": 1, "passed": false, "level": level, "text": text, "next_step": ""});
        assert_found(&contradictions(&with(failed), &given), words);
    }
    let advice = notice(
        "series_offsets",
        "the standard error of L is too small: series",
        "set series_offsets = true",
    );
    let with_offsets = given.clone() + "\n[model]\nseries_offsets = true\n";
    let found = contradictions(&advice, &with_offsets);
    for words in ["which the scene has", "the model has offsets"] {
        assert_found(&found, words);
    }
    assert_eq!(contradictions(&advice, &given), Vec::<String>::new());
    let mut opposite = advice.clone();
    let other =
        json!({"code": "outlier", "passed": false, "text": "two", "next_step": "series_offsets = false would do"});
    opposite["remarks"].as_array_mut().expect("a list").push(other);
    assert_found(&contradictions(&opposite, &given), "opposite series_offsets");
}

//! Looks through what `fit` says of a scene for two remarks that say opposite things, or one that its own findings have decided:
//! here of the committed reports, in `findings_schema` of every kind of fit.

use crate::common::{read_in_project, table_of};
use crate::findings_schema::committed_findings;
use serde_json::{json, Value};

fn text<'f>(of: &'f Value, key: &str) -> &'f str {
    of[key].as_str().unwrap_or_default()
}

fn rows<'f>(of: &'f Value, key: &str) -> impl Iterator<Item = &'f Value> {
    of[key].as_array().into_iter().flatten()
}

/// Failed checks and notices.
fn told(findings: &Value) -> Vec<&Value> {
    let failed = rows(findings, "remarks").filter(|remark| remark["passed"] == false);
    failed.collect()
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

/// Of the dry speed the comparison has a form of its own for each form of inertia.
fn own_speed_rejected(findings: &Value) -> Option<bool> {
    let own = rows(findings, "compare").find(|form| form["own"] == true)?;
    let at_own_speed = text(own, "model").replace("/2", "/impact");
    let twin = rows(findings, "compare").find(|form| text(form, "model") == at_own_speed)?;
    let behind = own["delta"].as_f64()? - twin["delta"].as_f64()?;
    Some(behind > 4.0 && behind > 2.0 * twin["delta_se"].as_f64()?)
}

/// Each contradiction in some findings; `given` is the scene with the header of its runs.
pub fn contradictions(findings: &Value, given: &str) -> Vec<String> {
    let (told, scene) = (told(findings), settings(given));
    let mut found = against_the_verdict(findings, &told);
    for (place, remark) in told.iter().enumerate() {
        let others = || told[..place].iter();
        let twice = others().any(|other| other["text"] == remark["text"]);
        let faults = against_the_findings(remark, findings, &scene).into_iter();
        let faults = faults.chain([(twice, "said twice")]).filter(|(is_so, _)| *is_so);
        found.extend(faults.map(|(_, words)| format!("{words}: {}", remark["text"])));
        let next_step = text(remark, "next_step");
        for [key, value] in settings(next_step) {
            if scene.contains(&[key, value]) {
                found.push(format!("advice that the scene follows: {key} = {value}"));
            }
            let mut advised = others().flat_map(|other| settings(text(other, "next_step")));
            if advised.any(|[own, to]| own == key && to != value) {
                found.push(format!("opposite advice on {key}"));
            }
        }
        let words = next_step.split(|c: char| !c.is_alphanumeric() && c != '_');
        let mut asked_for = words.filter(|word| next_step.starts_with("give") && word.contains("_sd"));
        if asked_for.any(|word| given.contains(word)) {
            found.push(format!("asks for what is given: {next_step}"));
        }
    }
    found
}

/// What of a remark would contradict the findings or the settings of the scene, and whether it does.
fn against_the_findings(remark: &Value, findings: &Value, scene: &[[&str; 2]]) -> [(bool, &'static str); 9] {
    let (told, code) = (text(remark, "text"), text(remark, "code"));
    let says = |words: &str| told.contains(words);
    let symbol = told.split(' ').next().unwrap_or_default();
    let cautions = remark["line"].is_null() && remark["level"] == "cautions";
    let term = TERMS.iter().find(|[_, words]| told.starts_with(words));
    let term = term.map_or("", |[term, _]| *term);
    let is_held = rows(findings, "terms").any(|row| row["term"] == term && row["held"] == true);
    let stated = |check: &Value| text(check, "code").starts_with("stated_errors") && check["passed"] == true;
    let denied = format!("{symbol} is independent of the film");
    let chosen = told.strip_prefix("inertia = \"auto\" took ");
    [
        (says("not in the model") && is_held, "is in the model"),
        (
            cautions && !term.is_empty() && says("the runs speak against it"),
            "a caution of what the runs speak against",
        ),
        (
            cautions && term == "own_dry_speed" && own_speed_rejected(findings) == Some(true),
            "a caution of what the comparison rejects",
        ),
        (
            code == "form_not_compared" && rows(findings, "compare").any(|form| form["model"] == symbol),
            "compared all the same",
        ),
        (
            scene.contains(&["series_offsets", "true"]) && says("series") && says("too small"),
            "the model has offsets of series",
        ),
        (
            is_quoted(findings) && code == "energy_balance" && !says("by least squares, which"),
            "quoted, and not usable",
        ),
        (
            code == "film_trend" && learnt(findings).any(|one| one.starts_with(&denied)),
            "learnt to be independent of the film",
        ),
        (
            code == "measurement_errors_too_large" && rows(findings, "remarks").any(stated),
            "the runs scatter as stated",
        ),
        (
            chosen.is_some_and(|rest| !rest.starts_with(text(&findings["inertia"], "inertia"))),
            "another form was chosen",
        ),
    ]
}

fn is_quoted(findings: &Value) -> bool {
    findings["main"]["verdict"]["passed"] == true
}

fn learnt(findings: &Value) -> impl Iterator<Item = &str> {
    rows(&findings["main"], "learnt").filter_map(Value::as_str)
}

/// Numbers that are quoted though something forbids it, and parameters said to be determined that are not.
fn against_the_verdict(findings: &Value, told: &[&Value]) -> Vec<String> {
    let mut found = vec![];
    let quoted = is_quoted(findings);
    if quoted == told.iter().any(|remark| remark["level"] == "forbids") {
        found.push(format!("quoted: {quoted}, against the checks"));
    }
    let numbers = || rows(findings, "estimates").filter(|row| row["main"] == true);
    for place in numbers().filter(|row| row["source"] == "square_root_law") {
        let keys = ["particle", "film_ratio", "diameter_m"];
        let same = |law: &&Value| keys.iter().all(|key| law[key] == place[key]) && law["law"] == "sqrt";
        let law = rows(findings, "scaling").find(same);
        if quoted && law.is_some_and(|law| law["verdict"]["passed"] == false) {
            found.push(format!("quoted from a law that is not usable: {place}"));
        }
    }
    if learnt(findings).any(|one| one.contains("determine every parameter")) {
        let unseen = rows(&findings["identifies"], "unseen").next().is_some();
        let led = numbers().any(|own| own["prior_led"] == true);
        if unseen || led || told.iter().any(|remark| remark["code"] == "unseen") {
            found.push("every parameter is determined, and some are not".to_owned());
        }
    }
    found
}

/// The findings of a committed report, and its scene.
fn committed(name: &str) -> (Value, String) {
    let given = read_in_project(&format!("datasets/{name}/scene.toml"));
    (committed_findings(name), given)
}

#[track_caller]
fn assert_found(found: &[String], words: &str) {
    assert!(found.iter().any(|one| one.contains(words)), "{words}: {found:?}");
}

/// The committed reports have none; each that is planted in one of them is found.
#[test]
fn remarks_on_a_committed_report_do_not_contradict_each_other() {
    let (findings, given) = committed("sticking");
    assert_eq!(contradictions(&findings, &given), Vec::<String>::new());
    let (mut findings, given) = committed("mueller2016");
    assert_eq!(contradictions(&findings, &given), Vec::<String>::new());
    // as where the scene leaves the form open
    findings["inertia"] = json!({"inertia": "stepwise"});
    let with = |code: &str, level: &str, text: &str, next_step: &str| {
        let mut planted = findings.clone();
        let remark = json!({"code": code, "level": level, "passed": false, "text": text, "next_step": next_step});
        planted["remarks"].as_array_mut().expect("a list").push(remark);
        planted
    };
    for [words, code, level, text] in table_of(
        "is in the model | term_not_held | cautions | inertia of the liquid: not in the model
         speak against | term_not_held | cautions | second order of the dry law: the runs speak against it
         the comparison rejects | term_not_held | cautions | e_dry at the run's own speed: not in the model
         some are not | unseen | cautions | one film ratio
         another form was chosen | form_chosen | cautions | inertia = \"auto\" took none: the intervals
         compared all the same | form_not_compared | cautions | cap/2 is not compared
         against the checks | better_form | forbids | none/2 predicts better
         quoted, and not usable | energy_balance | cautions | energy balance: not usable
         independent of the film | film_trend | cautions | L rises with the film",
    ) {
        assert_found(&contradictions(&with(code, level, text, ""), &given), words);
    }
    let too_small = "the standard error of L is too small: series";
    let advice = with("series_offsets", "cautions", too_small, "set series_offsets = true");
    assert_eq!(contradictions(&advice, &given), Vec::<String>::new());
    let with_offsets = given.clone() + "\n[model]\nseries_offsets = true\n";
    let found = contradictions(&advice, &with_offsets);
    for words in ["advice that the scene follows", "the model has offsets"] {
        assert_found(&found, words);
    }
    let mut opposite = advice.clone();
    let other =
        json!({"code": "outlier", "passed": false, "text": too_small, "next_step": "series_offsets = false would do"});
    opposite["remarks"].as_array_mut().expect("a list").push(other);
    for words in ["opposite advice on series_offsets", "said twice"] {
        assert_found(&contradictions(&opposite, &given), words);
    }
}

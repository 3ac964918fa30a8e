//! Holds the convergence diagnostics and PSIS-LOO against R's posterior and loo and against ArviZ.

use std::collections::BTreeMap;

use crate::common::read_in_project;
use crate::laws::{number, rows};
use serde_json::Value;
use wetcor::inference::diagnostics::energy::e_bfmi;
use wetcor::inference::diagnostics::loo::{self, Loo};
use wetcor::inference::diagnostics::pareto::{khat_threshold, tail_length};
use wetcor::inference::diagnostics::psis::psis;
use wetcor::inference::diagnostics::summary::{summarise, Summary};
use wetcor::inference::diagnostics::{ess, mcse};

const RELATIVE: f64 = 1e-8;

type Chains = Vec<Vec<f64>>;

fn read(name: &str) -> String {
    read_in_project(&format!("tests/data/diagnostics/{name}"))
}

fn slices(chains: &Chains) -> Vec<&[f64]> {
    chains.iter().map(Vec::as_slice).collect()
}

/// Draws of the made-up cases.
fn made_up() -> BTreeMap<String, Chains> {
    let mut cases: BTreeMap<String, Chains> = BTreeMap::new();
    for line in read("arviz_draws.csv").lines() {
        let (name, draws) = line.split_once(',').expect("a name before the draws");
        let draws = draws.split(',').map(|cell| cell.parse().expect("a number"));
        cases.entry(name.to_owned()).or_default().push(draws.collect());
    }
    cases
}

fn arviz() -> Value {
    serde_json::from_str(&read("arviz_reference.json")).expect("JSON")
}

fn list(value: &Value) -> Vec<f64> {
    let entries = value.as_array().expect("a list");
    entries.iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn close(what: &str, ours: f64, theirs: f64) {
    let apart = (ours - theirs).abs();
    assert!(apart <= RELATIVE * theirs.abs(), "{what}: {ours} {theirs}");
}

/// Every number of a summary by the name the reference has for it.
fn by_name(summary: &Summary) -> [(&'static str, Option<f64>); 13] {
    [
        ("mean", summary.mean),
        ("sd", summary.sd),
        ("median", summary.median),
        ("q05", summary.q05),
        ("q95", summary.q95),
        ("rhat", summary.rhat),
        ("ess_bulk", summary.ess_bulk),
        ("ess_tail", summary.ess_tail),
        ("ess_mean", summary.ess_mean),
        ("mcse_mean", summary.mcse_mean),
        ("mcse_sd", summary.mcse_sd),
        ("mcse_q05", summary.mcse_q05),
        ("mcse_q95", summary.mcse_q95),
    ]
}

#[test]
fn eight_schools_agrees_with_posterior() {
    let [draws, answers] = ["draws", "posterior"].map(|name| {
        let text = read(&format!("eight_schools_{name}.csv"));
        rows(&text.replace('"', ""))
    });
    for answer in answers {
        let name = &answer["variable"];
        let draws: Vec<f64> = draws.iter().map(|row| number(row, name)).collect();
        let chains: Vec<&[f64]> = draws.chunks(100).collect();
        let check = |column: &str, ours: f64| {
            close(&format!("{name} {column}"), ours, number(&answer, column));
        };
        let summary = summarise(&chains);
        assert!(summary.is_whole());
        for (column, ours) in by_name(&summary) {
            let column = match column {
                "q05" => "q5",
                "mcse_q05" => "mcse_q5",
                same => same,
            };
            check(column, ours.expect("a diagnostic"));
        }
        for percent in [1, 10, 25, 30, 50, 75, 90, 99] {
            let probability = f64::from(percent) / 100.0;
            let ours = ess::of_quantile(&chains, probability).expect("an ESS");
            check(&format!("ess_q{percent}"), ours);
            let ours = mcse::of_quantile(&chains, probability).expect("an error");
            check(&format!("mcse_q{percent}"), ours);
        }
    }
}

/// Whether ArviZ gives a number in a case where posterior and we give none.
fn unlike_arviz(case: &str, name: &str) -> bool {
    let of_draws = !matches!(name, "mean" | "sd" | "median" | "q05" | "q95");
    match case {
        "constant" => of_draws,
        "with_inf" | "with_nan" => true,
        "each_chain_still" if name == "rhat" => true,
        // the 95 % point is the largest value: no draw lies above it
        "two_values" | "each_chain_still" => matches!(name, "ess_tail" | "mcse_q95"),
        _ => false,
    }
}

#[test]
fn made_up_chains_agree_with_arviz() {
    let answers = arviz();
    let cases = made_up();
    assert_eq!(cases.len(), answers["cases"].as_object().expect("cases").len());
    for (case, chains) in &cases {
        let chains = slices(chains);
        let answers = &answers["cases"][case];
        let theirs = |name: &str| answers[name].as_f64().expect("a number");
        let compare = |name: &str, ours: Option<f64>| match (unlike_arviz(case, name), ours) {
            (false, Some(ours)) => close(&format!("{case} {name}"), ours, theirs(name)),
            (unlike, ours) => assert!(unlike && ours.is_none(), "{case} {name}: {ours:?}"),
        };
        let summary = summarise(&chains);
        for (name, ours) in by_name(&summary) {
            compare(name, ours);
        }
        // quantiles say the same as the summary, and more
        compare("ess_q30", ess::of_quantile(&chains, 0.3));
        compare("mcse_q05", mcse::of_quantile(&chains, 0.05));
        compare("mcse_q95", mcse::of_quantile(&chains, 0.95));
        compare("mcse_q30", mcse::of_quantile(&chains, 0.3));
        for (chain, theirs) in chains.iter().zip(answers["e_bfmi"].as_array().expect("one a chain")) {
            match (e_bfmi(chain), theirs.as_f64()) {
                (Some(ours), Some(theirs)) => close(&format!("{case} E-BFMI"), ours, theirs),
                (ours, theirs) => assert_eq!(ours, theirs, "{case} E-BFMI"),
            }
        }
    }
}

#[test]
fn smoothed_weights_agree_with_arviz() {
    for (case, answer) in arviz()["weights"].as_object().expect("cases") {
        let ratios = list(&answer["log_ratios"]);
        let number = |name: &str| answer[name].as_f64().expect("a number");
        let tail = tail_length(ratios.len(), number("r_eff"));
        assert_eq!(Some(tail as u64), answer["tail"].as_u64(), "{case}");
        let ours = psis(&ratios, tail).expect("finite ratios");
        close(case, ours.khat.expect("a tail"), number("khat"));
        for (ours, theirs) in ours.log_weights.iter().zip(list(&answer["log_weights"])) {
            // a logarithm may pass through zero, so that its error is held against 1 as well
            let most = RELATIVE * (1.0 + theirs.abs());
            assert!((ours - theirs).abs() <= most, "{case}: {ours} {theirs}");
        }
    }
}

/// PSIS-LOO of a made-up model from its log likelihoods, all chains together a run.
fn loo_of(model: &str, r_eff: f64) -> Loo {
    let text = read("arviz_loo.csv");
    let numbers = |line: &str| -> Option<Vec<f64>> {
        let cells = line.strip_prefix(model)?.strip_prefix(',')?.split(',').skip(1);
        cells.map(|cell| cell.parse().ok()).collect()
    };
    let runs: Vec<Vec<f64>> = text.lines().filter_map(numbers).collect();
    let draws = loo::LooDraws {
        count: runs[0].len(),
        r_eff,
    };
    let found = loo::loo(runs.len(), draws, |some, rows| {
        rows.copy_from_slice(&runs[some].concat())
    });
    found.expect("finite densities")
}

#[test]
fn leave_one_out_agrees_with_arviz() {
    let answers = arviz();
    let of_model = |model: &str| {
        let answer = &answers["loo"][model];
        let r_eff = loo::relative_efficiency(&list(&answer["ess_of_means"]), 4, 600);
        let ours = loo_of(model, r_eff);
        let number = |name: &str| answer[name].as_f64().expect("a number");
        close(model, ours.elpd, number("elpd"));
        close(model, ours.se.expect("several runs"), number("se"));
        close(model, ours.p_loo, number("p_loo"));
        close(model, khat_threshold(600), number("good_k"));
        let (elpd, khat) = (list(&answer["elpd_i"]), list(&answer["khat"]));
        assert_eq!(ours.runs.len(), elpd.len());
        for (run, ours) in ours.runs.iter().enumerate() {
            close(model, ours.elpd, elpd[run]);
            close(model, ours.khat.expect("a tail"), khat[run]);
        }
        let worst = khat.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let bad = khat.iter().filter(|khat| **khat > number("good_k")).count();
        let (ours, count) = ours.worst_khat(number("good_k"));
        close(model, ours.expect("a tail"), worst);
        assert_eq!(count, bad);
        loo_of(model, r_eff)
    };
    let difference = loo::difference(&of_model("known"), &of_model("unknown")).expect("the same runs");
    let answer = &answers["loo"]["difference"];
    let number = |name: &str| answer[name].as_f64().expect("a number");
    close("difference", difference.value, number("value"));
    close("its se", difference.se.expect("several runs"), number("se"));
}

//! Holds `wetcor handoff` to the predictions of the same fit, and to its refusals.

use crate::common::{ask, contents, entries, fitted_example as example, Folder, Ran, Says};
use std::path::Path;

const WET: &str = "--particle PTFE --liquid AK10 --diameter-mm 4.762 --film-um 286";
const DRY: &str = "--particle PTFE --liquid dry --diameter-mm 4.762";

fn handoff(words: &str) -> Ran {
    ask("handoff", example(), words)
}

/// The numbers of a column of a table, whose comments are left out.
fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header");
    let place = header.split(',').position(|own| own == name);
    let place = place.unwrap_or_else(|| panic!("no {name} in {header}"));
    let cell = |line: &str| line.split(',').nth(place).and_then(|cell| cell.parse().ok());
    lines.map(|line| cell(line).expect("a number")).collect()
}

#[test]
fn the_table_is_what_is_predicted() {
    for pair in [WET, DRY] {
        let (status, table, err) = handoff(&format!("{pair} --speed-m-s 1.2 --to table"));
        assert_eq!((status, err.as_str()), (Some(0), ""));
        let [v, e, low, beyond] = ["v_m_s", "e_q50", "e_q05", "extrapolated"].map(|name| column(&table, name));
        assert!(
            v.len() > 20 && beyond.contains(&1.0) && beyond.contains(&0.0),
            "{table}"
        );
        for place in (0..v.len()).step_by(5) {
            let speed = v[place];
            let (_, predicted, _) = ask("predict", example(), &format!("{pair} --speed-m-s {speed}:{speed}:1"));
            // the table has five digits
            let near = |name: &str, x: f64| (column(&predicted, name)[0] - x).abs() < 1e-5;
            assert!(
                near("restitution", e[place]) && near("restitution_q05", low[place]),
                "{speed} {predicted}"
            );
            let marked = predicted.contains(",true");
            assert_eq!(marked, beyond[place] == 1.0, "{speed}");
        }
    }
}

/// What stands in the files is held by those kept in `tests/data/handoff`.
#[test]
fn files_of_every_code_are_written_where_nothing_is() {
    let place = Folder::new();
    for (code, speed) in [
        ("table", "1.2"),
        ("lammps", "3.5"),
        ("liggghts", "1.2"),
        ("yade", "1.2"),
    ] {
        let out = place.join(code);
        let words = format!("{WET} --speed-m-s {speed} --to {code} --out {}", out.display());
        let (status, said, err) = handoff(&words);
        assert_eq!(status, Some(0), "{err}");
        assert_eq!(err.contains("extrapolated: at 3.5 m/s"), speed == "3.5", "{err}");
        let written = contents(&out);
        assert_eq!(said.lines().count(), written.len(), "{said}");
        assert!(said.lines().all(|name| Path::new(name).is_file()), "{said}");
        // what is there is kept
        let (status, said, err) = handoff(&words);
        assert_eq!((status, said.as_str()), (Some(2), ""));
        err.says("exists; --out names another folder; nothing was written");
        assert_eq!(contents(&out), written);
    }
    assert_eq!(entries(place.path()), ["lammps", "liggghts", "table", "yade"]);
}

#[test]
fn without_out_the_first_file_is_printed_and_the_other_named() {
    let (status, printed, err) = handoff(&format!("{WET} --speed-m-s 1.2 --to liggghts"));
    assert_eq!(status, Some(0));
    assert!(printed.starts_with("# LIGGGHTS: restitution of PTFE spheres on a plate"));
    assert_eq!(err, "notice: with --out there is drop_liggghts_stokes.in as well\n");
}

#[test]
fn a_fit_that_is_not_to_be_quoted_says_so_in_the_file() {
    let place = Folder::new();
    let findings = std::fs::read_to_string(example().join("findings.json")).expect("it is written");
    let mut findings: serde_json::Value = serde_json::from_str(&findings).expect("JSON");
    findings["remarks"][0]["passed"] = false.into();
    findings["remarks"][0]["level"] = "forbids".into();
    place.write("findings.json", findings.to_string());
    let words = format!("{WET} --speed-m-s 1.2 --to yade");
    let (status, printed, _) = ask("handoff", place.path(), &words);
    assert_eq!(status, Some(1));
    printed.says("NOT TO BE QUOTED");
    assert_eq!(ask("handoff", place.path(), &format!("{words} --anyway")).0, Some(0));
}

#[test]
fn what_no_law_or_code_has_is_refused_in_one_line() {
    for (words, expected) in [
        (
            format!("{WET} --speed-m-s 0.05 --to lammps"),
            "--speed-m-s: at 0.05 m/s the law gives no rebound, and no code takes e = 0; it rebounds from",
        ),
        (
            "--speed-m-s 1 --to yade".to_owned(),
            "expected --particle, --liquid (or --liquid-density-kg-m3 and --viscosity-mPa-s), --diameter-mm, --film-um as well",
        ),
        (
            format!("{WET} --speed-m-s 1 --to mfix"),
            "expected `table`; docs/simulation-codes.md has lines to paste for this code, which were never run",
        ),
        (format!("{WET} --speed-m-s -1 --to yade"), "expected a number above 0"),
        (
            "--particle PTFE --liquid AK10 --diameter-mm 4 --film-um 2500 --speed-m-s 1 --to yade".to_owned(),
            "--film-um: found a film ratio of 0.625, expected at most 0.5",
        ),
    ] {
        let (status, out, err) = handoff(&words);
        assert_eq!((status, out.as_str()), (Some(2), ""), "{words}");
        assert!(err.contains(expected), "{words}: {err}");
    }
}

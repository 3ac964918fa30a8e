//! Holds the texts: every place filled, marks where they belong, refusals, and the files of one law word by word.

use std::path::Path;

use super::*;
use crate::error::Error;
use crate::findings::predict::PredictedPoint;
use crate::physics::Setting;

fn point(e: f64, band: f64) -> PredictedPoint {
    PredictedPoint {
        q50: e,
        q05: e - band,
        q95: e + band,
        extrapolated: false,
    }
}

/// A law like that of PTFE on glass under AK10, with a threshold at 0.3 m/s.
fn wet(speed: f64) -> PredictedPoint {
    let e = (0.55 - 0.165 / speed).max(0.0).sqrt();
    PredictedPoint {
        extrapolated: !(0.8..=1.7).contains(&speed),
        ..point(e, 0.01 * e)
    }
}

fn dry(speed: f64) -> PredictedPoint {
    point(1.0 - 0.183 * speed.powf(0.2), 0.01)
}

fn handoff(law: &dyn Fn(f64) -> PredictedPoint, reference_speed: f64) -> Handoff<'_> {
    Handoff {
        title: "PTFE on wetted glass",
        source: "posterior median of the energy balance",
        particle: "PTFE",
        density: 2150.0,
        diameter: 4.762e-3,
        liquid: "AK10",
        wet: Some(Setting {
            density: 2150.0,
            diameter: 4.762e-3,
            roughness: None,
            liquid_density: 930.0,
            viscosity: 9.3e-3,
            film: 286e-6,
            surface_tension: None,
        }),
        reference_speed,
        law,
        log_slope: 0.165 / reference_speed / (2.0 * law(reference_speed).q50.powi(2)),
        speeds: Some([0.8, 1.7]),
        stokes: Some([97.86, 207.9]),
        quotable: true,
    }
}

fn dried<'a>(of: &Handoff<'a>) -> Handoff<'a> {
    Handoff {
        wet: None,
        stokes: None,
        law: &dry,
        log_slope: -0.0448,
        ..*of
    }
}

fn every_file(handoff: &Handoff) -> Vec<HandoffFile> {
    let of = |code| files(code, handoff).unwrap_or_else(|error| panic!("{error}"));
    Code::ALL.into_iter().flat_map(of).collect()
}

fn refused(code: Code, handoff: &Handoff) -> String {
    match files(code, handoff) {
        Err(Error::Usage(text)) => text,
        other => panic!("{other:?}"),
    }
}

/// No place of a template is left, every number is one, and the heading is of short lines in ASCII.
fn assert_clean(file: &HandoffFile) {
    let HandoffFile { name, text, .. } = file;
    assert!(text.is_ascii() && text.ends_with('\n'), "{name}");
    for odd in ["{{", "}}", "NaN", " inf"] {
        assert!(!text.contains(odd), "{name}: {odd}");
    }
    let mut heading = text.lines().take_while(|line| !line.is_empty());
    assert!(heading.all(|line| line.len() <= 160), "{name}");
}

/// Written by `UPDATE_EXPECTED=1 cargo test handoff`.
#[test]
fn the_files_are_these() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/handoff");
    let wet = handoff(&wet, 1.0);
    let version = format!("by wetcor {}", env!("CARGO_PKG_VERSION"));
    for (kind, handoff) in [("wet", wet), ("dry", dried(&wet))] {
        for file in every_file(&handoff) {
            assert_clean(&file);
            // only what differs dry
            if kind == "dry" && !file.name.contains("viscoelastic") {
                continue;
            }
            let text = file.text.replace(&version, "by wetcor VERSION");
            let path = folder.join(file.name);
            if std::env::var_os("UPDATE_EXPECTED").is_some() {
                std::fs::create_dir_all(&folder).expect("writable");
                std::fs::write(&path, &text).expect("writable");
            }
            let expected = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            assert_eq!(text, expected, "{}", file.name);
        }
    }
}

#[test]
fn what_is_extrapolated_or_not_to_be_quoted_is_marked_in_every_file() {
    let outside = Handoff {
        quotable: false,
        ..handoff(&wet, 2.0)
    };
    for file in every_file(&outside) {
        assert!(
            file.text.contains("EXTRAPOLATED: ") && file.text.contains("NOT TO BE QUOTED: "),
            "{}",
            file.name
        );
    }
    let unmeasured = Handoff {
        speeds: None,
        stokes: None,
        ..outside
    };
    for file in every_file(&unmeasured) {
        assert!(file.text.contains("everything here is extrapolation"), "{}", file.name);
    }
}

#[test]
fn what_a_code_cannot_take_is_refused_by_name() {
    let barely = handoff(&wet, 0.3003);
    assert!(files(Code::Yade, &barely).is_ok() && files(Code::Lammps, &barely).is_ok());
    let higher = |speed: f64| PredictedPoint { q50: 1.2, ..wet(speed) };
    assert!(refused(Code::Table, &handoff(&higher, 1.0)).contains("e = 1.2"));
}

/// |e(v)/e(1) − 1| = 0.05 solved by hand: e² = 0.385 · 0.95² and 0.385 · 1.05².
#[test]
fn the_constant_holds_where_the_law_is_within_five_percent() {
    let [slowest, fastest] = handoff(&wet, 1.0).constant_holds();
    let at = |share: f64| 0.165 / (0.55 - 0.385 * share * share);
    assert!((slowest.expect("it falls") - at(0.95)).abs() < 1e-9);
    assert!((fastest.expect("it rises") - at(1.05)).abs() < 1e-9);
    let constant = |_: f64| point(0.7, 0.0);
    assert_eq!(handoff(&constant, 1.0).constant_holds(), [None, None]);
}

/// With limitForce on LIGGGHTS makes 0.214 of the least input it takes.
#[test]
fn what_the_limit_leaves_no_input_for_is_told() {
    let low = |speed: f64| PredictedPoint { q50: 0.1, ..wet(speed) };
    let constant = liggghts::files(&handoff(&low, 1.0)).unwrap_or_default().swap_remove(0);
    assert!(
        constant.text.contains("cannot be had, the least is 0.2137"),
        "{}",
        constant.text
    );
    assert!(constant.text.contains("label limit_on\nvariable plate string none\n"));
}

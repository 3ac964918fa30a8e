//! Holds that what runs cannot see is named, with the runs that would show it.

use crate::common::scenes::{scene_of, truth, AK10, HEADER, PTFE};
use crate::common::{sample_as_usual, seed_of, table_of, Place, Says, Told};
use wetcor::findings::identify::{Directions, Unidentified};
use wetcor::findings::{self, Findings};
use wetcor::runs::Table;

const L: f64 = 1.85;
const C: f64 = 0.47;
const FILM_SCALE: f64 = 0.069;

/// A design in one liquid, with whatever else its scene says.
struct Design {
    inertia: &'static str,
    films: &'static str,
    heights: &'static str,
    dry: &'static str,
    more: &'static str,
}

/// Two film ratios, five heights and dry runs: everything is seen.
const WELL: Design = Design {
    inertia: "stepwise",
    films: "0.06, 0.12",
    heights: "30, 60, 90, 120, 150",
    dry: "dry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]",
    more: "",
};

impl Design {
    fn of(inertia: &'static str, films: &'static str, dry: &'static str) -> Design {
        Design {
            inertia,
            films,
            dry,
            ..WELL
        }
    }

    fn place(&self) -> Place {
        let Design { inertia, films, .. } = self;
        let form = format!("inertia = \"{inertia}\"\n");
        let truth = truth([L, C, 0.009, 0.02], &format!("{form}film_scale = {FILM_SCALE}\n"));
        let text = format!(
            "[model]\n{form}{truth}[design]\ndiameter_mm = {{ PTFE = [4.762] }}\nliquids = [\"AK10\"]\n\
             film_ratio = {{ PTFE = [{films}] }}\nheight_mm = [{}]\nrepeats = 20\n{}\n{}",
            self.heights, self.dry, self.more
        );
        Place::new(&scene_of("what runs cannot see", &[PTFE, AK10, &text]))
    }

    /// Draws and fits; the seed is the test's name.
    fn draw(&self, test: &str) -> (Place, Table, Findings) {
        let place = self.place();
        let table = place.draw(seed_of(test), None);
        let findings = findings::fit_least_squares(&place.scene, &table, 1, false);
        (place, table, findings)
    }

    fn see(&self, test: &str) -> Directions {
        self.draw(test).2.identifies.expect("parameters and finite sums")
    }
}

/// The only group of unseen directions.
fn only(seen: &Directions) -> &Unidentified {
    assert_eq!(seen.unseen.len(), 1, "{seen:?}");
    &seen.unseen[0]
}

/// A prior so narrow that it says more than the runs takes nothing from what they tell.
#[test]
fn two_film_ratios_and_dry_runs_see_everything() {
    let seen = WELL.see("two_film_ratios_and_dry_runs_see_everything");
    assert_eq!(seen.unseen, vec![]);
    assert_eq!(seen.at, "least_squares");
    assert!(seen.spread_left < 0.5, "{seen:?}");
    let narrow = Design {
        more: "[priors]\ninertial_prefactor = { lognormal = [0.47, 0.001] }",
        ..WELL
    };
    let test = "a_narrow_prior_takes_nothing_from_what_the_runs_tell";
    assert_eq!(narrow.see(test).unseen, vec![]);
    // a form without a film scale needs no second film ratio
    let one_film = Design::of("stepwise", "0.12", WELL.dry);
    let test = "one_film_ratio_with_dry_runs_is_enough_for_the_prefactor_alone";
    assert_eq!(one_film.see(test).unseen, vec![]);
}

#[test]
fn what_is_not_seen_is_a_caution_of_the_report() {
    let design = Design::of("stepwise", "0.06", "");
    let findings = design.draw("one_film_ratio_without_dry_runs_tells_e_inf").2;
    let seen = findings.identifies.as_ref().expect("parameters");
    assert_eq!(seen.at, "least_squares_with_priors");
    let notice = findings.notice("unseen").expect("a caution of the report");
    notice.text.reads(&only(seen).reason);
    assert_eq!(notice.next_step, only(seen).add);
}

/// The name of a seed, form, film ratios, heights, dry runs; parameters that are not seen, their directions, why, what to add.
/// Of films and speeds so near each other that no known reason explains it, the parameters are named all the same.
const UNSEEN: &str = "\
one_film_ratio_without_dry_runs_tells_e_inf | stepwise | 0.06 | 30, 60, 90, 120, 150 | none | inertial_prefactor, dry_k[PTFE] |  | \
one film ratio and no dry runs: the inertial prefactor and e_dry cannot be told apart | add another film ratio or dry runs
one_film_ratio_with_dry_runs_tells_the_loss_of_that_film | saturating | 0.12 | 30, 60, 90, 120, 150 | some | \
inertial_prefactor, film_scale |  | one film ratio: the inertial prefactor and | add another film ratio
films_beyond_the_level_off_tell_the_level_but_no_film_scale | saturating | 0.44, 0.46, 0.48 | 30, 60, 90, 120, 150 | some | \
film_scale |  | every film is beyond the level-off: the film scale | add thinner films
films_below_the_level_off_tell_the_loss_but_not_its_level | saturating | 0.02, 0.03 | 30, 60, 90, 120, 150 | some | \
inertial_prefactor, film_scale |  | every film is below the level-off: | add thicker films
one_film_ratio_with_a_film_scale_and_no_dry_runs_hides_two_directions | saturating | 0.06 | 30, 60, 90, 120, 150 | none | \
inertial_prefactor, film_scale, dry_k[PTFE] | 2 |  | add another film ratio and dry runs
one_speed_tells_only_the_restitution_there | stepwise | 0.06 | 90 | some | lubrication_log, inertial_prefactor |  | \
one film ratio and one Stokes number: the inertial prefactor and the viscous loss cannot be told apart | \
add another film ratio or runs at other speeds
one_speed_tells_only_the_restitution_there | stepwise | 0.06 | 90 | none | \
lubrication_log, inertial_prefactor, dry_k[PTFE] | 2 |  | add 2 of: another film ratio, runs at other speeds, dry runs
what_no_known_reason_explains_still_tells_the_restitution | stepwise | 0.06, 0.065 | 100, 101 | none | \
lubrication_log, inertial_prefactor, dry_k[PTFE] | 2 |  | any";

#[test]
fn what_a_design_cannot_tell_is_named_with_the_runs_that_would() {
    for [seed, inertia, films, heights, dry, parameters, directions, reason, add] in table_of(UNSEEN) {
        let design = Design {
            inertia,
            films,
            heights,
            dry: if dry == "some" { WELL.dry } else { "" },
            more: "",
        };
        let seen = design.see(seed);
        let unseen = only(&seen);
        let mut named = unseen.parameters.clone();
        let mut expected: Vec<&str> = parameters.split(", ").collect();
        if add == "any" {
            named.sort();
            expected.sort();
        } else {
            unseen.add.reads(add);
        }
        assert_eq!(named, expected, "{seed}");
        unseen.reason.begins(reason);
        let count = unseen.directions.to_string();
        assert!(directions.is_empty() || count == directions, "{unseen:?}");
    }
}

/// At one film ratio inertia takes as much at every speed and the viscous loss does not: what is missing is runs, not a film.
#[test]
fn a_few_runs_at_one_film_ratio_are_too_few() {
    let place = Place::new(&scene_of("few", &[PTFE, AK10]));
    let mut rows = HEADER.to_owned();
    for (v, e) in [(0.55, 0.852), (1.05, 0.800), (1.45, 0.821), (1.95, 0.785)] {
        rows += &format!("PTFE,dry,4.762,,{v},{e}\n");
    }
    for (v, e) in [(0.7, 0.602), (1.1, 0.686), (1.5, 0.679), (1.9, 0.720)] {
        rows += &format!("PTFE,AK10,4.762,286,{v},{e}\n");
    }
    let seen = place.fit_rows(&rows).identifies.expect("parameters");
    let unseen = only(&seen);
    unseen.parameters.join(" ").says("inertial_prefactor");
    let reason = "only the speed tells inertia from the viscous loss, and 4 rebounds at St 8";
    unseen.reason.says(reason);
    let add = "add runs at faster and slower speeds, or at another film ratio";
    unseen.add.reads(add);
}

/// The same from the posterior's draws: what keeps its prior is named with the parameter it moves with, and the runs
/// that would tell it are those of `check`.
#[test]
fn a_posterior_that_keeps_its_prior_names_the_partner() {
    let design = Design {
        inertia: "saturating",
        films: "0.02, 0.03",
        more: "[sampler]\nchains = 4\nwarmup = 500\ndraws = 500",
        ..WELL
    };
    let test = "a_posterior_that_keeps_its_prior_names_the_partner";
    let notice = |design: &Design| {
        let (place, table, mut findings) = design.draw(test);
        sample_as_usual(&mut findings, &place.scene, &table.runs);
        let mut notices = findings.remarks.into_iter();
        notices.find(|notice| notice.code == "prior_rules")
    };
    let found = notice(&design).expect("C and the film scale keep their priors");
    for words in ["C (0.", "with δ̃0)", "with C)"] {
        found.text.says(words);
    }
    assert_eq!((found.count(), found.next_step.as_str()), (2, "add thicker films"));
    let more = design.more;
    assert_eq!(notice(&Design { more, ..WELL }), None);
}

/// Runs that determine nothing end in words, never in a panic or a number that is none.
#[test]
fn degenerate_runs_are_told_in_finite_numbers() {
    let place = WELL.place();
    let eight = |of: &str, e: f64| -> String {
        let run = |i| format!("PTFE,{of},{},{e}\n", 0.5 + 0.1 * f64::from(i));
        (0..8).map(run).collect()
    };
    let [wet, dry] = ["AK10,4.762,286", "dry,4.762,"].map(|of| move |e: f64| eight(of, e));
    for (rows, reason) in [
        (dry(0.8), ""),
        (dry(0.8) + &wet(0.0), "no wet run rebounded"),
        (wet(0.0), "no wet run rebounded"),
        (dry(0.0) + &wet(0.0), "no wet run rebounded"),
        (dry(0.0), "the runs say less than the priors: e_dry"),
        ("PTFE,AK10,4.762,286,1,0.6\n".to_owned(), "one Stokes number"),
        (dry(1.1) + &wet(1.1), ""),
        (dry(0.8) + &wet(1e-9), ""),
    ] {
        let findings = place.fit_rows(&(HEADER.to_owned() + &rows));
        let seen = findings.identifies.expect("finite sums");
        assert!(seen.spread_left.is_finite(), "{seen:?}");
        let is_told = seen.unseen.iter().any(|unseen| unseen.reason.starts_with(reason));
        assert!(reason.is_empty() || is_told, "{:?} for {rows}", seen.unseen);
    }
}

/// Two liquids whose density ratios differ tell the loss of one film without dry runs, though not how it grows.
#[test]
fn two_density_ratios_stand_in_for_dry_runs() {
    let design = Design::of("saturating", "0.12", "");
    let text = design.place().folder.read("scene.toml");
    let liquids = "[liquids.heavy]\ndensity_kg_m3 = 1900\nviscosity_mPa_s = 9.3\n[model]";
    let place = Place::new(
        &text
            .replace("[model]", liquids)
            .replace("liquids = [\"AK10\"]", "liquids = [\"AK10\", \"heavy\"]")
            .replace("repeats = 20", "repeats = 400"),
    );
    let findings = place.infer(seed_of("two_density_ratios_stand_in_for_dry_runs"));
    let seen = findings.identifies.expect("parameters");
    assert_eq!(only(&seen).parameters, ["inertial_prefactor", "film_scale"]);
}

//! Holds the sizes of terms, and what is decided by them, against simulated runs whose terms are known.

use crate::common::{assert_expected, binomial_z, counts, holds, mean, seed_of, study, Place, Told};
use wetcor::findings::terms::{SizedTerm, LINE};
use wetcor::findings::Findings;

/// A design clear of the threshold, in which one number sets how much one term matters.
#[derive(Clone, Copy)]
struct Design {
    term: &'static str,
    /// k, η in mPa s, γ in mN/m, film ratios, dry speed
    dry_k: f64,
    viscosity: f64,
    tension: f64,
    films: [f64; 2],
    dry_speed: &'static str,
    /// the terms of the truth
    truth: &'static str,
}

const USUAL: Design = Design {
    term: "",
    dry_k: 0.15,
    viscosity: 9.3,
    tension: 20.1,
    films: [0.05, 0.1],
    dry_speed: "2.0",
    truth: "[\"inertia\", \"viscous\"]",
};

impl Design {
    /// The scene; `terms` as a scene writes them, and the speed the fit takes e_dry at.
    fn scene(&self, terms: &str, dry_speed: &str) -> String {
        let quoted = |speed: &str| speed.replace("impact", "\"impact\"");
        format!(
            "title = \"one term\"\n[data]\nruns = \"runs.csv\"\n[particles.P]\ndensity_kg_m3 = 2150\nroughness_um = 5\n\
             [liquids.oil]\ndensity_kg_m3 = 930\nviscosity_mPa_s = {}\nsurface_tension_mN_m = {}\n\
             [model]\ninertia = \"stepwise\"\nterms = {terms}\ndry_speed_m_s = {}\n\
             [truth]\ndry_k = {{ P = {} }}\nlubrication_log = 3.0\ninertial_prefactor = 1.0\nsigma_dry = 0.01\n\
             sigma_wet = 0.02\ndry_speed_m_s = {}\nterms = {}\n\
             [design]\ndiameter_mm = {{ P = [6.0] }}\nliquids = [\"oil\"]\nfilm_ratio = {{ P = [{}, {}] }}\n\
             impact_speed_m_s = [0.9, 1.2, 1.6, 2.2]\ndry_impact_speed_m_s = [0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 1.7, 1.9, 2.1, 2.3, 2.5, 2.7]\nrepeats = 20\n",
            self.viscosity,
            self.tension,
            quoted(dry_speed),
            self.dry_k,
            quoted(self.dry_speed),
            self.truth,
            self.films[0],
            self.films[1],
        )
    }
}

/// Designs with each term a little below the line, a little above it, and far above.
fn all() -> [[Design; 3]; 5] {
    let of = |term: &'static str, sizes: [f64; 3], change: fn(&mut Design, f64)| {
        sizes.map(|size| {
            let mut own = Design { term, ..USUAL };
            change(&mut own, size);
            own
        })
    };
    [
        of("inertia", [0.00028, 0.0006, 0.006], |own, film| {
            own.films = [film, 2.0 * film]
        }),
        of("viscous", [0.082, 0.17, 1.7], |own, size| own.viscosity = size),
        of("bridge", [12.5, 26.0, 260.0], |own, size| {
            (own.tension, own.truth) = (size, "[\"inertia\", \"viscous\", \"bridge\"]");
        }),
        of("dry_second_order", [0.0135, 0.0195, 0.06], |own, size| {
            (own.dry_k, own.truth) = (size, "[\"inertia\", \"viscous\", \"dry_second_order\"]");
        }),
        of("own_dry_speed", [0.0038, 0.0088, 0.09], |own, size| {
            (own.dry_k, own.dry_speed) = (size, "impact");
        }),
    ]
}

fn of<'f>(findings: &'f Findings, term: &str) -> &'f SizedTerm {
    let found = findings.terms.iter().find(|sized| sized.term.name() == term);
    found.unwrap_or_else(|| panic!("{term} is not sized"))
}

/// Sets drawn for a coverage.
const SETS: u64 = 50;

/// In how many of so many sets the 95 % interval of a parameter holds its truth.
fn covered(design: &Design, (terms, dry_speed): (&str, &str), seed: &str) -> usize {
    let place = Place::new(&design.scene(terms, dry_speed));
    let (name, truth) = match design.term {
        "viscous" => ("inertial_prefactor", 1.0),
        "dry_second_order" => ("dry_k[P]", design.dry_k),
        _ => ("lubrication_log", 3.0),
    };
    let covers = study(seed, SETS, |seed| {
        [holds(place.infer(seed).fitted(name).interval, truth)]
    });
    counts(&covers)[0]
}

/// The terms of a design's truth and its dry speed, and the same without its own.
fn with_and_without(design: &Design) -> [(String, &'static str); 2] {
    let terms = ["inertia", "viscous", "bridge", "dry_second_order"];
    [true, false].map(|own| {
        let holds = |term: &&str| {
            if *term == design.term {
                own
            } else {
                terms[..2].contains(term)
            }
        };
        let listed: Vec<&str> = terms.into_iter().filter(holds).collect();
        let is_own_speed = own && design.term == "own_dry_speed";
        (format!("{listed:?}"), if is_own_speed { "impact" } else { "2.0" })
    })
}

#[test]
fn each_term_is_decided_by_its_size() {
    for [below, above, far] in all() {
        let seed = seed_of("each_term_is_decided_by_its_size");
        let size = |design: &Design| {
            let found = Place::new(&design.scene("\"auto\"", "2.0")).infer(seed);
            let sized = of(&found, design.term);
            let by_itself = matches!(design.term, "inertia" | "viscous");
            let size = sized.size.expect("the runs scatter");
            assert_eq!(sized.held, by_itself && size >= LINE, "{sized:?}");
            let codes = ["term_not_held", "term_acts"];
            let mut told = found.remarks.iter().filter(|own| codes.contains(&own.code));
            let is_told = told.any(|own| own.text.starts_with(sized.term.in_words()));
            assert_eq!(is_told, !by_itself && size >= LINE, "{sized:?}");
            size
        };
        let term = below.term;
        let (below, above, far) = (size(&below), size(&above), size(&far));
        assert!(
            below < LINE && LINE < above && far > 2.0,
            "{term}: {below} {above} {far}"
        );
    }
}

/// A bridge that acts moves L by many of its ±: the runs show it, which forbids quoting until it is held.
#[test]
fn a_bridge_that_the_runs_show_forbids_quoting_until_it_is_held() {
    const ACTS: &str = "[\"inertia\", \"viscous\", \"bridge\"]";
    let forbidden = |truth: &'static str, terms: &str| {
        let design = Design {
            tension: 60.0,
            films: [0.06, 0.08],
            truth,
            ..USUAL
        };
        let scene = design.scene(terms, "2.0").replace("[0.9, ", "[0.4, 0.5, 0.65, 0.9, ");
        let place = Place::new(&scene.replace("sigma_wet = 0.02", "sigma_wet = 0.01"));
        let shown = study("a_bridge_that_the_runs_show", 8, |seed| {
            [place.infer(seed).forbids("term_acts")]
        });
        counts(&shown)[0]
    };
    assert!(forbidden(ACTS, "\"auto\"") >= 6);
    assert_eq!(forbidden(ACTS, ACTS), 0);
    assert_eq!(forbidden(USUAL.truth, "\"auto\""), 0);
}

/// Below the line a term may be left out, above it is held, by itself or by name; either way intervals cover.
#[test]
#[ignore = "slow: run with --ignored"]
fn intervals_cover_with_what_is_decided() {
    for [below, above, _] in all() {
        let seed = format!("intervals_cover_with_what_is_decided {}", below.term);
        // a bias of a quarter of a standard error, and as much more as the size of a draw may be off
        let decided = covered(&below, ("\"auto\"", "2.0"), &seed);
        assert_expected(below.term, decided, SETS, 0.945);
        let [(held, speed), _] = with_and_without(&above);
        assert_expected(above.term, covered(&above, (&held, speed), &seed), SETS, 0.95);
    }
}

/// The planted fault: a term that matters much, left out by name. No more than 84 % cover without it.
#[test]
#[ignore = "slow: run with --ignored"]
fn intervals_do_not_cover_without_a_term_that_matters() {
    let most = (0.84 - 0.945) / (0.945 * 0.055 / SETS as f64).sqrt();
    for [_, _, far] in all() {
        let [with, (without, speed)] = with_and_without(&far);
        let seed = format!("intervals_do_not_cover_without_a_term {}", far.term);
        let z = binomial_z(covered(&far, (&without, speed), &seed), SETS as usize, 0.945);
        assert!(z < most, "{}: {z}", far.term);
        assert_expected(far.term, covered(&far, (&with.0, with.1), &seed), SETS, 0.95);
    }
}

/// The share of a term that the runs show is 1 where they were drawn with it and 0 where not; the planted fault takes one
/// for the other.
#[test]
fn the_share_of_a_term_that_the_runs_show_is_that_of_their_truth() {
    const SETS: u64 = 40;
    // these designs show neither a bridge nor the second order of the dry law well enough to tell both truths apart
    let [_, _, _, _, own] = all().map(|[_, _, far]| far);
    let absent = Design {
        truth: USUAL.truth,
        dry_speed: USUAL.dry_speed,
        ..own
    };
    for (design, truth) in [(absent, 0.0), (own, 1.0)] {
        let place = Place::new(&design.scene("\"auto\"", "2.0"));
        let name = "the_share_of_a_term_that_the_runs_show_is_that_of_their_truth";
        let found = study(name, SETS, |seed| {
            let found = place.infer(seed);
            let sized = of(&found, design.term);
            // not where a parameter is not told from zero
            Some([sized.runs_show?, sized.runs_show_se?])
        });
        let shown: Vec<[f64; 2]> = found.into_iter().flatten().collect();
        let sets = shown.len() as f64;
        assert!(2.0 * sets > SETS as f64, "{}: {sets} sets", design.term);
        let (mean, _) = mean(&shown.iter().map(|[share, _]| *share).collect::<Vec<_>>());
        let se = shown.iter().map(|[_, se]| se * se).sum::<f64>().sqrt() / sets;
        let squares = shown.iter().map(|[share, se]| ((share - mean) / se).powi(2));
        let scatter = squares.sum::<f64>() / (sets - 1.0);
        let name = format!("{} {truth}: {mean} ± {se}, {scatter}", design.term);
        // the fit is linear about a point without the term
        assert!((mean - truth).abs() < 0.1 + 4.5 * se, "{name}");
        assert!((mean - (1.0 - truth)).abs() > 4.5 * se + 0.2, "{name}");
        // χ² of 39 degrees of freedom over them, within 4.5 sd
        assert!((scatter - 1.0).abs() < 4.5 * (2.0 / (sets - 1.0)).sqrt(), "{name}");
    }
}

//! Measures how often the main numbers' intervals cover the truth they were simulated from, and how often they are quoted.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;

use crate::error::Error;
use crate::findings::main_numbers::{MainNumber, Source};
use crate::findings::posterior::MethodChoice;
use crate::findings::{fit_least_squares, Findings};
use crate::model::simulate::Simulation;
use crate::physics::loss::Film;
use crate::physics::quantity::Place;
use crate::physics::Quantity;
use crate::ranks::Ranks;
use crate::report::markdown::page::Page;
use crate::report::markdown::table::ReportTable;
use crate::runs::{self, Table};
use crate::scene::{self, Scene};
use crate::seed::stream;

/// The probability that intervals are made for.
const LEVEL: f64 = 0.95;

/// A design whose main numbers are put to the test.
struct MainDesign {
    name: &'static str,
    what: &'static str,
    /// lines of `[design]`
    design: &'static str,
    /// spread of the wet restitutions
    sigma_wet: f64,
    lubrication_log: f64,
}

/// Dry runs alone.
const fn dry(name: &'static str, what: &'static str, design: &'static str) -> MainDesign {
    MainDesign {
        name,
        what,
        design,
        sigma_wet: 0.02,
        lubrication_log: 1.85,
    }
}

const ALL: [MainDesign; 8] = [
    MainDesign {
        name: "paper",
        what: "2 diameters, 2 liquids, film ratios 0.04 and 0.1, 5 heights, 5 repeats; 50 dry runs",
        design: "diameter_mm = { PTFE = [4.762, 8.0] }\nliquids = [\"thin\", \"thick\"]\nfilm_ratio = { PTFE = [0.04, 0.1] }\n\
                 height_mm = [30, 60, 90, 120, 150]\ndry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]\nrepeats = 5\n",
        sigma_wet: 0.02,
        lubrication_log: 1.85,
    },
    MainDesign {
        name: "unrepeated",
        what: "1 diameter, 2 liquids, film ratios 0.04 and 0.1, 15 speeds once; 15 dry runs at speeds of their own",
        design: "diameter_mm = { PTFE = [4.762] }\nliquids = [\"thin\", \"thick\"]\nfilm_ratio = { PTFE = [0.04, 0.1] }\n\
                 impact_speed_m_s = [0.77, 0.84, 0.91, 0.98, 1.05, 1.12, 1.19, 1.26, 1.33, 1.40, 1.47, 1.54, 1.61, 1.68, 1.75]\n\
                 dry_impact_speed_m_s = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0]\nrepeats = 1\n",
        sigma_wet: 0.02,
        lubrication_log: 1.85,
    },
    MainDesign {
        name: "sticking",
        what: "1 diameter, 1 liquid, film ratios 0.04 and 0.08, 3 heights, 3 repeats, about a third of them stuck; 9 dry runs",
        design: "diameter_mm = { PTFE = [4.762] }\nliquids = [\"thick\"]\nfilm_ratio = { PTFE = [0.04, 0.08] }\n\
                 height_mm = [30, 60, 120]\ndry_impact_speed_m_s = [0.5, 1.0, 2.0]\nrepeats = 3\n",
        sigma_wet: 0.03,
        lubrication_log: 3.9,
    },
    dry("dry_3", "3 dry runs alone", "diameter_mm = { PTFE = [4.762] }\ndry_impact_speed_m_s = [0.5, 1.0, 2.0]\nrepeats = 1\n"),
    dry("dry_4", "4 dry runs alone", "diameter_mm = { PTFE = [4.762] }\ndry_impact_speed_m_s = [0.5, 1.0, 1.5, 2.0]\nrepeats = 1\n"),
    dry("dry_5", "5 dry runs alone", "diameter_mm = { PTFE = [4.762] }\ndry_impact_speed_m_s = [0.5, 0.9, 1.2, 1.6, 2.0]\nrepeats = 1\n"),
    dry("dry_6", "6 dry runs alone", "diameter_mm = { PTFE = [4.762] }\ndry_impact_speed_m_s = [0.5, 1.0, 2.0]\nrepeats = 2\n"),
    dry("dry_8", "8 dry runs alone", "diameter_mm = { PTFE = [4.762] }\ndry_impact_speed_m_s = [0.5, 1.0, 1.5, 2.0]\nrepeats = 2\n"),
];

impl MainDesign {
    fn scene(&self) -> Result<Scene, Error> {
        let text = format!(
            "title = \"{}\"\n[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n\
             [liquids.thin]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n\
             [liquids.thick]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 20\n\
             [model]\ninertia = \"stepwise\"\n[bootstrap]\nreplicates = 1000\n\
             [truth]\ndry_k = {{ PTFE = 0.183 }}\nlubrication_log = {}\ninertia = \"stepwise\"\n\
             inertial_prefactor = 1.2\nsigma_dry = 0.01\nsigma_wet = {}\n[design]\n{}",
            self.name, self.lubrication_log, self.sigma_wet, self.design
        );
        scene::parse(&text, Path::new("calibration/scene.toml"), String::new())
    }
}

/// How often one main number of a design was quoted and covered.
#[derive(Debug, Clone, PartialEq)]
pub struct MainCoverage {
    /// name of the design
    pub design: &'static str,
    /// the quantity, and at which film ratio
    pub quantity: String,
    /// where the number comes from
    pub source: Source,
    /// data sets whose verdict lets it be quoted and which have an interval
    pub quoted: u64,
    /// those of them whose interval covers the truth
    pub covered: u64,
}

impl MainCoverage {
    /// Share of the quoted intervals that cover.
    pub fn share(&self) -> f64 {
        self.covered as f64 / self.quoted as f64
    }

    /// How far that lies from the level, in standard errors.
    pub fn z(&self) -> f64 {
        (self.share() - LEVEL) / (LEVEL * (1.0 - LEVEL) / self.quoted as f64).sqrt()
    }
}

/// The measured table.
#[derive(Debug, Clone, PartialEq)]
pub struct MainCoverageTable {
    /// data sets a design
    pub sets: u64,
    /// every coverage
    pub rows: Vec<MainCoverage>,
}

/// Data sets of each design that a study takes; a posterior takes longer than a fit.
pub const SETS: u64 = 1000;

/// How many designs are measured.
pub const DESIGNS: u64 = ALL.len() as u64;

/// Simulates and fits `sets` data sets of every design, to the posterior. `progress` is called after each of this rank.
pub fn measure(sets: u64, seed: u64, ranks: &Ranks, progress: &(dyn Fn() + Sync)) -> Result<MainCoverageTable, Error> {
    let mut rows = vec![];
    for design in &ALL {
        rows.extend(of_design(design, sets, seed, ranks, progress)?);
    }
    Ok(MainCoverageTable { sets, rows })
}

/// What is counted of a number: quoted, covered.
type Counts = BTreeMap<(String, Source), [u64; 2]>;

fn of_design(
    design: &MainDesign,
    sets: u64,
    seed: u64,
    ranks: &Ranks,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<MainCoverage>, Error> {
    let scene = design.scene()?;
    let of_set = |set: u64| -> Result<Counts, Error> {
        let findings = infer(&scene, seed, set)?;
        progress();
        Ok(count(&scene, &findings))
    };
    let each = ranks.gather(sets, |own| own.into_par_iter().map(of_set).collect())?;
    let mut counts = Counts::new();
    for (key, [quoted, covered]) in each.into_iter().flatten() {
        let of_all = counts.entry(key).or_default();
        of_all[0] += quoted;
        of_all[1] += covered;
    }
    let rows = counts
        .into_iter()
        .map(|((quantity, source), [quoted, covered])| MainCoverage {
            design: design.name,
            quantity,
            source,
            quoted,
            covered,
        });
    Ok(rows.collect())
}

/// Draws a data set and fits it, to the posterior.
fn infer(scene: &Scene, seed: u64, set: u64) -> Result<Findings, Error> {
    let drawn = Simulation::new(scene, None)?.draw_from(stream(seed, "main numbers", set));
    let table = Table::of(runs::arrange(scene, &drawn));
    let mut findings = fit_least_squares(scene, &table, seed.wrapping_add(set), true);
    findings.add_posterior(scene, &table.runs, MethodChoice::Sampler, &|_, _| ())?;
    Ok(findings)
}

/// Which main numbers were quoted, and covered; at the first film ratio, since the others are of the same runs.
fn count(scene: &Scene, findings: &Findings) -> Counts {
    let mut counts = Counts::new();
    let Some(truth) = &scene.truth else {
        return counts;
    };
    let verdict = &findings.main.verdict;
    let mut add = |quantity: &str, number: &MainNumber, truth: Option<f64>| {
        let own = counts.entry((quantity.to_owned(), number.source)).or_default();
        if let (Some([lo, hi]), Some(truth), true) = (number.interval, truth, verdict.passed) {
            own[0] += 1;
            own[1] += u64::from(lo <= truth && truth <= hi);
        }
    };
    for parameter in &findings.main.parameters {
        let truth = match parameter.sphere {
            Some(_) => truth.dry_k[0],
            None => truth.of_quantity(parameter.quantity),
        };
        add(&parameter.name, &parameter.number, truth);
    }
    let first = findings.main.at.first().map(|place| place.film_ratio);
    let mut seen: Vec<Source> = vec![];
    for place in findings.main.at.iter().filter(|place| Some(place.film_ratio) == first) {
        // one liquid stands for the others
        if seen.contains(&place.source) {
            continue;
        }
        seen.push(place.source);
        let film = Film {
            film_ratio: place.film_ratio,
            density_ratio: scene.liquids[0].density / scene.particles[0].density,
        };
        let k = truth.dry_k[0];
        let wetted = k.and_then(|k| truth.wetted(k, film, scene.model.dry_speed.reference()));
        for (quantity, number) in [(Quantity::EInf, &place.e_inf), (Quantity::StC, &place.st_c)] {
            let truth = wetted.as_ref().map(|wetted| quantity.value(&Place::NONE, wetted));
            add(quantity.describe().name, number, truth);
        }
    }
    counts
}

/// The table as a section in markdown.
pub fn markdown(table: &MainCoverageTable) -> String {
    let mut page = Page::titled("", &[]);
    page.text.clear();
    page.heading("Do the main numbers cover?");
    page.paragraph(&format!(
        "{} simulated data sets a design, each fitted to its posterior as `wetcor fit` does. Quoted: sets, in per cent, whose \
         verdict lets the number be quoted and that have an interval; covered: quoted 95 % intervals, in per cent, that hold \
         the truth; z: the distance from 95 % in standard errors. e_inf and St_c are those of the first film ratio.",
        table.sets
    ));
    page.list(
        &ALL.iter()
            .map(|design| format!("{}: {}", design.name, design.what))
            .collect::<Vec<_>>(),
    );
    let rows = ReportTable::of(&table.rows)
        .column("design", |row| row.design)
        .column("quantity", |row| &row.quantity)
        .column("from", |row| row.source.name())
        .column("quoted", |row| {
            format!("{:.1}", 100.0 * row.quoted as f64 / table.sets as f64)
        })
        .column("covered", |row| format!("{:.1}", 100.0 * row.share()))
        .column("z", |row| format!("{:.1}", row.z()));
    page.table(&rows);
    page.text.trim_end().to_owned() + "\n"
}

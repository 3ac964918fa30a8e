//! Measures how often the main numbers' intervals cover the truth they were simulated from, and how often they are quoted.

use minijinja::context;

use super::coverage::{covers, draw, CoverageDesign, DrawnSets};
use crate::error::Error;
use crate::findings::fit_least_squares;
use crate::findings::main_numbers::{MainNumber, MainNumbers, Source};
use crate::findings::posterior::MethodChoice;
use crate::physics::loss::Film;
use crate::physics::quantity::Place;
use crate::physics::Quantity;
use crate::report::template;
use crate::runs::Table;
use crate::scene::Scene;

/// The probability that intervals are made for.
const LEVEL: f64 = 0.95;

const fn dry(name: &'static str, what: &'static str, design: &'static str) -> CoverageDesign {
    CoverageDesign {
        name,
        what,
        diameter_mm: "4.762",
        design,
        truth: "lubrication_log = 1.85\nsigma_wet = 0.02\n",
    }
}

const ALL: [CoverageDesign; 8] = [
    CoverageDesign {
        name: "paper",
        what: "2 diameters, 2 liquids, film ratios 0.04 and 0.1, 5 heights, 5 repeats; 50 dry runs",
        diameter_mm: "4.762, 8.0",
        design: "liquids = [\"thin\", \"thick\"]\nfilm_ratio = { PTFE = [0.04, 0.1] }\nheight_mm = [30, 60, 90, 120, 150]\n\
                 dry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]\nrepeats = 5\n",
        truth: "lubrication_log = 1.85\nsigma_wet = 0.02\n",
    },
    CoverageDesign {
        name: "unrepeated",
        what: "1 diameter, 2 liquids, film ratios 0.04 and 0.1, 15 speeds once; 15 dry runs at speeds of their own",
        diameter_mm: "4.762",
        design: "liquids = [\"thin\", \"thick\"]\nfilm_ratio = { PTFE = [0.04, 0.1] }\n\
                 impact_speed_m_s = [0.77, 0.84, 0.91, 0.98, 1.05, 1.12, 1.19, 1.26, 1.33, 1.40, 1.47, 1.54, 1.61, 1.68, 1.75]\n\
                 dry_impact_speed_m_s = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.8, 2.0]\nrepeats = 1\n",
        truth: "lubrication_log = 1.85\nsigma_wet = 0.02\n",
    },
    CoverageDesign {
        name: "sticking",
        what: "1 diameter, 1 liquid, film ratios 0.04 and 0.08, 3 heights, 3 repeats, about a third of them stuck; 9 dry runs",
        diameter_mm: "4.762",
        design: "liquids = [\"thick\"]\nfilm_ratio = { PTFE = [0.04, 0.08] }\nheight_mm = [30, 60, 120]\n\
                 dry_impact_speed_m_s = [0.5, 1.0, 2.0]\nrepeats = 3\n",
        truth: "lubrication_log = 3.9\nsigma_wet = 0.03\n",
    },
    dry("dry_3", "3 dry runs alone", "dry_impact_speed_m_s = [0.5, 1.0, 2.0]\nrepeats = 1\n"),
    dry("dry_4", "4 dry runs alone", "dry_impact_speed_m_s = [0.5, 1.0, 1.5, 2.0]\nrepeats = 1\n"),
    dry("dry_5", "5 dry runs alone", "dry_impact_speed_m_s = [0.5, 0.9, 1.2, 1.6, 2.0]\nrepeats = 1\n"),
    dry("dry_6", "6 dry runs alone", "dry_impact_speed_m_s = [0.5, 1.0, 2.0]\nrepeats = 2\n"),
    dry("dry_8", "8 dry runs alone", "dry_impact_speed_m_s = [0.5, 1.0, 1.5, 2.0]\nrepeats = 2\n"),
];

const COMMON: &str = "[liquids.thin]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n\
    [liquids.thick]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 20\n[model]\ninertia = \"stepwise\"\n\
    [bootstrap]\nreplicates = 1000\n[truth]\ndry_k = { PTFE = 0.183 }\ninertia = \"stepwise\"\n\
    inertial_prefactor = 1.2\nsigma_dry = 0.01\n";

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
    fn share(&self) -> f64 {
        self.covered as f64 / self.quoted as f64
    }

    /// How far that lies from the level, in standard errors.
    fn z(&self) -> f64 {
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

/// Simulates and fits the data sets of every design, to the posterior.
pub fn measure(drawn: DrawnSets) -> Result<MainCoverageTable, Error> {
    let mut rows = vec![];
    for design in &ALL {
        let scene = design.scene(COMMON)?;
        // processes of MPI are no thread's to share
        let seed = drawn.seed;
        let of_set = |set: u64| -> Result<_, Error> {
            let table = Table::of(draw(&scene, seed, "main numbers", set)?);
            let mut findings = fit_least_squares(&scene, &table, seed.wrapping_add(set), true);
            findings.add_posterior(&scene, &table.runs, MethodChoice::Sampler, &|_, _| ())?;
            Ok(quoted_and_covered(&scene, &findings.main))
        };
        let counts = drawn.count_over_sets(of_set)?;
        rows.extend(
            counts
                .into_iter()
                .map(|((quantity, source), [quoted, covered])| MainCoverage {
                    design: design.name,
                    quantity,
                    source,
                    quoted,
                    covered,
                }),
        );
    }
    Ok(MainCoverageTable { sets: drawn.sets, rows })
}

/// Whether each main number covers, where it is quoted; at the first film ratio, since the others are of the same runs.
fn quoted_and_covered(scene: &Scene, main: &MainNumbers) -> Vec<((String, Source), Option<bool>)> {
    let Some(truth) = &scene.truth else {
        return vec![];
    };
    let mut told = vec![];
    let mut add = |quantity: &str, number: &MainNumber, truth: Option<f64>| {
        let quoted = number.interval.zip(truth).filter(|_| main.verdict.passed);
        let covers = quoted.map(|(interval, truth)| covers(interval, truth));
        told.push(((quantity.to_owned(), number.source), covers));
    };
    for parameter in &main.parameters {
        let truth = match parameter.sphere {
            Some(_) => truth.dry_k[0],
            None => truth.of_quantity(parameter.quantity),
        };
        add(&parameter.name, &parameter.number, truth);
    }
    let first = main.at.first().map(|place| place.film_ratio);
    let mut seen: Vec<Source> = vec![];
    for place in main.at.iter().filter(|place| Some(place.film_ratio) == first) {
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
    told
}

/// The table as a section in markdown.
pub fn markdown(table: &MainCoverageTable) -> Result<String, Error> {
    let row = |row: &MainCoverage| {
        context! {
            design => row.design,
            quantity => row.quantity.as_str(),
            source => row.source.name(),
            quoted => row.quoted as f64 / table.sets as f64,
            covered => row.share(),
            z => row.z(),
        }
    };
    let values = context! {
        sets => table.sets,
        designs => ALL.each_ref().map(CoverageDesign::explained).to_vec(),
        rows => table.rows.iter().map(row).collect::<Vec<_>>(),
    };
    template::page("main_coverage.md", &values, &[])
}

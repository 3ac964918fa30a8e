//! Measures how often the intervals of e_inf and St_c cover the truth they were simulated from.

use std::io::Read;
use std::path::Path;

use rayon::prelude::*;

use crate::error::Error;
use crate::findings::estimate::{Estimate, Quoting};
use crate::findings::scaling::{self, FittedScaling};
use crate::findings::{bootstrap, energy};
use crate::inference::bootstrap::strata::LEAST_RUNS;
use crate::inference::delta::{Interval, LEVELS};
use crate::model::simulate::Simulation;
use crate::ranks::Ranks;
use crate::report::markdown::page::Page;
use crate::report::markdown::table::ReportTable;
use crate::runs;
use crate::scene::{self, Scene, WetLaw};
use crate::seed::stream;
use crate::staging::OutputPlace;

/// The methods compared, as intervals name them, the simplest first.
pub const METHODS: [&str; 3] = ["delta", "percentile", "bca"];

/// A design whose intervals are put to the test.
struct CalibrationDesign {
    name: &'static str,
    what: &'static str,
    diameter_mm: &'static str,
    liquids: &'static str,
    speeds: &'static str,
    repeats: u32,
    noise: &'static str,
}

const PAPER: CalibrationDesign = CalibrationDesign {
    name: "paper",
    what: "the paper's design at one film ratio: 2 diameters, 2 liquids, 5 heights, 5 repeats, normal noise",
    diameter_mm: "4.762, 8.0",
    liquids: "\"AK10\", \"M50\"",
    speeds: "height_mm = [30, 60, 90, 120, 150]",
    repeats: 5,
    noise: "normal",
};

/// Data sets of each design.
pub const SETS: u64 = 4000;

/// Most data sets of a design: the shares are then known to 0.03 %, and what each set gave is held.
pub const MOST_SETS: u64 = 1_000_000;

/// Replicates of each simulated data set: enough that their number does not show in the coverage.
pub const REPLICATES: u64 = 2000;

/// How many designs are measured.
pub const DESIGNS: u64 = ALL.len() as u64;

const ALL: [CalibrationDesign; 5] = [
    PAPER,
    CalibrationDesign {
        name: "small",
        what: "8 runs: 1 diameter, 1 liquid, 4 heights, 2 repeats, normal noise",
        diameter_mm: "4.762",
        liquids: "\"M50\"",
        speeds: "height_mm = [30, 60, 100, 150]",
        repeats: 2,
        noise: "normal",
    },
    CalibrationDesign {
        name: "skewed",
        what: "as the paper's, noise with a long tail to low restitutions",
        noise: "skewed",
        ..PAPER
    },
    CalibrationDesign {
        name: "heteroscedastic",
        what: "as the paper's, noise growing with 1/St from about half to twice its mean",
        noise: "heteroscedastic",
        ..PAPER
    },
    CalibrationDesign {
        name: "unrepeated",
        what: "as the paper's, each series at 25 speeds once",
        speeds:
            "impact_speed_m_s = [0.77, 0.81, 0.85, 0.89, 0.93, 0.97, 1.01, 1.05, 1.09, 1.13, 1.17, 1.21, 1.25, 1.29, \
                 1.33, 1.37, 1.41, 1.45, 1.49, 1.53, 1.57, 1.61, 1.65, 1.69, 1.73]",
        repeats: 1,
        ..PAPER
    },
];

impl CalibrationDesign {
    /// The scene; both liquids have one density, so that the square-root law is the truth itself.
    fn scene(&self, replicates: u64, sigma: f64) -> Result<Scene, Error> {
        let text = format!(
            "title = \"{}\"\n[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n\
             [liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n\
             [liquids.M50]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 48.3\n\
             [bootstrap]\nreplicates = {replicates}\n\
             [truth]\ndry_k = {{ PTFE = 0.183 }}\nlubrication_log = 1.85\ninertia = \"saturating\"\n\
             inertial_prefactor = 0.47\nfilm_scale = 0.069\nsigma_dry = 0.009\nsigma_wet = {sigma}\nnoise = \"{}\"\n\
             [design]\ndiameter_mm = {{ PTFE = [{}] }}\nliquids = [{}]\nfilm_ratio = {{ PTFE = [0.06] }}\n\
             {}\nrepeats = {}\n",
            self.name, self.noise, self.diameter_mm, self.liquids, self.speeds, self.repeats
        );
        scene::parse(&text, Path::new("calibration/scene.toml"), String::new())
    }
}

/// How often one method's intervals covered one quantity on one design.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// name of the design
    pub design: &'static str,
    /// the fitted law
    pub law: WetLaw,
    /// `e_inf`, `st_c`, or `true e_inf` for the linear law against the truth in place of its own noise-free fit
    pub quantity: &'static str,
    /// one of [`METHODS`]
    pub method: &'static str,
    /// share of the data sets covered, for each of [`LEVELS`]
    pub covered: [f64; 2],
    /// whether it counts for the choice of the default: the truth of another law does not
    pub counts: bool,
}

/// The measured table.
#[derive(Debug, Clone, PartialEq)]
pub struct CoverageTable {
    /// data sets a design
    pub sets: u64,
    /// replicates a data set
    pub replicates: u64,
    /// every coverage
    pub rows: Vec<Coverage>,
}

impl CoverageTable {
    /// The largest |coverage − level| of a method, over designs, laws, quantities and levels that count.
    pub fn worst(&self, method: &str) -> f64 {
        let rows = self.rows.iter().filter(|row| row.method == method && row.counts);
        rows.flat_map(|row| row.covered.iter().zip(LEVELS).map(|(c, level)| (c - level).abs()))
            .fold(0.0, f64::max)
    }

    /// The method with the smallest worst; of methods nearer to it than the Monte Carlo error, the simplest.
    pub fn best(&self) -> &'static str {
        let smallest = METHODS
            .iter()
            .map(|method| self.worst(method))
            .fold(f64::INFINITY, f64::min);
        let near = |method: &&str| self.worst(method) <= smallest + self.mcse(LEVELS[0]);
        METHODS.into_iter().find(near).unwrap_or(METHODS[0])
    }

    /// Monte Carlo error of a share.
    fn mcse(&self, level: f64) -> f64 {
        (level * (1.0 - level) / self.sets as f64).sqrt()
    }
}

/// Simulates, fits and bootstraps `sets` data sets of every design. `progress` is called after each data set of this rank.
pub fn measure(
    sets: u64,
    replicates: u64,
    seed: u64,
    ranks: &Ranks,
    progress: &(dyn Fn() + Sync),
) -> Result<CoverageTable, Error> {
    let drawn = DrawnSets { sets, replicates, seed };
    let mut rows = vec![];
    for design in &ALL {
        rows.extend(of_design(design, drawn, ranks, progress)?);
    }
    Ok(CoverageTable { sets, replicates, rows })
}

/// Both laws at the design's one film ratio, bootstrapped or not.
fn infer(scene: &Scene, seed: u64, set: u64, replicated: bool) -> Result<Vec<FittedScaling>, Error> {
    let drawn = Simulation::new(scene, None)?.draw_from(stream(seed, "calibration", set));
    let runs = runs::arrange(scene, &drawn);
    let quoting = Quoting {
        level: scene.bootstrap.level,
    };
    let mut fitted = scaling::fit_scaling(scene, &runs, &[], quoting);
    fitted.retain(|fitted| fitted.scaling.film_ratio.is_some());
    if replicated {
        let mut none = energy::estimate_energy(scene, &runs, &[], &[], quoting);
        let estimates = bootstrap::Estimates {
            dry: &mut [],
            series: &mut [],
            scaling: &mut fitted,
            energy: &mut none,
        };
        let options = bootstrap::Options {
            seed: seed.wrapping_add(set),
            keep_all: true,
            most_resampled: usize::MAX,
        };
        bootstrap::add_bootstrap_intervals(scene, &runs, estimates, options, &|_| ());
    }
    Ok(fitted)
}

/// A quantity held against a target.
struct CoverageAim {
    law: WetLaw,
    quantity: &'static str,
    of: fn(&FittedScaling) -> &Estimate,
    target: f64,
    counts: bool,
}

fn aims(scene: &Scene) -> Result<Vec<CoverageAim>, Error> {
    let e_inf: fn(&FittedScaling) -> &Estimate = |fitted| &fitted.scaling.e_inf;
    let st_c: fn(&FittedScaling) -> &Estimate = |fitted| &fitted.scaling.st_c;
    // without noise each law returns its own target
    let exact = infer(scene, 0, 0, false)?;
    let value = |law: WetLaw, of: fn(&FittedScaling) -> &Estimate| {
        exact
            .iter()
            .find(|fitted| fitted.law == law)
            .and_then(|fitted| of(fitted).value)
            .unwrap_or(f64::NAN)
    };
    let aim = |law: WetLaw, quantity: &'static str, of: fn(&FittedScaling) -> &Estimate| CoverageAim {
        law,
        quantity,
        of,
        target: value(law, of),
        counts: true,
    };
    Ok(vec![
        aim(WetLaw::Sqrt, "e_inf", e_inf),
        aim(WetLaw::Sqrt, "st_c", st_c),
        aim(WetLaw::Linear, "e_inf", e_inf),
        aim(WetLaw::Linear, "st_c", st_c),
        CoverageAim {
            law: WetLaw::Linear,
            quantity: "true e_inf",
            of: e_inf,
            target: value(WetLaw::Sqrt, e_inf),
            counts: false,
        },
    ])
}

/// The data sets that are simulated of each design.
#[derive(Clone, Copy)]
struct DrawnSets {
    sets: u64,
    /// of each
    replicates: u64,
    seed: u64,
}

fn of_design(
    design: &CalibrationDesign,
    drawn: DrawnSets,
    ranks: &Ranks,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Coverage>, Error> {
    const SIGMA: f64 = 0.02;
    let DrawnSets { sets, replicates, seed } = drawn;
    let aims = aims(&design.scene(replicates, 0.0)?)?;
    let scene = design.scene(replicates, SIGMA)?;
    let width = METHODS.len() * LEVELS.len();
    let of_set = |set: u64| -> Result<Vec<u64>, Error> {
        let fitted = infer(&scene, seed, set, true)?;
        let mut hits = vec![0; aims.len() * width];
        for (aim, hits) in aims.iter().zip(hits.chunks_mut(width)) {
            let found = fitted.iter().find(|fitted| fitted.law == aim.law).map(aim.of);
            for interval in found.map_or(&[][..], |estimate| &estimate.intervals) {
                if let Some(place) = index_of(interval) {
                    hits[place] += u64::from(interval.lo <= aim.target && aim.target <= interval.hi);
                }
            }
        }
        progress();
        Ok(hits)
    };
    let hits = ranks.gather(sets, |own| own.into_par_iter().map(of_set).collect())?;
    let mut counts = vec![0; aims.len() * width];
    for hits in &hits {
        counts.iter_mut().zip(hits).for_each(|(count, hit)| *count += hit);
    }
    let mut rows = vec![];
    for (aim, counts) in aims.iter().zip(counts.chunks(width)) {
        for (method, counts) in METHODS.into_iter().zip(counts.chunks(LEVELS.len())) {
            let share = |level: usize| counts[level] as f64 / sets as f64;
            rows.push(Coverage {
                design: design.name,
                law: aim.law,
                quantity: aim.quantity,
                method,
                covered: [share(0), share(1)],
                counts: aim.counts,
            });
        }
    }
    Ok(rows)
}

fn index_of(interval: &Interval) -> Option<usize> {
    let method = METHODS.into_iter().position(|method| method == interval.method)?;
    let level = LEVELS.into_iter().position(|level| level == interval.level)?;
    Some(method * LEVELS.len() + level)
}

/// The title of the page.
const TITLE: &str = "Do the intervals cover?";

/// Fails where something stands at a place that is no earlier page of this kind.
pub fn may_replace(place: &OutputPlace) -> Result<(), Error> {
    let heading = format!("# {TITLE}");
    let is_ours = || {
        let mut start = vec![];
        let file = std::fs::File::open(place.path()).ok()?;
        file.take(heading.len() as u64).read_to_end(&mut start).ok()?;
        (start == heading.as_bytes()).then_some(())
    };
    if place.is_taken() && !(place.path().is_file() && is_ours().is_some()) {
        return Err(Error::Out {
            path: place.named().to_path_buf(),
            reason: "exists and is no page of `wetcor calibrate`".to_owned(),
        });
    }
    Ok(())
}

/// The table as markdown.
pub fn markdown(table: &CoverageTable) -> String {
    let mut page = Page::titled(TITLE, &[]);
    page.paragraph(&format!(
        "Share of {} simulated data sets, in per cent, whose 90 % and 95 % intervals of e_inf and St_c cover the truth, \
         for each design, law and method; {} replicates each (cases). The Monte Carlo error of a share is {:.1} at 90 % \
         and {:.1} at 95 %. Delta: with Student's t. The linear law is held against its own noise-free fit on the same \
         design, and once against the true e_inf.",
        table.sets,
        table.replicates,
        100.0 * table.mcse(0.90),
        100.0 * table.mcse(0.95)
    ));
    page.paragraph("Made by `wetcor calibrate --out reports/calibration.md`.");
    page.paragraph(&format!(
        "Runs are resampled inside series and, in these, inside impact speeds; speeds with fewer than {LEAST_RUNS} runs \
         join their neighbours. From n runs n − 1 are drawn with the weight n/(n − 1), and percentile and BCa limits are \
         taken at Φ(t) for Student's t with the degrees of freedom of the strata. Without the strata of speed the \
         linear law's misfit counts as noise; without the other two every interval of few runs is too short."
    ));
    let designs = ALL.iter().map(|design| format!("{}: {}", design.name, design.what));
    page.list(&designs.collect::<Vec<_>>());
    let rows = table.rows.chunks_exact(METHODS.len());
    let mut covered = ReportTable::of(rows)
        .whole()
        .column("design", |methods| methods[0].design)
        .column("law", |methods| methods[0].law.name())
        .column("quantity", |methods| methods[0].quantity);
    for (place, method) in METHODS.into_iter().enumerate() {
        for (level, at) in LEVELS.into_iter().enumerate() {
            covered = covered.column(format!("{method} {:.0}", 100.0 * at), |methods| {
                format!("{:.1}", 100.0 * methods[place].covered[level])
            });
        }
    }
    page.table(&covered);
    let worst = METHODS.map(|method| format!("{method} {:.1}", 100.0 * table.worst(method)));
    page.paragraph(&format!(
        "Largest distance from the level, true e_inf of the linear law excepted: {}. The smallest, or the simplest as near \
         to it as the Monte Carlo error, is the default: {}.",
        worst.join(", "),
        table.best()
    ));
    page.text.trim_end().to_owned() + "\n"
}

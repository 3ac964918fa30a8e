//! Measures how often the intervals of e_inf and St_c cover the truth they were simulated from.

use std::array::from_fn;
use std::io::Read;
use std::path::Path;

use minijinja::context;
use rayon::prelude::*;

use crate::error::Error;
use crate::findings::estimate::Estimate;
use crate::findings::scaling::{self, Scaling};
use crate::findings::{bootstrap, FitSetup};
use crate::inference::bootstrap::strata::LEAST_RUNS;
use crate::inference::delta::LEVELS;
use crate::model::simulate::Simulation;
use crate::physics::Quantity;
use crate::ranks::Ranks;
use crate::report::template;
use crate::runs;
use crate::scene::{self, Scene, WetLaw};
use crate::seed::stream;
use crate::staging::OutputPlace;

/// The methods compared, as intervals name them, the simplest first.
const METHODS: [&str; 3] = ["delta", "percentile", "bca"];

/// Data sets of each design.
pub const SETS: u64 = 4000;

/// Most data sets of a design: the shares are then known to 0.03 %.
pub const MOST_SETS: u64 = 1_000_000;

/// Replicates of each simulated data set: enough that their number does not show in the coverage.
const REPLICATES: u64 = 2000;

/// The data sets that are drawn of each design, and who draws them.
#[derive(Clone, Copy)]
pub struct DrawnSets<'a> {
    /// how many a design
    pub sets: u64,
    /// seed of every use of chance
    pub seed: u64,
    /// the processes that share them
    pub ranks: &'a Ranks,
    /// called after each data set of this process
    pub progress: &'a (dyn Fn() + Sync),
}

/// A design whose intervals are put to the test.
struct CoverageDesign {
    name: &'static str,
    /// in words
    what: &'static str,
    diameter_mm: &'static str,
    /// the other lines of `[design]`
    design: &'static str,
    /// lines of `[truth]` in which designs differ
    truth: &'static str,
}

/// How many designs are measured.
pub const DESIGNS: u64 = ALL.len() as u64;

const PAPER: CoverageDesign = CoverageDesign {
    name: "paper",
    what: "the paper's design at one film ratio: 2 diameters, 2 liquids, 5 heights, 5 repeats, normal noise",
    diameter_mm: "4.762, 8.0",
    design: "liquids = [\"AK10\", \"M50\"]\nfilm_ratio = { PTFE = [0.06] }\nheight_mm = [30, 60, 90, 120, 150]\nrepeats = 5\n",
    truth: "noise = \"normal\"\n",
};

const ALL: [CoverageDesign; 5] = [
    PAPER,
    CoverageDesign {
        name: "small",
        what: "8 runs: 1 diameter, 1 liquid, 4 heights, 2 repeats, normal noise",
        diameter_mm: "4.762",
        design: "liquids = [\"M50\"]\nfilm_ratio = { PTFE = [0.06] }\nheight_mm = [30, 60, 100, 150]\nrepeats = 2\n",
        ..PAPER
    },
    CoverageDesign {
        name: "skewed",
        what: "as the paper's, noise with a long tail to low restitutions",
        truth: "noise = \"skewed\"\n",
        ..PAPER
    },
    CoverageDesign {
        name: "heteroscedastic",
        what: "as the paper's, noise growing with 1/St from about half to twice its mean",
        truth: "noise = \"heteroscedastic\"\n",
        ..PAPER
    },
    CoverageDesign {
        name: "unrepeated",
        what: "as the paper's, each series at 25 speeds once",
        design: "liquids = [\"AK10\", \"M50\"]\nfilm_ratio = { PTFE = [0.06] }\n\
                 impact_speed_m_s = [0.77, 0.81, 0.85, 0.89, 0.93, 0.97, 1.01, 1.05, 1.09, 1.13, 1.17, 1.21, 1.25, 1.29, \
                 1.33, 1.37, 1.41, 1.45, 1.49, 1.53, 1.57, 1.61, 1.65, 1.69, 1.73]\nrepeats = 1\n",
        ..PAPER
    },
];

impl CoverageDesign {
    /// Its scene with this spread of the wet restitutions; both liquids have one density, so that the square-root law is the
    /// truth itself.
    fn scene(&self, sigma_wet: f64) -> Result<Scene, Error> {
        let CoverageDesign {
            name,
            diameter_mm,
            design,
            truth,
            ..
        } = self;
        let text = format!(
            "title = \"{name}\"\n[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n\
             [liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n\
             [liquids.M50]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 48.3\n[bootstrap]\nreplicates = {REPLICATES}\n\
             [truth]\ndry_k = {{ PTFE = 0.183 }}\nlubrication_log = 1.85\ninertia = \"saturating\"\n\
             inertial_prefactor = 0.47\nfilm_scale = 0.069\nsigma_dry = 0.009\nsigma_wet = {sigma_wet}\n{truth}\
             [design]\ndiameter_mm = {{ PTFE = [{diameter_mm}] }}\n{design}"
        );
        scene::parse(&text, Path::new("calibration/scene.toml"), String::new())
    }
}

/// A law, a quantity of it, and the law whose fit of noise-free runs is the truth that its intervals are held against.
type Aim = (WetLaw, Quantity, WetLaw);

const AIMS: [Aim; 5] = [
    (WetLaw::Sqrt, Quantity::EInf, WetLaw::Sqrt),
    (WetLaw::Sqrt, Quantity::StC, WetLaw::Sqrt),
    (WetLaw::Linear, Quantity::EInf, WetLaw::Linear),
    (WetLaw::Linear, Quantity::StC, WetLaw::Linear),
    (WetLaw::Linear, Quantity::EInf, WetLaw::Sqrt),
];

fn estimate(fitted: &[Scaling], law: WetLaw, quantity: Quantity) -> Option<&Estimate> {
    let own = fitted.iter().find(|fitted| fitted.law == law)?;
    Some(&own.estimates[quantity])
}

/// How often the intervals of a quantity cover the truth in the data sets of a design.
struct CoverageRow {
    design: &'static CoverageDesign,
    aim: Aim,
    /// share of the data sets, by method and level
    covered: [[f64; LEVELS.len()]; METHODS.len()],
}

/// The measured table.
pub struct CoverageTable {
    /// data sets a design
    sets: u64,
    rows: Vec<CoverageRow>,
}

impl CoverageTable {
    /// The largest |coverage − level| of a method, over designs, laws, quantities and levels that count.
    fn worst(&self, method: usize) -> f64 {
        let counted = self.rows.iter().filter(|CoverageRow { aim, .. }| aim.0 == aim.2);
        let shares = counted.flat_map(|row| row.covered[method].into_iter().zip(LEVELS));
        shares
            .map(|(covered, level)| (covered - level).abs())
            .fold(0.0, f64::max)
    }

    /// The method with the smallest worst; of methods nearer to it than the Monte Carlo error, the simplest.
    fn best(&self) -> &'static str {
        let worst: [f64; METHODS.len()] = from_fn(|method| self.worst(method));
        let smallest = worst.into_iter().fold(f64::INFINITY, f64::min);
        let near = worst.iter().position(|worst| *worst <= smallest + self.mcse(LEVELS[0]));
        METHODS[near.unwrap_or(0)]
    }

    /// Monte Carlo error of a share.
    fn mcse(&self, level: f64) -> f64 {
        (level * (1.0 - level) / self.sets as f64).sqrt()
    }
}

/// Simulates, fits and bootstraps the data sets of every design.
pub fn measure(drawn: DrawnSets) -> Result<CoverageTable, Error> {
    const SIGMA: f64 = 0.02;
    let sets = drawn.sets;
    let mut rows = vec![];
    for design in &ALL {
        let exact = infer(&design.scene(0.0)?, 0, 0, false)?;
        let scene = design.scene(SIGMA)?;
        // holds no more of what is drawn: processes of MPI are no thread's to share
        let of_set = |set: u64| -> Result<_, Error> {
            let fitted = infer(&scene, drawn.seed, set, true)?;
            (drawn.progress)();
            Ok(covering(&exact, &fitted))
        };
        let each = drawn
            .ranks
            .gather(sets, |own| own.into_par_iter().map(of_set).collect())?;
        let mut counts = [[[0; LEVELS.len()]; METHODS.len()]; AIMS.len()];
        for [aim, method, level] in each.into_iter().flatten() {
            counts[aim][method][level] += 1;
        }
        let share = |count: u64| count as f64 / sets as f64;
        let of_aims = AIMS.into_iter().zip(counts);
        rows.extend(of_aims.map(|(aim, counts)| CoverageRow {
            design,
            aim,
            covered: counts.map(|of_method| of_method.map(share)),
        }));
    }
    Ok(CoverageTable { sets, rows })
}

/// The intervals that cover their truth, by the places of aim, method and level.
fn covering(exact: &[Scaling], fitted: &[Scaling]) -> Vec<[usize; 3]> {
    let mut found = vec![];
    for (aim, (law, quantity, truth_of)) in AIMS.into_iter().enumerate() {
        let truth = estimate(exact, truth_of, quantity).and_then(|own| own.value);
        for interval in estimate(fitted, law, quantity).map_or(&[][..], |own| &own.intervals) {
            let method = METHODS.into_iter().position(|method| method == interval.method);
            let level = LEVELS.into_iter().position(|level| level == interval.level);
            let covers = truth.is_some_and(|truth| interval.lo <= truth && truth <= interval.hi);
            let place = method.zip(level).filter(|_| covers);
            found.extend(place.map(|(method, level)| [aim, method, level]));
        }
    }
    found
}

/// Both laws at the design's one film ratio, bootstrapped or not.
fn infer(scene: &Scene, seed: u64, set: u64, replicated: bool) -> Result<Vec<Scaling>, Error> {
    let drawn = Simulation::new(scene, None)?.draw_from(stream(seed, "calibration", set));
    let runs = runs::arrange(scene, &drawn);
    let setup = FitSetup {
        scene,
        runs: &runs,
        dry: &[],
    };
    let mut fitted = scaling::fit_scaling(setup);
    fitted.retain(|fitted| fitted.film_ratio.is_some());
    if replicated {
        let estimates = bootstrap::Estimates {
            dry: &mut [],
            series: &mut [],
            scaling: &mut fitted,
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
        let reason = "exists and is no page of `wetcor calibrate`";
        return Err(Error::out(place.named(), reason));
    }
    Ok(())
}

/// The table as markdown.
pub fn markdown(table: &CoverageTable) -> Result<String, Error> {
    let columns = METHODS
        .iter()
        .flat_map(|method| LEVELS.map(|at| format!("{method} {:.0}", 100.0 * at)));
    let row = |CoverageRow { design, aim, covered }: &CoverageRow| {
        let (law, quantity, truth_of) = *aim;
        let of = if law == truth_of { "" } else { "true " };
        context! {
            design => design.name,
            law => law.name(),
            quantity => format!("{of}{}", quantity.describe().name),
            covered => covered.as_flattened().to_vec(),
        }
    };
    let worst = METHODS.iter().enumerate();
    let worst = worst.map(|(place, method)| context! { method => method.to_string(), distance => table.worst(place) });
    let values = context! {
        title => TITLE,
        sets => table.sets,
        replicates => REPLICATES,
        errors => LEVELS.map(|level| 100.0 * table.mcse(level)).to_vec(),
        least_runs => LEAST_RUNS,
        designs => ALL.each_ref().map(|design| format!("{}: {}", design.name, design.what)).to_vec(),
        columns => columns.collect::<Vec<_>>(),
        rows => table.rows.iter().map(row).collect::<Vec<_>>(),
        worst => worst.collect::<Vec<_>>(),
        best => table.best().to_string(),
    };
    template::page("calibration.md", &values, &[])
}

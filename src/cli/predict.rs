//! Runs `wetcor predict`: the restitution at speeds of the user's choice, from a finished fit's folder.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use wetcor::error::{quoted, Error};
use wetcor::findings::predict::{LiquidBasis, PredictedSeries};
use wetcor::physics::form::Term;
use wetcor::physics::Setting;
use wetcor::report::finished::{Finished, SeriesSetting};
use wetcor::report::prediction::{self, Origin};
use wetcor::scene::{name_expected, LARGEST_FILM_RATIO};
use wetcor::units::Dimension;

use super::messages::{print_result, warn, NOT_QUOTABLE};

#[derive(Args)]
#[command(after_help = "\
Example:
  wetcor predict reports/mueller2016 --particle PTFE --liquid AK10 --diameter-mm 4.762 --film-um 286 --speed-m-s 0.2:2:10

A line a speed. restitution is the posterior median of the curve of the energy balance, 0 where it does not rebound; its \
_q05 to _q95 are the points of its 50 % and 90 % bands, from the parameters' uncertainty alone: what a simulation needs. \
run_q05 to run_q95 are those of a single run with its scatter, 0 where it sticks: what an experiment will see. log_slope \
is d ln e/d ln v of the curve. extrapolated: outside the Stokes numbers or the film ratios of the particle's runs. Of a fit with [model] \
series_offsets all bands are those of a new series, unless --measured-series is given; series says which. A fit that is not to be quoted is \
predicted from with exit status 1, unless --anyway is given.")]
pub struct Predict {
    /// Folder of a finished fit
    folder: PathBuf,
    /// A particle of the scene
    #[arg(long)]
    particle: String,
    /// A liquid of the scene; for another give its density and viscosity instead
    #[arg(long, required_unless_present_all = ["liquid_density", "viscosity"])]
    liquid: Option<String>,
    /// Density of a liquid the scene has not, kg/m³
    #[arg(long = "liquid-density-kg-m3", value_name = "X", value_parser = positive, requires = "viscosity", conflicts_with = "liquid")]
    liquid_density: Option<f64>,
    /// Its viscosity, mPa s
    #[arg(long = "viscosity-mPa-s", value_name = "X", value_parser = positive, requires = "liquid_density", conflicts_with = "liquid")]
    viscosity: Option<f64>,
    /// Diameter of the particle, mm; one of the fit's where each has its own k
    #[arg(long = "diameter-mm", value_name = "X", value_parser = positive)]
    diameter: f64,
    /// Thickness of the film, µm
    #[arg(long = "film-um", value_name = "X", value_parser = positive)]
    film: f64,
    /// Impact speeds, m/s: so many from the first to the last
    #[arg(long = "speed-m-s", value_name = "FIRST:LAST:COUNT", value_parser = speeds)]
    speed: Speeds,
    /// Predict the series that was measured at this setting, where series have offsets, in place of a new one
    #[arg(long, requires = "liquid")]
    measured_series: bool,
    /// Exit with 0 on a fit that is not to be quoted, too
    #[arg(long)]
    anyway: bool,
    /// What to print
    #[arg(long, value_enum, default_value_t = Format::Csv)]
    format: Format,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// a table
    Csv,
    /// an object with a list
    Json,
}

/// Most speeds of one call.
const MOST_SPEEDS: usize = 100_000;

#[derive(Clone, Copy)]
struct Speeds {
    first: f64,
    last: f64,
    count: usize,
}

impl Speeds {
    /// Evenly spaced, the ends themselves included.
    fn all(self) -> Vec<f64> {
        let last = self.count - 1;
        let steps = last.max(1) as f64;
        let speed = |i: usize| match i {
            0 => self.first,
            i if i == last => self.last,
            i => {
                let between = (self.first * (last - i) as f64 + self.last * i as f64) / steps;
                // to twelve digits, as one would write it: 0.6:1.8:5 has a 0.9, not a 0.8999999999999999
                format!("{between:.11e}").parse().unwrap_or(between)
            }
        };
        (0..self.count).map(speed).collect()
    }
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "expected a number above 0".to_owned())
}

fn speeds(text: &str) -> Result<Speeds, String> {
    let expected = || {
        format!(
            "expected FIRST:LAST:COUNT as 0.2:2:10, 0 < FIRST < LAST, COUNT from 2 to {MOST_SPEEDS} (or v:v:1 for one)"
        )
    };
    let parts: Vec<&str> = text.split(':').collect();
    let [first, last, count] = parts[..] else {
        return Err(expected());
    };
    let (Ok(first), Ok(last), Ok(count)) = (positive(first), positive(last), count.parse()) else {
        return Err(expected());
    };
    let in_order = if count == 1 { first == last } else { first < last };
    if in_order && (1..=MOST_SPEEDS).contains(&count) {
        Ok(Speeds { first, last, count })
    } else {
        Err(expected())
    }
}

/// Prints the prediction, and on standard error what to mind.
pub fn predict(request: &Predict, quiet: bool) -> Result<u8, Error> {
    let finished = Finished::read(&request.folder)?;
    let diameter = Dimension::Length.usual_to_si(request.diameter);
    let film = Dimension::Thickness.usual_to_si(request.film);
    let measured = request.liquid.as_deref().filter(|_| request.measured_series);
    let law = match measured {
        Some(liquid) => finished.law_of_series(&SeriesSetting {
            particle: &request.particle,
            liquid,
            diameter,
            film_ratio: film / diameter,
        })?,
        None => finished.law(&request.particle, diameter)?,
    };
    let series = measured.map(|_| PredictedSeries::Measured).or(finished.series());
    let particles = &finished.basis.particles;
    let Some(particle) = particles.iter().find(|particle| particle.name == request.particle) else {
        return Err(Error::Internal {
            doing: "find the particle",
            reason: "a law of an unknown particle".to_owned(),
        });
    };
    let LiquidBasis {
        density_kg_m3: liquid_density,
        viscosity_pa_s: viscosity,
        surface_tension_n_m: surface_tension,
        ..
    } = liquid(request, &finished)?;
    if Term::Bridge.is_held(law.form) && surface_tension.is_none() {
        let text = "the fit holds the rupture of the bridge, and this liquid's surface tension is not known";
        return Err(Error::Usage(format!(
            "--liquid: {text}; name a liquid of the scene that has one"
        )));
    }
    let setting = Setting {
        density: particle.density_kg_m3,
        diameter,
        roughness: particle.roughness_m,
        liquid_density,
        viscosity,
        film,
        surface_tension,
    };
    check_domain(&setting)?;
    let rows = law.predict(&setting, &request.speed.all());
    let text = match request.format {
        Format::Csv => prediction::csv(&rows, series)?,
        Format::Json => {
            let origin = Origin {
                title: &finished.title,
                particle: &request.particle,
                liquid: request.liquid.as_deref(),
                series,
                draws: law.draws.len(),
                quotable: finished.failed.is_empty(),
            };
            prediction::json(origin, &setting, &rows)?
        }
    };
    if !quiet {
        for check in &finished.failed {
            warn(&format!("the fit is not to be quoted, and this not either: {check}"));
        }
        if let Some(grows) = &finished.noise_grows {
            warn(&format!(
                "run_q05 to run_q95 and stuck_probability take one spread for every run, and {grows}"
            ));
        }
        let outside = rows.iter().filter(|row| row.extrapolated).count();
        if outside > 0 {
            let of = rows.len();
            warn(&match law.covered {
                Some(covered) => format!(
                    "{outside} of {of} speeds extrapolated: runs of {} covered Stokes numbers {:.1} to {:.1} and film ratios {:.3} to {:.3}",
                    request.particle, covered.stokes[0], covered.stokes[1], covered.film_ratio[0], covered.film_ratio[1]
                ),
                None => format!("all speeds extrapolated: {} has no wet runs", request.particle),
            });
        }
    }
    print_result(&text)?;
    Ok(if finished.failed.is_empty() || request.anyway {
        0
    } else {
        NOT_QUOTABLE
    })
}

/// Fails where no formula is valid, or a number of the command line vanishes in SI.
fn check_domain(setting: &Setting) -> Result<(), Error> {
    for (flag, x) in [
        ("--diameter-mm", setting.diameter),
        ("--film-um", setting.film),
        ("--viscosity-mPa-s", setting.viscosity),
        ("--liquid-density-kg-m3", setting.liquid_density),
        ("the liquid's density over the particle's", setting.density_ratio()),
    ] {
        if !x.is_normal() {
            let expected = "expected a number that is neither too small nor too large to compute with";
            return Err(Error::Usage(format!("{flag}: found {x:e} in SI, {expected}")));
        }
    }
    let ratio = setting.film_ratio();
    if ratio > LARGEST_FILM_RATIO {
        return Err(Error::Usage(format!(
            "--film-um: found a film ratio of {ratio:.3}, expected at most {LARGEST_FILM_RATIO}: no formula is valid above"
        )));
    }
    Ok(())
}

/// Density and viscosity of the liquid request for, kg/m³ and Pa s.
fn liquid(request: &Predict, finished: &Finished) -> Result<LiquidBasis, Error> {
    let liquids = &finished.basis.liquids;
    match (&request.liquid, request.liquid_density, request.viscosity) {
        (None, Some(density), Some(viscosity)) => Ok(LiquidBasis {
            name: String::new(),
            density_kg_m3: Dimension::Density.usual_to_si(density),
            viscosity_pa_s: Dimension::Viscosity.usual_to_si(viscosity),
            surface_tension_n_m: None,
        }),
        (name, ..) => {
            let name = name.as_deref().unwrap_or_default();
            let listed = liquids.iter().find(|liquid| liquid.name == name);
            listed.cloned().ok_or_else(|| {
                let names = liquids.iter().map(|liquid| liquid.name.as_str());
                let all: Vec<&str> = names.clone().collect();
                let expected = name_expected(&format!("one of {}", all.join(", ")), name, names);
                let other = "for another liquid give --liquid-density-kg-m3 and --viscosity-mPa-s";
                Error::Usage(format!("--liquid: found {}, {expected}; {other}", quoted(name)))
            })
        }
    }
}

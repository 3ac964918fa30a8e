//! Runs `wetcor predict`: the restitution at speeds of the user's choice, from a finished fit's folder.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use rayon::prelude::*;
use wetcor::error::{named, Error};
use wetcor::findings::predict::{Covered, ParticleLaw};
use wetcor::physics::Setting;
use wetcor::report::finished::Finished;
use wetcor::report::prediction::{self, Prediction};
use wetcor::runs::{read_settings, AskedSetting};

use super::messages::{print_result, status, warn};
use super::setting::{find_law, positive, warn_of, AskedLiquid, AskedPair, SettingArguments};

#[derive(Args)]
#[command(after_help = include_str!("help/predict.txt").trim_ascii_end())]
pub struct Predict {
    /// Folder of a finished fit
    folder: PathBuf,
    #[command(flatten)]
    setting: SettingArguments,
    /// A table of settings in place of one: CSV or workbook (`book.xlsx#May` of several sheets)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["particle", "liquid", "liquid_density", "viscosity", "diameter", "film"])]
    settings: Option<PathBuf>,
    /// Impact speeds, m/s: so many from the first to the last
    #[arg(long = "speed-m-s", value_name = "FIRST:LAST:COUNT", value_parser = speeds, required_unless_present = "settings")]
    speed: Option<Speeds>,
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

/// Impact speeds, m/s.
#[derive(Clone)]
struct Speeds(Vec<f64>);

fn speeds(text: &str) -> Result<Speeds, String> {
    evenly_spaced(text).ok_or_else(|| {
        format!(
            "expected FIRST:LAST:COUNT as 0.2:2:10, 0 < FIRST < LAST, COUNT from 2 to {MOST_SPEEDS} (or v:v:1 for one)"
        )
    })
}

/// So many speeds, the ends themselves included.
fn evenly_spaced(text: &str) -> Option<Speeds> {
    let (first, rest) = text.split_once(':')?;
    let (last, count) = rest.split_once(':')?;
    let (first, last, count) = (
        positive(first).ok()?,
        positive(last).ok()?,
        count.parse::<usize>().ok()?,
    );
    let in_order = if count == 1 { first == last } else { first < last };
    if !in_order || !(1..=MOST_SPEEDS).contains(&count) {
        return None;
    }
    let end = count - 1;
    let speed = |i: usize| {
        let between = (first * (end - i) as f64 + last * i as f64) / end.max(1) as f64;
        match i {
            0 => first,
            i if i == end => last,
            // to twelve digits, as one would write it: 0.6:1.8:5 has a 0.9, not a 0.8999999999999999
            _ => format!("{between:.11e}").parse().unwrap_or(between),
        }
    };
    Some(Speeds((0..count).map(speed).collect()))
}

/// A pair with the speeds asked for there.
struct Asked {
    /// line of the table of settings
    line: Option<u64>,
    pair: AskedPair,
    speeds: Vec<f64>,
}

impl Predict {
    /// What is asked for, each pair with its speeds.
    fn asked(&self) -> Result<Vec<Asked>, Error> {
        let speeds = self.speed.as_ref().map(|Speeds(all)| all.clone());
        let Some(path) = &self.settings else {
            return Ok(vec![Asked {
                line: None,
                pair: self.setting.pair()?,
                speeds: speeds.unwrap_or_default(),
            }]);
        };
        let settings = read_settings(path)?;
        let in_table = settings.iter().any(|setting| setting.impact_speed.is_some());
        if in_table == speeds.is_some() {
            let problem = if in_table {
                "the table of settings has impact speeds of its own: expected no --speed-m-s"
            } else {
                "expected --speed-m-s, or a column `impact_speed_m_s` in the table of settings"
            };
            return Err(Error::Usage(problem.to_owned()));
        }
        let rows = settings.len().saturating_mul(speeds.as_ref().map_or(1, Vec::len));
        if rows > MOST_SPEEDS {
            return Err(Error::Usage(format!(
                "found {rows} speeds of all settings together, expected at most {MOST_SPEEDS}"
            )));
        }
        let asked = |setting: AskedSetting| Asked {
            line: Some(setting.line),
            pair: AskedPair {
                particle: setting.particle,
                liquid: setting.liquid.map_or(AskedLiquid::Dry, AskedLiquid::Named),
                diameter: setting.diameter,
                film: setting.film,
            },
            speeds: match setting.impact_speed {
                Some(speed) => vec![speed],
                None => speeds.clone().unwrap_or_default(),
            },
        };
        Ok(settings.into_iter().map(asked).collect())
    }
}

/// Prints the prediction, and on standard error what to mind.
pub fn predict(request: &Predict) -> Result<u8, Error> {
    let all = request.asked()?;
    let finished = Finished::read(&request.folder)?;
    let in_table = |error, asked: &Asked| match (error, &request.settings, asked.line) {
        (Error::Usage(text), Some(path), Some(line)) => Error::Usage(format!("{}: line {line}: {text}", named(path))),
        (other, ..) => other,
    };
    let predicted = all.par_iter().map(|asked| {
        let (wet, law) = find_law(&asked.pair, &finished).map_err(|error| in_table(error, asked))?;
        let rows = law.curve(wet.as_ref()).predict(&asked.speeds);
        let beyond = rows.iter().filter(|row| row.extrapolated).count();
        let outside = (beyond > 0).then(|| beyond_the_runs(asked, (wet.as_ref(), &law), beyond));
        let pair = &asked.pair;
        let prediction = Prediction {
            series: (finished.has_offsets() && wet.is_some()).then_some("new"),
            ..Prediction::new(&pair.particle, pair.liquid.name(), pair.diameter, wet.as_ref(), rows)
        };
        Ok((prediction, outside))
    });
    let predicted: Vec<Result<_, Error>> = predicted.collect();
    let predicted: Vec<_> = predicted.into_iter().collect::<Result<_, _>>()?;
    let (predictions, outside): (Vec<Prediction>, Vec<Option<String>>) = predicted.into_iter().unzip();
    let one = request.settings.is_none();
    let text = match request.format {
        Format::Csv => prediction::csv(&predictions, !one)?,
        Format::Json => prediction::json(&finished, &predictions, one)?,
    };
    warn_of(&finished);
    if let Some(grows) = &finished.noise_grows {
        warn(&format!(
            "run_q05 to run_q95 and stuck_probability take one spread for every run, and {grows}"
        ));
    }
    // of the first few settings how far beyond the runs they are
    const SHOWN: usize = 3;
    let mut outside = outside.into_iter().flatten();
    outside.by_ref().take(SHOWN).for_each(|text| warn(&text));
    let more = outside.count();
    if more > 0 {
        warn(&format!("{more} more settings with extrapolated speeds"));
    }
    print_result(&text)?;
    Ok(status(finished.failed.is_empty() || request.anyway))
}

/// Says how many of the speeds lie beyond the runs, and where these were made.
fn beyond_the_runs(asked: &Asked, (wet, law): (Option<&Setting>, &ParticleLaw), beyond: usize) -> String {
    let particle = &asked.pair.particle;
    let speeds = |[slowest, fastest]: [f64; 2]| format!("{slowest:.3} to {fastest:.3} m/s");
    let numbers = |Covered {
                       stokes: [least, most],
                       film_ratio: [thinnest, thickest],
                   }: Covered| {
        format!("Stokes numbers {least:.1} to {most:.1} and film ratios {thinnest:.3} to {thickest:.3}")
    };
    let covered = match (wet, law.particle.covered, law.particle.dry_speeds_m_s) {
        (Some(wet), Some(in_all), _) => match law.range_in(wet) {
            Some(own) => {
                let liquid = asked.pair.liquid.name().unwrap_or("this liquid");
                let (speeds, numbers) = (speeds(own.impact_speed_m_s), numbers(own.covered));
                format!("runs of {particle} in {liquid} covered {speeds}, {numbers}")
            }
            None if law.particle.covered_in.is_empty() => format!("runs of {particle} covered {}", numbers(in_all)),
            None => format!(
                "no run of {particle} was made in this liquid; in others they covered {}",
                numbers(in_all)
            ),
        },
        (None, _, Some(own)) => format!("dry runs of {particle} covered speeds from {}", speeds(own)),
        (wet, ..) => {
            let kind = if wet.is_some() { "wet" } else { "dry" };
            return format!("all speeds extrapolated: {particle} has no {kind} runs");
        }
    };
    format!("{beyond} of {} speeds extrapolated: {covered}", asked.speeds.len())
}

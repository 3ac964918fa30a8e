//! Runs `wetcor handoff`: files for a simulation code, from a finished fit's folder.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::Args;
use wetcor::error::{named, Error};
use wetcor::handoff::{self, Code, Handoff, HandoffFile};
use wetcor::report::finished::Finished;
use wetcor::staging::{self, OutputPlace, Staging};

use super::messages::{print_after_writing, print_result, status, warn};
use super::setting::{find_law, positive, warn_of, SettingArguments};

#[derive(Args)]
#[command(after_help = include_str!("help/handoff.txt").trim_ascii_end())]
pub struct HandoffArguments {
    /// Folder of a finished fit
    folder: PathBuf,
    #[command(flatten)]
    setting: SettingArguments,
    /// Impact speed at which the code is to have the law's restitution, m/s
    #[arg(long = "speed-m-s", value_name = "V", value_parser = positive, allow_negative_numbers = true)]
    speed: f64,
    /// The simulation code, or a table of e at many speeds
    #[arg(long, value_parser = codes())]
    to: Code,
    /// Folder to write; one that is there is kept
    #[arg(long)]
    out: Option<PathBuf>,
    /// Exit with 0 on a fit that is not to be quoted, too
    #[arg(long)]
    anyway: bool,
}

/// Codes that nobody has run the lines of.
const NEVER_RUN: [&str; 2] = ["mercurydpm", "mfix"];

/// Reads the word of a code, and refuses those that were never run.
fn codes() -> impl TypedValueParser<Value = Code> {
    let words = Code::ALL.map(|code| PossibleValue::new(code.word()));
    let never_run = NEVER_RUN.map(|word| PossibleValue::new(word).hide(true));
    let all = PossibleValuesParser::new(words.into_iter().chain(never_run));
    all.try_map(|word| {
        let code = Code::ALL.into_iter().find(|code| code.word() == word);
        code.ok_or("expected `table`; docs/simulation-codes.md has lines to paste for this code, which were never run")
    })
}

/// Writes the files, or prints the first.
pub fn handoff(request: &HandoffArguments) -> Result<u8, Error> {
    let asked = request.setting.pair()?;
    let place = request.out.as_deref().map(staging::prepare).transpose()?;
    if let Some(place) = &place {
        place.check_free("folder")?;
    }
    let finished = Finished::read(&request.folder)?;
    let (wet, law) = find_law(&asked, &finished)?;
    let curve = law.curve(wet.as_ref());
    let source = format!(
        "posterior median of the energy balance, {} draws{}",
        law.draws.len(),
        if finished.has_offsets() && wet.is_some() {
            ", of a new series"
        } else {
            ""
        }
    );
    let range = wet.as_ref().and_then(|wet| law.range_in(wet));
    let files = handoff::files(
        request.to,
        &Handoff {
            title: &finished.title,
            source: &source,
            particle: &asked.particle,
            density: finished.particle(&asked.particle)?.density_kg_m3,
            diameter: asked.diameter,
            liquid: asked.liquid.name().unwrap_or("a liquid that the scene has not"),
            wet,
            reference_speed: request.speed,
            law: &|v| curve.at(v),
            log_slope: curve.log_slope(request.speed),
            speeds: match wet {
                Some(_) => range.map(|own| own.impact_speed_m_s),
                None => law.particle.dry_speeds_m_s,
            },
            stokes: range.map(|own| own.covered.stokes),
            quotable: finished.failed.is_empty(),
        },
    )?;
    warn_of(&finished);
    let v = request.speed;
    if curve.at(v).extrapolated {
        warn(&format!(
            "extrapolated: at {v} m/s this pair lies outside what the runs of the particle in this liquid covered"
        ));
    }
    match (&request.out, place) {
        (Some(out), Some(place)) => write(&place, out, &files)?,
        _ => print_first(&files)?,
    }
    Ok(status(finished.failed.is_empty() || request.anyway))
}

fn print_first(files: &[HandoffFile]) -> Result<(), Error> {
    let Some((first, others)) = files.split_first() else {
        return Ok(());
    };
    if !others.is_empty() {
        let names: Vec<&str> = others.iter().map(|file| file.name).collect();
        warn(&format!("with --out there is {} as well", names.join(", ")));
    }
    print_result(&first.text)
}

fn write(place: &OutputPlace, out: &Path, files: &[HandoffFile]) -> Result<(), Error> {
    let staging = Staging::beside(place)?;
    for file in files {
        let written = staging
            .create(file.name)
            .and_then(|mut made| made.write_all(file.text.as_bytes()));
        written.map_err(|error| Error::io(&out.join(file.name), "write", error))?;
    }
    staging.put(|place| place.check_free("folder"))?;
    let names: String = files.iter().map(|file| named(&out.join(file.name)) + "\n").collect();
    print_after_writing(out, &names)
}

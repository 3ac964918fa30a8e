//! Holds what the camera saw: recordings of spheres that fall and rebound, and the runs they give.
//!
//! | file | job |
//! |---|---|
//! | `track.rs` | holds where a sphere was, and how far its positions scatter |
//! | `parabola.rs` | fits a parabola through frames, and says what it shows |
//! | `segments.rs` | parts a track into flights, rests and what is neither |
//! | `contacts.rs` | finds the contacts with the plate |
//! | `gravity.rs` | estimates the one gravity of all flights |
//! | `air.rs` | computes what the air takes from a falling sphere |
//! | `impact.rs` | computes the speeds of an impact with their errors |
//! | `flights.rs` | fits the flights of one recording |
//! | `frames/` | finds the sphere in frames |
//! | `list.rs` | reads the list of recordings |
//! | `positions.rs` | reads a table of positions |
//! | `campaign.rs` | goes from recordings to runs, with a scale and a verdict each |
//! | `write.rs` | writes the runs |

mod air;
mod campaign;
mod contacts;
mod flights;
pub mod frames;
mod gravity;
mod impact;
mod list;
mod parabola;
mod positions;
mod segments;
mod track;
mod write;

pub use air::SphereInAir;
pub use campaign::{FreeFlight, GravityCheck, ImageScale, Impact, Outcome, Refusal, ScaleSource, Tracked};
pub use contacts::NoContact;
pub use gravity::{Gravity, FAR, GRAVITY, OFF};
pub use impact::ContactSpeeds;
pub use list::{Axis, Recording};
pub use track::Track;
pub use write::runs_table;

use std::path::Path;

use campaign::Shown;
use frames::{find_sphere, Sightings};

use crate::error::{Error, Problem};
use crate::notice::Notice;

/// Recordings with what they gave.
#[derive(Debug)]
pub struct Campaign {
    /// in the order of the list
    pub outcomes: Vec<Outcome>,
    /// what falls, and how fast
    pub gravity: GravityCheck,
    /// what wants a second look
    pub notices: Vec<Notice>,
}

/// What is asked of a list of recordings.
#[derive(Debug, Clone, Copy, Default)]
pub struct TrackOptions {
    /// where heights of tables point that do not say so
    pub axis: Option<Axis>,
    /// whether every rebound gives a run, not the first alone
    pub all_rebounds: bool,
}

/// Reads a list of recordings and tracks each; `progress` is told what share of the work is done.
///
/// Fails with every recording that cannot be read, and every one in which nothing falls, named by its line in the list.
pub fn track(list: &Path, options: TrackOptions, progress: &(dyn Fn(f64) + Sync)) -> Result<Campaign, Error> {
    let (recordings, notices) = list::read(list)?;
    let mut shown = vec![];
    let mut problems = vec![];
    let count = recordings.len() as f64;
    for (before, recording) in recordings.iter().enumerate() {
        if recording.exclude.is_some() {
            shown.push(None);
            continue;
        }
        let share = |of: f64| progress((before as f64 + of) / count);
        match show(recording, options.axis, &share) {
            Ok(of) => shown.push(Some(of)),
            Err(reason) => {
                shown.push(None);
                problems.push(problem(recording, reason));
            }
        }
    }
    if !problems.is_empty() {
        return Err(Error::input(list, problems));
    }
    let (outcomes, gravity) = campaign::analyse(recordings, shown, options.all_rebounds);
    let refused = outcomes
        .iter()
        .filter_map(|outcome| Some((&outcome.recording, outcome.tracked.as_ref().err()?)));
    let problems: Vec<Problem> = refused
        .filter(|(_, refusal)| refusal.is_no_fall())
        .map(|(recording, refusal)| {
            problem(
                recording,
                format!("{}; a reason in `exclude` leaves it out", refusal.words()),
            )
        })
        .collect();
    if !problems.is_empty() {
        return Err(Error::input(list, problems));
    }
    Ok(Campaign {
        outcomes,
        gravity,
        notices,
    })
}

fn problem(recording: &Recording, expected: String) -> Problem {
    Problem {
        line: Some(recording.line),
        place: recording.run.clone(),
        found: None,
        expected,
    }
}

/// What a recording shows, or why it cannot be read.
fn show(recording: &Recording, axis: Option<Axis>, progress: &(dyn Fn(f64) + Sync)) -> Result<Shown, String> {
    if positions::is_table(&recording.file) {
        let positions = positions::read(recording, axis).map_err(|error| error.to_string())?;
        return Ok(Shown {
            track: positions.track,
            in_pixels: positions.in_pixels,
            diameter: None,
        });
    }
    let rate = recording.frame_rate.ok_or("frames need a frame_rate_Hz")?;
    let found = find_sphere(&recording.file, &|done, of| progress(done as f64 / of as f64))?;
    Ok(shown_by_frames(&found, rate))
}

/// What frames of a rate show; those in which the sphere is a streak have no position.
fn shown_by_frames(found: &Sightings, rate: f64) -> Shown {
    /// of the radius, that it may be blurred by
    const STREAK: f64 = 0.5;
    /// what a radius errs by in pixels, by the tests of `frames/`
    const RADIUS_SD: f64 = 0.1;
    let sharp = found.seen.iter().filter(|of| of.blur_px < STREAK * found.radius_px);
    Shown {
        track: Track {
            times: sharp.clone().map(|of| of.frame as f64 / rate).collect(),
            // rows are counted downwards
            heights: sharp.map(|of| -of.y_px).collect(),
        },
        in_pixels: true,
        diameter: Some([2.0 * found.radius_px, 2.0 * RADIUS_SD]),
    }
}

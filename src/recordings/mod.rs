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
//! | `header.rs` | matches the header of a table with its columns |
//! | `list.rs` | reads the list of recordings |
//! | `positions.rs` | reads a table of positions |
//! | `campaign.rs` | goes from recordings to runs, with a scale and a verdict each |
//! | `write.rs` | writes the runs |

mod air;
mod campaign;
mod contacts;
mod flights;
mod gravity;
mod header;
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

/// Reads a list of recordings and tracks each; `progress` is told how many are done.
///
/// Fails with every recording that cannot be read, and every one in which nothing falls, named by its line in the list.
pub fn track(list: &Path, options: TrackOptions, progress: &dyn Fn(usize)) -> Result<Campaign, Error> {
    let (recordings, notices) = list::read(list)?;
    let mut shown = vec![];
    let mut problems = vec![];
    for (done, recording) in recordings.iter().enumerate() {
        progress(done);
        if recording.exclude.is_some() {
            shown.push(None);
            continue;
        }
        match show(recording, options.axis) {
            Ok(of) => shown.push(Some(of)),
            Err(error) => {
                shown.push(None);
                problems.push(problem(recording, error.to_string()));
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

/// What a recording shows.
fn show(recording: &Recording, axis: Option<Axis>) -> Result<Shown, Error> {
    let positions = positions::read(recording, axis)?;
    Ok(Shown {
        track: positions.track,
        in_pixels: positions.in_pixels,
        diameter: None,
    })
}

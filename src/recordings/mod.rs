//! Holds what the camera saw: recordings of spheres that fall and rebound, and the runs they give.
//!
//! | file | job |
//! |---|---|
//! | `track.rs` | holds where a sphere was, and how far its positions scatter |
//! | `parabola.rs` | fits a parabola through frames, and says what it shows |
//! | `segments.rs` | parts a track into flights, rests and what is neither |
//! | `timing.rs` | finds frames that are missing or repeated |
//! | `contacts.rs` | finds the contacts with the plate |
//! | `gravity.rs` | estimates the one gravity of all flights |
//! | `air.rs` | computes what the air takes from a falling sphere |
//! | `impact.rs` | computes the speeds of an impact with their errors |
//! | `flights.rs` | fits the flights of one recording |
//! | `plates.rs` | compares the heights at which recordings meet the plate |
//! | `rounded_times.rs` | tells times rounded to few digits, and spaces them evenly |
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
mod plates;
mod positions;
mod rounded_times;
mod segments;
mod timing;
mod track;
mod write;

pub use air::SphereInAir;
pub use campaign::{
    FreeFlight, GravityCheck, ImageScale, Impact, Outcome, ScaleSource, Shown, Tracked, APART_FROM_OTHERS_SINCE,
    APART_SINCE,
};
pub use contacts::Refusal;
pub use gravity::{Gravity, FAR, GRAVITY, OFF};
pub use impact::ContactSpeeds;
pub use list::{Axis, Recording};
pub use timing::Jump;
pub use track::Track;
pub use write::runs_table;

use std::path::Path;

use frames::{find_sphere, Sightings};
use positions::Reading;

use crate::error::{and_more, file_name, quoted, Error, Problem};
use crate::remark::Remark;
use crate::rounding::significant;
use crate::units::milliseconds;

/// Recordings with what they gave.
#[derive(Debug)]
pub struct Campaign {
    /// in the order of the list
    pub outcomes: Vec<Outcome>,
    /// what falls, and how fast
    pub gravity: GravityCheck,
    /// what wants a second look
    pub notices: Vec<Remark>,
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
/// A recording that cannot be read, or in which nothing falls, carries the reason and stops no other. Fails where the list
/// cannot be used, and where none of its recordings can be read: with each of them, named by its line.
pub fn track(list: &Path, options: TrackOptions, progress: &(dyn Fn(f64) + Sync)) -> Result<Campaign, Error> {
    let (recordings, mut notices) = list::read(list)?;
    let count = recordings.len() as f64;
    let mut shown = vec![];
    for (before, recording) in recordings.iter().enumerate() {
        let share = |of: f64| progress((before as f64 + of) / count);
        shown.push(match &recording.exclude {
            Some(reason) => Err(Refusal::Excluded(reason.clone())),
            None => show(recording, options.axis, &share, &mut notices).map_err(Refusal::Unread),
        });
    }
    let mut unread = vec![];
    for (shown, recording) in shown.iter().zip(&recordings) {
        if let Err(Refusal::Unread(reason)) = shown {
            unread.push(Problem::new(&recording.run, reason).on(recording.line));
        }
    }
    if !unread.is_empty() && shown.iter().all(Result::is_err) {
        return Err(Error::input(list, unread));
    }
    let (outcomes, gravity) = campaign::analyse(recordings, shown, options.all_rebounds);
    Ok(Campaign {
        outcomes,
        gravity,
        notices,
    })
}

/// What a recording shows, or why it cannot be read.
fn show(
    recording: &Recording,
    axis: Option<Axis>,
    progress: &(dyn Fn(f64) + Sync),
    notices: &mut Vec<Remark>,
) -> Result<Shown, String> {
    if positions::is_table(&recording.file) {
        let Reading { shown, falling, spaced } = positions::read(recording, axis).map_err(on_one_line)?;
        if let (Some(step), Some(rate)) = (spaced, recording.frame_rate) {
            let Recording { line, run, .. } = recording;
            let step = significant(milliseconds(step), 1);
            let text = format!(
                "line {line}, {run}: its times are rounded to {step} ms; its frames are taken as {rate} a second"
            );
            let todo = "write times with more digits, or a column `frame` for them, if frames are missing";
            notices.push(Remark::new("times_rounded", 1, text, todo));
        }
        if falling > 1 {
            let Recording { line, run, .. } = recording;
            let taken = quoted(shown.object.as_deref().unwrap_or_default());
            let text =
                format!("line {line}, {run}: {falling} objects fall; object {taken} is taken, which falls farthest");
            let todo = "leave only the sphere in the table if it is another";
            notices.push(Remark::new("several_objects_fall", falling, text, todo));
        }
        return Ok(shown);
    }
    let rate = recording.frame_rate.ok_or("frames need a frame_rate_Hz")?;
    let found = find_sphere(&recording.file, &|done, of| progress(done as f64 / of as f64))?;
    Ok(shown_by_frames(&found, rate))
}

/// An error of one recording's file among those of the list, its problems one after the other.
fn on_one_line(error: Error) -> String {
    /// problems of one file that are told
    const TOLD: usize = 3;
    let Error::Input { file, problems, count } = error else {
        return error.to_string();
    };
    let told = problems.iter().take(TOLD).map(ToString::to_string).collect();
    format!("{}: {}", file_name(&file), and_more(told, count, "; "))
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
        frames: found.frames,
        counted_from: Some(1),
        object: None,
    }
}

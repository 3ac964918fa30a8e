//! Finds frames that are missing or repeated by the jumps of a flight, and gives each position its time.
//!
//! Where frames are missing or repeated, all later ones come too early or too late by whole frames. A flight is then seen as
//! two, of which one lies on the other once it is moved in time by so many frames. A recording whose other jumps are no whole
//! frames is left as it is: its flights then do not meet.

use super::parabola::Kind;
use super::segments::{parted, Beside, Segment};
use super::track::Track;

/// A jump in the times of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// when the first frame after it was seen by the recording's own count, in s
    pub time: f64,
    /// how many frames are missing before that one; below 0 so many are repeated
    pub missing: i32,
}

/// Most jumps that are looked for: a recording with more has no frame rate.
const MOST_JUMPS: usize = 100;

/// Most frames of one jump.
const MOST_FRAMES: f64 = 10.0;

/// Standard deviations of a position that the sphere must move by in a frame, where one is to be missed.
const LEAST_MOVE: f64 = 6.0;

/// The track with its frames in their own time and the repeated ones left out, and the jumps in order of time.
pub(super) fn on_time(mut track: Track, sigma: f64) -> (Track, Vec<Jump>) {
    let frame_time = track.frame_time();
    let mut counted = track.times.clone();
    let mut jumps = vec![];
    while jumps.len() < MOST_JUMPS {
        let Some((last, missing)) = next_jump(&track, sigma) else {
            break;
        };
        let repeated = usize::try_from(-missing).unwrap_or(0);
        let after = (last + 1 + repeated).min(track.times.len());
        jumps.push(Jump {
            time: counted.get(last + 1).copied().unwrap_or_default(),
            missing,
        });
        for time in &mut track.times[after..] {
            *time += f64::from(missing) * frame_time;
        }
        for numbers in [&mut track.times, &mut track.heights, &mut counted] {
            numbers.drain(last + 1..after);
        }
    }
    jumps.sort_by(|a, b| a.time.total_cmp(&b.time));
    (track, jumps)
}

/// The last position before a jump, and how many frames are missing after it.
fn next_jump(track: &Track, sigma: f64) -> Option<(usize, i32)> {
    let (beside, segments) = parted(track, sigma);
    let beside = beside?;
    segments.windows(2).find_map(|pair| {
        let [a, b] = pair else { return None };
        let missing = missing_between(&beside, a, b)?;
        Some((*a.frames.last()?, missing))
    })
}

/// How many frames are missing between two parts of one flight; `None` where they are no such parts.
fn missing_between(beside: &Beside, a: &Segment, b: &Segment) -> Option<i32> {
    if a.kind == Kind::Rest || b.kind == Kind::Rest {
        return None;
    }
    let frame_time = beside.track.frame_time();
    let middle = 0.5 * (a.parabola.ends[1] + b.parabola.ends[0]);
    let velocity = 0.5 * (a.parabola.velocity(middle) + b.parabola.velocity(middle));
    // near the top of a flight a frame moves the sphere by less than is seen
    let moves = velocity.abs() * frame_time;
    if moves < LEAST_MOVE * beside.sigma {
        return None;
    }
    // a parabola passes a height difference at the mean of the velocities at its ends
    let missing = ((b.parabola.height(middle) - a.parabola.height(middle)) / (velocity * frame_time)).round();
    if missing == 0.0 || missing.is_nan() || missing.abs() > MOST_FRAMES {
        return None;
    }
    let mut moved = beside.track.clone();
    let first = *b.frames.first()?;
    for time in &mut moved.times[first..] {
        *time += missing * frame_time;
    }
    let beside = Beside {
        track: &moved,
        ..*beside
    };
    let later = beside.segment(b.frames.clone())?;
    let whole = beside.as_one(a, &later)?;
    // what is no parabola to a pixel may jump by as much as it is off
    let is_sure = beside.fits_as_well(&whole, a, &later) || moves > 2.0 * beside.step();
    (whole.kind == Kind::Flight && is_sure).then_some(missing as i32)
}

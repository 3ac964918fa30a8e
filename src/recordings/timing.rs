//! Finds frames that are missing or repeated by the jumps of a flight, and gives each position its time.
//!
//! Where frames are missing or repeated, all later ones come too early or too late by whole frames. A flight is then seen as
//! two, of which one lies on the other once it is moved in time by so many frames. A recording whose other jumps are no whole
//! frames is left as it is: its flights then do not meet.
//!
//! Beside a contact a repeated frame is seen by two equal positions, one of them off its flight.
//!
//! Where faults are frequent no flight is seen between them, and the scatter of positions is that of the faults. So each move
//! from a frame to the next is compared with its neighbours first.

use super::parabola::{Kind, Parabola};
use super::segments::{parted, Beside, Segment};
use super::track::Track;
use crate::distributions::{median, SD_OF_MEDIAN_DISTANCE};

/// A jump in the times of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// when the first frame after it was seen by the recording's own count, in s
    pub time: f64,
    /// how many frames are missing before that one; below 0 so many are repeated
    pub missing: i32,
}

/// Share of frames that may be repeated or missing: of more, nobody knows which rate the others have.
pub(super) const MOST_UNEVEN: f64 = 0.08;

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
    let pairs = || segments.windows(2);
    let in_flight = pairs().find_map(|pair| {
        let [a, b] = pair else { return None };
        let missing = missing_between(&beside, a, b)?;
        Some((*a.frames.last()?, missing))
    });
    let at_contact = || pairs().find_map(|pair| Some((repeated_at_contact(&beside, &pair[0], &pair[1])?, -1)));
    in_flight.or_else(at_contact)
}

/// The first of two positions that are one frame, beside the contact between two flights; `None` where there are none.
///
/// They are equal to the last digit, and one of them is on its flight while the other is not. Two frames as high before and
/// after a contact are each on their own, and those of a sphere that dwells on the plate are on neither.
fn repeated_at_contact(beside: &Beside, a: &Segment, b: &Segment) -> Option<usize> {
    /// standard deviations of a position by which one is on a flight, and by which it is surely not
    const ON: f64 = 5.0;
    const OFF: f64 = 10.0;
    let meets = a.parabola.velocity(a.parabola.ends[1]) < 0.0 && b.parabola.velocity(b.parabola.ends[0]) > 0.0;
    if !meets || [a, b].iter().any(|part| part.kind != Kind::Flight) {
        return None;
    }
    let Track { times, heights } = beside.track;
    let off =
        |of: &Parabola, at: usize| (heights[at] - of.height(times[at])).abs() / of.position_sd(times[at], beside.sigma);
    let is_one = |first: &usize| {
        let offs = [off(&a.parabola, *first), off(&b.parabola, first + 1)];
        let is_on_one = offs.iter().any(|off| *off < ON) && offs.iter().any(|off| *off > OFF);
        heights[*first] == heights[first + 1] && is_on_one
    };
    (*a.frames.last()?..*b.frames.first()?).find(is_one)
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

/// A move from a frame to the next beside the moves about it.
struct Move {
    /// by those about it
    expected: f64,
    /// frame times that it took: 0 of a repeated frame, 2 past one that is missing
    frames: f64,
    /// distance from what so many frame times make
    off: f64,
}

/// Share of the frames that are repeated or follow a missing one, in the flights; `None` where the moves are too few, or
/// too small for the scatter of positions, to tell.
pub(super) fn uneven_share(track: &Track) -> Option<f64> {
    /// moves that tell a share
    const ENOUGH: usize = 8;
    /// faults that are no chance
    const LEAST_FAULTS: usize = 4;
    /// times the scatter of moves, beyond which one tells a fault
    const SURE: f64 = 12.0;
    /// of the moves of a sphere that does not rest, those like their neighbours: fewer are alike by chance
    const LEAST_ALIKE: f64 = 0.15;
    let frame_time = track.frame_time();
    let gaps = track.times.windows(2).map(|pair| (pair[1] - pair[0]) / frame_time);
    let gaps: Vec<f64> = gaps.collect();
    let steps = track.heights.windows(2).map(|pair| pair[1] - pair[0]);
    let moves: Vec<f64> = steps.zip(&gaps).map(|(step, gap)| step / gap).collect();
    let least = track.least_move();
    let is_fast = |of: &Move| 3.0 * of.expected.abs() > least;
    let alone = (0..moves.len()).filter(|at| gaps[*at].round() == 1.0);
    let compared: Vec<Move> = alone.filter_map(|at| compared(&moves, at)).filter(is_fast).collect();
    let scatter = SD_OF_MEDIAN_DISTANCE * median(&mut compared.iter().map(|of| of.off).collect::<Vec<_>>())?;
    let scatter = scatter.max(track.rounding());
    let sure = compared.iter().filter(|of| of.expected.abs() > SURE * scatter);
    let told = sure.clone().count();
    let faults = sure.filter(|of| of.frames != 1.0).count();
    let share = faults as f64 / told as f64;
    let fast = moves.iter().filter(|step| 3.0 * step.abs() > least).count();
    let is_told = told >= ENOUGH && compared.len() as f64 > LEAST_ALIKE * fast as f64;
    // a few faults among few moves say neither
    (is_told && (faults >= LEAST_FAULTS || share <= MOST_UNEVEN)).then_some(share)
}

/// A move beside those about it; `None` near a contact, or near the top of a flight.
///
/// In a flight the mean of two moves is the one in their middle, however it is accelerated.
fn compared(moves: &[f64], at: usize) -> Option<Move> {
    /// moves to each side
    const ABOUT: usize = 3;
    /// of their sum, by which two moves of one flight differ at most, one of them past a missing frame
    const APART: f64 = 0.4;
    /// of the nearest mean, by which another differs at most
    const UNLIKE: f64 = 0.5;
    /// frame times by which a move is off a whole number at most
    const OFF: f64 = 0.3;
    let mean = |far: usize| {
        let (before, after) = (moves[at.checked_sub(far)?], moves.get(at + far)?);
        let is_alike = (before - after).abs() <= APART * (before + after).abs();
        is_alike.then_some(0.5 * (before + after))
    };
    let nearest = mean(1)?;
    let is_like = |mean: &f64| (mean - nearest).abs() <= UNLIKE * nearest.abs();
    let mut means: Vec<f64> = (1..=ABOUT).filter_map(mean).filter(is_like).collect();
    if means.len() < 2 {
        return None;
    }
    means.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let expected = means[means.len() / 2];
    let took = moves[at] / expected;
    let is_about = |frames: &f64| (took - frames).abs() < OFF;
    let frames = [0.0, 2.0].into_iter().find(is_about).unwrap_or(1.0);
    let off = means.iter().map(|mean| (moves[at] - frames * mean).abs());
    Some(Move {
        expected,
        frames,
        off: off.fold(f64::INFINITY, f64::min),
    })
}

//! Tells times that a program rounded to few digits, and spaces their frames evenly by the frame rate.

use super::track::Track;

/// Times at an even distance.
pub(super) struct EvenTimes {
    /// in s, a frame each
    pub times: Vec<f64>,
    /// what they were rounded to, in s
    pub step: f64,
}

/// Of a step or a frame time: what f64 leaves of decimal numbers.
const EXACT: f64 = 1e-6;

/// Of the frame time: finer steps do no harm.
const FINE: f64 = 0.02;

/// The power of ten in s that all times are multiples of, where they are rounded to it; `None` where they are of more digits
/// than a camera needs.
pub(super) fn rounded_to(times: &[f64]) -> Option<f64> {
    /// powers of ten: to 0.1 µs
    const MOST_DIGITS: i32 = 7;
    let is_multiple = |step: f64| times.iter().all(|t| (t / step - (t / step).round()).abs() < EXACT);
    let steps = (0..=MOST_DIGITS).map(|digits| 10f64.powi(-digits));
    steps.into_iter().find(|step| is_multiple(*step))
}

/// Whether frame times are rounded by so much that flights are no parabolas: gaps differ, and by one step at most.
pub(super) fn are_rounded(track: &Track) -> bool {
    /// of the frame time, that a step which is no frame has at most
    const LESS: f64 = 0.9;
    let frame_time = track.frame_time();
    let Some(step) = rounded_to(&track.times).filter(|step| *step > FINE * frame_time) else {
        return false;
    };
    // frames that are missing are so for whole frames, not for a step
    let gaps = track
        .times
        .windows(2)
        .map(|pair| ((pair[1] - pair[0] - frame_time) / step).round());
    let by_a_step = gaps.filter(|off| off.abs() == 1.0).count();
    step < LESS * frame_time && by_a_step > 1
}

/// Times of frames of a rate which these are, each rounded; `None` where they are not, or are not rounded.
pub(super) fn spaced_evenly(times: &[f64], rate: f64) -> Option<EvenTimes> {
    /// of the frame time: coarser ones do not tell which frame is missing
    const COARSE: f64 = 0.6;
    let first = *times.first()?;
    let step = rounded_to(times).filter(|step| (FINE..COARSE).contains(&(step * rate)))?;
    let from = |start: f64| times.iter().map(move |t| start + ((t - start) * rate).round() / rate);
    // the first is rounded as they all are: nearer is the mean of all
    let late = times.iter().zip(from(first)).map(|(t, even)| t - even).sum::<f64>() / times.len() as f64;
    let even: Vec<f64> = from(first + late).collect();
    let off = times.iter().zip(&even).map(|(t, even)| t - even);
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [least, most] = off.fold(ends, |[least, most], off| [least.min(off), most.max(off)]);
    let is_rising = even.windows(2).all(|pair| pair[0] < pair[1]);
    let is_by_rounding = most - least <= (1.0 + EXACT) * step && most - least > EXACT / rate;
    (is_rising && is_by_rounding).then_some(EvenTimes { times: even, step })
}

/// Whether many frames one after the other have one time since it was rounded, and not since two things are seen in each:
/// positions that leap from one thing to the other are nearer to the next but one.
pub(super) fn many_are_one(times: &[f64], heights: &[f64]) -> bool {
    let equal = times.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let path = |by: usize| {
        heights
            .iter()
            .zip(&heights[by.min(heights.len())..])
            .map(|(a, b)| (b - a).abs())
            .sum::<f64>()
    };
    10 * equal > times.len() && path(2) > 1.5 * path(1)
}

//! Parts a track into flights, rests and what is neither, with frames that belong to none.
//!
//! The parts are those that together have the least Σ (residuals of a parabola)²/σ² + a price for each part + a price for
//! each frame left out (optimal partitioning; Jackson et al., IEEE Signal Process. Lett. 12, 105 (2005), with the pruning of
//! Killick et al., J. Am. Stat. Assoc. 107, 1590 (2012)). No gravity and no scale is assumed: whether they are right is asked
//! of the flights later.

use super::parabola::{Kind, Moments, Parabola, LEAST_FRAMES};
use super::track::Track;

/// Frames one after the other, of which those that were left out are not listed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Segment {
    /// places in the track, rising
    pub frames: Vec<usize>,
    pub kind: Kind,
    /// through its frames
    pub parabola: Parabola,
}

/// What a frame that belongs to no part costs, in squares of σ.
const OUTLIER: f64 = 16.0;

/// Frames, or blocks of them, that are parted at once; longer tracks are parted in blocks.
const MOST_PLACES: usize = 2_000;

/// The segments of a track whose positions scatter by σ, in their order.
pub(super) fn segments(track: &Track, sigma: f64) -> Vec<Segment> {
    let (beside, mut found) = parted(track, sigma);
    if let Some(beside) = beside {
        beside.join(&mut found);
    }
    found
}

/// The same before any are joined, with what they are compared with; nothing where nothing falls.
pub(super) fn parted(track: &Track, sigma: f64) -> (Option<Beside<'_>>, Vec<Segment>) {
    let block = track.times.len().div_ceil(MOST_PLACES).max(1);
    let parts = parts(&in_blocks(track, block), sigma / (block as f64).sqrt());
    let frames_of = |place: usize| place * block..((place + 1) * block).min(track.times.len());
    let frames = parts
        .into_iter()
        .map(|part| part.into_iter().flat_map(frames_of).collect::<Vec<usize>>());
    let parabolas = frames.filter_map(|frames| Some((Parabola::through(&track.points(&frames))?, frames)));
    let parabolas: Vec<(Parabola, Vec<usize>)> = parabolas.collect();
    // what bends downwards most is a fall: a long rest that drifts bends a little, and surely
    let falls = parabolas.iter().filter(|(parabola, _)| parabola.bends_downwards(sigma));
    let surest = falls.max_by(|(a, _), (b, _)| b.bend().total_cmp(&a.bend()));
    let fall = surest.map(|(fall, _)| *fall);
    let [lowest, highest] = track.ends_within(parabolas.iter().flat_map(|(_, frames)| frames));
    let found = parabolas.into_iter().map(|(parabola, frames)| Segment {
        kind: fall.map_or(Kind::Other, |fall| parabola.kind_beside(&fall, sigma)),
        frames,
        parabola,
    });
    let found = found.collect();
    let beside = fall.map(|fall| Beside {
        track,
        fall,
        sigma,
        range: highest - lowest,
    });
    (beside, found)
}

/// Means of so many frames each.
fn in_blocks(track: &Track, block: usize) -> Track {
    let mean = |numbers: &[f64]| numbers.iter().sum::<f64>() / numbers.len() as f64;
    Track {
        times: track.times.chunks(block).map(mean).collect(),
        heights: track.heights.chunks(block).map(mean).collect(),
    }
}

/// Places of the track, part by part; fewer than [`LEAST_FRAMES`] are no part.
fn parts(track: &Track, sigma: f64) -> Vec<Vec<usize>> {
    let places = track.times.len();
    let price = 10.0 + 3.0 * (places.max(1) as f64).ln();
    let unit = track.frame_time().max(f64::MIN_POSITIVE);
    // the least cost of the places before each, and where its last part begins; none where the last place was left out
    let mut least = vec![0.0; places + 1];
    let mut begins: Vec<Option<usize>> = vec![None; places + 1];
    let mut open: Vec<(usize, Moments)> = vec![];
    for place in 0..places {
        open.push((place, Moments::new(track.times[place], track.heights[place], unit)));
        let mut best = (least[place] + OUTLIER, None);
        for (start, moments) in &mut open {
            moments.add(track.times[place], track.heights[place]);
            if place + 1 - *start < LEAST_FRAMES {
                continue;
            }
            let cost = least[*start] + moments.squares() / (sigma * sigma);
            if cost + price < best.0 {
                best = (cost + price, Some(*start));
            }
        }
        (least[place + 1], begins[place + 1]) = best;
        // what costs more without a new part costs more with all that may come
        open.retain(|(start, moments)| {
            place + 1 - *start < LEAST_FRAMES || least[*start] + moments.squares() / (sigma * sigma) <= best.0
        });
    }
    let mut parts = vec![];
    let mut end = places;
    while end > 0 {
        match begins[end] {
            Some(start) => {
                parts.push((start..end).collect());
                end = start;
            }
            None => end -= 1,
        }
    }
    parts.reverse();
    parts
}

/// What segments of a track are compared with.
#[derive(Clone, Copy)]
pub(super) struct Beside<'t> {
    pub track: &'t Track,
    /// the fall that is seen best
    pub fall: Parabola,
    pub sigma: f64,
    /// of the heights of its parts
    pub range: f64,
}

impl Beside<'_> {
    /// How far the heights of two parts of one flight may be apart: by positions that scatter, and by a share of the heights
    /// that are seen, since the drag of the air, or a lens, makes a fall no parabola to a pixel.
    pub fn step(&self) -> f64 {
        const SDS: f64 = 5.0;
        const SHARE: f64 = 0.002;
        SDS * self.sigma + SHARE * self.range
    }

    /// `None` of no frames.
    pub fn segment(&self, frames: Vec<usize>) -> Option<Segment> {
        let parabola = Parabola::through(&self.track.points(&frames))?;
        Some(Segment {
            frames,
            kind: parabola.kind_beside(&self.fall, self.sigma),
            parabola,
        })
    }

    /// Joins what is one flight or one rest: with frames of something else between them, or parted by a price that a slight
    /// misfit of long flights exceeds.
    fn join(&self, segments: &mut Vec<Segment>) {
        let mut place = 0;
        'next: while place < segments.len() {
            // the nearest first, then over a few that are something else
            for other in place + 1..(place + 4).min(segments.len()) {
                if let Some(both) = self.as_one(&segments[place], &segments[other]) {
                    segments[place] = both;
                    segments.drain(place + 1..=other);
                    place = place.saturating_sub(1);
                    continue 'next;
                }
            }
            place += 1;
        }
    }

    /// Whether the whole of two segments fits as well as they do.
    pub fn fits_as_well(&self, both: &Segment, a: &Segment, b: &Segment) -> bool {
        /// squares of σ by which the whole may fit worse than its parts
        const WORSE: f64 = 30.0;
        let worse = both.parabola.squares - a.parabola.squares - b.parabola.squares;
        worse < WORSE * self.sigma * self.sigma
    }

    /// Both as one, where they are. Only a contact parts flights, and there the velocity jumps.
    pub fn as_one(&self, a: &Segment, b: &Segment) -> Option<Segment> {
        /// of the fastest speed: less is no contact
        const JUMP: f64 = 0.05;
        let both = self.segment(a.frames.iter().chain(&b.frames).copied().collect())?;
        if self.fits_as_well(&both, a, b) {
            return Some(both);
        }
        let middle = 0.5 * (a.parabola.ends[1] + b.parabola.ends[0]);
        let jump = b.parabola.velocity(middle) - a.parabola.velocity(middle);
        let step = b.parabola.height(middle) - a.parabola.height(middle);
        let smooth = jump.abs() < JUMP * self.fall.fastest() && step.abs() < self.step();
        let same = a.kind == b.kind && both.kind == a.kind && a.kind != Kind::Other;
        (smooth && same).then_some(both)
    }
}

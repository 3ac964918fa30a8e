//! Finds the contacts of a sphere with the plate among the segments of its track.

use super::parabola::{Kind, LEAST_FRAMES};
use super::segments::Segment;
use super::track::Track;

/// A sphere that came down, and what became of it; places among the segments of its track.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Contact {
    /// the flight that ends in it
    pub before: usize,
    pub after: After,
}

/// What follows a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum After {
    /// it rebounded
    Flight(usize),
    /// it stayed
    Rest(usize),
}

impl Contact {
    /// The flight after it; `None` where the sphere stayed.
    pub fn rebound(self) -> Option<usize> {
        match self.after {
            After::Flight(after) => Some(after),
            After::Rest(_) => None,
        }
    }
}

/// Why a recording gives no run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Refusal {
    /// the list leaves it out, for this reason
    Excluded(String),
    /// it cannot be read, for this reason
    Unread(String),
    /// there is no flight in it
    NeverFalls,
    /// positions bend upwards wherever they bend: their axis points the other way
    FallsUpwards,
    /// what frames show is accelerated upwards
    BendsUpwards,
    /// the first that is seen is a sphere that rises
    BeginsRising,
    /// too few frames of the fall are seen before the sphere rises
    ShortFall,
    /// what comes before the first flight, which rises, is no fall
    NoFall,
    /// a flight is followed by another that goes on falling
    Torn,
    /// too many frames are repeated or missing
    Uneven,
    /// times are rounded to few digits
    RoundedTimes,
    /// it ends before the sphere has come down, or just after
    EndsBefore,
    /// what follows is neither a flight of enough frames nor a sphere at rest
    Unclear,
}

/// The contacts of a track whose positions scatter by σ, the first one alone unless `all` are asked for.
pub(super) fn contacts(
    track: &Track,
    segments: &[Segment],
    (sigma, all): (f64, bool),
) -> Result<Vec<Contact>, Refusal> {
    let flights: Vec<usize> = (0..segments.len())
        .filter(|place| segments[*place].kind == Kind::Flight)
        .collect();
    let frames = |places: &[usize]| places.iter().map(|place| segments[*place].frames.len()).sum::<usize>();
    let upwards: Vec<usize> = (0..segments.len())
        .filter(|place| segments[*place].kind == Kind::Other && segments[*place].parabola.bends_upwards(sigma))
        .collect();
    if frames(&upwards) > frames(&flights) {
        return Err(Refusal::FallsUpwards);
    }
    let first = flights.first().ok_or(Refusal::NeverFalls)?;
    // a sphere that was let go just now, so many frames ago, may seem to rise a little
    const LET_GO: f64 = 0.1;
    const SOON: f64 = 10.0;
    let parabola = &segments[*first].parabola;
    let [start, end] = parabola.ends.map(|t| parabola.velocity(t));
    let rises = start > LET_GO * end.abs();
    let is_soon = |rest: &Segment| parabola.ends[0] - rest.parabola.ends[1] <= SOON * track.frame_time();
    let mut before = segments[..*first].iter();
    let held_before = before.any(|segment| segment.kind == Kind::Rest && is_soon(segment));
    if rises && !held_before && !all {
        let before = segments[*first]
            .frames
            .first()
            .map_or(&[][..], |place| &track.heights[..*place]);
        let falls = matches!(before, [top, .., last] if top > last);
        return Err(match before.len() {
            _ if !falls => Refusal::BeginsRising,
            0..=LEAST_FRAMES => Refusal::ShortFall,
            _ => Refusal::NoFall,
        });
    }
    let mut found = vec![];
    let mut why = Refusal::EndsBefore;
    for (place, before) in flights.iter().enumerate() {
        let next = flights.get(place + 1).copied();
        match after(segments, *before, next) {
            Ok(after) => found.push(Contact { before: *before, after }),
            Err(reason) => why = reason,
        }
        if !all {
            break;
        }
    }
    if found.is_empty() {
        return Err(why);
    }
    Ok(found)
}

/// What follows a flight.
fn after(segments: &[Segment], before: usize, next: Option<usize>) -> Result<After, Refusal> {
    let falling = &segments[before].parabola;
    let end = falling.ends[1];
    if falling.velocity(end) >= 0.0 {
        return Err(Refusal::Unclear);
    }
    let rest = (before + 1..segments.len()).find(|place| segments[*place].kind == Kind::Rest);
    let rebound = next.filter(|next| rest.is_none_or(|rest| *next < rest));
    if let Some(next) = rebound {
        let rising = &segments[next].parabola;
        let start = rising.ends[0];
        let middle = 0.5 * (start + end);
        let jump = rising.velocity(middle) - falling.velocity(middle);
        return if rising.velocity(start) > 0.0 && jump > 0.0 {
            Ok(After::Flight(next))
        } else if rising.velocity(start) < 0.0 {
            Err(Refusal::Torn)
        } else {
            Err(Refusal::Unclear)
        };
    }
    match rest {
        Some(rest) => Ok(After::Rest(rest)),
        None if before + 1 < segments.len() => Err(Refusal::Unclear),
        None => Err(Refusal::EndsBefore),
    }
}

impl Refusal {
    /// As a reason in a table says it.
    pub fn words(&self) -> &str {
        match self {
            Refusal::Excluded(reason) | Refusal::Unread(reason) => reason,
            Refusal::NeverFalls => "nothing falls in it",
            Refusal::FallsUpwards => "it falls upwards: y_axis is the other one",
            Refusal::BendsUpwards => "what moves in its frames is accelerated upwards: the ground must be below",
            Refusal::ShortFall => "fewer than five frames of the fall are seen before the sphere rises",
            Refusal::Torn => "its flight is torn in two, and not by whole frames: the times of its frames are uneven, or the air \
                                bends the flight of a light sphere",
            Refusal::Uneven => "more than one frame in twelve is repeated or missing: its frame rate is not known",
            Refusal::RoundedTimes => {
                "its times are rounded to too few digits: a column `frame` instead of them, or frame_rate_Hz as it was, tells when \
                 each frame was taken"
            }
            Refusal::NoFall => {
                "it begins with a rise, and the frames before it show no free fall: they scatter too much, or some are repeated or \
                 missing"
            }
            Refusal::BeginsRising => "it begins with a sphere that rises, after a first impact that was not seen",
            Refusal::EndsBefore => "it ends before the sphere has rebounded",
            Refusal::Unclear => "what follows the impact is neither a flight of five frames nor a sphere at rest",
        }
    }

    /// Whether it cannot be read, or nothing falls in it, so that it cannot be what was meant.
    pub fn is_mistake(&self) -> bool {
        use Refusal::{BendsUpwards, FallsUpwards, NeverFalls, Unread};
        matches!(self, Unread(_) | NeverFalls | FallsUpwards | BendsUpwards)
    }
}

//! Goes from recordings to runs: one gravity for all of them, a scale each, a verdict each.

use serde::Serialize;

use super::contacts::{Contact, Refusal};
use super::flights::{Flights, SURE};
use super::gravity::{is_off, shared, Gravity, GRAVITY};
use super::impact::{ContactSpeeds, Level};
use super::list::Recording;
use super::plates::{alone, PlateHeight};
use super::rounded_times::are_rounded;
use super::timing::Jump;
use super::track::Track;
use crate::rounding::significant;
use crate::runs::LARGEST_RESTITUTION;
use crate::units::{millimetres, milliseconds, pixels_per_millimetre, MAGNITUDES};

/// Relative change of v_r by a contact that lies apart which is told.
const APART_COUNTS: f64 = 0.005;

/// What lets two flights meet at another height than others.
pub const APART_SINCE: &str =
    "frames are missing at one of these contacts, the plate is not level in the picture, or a \
                               mark on a spinning sphere was tracked";

/// What lets a recording meet the plate at another height than the others do.
pub const APART_FROM_OTHERS_SINCE: &str =
    "a frame is missing or repeated at its contact, or the plate or the camera was moved";

/// Rounds in which flights, contacts and gravity follow each other; each brings them nearer by orders of magnitude.
const ROUNDS: usize = 4;

/// What a recording shows, before any scale of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// heights as they were seen
    pub track: Track,
    /// whether its heights are pixels, not metres
    pub in_pixels: bool,
    /// diameter of the sphere in pixels with its standard error, where it was seen
    pub diameter: Option<[f64; 2]>,
    /// how many frames there are, with and without the sphere; of a table its positions
    pub frames: usize,
    /// the number of the first frame; `None` of positions whose table has times alone
    pub counted_from: Option<u32>,
    /// the object that was taken, where a table has several
    pub object: Option<String>,
}

/// Where the scale of a recording comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum ScaleSource {
    /// heights are lengths already
    Lengths,
    /// the list of recordings
    Stated,
    /// the sphere's diameter in its frames
    Diameter,
    /// the acceleration of what falls
    Gravity,
}

impl ScaleSource {
    /// Those that gravity is held against.
    const MEASURED: [ScaleSource; 3] = [ScaleSource::Lengths, ScaleSource::Stated, ScaleSource::Diameter];
}

/// Pixels per metre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ImageScale {
    /// what was used; 1 of lengths
    pub value: f64,
    /// where it comes from
    pub source: ScaleSource,
    /// by the sphere's diameter, with its standard error
    pub by_diameter: Option<[f64; 2]>,
}

/// An impact of a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Impact {
    /// both speeds at the plate, in m/s; the height there in m
    pub speeds: ContactSpeeds,
    /// whether the sphere stayed
    pub stuck: bool,
    /// v and v_r at the film's surface; of a dry plate at the plate
    pub at_film: [f64; 2],
    /// height difference in m to the nearest of the recording's other contacts and the sphere at rest, where film and errors do
    /// not explain it and it matters; included in the standard deviations of the speeds, as a smaller one is
    pub apart: Option<f64>,
    /// height difference in m to the other recordings' contacts, where those agree, this one alone differs and it matters;
    /// included in the standard deviations likewise
    pub apart_from_others: Option<f64>,
    /// why the run is left out, where it is
    pub verdict: Option<String>,
}

/// A free flight of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeFlight {
    /// places of its frames in the track
    pub frames: Vec<usize>,
    /// heights less the parabola and what the air moved, in m, a frame each
    pub residuals: Vec<f64>,
    /// its own gravity with the standard error, in m/s²
    pub own_gravity: [f64; 2],
    /// the parabola: an instant, height over the contact and velocity then, and the gravity
    pub parabola: [f64; 4],
}

/// What a recording gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracked {
    /// heights in m over that of the first contact
    pub track: Track,
    /// standard deviation of a position in m
    pub noise: f64,
    /// pixels per m
    pub scale: ImageScale,
    /// every flight, in order
    pub flights: Vec<FreeFlight>,
    /// frames that were repeated or are missing, by the jumps of the flights; their times are mended
    pub jumps: Vec<Jump>,
    /// the first, or all where they were asked for; at least one
    pub impacts: Vec<Impact>,
    /// height of the sphere at rest less that of the contact, in m, where it came to rest
    pub rest: Option<f64>,
}

/// A recording with what it gave, or why it gave nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// which
    pub recording: Recording,
    /// what it shows, where it was read
    pub shown: Option<Shown>,
    /// its impacts
    pub tracked: Result<Tracked, Refusal>,
}

/// The gravity of the recordings that share a kind of scale, of those whose own agrees with [`GRAVITY`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GravityCheck {
    /// g in m/s² by scales that were measured; `None` where none was, or none agrees
    pub measured: Option<Gravity>,
    /// the scale, in pixels per m, with its standard error, of the recordings that have it from gravity
    pub scale: Option<[f64; 2]>,
    /// by how much, relative, the gravity of a kind of measured scale is off [`GRAVITY`]: that of the worst
    pub off: f64,
}

/// Standard deviation of the gravity of a place about [`GRAVITY`], relative: on the ground it is 9.780 to 9.832 m/s².
pub const LOCAL_GRAVITY: f64 = 0.0015;

impl GravityCheck {
    /// The relative error that speeds share: by how much g is off, or is known. `None` without a gravity, and of more than
    /// an error of a scale: a scale or a frame rate is then wrong, or the flights are too short to tell.
    pub fn shared_error(&self) -> Option<f64> {
        /// more is no error that speeds share but a mistake
        const MOST: f64 = 0.1;
        let measured = self.measured.map(|g| g.se / GRAVITY);
        let scale = self.scale.map(|[value, se]| se / value);
        let known = measured.into_iter().chain(scale).reduce(f64::max)?;
        Some(self.off.max(known).max(LOCAL_GRAVITY)).filter(|error| *error <= MOST)
    }
}

/// A recording on its way.
struct Underway<'r> {
    recording: &'r Recording,
    flights: Flights,
    scale: ImageScale,
    /// the gravity of its own flights, where it is not that of free fall: no other recording is to share it
    stray: Option<Gravity>,
}

/// All recordings with what they gave, in their order; those that show nothing carry the reason.
pub(super) fn analyse(
    recordings: Vec<Recording>,
    shown: Vec<Result<Shown, Refusal>>,
    all_rebounds: bool,
) -> (Vec<Outcome>, GravityCheck) {
    let begun = recordings
        .iter()
        .zip(&shown)
        .map(|(recording, shown)| Underway::of(recording, shown.as_ref().map_err(Refusal::clone)?, all_rebounds));
    let mut underway: Vec<Result<Underway, Refusal>> = begun.collect();
    let check = settle(&mut underway);
    let plates = underway.iter().map(|of| of.as_ref().ok()?.plate(check));
    let apart = alone(&plates.collect::<Vec<_>>());
    let tracked = underway
        .into_iter()
        .zip(apart)
        .map(|(of, apart)| finish(&of?, check, apart));
    let tracked: Vec<Result<Tracked, Refusal>> = tracked.collect();
    let outcomes = recordings.into_iter().zip(shown).zip(tracked);
    let outcomes = outcomes.map(|((recording, shown), tracked)| Outcome {
        recording,
        shown: shown.ok(),
        tracked,
    });
    (outcomes.collect(), check)
}

/// The scale of a recording; one by gravity is 1 so far.
fn scale(recording: &Recording, shown: &Shown) -> ImageScale {
    let by_diameter = shown.diameter.map(|of| of.map(|pixels| pixels / recording.diameter));
    let (value, source) = match (shown.in_pixels, recording.scale, by_diameter) {
        (false, ..) => (1.0, ScaleSource::Lengths),
        (true, Some(stated), _) => (stated, ScaleSource::Stated),
        (true, None, Some([value, _])) => (value, ScaleSource::Diameter),
        (true, None, None) => (1.0, ScaleSource::Gravity),
    };
    ImageScale {
        value,
        source,
        by_diameter,
    }
}

/// Lets flights, contacts, gravity and the scale by gravity follow each other; what fails leaves with its reason.
fn settle(underway: &mut [Result<Underway, Refusal>]) -> GravityCheck {
    let mut check = GravityCheck::default();
    // a long recording at another scale than the others has most of the frames: each counts once
    let by_gravity = underway.iter().flatten().filter(|of| of.is_by_gravity());
    let mut own: Vec<Gravity> = by_gravity.filter_map(|of| shared(&of.flights.gravities())).collect();
    own.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut found = own.get(own.len().saturating_sub(1) / 2).copied();
    for round in 0..=ROUNDS {
        if let Some(g) = found {
            for of in underway.iter_mut().flatten().filter(|of| of.is_by_gravity()) {
                of.flights = of.flights.over(g.value / GRAVITY);
                of.scale.value *= g.value / GRAVITY;
                check.scale = Some([of.scale.value, of.scale.value * g.se / g.value]);
            }
        }
        // a recording whose own flights do not fall as things do stands apart: its mistake is no other recording's
        for of in underway.iter_mut().flatten() {
            of.stray = shared(&of.flights.gravities()).filter(|own| is_off(own.value, own.se, GRAVITY));
        }
        found = gravity_of(underway, &[ScaleSource::Gravity]);
        check.measured = gravity_of(underway, &ScaleSource::MEASURED);
        if round == ROUNDS {
            break;
        }
        for place in underway.iter_mut() {
            let refined = place.as_mut().map_or(Ok(()), |of| of.refine(check));
            if let Err(reason) = refined {
                *place = Err(reason);
            }
        }
    }
    let each = ScaleSource::MEASURED
        .iter()
        .filter_map(|source| gravity_of(underway, &[*source]));
    check.off = each.map(|g| (g.value / GRAVITY - 1.0).abs()).fold(0.0, f64::max);
    check
}

/// The gravity of recordings whose scale is of these kinds and whose own agrees with that of free fall.
fn gravity_of(underway: &[Result<Underway, Refusal>], sources: &[ScaleSource]) -> Option<Gravity> {
    let of_kind = underway
        .iter()
        .flatten()
        .filter(|of| of.stray.is_none() && sources.contains(&of.scale.source));
    let own: Vec<([f64; 2], usize)> = of_kind.flat_map(|of| of.flights.gravities()).collect();
    shared(&own)
}

/// The gravity that a recording is fitted with. Of one whose scale it gives it is known; what the scale errs by is an error
/// that all speeds share.
fn gravity_for(of: &Underway, check: GravityCheck) -> Option<Gravity> {
    if of.stray.is_some() {
        return of.stray;
    }
    if of.is_by_gravity() {
        return Some(Gravity {
            value: GRAVITY,
            se: 0.0,
            flights: 0,
        });
    }
    check.measured
}

/// What a recording gave, whose first contact is `from_others` away from those of the others where it alone differs.
fn finish(of: &Underway, check: GravityCheck, from_others: Option<f64>) -> Result<Tracked, Refusal> {
    let gravity = gravity_for(of, check).ok_or(Refusal::NeverFalls)?;
    let flights = &of.flights;
    let mut met = flights.met(gravity);
    met.retain(|(contact, _)| flights.has_frames(*contact));
    let (first, at) = met.first().copied().ok_or(Refusal::Unclear)?;
    let impacts = met.iter().map(|(contact, speeds)| {
        let stuck = contact.rebound().is_none();
        let lost = 2.0 * gravity.value * of.recording.film;
        let at_film = [speeds.impact_speed, speeds.rebound_speed].map(|v| (v * v - lost).max(0.0).sqrt());
        let own = flights.apart(*contact, gravity, of.recording.film);
        let apart = own.filter(|gap| *gap > 0.0);
        // its own other contacts know better
        let from_others = from_others.filter(|_| own.is_none() && *contact == first);
        // a height that is off by h moves v by g h/v, and v_r likewise
        let off = apart.or(from_others).map_or([0.0; 2], |gap| {
            [speeds.impact_speed, speeds.rebound_speed].map(|v| gravity.value * gap / v)
        });
        let share = off[1] / speeds.rebound_speed;
        Impact {
            speeds: ContactSpeeds {
                height: speeds.height - at.height,
                ..speeds.with_error_along(off)
            },
            stuck,
            at_film,
            apart: apart.filter(|_| share > APART_COUNTS),
            apart_from_others: from_others.filter(|_| share > APART_COUNTS),
            // its numbers cannot all be right
            verdict: of
                .width_verdict()
                .or_else(|| of.fall_verdict(*contact, gravity, check))
                .or_else(|| of.unseen_verdict(*speeds))
                .or_else(|| of.contact_verdict(*contact, *speeds, gravity))
                .or_else(|| of.run_verdict(*contact, *speeds))
                .or_else(|| of.scatter_verdict(*speeds))
                .or_else(|| too_far_apart(apart?, share)),
        }
    });
    let rest = flights
        .rest_after(first)
        .map(|rest| flights.level(rest).height - at.height);
    Ok(Tracked {
        impacts: impacts.collect(),
        flights: free_flights(flights, gravity, at.height),
        track: Track {
            times: flights.track.times.clone(),
            heights: flights.track.heights.iter().map(|height| height - at.height).collect(),
        },
        noise: flights.sigma,
        jumps: flights.jumps.clone(),
        scale: of.scale,
        rest,
    })
}

/// Why an impact is left out whose contact lies this far, in m, from the height of the others, which makes v_r wrong by this
/// share.
fn too_far_apart(gap: f64, share: f64) -> Option<String> {
    /// beyond this nobody knows the speeds well enough for a run
    const MOST: f64 = 0.03;
    (share > MOST).then(|| {
        format!(
            "the flights before and after this impact meet {} mm from the height of the other contacts or of the sphere at rest, \
             which puts its rebound speed in doubt by {} %: {APART_SINCE}",
            significant(millimetres(gap), 2),
            significant(100.0 * share, 2)
        )
    })
}

fn free_flights(flights: &Flights, gravity: Gravity, level: f64) -> Vec<FreeFlight> {
    let acceleration = -gravity.value;
    let flight = |place: usize| {
        let instant = flights.segments[place].parabola.time;
        let fit = flights.fit_from_middle(place);
        FreeFlight {
            frames: flights.segments[place].frames.clone(),
            residuals: flights.residuals(place, gravity),
            own_gravity: fit.own_gravity(flights.sigma),
            parabola: [
                instant,
                fit.height_under(acceleration, instant) - level,
                fit.velocity_under(acceleration, instant),
                gravity.value,
            ],
        }
    };
    flights.places().map(flight).collect()
}

impl Underway<'_> {
    fn of<'r>(recording: &'r Recording, shown: &Shown, all_rebounds: bool) -> Result<Underway<'r>, Refusal> {
        let scale = scale(recording, shown);
        let flights = Flights::of(shown.track.clone(), all_rebounds).map_err(|reason| match reason {
            // frames have their ground below whatever the list says of tables
            Refusal::FallsUpwards if shown.diameter.is_some() => Refusal::BendsUpwards,
            Refusal::Torn
            | Refusal::Uneven
            | Refusal::Unclear
            | Refusal::NoFall
            | Refusal::ShortFall
            | Refusal::EndsBefore
                if are_rounded(&shown.track) =>
            {
                Refusal::RoundedTimes
            }
            other => other,
        })?;
        Ok(Underway {
            recording,
            stray: None,
            flights: flights.over(scale.value),
            scale,
        })
    }

    /// The height at which its first contact meets the plate; `None` of a sphere that stayed.
    fn plate(&self, check: GravityCheck) -> Option<PlateHeight> {
        let gravity = gravity_for(self, check).filter(|_| self.stray.is_none())?;
        let met = self.flights.met(gravity);
        let (contact, speeds) = met.into_iter().find(|(contact, _)| self.flights.has_frames(*contact))?;
        contact.rebound()?;
        Some(PlateHeight {
            level: Level {
                height: speeds.height,
                sd: speeds.height_sd,
            },
            by_a_frame: self.flights.higher_by_a_frame(&speeds),
            film: self.recording.film,
            scale_and_diameter: [self.scale.value, self.recording.diameter],
        })
    }

    /// Whether its scale is one that gravity gives.
    fn is_by_gravity(&self) -> bool {
        self.scale.source == ScaleSource::Gravity
    }

    /// Fits its flights anew, with the gravity that is known by now.
    fn refine(&mut self, check: GravityCheck) -> Result<(), Refusal> {
        let gravity = gravity_for(self, check).ok_or(Refusal::NeverFalls)?;
        let recording = self.recording;
        // lengths are metres from here on
        self.flights.air = recording.density.map(|density| recording.in_air(density));
        self.flights.refine(gravity, recording.film)
    }

    /// Whether the sphere can be as wide as its scale says: wider than its positions scatter, and as the frames show it.
    fn width_verdict(&self) -> Option<String> {
        /// pixels that a tracker needs
        const LEAST_WIDTH: f64 = 2.0;
        /// standard deviations of a position, of which the width has more
        const LEAST_SDS: f64 = 4.0;
        /// by which share two scales may differ: a sphere may hang nearer to the camera than the scale did
        const APART: f64 = 0.1;
        let scale = self.scale.value;
        if self.is_by_gravity() {
            let (width, scatter) = (self.recording.diameter * scale, self.flights.sigma * scale);
            return (width < LEAST_WIDTH.max(LEAST_SDS * scatter)).then(|| {
                format!(
                    "by gravity the scale is {} px/mm and its sphere {width:.1} px wide, where positions scatter by \
                     {scatter:.1} px: frame_rate_Hz or diameter_mm is wrong, or it was taken at another scale than the others",
                    significant(pixels_per_millimetre(scale), 3)
                )
            });
        }
        let [seen, se] = self
            .scale
            .by_diameter
            .filter(|_| self.scale.source == ScaleSource::Stated)?;
        let off = (seen - scale).abs();
        (off > APART * scale && off > 3.0 * se).then(|| {
            format!(
                "by the sphere's diameter the scale is {} px/mm, by the list {}: diameter_mm or scale_px_per_mm is wrong",
                significant(pixels_per_millimetre(seen), 3),
                significant(pixels_per_millimetre(scale), 3)
            )
        })
    }

    /// Whether its flights fall as things do, and each as those of all.
    fn fall_verdict(&self, contact: Contact, gravity: Gravity, check: GravityCheck) -> Option<String> {
        let it_falls = match self.scale.source {
            ScaleSource::Gravity => "by the scale of the others it falls",
            _ => "it falls",
        };
        let [by_itself, all] = [(it_falls, self.stray), ("all flights fall", check.measured)];
        let is_wrong = |g: &Gravity| is_off(g.value, g.se, GRAVITY);
        let wrong = [by_itself, all].map(|(who, of)| Some((who, of.filter(is_wrong)?)));
        if let Some((who, g)) = wrong.into_iter().flatten().next() {
            return Some(format!(
                "{who} at {} m/s^2, not {GRAVITY}, {} times as fast as things do: {}",
                significant(g.value, 3),
                significant(g.value / GRAVITY, 3),
                self.what_is_wrong(g.value / GRAVITY)
            ));
        }
        let places = [("before", Some(contact.before)), ("after", contact.rebound())];
        places.into_iter().find_map(|(side, place)| {
            let [own, se] = self.flights.fit_from_middle(place?).own_gravity(self.flights.sigma);
            is_off(own, se.hypot(gravity.se), gravity.value).then(|| {
                format!(
                    "its flight {side} the contact falls at {own:.2} m/s^2, where all fall at {:.2}: {}",
                    gravity.value,
                    self.what_is_wrong(own / gravity.value)
                )
            })
        })
    }

    /// What the frame rate or the scale would be if the other is right, where things fall so many times too fast.
    fn what_is_wrong(&self, times: f64) -> String {
        let right = |what: &str, value: f64| format!("{what} would be {}", significant(value, 3));
        let rate = self
            .recording
            .frame_rate
            .map(|rate| right("frame_rate_Hz", rate / times.sqrt()));
        let scale = match self.scale.source {
            ScaleSource::Stated => Some(right(
                "scale_px_per_mm",
                pixels_per_millimetre(self.scale.value * times),
            )),
            ScaleSource::Lengths => Some(right("lengths", 1.0 / times) + " times as large"),
            ScaleSource::Diameter | ScaleSource::Gravity => None,
        };
        let would: Vec<String> = rate.into_iter().chain(scale).filter(|_| times > 0.0).collect();
        if would.is_empty() {
            return "frame rate or scale is wrong".to_owned();
        }
        format!("frame rate or scale is wrong ({})", would.join(", or "))
    }

    /// Whether it was seen near its contact: in a long gap it may have met the plate more than once.
    fn unseen_verdict(&self, speeds: ContactSpeeds) -> Option<String> {
        /// frames that a tracker may lose about a contact
        const LOST: f64 = 6.0;
        /// share of the impact speed with which a rebound may come that fits into the gap
        const HIDDEN: f64 = 0.1;
        let track = &self.flights.track;
        let after = track.times.partition_point(|t| *t <= speeds.time);
        let gap = track.times.get(after)? - track.times.get(after.checked_sub(1)?)?;
        let hides = 0.5 * GRAVITY * gap > HIDDEN * speeds.impact_speed;
        (hides && gap > LOST * track.frame_time()).then(|| {
            format!(
                "nothing is seen for {} ms about its contact, in which it may have met the plate more than once",
                significant(milliseconds(gap), 2)
            )
        })
    }

    /// Whether its flights reach the contact: where frames are missing or repeated beside it, some belong to neither.
    fn contact_verdict(&self, contact: Contact, speeds: ContactSpeeds, gravity: Gravity) -> Option<String> {
        /// positions that may be another object's, where no other frames are missing or repeated
        const OTHERS: usize = 2;
        /// frames about the contact, whose exposure may hold it
        const ABOUT: f64 = 0.6;
        /// standard deviations of a position, which a frame moves the contact by more than
        const CLEAR: f64 = 4.0 * SURE;
        /// frames that may be missing, or less than 0 repeated, beside a contact
        const WHOLE: [f64; 3] = [2.0, 1.0, -1.0];
        let after = contact.rebound()?;
        let flights = &self.flights;
        let last = *flights.segments[contact.before].frames.last()?;
        let first = *flights.segments[after].frames.first()?;
        let near = ABOUT * flights.track.frame_time();
        let is_left = |place: &usize| {
            let (time, height) = (flights.track.times[*place], flights.track.heights[*place]);
            (time - speeds.time).abs() > near && height > speeds.height + self.recording.film
        };
        // one is enough that is on its flight at the time of another frame, unless others are another object's
        let film = self.recording.film;
        let lowest = match film {
            0.0 => speeds.height - WHOLE[0] * flights.higher_by_a_frame(&speeds),
            _ => speeds.height + film,
        };
        let is_whole = |place: &usize| {
            let (time, height) = (flights.track.times[*place], flights.track.heights[*place]);
            let is_before = time < speeds.time;
            let (flight, later) = if is_before {
                (contact.before, 1.0)
            } else {
                (after, -1.0)
            };
            let moved = |frames: &f64| time + later * frames * flights.track.frame_time();
            let is_on = |frames: &f64| {
                let expected = flights.height_at(flight, gravity, moved(frames));
                (height - expected).abs() < SURE * flights.sigma
            };
            (time - speeds.time).abs() > near && height > lowest && WHOLE.iter().any(is_on)
        };
        let is_unbroken = |flight: usize| {
            let frames = &flights.segments[flight].frames;
            frames.windows(2).all(|pair| pair[1] == pair[0] + 1)
        };
        let left = (last + 1..first).filter(is_left).count();
        let whole = (last + 1..first).filter(is_whole).count();
        let tells = flights.higher_by_a_frame(&speeds) > CLEAR * flights.sigma;
        let is_sure = tells && whole > 0 && is_unbroken(contact.before) && is_unbroken(after);
        let left = if is_sure { left.max(whole) } else { left };
        let most = if is_sure || !flights.jumps.is_empty() {
            0
        } else {
            OTHERS
        };
        (left > most).then(|| {
            format!("{left} positions beside its contact fit neither flight: frames are missing or repeated there")
        })
    }

    /// Whether positions may scatter as they do about its flights. Where moves are too few to tell frames that are repeated or
    /// missing, these leave a good part of a move, and more than a tracker errs by.
    fn scatter_verdict(&self, speeds: ContactSpeeds) -> Option<String> {
        /// of a move from frame to frame
        const OF_MOVE: f64 = 0.07;
        /// of the diameter
        const OF_WIDTH: f64 = 0.03;
        /// times what rounding leaves
        const OF_ROUNDING: f64 = 3.0;
        let flights = &self.flights;
        let of_move = flights.sigma / (speeds.impact_speed * flights.track.frame_time());
        let of_width = flights.sigma / self.recording.diameter;
        let is_wide = of_move > OF_MOVE && of_width > OF_WIDTH;
        (!flights.is_timed && is_wide && flights.sigma > OF_ROUNDING * flights.track.rounding()).then(|| {
            format!(
                "positions scatter about its flights by {} mm, {} times what a frame moves the sphere by: some frames are repeated \
                 or missing, or another thing was tracked",
                significant(millimetres(flights.sigma), 2),
                significant(of_move, 2)
            )
        })
    }

    /// Whether a table of runs takes it.
    fn run_verdict(&self, contact: Contact, speeds: ContactSpeeds) -> Option<String> {
        /// kg/m³ of the densest sphere there is, where the list has no density
        const DENSEST: f64 = 22_600.0;
        let (v, v_r) = (speeds.impact_speed, speeds.rebound_speed);
        let sphere = self.recording.in_air(self.recording.density.unwrap_or(DENSEST));
        let drag = sphere.deceleration(v) / GRAVITY;
        if drag > 1.0 {
            return Some(format!(
                "no fall is as fast as {} m/s: the drag of the air would be {} times the weight: frame rate or scale is wrong",
                significant(v, 3),
                significant(drag, 2)
            ));
        }
        if self.recording.film > self.recording.diameter {
            return Some("film_um is more than the diameter".to_owned());
        }
        if v_r > LARGEST_RESTITUTION * v {
            return Some(format!(
                "it rebounds {} times as fast as it comes: what was taken for its flights is not one sphere's",
                significant(v_r / v, 3)
            ));
        }
        let stuck = contact.rebound().is_none();
        let usual = |number: f64| MAGNITUDES.contains(&number);
        let sds = [speeds.impact_speed_sd, speeds.rebound_speed_sd];
        let taken = usual(v) && (stuck || usual(v_r)) && sds.into_iter().all(|sd| sd == 0.0 || usual(sd));
        (!taken).then(|| "its speeds are beyond what a table of runs takes".to_owned())
    }
}

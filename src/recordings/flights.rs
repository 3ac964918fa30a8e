//! Fits the flights of one recording: which frames belong to each, and the speeds where two of them meet.

use super::air::{SphereInAir, DRAG_REL_SD};
use super::contacts::{contacts, After, Contact, Refusal};
use super::gravity::Gravity;
use super::impact::{rebound, stayed, ContactSpeeds, Level};
use super::parabola::{Kind, Parabola, LEAST_FRAMES};
use super::segments::{segments, Segment};
use super::timing::{on_time, uneven_share, Jump, MOST_UNEVEN};
use super::track::Track;

/// A track with its flights and contacts.
#[derive(Debug, Clone)]
pub(super) struct Flights {
    pub track: Track,
    /// standard deviation of a position: first by differences, then by what the flights leave
    pub sigma: f64,
    pub segments: Vec<Segment>,
    pub contacts: Vec<Contact>,
    /// the sphere, where its drag is to be taken off; heights are in m then
    pub air: Option<SphereInAir>,
    /// frames that were repeated or are missing
    pub jumps: Vec<Jump>,
    /// whether frequent ones would have been seen
    pub is_timed: bool,
}

/// Standard deviations of two heights of a plate by which these differ, at least.
pub(super) const SURE: f64 = 5.0;

/// Frames whose exposure may hold the contact, to each side, in frames.
const EXPOSED: f64 = 0.5;

impl Flights {
    /// Of a track in any unit of length.
    pub fn of(track: Track, all: bool) -> Result<Flights, Refusal> {
        let sigma = track.noise().ok_or(Refusal::NeverFalls)?;
        let share = uneven_share(&track);
        if share.is_some_and(|share| share > MOST_UNEVEN) {
            return Err(Refusal::Uneven);
        }
        let frames = track.times.len() as f64;
        let (track, jumps) = on_time(track, sigma);
        let uneven: i32 = jumps.iter().map(|jump| jump.missing.abs()).sum();
        if f64::from(uneven) > MOST_UNEVEN * frames {
            return Err(Refusal::Uneven);
        }
        let segments = segments(&track, sigma);
        let contacts = contacts(&track, &segments, (sigma, all))?;
        Ok(Flights {
            track,
            sigma,
            segments,
            contacts,
            air: None,
            jumps,
            is_timed: share.is_some(),
        })
    }

    /// The same in another unit of length.
    pub fn over(&self, scale: f64) -> Flights {
        let track = self.track.over(scale);
        let mut flights = self.clone();
        for segment in &mut flights.segments {
            segment.parabola = Parabola::through(&track.points(&segment.frames)).unwrap_or(segment.parabola);
        }
        Flights {
            sigma: self.sigma / scale,
            track,
            ..flights
        }
    }

    /// The places of its flights.
    pub fn places(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.segments.len()).filter(|place| self.segments[*place].kind == Kind::Flight)
    }

    /// A flight as it would be without air: what the air takes is taken off from an instant on, before and after.
    pub fn fit(&self, place: usize, instant: f64) -> Parabola {
        let segment = &self.segments[place];
        if self.air.is_none() {
            return segment.parabola;
        }
        let mut points = self.track.points(&segment.frames);
        for (t, y) in &mut points {
            *y -= self.moved_by_air(place, instant, *t);
        }
        Parabola::through(&points).unwrap_or(segment.parabola)
    }

    /// The same from the middle of its frames on.
    pub fn fit_from_middle(&self, place: usize) -> Parabola {
        self.fit(place, self.segments[place].parabola.time)
    }

    /// Every flight of the recording, each as it would be without air.
    fn fits(&self) -> impl Iterator<Item = Parabola> + '_ {
        // whichever the instant, the acceleration is the same
        self.places().map(move |place| self.fit_from_middle(place))
    }

    /// The gravity of every flight by itself with the standard error, and its frames.
    pub fn gravities(&self) -> Vec<([f64; 2], usize)> {
        let own = |fit: Parabola| (fit.own_gravity(self.sigma), fit.frames);
        self.fits().map(own).collect()
    }

    /// Heights less the parabola of this gravity and what the air moved, a frame each.
    pub fn residuals(&self, place: usize, gravity: Gravity) -> Vec<f64> {
        let fit = self.fit_from_middle(place);
        let residual = |frame: &usize| {
            let t = self.track.times[*frame];
            self.track.heights[*frame] - self.moved_by_air(place, fit.time, t) - fit.height_under(-gravity.value, t)
        };
        self.segments[place].frames.iter().map(residual).collect()
    }

    /// By how much the air has moved a flight at a time, from an instant on.
    fn moved_by_air(&self, place: usize, instant: f64, t: f64) -> f64 {
        let seen = &self.segments[place].parabola;
        let moved = |sphere: SphereInAir| sphere.moved(t - instant, seen.velocity(instant), -seen.acceleration());
        self.air.map_or(0.0, moved)
    }

    /// The height of a flight at a time, with what the air moves it by.
    pub fn height_at(&self, place: usize, gravity: Gravity, t: f64) -> f64 {
        let fit = self.fit_from_middle(place);
        fit.height_under(-gravity.value, t) + self.moved_by_air(place, fit.time, t)
    }

    /// The height by which two flights meet higher for each frame that is missing between them.
    pub fn higher_by_a_frame(&self, speeds: &ContactSpeeds) -> f64 {
        let (v, v_r) = (speeds.impact_speed, speeds.rebound_speed);
        self.track.frame_time() * v * v_r / (v + v_r)
    }

    /// The contacts at which its flights meet, each with the speeds there.
    pub fn met(&self, gravity: Gravity) -> Vec<(Contact, ContactSpeeds)> {
        let contacts = self.contacts.iter();
        let met = contacts.filter_map(|contact| Some((*contact, self.speeds(*contact, gravity)?)));
        met.collect()
    }

    /// The speeds at a contact, with what frames that are repeated or missing do to them; `None` where its flights do not
    /// meet.
    pub fn speeds(&self, contact: Contact, gravity: Gravity) -> Option<ContactSpeeds> {
        let found = self.speeds_on_time(contact, gravity)?;
        if self.jumps.is_empty() {
            return Some(found);
        }
        let frames = self.track.times.len() as f64;
        let (v, v_r) = (found.impact_speed, found.rebound_speed);
        // frames may be all there in a time of their own, which makes the rate another
        let net: i32 = self.jumps.iter().map(|jump| jump.missing).sum();
        let rate = f64::from(net) / frames;
        // and one may be missing at the contact, where no flight shows it, as often as elsewhere
        let all: i32 = self.jumps.iter().map(|jump| jump.missing.abs()).sum();
        let often = (f64::from(all) / frames).sqrt();
        let late = gravity.value * self.track.frame_time() * often / (v + v_r);
        let late = contact.rebound().map_or([0.0, 0.0], |_| [late * v_r, late * v]);
        Some(found.with_error_along([rate * v, rate * v_r]).with_error_along(late))
    }

    fn speeds_on_time(&self, contact: Contact, gravity: Gravity) -> Option<ContactSpeeds> {
        let end = self.segments[contact.before].parabola.ends[1];
        let start = contact
            .rebound()
            .map_or(end, |after| self.segments[after].parabola.ends[0]);
        let about = self.meeting(contact, Some([end, start]), gravity)?;
        if self.air.is_none() {
            return Some(about);
        }
        // the instant is that of the contact: speeds there are those that air has left
        let found = self.meeting(contact, Some([about.time; 2]), gravity)?;
        let plain = self.meeting(contact, None, gravity)?;
        Some(found.with_error_along([
            DRAG_REL_SD * (plain.impact_speed - found.impact_speed),
            DRAG_REL_SD * (plain.rebound_speed - found.rebound_speed),
        ]))
    }

    /// The speeds where the flights meet, what the air takes from each taken off from an instant on; as seen without one.
    fn meeting(&self, contact: Contact, instants: Option<[f64; 2]>, gravity: Gravity) -> Option<ContactSpeeds> {
        let fit = |place: usize, which: usize| match instants {
            Some(instants) => self.fit(place, instants[which]),
            None => self.segments[place].parabola,
        };
        let before = fit(contact.before, 0);
        match contact.after {
            After::Flight(after) => rebound(&before, &fit(after, 1), self.sigma, gravity),
            After::Rest(rest) => stayed(&before, self.level(rest), self.sigma, gravity),
        }
    }

    /// The height of a rest: that of its later half, when nothing is left of what came before.
    pub fn level(&self, rest: usize) -> Level {
        let frames = &self.segments[rest].frames;
        let late = &frames[frames.len() / 2..];
        let count = late.len() as f64;
        Level {
            height: late.iter().map(|frame| self.track.heights[*frame]).sum::<f64>() / count,
            sd: self.sigma / count.sqrt(),
        }
    }

    /// The lowest rest after a contact.
    pub fn rest_after(&self, contact: Contact) -> Option<usize> {
        let rests = (contact.before + 1..self.segments.len()).filter(|place| self.segments[*place].kind == Kind::Rest);
        rests.min_by(|a, b| self.level(*a).height.total_cmp(&self.level(*b).height))
    }

    /// Distance between the height of a contact and the nearest height at which the sphere met the plate otherwise: at another
    /// contact or at rest. 0 where film and errors explain it; `None` where there is no other.
    ///
    /// A frame that is missing at a contact, where no flight shows it, lets both flights meet above the plate.
    pub fn apart(&self, contact: Contact, gravity: Gravity, film: f64) -> Option<f64> {
        /// times the error of the best known height, beyond which another tells nothing beside it
        const WORSE: f64 = 3.0;
        contact.rebound()?;
        let mut whole = self.clone();
        whole.contacts = contacts(&self.track, &self.segments, (self.sigma, true)).ok()?;
        whole.take_own_frames(gravity, film);
        let own = whole.speeds(contact, gravity)?;
        let met = whole.met(gravity).into_iter();
        let others = met.filter(|(other, _)| other.before != contact.before && whole.has_frames(*other));
        let others = others.map(|(_, speeds)| Level {
            height: speeds.height,
            sd: speeds.height_sd,
        });
        let rest = whole.rest_after(contact).map(|rest| whole.level(rest));
        let others: Vec<Level> = others.chain(rest).collect();
        let explained = |other: &Level| SURE * own.height_sd.hypot(other.sd);
        let best = others.iter().map(explained).reduce(f64::min)?;
        let well_known = others.iter().filter(|other| explained(other) <= WORSE * best);
        let is_explained = |other: &Level| (own.height - other.height).abs() <= film + explained(other);
        if well_known.clone().any(is_explained) {
            return Some(0.0);
        }
        well_known
            .map(|other| (own.height - other.height).abs())
            .reduce(f64::min)
    }

    /// Gives each flight the frames that are its own. Then what rose no higher than the film stayed.
    pub fn refine(&mut self, gravity: Gravity, film: f64) -> Result<(), Refusal> {
        self.take_own_frames(gravity, film);
        self.settle(gravity, film)
    }

    /// Gives each flight the frames that are its own once its contacts are known: up to them, but for those whose exposure
    /// may hold the contact and those in a film of this thickness.
    fn take_own_frames(&mut self, gravity: Gravity, film: f64) {
        let met = self.met(gravity);
        for place in self.places().collect::<Vec<_>>() {
            let from = met.iter().find(|(contact, _)| contact.rebound() == Some(place));
            let to = met.iter().find(|(contact, _)| contact.before == place);
            let ends = [from, to].map(|met| met.map(|(_, speeds)| *speeds));
            let frames = self.own_frames(place, gravity, ends, film);
            if let Some(parabola) = Parabola::through(&self.track.points(&frames)) {
                self.segments[place].frames = frames;
                self.segments[place].parabola = parabola;
            }
        }
        let leaves: f64 = self.fits().map(|fit| fit.squares_under(-gravity.value)).sum();
        let free: usize = self
            .places()
            .map(|place| self.segments[place].frames.len().saturating_sub(2))
            .sum();
        if free > 0 {
            self.sigma = (leaves / free as f64).sqrt().max(f64::MIN_POSITIVE);
        }
    }

    /// The frames of a flight between two contacts.
    fn own_frames(&self, place: usize, gravity: Gravity, met: [Option<ContactSpeeds>; 2], film: f64) -> Vec<usize> {
        /// standard deviations beyond which a position is another object's
        const FAR: f64 = 5.0;
        let segment = &self.segments[place];
        let [first, last] = segment.parabola.ends;
        let fit = self.fit_from_middle(place);
        // of a flight that is no parabola to a pixel, as under a wrong scale, by what it is off
        let free = fit.frames.saturating_sub(2).max(1);
        let off = (fit.squares_under(-gravity.value) / free as f64).sqrt();
        let scatter = self.sigma.max(off);
        let exposed = EXPOSED * self.track.frame_time();
        let [from, to] = met;
        let start = from.map_or(first, |speeds| speeds.time + exposed);
        let end = to.map_or(last, |speeds| speeds.time - exposed);
        let floor = met
            .into_iter()
            .flatten()
            .map(|speeds| speeds.height + film)
            .fold(f64::NEG_INFINITY, f64::max);
        let is_own = |frame: &usize| {
            let t = self.track.times[*frame];
            if t < start || t > end {
                return false;
            }
            let expected = fit.height_under(-gravity.value, t) + self.moved_by_air(place, fit.time, t);
            let x = t - fit.time;
            let leverage = 1.0 + 1.0 / fit.frames as f64 + x * x / fit.sum_of_squares;
            expected > floor && (self.track.heights[*frame] - expected).abs() < FAR * scatter * leverage.sqrt()
        };
        (0..self.track.times.len()).filter(is_own).collect()
    }

    /// What rebounded no higher than the film stayed; what rested only after a rise out of it did not.
    fn settle(&mut self, gravity: Gravity, film: f64) -> Result<(), Refusal> {
        /// standard deviations of a position above the film
        const ABOVE: f64 = 6.0;
        /// of all heights: pictures of a video that hardly change are corrected now and then
        const WANDER: f64 = 0.001;
        let [lowest, highest] = self.track.ends_of_heights();
        let scatter = ABOVE * self.sigma + WANDER * (highest - lowest);
        for place in 0..self.contacts.len() {
            let contact = self.contacts[place];
            let Some(speeds) = self.speeds(contact, gravity) else {
                continue;
            };
            match (contact.after, self.rest_after(contact)) {
                (After::Flight(_), Some(rest)) => {
                    let rise = 0.5 * speeds.rebound_speed * speeds.rebound_speed / gravity.value;
                    if rise < film {
                        self.contacts[place].after = After::Rest(rest);
                    }
                }
                (After::Rest(rest), _) => {
                    let level = self.level(rest).height;
                    let after = self.track.times.partition_point(|t| *t <= speeds.time);
                    // frames in a row: one or two may be another object's
                    let rows = self.track.heights[after..].windows(3);
                    let lowest = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min) - level;
                    let highest = rows.map(lowest).fold(0.0, f64::max);
                    if highest > film + scatter {
                        return Err(Refusal::Unclear);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Whether the flights about a contact have frames enough.
    pub fn has_frames(&self, contact: Contact) -> bool {
        let enough = |place: usize| self.segments[place].frames.len() >= LEAST_FRAMES;
        enough(contact.before) && contact.rebound().is_none_or(enough)
    }
}

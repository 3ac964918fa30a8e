//! Fits the flights of one recording: which frames belong to each, and the speeds where two of them meet.

use super::contacts::{contacts, After, Contact, NoContact};
use super::gravity::{FlightFit, Gravity};
use super::impact::{rebound, stayed, ContactSpeeds, Level};
use super::parabola::{Kind, Parabola, LEAST_FRAMES};
use super::segments::{segments, Segment};
use super::track::Track;

/// A track with its flights and contacts.
#[derive(Debug, Clone)]
pub(super) struct Flights {
    pub track: Track,
    /// standard deviation of a position: first by differences, then by what the flights leave
    pub sigma: f64,
    pub segments: Vec<Segment>,
    pub contacts: Vec<Contact>,
}

/// Frames whose exposure may hold the contact, to each side, in frames.
const EXPOSED: f64 = 0.5;

impl Flights {
    /// Of a track in any unit of length.
    pub fn of(track: Track, all: bool) -> Result<Flights, NoContact> {
        let sigma = track.noise().ok_or(NoContact::NeverFalls)?;
        let segments = segments(&track, sigma);
        let contacts = contacts(&track, &segments, (sigma, all))?;
        Ok(Flights {
            track,
            sigma,
            segments,
            contacts,
        })
    }

    /// The same in another unit of length.
    pub fn over(&self, scale: f64) -> Flights {
        let track = self.track.over(scale);
        let in_unit = |segment: &Segment| Segment {
            frames: segment.frames.clone(),
            kind: segment.kind,
            parabola: Parabola::through(&track, &segment.frames).unwrap_or(segment.parabola),
        };
        Flights {
            segments: self.segments.iter().map(in_unit).collect(),
            sigma: self.sigma / scale,
            contacts: self.contacts.clone(),
            track,
        }
    }

    /// The places of its flights.
    fn places(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.segments.len()).filter(|place| self.segments[*place].kind == Kind::Flight)
    }

    pub fn fit(&self, place: usize) -> FlightFit {
        FlightFit {
            parabola: self.segments[place].parabola,
            sigma: self.sigma,
        }
    }

    /// Every flight of the recording.
    pub fn fits(&self) -> Vec<FlightFit> {
        self.places().map(|place| self.fit(place)).collect()
    }

    /// The speeds at a contact; `None` where its flights do not meet.
    pub fn speeds(&self, contact: Contact, gravity: Gravity) -> Option<ContactSpeeds> {
        let before = self.fit(contact.before);
        match contact.after {
            After::Flight(after) => rebound(&before, &self.fit(after), gravity),
            After::Rest(rest) => stayed(&before, self.level(rest), gravity),
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

    /// Gives each flight the frames that are its own once its contacts are known: up to them, but for those whose exposure
    /// may hold the contact and those in a film of this thickness. Then what rose no higher than the film stayed.
    pub fn refine(&mut self, gravity: Gravity, film: f64) -> Result<(), NoContact> {
        let met: Vec<(Contact, ContactSpeeds)> = self
            .contacts
            .iter()
            .filter_map(|contact| Some((*contact, self.speeds(*contact, gravity)?)))
            .collect();
        for place in self.places().collect::<Vec<_>>() {
            let from = met.iter().find(|(contact, _)| contact.after == After::Flight(place));
            let to = met.iter().find(|(contact, _)| contact.before == place);
            let frames = self.own_frames(
                place,
                gravity,
                [from, to].map(|met| met.map(|(_, speeds)| *speeds)),
                film,
            );
            if let Some(parabola) = Parabola::through(&self.track, &frames) {
                self.segments[place].frames = frames;
                self.segments[place].parabola = parabola;
            }
        }
        let leaves: Vec<f64> = self
            .places()
            .map(|place| self.segments[place].parabola.squares_under(-gravity.value))
            .collect();
        let free: usize = self
            .places()
            .map(|place| self.segments[place].frames.len().saturating_sub(2))
            .sum();
        if free > 0 {
            self.sigma = (leaves.iter().sum::<f64>() / free as f64).sqrt().max(f64::MIN_POSITIVE);
        }
        self.settle(gravity, film)
    }

    /// The frames of a flight between two contacts.
    fn own_frames(&self, place: usize, gravity: Gravity, met: [Option<ContactSpeeds>; 2], film: f64) -> Vec<usize> {
        /// standard deviations beyond which a position is another object's
        const FAR: f64 = 5.0;
        let segment = &self.segments[place];
        let [first, last] = segment.span(&self.track);
        let fit = segment.parabola;
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
            let (t, y) = (self.track.times[*frame], self.track.heights[*frame]);
            let expected = fit.height_under(-gravity.value, t);
            let x = t - fit.time;
            let leverage = 1.0 + 1.0 / fit.frames as f64 + x * x / fit.sum_of_squares;
            t >= start && t <= end && expected > floor && (y - expected).abs() < FAR * self.sigma * leverage.sqrt()
        };
        (0..self.track.times.len()).filter(is_own).collect()
    }

    /// What rebounded no higher than the film stayed; what rested only after a rise out of it did not.
    fn settle(&mut self, gravity: Gravity, film: f64) -> Result<(), NoContact> {
        /// standard deviations of a position above the film
        const ABOVE: f64 = 6.0;
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
                    if highest > film + ABOVE * self.sigma {
                        return Err(NoContact::Unclear);
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
        enough(contact.before)
            && match contact.after {
                After::Flight(after) => enough(after),
                After::Rest(_) => true,
            }
    }
}

//! Tells the sphere from its mirror image, its shadow and from other things that move.

use rayon::prelude::*;

use super::background::Background;
use super::circle::{median, Circle, Disc, Rays};
use super::decode::Grey;
use super::edge::{edges, Difference, Edges};
use super::votes::{EdgeCells, Place};

/// The sphere as seen in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// number of the frame, from 0
    pub frame: usize,
    /// centre, px to the right of the centre of the first pixel
    pub x_px: f64,
    /// centre, px below the centre of the first pixel
    pub y_px: f64,
    /// radius of the outline in this frame alone, px; a motion blur changes it
    pub radius_px: f64,
    /// part of the outline that the centre was found from: the rest is hidden by a meniscus, a mirror image or a film
    pub outline_share: f64,
    /// robust sd of the outline's points about the circle, px
    pub scatter_px: f64,
    /// width of the outline's step where it is widest, px: about 2 of a sharp sphere, else its path during the exposure
    pub blur_px: f64,
}

/// Least radius of a sphere, px: below, an outline has not enough pixels.
const LEAST_RADIUS: f64 = 4.0;

/// The outline of the sphere in a frame, from which circles of any radius are fitted.
pub(super) struct Outline {
    /// from whose centre its rays go
    about: Disc,
    pub edges: Edges,
    /// with its radius free
    free: Circle,
    /// height of a second disc below the sphere: its mirror image
    mirror_y: Option<f64>,
}

/// Looks for a sphere of a known size.
pub(super) struct Seeker<'b> {
    background: &'b Background,
    radius: f64,
    rays: Rays,
    cell: usize,
}

/// Rays of an outline: about one a pixel, no more than help.
fn rays(radius: f64) -> Rays {
    Rays::new(((std::f64::consts::TAU * radius) as usize).clamp(48, 180))
}

/// Rounds in which an outline is looked for about a centre that is known better each time, and how far from it, in radii.
/// The last ones are for a motion blur, in which a centre is found slowly.
const REACH: [f64; 9] = [0.45, 0.3, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25];

/// Motion of a centre in a round that is none, px.
const STILL: f64 = 0.1;

/// How far at least, in widths of a blurred edge.
const REACH_OF_WIDTH: f64 = 1.1;

/// Least reach of a search, px.
const LEAST_REACH: f64 = 5.0;

impl<'b> Seeker<'b> {
    pub fn new(background: &'b Background, radius: f64) -> Seeker<'b> {
        Seeker {
            background,
            radius,
            rays: rays(radius),
            // so that a radius is five cells
            cell: ((radius / 5.0) as usize).clamp(1, 16),
        }
    }

    /// The sphere's outline in a frame; `None` where it is not, or not whole.
    pub fn outline(&self, grey: &Grey) -> Option<Outline> {
        /// Discs of a frame: the sphere, its mirror image, its shadow, another.
        const MOST_DISCS: usize = 4;
        /// Part of an outline that votes.
        const LEAST_VOTES: f64 = 0.25;
        let difference = Difference::of(grey, self.background);
        let cells = EdgeCells::of(&difference, self.cell);
        let places = cells.places(self.radius, MOST_DISCS, LEAST_VOTES);
        let found = places.into_iter().filter_map(|place| {
            let outline = outline(&difference, &self.rays, place.disc)?;
            let near = (outline.free.disc.radius / self.radius - 1.0).abs() < 0.15;
            near.then_some(outline)
        });
        let mut discs: Vec<Outline> = vec![];
        for outline in found {
            let same = |other: &Outline| other.free.disc.distance(outline.free.disc) < 0.5 * self.radius;
            if !discs.iter().any(same) {
                discs.push(outline);
            }
        }
        let sphere = sphere_of(discs, self.radius)?;
        let Disc { x, y, .. } = sphere.free.disc;
        let whole =
            |centre: f64, pixels: usize| centre - self.radius >= -0.5 && centre + self.radius <= pixels as f64 - 0.5;
        (whole(x, grey.width) && whole(y, grey.height)).then_some(sphere)
    }

    /// Where the sphere is, its radius being that of the recording. An outline blurred by motion has one of its own, which
    /// counts where the outline is nearly whole.
    pub fn sighting(&self, frame: usize, outline: &Outline, shared: Shared) -> Option<Sighting> {
        /// How much wider a blurred step is.
        const BLURRED: f64 = 1.4;
        /// Part of an outline that holds a radius.
        const WHOLE: f64 = 0.6;
        let own = outline.edges.width > BLURRED * shared.width && outline.free.share > WHOLE;
        let circle = self.rays.fit(&outline.edges.points, (!own).then_some(shared.radius))?;
        let disc = circle.disc.about_centre_of(outline.about);
        Some(Sighting {
            frame,
            x_px: disc.x,
            y_px: disc.y,
            radius_px: outline.free.disc.radius,
            outline_share: circle.share,
            scatter_px: circle.scatter,
            blur_px: outline.edges.widest,
        })
    }
}

/// The outline of a disc of about this place and size.
fn outline(difference: &Difference, rays: &Rays, place: Disc) -> Option<Outline> {
    let mut about = place;
    let mut found: Option<Outline> = None;
    for reach in REACH {
        // of those that motion blurs most
        let widest = found.as_ref().map_or(0.0, |outline| outline.edges.widest);
        let reach = (reach * about.radius).max(REACH_OF_WIDTH * widest).max(LEAST_REACH);
        let edges = edges(difference, rays, about, reach.min(about.radius));
        let circle = rays.fit(&edges.points, None)?;
        let disc = circle.disc.about_centre_of(about);
        if disc.distance(place) > 0.7 * place.radius || (disc.radius / place.radius - 1.0).abs() > 0.3 {
            return None;
        }
        found = Some(Outline {
            about,
            edges,
            free: Circle { disc, ..circle },
            mirror_y: None,
        });
        if circle.disc.x.hypot(circle.disc.y) < STILL {
            break;
        }
        about = disc;
    }
    found
}

/// The sphere among discs of its size: the one that stands out most, or one straight above it, whose mirror image it is.
fn sphere_of(discs: Vec<Outline>, radius: f64) -> Option<Outline> {
    let clear = |outline: &Outline| f64::from(outline.edges.contrast) * outline.free.share;
    let clearest = discs.iter().max_by(|a, b| clear(a).total_cmp(&clear(b)))?;
    let in_line = |outline: &&Outline, with: Disc| (outline.free.disc.x - with.x).abs() < 0.25 * radius;
    let as_clear = clear(clearest);
    let clearest = clearest.free.disc;
    let above = discs.iter().filter(|outline| {
        in_line(outline, clearest) && clear(outline) > 0.4 * as_clear && outline.free.disc.y < clearest.y
    });
    let upper = above
        .map(|outline| outline.free.disc)
        .min_by(|a, b| a.y.total_cmp(&b.y));
    let sphere = upper.unwrap_or(clearest);
    let lower = discs.iter().filter(|outline| in_line(outline, sphere));
    let lower = lower
        .map(|outline| outline.free.disc.y)
        .filter(|y| *y > sphere.y + radius);
    let mirror_y = lower.min_by(f64::total_cmp);
    let found = discs.into_iter().find(|outline| outline.free.disc == sphere)?;
    Some(Outline { mirror_y, ..found })
}

/// Drops discs below the plate: where the sphere is out of view above, its mirror image may be in view.
pub(super) fn leave_mirror_images_out(outlines: &mut [Option<Outline>]) {
    /// Frames with both that show where the plate is.
    const FEWEST_PAIRS: usize = 5;
    let middles = || {
        let each = outlines.iter().flatten();
        each.filter_map(|outline| Some(0.5 * (outline.free.disc.y + outline.mirror_y?)))
    };
    if middles().count() < FEWEST_PAIRS {
        return;
    }
    let Some(plate) = median(middles()) else { return };
    let Some(spread) = median(middles().map(|middle| (middle - plate).abs())) else {
        return;
    };
    for place in outlines.iter_mut() {
        place.take_if(|outline| outline.free.disc.y > plate && spread < 0.25 * outline.free.disc.radius);
    }
}

/// What the outlines of a recording have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shared {
    /// px
    pub radius: f64,
    /// width of a step at an outline of the sharper half of them, px
    width: f64,
}

/// The radius that the recording's sharpest whole outlines have; `None` where there is no outline.
pub(super) fn shared(outlines: &[Option<Outline>]) -> Option<Shared> {
    let seen = || outlines.iter().flatten();
    let most = seen().map(|outline| outline.free.share).fold(0.0, f64::max);
    let whole = || seen().filter(|outline| outline.free.share > 0.9 * most);
    // motion widens an edge, and changes a radius with it
    let width = median(whole().map(|outline| outline.edges.width))?;
    let sharp = whole().filter(|outline| outline.edges.width <= width);
    let radius = median(sharp.map(|outline| outline.free.disc.radius))?;
    Some(Shared { radius, width })
}

/// The radius of the sphere, from frames of a sample: from every other one where it is seen often enough in these.
pub(super) fn radius(sample: &[Grey], background: &Background) -> Option<f64> {
    const OFTEN: usize = 6;
    let [some, others] = [0, 1].map(|first| sample.iter().skip(first).step_by(2).collect::<Vec<_>>());
    let mut radii = discs(&some, background);
    let often = largest(radii.clone()).is_some_and(|radius| {
        let alike = radii.iter().filter(|other| (*other / radius - 1.0).abs() < 1.0 - ALIKE);
        alike.count() >= OFTEN
    });
    if !often {
        radii.extend(discs(&others, background));
    }
    largest(radii)
}

/// How far radii of one sphere are from each other.
const ALIKE: f64 = 0.92;

/// The radius of the largest discs; a disc that a single frame shows counts only where none shows in two.
pub(super) fn largest(mut radii: Vec<f64>) -> Option<f64> {
    radii.sort_by(f64::total_cmp);
    let twice = radii
        .iter()
        .rev()
        .zip(radii.iter().rev().skip(1))
        .find(|(r, next)| **next > ALIKE * **r);
    let largest = twice.map(|(radius, _)| *radius).or(radii.last().copied())?;
    radii.retain(|radius| *radius > ALIKE * largest && *radius <= largest);
    median(radii.into_iter())
}

/// Radii of the discs that frames show, the two clearest a frame.
pub(super) fn discs(frames: &[&Grey], background: &Background) -> Vec<f64> {
    let lot = super::decode::at_once(frames.first().map_or(0, |grey| grey.levels.len()));
    let mut radii = vec![];
    for lot in frames.chunks(lot) {
        let each: Vec<Vec<f64>> = lot
            .par_iter()
            .map(|grey| {
                let difference = Difference::of(grey, background);
                // cells of half the size where no disc is found: a sphere may be small
                [8, 4, 2, 1]
                    .into_iter()
                    .map(|cell| discs_in(&difference, cell))
                    .find(|radii| !radii.is_empty())
                    .unwrap_or_default()
            })
            .collect();
        radii.extend(each.concat());
    }
    radii
}

fn discs_in(difference: &Difference, cell: usize) -> Vec<f64> {
    /// Radii from three cells on, each larger by so much.
    const FIRST: f64 = 3.0;
    const LARGER: f64 = 1.12;
    /// Part of an outline that votes.
    const LEAST_VOTES: f64 = 0.4;
    /// Part of an outline that is on one circle.
    const LEAST_SHARE: f64 = 0.6;
    let cells = EdgeCells::of(difference, cell);
    let most = 0.5 * difference.grey.width.min(difference.grey.height) as f64;
    let mut places: Vec<Place> = vec![];
    let mut radius = (FIRST * cell as f64).max(LEAST_RADIUS);
    while radius < most {
        places.extend(cells.places(radius, 2, LEAST_VOTES));
        radius *= LARGER;
    }
    // the longest outline first
    places.sort_by(|a, b| (b.share * b.disc.radius).total_cmp(&(a.share * a.disc.radius)));
    /// Places that are looked at.
    const MOST_PLACES: usize = 6;
    let found = places.into_iter().take(MOST_PLACES).filter_map(|place| {
        let Circle { disc, share, scatter } = outline(difference, &rays(place.disc.radius), place.disc)?.free;
        let good = share >= LEAST_SHARE && scatter < 0.1 * disc.radius;
        (good && disc.radius >= LEAST_RADIUS).then_some(disc.radius)
    });
    found.take(2).collect()
}

//! Finds the edge of a disc along rays from a provisional centre, to a part of a pixel.
//!
//! About the steepest place of a ray a step is fitted between the level outside and a straight line inside, which follows
//! a sphere's shading: the step stands where the light between both is as much as was measured. Whatever blurs an edge
//! evenly to both sides – optics, pixels, interpolation, motion during the exposure – moves no light and so not the step.

use super::background::{brightness, Background};
use super::circle::{median, Disc, EdgePoint, Rays};
use super::decode::Grey;

/// A frame less its background.
pub(super) struct Difference<'f> {
    pub grey: &'f Grey,
    pub background: &'f Background,
    /// what a level of the frame is in levels of the background
    gain: f32,
}

impl<'f> Difference<'f> {
    pub fn of(grey: &'f Grey, background: &'f Background) -> Difference<'f> {
        Difference {
            grey,
            background,
            gain: 1.0 / brightness(&grey.levels, &background.levels),
        }
    }

    /// A row of it, pixel by pixel.
    pub fn row(&self, y: usize) -> impl Iterator<Item = f32> + '_ {
        let range = y * self.grey.width..(y + 1) * self.grey.width;
        range.map(move |pixel| self.pixel(pixel))
    }

    fn pixel(&self, at: usize) -> f32 {
        f32::from(self.grey.levels[at]) * self.gain - self.background.levels[at]
    }

    /// Between pixels, whose centres are at integers; `None` outside.
    fn at(&self, x: f64, y: f64) -> Option<f32> {
        if !(x >= 0.0 && y >= 0.0) {
            return None;
        }
        let (left, top) = (x as usize, y as usize);
        if left + 1 >= self.grey.width || top + 1 >= self.grey.height {
            return None;
        }
        let (fx, fy) = ((x - left as f64) as f32, (y - top as f64) as f32);
        let between = |row: usize| {
            let first = row * self.grey.width + left;
            let (a, b) = (self.pixel(first), self.pixel(first + 1));
            a + (b - a) * fx
        };
        let (upper, lower) = (between(top), between(top + 1));
        Some(upper + (lower - upper) * fy)
    }
}

/// Edges along all rays from a centre.
pub(super) struct Edges {
    /// one a ray
    pub points: Vec<EdgePoint>,
    /// median step from outside to inside, in levels without sign
    pub contrast: f32,
    /// median width of the steps, px
    pub width: f64,
    /// largest width of the steps, px
    pub widest: f64,
}

/// Step of samples along a ray, px.
const STEP: f64 = 0.5;

/// The levels along all rays about where edges are looked for.
struct Profiles {
    /// distance of the first sample of a ray
    first: f64,
    /// samples of a ray
    samples: usize,
    /// ray by ray; not a number outside of the frame
    rays: Vec<Vec<f32>>,
}

impl Profiles {
    fn of(difference: &Difference, rays: &Rays, disc: Disc, reach: f64) -> Profiles {
        let first = (disc.radius - reach).max(STEP);
        let samples = ((disc.radius + reach - first) / STEP).max(0.0) as usize;
        let along = |(nx, ny): &(f64, f64)| {
            let level = |i: usize| {
                let distance = first + STEP * i as f64;
                let level = difference.at(disc.x + distance * nx, disc.y + distance * ny);
                level.unwrap_or(f32::NAN)
            };
            (0..samples).map(level).collect()
        };
        Profiles {
            first,
            samples,
            rays: rays.directions.iter().map(along).collect(),
        }
    }

    /// The width of the step on each ray, px: what the levels rise by, in their steepest slopes. It is taken of the mean of
    /// rays of about its direction and the opposite one, since motion blurs both alike.
    fn widths(&self, most: f64) -> Vec<f64> {
        /// Rays of a turn that are taken together, to each side.
        const SIDE: usize = 24;
        /// Width of an edge of pixels alone, px.
        const SHARP: f64 = 1.0;
        let rays = self.rays.len();
        let side = rays / SIDE;
        let mut mean = vec![0.0f32; self.samples];
        let mut width_of = |j: usize| {
            mean.fill(0.0);
            let mut count = 0.0;
            for k in 0..=2 * side {
                for opposite in [0, rays / 2] {
                    let ray = &self.rays[(j + rays + k - side + opposite) % rays];
                    if ray.iter().all(|level| level.is_finite()) {
                        count += 1.0;
                        mean.iter_mut().zip(ray).for_each(|(sum, level)| *sum += level);
                    }
                }
            }
            if count == 0.0 {
                return SHARP;
            }
            let slopes = mean.windows(5).map(|w| match w {
                [a, b, _, c, d] => ((c + d - a - b) / (6.0 * STEP as f32)).abs(),
                _ => 0.0,
            });
            let steepest = slopes.fold(0.0, f32::max);
            let end = (self.samples / 6).max(1);
            let outside = mean.iter().rev().take(end).sum::<f32>() / end as f32;
            let inside = mean.iter().take(end).sum::<f32>() / end as f32;
            let width = f64::from((inside - outside).abs() / steepest);
            if width.is_finite() {
                width.clamp(SHARP, most.max(SHARP))
            } else {
                SHARP
            }
        };
        (0..rays).map(&mut width_of).collect()
    }

    /// Where levels on both sides, over half of a step's width, differ most on a ray; `None` where by noise only.
    fn steepest(&self, ray: usize, width: f64, noise: f32) -> Option<f64> {
        let levels = &self.rays[ray];
        let half = ((0.7 * width / STEP) as usize).max(2);
        if levels.len() < 2 * half {
            return None;
        }
        let mut sums = Vec::with_capacity(levels.len() + 1);
        let mut sum = 0.0;
        sums.push(sum);
        sums.extend(levels.iter().map(|level| {
            sum += level;
            sum
        }));
        let near = sums.iter().zip(sums.iter().skip(half)).zip(sums.iter().skip(2 * half));
        let steps = near.map(|((a, b), c)| (c - 2.0 * b + a).abs() / half as f32);
        let finite = steps.enumerate().filter(|(_, step)| step.is_finite());
        let (at, step) = finite.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (step > 2.0 * noise).then_some(self.first + STEP * ((at + half) as f64 - 0.5))
    }
}

/// The edges of a disc of about this place and size, looked for within a reach to both sides of its outline, px. Edges of much less contrast than the others have little weight.
pub(super) fn edges(difference: &Difference, rays: &Rays, disc: Disc, reach: f64) -> Edges {
    let profiles = Profiles::of(difference, rays, disc, reach);
    let widths = profiles.widths(disc.radius);
    let found: Vec<Option<(f64, f32)>> = rays
        .directions
        .iter()
        .zip(&widths)
        .enumerate()
        .map(|(ray, (direction, width))| {
            let about = profiles.steepest(ray, *width, difference.background.noise)?;
            // wider for a blur: its middle is found from farther away
            let half = (0.6 * width + 0.3 + 0.25 * (width - 3.0).max(0.0)).min(0.8 * disc.radius);
            // from a place that is found better the second time
            let (distance, _) = stand(difference, disc, *direction, about, half)?;
            stand(difference, disc, *direction, distance, half)
        })
        .collect();
    let steps = || found.iter().flatten().map(|(_, step)| f64::from(step.abs()));
    let contrast = median(steps()).unwrap_or(0.0) as f32;
    let least = 4.0 * difference.background.noise;
    let points = found.iter().zip(&widths).map(|(found, width)| match found {
        Some((distance, step)) if step.abs() > least => {
            let share = (step / contrast).abs().min(1.0);
            EdgePoint {
                distance: *distance as f32,
                weight: share * share,
                // the wider a step, the worse is its place known
                scale: (0.4 * (1.0 + width)).max(1.0) as f32,
            }
        }
        _ => EdgePoint::NONE,
    });
    Edges {
        points: points.collect(),
        contrast,
        width: median(widths.iter().copied()).unwrap_or(0.0),
        widest: widths.iter().copied().fold(0.0, f64::max),
    }
}

/// Where the step about a place stands, and its height from outside to inside; `None` where it is not within `half` px of
/// that place.
fn stand(difference: &Difference, disc: Disc, (nx, ny): (f64, f64), about: f64, half: f64) -> Option<(f64, f32)> {
    let level = |t: f64| difference.at(disc.x + (about + t) * nx, disc.y + (about + t) * ny);
    // a whole number of samples over the step, so that its light is the trapezoidal sum
    let over = (2.0 * half / STEP).round().max(2.0);
    let half = 0.5 * over * STEP;
    let mut light = 0.0;
    for i in 0..=over as usize {
        let part = if i == 0 || i == over as usize { 0.5 } else { 1.0 };
        light += part * STEP * f64::from(level(STEP * i as f64 - half)?);
    }
    // no more of the shading than the levels need: farther in, another side of the light may begin
    let samples = (half.min(0.2 * disc.radius).max(1.5) / STEP) as usize;
    let (mut outside, mut n, mut t1, mut t2, mut f0, mut f1) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for i in 0..=samples {
        let from = half + STEP * i as f64;
        outside += f64::from(level(from)?);
        if about - from < STEP {
            return None;
        }
        let inside = f64::from(level(-from)?);
        let limb = limb(from / about);
        n += 1.0;
        t1 += limb;
        t2 += limb * limb;
        f0 += inside;
        f1 += limb * inside;
    }
    outside /= n;
    let shading = (n * f1 - t1 * f0) / (n * t2 - t1 * t1);
    let inside = (f0 - shading * t1) / n;
    // light of a step at u, with its shading
    let mut u = 0.0;
    for _ in 0..6 {
        let shaded = about * limb_light((half + u) / about);
        let excess = inside * (u + half) + shading * shaded + outside * (half - u) - light;
        u -= excess / (inside - outside + shading * limb((half + u) / about));
        if u.is_nan() || u.abs() > half {
            return None;
        }
    }
    Some((about + u, (inside - outside) as f32))
}

/// How much of its side a ball turns to the camera so far within its outline, in radii.
fn limb(within: f64) -> f64 {
    (within * (2.0 - within)).max(0.0).sqrt()
}

/// The integral of [`limb`] from the outline to within it, to its second term in the square of the distance.
fn limb_light(within: f64) -> f64 {
    (2.0 * within).max(0.0).sqrt() * within * (2.0 / 3.0 - 0.1 * within)
}

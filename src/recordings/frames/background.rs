//! Finds what the camera sees where no sphere is, from a bounded sample of the frames.
//!
//! A pixel that shows two lasting levels was covered by a sphere at rest for a part of the recording, be it a small or a
//! large one, at its beginning or at its end. Such pixels are joined to regions that changed at the same time, and of the
//! two pictures of a region that one is the background which continues its surroundings: the other has the outline of a
//! sphere along the region's edge.

use rayon::prelude::*;

use super::decode::Grey;
use super::regions::{self, TwoLevels};

/// Most frames of a sample; they are counted in the bits of a word.
const MOST_SAMPLES: usize = 48;
/// Fewest frames of a sample, where frames are large.
const FEWEST_SAMPLES: usize = 8;
/// Pixels of a sample, of two bytes each.
const SAMPLE_PIXELS: usize = 1 << 26;

/// Points at which brightness and noise are compared.
const POINTS: usize = 4096;

/// The picture without a sphere, and what a pixel of it varies by.
pub(super) struct Background {
    pub levels: Vec<f32>,
    /// sd of a pixel from frame to frame, in the same levels
    pub noise: f32,
    /// what a grey level of the file is
    pub unit: u16,
}

/// Frames to take for a sample, evenly over the recording with its first and its last.
pub(super) fn sample_frames(frames: usize, pixels: usize) -> Vec<usize> {
    let most = (SAMPLE_PIXELS / pixels.max(1)).clamp(FEWEST_SAMPLES, MOST_SAMPLES);
    let count = most.min(frames);
    let step = |k: usize| k * (frames - 1) / (count - 1).max(1);
    (0..count).map(step).collect()
}

impl Background {
    /// Of frames of one size, of which there is at least one.
    pub fn of(sample: &[Grey]) -> Option<Background> {
        let first = sample.first()?;
        let (width, height, unit) = (first.width, first.height, first.unit);
        let reference: Vec<f32> = first.levels.iter().map(|level| f32::from(*level)).collect();
        let gains: Vec<f32> = sample
            .par_iter()
            .map(|grey| 1.0 / brightness(&grey.levels, &reference))
            .collect();
        let noise = noise(sample, &gains).max(f32::from(unit) * QUANTISATION);
        let (rows, changed): (Vec<Vec<f32>>, Vec<Vec<TwoLevels>>) = (0..height)
            .into_par_iter()
            .map(|y| {
                let mut series = vec![0.0; sample.len()];
                let mut sorted = series.clone();
                let (mut row, mut changed) = (Vec::with_capacity(width), vec![]);
                for pixel in y * width..(y + 1) * width {
                    for ((value, grey), gain) in series.iter_mut().zip(sample).zip(&gains) {
                        *value = f32::from(grey.levels[pixel]) * gain;
                    }
                    let (level, other) = lasting_levels(&series, &mut sorted, noise);
                    row.push(level);
                    changed.extend(other.map(|other| TwoLevels::new(pixel, level, other, &series, noise)));
                }
                (row, changed)
            })
            .unzip();
        let mut levels = rows.concat();
        for (pixel, times) in regions::settle(&levels, width, &changed.concat()) {
            let frames = sample.iter().zip(&gains).enumerate();
            let shown = frames.filter(|(k, _)| times >> k & 1 == 1);
            let series = shown.map(|(_, (grey, gain))| f32::from(grey.levels[pixel]) * gain);
            let mut series: Vec<f32> = series.collect();
            if !series.is_empty() {
                levels[pixel] = trimmed_mean(&mut series);
            }
        }
        Some(Background { levels, noise, unit })
    }
}

/// sd of what rounding to a grey level adds.
const QUANTISATION: f32 = 0.29;

/// The ratio of two pictures that most of their bright points agree in.
pub(super) fn brightness(levels: &[u16], reference: &[f32]) -> f32 {
    // a prime stride meets every column
    let stride = prime_stride(levels.len());
    let mut bright: Vec<f32> = reference.iter().step_by(stride).copied().collect();
    let count = bright.len();
    let high = kth(&mut bright, count * 9 / 10);
    /// Levels of 65,536 below which a ratio is noise.
    const DARK: f32 = 2_000.0;
    if high < DARK {
        return 1.0;
    }
    let points = levels.iter().zip(reference).step_by(stride);
    let lit = points.filter(|(_, reference)| **reference > 0.5 * high);
    let mut ratios: Vec<f32> = lit.map(|(level, reference)| f32::from(*level) / reference).collect();
    let ratio = trimmed_mean(&mut ratios);
    if ratio > 0.0 {
        ratio
    } else {
        1.0
    }
}

/// The mean of those within three robust sd of the median: rounded levels make the median itself coarse.
fn trimmed_mean(values: &mut [f32]) -> f32 {
    let median = upper_median(values);
    let mut away: Vec<f32> = values.iter().map(|value| (value - median).abs()).collect();
    let within = 3.0 * 1.4826 * upper_median(&mut away) + f32::EPSILON;
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values.iter().filter(|value| (**value - median).abs() <= within) {
        sum += value;
        count += 1.0;
    }
    if count > 0.0 {
        sum / count
    } else {
        median
    }
}

/// The k-th smallest, 0 of none.
fn kth(values: &mut [f32], k: usize) -> f32 {
    if k >= values.len() {
        return 0.0;
    }
    *values.select_nth_unstable_by(k, f32::total_cmp).1
}

fn upper_median(values: &mut [f32]) -> f32 {
    kth(values, values.len() / 2)
}

fn prime_stride(pixels: usize) -> usize {
    const PRIMES: [usize; 13] = [1, 3, 7, 17, 37, 79, 163, 331, 673, 1361, 2729, 5471, 10_949];
    let wanted = pixels / POINTS;
    PRIMES.into_iter().rev().find(|prime| *prime <= wanted).unwrap_or(1)
}

/// The sd of a pixel between frames that follow each other in the sample: most pixels are of what stands still.
fn noise(sample: &[Grey], gains: &[f32]) -> f32 {
    let mut each: Vec<f32> = sample
        .windows(2)
        .zip(gains.windows(2))
        .map(|(pair, gains)| {
            let stride = prime_stride(pair[0].levels.len());
            let levels = pair[0].levels.iter().zip(&pair[1].levels).step_by(stride);
            let away = levels.map(|(a, b)| (f32::from(*a) * gains[0] - f32::from(*b) * gains[1]).abs());
            1.4826 * upper_median(&mut away.collect::<Vec<f32>>()) / std::f32::consts::SQRT_2
        })
        .collect();
    upper_median(&mut each)
}

/// The level that a pixel shows most often, and a second one that lasts as well, if any.
fn lasting_levels(series: &[f32], sorted: &mut [f32], noise: f32) -> (f32, Option<f32>) {
    /// Noise within which a pixel that stands still stays.
    const STILL: f32 = 7.0;
    /// Noise that the levels of one state span.
    const SPAN: f32 = 7.0;
    /// A part of the sample in which a state lasts.
    const LASTS: f32 = 0.08;
    let (mut low, mut high, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0);
    for value in series {
        low = low.min(*value);
        high = high.max(*value);
        sum += value;
    }
    if high - low <= STILL * noise {
        return (sum / series.len() as f32, None);
    }
    sorted.copy_from_slice(series);
    sorted.sort_unstable_by(f32::total_cmp);
    let (start, end) = densest(sorted, SPAN * noise);
    let first = mean(&sorted[start..end]);
    // what stands beside the first state belongs to neither
    let below = sorted.iter().take_while(|value| **value < first - SPAN * noise).count();
    let above = sorted
        .iter()
        .take_while(|value| **value <= first + SPAN * noise)
        .count();
    let others = [&sorted[..below], &sorted[above..]].map(|part| {
        let (start, end) = densest(part, SPAN * noise);
        &part[start..end]
    });
    let second = others.into_iter().max_by_key(|levels| levels.len());
    let lasting = (LASTS * series.len() as f32).max(2.0);
    let second = second.filter(|levels| levels.len() as f32 >= lasting);
    (first, second.map(mean))
}

/// Where most of sorted values stand within a span.
fn densest(sorted: &[f32], span: f32) -> (usize, usize) {
    let (mut best, mut end) = ((0, 0), 0);
    for (start, from) in sorted.iter().enumerate() {
        while sorted.get(end).is_some_and(|value| *value <= from + span) {
            end += 1;
        }
        if end - start > best.1 - best.0 {
            best = (start, end);
        }
    }
    best
}

fn mean(values: &[f32]) -> f32 {
    values.iter().sum::<f32>() / values.len() as f32
}

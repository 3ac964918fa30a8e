//! Holds where a sphere was, frame by frame, and how far its positions scatter.

use crate::distributions::{median, SD_OF_MEDIAN_DISTANCE};

/// Heights of a sphere over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Track {
    /// when each position was seen, in s; rising
    pub times: Vec<f64>,
    /// upwards, of any point of the sphere; in m, or in pixels where no scale is known yet
    pub heights: Vec<f64>,
}

impl Track {
    /// Seconds from frame to frame, by the median; 0 of fewer than two.
    pub fn frame_time(&self) -> f64 {
        let mut gaps: Vec<f64> = self.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        median(&mut gaps).unwrap_or(0.0)
    }

    /// The time and the height of some frames.
    pub(super) fn points(&self, frames: &[usize]) -> Vec<(f64, f64)> {
        let point = |frame: &usize| (self.times[*frame], self.heights[*frame]);
        frames.iter().map(point).collect()
    }

    /// The same in another unit of length.
    pub fn over(&self, scale: f64) -> Track {
        Track {
            times: self.times.clone(),
            heights: self.heights.iter().map(|height| height / scale).collect(),
        }
    }

    /// The standard deviation of a position, robustly: third differences of evenly spaced frames vanish along parabolas.
    ///
    /// Not below what rounding to a grid leaves; `None` without four frames in a row, and of what does not move.
    pub fn noise(&self) -> Option<f64> {
        /// frames are one after the other where their gaps are so equal
        const EVEN: f64 = 0.01;
        /// of heights in m or in pixels: far below what any camera tells
        const LEAST_RANGE: f64 = 1e-15;
        /// fours of such frames that tell the scatter
        const ENOUGH: usize = 8;
        // 1² + 3² + 3² + 1²
        let of_differences = 20f64.sqrt();
        let frame = self.frame_time();
        let in_a_row = |times: &[f64]| {
            let gaps = times.windows(2).map(|pair| pair[1] - pair[0]);
            gaps.into_iter().all(|gap| (gap - frame).abs() <= EVEN * frame)
        };
        let fours = self.times.windows(4).zip(self.heights.windows(4));
        let [lowest, highest] = self.ends_of_heights();
        if highest - lowest < LEAST_RANGE {
            return None;
        }
        let fours: Vec<&[f64]> = fours.filter(|(times, _)| in_a_row(times)).map(|(_, y)| y).collect();
        // pictures of a video hardly change while the sphere rests: its flights scatter by more
        let least = self.least_move();
        let moves = |y: &&&[f64]| (y[3] - y[0]).abs() > least;
        let moving = fours.iter().filter(moves).count() >= ENOUGH;
        let mut differences: Vec<f64> = fours
            .iter()
            .filter(|y| !moving || moves(y))
            .map(|y| (y[3] - 3.0 * y[2] + 3.0 * y[1] - y[0]).abs())
            .collect();
        let scatter = SD_OF_MEDIAN_DISTANCE * median(&mut differences)? / of_differences;
        Some(scatter.max(self.rounding()))
    }

    /// The height by which three frames move a sphere that does not rest, at least.
    pub(super) fn least_move(&self) -> f64 {
        /// of the range of heights
        const MOVES: f64 = 0.01;
        let [lowest, highest] = self.ends_of_heights();
        MOVES * (highest - lowest)
    }

    /// The lowest and the highest height.
    pub(super) fn ends_of_heights(&self) -> [f64; 2] {
        ends_of(self.heights.iter().copied())
    }

    /// The lowest and the highest height of some frames.
    pub(super) fn ends_within<'f>(&self, frames: impl IntoIterator<Item = &'f usize>) -> [f64; 2] {
        ends_of(frames.into_iter().map(|frame| self.heights[*frame]))
    }

    /// What a grid that all heights stand on makes them scatter by; next to nothing where they stand on none.
    pub(super) fn rounding(&self) -> f64 {
        /// of the range of heights: far below what any camera tells
        const LEAST: f64 = 1e-9;
        let mut heights = self.heights.clone();
        heights.sort_by(f64::total_cmp);
        let [lowest, highest] = self.ends_of_heights();
        let range = highest - lowest;
        let steps = heights.windows(2).map(|pair| pair[1] - pair[0]);
        let grid = steps.filter(|step| *step > LEAST * range).fold(f64::INFINITY, f64::min);
        let grid = if grid.is_finite() { grid } else { 0.0 };
        (grid / 12f64.sqrt()).max(LEAST * range)
    }
}

fn ends_of(heights: impl Iterator<Item = f64>) -> [f64; 2] {
    heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[lowest, highest], height| {
        [lowest.min(height), highest.max(height)]
    })
}

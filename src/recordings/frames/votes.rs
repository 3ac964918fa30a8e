//! Finds where discs may be in a frame: each edge pixel votes for the two centres a radius away along its slope.

use super::circle::Disc;
use super::edge::Difference;

/// Edge pixels that vote at most; a frame with more shows no sphere on a still background.
const MOST_VOTERS: usize = 20_000;

/// An edge pixel and the direction of its slope.
struct Voter {
    x: f32,
    y: f32,
    nx: f32,
    ny: f32,
}

/// The edges of a frame less its background, in cells of so many pixels.
pub(super) struct EdgeCells {
    cell: usize,
    width: usize,
    height: usize,
    voters: Vec<Voter>,
}

/// A place that is voted for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub disc: Disc,
    /// votes, of those that a whole outline has
    pub share: f64,
}

impl EdgeCells {
    pub fn of(difference: &Difference, cell: usize) -> EdgeCells {
        let (width, height) = (difference.grey.width / cell, difference.grey.height / cell);
        let mut means = vec![0.0f32; width * height];
        for (row, line) in means.chunks_exact_mut(width.max(1)).enumerate() {
            for y in row * cell..(row + 1) * cell {
                let mut levels = difference.row(y);
                for sum in line.iter_mut() {
                    *sum += levels.by_ref().take(cell).sum::<f32>();
                }
            }
        }
        let part = 1.0 / (cell * cell) as f32;
        means.iter_mut().for_each(|sum| *sum *= part);
        let voters = voters(&means, width, height, difference.background.noise / cell as f32);
        EdgeCells {
            cell,
            width,
            height,
            voters,
        }
    }

    /// The places with most votes for a radius, px, the first the most; none that stands in another.
    pub fn places(&self, radius: f64, most: usize, least_share: f64) -> Vec<Place> {
        let of_cells = (radius / self.cell as f64) as f32;
        let mut sums = self.tally(of_cells);
        let outline = std::f64::consts::TAU * f64::from(of_cells);
        let mut places: Vec<Place> = vec![];
        while places.len() < most {
            let Some((at, votes)) = sums.iter().enumerate().max_by(|a, b| a.1.cmp(b.1).then(b.0.cmp(&a.0))) else {
                break;
            };
            let share = f64::from(*votes) / outline;
            if share < least_share {
                break;
            }
            let (column, row) = (at % self.width, at / self.width);
            let centre = |cells: usize| (cells as f64 + 0.5) * self.cell as f64 - 0.5;
            let (x, y) = (centre(column), centre(row));
            places.push(Place {
                disc: Disc { x, y, radius },
                share,
            });
            let around = (0.6 * of_cells) as usize + 1;
            for y in row.saturating_sub(around)..(row + around + 1).min(self.height) {
                let line = y * self.width;
                let ends = (column.saturating_sub(around), (column + around + 1).min(self.width));
                sums[line + ends.0..line + ends.1].fill(0);
            }
        }
        places
    }

    /// Votes for a radius, summed over three cells each way.
    fn tally(&self, radius: f32) -> Vec<u16> {
        let (width, height) = (self.width, self.height);
        let mut votes = vec![0u16; width * height];
        for voter in &self.voters {
            for side in [-radius, radius] {
                let (x, y) = (voter.x + side * voter.nx, voter.y + side * voter.ny);
                if !(x > -0.5 && y > -0.5) {
                    continue;
                }
                let (x, y) = ((x + 0.5) as usize, (y + 0.5) as usize);
                if x < width && y < height {
                    votes[y * width + x] += 1;
                }
            }
        }
        let mut sums = vec![0u16; width * height];
        if width < 3 || height < 3 {
            return sums;
        }
        for y in 1..height - 1 {
            let into = &mut sums[y * width + 1..(y + 1) * width - 1];
            for (into, [above, line, below]) in into.iter_mut().zip(about(&votes, width, y)) {
                *into = above.iter().chain(line).chain(below).sum();
            }
        }
        sums
    }
}

/// The three by three cells about each inner cell of a row that is neither the first nor the last.
fn about<T>(cells: &[T], width: usize, y: usize) -> impl Iterator<Item = [&[T]; 3]> {
    let row = |y: usize| cells[y * width..(y + 1) * width].windows(3);
    let rows = row(y - 1).zip(row(y)).zip(row(y + 1));
    rows.map(|((above, line), below)| [above, line, below])
}

/// Cells that are steeper than those beside them along their slope, by more than noise.
fn voters(means: &[f32], width: usize, height: usize, noise: f32) -> Vec<Voter> {
    /// sd of a slope of Sobel's, in sd of a cell.
    const OF_NOISE: f32 = 0.43;
    /// Such sd that a slope must have to be an edge.
    const EDGE: f32 = 6.0;
    if width < 3 || height < 3 {
        return vec![];
    }
    let mut slopes = vec![(0.0f32, 0.0f32); width * height];
    for y in 1..height - 1 {
        let into = &mut slopes[y * width + 1..(y + 1) * width - 1];
        for (into, rows) in into.iter_mut().zip(about(means, width, y)) {
            let [[a, b, c], [d, _, e], [f, g, h]] = rows else {
                continue;
            };
            let x = (c + 2.0 * e + h - a - 2.0 * d - f) / 8.0;
            let y = (f + 2.0 * g + h - a - 2.0 * b - c) / 8.0;
            *into = (x, y);
        }
    }
    let least = (EDGE * OF_NOISE * noise).powi(2);
    let steepness = |at: usize| slopes.get(at).map_or(0.0, |(x, y)| x * x + y * y);
    let mut voters = vec![];
    for (at, (x, y)) in slopes.iter().enumerate() {
        let own = x * x + y * y;
        if own < least {
            continue;
        }
        // the neighbours along the slope, of four directions
        let step = if x.abs() > 2.4 * y.abs() {
            1
        } else if y.abs() > 2.4 * x.abs() {
            width
        } else if x * y > 0.0 {
            width + 1
        } else {
            width - 1
        };
        if own < steepness(at.wrapping_sub(step)) || own <= steepness(at + step) {
            continue;
        }
        let length = own.sqrt();
        voters.push(Voter {
            x: (at % width) as f32,
            y: (at / width) as f32,
            nx: x / length,
            ny: y / length,
        });
    }
    if voters.len() > MOST_VOTERS {
        let every = voters.len().div_ceil(MOST_VOTERS);
        return voters.into_iter().step_by(every).collect();
    }
    voters
}

//! Compares columns that tell the same thing of a run: over a whole table, and in each block of it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::places::NamedRows;
use super::raw_row::{fall, RawRow};
use super::read_run::RowSetting;
use crate::physics::numbers::free_fall_speed;
use crate::scene::RunColumn;

/// Columns of which the first is read only where the second has nothing.
pub(super) const TOLD_TWICE: [[RunColumn; 2]; 4] = [
    [RunColumn::DropHeight, RunColumn::ImpactSpeed],
    [RunColumn::Stokes, RunColumn::ImpactSpeed],
    [RunColumn::Stokes, RunColumn::DropHeight],
    [RunColumn::ReboundHeight, RunColumn::ReboundSpeed],
];

/// Of each of [`TOLD_TWICE`] the speed by the first column over that by the second, if a run has both.
pub(super) type SpeedRatios = [Option<f64>; TOLD_TWICE.len()];

/// A run whose speeds by two columns lie further apart than this share is named.
const APART: f64 = 0.1;

/// By how much the logarithm of what a column gives, a speed or a restitution, may be off by the last digit that is written
/// there, where `rounding` gives half of that as a share of its number.
pub(super) fn rounding_of_log(raw: &RawRow, column: RunColumn, rounding: impl Fn(RunColumn) -> f64) -> f64 {
    /// half of the last digit of a height and of a speed that is read to the fewest digits, m and m/s: beyond, zeros are not
    /// written
    const COARSEST: [f64; 2] = [0.005, 0.05];
    let at_most = |coarsest: f64| raw[column].map_or(0.0, |value| rounding(column).min(coarsest / value));
    let (share, power) = match column {
        // v grows as √h
        RunColumn::DropHeight | RunColumn::ReboundHeight => (at_most(COARSEST[0]), 0.5),
        RunColumn::ImpactSpeed | RunColumn::ReboundSpeed => (at_most(COARSEST[1]), 1.0),
        _ => (rounding(column), 1.0),
    };
    -power * (-share).ln_1p()
}

/// Those of a run; 1 where rounding explains what they are.
pub(super) fn speed_ratios(
    raw: &RawRow,
    surface: f64,
    of_stokes: Option<f64>,
    rounding: impl Fn(RunColumn) -> f64,
) -> SpeedRatios {
    let speed = |column: RunColumn| match column {
        RunColumn::DropHeight | RunColumn::ReboundHeight => Some(free_fall_speed(fall(raw[column]?, surface)?)),
        RunColumn::Stokes => Some(raw[column]? * of_stokes?),
        _ => raw[column],
    };
    TOLD_TWICE.map(|[one, other]| {
        // a Stokes number is held against the speed itself
        if other == RunColumn::DropHeight && raw[RunColumn::ImpactSpeed].is_some() {
            return None;
        }
        let ratio = Some(speed(one)? / speed(other)?).filter(|ratio| *ratio > 0.0 && ratio.is_finite())?;
        let by_rounding: f64 = [one, other]
            .map(|column| rounding_of_log(raw, column, &rounding))
            .iter()
            .sum();
        Some(if ratio.ln().abs() <= by_rounding { 1.0 } else { ratio })
    })
}

/// How the speeds of two columns compare over a table.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Comparison {
    /// runs by the class of the logarithm of their ratio
    classes: BTreeMap<i32, usize>,
    /// the rows that lie apart, with their ratio
    apart: NamedRows<f64>,
    /// its blocks in order; empty where there are too many
    blocks: Vec<Block>,
    has_too_many_blocks: bool,
    /// the first and the last row; `None` without any
    rows: Option<[u32; 2]>,
}

/// Rows one after the other of one setting, in which the ratio does not jump.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Block {
    ends: [BlockRow; 2],
    runs: i64,
    /// of the logarithm of the ratio in whole [`Block::STEP`]: sums that do not go by the order of adding
    sum: i64,
    squares: i64,
}

/// A row at an end of a block.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct BlockRow {
    row: u32,
    setting: RowSetting,
    /// logarithm of its ratio, in whole [`Block::STEP`]
    ratio: i64,
}

impl Block {
    const STEP: f64 = 1e-4;

    fn of(row: BlockRow) -> Block {
        Block {
            ends: [row; 2],
            runs: 1,
            sum: row.ratio,
            squares: row.ratio * row.ratio,
        }
    }

    /// Whether a later block is this one going on.
    fn goes_on_with(&self, next: &Block) -> bool {
        let [last, first] = [self.ends[1], next.ends[0]];
        let jump = (last.ratio - first.ratio).abs() as f64 * Block::STEP;
        jump <= APART && last.setting.is_like(&first.setting)
    }

    fn extend(&mut self, next: &Block) {
        self.ends[1] = next.ends[1];
        self.runs += next.runs;
        self.sum += next.sum;
        self.squares = self.squares.saturating_add(next.squares);
    }

    /// Mean logarithm of the ratio.
    fn mean(&self) -> f64 {
        self.sum as f64 / self.runs as f64 * Block::STEP
    }

    /// Squares of the logarithms about their mean.
    fn squares_about_mean(&self) -> f64 {
        let about = self.squares as f64 - (self.sum as f64).powi(2) / self.runs as f64;
        about.max(0.0) * Block::STEP * Block::STEP
    }
}

impl Comparison {
    /// Width of a class.
    const STEP: f64 = 0.005;

    /// Blocks that are kept: a table has more only where its rows are in no order, and single rows are then named.
    const MOST_BLOCKS: usize = 50_000;

    pub fn add(&mut self, row: u32, setting: RowSetting, ratio: f64) {
        // beyond every magnitude of a file
        const MOST: f64 = 400.0;
        self.rows.get_or_insert([row; 2])[1] = row;
        let class = (ratio.ln() / Comparison::STEP).round() as i32;
        *self.classes.entry(class).or_default() += 1;
        if ratio.ln().abs() > APART {
            self.apart.push(row, ratio);
        }
        let ratio = (ratio.ln().clamp(-MOST, MOST) / Block::STEP).round() as i64;
        if self.has_too_many_blocks {
            return;
        }
        let next = Block::of(BlockRow { row, setting, ratio });
        match self.blocks.last_mut() {
            Some(last) if last.goes_on_with(&next) => last.extend(&next),
            _ => self.blocks.push(next),
        }
        if self.blocks.len() > Comparison::MOST_BLOCKS {
            self.has_too_many_blocks = true;
            self.blocks = vec![];
        }
    }

    /// Of the columns that were compared, by the names that the table has for them; `None` where no run has both. The rows
    /// of the table stand after so many of others.
    pub fn of(&self, columns: [RunColumn; 2], names: [String; 2], rows_before: u32) -> Option<ComparedColumns> {
        let moved = |row: u32| row.saturating_add(rows_before);
        let blocks = self.blocks_apart().into_iter().map(|block| ComparedBlock {
            rows: block.rows.map(moved),
            ..block
        });
        let apart = self.apart.first.iter().map(|(row, ratio)| (moved(*row), *ratio));
        let is_above = |class: i32| f64::from(class) * Comparison::STEP > APART;
        let above = self.classes.iter().filter(|(class, _)| is_above(**class));
        let above: usize = above.map(|(_, runs)| runs).sum();
        Some(ComparedColumns {
            columns,
            names,
            runs: self.classes.values().sum(),
            rows: self.rows?.map(moved),
            ratio: self.quantile(0.5)?,
            ends: [self.quantile(0.1)?, self.quantile(0.9)?],
            apart: apart.collect(),
            all_apart: self.apart.count,
            on_one_side: above.max(self.apart.count.saturating_sub(above)),
            blocks: blocks.collect(),
        })
    }

    /// The ratio below which such a share of the runs lies; `None` without any.
    fn quantile(&self, share: f64) -> Option<f64> {
        let runs: usize = self.classes.values().sum();
        let mut before = 0;
        let class = self.classes.iter().find(|(_, own)| {
            before += **own;
            before as f64 > share * runs as f64
        });
        Some((f64::from(*class?.0) * Comparison::STEP).exp())
    }

    /// The blocks that lie apart beyond the scatter inside blocks, those that follow each other with one ratio as one.
    fn blocks_apart(&self) -> Vec<ComparedBlock> {
        /// runs of a block, at least
        const FEWEST: i64 = 3;
        /// beyond what falling through air may take
        const BEYOND: f64 = 0.05;
        /// and beyond so many standard errors of the mean of a block
        const STANDARD_ERRORS: f64 = 4.0;
        /// smallest scatter that is believed
        const LEAST_SCATTER: f64 = 0.003;
        let squares: f64 = self.blocks.iter().map(Block::squares_about_mean).sum();
        let freedom: i64 = self.blocks.iter().map(|block| block.runs - 1).sum();
        let sd = (squares / freedom.max(1) as f64).sqrt().max(LEAST_SCATTER);
        let is_apart = |block: &Block| {
            let se = sd / (block.runs as f64).sqrt();
            block.runs >= FEWEST && block.mean().abs() > BEYOND + STANDARD_ERRORS * se
        };
        let mut apart: Vec<(usize, Block)> = vec![];
        for (at, block) in self.blocks.iter().enumerate().filter(|(_, block)| is_apart(block)) {
            match apart.last_mut() {
                Some((last, joined)) if *last + 1 == at && (joined.mean() - block.mean()).abs() <= APART => {
                    *last = at;
                    joined.extend(block);
                }
                _ => apart.push((at, *block)),
            }
        }
        let compared = |(_, block): (usize, Block)| ComparedBlock {
            rows: block.ends.map(|end| end.row),
            runs: block.runs as usize,
            ratio: block.mean().exp(),
        };
        apart.into_iter().map(compared).collect()
    }
}

/// Two columns of a table that tell the same thing.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedColumns {
    /// which they are; the second is read
    pub columns: [RunColumn; 2],
    /// what the table calls them
    pub names: [String; 2],
    /// runs that have both
    pub runs: usize,
    /// the first and the last row of these, counted over all tables
    pub rows: [u32; 2],
    /// median over these runs of the speed by the first over the speed by the second; of film ratios, of that of the column
    /// over δ/D
    pub ratio: f64,
    /// 10 % and 90 % quantiles of the same
    pub ends: [f64; 2],
    /// the first rows whose speeds lie more than a tenth apart, with their ratio
    pub apart: Vec<(u32, f64)>,
    /// how many such rows there are
    pub all_apart: usize,
    /// about how many of these lie on the side of most of them
    pub on_one_side: usize,
    /// blocks of rows that lie apart as a whole
    pub blocks: Vec<ComparedBlock>,
}

/// Rows one after the other in which two columns lie apart.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedBlock {
    /// the first and the last, counted over all tables
    pub rows: [u32; 2],
    /// runs in it that have both columns
    pub runs: usize,
    /// geometric mean of the ratio over these runs
    pub ratio: f64,
}

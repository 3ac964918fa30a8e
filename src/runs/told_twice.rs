//! Compares columns that tell the same thing of a run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::raw_row::{RawRow, StokesScale, Surface};
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

/// Rows that are named.
const NAMED: usize = 5;

/// Those of a run.
pub(super) fn speed_ratios(raw: &RawRow, surface: &Surface, of_stokes: &StokesScale) -> SpeedRatios {
    let by_height = |height: Option<f64>| Some(free_fall_speed(surface.fall(height?)?));
    let by_stokes = match of_stokes {
        StokesScale::Known(scale) => raw.stokes.map(|stokes| stokes * scale),
        _ => None,
    };
    let dropped = by_height(raw.drop_height);
    let ratio = |one: Option<f64>, other: Option<f64>| {
        let ratio = one? / other?;
        (ratio > 0.0 && ratio.is_finite()).then_some(ratio)
    };
    [
        ratio(dropped, raw.impact_speed),
        ratio(by_stokes, raw.impact_speed),
        ratio(by_stokes.filter(|_| raw.impact_speed.is_none()), dropped),
        ratio(by_height(raw.rebound_height), raw.rebound_speed),
    ]
}

/// How the speeds of two columns compare over a table.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Comparison {
    /// runs by the class of the logarithm of their ratio
    classes: BTreeMap<i32, usize>,
    /// the first rows that lie apart, with their ratio, and how many do
    apart: (Vec<(u32, f64)>, usize),
}

impl Comparison {
    /// Width of a class.
    const STEP: f64 = 0.005;

    pub fn add(&mut self, row: u32, ratio: f64) {
        let class = (ratio.ln() / Comparison::STEP).round() as i32;
        *self.classes.entry(class).or_default() += 1;
        if ratio.ln().abs() > APART {
            self.apart.1 += 1;
            if self.apart.0.len() < NAMED {
                self.apart.0.push((row, ratio));
            }
        }
    }

    /// Adds what a later part of a table says, of which so many rows come before.
    pub fn extend(&mut self, part: &Comparison, rows_before: u32) {
        for (class, runs) in &part.classes {
            *self.classes.entry(*class).or_default() += runs;
        }
        self.apart.1 += part.apart.1;
        let later = part
            .apart
            .0
            .iter()
            .map(|(row, ratio)| (row.saturating_add(rows_before), *ratio));
        self.apart.0.extend(later);
        self.apart.0.truncate(NAMED);
    }

    /// Of the columns that were compared, by the names that the table has for them; `None` where no run has both.
    pub fn of(&self, columns: [RunColumn; 2], names: [String; 2]) -> Option<ComparedColumns> {
        let runs: usize = self.classes.values().sum();
        let mut before = 0;
        let middle = self.classes.iter().find(|(_, own)| {
            before += **own;
            2 * before > runs
        });
        Some(ComparedColumns {
            columns,
            names,
            runs,
            ratio: (f64::from(*middle?.0) * Comparison::STEP).exp(),
            apart: self.apart.0.clone(),
            all_apart: self.apart.1,
        })
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
    /// median over these runs of the speed by the first over the speed by the second
    pub ratio: f64,
    /// the first rows whose speeds lie more than a tenth apart, with their ratio
    pub apart: Vec<(u32, f64)>,
    /// how many such rows there are
    pub all_apart: usize,
}

//! Holds one run as it was read, before runs are put in order.

use serde::{Deserialize, Serialize};

use super::errors::RunError;
use crate::physics::numbers::same_diameter;

/// What a run was made with: a block of rows goes on while it stays the same.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct RowSetting {
    /// index into the scene's particles
    pub particle: u32,
    /// index into the scene's liquids; `None` for a dry run
    pub liquid: Option<u32>,
    /// m
    pub diameter: f64,
    /// m; 0 for a dry run
    pub film: f64,
}

impl RowSetting {
    /// Whether runs of both are of one series, as far as two runs can tell.
    pub fn is_like(&self, other: &RowSetting) -> bool {
        /// films of one series differ by no larger share from run to run
        const SAME_FILM: f64 = 0.15;
        let is_same_film = (self.film - other.film).abs() <= SAME_FILM * self.film.max(other.film);
        (self.particle, self.liquid) == (other.particle, other.liquid)
            && same_diameter(self.diameter, other.diameter)
            && is_same_film
    }
}

/// A run as it was read.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ReadRun {
    pub setting: RowSetting,
    pub impact_speed: f64,
    pub restitution: f64,
    /// the nominal one of a wet run; `None` in a table without such a column
    pub film_ratio: Option<f64>,
    /// what impact speed and restitution err by
    pub errors: RunError,
    /// row of the table, from 1
    pub row: u32,
    /// how many runs it stands for; `None` where that is itself
    pub count: Option<f64>,
    /// whether those it stands for stuck, which its restitution need not tell
    pub stuck: Option<bool>,
}

impl ReadRun {
    /// Whether it stuck, where restitutions up to `limit` do.
    pub fn is_stuck(&self, limit: f64) -> bool {
        self.stuck.unwrap_or(self.restitution <= limit)
    }

    /// δ/D.
    pub fn own_film_ratio(&self) -> f64 {
        self.setting.film / self.setting.diameter
    }

    /// The same in a table in which so many rows come before.
    pub fn after(self, rows: u32) -> ReadRun {
        ReadRun {
            row: rows.saturating_add(self.row),
            ..self
        }
    }
}

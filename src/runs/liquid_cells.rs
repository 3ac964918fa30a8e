//! Watches how a table writes its liquids: an empty cell is a dry run, unless each name is written once, above its block.

use std::collections::BTreeMap;

use super::raw_row::{bad_cell, BadCell};
use super::read_run::ReadRun;
use super::refusals::CellPlace;
use crate::scene::{RunColumn, DRY};

/// The cells of a column of liquids, as far as they were read.
#[derive(Default)]
pub(super) struct LiquidCells {
    /// whether a liquid was named above, below any `dry`, and whether right above
    is_named: bool,
    is_right_above: bool,
    /// names right below a name
    in_blocks: usize,
    /// names right above an empty cell
    alone: usize,
    /// whether `dry` is written anywhere
    writes_dry: bool,
    /// empty cells below names
    empty: usize,
    /// those right below each other: the first so many
    blocks: Vec<EmptyBlock>,
    /// whether the last of them is the one at hand
    is_kept: bool,
    /// what runs that are dry for certain lose, of each particle
    dry: BTreeMap<u32, Losses>,
    /// what the row at hand is
    row: Row,
}

/// What a row is by its liquid.
#[derive(Default, Clone, Copy, PartialEq)]
enum Row {
    #[default]
    Wet,
    Dry,
    /// dry, or of the liquid above
    Doubtful,
}

/// Runs whose liquid is empty below a name.
struct EmptyBlock {
    first: CellPlace,
    particle: Option<u32>,
    losses: Losses,
}

/// How many runs there are, the means of ln v and of 1 − e, and the sums of squares and products about these.
#[derive(Default, Clone, Copy)]
struct Losses {
    count: f64,
    ln_speed: f64,
    loss: f64,
    speed_squares: f64,
    products: f64,
    loss_squares: f64,
}

impl Losses {
    fn add(&mut self, ln_speed: f64, loss: f64) {
        self.count += 1.0;
        let [x, y] = [ln_speed - self.ln_speed, loss - self.loss];
        self.ln_speed += x / self.count;
        self.loss += y / self.count;
        self.speed_squares += x * (ln_speed - self.ln_speed);
        self.products += x * (loss - self.loss);
        self.loss_squares += y * (loss - self.loss);
    }

    /// Whether the runs of a block lose more than these by their straight line in ln v, which any dry law follows nearly; `None`
    /// where they may, or where there are too few.
    fn is_below(&self, block: &Losses) -> Option<bool> {
        const FEWEST: f64 = 5.0;
        /// sds of their difference that are scatter, and those that are none
        const NEAR: f64 = 3.0;
        const FAR: f64 = 6.0;
        /// by how much spheres of other diameters may differ, as a share and at least, and what no experiment scatters less than
        const SHARE: f64 = 0.15;
        const LEAST: f64 = 0.015;
        const LEAST_SD: f64 = 0.003;
        /// the sd up to which an agreement says something
        const SURE: f64 = 0.01;
        if self.count < FEWEST || block.count == 0.0 {
            return None;
        }
        let slope = self.products / self.speed_squares.max(f64::MIN_POSITIVE);
        let rest = (self.loss_squares - slope * self.products).max(0.0);
        let beyond = block.ln_speed - self.ln_speed;
        let apart = block.loss - self.loss - slope * beyond;
        let by_slope = beyond * beyond / self.speed_squares.max(f64::MIN_POSITIVE);
        let sd_of_runs = (rest / (self.count - 2.0)).sqrt().max(LEAST_SD);
        let sd = sd_of_runs * (1.0 / self.count + 1.0 / block.count + by_slope).sqrt();
        if apart > FAR * sd && apart > LEAST.max(SHARE * self.loss) {
            Some(true)
        } else if apart < NEAR * sd && sd < SURE {
            Some(false)
        } else {
            None
        }
    }
}

impl LiquidCells {
    /// Adds a cell; `has_film` says whether another of its row speaks of a film, which tells an empty one from a name left out.
    pub fn add(&mut self, at: CellPlace, liquid: Option<&str>, has_film: bool) {
        /// blocks that are kept
        const MOST: usize = 10_000;
        let was_doubtful = self.row == Row::Doubtful;
        let is_dry = liquid.map(|name| name.eq_ignore_ascii_case(DRY));
        self.row = match is_dry {
            Some(false) => Row::Wet,
            Some(true) => Row::Dry,
            None if has_film || !self.is_named => Row::Dry,
            None => Row::Doubtful,
        };
        self.writes_dry |= is_dry == Some(true);
        if self.row == Row::Doubtful {
            self.alone += usize::from(self.is_right_above);
            self.empty += 1;
            if !was_doubtful {
                self.is_kept = self.blocks.len() < MOST;
                self.blocks.extend(self.is_kept.then(|| EmptyBlock {
                    first: at,
                    particle: None,
                    losses: Losses::default(),
                }));
            }
        }
        if let Some(is_dry) = is_dry {
            self.in_blocks += usize::from(!is_dry && self.is_right_above);
            self.is_named = !is_dry;
        }
        self.is_right_above = is_dry == Some(false);
    }

    /// Passes a row that is left out: it may name the liquid of those below.
    pub fn pass(&mut self, at: CellPlace, liquid: Option<&str>) {
        if liquid.is_some() {
            self.add(at, liquid, false);
        }
    }

    /// Takes what was measured in the row of the last cell.
    pub fn measured(&mut self, run: &ReadRun) {
        if self.row == Row::Wet {
            return;
        }
        let (ln_speed, loss) = (run.impact_speed.ln(), 1.0 - run.restitution);
        let particle = run.setting.particle;
        if self.row == Row::Dry {
            self.dry.entry(particle).or_default().add(ln_speed, loss);
        } else if let Some(block) = self.blocks.last_mut().filter(|_| self.is_kept) {
            // one of several particles is judged by its first
            if *block.particle.get_or_insert(particle) == particle {
                block.losses.add(ln_speed, loss);
            }
        }
    }

    /// The first cell that may have been left empty for the name above it: where its runs lose more than dry ones; where the
    /// table writes `dry` of other runs; or where names stand above empty cells and hardly any above another name, unless what
    /// was measured says that these runs are dry.
    pub fn doubt(&self) -> Option<(CellPlace, BadCell)> {
        /// empty cells below names, at least
        const EMPTY: usize = 2;
        /// names right above empty cells for each that stands below a name, at least
        const ALONE: usize = 10;
        let is_wet = |block: &EmptyBlock| self.dry.get(&block.particle?)?.is_below(&block.losses);
        let (at, why) = if let Some(wet) = self.blocks.iter().find(|block| is_wet(block) == Some(true)) {
            let why = "its restitution is too small for a dry run, as if the name above it were meant".to_owned();
            (wet.first, why)
        } else {
            let is_once_a_block = self.empty >= EMPTY && self.alone >= ALONE * self.in_blocks;
            let mut unknown = self.blocks.iter().filter(|block| is_wet(block).is_none());
            let doubtful = if self.writes_dry {
                self.blocks.first()
            } else {
                unknown.next().filter(|_| is_once_a_block)
            };
            let cells = match self.empty {
                1 => "one cell below a name is empty".to_owned(),
                empty => format!("{empty} cells below names are empty"),
            };
            let why = format!("{cells}, as if each name were written once for the rows below it");
            (doubtful?.first, why)
        };
        let expected = format!("expected a name in [liquids] or `{DRY}` in every row: {why}");
        Some((at, bad_cell(RunColumn::Liquid, expected)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::read_run::RowSetting;

    /// The line of the first doubt, in a column of liquids with `_` for an empty cell; `+` says that a film stands beside it, `w`
    /// that the run loses as much as a wet one, `t` as one in a thin film.
    fn first_doubt(cells: &str, is_measured: bool) -> Option<u64> {
        let mut seen = LiquidCells::default();
        for (row, cell) in (2..).zip(cells.split(' ')) {
            let liquid = cell.trim_end_matches(['+', 'w', 't']);
            let liquid = Some(liquid).filter(|name| *name != "_");
            // an `x` is left out, like a mean
            if liquid == Some("x") {
                seen.pass(CellPlace::Row(row), None);
                continue;
            }
            seen.add(CellPlace::Row(row), liquid, cell.ends_with('+'));
            let is_wet = cell.ends_with('w') || !matches!(liquid, None | Some("dry"));
            let of_film = if cell.ends_with('t') { 0.785 } else { 0.8 };
            let restitution = if is_wet { 0.7 } else { of_film } + 1e-3 * (row % 3) as f64;
            if is_measured {
                // both over the same speeds, at which a dry sphere loses more the faster it is
                let speed = 1.0 + 0.3 * (row % 3) as f64;
                seen.measured(&checked(speed, restitution - 0.05 * speed.ln()));
            }
        }
        seen.doubt().map(|(at, _)| at.number())
    }

    fn checked(impact_speed: f64, restitution: f64) -> ReadRun {
        ReadRun {
            setting: RowSetting {
                diameter: 4e-3,
                ..RowSetting::default()
            },
            impact_speed,
            restitution,
            ..ReadRun::default()
        }
    }

    #[test]
    fn a_liquid_written_once_a_block_is_doubted() {
        for (cells, row) in [
            ("A _ _ B _ _", 3),
            ("_ _ A _ _ dry _ _ A _", 5),
            ("dry _ _ A _ _", 6),
            // nothing tells these from such blocks
            ("A _ A _ A _", 3),
            // the table has a word for dry runs
            ("dry dry A _ _ B B B B", 5),
        ] {
            assert_eq!(first_doubt(cells, false), Some(row), "{cells}");
        }
        for right in [
            "_ _ _ A A A",
            "A _",
            "A B _ B A _ _ A A",
            "A A A _ _ _",
            "A A A A _ B B B _ _",
            "dry _ _ A",
            "A+ _+ A+ _+",
            "A dry A dry",
        ] {
            assert_eq!(first_doubt(right, false), None, "{right}");
        }
    }

    #[test]
    fn what_was_measured_tells_a_name_left_out_from_a_dry_run() {
        // a block in full beside one that is not, and a name forgotten
        assert_eq!(first_doubt("_ _ _ _ _ A _w _w _w B B B B", true), Some(8));
        assert_eq!(first_doubt("_ _ _ _ _ A A A _w A A", true), Some(10));
        // what is lost in a thin film tells neither
        assert_eq!(first_doubt("_ _ _ _ _ A _t _t _t", true), Some(8));
        // dry runs in any order
        for right in [
            "_ _ _ _ _ A _ _ A _ _ _",
            "_ _ _ _ _ A A A _ A A",
            "_ _ _ _ _ A _ A _ A _",
            "_ _ _ _ _ x A _ _ _ x A",
        ] {
            assert_eq!(first_doubt(right, true), None, "{right}");
        }
    }
}

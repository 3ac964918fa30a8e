//! Watches how a table writes its liquids: an empty cell is a dry run, unless each name is written once, above its block.

use super::raw_row::{bad_cell, BadCell};
use super::refusals::CellPlace;
use crate::scene::{RunColumn, DRY};

/// The cells of a column of liquids, as far as they were read.
#[derive(Default)]
pub(super) struct LiquidCells {
    /// whether a liquid was named above, below any `dry`
    is_named: bool,
    /// whether right above
    is_right_above: bool,
    /// names right below a name
    in_blocks: usize,
    /// names right above an empty cell
    alone: usize,
    /// empty cells below a name, and the first of them
    empty: usize,
    first_empty: Option<CellPlace>,
}

impl LiquidCells {
    /// Adds a cell; `has_film` says whether another of its row speaks of a film, which tells an empty one from a name left out.
    pub fn add(&mut self, at: CellPlace, liquid: Option<&str>, has_film: bool) {
        match liquid {
            Some(name) => {
                let is_wet = !name.eq_ignore_ascii_case(DRY);
                self.in_blocks += usize::from(is_wet && self.is_right_above);
                (self.is_named, self.is_right_above) = (is_wet, is_wet);
            }
            None => {
                if !has_film && self.is_named {
                    self.alone += usize::from(self.is_right_above);
                    self.empty += 1;
                    self.first_empty.get_or_insert(at);
                }
                self.is_right_above = false;
            }
        }
    }

    /// The first cell that may have been left empty for the name above it: where names stand above empty cells, and hardly any
    /// above another name.
    pub fn doubt(&self) -> Option<(CellPlace, BadCell)> {
        /// empty cells below names, at least
        const EMPTY: usize = 2;
        /// names right above empty cells for each that stands below a name, at least
        const ALONE: usize = 10;
        let is_once_a_block = self.empty >= EMPTY && self.alone >= ALONE * self.in_blocks;
        let at = self.first_empty.filter(|_| is_once_a_block)?;
        let expected = format!(
            "expected a name in [liquids] or `{DRY}` in every row: {} cells below names are empty, as if each name were \
             written once for the rows below it",
            self.empty
        );
        Some((at, bad_cell(RunColumn::Liquid, expected)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_liquid_written_once_a_block_is_doubted() {
        let first_doubt = |cells: &str| {
            let mut seen = LiquidCells::default();
            for (row, cell) in (2..).zip(cells.split(' ')) {
                let (liquid, film) = cell.split_once('+').unwrap_or((cell, ""));
                seen.add(
                    CellPlace::Row(row),
                    Some(liquid).filter(|name| *name != "_"),
                    !film.is_empty(),
                );
            }
            seen.doubt().map(|(at, _)| at.number())
        };
        assert_eq!(first_doubt("A _ _ B _ _"), Some(3));
        assert_eq!(first_doubt("_ _ A _ _ dry _ _ A _"), Some(5));
        assert_eq!(first_doubt("dry _ _ A _ _"), Some(6));
        // nothing tells these from such blocks
        assert_eq!(first_doubt("A _ A _ A _"), Some(3));
        for right in [
            "_ _ _ A A A",
            "A _",
            "A B _ B A _ _ A A",
            "A A A _ _ _",
            "A A A A _ B B B _ _",
            "dry _ _ A",
            "A+7 _+0 A+7 _+0",
            "A dry A dry",
        ] {
            assert_eq!(first_doubt(right), None, "{right}");
        }
    }
}

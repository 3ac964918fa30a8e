//! Puts numbers in classes, from cells in which those of any part of a table are counted, and then of all.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::physics::numbers::same_diameter;

/// How cells divide the numbers above 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Grid {
    /// each number has a cell of its own
    Exact,
    /// into cells of this width
    Steps(f64),
    /// into cells of this share of their numbers
    Shares(f64),
}

impl Grid {
    /// A cell's place, which grows with the number.
    fn place(self, number: f64) -> i64 {
        match self {
            // numbers above 0 are in the order of their bits
            Grid::Exact => number.to_bits() as i64,
            Grid::Steps(width) => (number / width).floor() as i64,
            Grid::Shares(share) => (number.ln() / share).floor() as i64,
        }
    }
}

/// The numbers of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Cell {
    /// the least of them
    pub lo: f64,
    /// the greatest
    pub hi: f64,
    count: f64,
    /// sum of what they are above the least
    above: f64,
}

impl Cell {
    fn of_one(number: f64) -> Cell {
        Cell {
            lo: number,
            hi: number,
            count: 1.0,
            above: 0.0,
        }
    }

    /// The sum of what its numbers are above some number, which need not be one of them.
    fn above(&self, number: f64) -> f64 {
        self.above + self.count * (self.lo - number)
    }

    /// Adds the numbers of another part of this cell.
    fn extend(&mut self, other: Cell) {
        let lo = self.lo.min(other.lo);
        *self = Cell {
            lo,
            hi: self.hi.max(other.hi),
            count: self.count + other.count,
            above: self.above(lo) + other.above(lo),
        };
    }
}

/// The mean of some cells' numbers, exactly theirs where all are one; NaN of none.
pub(super) fn mean_of_cells(cells: &[Cell]) -> f64 {
    let first = cells.first().map_or(f64::NAN, |cell| cell.lo);
    let count: f64 = cells.iter().map(|cell| cell.count).sum();
    first + cells.iter().map(|cell| cell.above(first)).sum::<f64>() / count
}

/// Numbers of a part of a table, or of all of it, counted in cells by their places.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Cells(BTreeMap<i64, Cell>);

impl Cells {
    pub fn new(grid: Grid, mut numbers: Vec<f64>) -> Cells {
        numbers.sort_by(f64::total_cmp);
        let mut last = (f64::NAN, 0);
        let each = numbers.into_iter().map(|number| {
            // equal numbers follow one another, and a place may cost a logarithm
            if number != last.0 {
                last = (number, grid.place(number));
            }
            (last.1, Cell::of_one(number))
        });
        Cells::default().with(each)
    }

    /// These with the numbers of others by their places.
    fn with(mut self, others: impl IntoIterator<Item = (i64, Cell)>) -> Cells {
        for (place, cell) in others {
            let own = self.0.entry(place);
            own.and_modify(|own| own.extend(cell)).or_insert(cell);
        }
        self
    }

    /// Adds those of another part.
    pub fn extend(&mut self, other: Cells) {
        *self = std::mem::take(self).with(other.0);
    }

    /// In increasing order.
    pub fn all(&self) -> Vec<Cell> {
        self.0.values().copied().collect()
    }
}

/// Classes of one diameter each, in increasing order.
pub(super) struct DiameterClasses {
    /// the least diameter of each
    lower_ends: Vec<f64>,
}

impl DiameterClasses {
    /// Far narrower than what still counts as one diameter.
    pub const GRID: Grid = Grid::Shares(1e-5);

    pub fn new(cells: &Cells) -> DiameterClasses {
        let mut lower_ends: Vec<f64> = vec![];
        for diameter in cells.all().iter().flat_map(|cell| [cell.lo, cell.hi]) {
            if lower_ends.last().is_none_or(|first| !same_diameter(*first, diameter)) {
                lower_ends.push(diameter);
            }
        }
        DiameterClasses { lower_ends }
    }

    pub fn of(&self, diameter: f64) -> u32 {
        let place = self.lower_ends.partition_point(|end| *end <= diameter);
        place.saturating_sub(1) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_parts_are_those_of_all() {
        let numbers: Vec<f64> = (1..400).map(|i| (f64::from(i) * 0.618_034).fract() + 0.01).collect();
        for grid in [Grid::Exact, Grid::Steps(0.03), Grid::Shares(0.05)] {
            let all = Cells::new(grid, numbers.clone());
            let parts = numbers.chunks(37).map(|part| Cells::new(grid, part.to_vec()));
            let joined = parts.fold(Cells::default(), |joined, part| joined.with(part.0));
            assert_eq!(joined.all().len(), all.all().len());
            for ((at, a), (place, b)) in joined.0.iter().zip(&all.0) {
                assert_eq!((at, a.lo, a.hi, a.count), (place, b.lo, b.hi, b.count));
                assert!((mean_of_cells(&[*a]) - mean_of_cells(&[*b])).abs() < 1e-15);
            }
            let mean = numbers.iter().sum::<f64>() / numbers.len() as f64;
            assert!((mean_of_cells(&joined.all()) - mean).abs() < 1e-14);
        }
        assert_eq!(mean_of_cells(&Cells::new(Grid::Exact, vec![0.06; 7]).all()), 0.06);
        assert!(mean_of_cells(&[]).is_nan());
    }

    #[test]
    fn a_class_ends_where_a_diameter_is_no_longer_that_of_its_first() {
        let diameters = vec![5.0e-3, 4.0e-3, 4.003e-3, 4.0035e-3, 4.0071e-3];
        let classes = DiameterClasses::new(&Cells::new(DiameterClasses::GRID, diameters));
        // 0.1 % from the first of a class, not from its neighbour
        let of = [4.0e-3, 4.003e-3, 4.0035e-3, 4.0071e-3, 5.0e-3].map(|diameter| classes.of(diameter));
        assert_eq!(of, [0, 0, 0, 1, 2]);
    }
}

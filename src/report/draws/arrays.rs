//! Holds arrays of draws, and of what belongs to them, as they lie in a file.

use serde_json::{json, Value};

use crate::inference::importance::DrawCounts;

/// A dimension of an array: its name, which the dimension's coordinate bears, too, and the number of places along it.
pub type ArrayDimension = (&'static str, usize);

/// Values of an array, the last dimension running fastest, little end first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayValues {
    /// what they are, as Zarr names it
    pub(super) data_type: Value,
    /// what stands where there is none
    pub(super) fill: Value,
    /// all of them; `None` for those too many to be held, which the caller writes, see [`super::zarr::PART`]
    pub(super) bytes: Option<Vec<u8>>,
}

impl ArrayValues {
    /// Real numbers; one that is not finite is kept as it is.
    pub fn reals(values: impl IntoIterator<Item = f64>) -> ArrayValues {
        let bytes = values.into_iter().flat_map(f64::to_le_bytes);
        ArrayValues::of(json!("float64"), json!("NaN"), Some(bytes.collect()))
    }

    /// Every column's number at the first draw of the first chain, then at the next; columns have their draws by chain.
    pub fn interleaved(columns: &[&[Vec<f64>]]) -> ArrayValues {
        let chains = columns.first().copied().unwrap_or_default();
        let lengths = chains.iter().map(Vec::len).enumerate();
        let places = lengths.flat_map(|(chain, length)| (0..length).map(move |draw| (chain, draw)));
        let numbers = places.flat_map(|(chain, draw)| columns.iter().map(move |column| column[chain][draw]));
        ArrayValues::reals(numbers)
    }

    /// Counts.
    pub fn counts(values: impl IntoIterator<Item = i64>) -> ArrayValues {
        let bytes = values.into_iter().flat_map(i64::to_le_bytes);
        ArrayValues::of(json!("int64"), json!(0), Some(bytes.collect()))
    }

    /// Flags.
    pub fn flags(values: impl IntoIterator<Item = bool>) -> ArrayValues {
        let bytes = values.into_iter().map(u8::from);
        ArrayValues::of(json!("bool"), json!(false), Some(bytes.collect()))
    }

    /// Names, in UTF-32 as long as the longest; trailing NUL characters are lost.
    pub fn texts(values: &[String]) -> ArrayValues {
        let characters = values.iter().map(|text| text.chars().count());
        let length = characters.max().unwrap_or(0).max(1);
        let padded = |text: &String| {
            let mut letters: Vec<u32> = text.chars().map(u32::from).collect();
            letters.resize(length, 0);
            letters
        };
        let bytes = values.iter().flat_map(padded).flat_map(u32::to_le_bytes);
        let configuration = json!({"length_bytes": size_of::<u32>() * length});
        let data_type = json!({"name": "fixed_length_utf32", "configuration": configuration});
        ArrayValues::of(data_type, json!(""), Some(bytes.collect()))
    }

    /// Numbers too many to be held.
    pub fn streamed() -> ArrayValues {
        ArrayValues::of(json!("float32"), json!("NaN"), None)
    }

    fn of(data_type: Value, fill: Value, bytes: Option<Vec<u8>>) -> ArrayValues {
        ArrayValues { data_type, fill, bytes }
    }
}

/// A named array. One that bears the name of its only dimension is that dimension's coordinate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DrawArray {
    /// its name
    pub name: String,
    /// names and lengths of its dimensions
    pub dimensions: Vec<ArrayDimension>,
    /// as many values as the dimensions ask for
    pub values: ArrayValues,
}

/// A group of arrays: for ArviZ posterior, sample_stats, log_likelihood and so on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayGroup {
    /// its name
    pub name: &'static str,
    /// the dimensions of an array with a value a draw; none where no array has draws
    draws: Vec<ArrayDimension>,
    /// coordinates and variables, in any order; those that share a dimension agree on its length
    pub arrays: Vec<DrawArray>,
}

impl ArrayGroup {
    /// A group without arrays.
    pub fn new(name: &'static str) -> ArrayGroup {
        ArrayGroup {
            name,
            draws: vec![],
            arrays: vec![],
        }
    }

    /// A group with the coordinates of chains and draws, from 0.
    pub fn of_draws(name: &'static str, size: DrawCounts) -> ArrayGroup {
        let mut group = ArrayGroup::new(name);
        group.draws = vec![("chain", size.chains), ("draw", size.draws)];
        for dimension in group.draws.clone() {
            group.add_indices(dimension);
        }
        group
    }

    /// Adds an array.
    pub fn add(&mut self, name: impl Into<String>, dimensions: &[ArrayDimension], values: ArrayValues) {
        self.arrays.push(DrawArray {
            name: name.into(),
            dimensions: dimensions.to_vec(),
            values,
        });
    }

    /// Adds an array with a value a draw, or with as many as another dimension is long.
    pub fn add_draws(&mut self, name: impl Into<String>, other: Option<ArrayDimension>, values: ArrayValues) {
        let dimensions: Vec<ArrayDimension> = self.draws.iter().copied().chain(other).collect();
        self.add(name, &dimensions, values);
    }

    /// Adds the coordinate of a dimension that is numbered from 0.
    pub fn add_indices(&mut self, dimension: ArrayDimension) {
        let (name, length) = dimension;
        self.add(name, &[dimension], ArrayValues::counts((0..).take(length)));
    }

    /// Adds draws of a quantity that each of some labels has, a column of chains each; the labels are the coordinate of their
    /// dimension, which is called `by`.
    pub fn add_labelled(&mut self, name: &str, (by, labels): (&'static str, &[String]), columns: &[&[Vec<f64>]]) {
        let label = (by, labels.len());
        if !self.arrays.iter().any(|array| array.name == by) {
            self.add(by, &[label], ArrayValues::texts(labels));
        }
        self.add_draws(name, Some(label), ArrayValues::interleaved(columns));
    }
}

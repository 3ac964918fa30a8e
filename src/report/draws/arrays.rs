//! Holds arrays of draws, and of what belongs to them, as they lie in a file.

/// Chains of equally many draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawSize {
    /// number of chains
    pub chains: usize,
    /// draws of each chain
    pub draws: usize,
}

impl DrawSize {
    /// Draws of all chains.
    pub fn total(self) -> usize {
        self.chains * self.draws
    }

    /// The dimensions of an array with a value a draw.
    pub fn dimensions(self) -> [ArrayDimension; 2] {
        [
            ArrayDimension::new("chain", self.chains),
            ArrayDimension::new("draw", self.draws),
        ]
    }
}

/// A dimension of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ArrayDimension {
    /// name, which the dimension's coordinate bears, too
    pub name: &'static str,
    /// number of places along it
    pub length: usize,
}

impl ArrayDimension {
    /// A dimension with its name and length.
    pub fn new(name: &'static str, length: usize) -> ArrayDimension {
        ArrayDimension { name, length }
    }
}

/// Type of the values of an array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueType {
    /// f64; one that is not finite is kept as it is
    Real,
    /// f32
    Single,
    /// i64
    Count,
    /// one byte, 0 or 1
    Flag,
    /// UTF-32, so many characters each; trailing NUL characters are lost
    Text {
        /// characters of the longest, at least one
        length: usize,
    },
}

impl ValueType {
    /// Bytes of a value.
    pub fn size(self) -> usize {
        match self {
            ValueType::Real | ValueType::Count => 8,
            ValueType::Single => 4,
            ValueType::Flag => 1,
            ValueType::Text { length } => 4 * length,
        }
    }
}

/// Values of an array, the last dimension running fastest, little end first: many enough that each copy of them is felt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayValues {
    /// what they are
    pub(super) value_type: ValueType,
    /// all of them; `None` for those too many to be held, which the caller writes, see [`super::zarr::PART`]
    pub(super) bytes: Option<Vec<u8>>,
}

impl ArrayValues {
    /// Real numbers.
    pub fn reals(values: impl IntoIterator<Item = f64>) -> ArrayValues {
        ArrayValues::of(ValueType::Real, values.into_iter().map(f64::to_le_bytes))
    }

    /// Every column's number at the first draw of the first chain, then at the next; columns have their draws by chain.
    pub fn interleaved(columns: &[&[Vec<f64>]]) -> ArrayValues {
        let chains = columns.first().copied().unwrap_or_default();
        let numbers = columns.len() * chains.iter().map(Vec::len).sum::<usize>();
        let mut bytes = Vec::with_capacity(ValueType::Real.size() * numbers);
        for (chain, draws) in chains.iter().enumerate() {
            for draw in 0..draws.len() {
                for column in columns {
                    bytes.extend_from_slice(&column[chain][draw].to_le_bytes());
                }
            }
        }
        ArrayValues {
            value_type: ValueType::Real,
            bytes: Some(bytes),
        }
    }

    /// Counts.
    pub fn counts(values: impl IntoIterator<Item = i64>) -> ArrayValues {
        ArrayValues::of(ValueType::Count, values.into_iter().map(i64::to_le_bytes))
    }

    /// The numbers from 0 on, as the coordinate of a dimension.
    pub fn indices(length: usize) -> ArrayValues {
        ArrayValues::counts((0i64..).take(length))
    }

    /// Flags.
    pub fn flags(values: impl IntoIterator<Item = bool>) -> ArrayValues {
        ArrayValues::of(ValueType::Flag, values.into_iter().map(|value| [u8::from(value)]))
    }

    /// Names.
    pub fn texts(values: &[String]) -> ArrayValues {
        let characters = values.iter().map(|text| text.chars().count());
        let length = characters.max().unwrap_or(0).max(1);
        let padded = |text: &String| {
            let mut letters: Vec<u32> = text.chars().map(u32::from).collect();
            letters.resize(length, 0);
            letters
        };
        let letters = values.iter().flat_map(padded);
        ArrayValues::of(ValueType::Text { length }, letters.map(u32::to_le_bytes))
    }

    /// Numbers too many to be held.
    pub fn streamed() -> ArrayValues {
        ArrayValues {
            value_type: ValueType::Single,
            bytes: None,
        }
    }

    fn of<const N: usize>(value_type: ValueType, values: impl Iterator<Item = [u8; N]>) -> ArrayValues {
        let mut bytes = Vec::with_capacity(N * values.size_hint().0);
        values.for_each(|value| bytes.extend_from_slice(&value));
        ArrayValues {
            value_type,
            bytes: Some(bytes),
        }
    }

    /// How many are held; `None` where the caller writes them.
    pub fn held(&self) -> Option<usize> {
        Some(self.bytes.as_ref()?.len() / self.value_type.size())
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

impl DrawArray {
    /// An array of these values.
    pub fn new(name: impl Into<String>, dimensions: &[ArrayDimension], values: ArrayValues) -> DrawArray {
        DrawArray {
            name: name.into(),
            dimensions: dimensions.to_vec(),
            values,
        }
    }
}

/// A group of arrays: for ArviZ posterior, sample_stats, log_likelihood and so on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayGroup {
    /// its name
    pub name: &'static str,
    /// coordinates and variables, in any order; those that share a dimension agree on its length
    pub arrays: Vec<DrawArray>,
}

impl ArrayGroup {
    /// A group without arrays.
    pub fn new(name: &'static str) -> ArrayGroup {
        ArrayGroup { name, arrays: vec![] }
    }

    /// A group with the coordinates of chains and draws, from 0.
    pub fn of_draws(name: &'static str, size: DrawSize) -> ArrayGroup {
        let mut group = ArrayGroup::new(name);
        for dimension in size.dimensions() {
            group.add_indices(dimension);
        }
        group
    }

    /// Adds an array.
    pub fn add(&mut self, name: impl Into<String>, dimensions: &[ArrayDimension], values: ArrayValues) {
        self.arrays.push(DrawArray::new(name, dimensions, values));
    }

    /// Adds the coordinate of a dimension that is numbered from 0.
    pub fn add_indices(&mut self, dimension: ArrayDimension) {
        self.add(dimension.name, &[dimension], ArrayValues::indices(dimension.length));
    }

    /// Adds draws of a quantity that each of some labels has, a column of chains each; the labels are the coordinate of their
    /// dimension, which is called `by`.
    pub fn add_labelled(
        &mut self,
        name: &str,
        size: DrawSize,
        (by, labels): (&'static str, &[String]),
        columns: &[&[Vec<f64>]],
    ) {
        let [chain, draw] = size.dimensions();
        let label = ArrayDimension::new(by, labels.len());
        if !self.arrays.iter().any(|array| array.name == by) {
            self.add(by, &[label], ArrayValues::texts(labels));
        }
        self.add(name, &[chain, draw, label], ArrayValues::interleaved(columns));
    }
}

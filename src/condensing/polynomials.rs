//! Polynomials in what differs between points: products of Chebyshev's, each on its own range from −1 to 1.

/// What differs between points, scaled to −1 to 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis<'a> {
    of: &'a [f64],
    scale: Scale,
}

/// What lies at −1 and 1 of an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    middle: f64,
    half: f64,
}

impl Scale {
    /// That of a column of its own, which may then lie beyond −1 and 1.
    pub fn axis(self, of: &[f64]) -> Axis<'_> {
        Axis { of, scale: self }
    }
}

impl<'a> Axis<'a> {
    /// A column as an axis; `None` where it does not vary beyond rounding.
    pub fn new(of: &'a [f64]) -> Option<Axis<'a>> {
        /// a range that is rounding beside its place
        const NARROW: f64 = 1e-9;
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (lo, hi) = of.iter().fold(ends, |(lo, hi), x| (lo.min(*x), hi.max(*x)));
        let (middle, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
        (half > NARROW * middle.abs()).then_some(Scale { middle, half }.axis(of))
    }

    /// For other points.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Where a point is on it.
    pub fn at(&self, point: usize) -> f64 {
        (self.of[point] - self.scale.middle) / self.scale.half
    }
}

/// Number of polynomials up to a degree in some axes together.
pub(crate) fn functions(axes: usize, degree: usize) -> usize {
    (1..=axes).fold(1, |count, axis| count * (degree + axis) / axis)
}

/// All products of Chebyshev polynomials up to a degree, the constant first.
pub(crate) struct Polynomials<'a> {
    axes: &'a [Axis<'a>],
    degree: usize,
    /// of each product after the constant: the earlier one that is multiplied, and by which polynomial of all axes
    factors: Vec<[usize; 2]>,
}

impl<'a> Polynomials<'a> {
    pub fn new(axes: &'a [Axis<'a>], degree: usize) -> Polynomials<'a> {
        let mut degrees = vec![0];
        let mut factors = vec![];
        for axis in 0..axes.len() {
            let before = degrees.len();
            for power in 1..=degree {
                for product in 0..before {
                    if degrees[product] + power <= degree {
                        factors.push([product, axis * degree + power - 1]);
                        degrees.push(degrees[product] + power);
                    }
                }
            }
        }
        Polynomials { axes, degree, factors }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        1 + self.factors.len()
    }

    /// Their values at a point, the constant first.
    pub fn at(&self, point: usize) -> Vec<f64> {
        let mut of_axes = Vec::with_capacity(self.axes.len() * self.degree);
        for axis in self.axes {
            let t = axis.at(point);
            let (mut last, mut here) = (1.0, t);
            for _ in 0..self.degree {
                of_axes.push(here);
                (last, here) = (here, 2.0 * t * here - last);
            }
        }
        let mut values = Vec::with_capacity(self.len());
        values.push(1.0);
        for [product, of_axis] in &self.factors {
            values.push(values[*product] * of_axes[*of_axis]);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_that_does_not_vary_is_no_axis() {
        assert!(Axis::new(&[0.3, 0.3, 0.3]).is_none() && Axis::new(&[]).is_none());
    }
}

//! Carries the slopes of a quantity along with its value, so that a formula written once gives both.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// What a formula may be computed in: a number, or a number with its slopes.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// The number, its slopes left behind.
    fn value(self) -> f64;

    /// Its square root.
    fn sqrt(self) -> Self;

    /// Its exponential.
    fn exp(self) -> Self;

    /// The number where a condition holds, NaN where not.
    fn only_if(self, holds: bool) -> Self;
}

impl Number for f64 {
    fn value(self) -> f64 {
        self
    }
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    fn exp(self) -> f64 {
        f64::exp(self)
    }
    fn only_if(self, holds: bool) -> f64 {
        if holds {
            self
        } else {
            f64::NAN
        }
    }
}

/// A number with its slopes in N others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jet<const N: usize> {
    /// the number
    pub value: f64,
    /// its slopes
    pub slopes: [f64; N],
}

impl<const N: usize> Jet<N> {
    /// One of the N numbers themselves, by its place.
    pub fn variable(value: f64, place: usize) -> Jet<N> {
        let mut slopes = [0.0; N];
        slopes[place] = 1.0;
        Jet { value, slopes }
    }

    /// The value of a function of this number and another, and the slopes by its slopes in both.
    fn with(self, other: Jet<N>, value: f64, [of_self, of_other]: [f64; 2]) -> Jet<N> {
        Jet {
            value,
            slopes: std::array::from_fn(|j| of_self * self.slopes[j] + of_other * other.slopes[j]),
        }
    }

    /// The value of a function here, and the slopes by its own slope.
    fn through(self, value: f64, slope: f64) -> Jet<N> {
        Jet {
            value,
            slopes: self.slopes.map(|own| slope * own),
        }
    }
}

impl<const N: usize> Add for Jet<N> {
    type Output = Jet<N>;
    fn add(self, other: Jet<N>) -> Jet<N> {
        self.with(other, self.value + other.value, [1.0, 1.0])
    }
}

impl<const N: usize> Neg for Jet<N> {
    type Output = Jet<N>;
    fn neg(self) -> Jet<N> {
        self.through(-self.value, -1.0)
    }
}

impl<const N: usize> Sub for Jet<N> {
    type Output = Jet<N>;
    fn sub(self, other: Jet<N>) -> Jet<N> {
        self.with(other, self.value - other.value, [1.0, -1.0])
    }
}

impl<const N: usize> Mul for Jet<N> {
    type Output = Jet<N>;
    fn mul(self, other: Jet<N>) -> Jet<N> {
        self.with(other, self.value * other.value, [other.value, self.value])
    }
}

impl<const N: usize> Mul<f64> for Jet<N> {
    type Output = Jet<N>;
    fn mul(self, factor: f64) -> Jet<N> {
        self.through(self.value * factor, factor)
    }
}

impl<const N: usize> Div for Jet<N> {
    type Output = Jet<N>;
    fn div(self, other: Jet<N>) -> Jet<N> {
        let value = self.value / other.value;
        self.with(other, value, [1.0 / other.value, -value / other.value])
    }
}

impl<const N: usize> Number for Jet<N> {
    fn value(self) -> f64 {
        self.value
    }
    fn sqrt(self) -> Jet<N> {
        let root = self.value.sqrt();
        self.through(root, 0.5 / root)
    }
    fn exp(self) -> Jet<N> {
        let value = self.value.exp();
        self.through(value, value)
    }
    fn only_if(self, holds: bool) -> Jet<N> {
        Jet {
            value: self.value.only_if(holds),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn formula<T: Number>(x: T, y: T) -> T {
        (x * y - (x / y).exp()).sqrt() * 3.0 + -(y + x * x) / (x - y)
    }

    #[test]
    fn slopes_agree_with_differences() {
        let (x, y, h) = (2.3, 1.7, 1e-6);
        let jet = formula(Jet::<2>::variable(x, 0), Jet::variable(y, 1));
        assert_eq!(jet.value, formula(x, y));
        let of_x = (formula(x + h, y) - formula(x - h, y)) / (2.0 * h);
        let of_y = (formula(x, y + h) - formula(x, y - h)) / (2.0 * h);
        assert!((of_x / jet.slopes[0] - 1.0).abs() < 1e-6);
        assert!((of_y / jet.slopes[1] - 1.0).abs() < 1e-6);
        assert!(jet.only_if(false).value.is_nan() && jet.only_if(true) == jet);
    }
}

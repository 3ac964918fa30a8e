//! Says what a number of a scene must be, in words and as a test.

/// Film ratio above which no inertial form of the paper is valid; thicker films are screened.
pub const LARGEST_FILM_RATIO: f64 = 0.5;

/// What a number must be, in words and as a test.
#[derive(Clone, Copy)]
pub(super) struct Expect {
    pub words: &'static str,
    pub holds: fn(f64) -> bool,
}

pub(super) const ABOVE_ZERO: Expect = Expect {
    words: "a number above 0",
    holds: |x| x > 0.0 && x.is_finite(),
};
pub(super) const NOT_NEGATIVE: Expect = Expect {
    words: "a number of 0 or more",
    holds: |x| x >= 0.0 && x.is_finite(),
};
pub(super) const SHARE: Expect = Expect {
    words: "a number from 0 to below 1",
    holds: |x| (0.0..1.0).contains(&x),
};
pub(super) const INSIDE_ONE: Expect = Expect {
    words: "a number between 0 and 1",
    holds: |x| x > 0.0 && x < 1.0,
};
pub(super) const FILM_RATIO: Expect = Expect {
    words: "a film ratio above 0 and up to 0.5",
    holds: |x| x > 0.0 && x <= LARGEST_FILM_RATIO,
};
pub(super) const FINITE: Expect = Expect {
    words: "a finite number",
    holds: f64::is_finite,
};

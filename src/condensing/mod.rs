//! Finds few of many points that stand for all of them, with counts of their own, wherever what is asked of them is smooth.
//!
//! Sums over points of a polynomial up to degree 2D keep their values, and values at the points are replaced by their
//! nearest polynomial of degree D: a sum of squares about any polynomial of degree D is then the same but for a constant.
//!
//! | file | job |
//! |---|---|
//! | `polynomials.rs` | polynomials in what differs between points |
//! | `recombination.rs` | few points with the moments of all |
//! | `nearest.rs` | the polynomial nearest to values at the points |

pub(crate) mod nearest;
pub(crate) mod polynomials;
pub(crate) mod recombination;

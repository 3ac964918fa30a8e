//! Says what the data say: fits, their uncertainty, comparisons of nested fits.
//!
//! | file | job |
//! |---|---|
//! | `least_squares/` | Levenberg–Marquardt, covariance, verdict of a fit |
//! | `effective_variance.rs` | weighs runs by the measurement errors of speed and restitution |
//! | `law.rs` | the dry, linear and square-root laws: value, slopes, bends, derivatives in the speed |
//! | `kernel.rs` | a law with its runs, fitted to them in one stream |
//! | `regression.rs` | a law fitted to runs |
//! | `sums.rs` | residuals and slopes summed over rows |
//! | `descent.rs` | least squares, and modes, by damped steps from sums over rows |
//! | `information.rs` | the directions in which runs say more than the priors |
//! | `joint.rs` | every run in a row of one joint fit: residuals, slopes, sums and squares; the fit itself |
//! | `linearised_joint.rs` | a joint fit that is linear about a point: step, leverages, what a change of the rows moves |
//! | `law_squares.rs` | the squares of a law about its minimum |
//! | `bootstrap/` | replicates and the intervals they give |
//! | `laplace.rs` | mode and curvature of a posterior |
//! | `prepared_posterior.rs` | a posterior with its start and its mode |
//! | `nuts.rs` | draws by trajectories |
//! | `importance.rs` | draws from the normal about the mode, their weights, and what is kept of them |
//! | `mixing.rs` | when draws are enough |
//! | `sampling.rs` | a posterior to its draws |
//! | `accuracy.rs` | the cheapest draws that reach an accuracy |
//! | `delta.rs` | standard errors and intervals of derived quantities |
//! | `profile/` | limits of quantities where the squares have risen, for fits too curved for the delta method |
//! | `nested.rs` | F test of one law for all groups against one law a group |
//! | `lack_of_fit.rs` | tests a law against its own runs |
//! | `spreads.rs` | test of one spread for all groups |
//! | `diagnostics/` | how reliable draws of Markov chains are |

pub mod accuracy;
pub mod bootstrap;
pub mod delta;
pub mod descent;
pub mod diagnostics;
pub mod effective_variance;
pub mod importance;
pub mod information;
pub mod joint;
pub mod kernel;
pub mod lack_of_fit;
pub mod laplace;
pub mod law;
pub mod law_squares;
pub mod least_squares;
pub mod linearised_joint;
pub mod mixing;
pub mod nested;
pub mod nuts;
pub mod prepared_posterior;
pub mod profile;
pub mod regression;
pub mod sampling;
pub mod spreads;
pub mod sums;

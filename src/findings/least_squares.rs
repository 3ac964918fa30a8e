//! Holds what least squares found, for the stages that start from it.

use super::balance::EnergyBalance;
use super::dry::Dry;
use super::scaling::Scaling;
use super::series::SeriesFit;
use crate::physics::Form;

/// The fits by least squares, and the seed of whatever draws next.
#[derive(Debug, Clone, Copy)]
pub struct LeastSquares<'f> {
    /// seed of every use of chance
    pub seed: u64,
    /// k of each particle with dry runs
    pub dry: &'f [Dry],
    /// the square-root law of each series
    pub series: &'f [SeriesFit],
    /// e_inf and St_c by both laws
    pub scaling: &'f [Scaling],
    /// L, inertial prefactor and film scale over all rebounds; `None` without a usable k
    pub energy_balance: Option<&'f EnergyBalance>,
    /// the energy balance that is held; its form of inertia may still be open
    pub form: Form,
}

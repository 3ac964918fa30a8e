//! Holds the noise of runs that are taken one at a time, and adds its slopes.

use super::own_rows::ByRow;
use super::run_density::RunDensity;
use super::run_noise::RunNoise;
use crate::model::parameters::{ParameterKind, SHAPE_SLOT};

/// The noise of wet runs at a full vector of parameters, where runs are taken one at a time.
#[derive(Clone, Copy)]
pub(super) struct RowNoise<'l> {
    pub own: &'l ByRow,
    pub noise: RunNoise,
}

/// Adds the slopes in the spreads and in the shape of the noise, of which this kind of runs has that σ.
pub(super) fn add_noise_slopes(of: RunDensity, sigma: ParameterKind, slopes: &mut [f64]) {
    slopes[sigma.slot()] += of.sigma;
    slopes[ParameterKind::SigmaEnergy.slot()] += of.energy;
    slopes[SHAPE_SLOT] += of.shape;
}

//! Takes from the draws what predictions and figures of a particle need.

use super::Posterior;
use crate::findings::predict::{offset_of_new_series, Draw, ParticleLaw};
use crate::model::likelihood::tails::Tails;
use crate::model::parameters::{physical, ParameterKind, SHAPE_SLOT};
use crate::runs::Runs;
use crate::scene::{NoiseOn, Scene};

impl Posterior {
    /// The law of a sphere, by its index, by at most so many draws, evenly taken; of a new series, where series have offsets.
    pub fn law(&self, scene: &Scene, runs: &Runs, sphere: usize, most: usize) -> ParticleLaw {
        let both = scene.model.noise == NoiseOn::Both;
        let family = scene.model.likelihood;
        let full = self.sampled.full_draws();
        let step = full.len().div_ceil(most).max(1);
        let offsets = scene.model.series_offsets;
        let draw = |(index, full): (usize, &Vec<f64>)| Draw {
            parameters: physical(full, sphere),
            sigma_dry: full[ParameterKind::SigmaDry.slot()],
            sigma_wet: full[ParameterKind::SigmaWet.slot()],
            sigma_energy: if both {
                full[ParameterKind::SigmaEnergy.slot()]
            } else {
                0.0
            },
            tails: Tails::of(family, full[SHAPE_SLOT]),
            series_offset: if offsets {
                offset_of_new_series(index, full[ParameterKind::SigmaSeries.slot()])
            } else {
                0.0
            },
        };
        let basis = &self.findings.basis;
        let particle = &basis.particles[runs.spheres[sphere].particle];
        ParticleLaw {
            form: self.setup.form,
            smallest_restitution: basis.smallest_restitution,
            covered: particle.covered,
            ranges: basis.ranges(particle),
            dry_speeds: particle.dry_speeds_m_s,
            draws: full.iter().step_by(step).enumerate().map(draw).collect(),
        }
    }
}

//! Takes from the draws what predictions and figures of a particle need.

use super::Posterior;
use crate::findings::predict::{offset_of_new_series, Draw, ParticleLaw};
use crate::model::likelihood::tails::Tails;
use crate::model::parameters::{physical, ParameterKind, SHAPE_SLOT};
use crate::physics::balance::Balance;
use crate::physics::loss::Film;
use crate::physics::viscous;
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

    /// (e_inf, St_c) of every draw of a sphere in a film, `fixed` being the part of L there that no parameter moves;
    /// `None` where a draw leaves none. `v` is the speed at which e_dry enters, m/s.
    pub fn e_inf_and_st_c(&self, sphere: usize, film: Film, fixed: f64, v: f64) -> Option<Vec<[f64; 2]>> {
        let pair = |full: &Vec<f64>| {
            let balance = Balance::new(self.setup.form, film, &physical(full, sphere));
            let e_inf = balance.e_inf(v);
            let st_c = viscous::st_c(balance.lost.over_stokes + fixed, e_inf);
            e_inf.is_finite().then_some([e_inf, st_c])
        };
        self.sampled.full_draws().iter().map(pair).collect()
    }
}

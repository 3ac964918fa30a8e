//! Computes the log likelihood of each of some runs at every one of many draws, several draws at a time.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::{EvaluatedLaw, NoiseSd, Pointwise, RunSetting};
use crate::exponential::is_fused;
use crate::model::likelihood::normal::ln_normal_cdf_and_slope;
use crate::model::likelihood::tails::Tails;
use crate::model::likelihood::trend::DrawnFilms;
use crate::model::parameters::{ParameterKind, COMMON_SLOTS};
use crate::physics::balance::Balance;
use crate::physics::loss::Share;
use crate::physics::rebound::mean_and_slope;

/// Many draws of the parameters, ready for some runs at a time.
#[derive(Debug)]
pub struct AtDraws<'p, 'r> {
    pointwise: &'p Pointwise<'r>,
    /// full vectors of parameters
    draws: Vec<&'p [f64]>,
    films: DrawnFilms,
    /// of dry runs at each draw
    dry: Vec<NoiseSd>,
    /// of wet runs
    wet: Vec<NoiseSd>,
    /// the law at each draw, where runs are not plain
    laws: Vec<EvaluatedLaw<'p, 'r>>,
}

impl<'r> Pointwise<'r> {
    /// The runs at some draws, full vectors of parameters.
    pub fn at_draws<'p>(&'p self, draws: Vec<&'p [f64]>) -> AtDraws<'p, 'r> {
        let law = |full: &&'p [f64]| {
            let law = self.at(full);
            // now, as whoever asks for some runs asks for the first draw first, and tasks would wait for one another
            if !self.shared.is_empty() {
                law.given_the_others();
            }
            law
        };
        let spreads = |kind: ParameterKind| draws.iter().map(|full| NoiseSd::of(full[kind.slot()])).collect();
        AtDraws {
            pointwise: self,
            films: DrawnFilms::new(self.form, &draws),
            dry: spreads(ParameterKind::SigmaDry),
            wet: spreads(ParameterKind::SigmaWet),
            laws: if self.is_plain() {
                vec![]
            } else {
                draws.par_iter().map(law).collect()
            },
            draws,
        }
    }
}

impl AtDraws<'_, '_> {
    /// Draws.
    pub fn len(&self) -> usize {
        self.draws.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.draws.is_empty()
    }

    /// [`EvaluatedLaw::ln_likelihood`] of these runs, a row each that is as long as there are draws.
    pub fn ln_likelihoods(&self, runs: Range<usize>, rows: &mut [f64]) {
        if self.pointwise.is_plain() {
            return Arch::new().dispatch(PlainRuns { at: self, runs, rows });
        }
        for (run, row) in runs.zip(rows.chunks_exact_mut(self.len().max(1))) {
            for (value, law) in row.iter_mut().zip(&self.laws) {
                *value = law.ln_likelihood(run);
            }
        }
    }

    /// A parameter at every draw.
    fn column(&self, slot: usize) -> impl Iterator<Item = f64> + '_ {
        self.draws.iter().map(move |full| full[slot])
    }
}

/// Plain runs at every draw.
struct PlainRuns<'a> {
    at: &'a AtDraws<'a, 'a>,
    runs: Range<usize>,
    rows: &'a mut [f64],
}

/// What the draws say of a setting.
struct SettingAtDraws {
    /// its place
    setting: Option<u32>,
    /// δ̃ of the losses
    film_ratio: f64,
    losses: Vec<Share>,
    /// m(r) or e_dry
    means: Vec<f64>,
}

impl WithSimd for PlainRuns<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let PlainRuns { at, runs, rows } = self;
        let pointwise = at.pointwise;
        let mut of = SettingAtDraws {
            setting: None,
            film_ratio: f64::NAN,
            losses: vec![Share::default(); at.len()],
            means: vec![0.0; at.len()],
        };
        for (run, row) in runs.zip(rows.chunks_exact_mut(at.len().max(1))) {
            let setting = pointwise.setting[run];
            if of.setting != Some(setting) {
                of.evaluate(at, &pointwise.settings[setting as usize], is_fused::<S>());
                of.setting = Some(setting);
            }
            let spreads = if run < pointwise.dry { &at.dry } else { &at.wet };
            let draws = row.iter_mut().zip(&of.means).zip(spreads);
            if pointwise.stuck[run] {
                for ((value, mean), spread) in draws {
                    let z = (pointwise.limit - mean) / spread.sigma;
                    *value = ln_normal_cdf_and_slope(z, is_fused::<S>())[0];
                }
            } else {
                let restitution = pointwise.runs.restitution[run];
                for ((value, mean), spread) in draws {
                    let z = (restitution - mean) / spread.sigma;
                    *value = Tails::Normal.ln_unit_density(z) - spread.ln;
                }
            }
        }
    }
}

impl SettingAtDraws {
    /// The mean of e* at a setting; the losses of a film are computed once for the settings that share it.
    #[inline(always)]
    fn evaluate(&mut self, at: &AtDraws, setting: &RunSetting, fused: bool) {
        let form = at.pointwise.form;
        let impact = &setting.impact;
        for (mean, k) in self.means.iter_mut().zip(at.column(COMMON_SLOTS + setting.sphere)) {
            *mean = k;
        }
        let Some(wet) = setting.wet else {
            for mean in &mut self.means {
                *mean = form.dry.of_loss(*mean * impact.dry_root)[0];
            }
            return;
        };
        if self.film_ratio != wet.film_ratio {
            at.films.shares((wet.film_ratio, wet.ln_film), fused, &mut self.losses);
            self.film_ratio = wet.film_ratio;
        }
        let balance = |k: f64, share: Share| Balance::at(form, k, share, wet.density_ratio);
        let both = self.means.iter_mut().zip(&self.losses);
        match wet.offset {
            None => {
                for (mean, share) in both {
                    *mean = mean_and_slope(balance(*mean, *share).kept(impact).0).0;
                }
            }
            Some(slot) => {
                for ((mean, share), offset) in both.zip(at.column(slot)) {
                    *mean = mean_and_slope(balance(*mean, *share).with_offset(offset).kept(impact).0).0;
                }
            }
        }
    }
}

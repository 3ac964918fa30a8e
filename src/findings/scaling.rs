//! Estimates e_inf and St_c over liquids, diameters and speeds, and where the energy went, by the linear and the square-root
//! law.

use std::ops::{Deref, Range};

use nalgebra::DMatrix;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

use super::dry;
use super::estimate::{Estimate, Quoting, FEWEST_DEGREES};
use super::film_groups::why_no_laws;
use super::fit_verdict::{f_words, one_against, OwnLaw, Verdict};
use super::places::WetPlace;
use super::quantities::{variables, FittedLaw, LawOver, PARAMETERS};
use super::wet_fit::{two, FitSetup, WetFit, WetRuns};
use crate::inference::delta::Uncertain;
use crate::inference::least_squares::Fit;
use crate::inference::nested::FTest;
use crate::physics::inertia::Inertia;
use crate::physics::jet::Jet;
use crate::physics::quantity::{Place, Quantity};
use crate::runs::{sphere_words, FilmGroup, Series};
use crate::scene::WetLaw;

/// e_inf and St_c of one particle, or one diameter of it, at one film ratio, or over all of them, by one law.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Scaling {
    /// name of the particle
    pub particle: String,
    /// D, m, where each diameter has a k of its own
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diameter_m: Option<f64>,
    /// film ratio; `None`: over all
    pub film_ratio: Option<f64>,
    /// `linear` or `sqrt`
    pub law: WetLaw,
    /// rebounds used
    pub runs: usize,
    /// runs that stuck, left out
    pub stuck: usize,
    /// where the energy went; `None` over all film ratios
    pub energy: Option<Energy>,
    /// correlation of e_inf and St_c
    pub correlation: Option<f64>,
    /// what the law gets wrong on this design without any noise. Linear: fitted to the square root at the same runs,
    /// minus that square root. Square root: fitted to the energy balance at the same runs, minus that balance
    pub bias: Option<Bias>,
    /// one law over all film ratios against one each (only over all)
    pub one_for_all: Option<FTest>,
    /// the law
    #[serde(flatten)]
    pub fitted: WetFit,
}

impl Deref for Scaling {
    type Target = WetFit;

    fn deref(&self) -> &WetFit {
        &self.fitted
    }
}

/// Parameters of the law of a film ratio.
const LAW_PARAMETERS: usize = 2;

impl Scaling {
    /// Whether it has the degrees of freedom to be quoted beside a posterior, which knows the spread from all runs.
    pub fn tells_its_spread(&self) -> bool {
        self.runs >= FEWEST_DEGREES + LAW_PARAMETERS
    }

    /// Whether it is a square-root law of one series, whose runs share an offset, that these, and enough of them, do not bear.
    pub(super) fn fails_by_itself(&self) -> bool {
        self.law == WetLaw::Sqrt && self.series.len() == 1 && !self.verdict.passed && self.tells_its_spread()
    }

    /// The larger of the law's two biases, in standard errors; `None` where either is not known.
    pub fn bias_in_se(&self) -> Option<f64> {
        let bias = self.bias?;
        let e_inf = bias.e_inf.abs() / self.estimates[Quantity::EInf].scale()?;
        let st_c = bias.st_c.abs() / self.estimates[Quantity::StC].scale()?;
        Some(e_inf.max(st_c))
    }

    /// Takes back a law that may not be quoted: over all film ratios its verdict, at one its numbers with it. What it leaves
    /// unexplained stays, as the energy balance is held against it.
    fn withhold(&mut self, why: &str) {
        if self.film_ratio.is_some() {
            (self.correlation, self.bias) = (None, None);
            self.fitted.withhold(why);
        } else if self.verdict.passed {
            self.fitted.verdict = Verdict::failed(why);
        }
    }

    /// The particle's words in a text: `PTFE`, `PTFE of 4.762 mm`.
    pub fn words(&self) -> String {
        sphere_words(&self.particle, self.diameter_m)
    }
}

/// Where the energy went at one film ratio, by one law.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Energy {
    /// ρ̃, mean over the rebounds used
    pub density_ratio: f64,
    /// eq. Eint2 at this film ratio
    pub stepwise: f64,
    /// eq. Eint1 at this film ratio; `None` beyond 0.39, where it falls
    pub cap: Option<f64>,
}

/// How far a law is off on this design, fitted without noise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Bias {
    /// in e_inf
    pub e_inf: f64,
    /// in St_c
    pub st_c: f64,
}

impl Bias {
    /// Of e_inf and St_c by a law, where these are the true ones.
    pub(super) fn of(law: [f64; 2], [e_inf, st_c]: [f64; 2]) -> Bias {
        Bias {
            e_inf: law[0] - e_inf,
            st_c: law[1] - st_c,
        }
    }
}

/// Both laws for every sphere with a k of its own, over all film ratios and at each; square root before linear.
pub fn fit_scaling(setup: FitSetup) -> Vec<Scaling> {
    let spheres = (0..setup.runs.spheres.len()).into_par_iter();
    spheres.flat_map_iter(|sphere| of_sphere(setup, sphere)).collect()
}

fn of_sphere(setup: FitSetup, sphere: usize) -> Vec<Scaling> {
    let groups = setup.runs.film_groups_of(sphere);
    let (Some(first), Some(last)) = (groups.first(), groups.last()) else {
        return vec![];
    };
    let of_group = |group: &FilmGroup| both_laws(setup, sphere, Some(group.film_ratio), group.series.clone());
    let (mut all, mut each): (_, Vec<[Scaling; 2]>) = rayon::join(
        || both_laws(setup, sphere, None, first.series.start..last.series.end),
        || groups.par_iter().map(of_group).collect(),
    );
    for (law, own) in all.iter_mut().enumerate() {
        own.one_for_all = test_one_for_all(setup, own, &each.iter().map(|both| &both[law]).collect::<Vec<_>>());
        if let Some(test) = own.one_for_all.filter(|test| test.p < DIFFERENT && own.verdict.passed) {
            let differ = f_words(&test, 3);
            own.fitted.verdict = Verdict::failed(format!("film ratios differ ({differ}): quote each film ratio"));
        }
        if !groups.iter().all(FilmGroup::has_one_film_ratio) {
            own.withhold(WIDE_AMONG_ALL);
        }
    }
    for (group, both) in groups.iter().zip(&mut each) {
        for own in both {
            if let Some(why) = why_no_laws(group) {
                own.withhold(&why);
            }
            let (energy, estimates) = energy_of(setup, group, own);
            own.energy = Some(energy);
            own.fitted.estimates.extend(estimates);
        }
    }
    all.into_iter().chain(each.into_iter().flatten()).collect()
}

/// Why a law over all film ratios is not quoted where some have no law of their own to hold it against.
const WIDE_AMONG_ALL: &str =
    "some of its runs have no film ratio of their own: whether one law holds for all cannot be tested";

/// Compares a law over all film ratios with the same law at each.
fn test_one_for_all(setup: FitSetup, all: &Scaling, each: &[&Scaling]) -> Option<FTest> {
    if !each.iter().all(|own| own.fit.converged()) {
        return None;
    }
    let pool = |fitted: &Scaling| WetRuns::over_stokes(setup, &setup.runs.series[fitted.series.clone()]);
    let pools: Vec<WetRuns> = each.iter().map(|own| pool(own)).collect();
    let own: Vec<OwnLaw> = pools.iter().map(|pool| pool.own_law(all.law)).collect();
    let (pool, fit) = (pool(all), &all.fit);
    let regression = pool.regression(all.law);
    let sticks_at = setup.scene.data.smallest_restitution;
    let expected = regression.fitted(fit);
    one_against(fit.parameters.len(), &expected, sticks_at, &own, |variance, _| {
        regression.chi_squared(&variance, &fit.parameters)
    })
}

/// The square root and the line over the runs of some series.
fn both_laws(setup: FitSetup, index: usize, film_ratio: Option<f64>, series: Range<usize>) -> [Scaling; 2] {
    let FitSetup { scene, runs, .. } = setup;
    let pool = WetRuns::over_stokes(setup, &runs.series[series.clone()]);
    let sphere = runs.spheres[index];
    let [root, mut line] = [WetLaw::Sqrt, WetLaw::Linear].map(|law| {
        let fitted = pool.fit(LawOver::Stokes(law), index, series.clone());
        Scaling {
            particle: scene.particles[sphere.particle].name.clone(),
            diameter_m: sphere.diameter,
            film_ratio,
            law,
            runs: pool.rebounds,
            stuck: pool.stuck,
            energy: None,
            correlation: fitted.source().correlation(Quantity::EInf, Quantity::StC),
            bias: None,
            one_for_all: None,
            fitted,
        }
    });
    line.bias = linear_bias(&root.fit, &pool);
    if let Some(bias) = line.bias_in_se().filter(|bias| *bias > FAR && line.verdict.passed) {
        line.fitted.verdict = Verdict::failed(format!(
            "biased by {bias:.1} of its standard errors, since e follows the square root: quote that law"
        ));
    }
    [root, line]
}

/// Standard errors that the bias of a usable linear law may reach: a 95 % interval then covers half of the time.
const FAR: f64 = 2.0;

/// Says of every law that the linear one is to be quoted, where all film ratios together bear it out and it holds.
pub(super) fn quote_lines(laws: &mut [Scaling], line_holds: bool) {
    for law in laws {
        match law.law {
            WetLaw::Sqrt if law.verdict.passed => {
                law.fitted.verdict = Verdict::failed("the linear law describes the runs better")
            }
            WetLaw::Linear if law.parameters().is_some() && law.bias.take().is_some() => {
                law.fitted.verdict = match line_holds {
                    true => Verdict::passed("describes the runs better than the square root"),
                    false => Verdict::failed("neither law describes the runs"),
                };
            }
            _ => {}
        }
    }
}

/// Probability of the F test below which one law does not hold for all film ratios.
pub const DIFFERENT: f64 = 0.001;

/// e_inf and St_c of the square-root law at the rebounds of some series of one sphere; `None` where it gives none.
pub(super) fn square_root_of(setup: FitSetup, series: &[Series]) -> Option<[f64; 2]> {
    let pool = WetRuns::over_stokes(setup, series);
    let (fit, _) = pool.regression(WetLaw::Sqrt).fit_with_errors(pool.errors.as_ref());
    e_inf_and_st_c(WetLaw::Sqrt, two(&fit))
}

/// e_inf and St_c of a law with these parameters; `None` where they give none.
pub(super) fn e_inf_and_st_c(law: WetLaw, parameters: [f64; 2]) -> Option<[f64; 2]> {
    let wetted = LawOver::Stokes(law).wetted(parameters);
    let both = [Quantity::EInf, Quantity::StC].map(|quantity| quantity.value(&Place::NONE, &wetted));
    both.iter().all(|x| x.is_finite()).then_some(both)
}

/// Fits the linear law to the noise-free square root at the same runs: what it gets wrong without any noise.
fn linear_bias(root: &Fit, pool: &WetRuns) -> Option<Bias> {
    let of_root = e_inf_and_st_c(WetLaw::Sqrt, two(root))?;
    let exact = pool.regression(WetLaw::Sqrt).fitted(root);
    let line = pool.refitted(WetLaw::Linear, &exact, |_| true);
    let of_line = e_inf_and_st_c(WetLaw::Linear, two(&line))?;
    Some(Bias::of(of_line, of_root))
}

/// Where the energy went by a law of one film ratio: the inertial loss over the density ratio, St_c·e_inf² and δc.
fn energy_of(setup: FitSetup, group: &FilmGroup, fitted: &Scaling) -> (Energy, [(Quantity, Estimate); 3]) {
    let FitSetup { scene, runs, .. } = setup;
    let film_ratio = group.film_ratio;
    let place = WetPlace::of_group(runs, group);
    let at = Place {
        roughness: scene.particles[place.particle].roughness,
        density_ratio: place.density_ratio(scene),
    };
    let why_no_delta_c = scene.model.viscous.why_no_critical_separation().map(str::to_owned);
    let why_no_delta_c = why_no_delta_c.or_else(|| scene.why_no_roughness([place.particle]));
    let source = fitted.source();
    let cap = Inertia::Cap;
    let energy = Energy {
        density_ratio: at.density_ratio,
        stepwise: Inertia::Stepwise.shape(film_ratio, 1.0),
        cap: (film_ratio <= cap.valid_to()).then(|| cap.shape(film_ratio, 1.0)),
    };
    let delta_c = match why_no_delta_c {
        Some(why) => Quoting::of(scene).none(why),
        None => source.estimate(Quantity::DeltaC, &at),
    };
    let estimates = [
        (Quantity::InertialLoss, inertial_loss(setup, fitted, &at)),
        (Quantity::StCEInf2, source.estimate(Quantity::StCEInf2, &at)),
        (Quantity::DeltaC, delta_c),
    ];
    (energy, estimates)
}

/// (e_dry² − e_inf²)/ρ̃ with the uncertainties of k and of the fit, and what they share.
fn inertial_loss(FitSetup { scene, dry, .. }: FitSetup, fitted: &Scaling, at: &Place) -> Estimate {
    let quoting = Quoting::of(scene);
    let usable = dry::fit_of_sphere(dry, fitted.sphere).and_then(|dry| dry.usable);
    let Some((k, k_se)) = usable else {
        return quoting.none("the particle has no usable dry runs, so e_dry is not known");
    };
    let e_inf = &fitted.estimates[Quantity::EInf];
    let (Some(_), Some(parameters)) = (e_inf.value, fitted.parameters()) else {
        return quoting.none(e_inf.why_none.clone().unwrap_or_default());
    };
    // at the speed at which e_inf is quoted, with its slope in k
    let (law, v) = (scene.model.form().dry, scene.model.dry_speed.reference());
    let mut slopes = [0.0; PARAMETERS];
    slopes[2] = law.slope_dry_k(k, v);
    let value = law.restitution(k, v);
    let e_dry = Jet { value, slopes };
    if value <= 0.0 {
        return quoting.none("e_dry is not positive at the reference speed");
    }
    let (shared, own) = (fitted.shift_by_dry_k, &fitted.uncertain);
    let of_k = k_se * k_se;
    let with_k = |covariance: &DMatrix<f64>| {
        DMatrix::from_fn(PARAMETERS, PARAMETERS, |i, j| match (i, j) {
            (0 | 1, 0 | 1) => covariance[(i, j)],
            (2, 2) => of_k,
            (2, other) | (other, _) => shared[other] * of_k,
        })
    };
    let source = FittedLaw {
        wetted: fitted.over.wetted(variables(parameters)).with_e_dry(e_dry),
        uncertain: &Uncertain {
            covariance: own.covariance.as_ref().map(with_k).map_err(Clone::clone),
            degrees_of_freedom: own.degrees_of_freedom,
        },
        why_none: None,
        ..fitted.source()
    };
    source.estimate(Quantity::InertialLoss, at)
}

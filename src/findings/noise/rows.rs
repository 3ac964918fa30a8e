//! Lays out the runs about the point where the joint fit ended, by groups whose noise may have something in common.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use crate::findings::balance::{problem_of, rebounds, spheres_with_known_k, EnergyBalance};
use crate::findings::fit_verdict::is_clear;
use crate::findings::wet_fit::FitSetup;
use crate::inference::joint::{fit_joint, Joint, JointRow, Known, Part};
use crate::inference::least_squares::Stop;
use crate::inference::linearised_joint::LinearisedJoint;
use crate::inference::sums::Sums;
use crate::model::parameters::{prior_of, ParameterKind};
use crate::physics::Form;
use crate::rounding::short;
use crate::runs::Runs;
use crate::scene::Scene;
use crate::units::millimetres;

/// Dry runs have one spread, wet runs another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RunKind {
    Dry,
    Wet,
}

impl RunKind {
    pub(super) const ALL: [RunKind; 2] = [RunKind::Dry, RunKind::Wet];

    /// What runs of it are called.
    pub(super) fn word(self) -> &'static str {
        match self {
            RunKind::Dry => "dry",
            RunKind::Wet => "wet",
        }
    }
}

/// Runs of one kind, sphere with a k of its own, liquid and film ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RunGroup {
    pub(super) kind: RunKind,
    /// index into [`Runs::spheres`]
    pub(super) sphere: usize,
    pub(super) liquid: Option<usize>,
    pub(super) film_ratio: Option<f64>,
}

/// A run about a point of the joint fit.
#[derive(Clone)]
pub(super) struct RunAtFit {
    /// index into [`Rows::parts`]
    pub(super) part: usize,
    pub(super) kind: RunKind,
    pub(super) row: JointRow,
    /// error of its restitution for a unit relative error of its speed
    pub(super) error_slope: f64,
    pub(super) sd: f64,
    /// whether its setting hardly ever sticks
    pub(super) clear: bool,
}

/// The runs of the joint fit, and where it ended.
pub(super) struct Rows<'a> {
    pub(super) scene: &'a Scene,
    pub(super) runs: &'a Runs,
    pub(super) joint: Joint<'a>,
    /// where the fit ended
    pub(super) point: Vec<f64>,
    /// names of the parameters, in the order of the point
    pub(super) names: Vec<String>,
    /// dry parts, then wet ones
    pub(super) parts: Vec<Part>,
    /// the group of each part, as an index into [`Rows::groups`]
    pub(super) group_of: Vec<usize>,
    pub(super) groups: Vec<RunGroup>,
}

impl<'a> Rows<'a> {
    /// Dry runs of every usable k, and wet runs of the spheres with a place in the energy balance.
    pub(super) fn new(scene: &'a Scene, joint: Joint<'a>, point: Vec<f64>) -> Rows<'a> {
        let names = joint.kinds().map(|kind| kind.name(scene, joint.runs)).collect();
        let parts: Vec<Part> = joint.dry_parts().chain(joint.wet_parts()).cloned().collect();
        let (mut groups, mut group_of): (Vec<RunGroup>, Vec<usize>) = (vec![], vec![]);
        for part in &parts {
            let series = part.series.map(|index| &joint.runs.series[index]);
            let group = RunGroup {
                kind: if series.is_some() { RunKind::Wet } else { RunKind::Dry },
                sphere: part.sphere,
                liquid: series.map(|series| series.liquid),
                film_ratio: series.map(|series| series.film_ratio),
            };
            // the parts of a group come one after the other
            if groups.last() != Some(&group) {
                groups.push(group);
            }
            group_of.push(groups.len() - 1);
        }
        Rows {
            scene,
            runs: joint.runs,
            joint,
            point,
            names,
            parts,
            group_of,
            groups,
        }
    }

    /// Of a part, by its place.
    pub(super) fn kind(&self, part: usize) -> RunKind {
        self.groups[self.group_of[part]].kind
    }

    /// Name of the particle of a group.
    pub(super) fn particle(&self, group: &RunGroup) -> &'a str {
        &self.scene.particles[self.runs.spheres[group.sphere].particle].name
    }

    /// Name of its liquid; `None` of dry runs.
    pub(super) fn liquid(&self, group: &RunGroup) -> Option<&'a str> {
        Some(&self.scene.liquids[group.liquid?].name)
    }

    /// Particle, liquid, diameter and film ratio of a part in a sentence.
    pub(super) fn part_name(&self, part: usize) -> String {
        let group = &self.groups[self.group_of[part]];
        let diameter = format!("{} mm", short(millimetres(self.parts[part].diameter)));
        let (particle, liquid) = (self.particle(group), self.liquid(group));
        group_name(particle, liquid, Some(&diameter), group.film_ratio)
    }

    /// No runs yet: sums of the parameters, and last of an offset of all restitutions.
    pub(super) fn blank(&self) -> Sums {
        Sums::new(self.names.len() + 1)
    }

    /// Whether a rebound belongs to a setting that hardly ever sticks.
    pub(super) fn is_clear(&self, row: &JointRow, sd: f64) -> bool {
        let expected = row.residual + self.runs.restitution[row.run];
        is_clear(expected, self.scene.data.smallest_restitution, sd)
    }

    /// The slopes of a run, over its sd.
    pub(super) fn slopes(&self, run: &RunAtFit) -> Vec<(usize, f64)> {
        self.parts[run.part].slopes(&run.row, 1.0 / run.sd)
    }

    /// Adds a run to sums.
    pub(super) fn add(&self, sums: &mut Sums, run: &RunAtFit) {
        let mut slopes = self.slopes(run);
        slopes.push((self.names.len(), 1.0 / run.sd));
        sums.add(run.row.residual / run.sd, &slopes);
    }

    /// The sums of the parameters over all parts, each with its weight.
    pub(super) fn together(&self, sums: &[Sums], weight: impl Fn(usize) -> f64) -> Sums {
        let mut all = Sums::new(self.names.len());
        for (part, sums) in sums.iter().enumerate() {
            all.add_weighted(sums, weight(part));
        }
        all
    }

    /// The fit to the sums of the parts, all of them with the same weight.
    pub(super) fn fit(&self, sums: &[Sums]) -> LinearisedJoint {
        LinearisedJoint::new(&self.together(sums, |_| 1.0))
    }

    /// The rebounds about a point, with their measurement errors; not yet judged, all of them clear of sticking.
    pub(super) fn rebounds(&self, point: &[f64]) -> Vec<RunAtFit> {
        self.at(point, |part| part.rebounds.clone())
    }

    /// The same of some runs of each part.
    pub(super) fn at(&self, point: &[f64], some: impl Fn(&Part) -> Range<usize>) -> Vec<RunAtFit> {
        let mut runs = vec![];
        for (index, part) in self.parts.iter().enumerate() {
            self.joint.each_in_log_speed(part, some(part), point, |row, by_speed| {
                runs.push(RunAtFit {
                    part: index,
                    kind: self.kind(index),
                    row,
                    error_slope: by_speed.response.error_slope(),
                    sd: f64::NAN,
                    clear: true,
                });
            });
        }
        runs
    }
}

/// What an offset that some runs share has to do with the parameters.
pub(super) struct SharedOffset {
    /// Σ residual/sd²
    pub(super) gradient: f64,
    /// Σ 1/sd²
    pub(super) weight: f64,
    /// v = Σ slopes/sd²
    pub(super) slopes: DVector<f64>,
}

impl SharedOffset {
    /// From sums that have an offset last.
    pub(super) fn of(sums: &Sums) -> SharedOffset {
        let offset = sums.gradient.len() - 1;
        SharedOffset {
            gradient: sums.gradient[offset],
            weight: sums.information[(offset, offset)],
            slopes: sums.information.view((0, offset), (offset, 1)).column(0).into_owned(),
        }
    }

    /// vᵀA⁻¹v: what parameters with this A⁻¹ take up of it.
    pub(super) fn taken(&self, inverse: &DMatrix<f64>) -> f64 {
        self.slopes.dot(&(inverse * &self.slopes))
    }
}

/// Particle, liquid, diameter and film ratio in a sentence.
pub(super) fn group_name(
    particle: &str,
    liquid: Option<&str>,
    diameter: Option<&str>,
    film_ratio: Option<f64>,
) -> String {
    let ratio = film_ratio.map(|ratio| {
        let decimals = format!("{ratio:.4}");
        format!("film ratio {}", decimals.trim_end_matches('0').trim_end_matches('.'))
    });
    let parts = [
        Some(particle),
        Some(liquid.unwrap_or("dry")),
        diameter,
        ratio.as_deref(),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// The joint fit, and the values of its parameters: the energy balance's own where it holds every sphere that rebounds;
/// else those of a balance which takes unknown k from their priors. Spheres with dry runs alone follow.
pub(super) fn linearisation_point<'r>(
    setup: FitSetup<'r>,
    balance: Option<&EnergyBalance>,
    form: Form,
) -> (Joint<'r>, Vec<f64>) {
    let FitSetup { scene, runs, dry } = setup;
    let all: Vec<usize> = (0..runs.spheres.len()).filter(|s| rebounds(runs, *s)).collect();
    let of_balance = balance.filter(|_| spheres_with_known_k(runs, dry).len() == all.len());
    let found = match of_balance {
        Some(balance) => Some((balance.form(), balance.fitted_point.point.clone(), balance.stop)),
        None => with_priors(setup, form, &all),
    };
    // a direction the runs cannot see is left out later, and makes the residuals no worse
    let ended = [Stop::Converged, Stop::Degenerate].map(Stop::as_str);
    let found = found.filter(|(_, values, stop)| ended.contains(stop) && values.iter().all(|x| x.is_finite()));
    let (form, mut values, wet) = match found {
        Some((form, values, _)) => (form, values, all),
        None => (form, vec![], vec![]),
    };
    let usable = || dry.iter().filter_map(|fitted| Some((fitted.sphere, fitted.usable?)));
    let dried: Vec<usize> = usable().map(|(sphere, _)| sphere).collect();
    let joint = Joint::new(scene, runs, form, &wet, &dried);
    let alone = usable().filter(|(sphere, _)| wet.binary_search(sphere).is_err());
    values.extend(alone.map(|(_, (k, _))| k));
    (joint, values)
}

/// Spread against which a prior's k is weighed: so small that it decides only what the runs leave open.
const OPEN: f64 = 1e-6;

/// Spread against which dry runs are weighed, about that of wet restitutions: where a fit starts from.
const USUAL: f64 = 0.02;

/// Form, parameters and stop reason of a balance of all spheres that rebound; `None` without any.
fn with_priors(setup: FitSetup, form: Form, spheres: &[usize]) -> Option<(Form, Vec<f64>, &'static str)> {
    let FitSetup { scene, runs, dry } = setup;
    if spheres.is_empty() {
        return None;
    }
    let with_dry = spheres_with_known_k(runs, dry);
    let joint = Joint::new(scene, runs, form, spheres, &with_dry);
    let mut problem = problem_of(joint, dry, USUAL);
    for (index, sphere) in spheres.iter().enumerate() {
        if with_dry.binary_search(sphere).is_ok() {
            continue;
        }
        let prior = prior_of(scene, runs, ParameterKind::DryK(*sphere), form).0;
        let sd = prior.sd().filter(|sd| *sd > 0.0).unwrap_or(0.01 * prior.median());
        problem.own_k[index] = prior.median();
        problem.known.push(Known {
            place: problem.joint.shared.len() + index,
            value: prior.median(),
            root: OPEN / sd,
        });
    }
    let fit = fit_joint(&problem);
    Some((form, fit.parameters, fit.stop.as_str()))
}

//! Sizes each term of the energy balance: by how many standard errors leaving it out would move a parameter.
//!
//! With J the slopes of the restitutions in the parameters of the model without the term, W the inverse variances, and Δe
//! what the term does to each restitution, b = (JᵀWJ)⁻¹JᵀWΔe is the bias that leaving it out gives, and max |b_j|/se_j its
//! size. Below 0.25 a 95 % interval still covers 94 %. What the priors say is in JᵀWJ, too, so that a direction the runs
//! cannot see has a standard error.

use nalgebra::DVector;
use schemars::JsonSchema;
use serde::Serialize;

use super::balance::{fit_balance, rebounds, with_inertia_of, EnergyBalance};
use super::dry;
use super::form_choice::GAIN;
use super::remarks::{self, COMPARE_DRY_SPEEDS};
use super::scaling::Scaling;
use super::wet_fit::FitSetup;
use crate::inference::joint::{Joint, JointRow, Part};
use crate::inference::least_squares::Stop;
use crate::inference::linearised_joint::Inverse;
use crate::inference::sums::Sums;
use crate::model::parameters::{prior_of, ParameterKind};
use crate::physics::form::Term;
use crate::physics::Form;
use crate::remark::{Level, Remark};
use crate::rounding::with_se;
use crate::runs::Series;
use crate::scene::{NoiseOn, Prior, Scene, WetLaw};

/// Size from which a term matters: 95 % intervals of a model without it then cover less than 94 %.
pub const LINE: f64 = 0.25;

/// A term, its size, and what was decided.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SizedTerm {
    /// which
    pub term: Term,
    /// whether the model holds it
    pub held: bool,
    /// scene (named there), auto (decided by the size) or default
    pub chosen_by: &'static str,
    /// largest bias of a parameter that leaving it out gives, in its standard errors; `None` without a spread of the runs
    pub size: Option<f64>,
    /// the parameter that has it
    pub moves: Option<String>,
    /// largest change of a restitution
    pub largest_effect: f64,
    /// share of its full effect that the runs show: 0 where they show none of it, 1 where all; `None` where it is held or
    /// cannot be told
    pub runs_show: Option<f64>,
    /// standard error of that share
    pub runs_show_se: Option<f64>,
}

impl SizedTerm {
    /// Whether the runs speak clearly against its acting in full, and not for a part of it.
    pub fn is_rejected(&self) -> bool {
        self.gain_without().is_some_and(|gain| gain > GAIN) && !self.acts_in_part()
    }

    /// Whether the share that the runs show lies clearly between none and all.
    fn acts_in_part(&self) -> bool {
        /// in standard errors
        const CLEAR: f64 = 2.0;
        let shown = self.runs_show.zip(self.runs_show_se);
        shown.is_some_and(|(share, se)| share.min(1.0 - share) > CLEAR * se)
    }

    /// What a term gains over its being absent, where that is more than chance gives and it may act in full.
    fn shown_in_full(&self) -> Option<f64> {
        /// in standard errors
        const OFF: f64 = 3.0;
        let (share, se) = self.runs_show.zip(self.runs_show_se)?;
        let gain = self.gain_without().map(|gain| -gain)?;
        ((1.0 - share).abs() <= OFF * se && !remarks::TERM_ACTS.holds(gain)).then_some(gain)
    }

    /// By how much log density the runs prefer the model without the term to one in which it acts in full; `None` where
    /// they do not tell.
    pub fn gain_without(&self) -> Option<f64> {
        let (share, se) = (self.runs_show?, self.runs_show_se?);
        Some((0.5 - share) / (se * se))
    }
}

/// What a prior without a standard deviation says: nothing.
const WIDE: f64 = 1e6;

/// A fitted prefactor this many standard errors from zero says how large its term is; else its prior does.
const SEEN: f64 = 2.0;

/// Spreads of dry and of wet restitutions; `None` where the runs leave none.
fn spreads(setup: FitSetup, scaling: &[Scaling], balance: Option<&EnergyBalance>) -> Option<[f64; 2]> {
    let FitSetup { runs, dry, .. } = setup;
    let of_laws = || {
        let laws = scaling.iter().filter(|fitted| fitted.law == WetLaw::Sqrt);
        laws.filter_map(|fitted| fitted.residual_sd).reduce(f64::min)
    };
    let wet = balance.and_then(|balance| balance.residual_sd).or_else(of_laws);
    let of_dry = dry.iter().filter_map(|one| one.residual_sd).reduce(f64::max);
    // runs of one kind have their spread stand for the other's, which then weighs nothing
    let is_spread = |sd: &f64| *sd > 1e-12;
    let wet = wet.or(of_dry.filter(|_| runs.series.is_empty())).filter(is_spread)?;
    Some([of_dry.filter(is_spread).unwrap_or(wet), wet])
}

/// Every term with its size in this form; the bridge only where a liquid in use has a surface tension.
fn term_sizes(setup: FitSetup, scaling: &[Scaling], form: Form, balance: Option<&EnergyBalance>) -> Vec<SizedTerm> {
    let FitSetup { scene, runs, .. } = setup;
    let form = with_inertia_of(form, balance);
    let spheres = || 0..runs.spheres.len();
    let wet: Vec<usize> = spheres().filter(|s| rebounds(runs, *s)).collect();
    let dry: Vec<usize> = spheres().filter(|s| !runs.dry_of(*s).is_empty()).collect();
    let joint = |form: Form| Joint::new(scene, runs, form, &wet, &dry);
    let fitted = |kind: ParameterKind| {
        let (value, se) = balance?.estimate(kind)?.value_and_scale()?;
        (value > SEEN * se).then_some(value)
    };
    // where the sizes are taken
    let value = |kind: ParameterKind| {
        let of_dry = || Some(dry::fit_of_sphere(setup.dry, kind.sphere()?)?.usable?.0);
        let believed = || prior_of(scene, runs, kind, form).0.median();
        fitted(kind).or_else(of_dry).unwrap_or_else(believed)
    };
    let sums = TermSums::of(scene, form, joint, value, spreads(setup, scaling, balance));
    let tension = |series: &Series| scene.liquids[series.liquid].surface_tension.is_some();
    let has_wet = !runs.series.is_empty();
    let applies = |term: &Term| match term {
        Term::DrySecondOrder => true,
        Term::Bridge => runs.series.iter().any(tension),
        Term::Inertia | Term::Viscous | Term::OwnDrySpeed => has_wet,
    };
    // elsewhere than at a fit of every parameter, what the runs have more than the model is no misfit of it
    let is_fitted = joint(form).kinds().all(|kind| fitted(kind).is_some());
    let is_least = |own: &EnergyBalance| own.stop == Stop::Converged.as_str() && scene.model.noise != NoiseOn::Both;
    let at_fit = balance.is_some_and(is_least) && is_fitted;
    let of = |term: Term| {
        let (size, moves) = sums.bias(term).unzip();
        let held = term.is_held(form);
        let share = sums.share_shown(term).filter(|_| at_fit && !held);
        let chosen_by = match term {
            Term::OwnDrySpeed => "scene",
            _ if scene.model.terms.is_some() => "scene",
            Term::Inertia | Term::Viscous => "auto",
            Term::Bridge | Term::DrySecondOrder => "default",
        };
        let (runs_show, runs_show_se) = share.unzip();
        SizedTerm {
            term,
            held,
            chosen_by,
            size,
            moves: moves.map(|kind| kind.name(scene, runs)),
            largest_effect: sums.largest_effect[term as usize],
            runs_show,
            runs_show_se,
        }
    };
    Term::ALL.into_iter().filter(applies).map(of).collect()
}

/// Hands on every rebound of a joint fit with its part, where the parameters have these values.
fn each_rebound(joint: &Joint, value: impl Fn(ParameterKind) -> f64, mut hand_on: impl FnMut(&Part, JointRow)) {
    let point: Vec<f64> = joint.kinds().map(value).collect();
    for part in &joint.parts {
        joint.each(part, part.rebounds.clone(), &point, |row| hand_on(part, row));
    }
}

/// Weighted sums over the runs.
struct TermSums {
    form: Form,
    /// whether the runs have a spread to weigh them by
    weighed: bool,
    /// the parameters of the fit that no prior holds
    kinds: Vec<ParameterKind>,
    /// of these parameters, the priors' own information with it, and then of a factor of what each term does
    sums: Sums,
    largest_effect: [f64; Term::ALL.len()],
}

impl TermSums {
    /// The slopes of every run, and what each term does to its restitution.
    fn of<'r>(
        scene: &Scene,
        form: Form,
        of_form: impl Fn(Form) -> Joint<'r>,
        value: impl Fn(ParameterKind) -> f64,
        spreads: Option<[f64; 2]>,
    ) -> TermSums {
        let joint = of_form(form);
        let prior = |kind: ParameterKind| prior_of(scene, joint.runs, kind, form).0;
        // what a prior holds is no parameter
        let is_free = |kind: &ParameterKind| !matches!(prior(*kind), Prior::Fixed(_));
        let kinds: Vec<ParameterKind> = joint.kinds().filter(is_free).collect();
        let place = |kind: ParameterKind| kinds.iter().position(|own| *own == kind);
        let places: Vec<Option<usize>> = joint.kinds().map(place).collect();
        let mut sums = Sums::new(kinds.len() + Term::ALL.len());
        for (place, kind) in kinds.iter().enumerate() {
            let sd = prior(*kind).sd().unwrap_or(WIDE);
            sums.information[(place, place)] = 1.0 / (sd * sd);
        }
        let mut toggled = Term::ALL.map(|term| {
            let mut models = vec![];
            each_rebound(&of_form(term.toggled(form)), &value, |_, row| models.push(row.model));
            models.into_iter()
        });
        let mut largest_effect = [0.0f64; Term::ALL.len()];
        each_rebound(&joint, &value, |part, row| {
            let root = spreads.map_or(0.0, |sds| sds[usize::from(part.series.is_some())].recip());
            let root = root * joint.runs.count(row.run).sqrt();
            let own = part.slopes(&row, root).into_iter();
            let of_parameters = own.filter_map(|(j, slope)| Some((places[j]?, slope)));
            let mut slopes: Vec<(usize, f64)> = of_parameters.collect();
            for (term, models) in toggled.iter_mut().enumerate() {
                let effect = models.next().map_or(0.0, |model| model - row.model);
                largest_effect[term] = largest_effect[term].max(effect.abs());
                slopes.push((kinds.len() + term, root * effect));
            }
            sums.add(root * row.residual, &slopes);
        });
        TermSums {
            form,
            weighed: spreads.is_some(),
            kinds,
            sums,
            largest_effect,
        }
    }

    /// Whether a parameter is a term's own.
    fn owns(&self, term: Term, place: usize) -> bool {
        match self.kinds[place] {
            ParameterKind::Shared(coefficient) => term.owns(coefficient, self.form),
            _ => false,
        }
    }

    /// The places of the parameters that are not this term's own, with the inverse of what runs and priors say of them; `None`
    /// where that leaves one open.
    fn others(&self, term: Term) -> Option<(Vec<usize>, Inverse)> {
        let places: Vec<usize> = (0..self.kinds.len()).filter(|place| !self.owns(term, *place)).collect();
        let inverse = Inverse::of(&self.sums.of(&places).information);
        (self.weighed && inverse.rank == places.len()).then_some((places, inverse))
    }

    /// What a term does to the gradient in some parameters, JᵀWΔe.
    fn pull(&self, term: Term, places: &[usize]) -> DVector<f64> {
        let column = self.sums.information.column(self.kinds.len() + term as usize);
        column.select_rows(places)
    }

    /// The largest bias in standard errors, and whose it is.
    fn bias(&self, term: Term) -> Option<(f64, ParameterKind)> {
        let (places, inverse) = self.others(term)?;
        let (most, size) = inverse.moved_most(&self.pull(term, &places))?;
        size.is_finite().then(|| (size, self.kinds[places[most]]))
    }

    /// Share of the term's full effect that the runs show, with its standard error: its coefficient in a fit that is linear
    /// about this one. `None` without a spread, or where the other parameters take up all that the term does.
    fn share_shown(&self, term: Term) -> Option<(f64, f64)> {
        /// what must be left of a term's squares beside the other parameters
        const LEAST_LEFT: f64 = 1e-6;
        let (places, inverse) = self.others(term)?;
        let (pull, own) = (self.pull(term, &places), self.kinds.len() + term as usize);
        let taken = &inverse.matrix * &pull;
        let squares = self.sums.information[(own, own)];
        let left = squares - pull.dot(&taken);
        if left.is_nan() || left <= LEAST_LEFT * squares {
            return None;
        }
        let gradient = &self.sums.gradient;
        let share = (gradient.select_rows(&places).dot(&taken) - gradient[own]) / left;
        let se = left.sqrt().recip();
        (share.is_finite() && se.is_finite()).then_some((share, se))
    }
}

/// Fits the energy balance, sizes its terms, and with `terms = "auto"` leaves out what is too small to matter.
///
/// What comes back is the form to hold, its balance, and the terms with the sizes they have in it; a term that was left
/// out keeps the size it was left out for.
pub(super) fn choose_terms(setup: FitSetup, scaling: &[Scaling]) -> (Form, Option<EnergyBalance>, Vec<SizedTerm>) {
    let scene = setup.scene;
    let mut form = scene.model.form();
    let open = scene.model.inertia_is_open();
    let mut left_out: Vec<SizedTerm> = vec![];
    loop {
        let is_open = open && Term::Inertia.is_held(form);
        let balance = fit_balance(setup, scaling, form, is_open);
        let mut terms = term_sizes(setup, scaling, form, balance.as_ref());
        let may_go = |sized: &&SizedTerm| {
            let optional = matches!(sized.term, Term::Inertia | Term::Viscous) && sized.term.is_held(form);
            optional && sized.size.is_some_and(|size| size < LINE)
        };
        let size = |sized: &SizedTerm| sized.size.unwrap_or(f64::NAN);
        let smallest = terms.iter().filter(may_go).min_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(smallest) = smallest.filter(|_| scene.model.terms.is_none()) else {
            for gone in left_out {
                let same = terms.iter_mut().filter(|sized| sized.term == gone.term);
                same.for_each(|sized| *sized = gone.clone());
            }
            return (form, balance, terms);
        };
        left_out.push(SizedTerm {
            held: false,
            chosen_by: "auto",
            ..smallest.clone()
        });
        form = smallest.term.toggled(form);
    }
}

/// Whether a term wants a second look: one that matters and is not held.
pub(super) fn term_notice(sized: &SizedTerm) -> Option<Remark> {
    let size = sized.size.filter(|size| *size >= LINE && !sized.held)?;
    let name = sized.term.in_words();
    let digits = if size < 10.0 { 2 } else { 0 };
    let moved = sized.moves.as_deref();
    let far = format!(
        "{} by {size:.digits$} standard errors, a restitution by up to {:.3}",
        moved.map_or("no parameter".to_owned(), remarks::in_symbols),
        sized.largest_effect
    );
    let shown = match (sized.runs_show, sized.runs_show_se) {
        (Some(share), Some(se)) => {
            let share = with_se(share, se);
            let between = if sized.acts_in_part() {
                ", neither none nor all of it"
            } else {
                ""
            };
            format!("; the runs show {share} of its full effect{between} (0: it is absent, 1: it acts in full)")
        }
        _ => String::new(),
    };
    if sized.is_rejected() {
        let text = format!("{name}: not in the model, and the runs speak against it{shown}");
        let told = remarks::TERM_NOT_HELD.notice(1, text).at(Level::Informs);
        return Some(told.then("nothing"));
    }
    let text = format!("{name}: not in the model; if it acts, leaving it out moves {far}{shown}");
    // as many parameters either way: neither can feign a better fit
    let gain = sized.gain_without().map(|gain| -gain);
    let is_shown = |gain: &f64| sized.term == Term::OwnDrySpeed && size >= 1.0 && !remarks::DRY_SPEED.holds(*gain);
    if let Some(gain) = gain.filter(is_shown) {
        return Some(remarks::DRY_SPEED.check(gain, text));
    }
    if sized.term == Term::OwnDrySpeed {
        return Some(remarks::TERM_NOT_HELD.notice(1, text).then(COMPARE_DRY_SPEEDS));
    }
    let told = match sized.shown_in_full() {
        Some(gain) => remarks::TERM_ACTS.check(gain, text),
        None => remarks::TERM_NOT_HELD.notice(1, text),
    };
    let key = sized.term.name();
    Some(told.then(format!("name \"{key}\" with the others in [model] terms to hold it")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_term_that_the_runs_reject_is_no_caution_and_a_dry_speed_that_they_show_is_a_check() {
        let shown = |term: Term, share: f64, se: f64| {
            let sized = SizedTerm {
                term,
                held: false,
                chosen_by: "default",
                size: Some(15.0),
                moves: Some("dry_k[PTFE]".to_owned()),
                largest_effect: 0.15,
                runs_show: Some(share),
                runs_show_se: Some(se),
            };
            term_notice(&sized).expect("it matters")
        };
        let left_out = |term: Term, share: f64| shown(term, share, 0.3);
        let rejected = left_out(Term::DrySecondOrder, 0.02);
        assert!(
            !rejected.cautions() && rejected.text.contains("speak against it; the runs show"),
            "{rejected:?}"
        );
        let open = left_out(Term::DrySecondOrder, 0.47);
        assert!(
            open.cautions() && open.text.contains("leaving it out moves k of PTFE by 15"),
            "{open:?}"
        );
        // 2.8 standard errors from absent, 4.8 from full
        let in_part = shown(Term::DrySecondOrder, 0.37, 0.13);
        assert!(
            in_part.cautions()
                && in_part
                    .text
                    .contains("0.37 ± 0.13 of its full effect, neither none nor all of it"),
            "{in_part:?}"
        );
        // a difference of 0.28 is e^3.1 times as likely where it acts
        for (term, share, forbids) in [
            (Term::OwnDrySpeed, 0.78, true),
            (Term::OwnDrySpeed, 0.76, false),
            (Term::Bridge, 0.78, true),
            (Term::DrySecondOrder, 0.76, false),
            // more than its full effect
            (Term::Bridge, 1.91, false),
        ] {
            assert_eq!(left_out(term, share).forbids(), forbids, "{term:?} {share}");
        }
    }
}

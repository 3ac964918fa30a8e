//! Holds what predictions read of the posterior in `findings.json`, and says what of it no fit writes.

use serde::de::DeserializeOwned;
use serde::Deserialize;

use crate::error::quoted;
use crate::findings::predict::{Basis, Covered, ParameterDraws};
use crate::model::parameters::SERIES_OFFSET;
use crate::physics::dry::DRY_K;
use crate::physics::form::Term;
use crate::physics::numbers::same_diameter;
use crate::physics::{Coefficient, DrySpeed, Form, Setting};
use crate::runs::diameter_in_mm;
use crate::scene::NOISE;
use crate::units::micrometres;

/// The posterior, as far as predictions read it.
#[derive(Debug, Deserialize)]
pub(super) struct PosteriorRecord {
    pub left_out: Vec<HeldRecord>,
    terms: Vec<String>,
    inertia: String,
    viscous: String,
    dry_speed_m_s: Option<f64>,
    #[serde(default)]
    pub series_offsets: Vec<SeriesRecord>,
    pub basis: Basis,
}

/// A parameter that was not sampled, with the value it is held at.
#[derive(Debug, Deserialize)]
pub(super) struct HeldRecord {
    pub name: String,
    pub value: Option<f64>,
}

/// A series with an offset of its own.
#[derive(Debug, Deserialize)]
pub(super) struct SeriesRecord {
    pub name: String,
    pub particle: String,
    pub liquid: String,
    pub diameter_m: f64,
    /// smallest and largest δ/D of its runs
    pub film_ratios: [f64; 2],
}

impl SeriesRecord {
    /// Whether it was measured with the diameter and the film of a plate, but for what films are rounded by.
    pub fn is_at(&self, plate: &Setting) -> bool {
        const ROUNDING: f64 = 0.02;
        let [lo, hi] = self.film_ratios;
        let films = lo * (1.0 - ROUNDING)..=hi * (1.0 + ROUNDING);
        same_diameter(self.diameter_m, plate.diameter) && films.contains(&plate.film_ratio())
    }

    /// Its diameter and films.
    pub fn words(&self) -> String {
        let [lo, hi] = self.film_ratios.map(|ratio| micrometres(self.diameter_m * ratio));
        let more = if hi - lo < 0.5 {
            String::new()
        } else {
            format!(" to {hi:.0}")
        };
        let diameter = diameter_in_mm(self.diameter_m);
        format!("{diameter} mm with a film of {lo:.0}{more} µm")
    }
}

impl PosteriorRecord {
    /// The energy balance of the fit. Fails with the word, or the parameter, that predictions do not know.
    pub fn form(&self) -> Result<Form, String> {
        let mut names = self
            .basis
            .draws
            .iter()
            .map(|own| &own.name)
            .chain(self.left_out.iter().map(|own| &own.name));
        if let Some(unknown) = names.find(|name| limit(name).is_none()) {
            return Err(format!("the parameter {}", quoted(unknown)));
        }
        let dry_speed = self.dry_speed_m_s.map_or(DrySpeed::Impact, DrySpeed::Reference);
        let form = Form {
            viscous: known("viscous loss", &self.viscous)?,
            ..Form::new(known("inertia", &self.inertia)?, dry_speed)
        };
        let terms = self.terms.iter().map(|word| known("the term", word));
        Ok(form.with_terms(&terms.collect::<Result<Vec<Term>, String>>()?))
    }

    /// What is wrong with a number that predictions with this form start from; `None`: nothing.
    pub fn odd_number(&self, form: Form) -> Option<String> {
        let kept = self.basis.draws_kept();
        let mut drawn = self.basis.draws.iter();
        if let Some(own) = drawn.find(|own| kept == 0 || own.values.len() != kept) {
            let (name, found) = (&own.name, own.values.len());
            return Some(format!(
                "{name}: found {found} draws, expected as many of each parameter, at least one"
            ));
        }
        let smallest = self.basis.smallest_restitution;
        if !(0.0..1.0).contains(&smallest) {
            return Some(format!(
                "smallest_restitution: found {smallest:?}, expected a number from 0 to below 1"
            ));
        }
        let is_odd = |x: f64| !(x > 0.0 && x.is_finite());
        if let Some((what, x)) = self.above_zero(form).into_iter().find(|(_, x)| is_odd(*x)) {
            let found = if x.is_nan() {
                "none".to_owned()
            } else {
                format!("{x:?}")
            };
            return Some(format!("{what}: found {found}, expected a number above 0"));
        }
        let held = |own: &HeldRecord| odd_value(&own.name, own.value?, true);
        let drawn = |own: &ParameterDraws| own.values.iter().find_map(|x| odd_value(&own.name, *x, false));
        let odd = self.left_out.iter().find_map(held);
        odd.or_else(|| self.basis.draws.iter().find_map(drawn))
    }

    /// Numbers that must be above 0, with their names; NaN where there is none and must be one.
    fn above_zero(&self, form: Form) -> Vec<(String, f64)> {
        let speed = self.dry_speed_m_s.map(|speed| ("dry_speed_m_s".to_owned(), speed));
        let mut all = Vec::from_iter(speed);
        let mut add = |what: &str, name: &str, numbers: &[f64]| {
            all.extend(numbers.iter().map(|x| (format!("{what} of {}", quoted(name)), *x)));
        };
        let without_roughness = form.viscous.reads_roughness().then_some(f64::NAN);
        for own in &self.basis.liquids {
            add("density", &own.name, &[own.density_kg_m3]);
            add("viscosity", &own.name, &[own.viscosity_pa_s]);
            add("surface tension", &own.name, own.surface_tension_n_m.as_slice());
        }
        for own in &self.basis.particles {
            add("density", &own.name, &[own.density_kg_m3]);
            add("roughness", &own.name, own.roughness_m.or(without_roughness).as_slice());
            add("diameter with a k of its own", &own.name, &own.dry_k_diameters_m);
            add(
                "speeds of dry runs",
                &own.name,
                own.dry_speeds_m_s.as_slice().as_flattened(),
            );
            if let Some(Covered { stokes, film_ratio }) = &own.covered {
                add("Stokes numbers", &own.name, stokes);
                add("film ratios", &own.name, film_ratio);
            }
            for within in &own.covered_in {
                let pair = format!("{} in {}", own.name, within.liquid);
                add("impact speeds", &pair, &within.impact_speed_m_s);
                add("Stokes numbers", &pair, &within.stokes);
                add("film ratios", &pair, &within.film_ratio);
            }
        }
        all
    }
}

/// What a word of findings stands for. Fails with `what` it was to be, and the word.
fn known<T: DeserializeOwned>(what: &str, word: &str) -> Result<T, String> {
    serde_json::from_value(word.into()).map_err(|_| format!("{what} {}", quoted(word)))
}

/// What a parameter lies above, and whether it may be held at 0: where the term it scales is left out, or measurement errors
/// are all that scatters the runs. `None` of a name that predictions do not know.
fn limit(name: &str) -> Option<(f64, bool)> {
    let mut of_terms = Coefficient::ALL.into_iter().map(Coefficient::describe);
    if let Some(own) = NOISE.iter().find(|own| own.name == name) {
        Some((own.least, own.may_be_zero))
    } else if let Some(own) = of_terms.find(|own| own.name == name) {
        Some((0.0, !own.must_be_positive))
    } else if name.starts_with(SERIES_OFFSET) {
        Some((f64::NEG_INFINITY, true))
    } else {
        let of_sphere = name.strip_prefix(DRY_K.name)?.starts_with('[');
        of_sphere.then_some((0.0, false))
    }
}

/// What is wrong with a parameter's value; `None`: nothing.
fn odd_value(name: &str, x: f64, held: bool) -> Option<String> {
    let (least, may_be_zero) = limit(name)?;
    let holds = x.is_finite() && (x > least || held && may_be_zero && x == 0.0);
    let expected = match least.is_finite() {
        true => format!("a number above {least}"),
        false => "a number".to_owned(),
    };
    (!holds).then(|| format!("{name}: found {x:?}, expected {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{Inertia, Viscous};

    #[test]
    fn each_form_is_read_by_the_word_it_is_written_with() {
        fn check<T>(all: &[T], name: fn(T) -> &'static str)
        where
            T: Copy + PartialEq + std::fmt::Debug + serde::Serialize + DeserializeOwned,
        {
            for one in all {
                assert_eq!(serde_json::to_value(one).expect("a word"), name(*one));
                assert_eq!(known("it", name(*one)), Ok(*one));
            }
            assert_eq!(known::<T>("it", "stairs"), Err("it `stairs`".to_owned()));
        }
        check(&Inertia::ALL, Inertia::name);
        check(&Viscous::ALL, Viscous::name);
        check(&Term::ALL, Term::name);
    }

    #[test]
    fn a_value_beyond_its_limit_is_told_with_what_was_expected() {
        for (name, value, held, expected) in [
            ("nu", 2.0, false, "nu: found 2.0, expected a number above 2"),
            (
                "sigma_wet",
                0.0,
                false,
                "sigma_wet: found 0.0, expected a number above 0",
            ),
            (
                "film_scale",
                0.0,
                true,
                "film_scale: found 0.0, expected a number above 0",
            ),
            ("asymmetry", f64::NAN, false, "asymmetry: found NaN, expected a number"),
            (
                "dry_k[PE]",
                f64::INFINITY,
                false,
                "dry_k[PE]: found inf, expected a number above 0",
            ),
        ] {
            assert_eq!(odd_value(name, value, held).as_deref(), Some(expected));
        }
        for (name, value) in [("sigma_wet", 0.0), ("lubrication_log", 0.0), ("asymmetry", -0.5)] {
            assert_eq!(odd_value(name, value, true), None);
        }
        assert_eq!(limit("sigma_kept"), None);
    }
}

//! Reads back from a report's `findings.json` what predictions start from, or says what it lacks.
//!
//! Nothing in it is taken on trust: every number must be one that a fit can have found.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::error::{named, quoted, Error};
use crate::files;
use crate::findings::dry::name_of_k;
use crate::findings::posterior::HeldParameter;
use crate::findings::predict::{offset_of_new_series, Basis, Draw, ParameterDraws, ParticleBasis, ParticleLaw};
use crate::findings::remarks::NOISE_GROWS;
use crate::findings::SCHEMA;
use crate::model::likelihood::tails::Tails;
use crate::physics::coefficient::Coefficients;
use crate::physics::dry::DRY_K;
use crate::physics::form::Term;
use crate::physics::numbers::same_diameter;
use crate::physics::{Coefficient, DrySpeed, Form, Inertia, Parameters, Viscous};
use crate::remark::Level;
use crate::runs::diameter_in_mm;
use crate::scene::{name_expected, LikelihoodFamily, NOISE, SIGMA_DRY, SIGMA_ENERGY, SIGMA_SERIES, SIGMA_WET};

/// The findings in a report's folder.
const FINDINGS: &str = "findings.json";

/// Most bytes of a `findings.json`: far more than any has.
const MOST_BYTES: u64 = 64 << 20;

/// A finished fit with a posterior.
#[derive(Debug)]
pub struct Finished {
    folder: PathBuf,
    /// title of the scene
    pub title: String,
    /// the gating checks that failed, in words; empty: the numbers may be quoted
    pub failed: Vec<String>,
    /// that the noise of wet runs grows, so that bands of single runs are too wide at one end and too narrow at the other;
    /// in words
    pub noise_grows: Option<String>,
    posterior: PosteriorRecord,
}

#[derive(Deserialize)]
struct FindingsHeader {
    schema: String,
    wetcor: String,
    title: String,
}

#[derive(Deserialize)]
struct FindingsRecord {
    posterior: Option<PosteriorRecord>,
    remarks: Vec<RemarkRecord>,
}

#[derive(Deserialize)]
struct RemarkRecord {
    code: String,
    level: Level,
    passed: bool,
    text: String,
    next_step: String,
}

impl RemarkRecord {
    /// What was found, with what to do.
    fn told(&self) -> String {
        match self.next_step.as_str() {
            "" => self.text.clone(),
            next_step => format!("{}; {next_step}", self.text),
        }
    }
}

/// The posterior, as far as predictions read it.
#[derive(Debug, Deserialize)]
struct PosteriorRecord {
    left_out: Vec<HeldParameter>,
    terms: Vec<Term>,
    inertia: Inertia,
    viscous: Viscous,
    dry_speed_m_s: Option<f64>,
    basis: Basis,
}

impl PosteriorRecord {
    /// The energy balance of the fit.
    fn form(&self) -> Form {
        let dry_speed = self.dry_speed_m_s.map_or(DrySpeed::Impact, DrySpeed::Reference);
        let viscous = self.viscous;
        Form {
            viscous,
            ..Form::new(self.inertia, dry_speed)
        }
        .with_terms(&self.terms)
    }

    /// A parameter that predictions do not know.
    fn unknown_parameter(&self) -> Option<&str> {
        let drawn = self.basis.draws.iter().map(|own| &own.name);
        let mut names = drawn.chain(self.left_out.iter().map(|own| &own.name));
        names.find(|name| limit(name).is_none()).map(String::as_str)
    }

    /// What is wrong with a number that predictions start from; `None`: nothing.
    fn odd_number(&self) -> Option<String> {
        let basis = &self.basis;
        let kept = basis.draws_kept();
        let mut drawn = basis.draws.iter();
        if let Some(own) = drawn.find(|own| kept == 0 || own.values.len() != kept) {
            let (name, found) = (&own.name, own.values.len());
            return Some(format!(
                "{name}: found {found} draws, expected as many of each parameter, at least one"
            ));
        }
        let smallest = basis.smallest_restitution;
        if !(0.0..1.0).contains(&smallest) {
            return Some(format!(
                "smallest_restitution: found {smallest:?}, expected a number from 0 to below 1"
            ));
        }
        let reads_roughness = self.form().viscous.reads_roughness();
        let mut smooth = basis
            .particles
            .iter()
            .filter(|own| reads_roughness && own.roughness_m.is_none());
        if let Some(own) = smooth.next() {
            let name = quoted(&own.name);
            return Some(format!("roughness of {name}: found none, expected a number above 0"));
        }
        let particles = basis.particles.iter().map(|own| (&own.name, serde_json::json!(own)));
        let mut named = particles.chain(basis.liquids.iter().map(|own| (&own.name, serde_json::json!(own))));
        let physical = named.find_map(|(owner, numbers)| not_above_zero(owner, "", &numbers));
        let speed = self.dry_speed_m_s.filter(|speed| *speed <= 0.0);
        let speed = speed.map(|speed| format!("dry_speed_m_s: found {speed:?}, expected a number above 0"));
        let held = |own: &HeldParameter| odd_value(&own.name, own.value?, true);
        let drawn = |own: &ParameterDraws| own.values.iter().find_map(|x| odd_value(&own.name, *x, false));
        let odd = physical.or(speed).or_else(|| self.left_out.iter().find_map(held));
        odd.or_else(|| basis.draws.iter().find_map(drawn))
    }
}

/// The first number of a particle or liquid that is not above 0, as each density, viscosity, length and speed of it is.
fn not_above_zero(owner: &str, name: &str, value: &serde_json::Value) -> Option<String> {
    if let Some(x) = value.as_f64().filter(|x| *x <= 0.0) {
        return Some(format!(
            "{name} of {}: found {x:?}, expected a number above 0",
            quoted(owner)
        ));
    }
    let in_list = value.as_array().into_iter().flatten().map(|own| (name, own));
    let named = value
        .as_object()
        .into_iter()
        .flatten()
        .map(|(name, own)| (name.as_str(), own));
    let mut all = in_list.chain(named);
    all.find_map(|(name, own)| not_above_zero(owner, name, own))
}

/// What a parameter lies above, and whether it may be held at 0: where the term it scales is left out, or measurement errors
/// are all that scatters the runs. `None` of a name that predictions do not know.
fn limit(name: &str) -> Option<(f64, bool)> {
    let mut of_terms = Coefficient::ALL.into_iter().map(Coefficient::describe);
    if let Some(own) = NOISE.iter().find(|own| own.name == name) {
        Some((own.least, own.may_be_zero))
    } else if let Some(own) = of_terms.find(|own| own.name == name) {
        Some((0.0, !own.must_be_positive))
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

impl Finished {
    /// Reads `findings.json` of a folder.
    ///
    /// Fails where the folder is no report, of another version, or of a fit without a posterior.
    pub fn read(folder: &Path) -> Result<Finished, Error> {
        let bytes = read_findings(folder)?;
        let refuse = |problem: &dyn Display| refuse(folder, problem);
        let no_json = |error: serde_json::Error| refuse(&format!("no findings of wetcor ({error})"));
        let header: FindingsHeader = serde_json::from_slice(&bytes).map_err(no_json)?;
        if header.schema != SCHEMA {
            let found = quoted(&header.schema);
            return Err(refuse(&format!("found schema {found}, expected `{SCHEMA}`")));
        }
        let ours = env!("CARGO_PKG_VERSION");
        if header.wetcor != ours {
            let theirs = quoted(&header.wetcor);
            let other = format!("written by wetcor {theirs}, this is `{ours}`, whose formulas may differ");
            return Err(refuse(&other));
        }
        let file: FindingsRecord = serde_json::from_slice(&bytes).map_err(no_json)?;
        let posterior = file.posterior;
        let posterior = posterior.ok_or_else(|| refuse(&"the fit has no posterior to predict from"))?;
        if let Some(unknown) = posterior.unknown_parameter() {
            let (folder, unknown) = (folder.display(), quoted(unknown));
            return Err(Error::Usage(format!(
                "{folder}: the fit has the parameter {unknown}, which predict does not know"
            )));
        }
        if let Some(odd) = posterior.odd_number() {
            return Err(refuse(&odd));
        }
        let failed = file.remarks.iter().filter(|own| !own.passed);
        let forbidding = failed.clone().filter(|own| own.level == Level::Forbids);
        let growing = failed.clone().find(|own| own.code == NOISE_GROWS.code);
        Ok(Finished {
            folder: folder.to_path_buf(),
            title: header.title,
            failed: forbidding.map(RemarkRecord::told).collect(),
            noise_grows: growing.map(|own| own.text.clone()),
            posterior,
        })
    }

    /// The scene's numbers.
    pub fn basis(&self) -> &Basis {
        &self.posterior.basis
    }

    /// A particle that the fit has a k of.
    ///
    /// Fails with those there are.
    pub fn particle(&self, name: &str) -> Result<&ParticleBasis, Error> {
        let particles = self.basis().particles.iter();
        match particles.clone().find(|own| own.name == name) {
            Some(own) if self.has_k(own) => Ok(own),
            Some(_) => Err(Error::Usage(format!(
                "--particle: {} has no runs in use, so the fit has no k of it; add dry runs of it and fit again",
                quoted(name)
            ))),
            None => {
                let names = particles.clone().map(|own| own.name.as_str());
                let with_k: Vec<&str> = particles
                    .filter(|own| self.has_k(own))
                    .map(|own| own.name.as_str())
                    .collect();
                let expected = name_expected(&format!("one of {}", with_k.join(", ")), name, names);
                Err(Error::Usage(format!(
                    "--particle: the fit has no k of {}; {expected}",
                    quoted(name)
                )))
            }
        }
    }

    /// Whether series have offsets, so that [`Finished::law`] is that of a new one.
    pub fn has_offsets(&self) -> bool {
        self.has(SIGMA_SERIES.name)
    }

    /// The law of wet or of dry impacts of a particle of a diameter, m, which is read where each has its own k. Where
    /// series have offsets it is that of a new series.
    ///
    /// Fails for a particle or diameter that the fit has no k of, and for a fit without such runs.
    pub fn law(&self, particle: &str, diameter: f64, is_wet: bool) -> Result<ParticleLaw, Error> {
        let known = self.particle(particle)?;
        let own = &known.dry_k_diameters_m;
        let sphere = own.iter().copied().find(|own| same_diameter(*own, diameter));
        if sphere.is_none() && !own.is_empty() {
            return Err(refuse_diameter(known, diameter));
        }
        let dry_k = name_of_k(particle, sphere);
        let name = |own: Coefficient| own.describe().name;
        let (runs, sigma) = if is_wet {
            ("wet", SIGMA_WET.name)
        } else {
            ("dry", SIGMA_DRY.name)
        };
        let form = self.posterior.form();
        let of_terms = form.coefficients().map(name).filter(|_| is_wet);
        let mut needed = [dry_k.as_str()].into_iter().chain(of_terms).chain([sigma]);
        if let Some(missing) = needed.find(|name| !self.has(name)) {
            let folder = self.folder.display();
            let text = format!("{folder}: the fit has no {missing}: it needs {runs} runs");
            return Err(Error::Usage(text));
        }
        // the one whose shape was drawn
        let mut families = LikelihoodFamily::NAMED.into_iter().map(|(_, family)| family);
        let has_shape = |family: &LikelihoodFamily| family.shape().is_some_and(|own| self.has(own.name));
        let family = families.find(has_shape).unwrap_or(LikelihoodFamily::Normal);
        let shape = family.shape().map_or("", |own| own.name);
        let noise = [
            SIGMA_DRY.name,
            SIGMA_WET.name,
            SIGMA_ENERGY.name,
            shape,
            SIGMA_SERIES.name,
        ];
        let names = [&[dry_k.as_str()][..], &Coefficient::ALL.map(name), &noise].concat();
        let columns: Vec<Vec<f64>> = names.iter().map(|name| self.column(name)).collect();
        let draws = (0..self.basis().draws_kept()).map(|draw| {
            let values: Vec<f64> = columns.iter().map(|column| column[draw]).collect();
            let (physical, noise) = values.split_at(1 + Coefficient::COUNT);
            Draw {
                parameters: Parameters {
                    dry_k: physical[0],
                    shared: Coefficients::first_of(&physical[1..]),
                },
                sigma_dry: noise[0],
                sigma_wet: noise[1],
                sigma_energy: noise[2],
                tails: Tails::of(family, noise[3]),
                series_offset: offset_of_new_series(draw, noise[4]),
            }
        });
        Ok(self.basis().law(known, form, draws.collect()))
    }

    /// A parameter in every draw: of one that was not sampled the value it is held at, of one that the fit does not have 0.
    fn column(&self, name: &str) -> Vec<f64> {
        match self.basis().draws_of(name) {
            Some(drawn) => drawn.to_vec(),
            None => vec![self.held(name).unwrap_or(0.0); self.basis().draws_kept()],
        }
    }

    /// The value a parameter is held at.
    fn held(&self, name: &str) -> Option<f64> {
        self.posterior.left_out.iter().find(|own| own.name == name)?.value
    }

    fn has(&self, name: &str) -> bool {
        self.basis().draws_of(name).is_some() || self.held(name).is_some()
    }

    /// Whether the fit has a k of a particle, at every diameter or at one.
    fn has_k(&self, particle: &ParticleBasis) -> bool {
        let own = particle.dry_k_diameters_m.iter().copied().map(Some);
        own.chain([None])
            .any(|diameter| self.has(&name_of_k(&particle.name, diameter)))
    }
}

fn refuse_diameter(particle: &ParticleBasis, diameter: f64) -> Error {
    let own = particle.dry_k_diameters_m.iter();
    let own: Vec<String> = own.map(|own| diameter_in_mm(*own).to_string()).collect();
    Error::Usage(format!(
        "--diameter-mm: found {}, expected one of {}: each diameter of {} has its own k, and this fit has no other",
        diameter_in_mm(diameter),
        own.join(", "),
        quoted(&particle.name)
    ))
}

/// The bytes of the folder's findings.
fn read_findings(folder: &Path) -> Result<Vec<u8>, Error> {
    files::read(&folder.join(FINDINGS), MOST_BYTES, "read").map_err(|error| match error {
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            refuse(folder, &"no findings of a fit")
        }
        Error::Input { problems, .. } => {
            let found: Vec<String> = problems.iter().map(ToString::to_string).collect();
            refuse(folder, &found.join(", "))
        }
        other => other,
    })
}

/// Says what is wrong with the findings, and the command that writes a folder predictions can be made from.
fn refuse(folder: &Path, problem: &dyn Display) -> Error {
    let again = format!("run `wetcor fit SCENE --out {}` with every stage", named(folder));
    Error::Usage(format!("{}: {problem}; {again}", folder.join(FINDINGS).display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::DeserializeOwned;

    #[test]
    fn each_form_is_read_by_the_word_it_is_written_with() {
        fn check<T>(all: &[T], name: fn(T) -> &'static str)
        where
            T: Copy + PartialEq + std::fmt::Debug + serde::Serialize + DeserializeOwned,
        {
            for one in all {
                assert_eq!(serde_json::to_value(one).expect("a word"), name(*one));
                assert_eq!(serde_json::from_value::<T>(name(*one).into()).ok(), Some(*one));
            }
        }
        check(&Inertia::ALL, Inertia::name);
        check(&Viscous::ALL, Viscous::name);
        check(&Term::ALL, Term::name);
    }
}

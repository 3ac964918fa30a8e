//! Reads back from a finished report's folder what predictions start from, or says what the folder lacks.
//!
//! A folder that is kept without its draws, as one in a repository is, has the posterior's means and covariance in
//! `findings.json`: draws of the normal with these stand in, and are called so.
//!
//! Nothing in a folder is taken on trust: its parts must be those that were written together (see [`Tie`]), and every number
//! must be one that a fit can have found.

use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::draws::csv;
use super::draws::tie::{Tie, STORE, TABLE};
use super::normal_draws::{normal_draws, Moments};
use super::posterior_record::{odd_value, PosteriorRecord, SeriesRecord};
use crate::encoding::decode;
use crate::error::{named, quoted, Error};
use crate::files;
use crate::findings::posterior::MOST_NUMBERS;
use crate::findings::predict::{offset_of_new_series, Basis, Draw, ParticleBasis, ParticleLaw, PredictedSeries};
use crate::findings::remarks::NOISE_GROWS;
use crate::findings::SCHEMA;
use crate::model::likelihood::tails::Tails;
use crate::physics::coefficient::Coefficients;
use crate::physics::dry::DRY_K;
use crate::physics::numbers::same_diameter;
use crate::physics::{Coefficient, Form, Parameters, Setting};
use crate::runs::{diameter_in_mm, sphere_label};
use crate::scene::{name_expected, LikelihoodFamily, SIGMA_DRY, SIGMA_ENERGY, SIGMA_SERIES, SIGMA_WET};
use crate::seed::sha256;
use crate::units::micrometres;

/// The findings in a report's folder.
const FINDINGS: &str = "findings.json";

/// Most bytes of a `findings.json` or a store's `zarr.json`: far more than any has.
const MOST_BYTES: u64 = 64 << 20;

/// Most bytes of the table of draws, whose numbers have some 20 each.
const MOST_BYTES_OF_DRAWS: u64 = 32 * MOST_NUMBERS as u64;

/// Draws of all laws together that are kept in case they are asked for again: some 500 MB.
const MOST_DRAWS_HELD: usize = 4_000_000;

/// A finished fit with a posterior.
#[derive(Debug)]
pub struct Finished {
    folder: PathBuf,
    /// SHA-256 of its `findings.json`
    sha256: String,
    /// title of the scene
    pub title: String,
    /// the gating checks that failed, in words; empty: the numbers may be quoted
    pub failed: Vec<String>,
    /// that the noise of wet runs grows, so that bands of single runs are too wide at one end and too narrow at the other;
    /// in words
    pub noise_grows: Option<String>,
    /// the scene's numbers
    pub basis: Basis,
    form: Form,
    posterior: PosteriorRecord,
    /// the laws asked for before: the draws of each are read once
    laws: RefCell<HashMap<LawName, Arc<ParticleLaw>>>,
}

/// The names of a law's k and of its offset; without the latter that of dry runs.
type LawName = (String, Option<String>);

#[derive(Deserialize)]
struct FindingsHeader {
    schema: String,
    wetcor: String,
    title: String,
}

#[derive(Deserialize)]
struct FindingsRecord {
    posterior: Option<PosteriorRecord>,
    verdicts: Vec<CheckRecord>,
    #[serde(default)]
    notices: Vec<NoticeRecord>,
}

#[derive(Deserialize)]
struct NoticeRecord {
    code: String,
    text: String,
}

#[derive(Deserialize)]
struct CheckRecord {
    passed: bool,
    gates: bool,
    text: String,
    #[serde(default)]
    advice: String,
}

impl CheckRecord {
    /// What was found, with what to do.
    fn told(self) -> String {
        match self.advice.as_str() {
            "" => self.text,
            advice => format!("{}; {advice}", self.text),
        }
    }
}

/// What the draws that predictions are made of were drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DrawnFrom {
    /// the posterior itself
    Posterior,
    /// the normal with its means and covariance, in the logarithms of what is positive
    NormalApproximation,
}

impl Finished {
    /// Reads `findings.json` of a folder.
    ///
    /// Fails where the folder is no report, of another version, or of a fit without a posterior.
    pub fn read(folder: &Path) -> Result<Finished, Error> {
        let bytes = read(folder, FINDINGS, "findings of a fit", MOST_BYTES)?;
        let refuse = |problem: &dyn Display| refuse(folder, FINDINGS, problem);
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
        let form = posterior.form().map_err(|unknown| {
            let folder = folder.display();
            Error::Usage(format!("{folder}: the fit has {unknown}, which predict does not know"))
        })?;
        if let Some(odd) = posterior.odd_number(form) {
            return Err(refuse(&odd));
        }
        let failed = file.verdicts.into_iter().filter(|check| check.gates && !check.passed);
        let mut notices = file.notices.into_iter();
        Ok(Finished {
            folder: folder.to_path_buf(),
            sha256: sha256(&bytes),
            title: header.title,
            failed: failed.map(CheckRecord::told).collect(),
            noise_grows: notices.find(|own| own.code == NOISE_GROWS.code).map(|own| own.text),
            basis: posterior.basis.clone(),
            form,
            posterior,
            laws: RefCell::default(),
        })
    }

    /// A particle that the fit has a k of.
    ///
    /// Fails with those there are.
    pub fn particle(&self, name: &str) -> Result<&ParticleBasis, Error> {
        let particles = self.basis.particles.iter();
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

    /// Of which series [`Finished::law`] is; `None` where series have no offsets.
    pub fn series(&self) -> Option<PredictedSeries> {
        let has_offsets = !self.posterior.series_offsets.is_empty();
        has_offsets.then_some(PredictedSeries::New)
    }

    /// The law of a particle of a diameter, m, from the folder's draws; the diameter is read where each has its own k. Where
    /// series have offsets it is that of a new series.
    ///
    /// Fails for a particle or diameter the fit has no k of, and where the draws are missing, cut short or not to be read.
    pub fn law(&self, particle: &str, diameter: f64) -> Result<Arc<ParticleLaw>, Error> {
        self.law_with(particle, diameter, Some(SIGMA_SERIES.name))
    }

    /// The same for dry impacts: what is of wet runs alone is not asked for.
    ///
    /// Fails as [`Finished::law`] does, and where the fit has no spread of dry runs.
    pub fn dry_law(&self, particle: &str, diameter: f64) -> Result<Arc<ParticleLaw>, Error> {
        self.law_with(particle, diameter, None)
    }

    /// What the draws of its laws were drawn from.
    pub fn drawn_from(&self) -> DrawnFrom {
        let kept = |name: &str| self.folder.join(name).symlink_metadata().is_ok();
        if kept(TABLE) || kept(STORE) {
            DrawnFrom::Posterior
        } else {
            DrawnFrom::NormalApproximation
        }
    }

    /// That of the series that was measured on a plate with a liquid of this name.
    ///
    /// Fails as [`Finished::law`] does, and where series have no offsets or none was measured there.
    pub fn law_of_series(&self, particle: &str, liquid: &str, plate: &Setting) -> Result<Arc<ParticleLaw>, Error> {
        let all = &self.posterior.series_offsets;
        if all.is_empty() {
            let text = "the fit has no offsets of series ([model] series_offsets), so that one law is that of all";
            return Err(Error::Usage(format!("--measured-series: {text}")));
        }
        let of_pair = all
            .iter()
            .filter(|own| own.particle == particle && own.liquid == liquid);
        let of_pair: Vec<&SeriesRecord> = of_pair.collect();
        if let Some(own) = of_pair.iter().find(|own| own.is_at(plate)) {
            return self.law_with(particle, plate.diameter, Some(&own.name));
        }
        let pair = format!("{} in {}", quoted(particle), quoted(liquid));
        Err(Error::Usage(format!(
            "--measured-series: no series of {pair} was measured at {} mm with a film of {:.0} µm; {}",
            diameter_in_mm(plate.diameter),
            micrometres(plate.film),
            match series_in_words(&of_pair) {
                words if words.is_empty() => format!("of {pair} none was"),
                words => format!("expected one of {}", words.join(", ")),
            }
        )))
    }

    /// The law of a particle of a diameter, as it was found before or from the draws: of wet runs with this offset, or with
    /// one of this spread; of dry ones without.
    fn law_with(&self, particle: &str, diameter: f64, offset: Option<&str>) -> Result<Arc<ParticleLaw>, Error> {
        let known = self.particle(particle)?;
        let own = &known.dry_k_diameters_m;
        let sphere = own.iter().copied().find(|own| same_diameter(*own, diameter));
        if sphere.is_none() && !own.is_empty() {
            return Err(refuse_diameter(known, diameter));
        }
        let asked = (name_of_k(particle, sphere), offset.map(str::to_owned));
        if let Some(before) = self.laws.borrow().get(&asked) {
            return Ok(Arc::clone(before));
        }
        let law = Arc::new(self.law_from_draws(known, &asked.0, offset)?);
        let mut laws = self.laws.borrow_mut();
        if (laws.len() + 1) * law.draws.len() > MOST_DRAWS_HELD {
            laws.clear();
        }
        laws.insert(asked, Arc::clone(&law));
        Ok(law)
    }

    fn law_from_draws(&self, known: &ParticleBasis, dry_k: &str, offset: Option<&str>) -> Result<ParticleLaw, Error> {
        let name = |own: Coefficient| own.describe().name;
        let (runs, sigma) = if offset.is_some() {
            ("wet", SIGMA_WET.name)
        } else {
            ("dry", SIGMA_DRY.name)
        };
        let of_terms = self.form.coefficients().map(name).filter(|_| offset.is_some());
        let mut needed = [dry_k].into_iter().chain(of_terms).chain([sigma]);
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
        let offset = offset.unwrap_or(SIGMA_SERIES.name);
        let noise = [SIGMA_DRY.name, SIGMA_WET.name, SIGMA_ENERGY.name, shape, offset];
        let columns = self.draws_of(&[&[dry_k][..], &Coefficient::ALL.map(name), &noise].concat())?;
        let draws = (0..columns[0].len()).map(|draw| {
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
                series_offset: match offset == SIGMA_SERIES.name {
                    true => offset_of_new_series(draw, noise[4]),
                    false => noise[4],
                },
            }
        });
        Ok(ParticleLaw {
            form: self.form,
            smallest_restitution: self.basis.smallest_restitution,
            covered: known.covered,
            ranges: self.basis.ranges(known),
            dry_speeds: known.dry_speeds_m_s,
            draws: draws.collect(),
        })
    }

    /// Draws of some parameters, in their order: of one that was not sampled the value it is held at, of one that the fit does
    /// not have 0.
    fn draws_of(&self, names: &[&str]) -> Result<Vec<Vec<f64>>, Error> {
        let sampled: Vec<&str> = names.iter().copied().filter(|name| self.is_sampled(name)).collect();
        let (file, columns) = match self.drawn_from() {
            DrawnFrom::Posterior => (TABLE, self.table_columns(&sampled)?),
            DrawnFrom::NormalApproximation => (FINDINGS, self.normal_columns(&sampled)?),
        };
        for (name, column) in sampled.iter().zip(&columns) {
            if let Some(odd) = column.iter().find_map(|x| odd_value(name, *x, false)) {
                return Err(refuse(&self.folder, file, &odd));
            }
        }
        let draws = columns.first().map_or(1, Vec::len);
        let mut columns = columns.into_iter();
        let of = |name: &&str| match self.is_sampled(name) {
            true => columns.next().unwrap_or_default(),
            false => vec![self.held(name).unwrap_or(0.0); draws],
        };
        Ok(names.iter().map(of).collect())
    }

    /// Whether there are draws of a parameter or an offset.
    fn is_sampled(&self, name: &str) -> bool {
        let all = &self.posterior;
        all.parameters.iter().any(|own| own.name == name) || all.series_offsets.iter().any(|own| own.name == name)
    }

    /// The value a parameter is held at.
    fn held(&self, name: &str) -> Option<f64> {
        self.posterior.left_out.iter().find(|own| own.name == name)?.value
    }

    fn has(&self, name: &str) -> bool {
        self.is_sampled(name) || self.held(name).is_some()
    }

    /// Whether the fit has a k of a particle, at every diameter or at one.
    fn has_k(&self, particle: &ParticleBasis) -> bool {
        let own = particle.dry_k_diameters_m.iter().copied().map(Some);
        own.chain([None])
            .any(|diameter| self.has(&name_of_k(&particle.name, diameter)))
    }

    /// Columns of the table of draws, which must be the one that was written with these findings.
    fn table_columns(&self, names: &[&str]) -> Result<Vec<Vec<f64>>, Error> {
        let bytes = read(&self.folder, TABLE, "draws to predict from", MOST_BYTES_OF_DRAWS)?;
        self.check_tie(&bytes)?;
        let PosteriorRecord { chains, draws, .. } = self.posterior;
        let read = decode(&bytes).and_then(|text| csv::read(text, names, chains * draws));
        read.map_err(|problem| refuse(&self.folder, TABLE, &problem))
    }

    /// Fails unless the findings and these draws are what the store beside them was written with.
    fn check_tie(&self, draws: &[u8]) -> Result<(), Error> {
        let store = format!("{STORE}/zarr.json");
        let root = read(&self.folder, &store, "word of what the draws belong to", MOST_BYTES)?;
        let tie = Tie::of_store(&root).map_err(|error| {
            let problem = format!("no word of what the draws belong to ({error})");
            refuse(&self.folder, &store, &problem)
        })?;
        for (name, hash, expected) in [
            (FINDINGS, &self.sha256, tie.findings_sha256),
            (TABLE, &sha256(draws), tie.draws_csv_sha256),
        ] {
            if *hash != expected {
                let why = "which names another by its hash: changed since, or of another fit";
                let problem = format!("does not belong to {STORE}, {why}");
                return Err(refuse(&self.folder, name, &problem));
            }
        }
        Ok(())
    }

    /// Columns of draws from the normal with the means and the covariance of these parameters.
    fn normal_columns(&self, names: &[&str]) -> Result<Vec<Vec<f64>>, Error> {
        let refuse = |problem: String| refuse(&self.folder, FINDINGS, &problem);
        let all = &self.posterior;
        let known = |name: &&str| {
            let place = all.parameters.iter().position(|own| own.name == **name);
            let moments = place.and_then(|place| Some((place, all.parameters[place].moments()?)));
            moments.ok_or_else(|| refuse(format!("no mean with an sd of {name}, and no draws in the folder")))
        };
        let known: Vec<(usize, Moments)> = names.iter().map(known).collect::<Result<_, _>>()?;
        let (places, moments): (Vec<usize>, Vec<Moments>) = known.into_iter().unzip();
        let cell = |i: usize, j: usize| *all.correlation.get(places[i])?.get(places[j])?;
        let correlation = DMatrix::from_fn(places.len(), places.len(), |i, j| cell(i, j).unwrap_or(f64::NAN));
        if !correlation.iter().all(|rho| rho.abs() <= 1.0 + 1e-9) {
            let problem = format!("no correlations of {}, and no draws in the folder", names.join(", "));
            return Err(refuse(problem));
        }
        Ok(normal_draws(&moments, &correlation))
    }
}

/// Where some series were measured, the first few of them.
fn series_in_words(all: &[&SeriesRecord]) -> Vec<String> {
    const SHOWN: usize = 6;
    let (shown, more) = all.split_at(all.len().min(SHOWN));
    let more = (!more.is_empty()).then(|| format!("{} more", more.len()));
    shown.iter().map(|own| own.words()).chain(more).collect()
}

/// The name of a k in files.
fn name_of_k(particle: &str, diameter: Option<f64>) -> String {
    format!("{}[{}]", DRY_K.name, sphere_label(particle, diameter))
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

/// The bytes of a file of the folder, which has no more than so many.
fn read(folder: &Path, file: &str, what: &str, most: u64) -> Result<Vec<u8>, Error> {
    files::read(&folder.join(file), most, "read").map_err(|error| match error {
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            refuse(folder, file, &format!("no {what}"))
        }
        Error::Input { problems, .. } => {
            let found: Vec<String> = problems.iter().map(ToString::to_string).collect();
            refuse(folder, file, &found.join(", "))
        }
        other => other,
    })
}

/// Says what is wrong with a file of the folder, and the command that writes a folder predictions can be made from.
fn refuse(folder: &Path, file: &str, problem: &dyn Display) -> Error {
    let again = format!("run `wetcor fit SCENE --out {}` with every stage", named(folder));
    Error::Usage(format!("{}: {problem}; {again}", folder.join(file).display()))
}

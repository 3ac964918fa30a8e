//! Reads back from a finished report's folder what predictions start from, or says what the folder lacks.
//!
//! A folder that is kept without its draws, as one in a repository is, has the posterior's means and covariance in
//! `findings.json`: draws of the normal with these stand in, and are called so.
//!
//! Nothing in a folder is taken on trust: its parts must be those that were written together (see [`Tie`]), and every number
//! must be one that a fit can have found.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::draws::csv;
use super::draws::tie::{Tie, STORE, TABLE};
use super::normal_draws::{normal_draws, Moments, DRAWS};
use crate::encoding::decode;
use crate::error::{named, quoted, Error};
use crate::files;
use crate::findings::notices::NOISE_GROWS_CODE;
use crate::findings::predict::{
    offset_of_new_series, Basis, Covered, Draw, ParticleBasis, ParticleLaw, PredictedSeries,
};
use crate::findings::SCHEMA;
use crate::model::likelihood::tails::Tails;
use crate::model::parameters::{ParameterKind, SERIES_OFFSET};
use crate::physics::coefficient::Coefficients;
use crate::physics::dry::DRY_K;
use crate::physics::form::Term;
use crate::physics::numbers::same_diameter;
use crate::physics::{Coefficient, DrySpeed, Form, Inertia, Parameters, Viscous};
use crate::runs::{diameter_in_mm, sphere_label};
use crate::scene::{name_expected, LikelihoodFamily, LARGEST_FILM_RATIO, MOST_KEPT};
use crate::seed::sha256;
use crate::units::micrometres;

/// Most bytes of a `findings.json` or a store's `zarr.json`: far more than any has.
const MOST_BYTES: u64 = 64 << 20;

/// Columns of the table of draws before those of the parameters: chain, iteration, draw.
const CONTROLS: u64 = 3;

/// Fewest and most bytes a number of the table of draws takes, with what parts it from the next.
const BYTES_A_NUMBER: [u64; 2] = [2, 32];

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
    posterior: PosteriorRecord,
    /// the laws asked for before: the draws of each are read once
    laws: RefCell<HashMap<(String, Impacts), Arc<ParticleLaw>>>,
}

/// Draws of all laws together that are kept in case they are asked for again: some 500 MB.
const MOST_DRAWS_HELD: usize = 4_000_000;

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
}

#[derive(Debug, Deserialize)]
struct PosteriorRecord {
    parameters: Vec<ParameterRecord>,
    left_out: Vec<Named>,
    #[serde(default)]
    correlation: Vec<Vec<Option<f64>>>,
    chains: usize,
    draws: usize,
    terms: Vec<String>,
    inertia: String,
    viscous: String,
    dry_speed_m_s: Option<f64>,
    #[serde(default)]
    series_offsets: Vec<SeriesRecord>,
    basis: Basis,
}

/// A series with an offset of its own.
#[derive(Debug, Deserialize)]
struct SeriesRecord {
    name: String,
    particle: String,
    liquid: String,
    diameter_m: f64,
    /// smallest and largest δ/D of its runs
    film_ratios: [f64; 2],
}

/// Where a series is looked for.
#[derive(Debug, Clone, Copy)]
pub struct SeriesSetting<'a> {
    /// name of the particle
    pub particle: &'a str,
    /// name of the liquid
    pub liquid: &'a str,
    /// D, m
    pub diameter: f64,
    /// δ/D
    pub film_ratio: f64,
}

impl SeriesRecord {
    /// Whether it was measured at a setting, but for what films are rounded by.
    fn is_at(&self, setting: &SeriesSetting) -> bool {
        const ROUNDING: f64 = 0.02;
        let [lo, hi] = self.film_ratios;
        let film = (lo * (1.0 - ROUNDING)..=hi * (1.0 + ROUNDING)).contains(&setting.film_ratio);
        let same = self.particle == setting.particle && self.liquid == setting.liquid;
        same && same_diameter(self.diameter_m, setting.diameter) && film
    }
}

/// A sampled parameter.
#[derive(Debug, Deserialize)]
struct ParameterRecord {
    name: String,
    #[serde(default)]
    mean: Option<f64>,
    #[serde(default)]
    sd: Option<f64>,
    #[serde(default)]
    prior: Option<PriorRecord>,
}

#[derive(Debug, Deserialize)]
struct PriorRecord {
    /// the parameter lies above this
    lower: f64,
}

/// A parameter that was not sampled; its value where it was held at one.
#[derive(Debug, Deserialize)]
struct Named {
    name: String,
    #[serde(default)]
    value: Option<f64>,
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

impl DrawnFrom {
    /// Its word in files.
    pub fn name(self) -> &'static str {
        match self {
            DrawnFrom::Posterior => "posterior",
            DrawnFrom::NormalApproximation => "normal_approximation",
        }
    }
}

/// The impacts a law is asked for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Impacts {
    Dry,
    /// wet ones of a series that was not measured
    New,
    /// wet ones of the series whose offset has this name
    Measured(String),
}

/// Where a parameter's values come from.
enum Source {
    /// a column of the draws
    Column(Vec<f64>),
    /// held at one value
    Held(f64),
}

impl Source {
    fn at(&self, draw: usize) -> f64 {
        match self {
            Source::Column(values) => values[draw],
            Source::Held(value) => *value,
        }
    }
}

impl Finished {
    /// Reads `findings.json` of a folder.
    ///
    /// Fails where the folder is no report, of another version, or of a fit without a posterior.
    pub fn read(folder: &Path) -> Result<Finished, Error> {
        let path = folder.join("findings.json");
        let bytes = read(&path, "findings of a fit", folder, MOST_BYTES)?;
        let no_json = |error: &dyn std::fmt::Display| {
            let text = format!("{}: no findings of wetcor ({error})", path.display());
            Error::Usage(format!("{text}; {}", again(folder)))
        };
        let mark: FindingsHeader = serde_json::from_slice(&bytes).map_err(|error| no_json(&error))?;
        let ours = env!("CARGO_PKG_VERSION");
        if mark.schema != SCHEMA {
            let found = quoted(&mark.schema);
            let text = format!("{}: found schema {found}, expected `{SCHEMA}`", path.display());
            return Err(Error::Usage(format!("{text}; {}", again(folder))));
        }
        if mark.wetcor != ours {
            let (theirs, path) = (quoted(&mark.wetcor), path.display());
            let text = format!("{path}: written by wetcor {theirs}, this is `{ours}`, whose formulas may differ");
            return Err(Error::Usage(format!("{text}; {}", again(folder))));
        }
        let file: FindingsRecord = serde_json::from_slice(&bytes).map_err(|error| no_json(&error))?;
        let Some(posterior) = file.posterior else {
            let text = format!("{}: the fit has no posterior to predict from", path.display());
            return Err(Error::Usage(format!("{text}; {}", again(folder))));
        };
        let failed = file.verdicts.into_iter().filter(|check| check.gates && !check.passed);
        let grows = |notice: NoticeRecord| (notice.code == NOISE_GROWS_CODE).then_some(notice.text);
        if let Some(odd) = odd_number(&posterior) {
            let text = format!("{}: {odd}", path.display());
            return Err(Error::Usage(format!("{text}; {}", again(folder))));
        }
        Ok(Finished {
            folder: folder.to_path_buf(),
            sha256: sha256(&bytes),
            title: mark.title,
            failed: failed.map(|check| check.text).collect(),
            noise_grows: file.notices.into_iter().find_map(grows),
            basis: posterior.basis.clone(),
            posterior,
            laws: RefCell::default(),
        })
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
        self.law_with(particle, diameter, Impacts::New)
    }

    /// The same for dry impacts: what is of wet runs alone is not asked for.
    ///
    /// Fails as [`Finished::law`] does, and where the fit has no spread of dry runs.
    pub fn dry_law(&self, particle: &str, diameter: f64) -> Result<Arc<ParticleLaw>, Error> {
        self.law_with(particle, diameter, Impacts::Dry)
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

    /// That of the series that was measured at a setting.
    ///
    /// Fails as [`Finished::law`] does, and where series have no offsets or none was measured there.
    pub fn law_of_series(&self, setting: &SeriesSetting) -> Result<Arc<ParticleLaw>, Error> {
        let all = &self.posterior.series_offsets;
        if all.is_empty() {
            let text = "the fit has no offsets of series ([model] series_offsets), so that one law is that of all";
            return Err(Error::Usage(format!("--measured-series: {text}")));
        }
        let Some(own) = all.iter().find(|own| own.is_at(setting)) else {
            return Err(self.refuse_series(setting));
        };
        self.law_with(setting.particle, setting.diameter, Impacts::Measured(own.name.clone()))
    }

    /// No series was measured there: names those of the particle and liquid that were.
    fn refuse_series(&self, setting: &SeriesSetting) -> Error {
        /// so many are named
        const SHOWN: usize = 6;
        let SeriesSetting { particle, liquid, .. } = setting;
        let all = self.posterior.series_offsets.iter();
        let own = all.filter(|own| own.particle == *particle && own.liquid == *liquid);
        let mut words: Vec<String> = own
            .map(|own| {
                let [lo, hi] = own.film_ratios.map(|ratio| micrometres(own.diameter_m * ratio));
                let film = if hi - lo < 0.5 {
                    format!("{lo:.0}")
                } else {
                    format!("{lo:.0} to {hi:.0}")
                };
                format!("{} mm with a film of {film} µm", diameter_in_mm(own.diameter_m))
            })
            .collect();
        let more = words.len().saturating_sub(SHOWN);
        words.truncate(SHOWN);
        if more > 0 {
            words.push(format!("{more} more"));
        }
        let expected = if words.is_empty() {
            format!("of {} in {} none was", quoted(particle), quoted(liquid))
        } else {
            format!("expected one of {}", words.join(", "))
        };
        Error::Usage(format!(
            "--measured-series: no series of {} in {} was measured at {} mm with a film of {:.0} µm; {expected}",
            quoted(particle),
            quoted(liquid),
            diameter_in_mm(setting.diameter),
            micrometres(setting.diameter * setting.film_ratio)
        ))
    }

    /// The law of a particle of a diameter, as it was found before or from the draws.
    fn law_with(&self, particle: &str, diameter: f64, impacts: Impacts) -> Result<Arc<ParticleLaw>, Error> {
        let known = self.basis.particles.iter().find(|known| known.name == particle);
        let Some(known) = known.filter(|known| self.has_k(known)) else {
            return Err(self.refuse_particle(particle));
        };
        let sphere = match known.dry_k_diameters_m.as_slice() {
            [] => None,
            own => match own.iter().find(|own| same_diameter(**own, diameter)) {
                Some(own) => Some(*own),
                None => return Err(refuse_diameter(known, diameter)),
            },
        };
        let asked = (name_of_k(particle, sphere), impacts);
        if let Some(before) = self.laws.borrow().get(&asked) {
            return Ok(Arc::clone(before));
        }
        let law = Arc::new(self.law_from_draws(known, &asked)?);
        let mut laws = self.laws.borrow_mut();
        if (laws.len() + 1) * law.draws.len() > MOST_DRAWS_HELD {
            laws.clear();
        }
        laws.insert(asked, Arc::clone(&law));
        Ok(law)
    }

    fn law_from_draws(&self, known: &ParticleBasis, asked: &(String, Impacts)) -> Result<ParticleLaw, Error> {
        let (dry_k, impacts) = asked;
        let inertia = Inertia::ALL
            .into_iter()
            .find(|form| form.name() == self.posterior.inertia)
            .ok_or_else(|| self.unknown(&format!("inertia {}", quoted(&self.posterior.inertia))))?;
        let viscous = Viscous::ALL
            .into_iter()
            .find(|form| form.name() == self.posterior.viscous)
            .ok_or_else(|| self.unknown(&format!("viscous loss {}", quoted(&self.posterior.viscous))))?;
        let form = self.form(inertia, viscous)?;
        let known_parameters = |name: &str| {
            let physical = Coefficient::ALL
                .iter()
                .any(|coefficient| coefficient.describe().name == name);
            physical || name.starts_with("dry_k[") || NOISE.iter().any(|kind| kind.key() == name)
        };
        if let Some(new) = self.posterior.parameters.iter().find(|p| !known_parameters(&p.name)) {
            return Err(self.unknown(&format!("the parameter {}", quoted(&new.name))));
        }
        let dry = matches!(impacts, Impacts::Dry);
        // what the form does not read counts as none
        let shared = Coefficient::ALL.map(|coefficient| {
            let unread = (dry || !form.has(coefficient)).then_some(f64::NAN);
            (coefficient.describe().name.to_owned(), unread)
        });
        // the one whose shape was drawn
        let has_shape = |family: &LikelihoodFamily| self.has(ParameterKind::Shape(*family).key());
        let mut families = LikelihoodFamily::NAMED.into_iter().map(|(_, family)| family);
        let family = families.find(has_shape).unwrap_or(LikelihoodFamily::Normal);
        let optional =
            |kind: ParameterKind, none: f64| (kind.key().to_owned(), (!self.has(kind.key())).then_some(none));
        let spread = |kind: ParameterKind, of_dry: bool| (kind.key().to_owned(), (of_dry != dry).then_some(0.0));
        let mut wanted = vec![(dry_k.clone(), None)];
        wanted.extend(shared);
        wanted.extend([
            spread(ParameterKind::SigmaDry, true),
            spread(ParameterKind::SigmaWet, false),
            optional(ParameterKind::SigmaEnergy, 0.0),
            optional(ParameterKind::Shape(family), f64::NAN),
            match impacts {
                Impacts::Measured(name) => (name.clone(), None),
                Impacts::New | Impacts::Dry => optional(ParameterKind::SigmaSeries, 0.0),
            },
        ]);
        let sources = self.sources(&wanted, if dry { "dry" } else { "wet" })?;
        let draws = (0..self.draws()).map(|draw| {
            let values: Vec<f64> = sources.iter().map(|source| source.at(draw)).collect();
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
                series_offset: match impacts {
                    Impacts::Measured(_) => noise[4],
                    Impacts::New | Impacts::Dry => offset_of_new_series(draw, noise[4]),
                },
            }
        });
        Ok(ParticleLaw {
            form,
            smallest_restitution: self.basis.smallest_restitution,
            covered: known.covered,
            ranges: self.basis.ranges(known),
            dry_speeds: known.dry_speeds_m_s,
            draws: draws.collect(),
        })
    }

    /// The terms of the fit's energy balance.
    fn form(&self, inertia: Inertia, viscous: Viscous) -> Result<Form, Error> {
        let speed = self.posterior.dry_speed_m_s;
        let mut terms = vec![];
        for name in &self.posterior.terms {
            match Term::LISTED.into_iter().find(|term| term.name() == name) {
                Some(term) => terms.push(term),
                None => return Err(self.unknown(&format!("the term {}", quoted(name)))),
            }
        }
        let speed = speed.map_or(DrySpeed::Impact, DrySpeed::Reference);
        let usual = Form {
            viscous,
            ..Form::new(inertia, speed)
        };
        Ok(usual.with_terms(&terms))
    }

    fn has(&self, name: &str) -> bool {
        let mut held = self.posterior.left_out.iter().filter(|held| held.value.is_some());
        self.posterior.parameters.iter().any(|p| p.name == name) || held.any(|held| held.name == name)
    }

    /// Whether the fit has a k of a particle, at every diameter or at one.
    fn has_k(&self, particle: &ParticleBasis) -> bool {
        let mut own = particle.dry_k_diameters_m.iter();
        let of_diameter = |diameter: Option<f64>| self.has(&name_of_k(&particle.name, diameter));
        of_diameter(None) || own.any(|diameter| of_diameter(Some(*diameter)))
    }

    fn refuse_particle(&self, particle: &str) -> Error {
        let name = quoted(particle);
        let particles = self.basis.particles.iter();
        let names = particles.clone().map(|known| known.name.as_str());
        if self.basis.particles.iter().any(|known| known.name == particle) {
            let text = format!("--particle: {name} has no runs in use, so the fit has no k of it");
            return Error::Usage(format!("{text}; add dry runs of it and fit again"));
        }
        let with_k = particles.filter(|known| self.has_k(known));
        let with_k: Vec<&str> = with_k.map(|known| known.name.as_str()).collect();
        let expected = name_expected(&format!("one of {}", with_k.join(", ")), particle, names);
        Error::Usage(format!("--particle: the fit has no k of {name}; {expected}"))
    }

    /// Something a later version may fit and this one cannot predict with.
    fn unknown(&self, what: &str) -> Error {
        let folder = self.folder.display();
        Error::Usage(format!("{folder}: the fit has {what}, which predict does not know"))
    }

    /// Columns of the table of draws, which must be the one that was written with these findings.
    fn columns(&self, columns: &[&str]) -> Result<Vec<Vec<f64>>, Error> {
        let path = self.folder.join(TABLE);
        let PosteriorRecord { chains, draws, .. } = self.posterior;
        let columns_of_draws = self.posterior.parameters.len() + self.posterior.series_offsets.len();
        let numbers = (chains * draws) as u64 * (columns_of_draws as u64 + CONTROLS);
        let [fewest, most] = BYTES_A_NUMBER.map(|bytes| numbers * bytes);
        // the names in the header have as much room as all of a findings.json
        let bytes = read(&path, "draws to predict from", &self.folder, most + MOST_BYTES)?;
        // before memory is asked for so many
        if fewest > bytes.len() as u64 {
            let found = bytes.len();
            let problem = format!("found {found} bytes, which {chains} chains of {draws} draws do not take");
            return Err(self.refuse(&path, &problem));
        }
        self.check_tie(&bytes)?;
        let text = decode(&bytes).map_err(|problem| self.refuse(&path, &problem))?;
        let read = csv::read(text, columns, chains * draws).map_err(|problem| self.refuse(&path, &problem))?;
        for (name, values) in columns.iter().zip(&read) {
            if let Some(odd) = values.iter().find_map(|x| odd_value(name, *x, false)) {
                return Err(self.refuse(&path, &odd));
            }
        }
        Ok(read)
    }

    /// Fails unless the findings and these draws are what the store beside them was written with.
    fn check_tie(&self, draws: &[u8]) -> Result<(), Error> {
        let store = self.folder.join(STORE).join("zarr.json");
        let root = read(&store, "word of what the draws belong to", &self.folder, MOST_BYTES)?;
        let tie = Tie::of_store(&root)
            .map_err(|error| self.refuse(&store, &format!("no word of what the draws belong to ({error})")))?;
        for (name, hash, expected) in [
            ("findings.json", &self.sha256, tie.findings_sha256),
            (TABLE, &sha256(draws), tie.draws_csv_sha256),
        ] {
            if *hash != expected {
                let other = format!(
                    "does not belong to {STORE}, which names another by its hash: changed since, or of another fit"
                );
                return Err(self.refuse(&self.folder.join(name), &other));
            }
        }
        Ok(())
    }

    /// Says what is wrong with a file of the folder.
    fn refuse(&self, path: &Path, problem: &dyn std::fmt::Display) -> Error {
        Error::Usage(format!("{}: {problem}; {}", path.display(), again(&self.folder)))
    }

    /// Draws a law is made of.
    fn draws(&self) -> usize {
        match self.drawn_from() {
            DrawnFrom::Posterior => self.posterior.chains * self.posterior.draws,
            DrawnFrom::NormalApproximation => DRAWS,
        }
    }

    /// Columns of draws from the normal with the means and the covariance of these parameters.
    fn normal_columns(&self, columns: &[&str]) -> Result<Vec<Vec<f64>>, Error> {
        let path = self.folder.join("findings.json");
        let of = |name: &&str| {
            let all = &self.posterior.parameters;
            let Some(place) = all.iter().position(|own| own.name == **name) else {
                let problem =
                    format!("no covariance of {name}: it is predicted from the draws, which are not in the folder");
                return Err(self.refuse(&path, &problem));
            };
            let own = &all[place];
            let lower = own.prior.as_ref().map_or(0.0, |prior| prior.lower);
            let known = own.mean.zip(own.sd).map(|(mean, sd)| Moments { mean, sd, lower });
            match known.filter(|own| own.sd > 0.0 && own.mean > own.lower) {
                Some(moments) => Ok((place, moments)),
                None => Err(self.refuse(
                    &path,
                    &format!("no mean with an sd of {name}, and no draws in the folder"),
                )),
            }
        };
        let known: Vec<(usize, Moments)> = columns.iter().map(of).collect::<Result<_, _>>()?;
        let mut correlation = DMatrix::identity(known.len(), known.len());
        for (i, (row, _)) in known.iter().enumerate() {
            for (j, (column, _)) in known.iter().enumerate() {
                let cell = self
                    .posterior
                    .correlation
                    .get(*row)
                    .and_then(|cells| *cells.get(*column)?);
                let Some(rho) = cell.filter(|rho| rho.abs() <= 1.0 + 1e-9) else {
                    let problem = format!(
                        "no correlation of {} with {}, and no draws in the folder",
                        columns[i], columns[j]
                    );
                    return Err(self.refuse(&path, &problem));
                };
                correlation[(i, j)] = rho;
            }
        }
        let moments: Vec<Moments> = known.into_iter().map(|(_, moments)| moments).collect();
        Ok(normal_draws(&moments, &correlation))
    }

    /// The values of some parameters, in that order; one with a number is not read. `runs` are those that tell them.
    fn sources(&self, wanted: &[(String, Option<f64>)], runs: &str) -> Result<Vec<Source>, Error> {
        let posterior = &self.posterior;
        let mut columns = vec![];
        for (name, unread) in wanted {
            let offset = || posterior.series_offsets.iter().any(|own| own.name == *name);
            let sampled = posterior.parameters.iter().any(|p| p.name == *name) || offset();
            if sampled {
                columns.push(name.as_str());
            } else if unread.is_none() && !self.has(name) {
                let why = format!("{}: the fit has no {name}", self.folder.display());
                return Err(Error::Usage(format!("{why}: it needs {runs} runs")));
            }
        }
        let mut read = match self.drawn_from() {
            DrawnFrom::Posterior => self.columns(&columns)?,
            DrawnFrom::NormalApproximation => self.normal_columns(&columns)?,
        };
        let sources = wanted.iter().map(|(name, unread)| {
            let column = columns.iter().position(|column| column == name);
            let held = || posterior.left_out.iter().find(|held| held.name == *name)?.value;
            match column {
                Some(place) => Source::Column(std::mem::take(&mut read[place])),
                // there is one or the other, as checked above
                None => Source::Held(held().or(*unread).unwrap_or(1.0)),
            }
        });
        Ok(sources.collect())
    }
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

/// What is wrong with the numbers a prediction starts from, the draws apart; `None`: nothing.
fn odd_number(posterior: &PosteriorRecord) -> Option<String> {
    let basis = &posterior.basis;
    let (chains, draws) = (posterior.chains, posterior.draws);
    let in_all = chains.checked_mul(draws).map(|all| all as u64);
    if !in_all.is_some_and(|all| (1..=MOST_KEPT).contains(&all)) {
        return Some(format!(
            "found {draws} draws of {chains} chains, expected from 1 to {MOST_KEPT} draws of all chains together"
        ));
    }
    let above = |place: String, x: f64| {
        let holds = x > 0.0 && x.is_finite();
        (!holds).then(|| format!("{place}: found {x:?}, expected a number above 0"))
    };
    let range = |place: String, [lo, hi]: [f64; 2], most: f64| {
        let holds = lo > 0.0 && lo <= hi && hi <= most;
        (!holds).then(|| format!("{place}: found {lo:?} to {hi:?}, expected a range above 0"))
    };
    let covered = |name: &str, covered: &Covered| {
        let of = |what: &str| format!("{what} of {}", quoted(name));
        let stokes = range(of("Stokes numbers"), covered.stokes, f64::MAX);
        stokes.or_else(|| range(of("film ratios"), covered.film_ratio, LARGEST_FILM_RATIO))
    };
    let mut forms = Viscous::ALL.into_iter();
    let reads_roughness = forms.any(|form| form.name() == posterior.viscous && form.reads_roughness());
    let particles = basis.particles.iter().find_map(|particle| {
        let density = above(format!("density of {}", quoted(&particle.name)), particle.density_kg_m3);
        let roughness = || {
            let place = format!("roughness of {}", quoted(&particle.name));
            match particle.roughness_m {
                Some(roughness) => above(place, roughness),
                None => reads_roughness.then(|| format!("{place}: found none, expected a number above 0")),
            }
        };
        let mut diameters = particle.dry_k_diameters_m.iter();
        let of_k = || format!("diameter of {} with a k of its own", quoted(&particle.name));
        density
            .or_else(roughness)
            .or_else(|| diameters.find_map(|diameter| above(of_k(), *diameter)))
            .or_else(|| covered(&particle.name, particle.covered.as_ref()?))
            .or_else(|| {
                particle.covered_in.iter().find_map(|own| {
                    let name = format!("{} in {}", particle.name, own.liquid);
                    let speeds = format!("impact speeds of {}", quoted(&name));
                    let numbers = Covered {
                        stokes: own.stokes,
                        film_ratio: own.film_ratio,
                    };
                    covered(&name, &numbers).or_else(|| range(speeds, own.impact_speed_m_s, f64::MAX))
                })
            })
    });
    let liquids = || {
        basis.liquids.iter().find_map(|liquid| {
            let name = quoted(&liquid.name);
            above(format!("density of {name}"), liquid.density_kg_m3)
                .or_else(|| above(format!("viscosity of {name}"), liquid.viscosity_pa_s))
                .or_else(|| above(format!("surface tension of {name}"), liquid.surface_tension_n_m?))
        })
    };
    let limit = || {
        let x = basis.smallest_restitution;
        let holds = (0.0..1.0).contains(&x);
        (!holds).then(|| format!("smallest_restitution: found {x:?}, expected a number from 0 to below 1"))
    };
    let speed = || above("dry_speed_m_s".to_owned(), posterior.dry_speed_m_s?);
    let held = || {
        let mut held = posterior
            .left_out
            .iter()
            .filter_map(|held| Some((&held.name, held.value?)));
        held.find_map(|(name, x)| odd_value(name, x, true))
    };
    particles.or_else(liquids).or_else(limit).or_else(speed).or_else(held)
}

/// What is wrong with a parameter's value; `None`: nothing. Held values may be 0 where the term they scale is left out, and
/// where measurement errors are all that scatters the runs.
fn odd_value(name: &str, x: f64, held: bool) -> Option<String> {
    // an offset may be of either sign
    if name.starts_with(SERIES_OFFSET) {
        return (!x.is_finite()).then(|| format!("{name}: found {x:?}, expected a number"));
    }
    let mut families = LikelihoodFamily::NAMED.into_iter();
    let shape = families.find_map(|(_, family)| family.shape().filter(|own| own.name == name));
    let least = shape.map_or(0.0, |own| own.least);
    // a term without a prefactor takes nothing
    let scales = |coefficient: &Coefficient| {
        let own = coefficient.describe();
        own.name == name && !own.must_be_positive
    };
    let is_spread = || {
        [ParameterKind::SigmaDry, ParameterKind::SigmaWet]
            .iter()
            .any(|kind| kind.key() == name)
    };
    let may_vanish = held && (Coefficient::ALL.iter().any(scales) || is_spread());
    let holds = x.is_finite() && (x > least || may_vanish && x == 0.0);
    (!holds).then(|| format!("{name}: found {x:?}, expected a number above {least:.0}"))
}

/// The parameters of the noise.
const NOISE: [ParameterKind; 6] = [
    ParameterKind::SigmaSeries,
    ParameterKind::SigmaWet,
    ParameterKind::SigmaEnergy,
    ParameterKind::Shape(LikelihoodFamily::Student),
    ParameterKind::Shape(LikelihoodFamily::AsymmetricLaplace),
    ParameterKind::SigmaDry,
];

/// The bytes of a file of the folder, which has no more than so many.
fn read(path: &Path, what: &str, folder: &Path, most: u64) -> Result<Vec<u8>, Error> {
    files::read(path, most, "read").map_err(|error| match error {
        Error::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            Error::Usage(format!("{}: no {what}; {}", path.display(), again(folder)))
        }
        Error::Input { problems, .. } => {
            let found: Vec<String> = problems.iter().map(ToString::to_string).collect();
            Error::Usage(format!("{}: {}; {}", path.display(), found.join(", "), again(folder)))
        }
        other => other,
    })
}

/// The command that writes a folder predictions can be made from.
fn again(folder: &Path) -> String {
    format!("run `wetcor fit SCENE --out {}` with every stage", named(folder))
}

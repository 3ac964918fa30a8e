//! Reads back from a finished report's folder what predictions start from, or says what the folder lacks.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::draws::csv;
use crate::encoding::decode;
use crate::error::{quoted, Error};
use crate::findings::predict::{Basis, Draw, Law};
use crate::findings::SCHEMA;
use crate::model::parameters::Kind;
use crate::physics::impact::{DrySpeed, Form, Parameters};
use crate::physics::inertia::Inertia;
use crate::scene::{form_of, name_expected, Term};

/// Where the draws lie in a report's folder.
const DRAWS: &str = "draws/draws.csv";

/// A finished fit with a posterior.
#[derive(Debug)]
pub struct Finished {
    folder: PathBuf,
    /// title of the scene
    pub title: String,
    /// the gating checks that failed, in words; empty: the numbers may be quoted
    pub failed: Vec<String>,
    /// the scene's numbers
    pub basis: Basis,
    posterior: Sampled,
}

#[derive(Deserialize)]
struct Mark {
    schema: String,
    wetcor: String,
    title: String,
}

#[derive(Deserialize)]
struct File {
    posterior: Option<Sampled>,
    verdicts: Vec<Check>,
}

#[derive(Deserialize)]
struct Check {
    passed: bool,
    gates: bool,
    text: String,
}

#[derive(Debug, Deserialize)]
struct Sampled {
    parameters: Vec<Named>,
    left_out: Vec<Named>,
    chains: usize,
    draws: usize,
    terms: Vec<String>,
    inertia: String,
    dry_speed_m_s: Option<f64>,
    basis: Basis,
}

/// A parameter; its value where it was held at one.
#[derive(Debug, Deserialize)]
struct Named {
    name: String,
    #[serde(default)]
    value: Option<f64>,
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
        let bytes = read(&path, "findings of a fit", folder)?;
        let no_json = |error: &dyn std::fmt::Display| {
            let text = format!("{}: no findings of wetcor ({error})", path.display());
            Error::Usage(format!("{text}; {}", again(folder)))
        };
        let mark: Mark = serde_json::from_slice(&bytes).map_err(|error| no_json(&error))?;
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
        let file: File = serde_json::from_slice(&bytes).map_err(|error| no_json(&error))?;
        let Some(posterior) = file.posterior else {
            let text = format!("{}: the fit has no posterior to predict from", path.display());
            return Err(Error::Usage(format!("{text}; {}", again(folder))));
        };
        let failed = file.verdicts.into_iter().filter(|check| check.gates && !check.passed);
        Ok(Finished {
            folder: folder.to_path_buf(),
            title: mark.title,
            failed: failed.map(|check| check.text).collect(),
            basis: posterior.basis.clone(),
            posterior,
        })
    }

    /// The law of a particle, from the folder's draws.
    ///
    /// Fails for a particle the fit has no k of, and where the draws are missing, cut short or not to be read.
    pub fn law(&self, particle: &str) -> Result<Law, Error> {
        let known = self.basis.particles.iter().find(|known| known.name == particle);
        let dry_k = format!("dry_k[{particle}]");
        let Some(known) = known.filter(|_| self.has(&dry_k)) else {
            return Err(self.refuse_particle(particle));
        };
        let inertia = Inertia::ALL
            .into_iter()
            .find(|form| form.name() == self.posterior.inertia)
            .ok_or_else(|| self.unknown(&format!("inertia {}", quoted(&self.posterior.inertia))))?;
        let form = self.form(inertia)?;
        let known_parameters = |name: &str| name.starts_with("dry_k[") || KINDS.iter().any(|kind| kind.key() == name);
        if let Some(new) = self.posterior.parameters.iter().find(|p| !known_parameters(&p.name)) {
            return Err(self.unknown(&format!("the parameter {}", quoted(&new.name))));
        }
        let mut wanted = vec![(dry_k, None)];
        wanted.extend(KINDS.iter().filter_map(|kind| {
            let unread = match kind {
                Kind::FilmScale => !inertia.has_film_scale(),
                Kind::InertialPrefactor => inertia == Inertia::None,
                _ => false,
            };
            // what is not there counts as none
            let instead = match kind {
                Kind::SigmaEnergy => 0.0,
                Kind::Nu => f64::INFINITY,
                _ => 1.0,
            };
            let optional = matches!(kind, Kind::SigmaEnergy | Kind::Nu);
            let unread = unread || optional && !self.has(kind.key());
            // a spread of dry runs is on no wet run's way
            (*kind != Kind::SigmaDry).then(|| (kind.key().to_owned(), unread.then_some(instead)))
        }));
        let sources = self.sources(&wanted)?;
        let draws = (0..self.posterior.chains * self.posterior.draws).map(|draw| {
            let [dry_k, lubrication_log, inertial_prefactor, film_scale, sigma_wet, sigma_energy, nu] =
                [0, 1, 2, 3, 4, 5, 6].map(|place: usize| sources[place].at(draw));
            Draw {
                parameters: Parameters {
                    dry_k,
                    lubrication_log,
                    inertial_prefactor,
                    film_scale,
                },
                sigma_wet,
                sigma_energy,
                nu: Some(nu).filter(|nu| nu.is_finite()),
            }
        });
        Ok(Law {
            form,
            smallest_restitution: self.basis.smallest_restitution,
            covered: known.covered,
            draws: draws.collect(),
        })
    }

    /// The terms of the fit's energy balance.
    fn form(&self, inertia: Inertia) -> Result<Form, Error> {
        let speed = self.posterior.dry_speed_m_s;
        let mut terms = vec![];
        for name in &self.posterior.terms {
            match Term::ALL.into_iter().find(|term| term.name() == name) {
                Some(term) => terms.push(term),
                None => return Err(self.unknown(&format!("the term {}", quoted(name)))),
            }
        }
        let speed = speed.map_or(DrySpeed::Impact, DrySpeed::Reference);
        Ok(form_of(inertia, speed, Some(&terms)))
    }

    fn has(&self, name: &str) -> bool {
        let held = self.posterior.left_out.iter().filter(|held| held.value.is_some());
        self.posterior.parameters.iter().chain(held).any(|p| p.name == name)
    }

    fn refuse_particle(&self, particle: &str) -> Error {
        let name = quoted(particle);
        let names = self.basis.particles.iter().map(|known| known.name.as_str());
        if self.basis.particles.iter().any(|known| known.name == particle) {
            let text = format!("--particle: {name} has no runs in use, so the fit has no k of it");
            return Error::Usage(format!("{text}; add dry runs of it and fit again"));
        }
        let with_k: Vec<&str> = names
            .clone()
            .filter(|name| self.has(&format!("dry_k[{name}]")))
            .collect();
        let expected = name_expected(&format!("one of {}", with_k.join(", ")), particle, names);
        Error::Usage(format!("--particle: the fit has no k of {name}; {expected}"))
    }

    /// Something a later version may fit and this one cannot predict with.
    fn unknown(&self, what: &str) -> Error {
        let folder = self.folder.display();
        Error::Usage(format!("{folder}: the fit has {what}, which predict does not know"))
    }

    /// The values of some parameters, in that order; one with a number is not read.
    fn sources(&self, wanted: &[(String, Option<f64>)]) -> Result<Vec<Source>, Error> {
        let posterior = &self.posterior;
        let mut columns = vec![];
        for (name, unread) in wanted {
            let sampled = posterior.parameters.iter().any(|p| p.name == *name);
            if sampled {
                columns.push(name.as_str());
            } else if unread.is_none() && !self.has(name) {
                let why = format!("{}: the fit has no {name}", self.folder.display());
                return Err(Error::Usage(format!("{why}: it needs wet runs")));
            }
        }
        let path = self.folder.join(DRAWS);
        let bytes = read(&path, "draws to predict from", &self.folder)?;
        let refuse = |problem: &dyn std::fmt::Display| {
            let text = format!("{}: {problem}", path.display());
            Error::Usage(format!("{text}; {}", again(&self.folder)))
        };
        let text = decode(&bytes).map_err(|problem| refuse(&problem))?;
        let draws = posterior.chains * posterior.draws;
        let mut read = csv::read(text, &columns, draws).map_err(|problem| refuse(&problem))?;
        if let Some(place) = columns
            .iter()
            .zip(&read)
            .position(|(_, values)| values.iter().any(|x| !x.is_finite()))
        {
            return Err(refuse(&format!("{}: found a draw that is not finite", columns[place])));
        }
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

/// Parameters besides the k of the particles, in the order a law takes them.
const KINDS: [Kind; 7] = [
    Kind::LubricationLog,
    Kind::InertialPrefactor,
    Kind::FilmScale,
    Kind::SigmaWet,
    Kind::SigmaEnergy,
    Kind::Nu,
    Kind::SigmaDry,
];

/// The bytes of a file of the folder.
fn read(path: &Path, what: &str, folder: &Path) -> Result<Vec<u8>, Error> {
    std::fs::read(path).map_err(|error| {
        if error.kind() == std::io::ErrorKind::NotFound {
            Error::Usage(format!("{}: no {what}; {}", path.display(), again(folder)))
        } else {
            Error::io(path, "read", error)
        }
    })
}

/// The command that writes a folder predictions can be made from.
fn again(folder: &Path) -> String {
    format!("run `wetcor fit SCENE --out {}` with every stage", folder.display())
}

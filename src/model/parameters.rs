//! Lists the parameters a scene's runs call for, each with its unit, bounds, prior and where the prior comes from.

use crate::error::{quoted, Error, Problem};
use crate::physics::coefficient::Coefficients;
use crate::physics::dry::{speed_root, DRY_K};
use crate::physics::form::Term;
use crate::physics::{self, Coefficient, DrySpeed, Form, Inertia, Quantity};
use crate::runs::{Runs, Series};
use crate::scene::{
    log_normal, within, LikelihoodFamily, NoiseOn, Prior, PriorChoice, Scene, SceneParameter, NU, SIGMA_DRY,
    SIGMA_ENERGY, SIGMA_SERIES, SIGMA_WET,
};

/// What a parameter is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ParameterKind {
    /// k of a sphere, by its index in [`Runs::spheres`]
    DryK(usize),
    /// a parameter of a term, which particles share
    Shared(Coefficient),
    /// spread of the dry restitutions
    SigmaDry,
    /// spread of the wet restitutions
    SigmaWet,
    /// spread σ_r of the energy wet runs keep
    SigmaEnergy,
    /// spread σ_series of the offsets of r that the runs of a series share
    SigmaSeries,
    /// the shape of a family of noise: degrees of freedom ν of Student's, η of Laplace's
    Shape(LikelihoodFamily),
    /// L′, the slope of L in the logarithm of the film ratio
    LubricationTrend,
    /// C′, the slope of ln C in the logarithm of the film ratio
    InertialTrend,
}

impl ParameterKind {
    /// Whether it is the spread of some noise.
    pub fn is_spread(self) -> bool {
        use ParameterKind::{SigmaDry, SigmaEnergy, SigmaSeries, SigmaWet};
        matches!(self, SigmaDry | SigmaWet | SigmaEnergy | SigmaSeries)
    }

    /// L = ln(δc/ε)
    pub const LUBRICATION_LOG: ParameterKind = ParameterKind::Shared(Coefficient::LubricationLog);
    /// C
    pub const INERTIAL_PREFACTOR: ParameterKind = ParameterKind::Shared(Coefficient::InertialPrefactor);
    /// δ̃0
    pub const FILM_SCALE: ParameterKind = ParameterKind::Shared(Coefficient::FilmScale);

    /// The sphere that it is the k of, by its index; `None` of another parameter.
    pub fn sphere(self) -> Option<usize> {
        match self {
            ParameterKind::DryK(sphere) => Some(sphere),
            _ => None,
        }
    }

    /// What is said of it.
    fn describe(self) -> SceneParameter {
        match self {
            ParameterKind::DryK(_) => SceneParameter::of_physics(&DRY_K),
            ParameterKind::Shared(coefficient) => SceneParameter::of_physics(coefficient.describe()),
            ParameterKind::SigmaDry => SIGMA_DRY,
            ParameterKind::SigmaWet => SIGMA_WET,
            ParameterKind::SigmaEnergy => SIGMA_ENERGY,
            ParameterKind::SigmaSeries => SIGMA_SERIES,
            // the normal has none, and is never asked for it
            ParameterKind::Shape(family) => family.shape().unwrap_or(NU),
            ParameterKind::LubricationTrend => LUBRICATION_TREND,
            ParameterKind::InertialTrend => INERTIAL_TREND,
        }
    }

    /// The quantity it is; `None` of a parameter of the noise or a trend.
    pub fn quantity(self) -> Option<Quantity> {
        match self {
            ParameterKind::DryK(_) => Some(Quantity::DryK),
            ParameterKind::Shared(coefficient) => Some(Quantity::Shared(coefficient)),
            _ => None,
        }
    }

    /// The key of its prior in a scene.
    pub fn key(self) -> &'static str {
        self.describe().name
    }

    /// Its name in files: `lubrication_log`, `dry_k[PTFE]`, `dry_k[PTFE,4.762]`.
    pub fn name(self, scene: &Scene, runs: &Runs) -> String {
        match self {
            ParameterKind::DryK(sphere) => format!("{}[{}]", self.key(), runs.spheres[sphere].label(scene)),
            _ => self.key().to_owned(),
        }
    }

    /// The letter of the formulas.
    pub fn symbol(self) -> &'static str {
        self.describe().symbol
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        self.describe().unit
    }

    /// Its default prior, with the reason for it.
    pub fn default_prior(self, form: Form) -> (Prior, &'static str) {
        if let ParameterKind::Shared(coefficient) = self {
            let own = form.prior(coefficient);
            return (log_normal(own), own.reason);
        }
        let own = self.describe();
        (own.prior, own.reason)
    }

    /// Its place in a full vector of parameters.
    pub fn slot(self) -> usize {
        match self {
            ParameterKind::Shared(coefficient) => coefficient as usize,
            ParameterKind::SigmaWet => Coefficient::COUNT,
            ParameterKind::SigmaDry => Coefficient::COUNT + 1,
            ParameterKind::SigmaEnergy => Coefficient::COUNT + 2,
            ParameterKind::LubricationTrend => Coefficient::COUNT + 3,
            ParameterKind::InertialTrend => Coefficient::COUNT + 4,
            ParameterKind::Shape(_) => SHAPE_SLOT,
            ParameterKind::SigmaSeries => Coefficient::COUNT + 6,
            ParameterKind::DryK(sphere) => COMMON_SLOTS + sphere,
        }
    }
}

/// The parameters of the energy balance of one sphere, from a full vector.
pub fn physical(full: &[f64], sphere: usize) -> physics::Parameters {
    physics::Parameters {
        dry_k: full[ParameterKind::DryK(sphere).slot()],
        shared: Coefficients::first_of(full),
    }
}

/// The place in a full vector of the shape of the noise, whatever its family.
pub const SHAPE_SLOT: usize = Coefficient::COUNT + 5;

/// Places of a full vector before the k of the spheres.
pub const COMMON_SLOTS: usize = Coefficient::COUNT + 7;

/// The name of an offset in files, before the series it is of.
pub const SERIES_OFFSET: &str = "series_offset";

/// Most offsets: the sampler turns every two of the numbers of a draw against each other at each step.
const MOST_OFFSETS: usize = 500;

/// The place in a full vector of the offset of a series, by its index.
pub fn offset_slot(runs: &Runs, series: usize) -> usize {
    COMMON_SLOTS + runs.spheres.len() + series
}

/// The trend of L with the film ratio, of which no scene speaks.
const LUBRICATION_TREND: SceneParameter = SceneParameter {
    name: "lubrication_log_trend",
    symbol: "L′",
    meaning: "",
    example: "",
    unit: "1",
    prior: Prior::Normal(0.0, 1.0),
    reason: "default: at 1 the sphere turns round at a fixed share of the film, beyond 2 either way is past belief",
    least: f64::NEG_INFINITY,
    may_be_zero: true,
};

/// The trend of ln C with the film ratio.
const INERTIAL_TREND: SceneParameter = SceneParameter {
    name: "inertial_prefactor_trend",
    symbol: "C′",
    reason: "default: at −1 a loss that grows with the film is level, beyond 2 either way is past belief",
    ..LUBRICATION_TREND
};

/// The source of a prior that the scene gives.
pub const OF_SCENE: &str = "the scene";

/// Where a prior of the spread of the energy kept comes from that stands in no file.
pub const OF_SLOW_REBOUNDS: &str = "errors of 1 % in speed and 3 % in film of the runs that barely rebound";

/// A parameter to be sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParameter {
    /// what it is
    pub kind: ParameterKind,
    /// its name in files: `lubrication_log`, `dry_k[PTFE]`, `dry_k[PTFE,4.762]`
    pub name: String,
    /// it lies inside (lower, upper)
    pub bounds: (f64, f64),
    /// its prior, truncated to the bounds
    pub prior: Prior,
    /// where the prior comes from
    pub source: &'static str,
}

/// A parameter that is not sampled.
#[derive(Debug, Clone, PartialEq)]
pub struct LeftOut {
    /// what it is
    pub kind: ParameterKind,
    /// its name in files
    pub name: String,
    /// the value it is held at; `None` where no formula in use reads it
    pub value: Option<f64>,
    /// why
    pub reason: &'static str,
}

/// A parameter that runs may call for.
struct CandidateParameter {
    kind: ParameterKind,
    /// it lies inside (lower, upper)
    bounds: (f64, f64),
    /// why it is not sampled, if it is not, and the value it is held at
    why_not: Option<(Option<f64>, &'static str)>,
}

/// The parameters of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParameters {
    /// those to be sampled, in the order of files
    pub sampled: Vec<ModelParameter>,
    /// those that are not
    pub left_out: Vec<LeftOut>,
    /// names of the offsets of r, one for each series of the runs, which follow the sampled parameters in a draw; empty where
    /// the scene has none
    pub series_offsets: Vec<String>,
    /// a full vector with the values of those left out; the others are 1, trends and offsets 0
    pub template: Vec<f64>,
}

impl ModelParameters {
    /// The parameters that `runs` call for, with this form of the energy balance.
    ///
    /// Fails where a prior of the scene leaves a parameter no room inside its bounds, or no density that can be sampled.
    pub fn of(scene: &Scene, runs: &Runs, form: Form) -> Result<ModelParameters, Error> {
        let wet = !runs.series.is_empty();
        let dry = !runs.dry.is_empty();
        let mut parameters = ModelParameters {
            sampled: vec![],
            left_out: vec![],
            series_offsets: vec![],
            template: vec![1.0; COMMON_SLOTS + runs.spheres.len()],
        };
        for trend in [ParameterKind::LubricationTrend, ParameterKind::InertialTrend] {
            parameters.template[trend.slot()] = 0.0;
        }
        let unread = |reason| (None, reason);
        let dry_k = |sphere: usize| {
            let fastest = fastest(runs, sphere, form);
            // e_dry is positive and falls at every speed in use; beyond, e_dry² grows again and a second mode appears
            let most = fastest.map_or(f64::INFINITY, |v| form.dry.largest_loss() / speed_root(v));
            CandidateParameter {
                kind: ParameterKind::DryK(sphere),
                bounds: (0.0, most),
                why_not: fastest.is_none().then(|| unread("the particle has no runs in use")),
            }
        };
        let of_wet = |kind: ParameterKind| CandidateParameter {
            kind,
            bounds: (0.0, f64::INFINITY),
            why_not: (!wet).then(|| unread("no wet runs in use")),
        };
        let mut candidates: Vec<CandidateParameter> = (0..runs.spheres.len()).map(dry_k).collect();
        if !Term::Viscous.is_held(form) {
            let mut viscous = of_wet(ParameterKind::LUBRICATION_LOG);
            viscous
                .why_not
                .get_or_insert((Some(0.0), "the viscous loss is left out of the model"));
            candidates.push(viscous);
        }
        // what the runs cannot tell keeps its prior: held, it would make another look known
        candidates.extend(form.coefficients().map(|own| of_wet(ParameterKind::Shared(own))));
        candidates.push(CandidateParameter {
            kind: ParameterKind::SigmaDry,
            bounds: (0.0, f64::INFINITY),
            why_not: (!dry).then(|| unread("no dry runs in use")),
        });
        candidates.push(of_wet(ParameterKind::SigmaWet));
        if scene.model.noise == NoiseOn::Both {
            candidates.push(of_wet(ParameterKind::SigmaEnergy));
        }
        let family = scene.model.likelihood;
        let speeds_err = runs.errors.iter().any(|error| error.impact_speed_sd > 0.0);
        let refused = family.refused_beside("errors of the impact speeds");
        if let Some(expected) = refused.filter(|_| speeds_err) {
            return Err(Error::Usage(format!("[model] likelihood: {expected}")));
        }
        candidates.extend(family.shape().map(|own| CandidateParameter {
            kind: ParameterKind::Shape(family),
            bounds: (own.least, f64::INFINITY),
            why_not: runs.is_empty().then(|| unread("no runs in use")),
        }));
        if scene.model.series_offsets {
            candidates.push(of_wet(ParameterKind::SigmaSeries));
        }
        for candidate in candidates {
            parameters.add(scene, runs, form, candidate)?;
        }
        if scene.model.series_offsets {
            parameters.add_series_offsets(scene, runs)?;
        }
        Ok(parameters)
    }

    /// An offset for each series, 0 in the template.
    fn add_series_offsets(&mut self, scene: &Scene, runs: &Runs) -> Result<(), Error> {
        let found = runs.series.len();
        if found > MOST_OFFSETS {
            let text = format!("[model] series_offsets: found {found} series, expected at most {MOST_OFFSETS}");
            let next = "name nominal film ratios ([data] film_ratios), so that runs of one film ratio are one series";
            return Err(Error::Usage(format!("{text}; {next}")));
        }
        let name = |series: &Series| format!("{SERIES_OFFSET}[{}]", series.label(scene));
        self.series_offsets = runs.series.iter().map(name).collect();
        self.template.resize(offset_slot(runs, found), 0.0);
        Ok(())
    }

    /// The same with a trend with the film ratio sampled, too, which is otherwise held at 0.
    ///
    /// `trend` is [`ParameterKind::LubricationTrend`] or [`ParameterKind::InertialTrend`].
    pub fn with_trend(mut self, trend: ParameterKind) -> ModelParameters {
        // that of a trend is the same in every form
        let (prior, source) = trend.default_prior(Form::new(Inertia::None, DrySpeed::Impact));
        self.sampled.push(ModelParameter {
            kind: trend,
            name: trend.key().to_owned(),
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            prior,
            source,
        });
        self
    }

    fn add(&mut self, scene: &Scene, runs: &Runs, form: Form, candidate: CandidateParameter) -> Result<(), Error> {
        let CandidateParameter { kind, bounds, why_not } = candidate;
        let name = kind.name(scene, runs);
        let (prior, source) = prior_of(scene, runs, kind, form);
        let left_out = match (why_not, prior) {
            // what no run reads stays unread; what cannot be identified is held where the scene holds it
            (None | Some((Some(_), _)), Prior::Fixed(value)) => Some((Some(value), "held by the scene's prior")),
            (why, _) => why,
        };
        if let Some((value, reason)) = left_out {
            if let Some(value) = value {
                // a loss that is not held has 0 of its parameter, and C may be held at 0, too; so may the spread of runs whose
                // measurement errors are stated, which the reader of the runs sees to
                let held = !matches!(prior, Prior::Fixed(_));
                let lowest_allowed = value == 0.0 && (held || kind.describe().may_be_zero);
                if !(lowest_allowed || value > bounds.0 && value < bounds.1) {
                    return Err(no_room(scene, runs, kind, &prior, within("a value", bounds)));
                }
                self.template[kind.slot()] = value;
            }
            self.left_out.push(LeftOut {
                kind,
                name,
                value,
                reason,
            });
            return Ok(());
        }
        if let Some(expected) = prior.fails(bounds) {
            return Err(no_room(scene, runs, kind, &prior, expected));
        }
        let bounds = match prior {
            Prior::Uniform(lo, hi) => (bounds.0.max(lo), bounds.1.min(hi)),
            _ => bounds,
        };
        self.sampled.push(ModelParameter {
            kind,
            name,
            bounds,
            prior,
            source,
        });
        Ok(())
    }

    /// The place of a sampled parameter in a draw.
    pub fn place(&self, kind: ParameterKind) -> Option<usize> {
        self.sampled.iter().position(|parameter| parameter.kind == kind)
    }

    /// The full vector of a draw.
    pub fn full(&self, draw: &[f64]) -> Vec<f64> {
        let mut full = self.template.clone();
        self.fill(draw, &mut full);
        full
    }

    /// Writes a draw into a full vector that began as the template; one without offsets leaves these as they are.
    pub fn fill(&self, draw: &[f64], full: &mut [f64]) {
        for (parameter, value) in self.sampled.iter().zip(draw) {
            full[parameter.kind.slot()] = *value;
        }
        let offsets = draw.get(self.sampled.len()..).unwrap_or_default();
        full[self.first_offset()..][..offsets.len()].copy_from_slice(offsets);
    }

    /// Numbers of a draw: the sampled parameters, then the offsets of the series.
    pub fn dimension(&self) -> usize {
        self.sampled.len() + self.series_offsets.len()
    }

    /// Where the offsets stand in a full vector.
    pub fn first_offset(&self) -> usize {
        self.template.len() - self.series_offsets.len()
    }
}

/// The prior of a parameter and where it comes from: that of one particle goes before that of all.
pub fn prior_of(scene: &Scene, runs: &Runs, kind: ParameterKind, form: Form) -> (Prior, &'static str) {
    match choice_of(scene, runs, kind) {
        Some(choice) if choice.parameter == SIGMA_ENERGY.name && choice.line.is_none() => {
            (choice.prior, OF_SLOW_REBOUNDS)
        }
        Some(choice) => (choice.prior, OF_SCENE),
        None => kind.default_prior(form),
    }
}

/// The prior the scene sets for a parameter; `None` where it keeps its default.
fn choice_of<'s>(scene: &'s Scene, runs: &Runs, kind: ParameterKind) -> Option<&'s PriorChoice> {
    let of = |particle: Option<usize>| {
        let mut set = scene.priors.iter();
        set.find(|choice| choice.particle == particle && choice.parameter == kind.key())
    };
    let own = match kind {
        ParameterKind::DryK(sphere) => of(Some(runs.spheres[sphere].particle)),
        _ => None,
    };
    own.or_else(|| of(None))
}

/// A prior that leaves a parameter no room, with the line of the scene it stands on.
fn no_room(scene: &Scene, runs: &Runs, kind: ParameterKind, prior: &Prior, expected: String) -> Error {
    let choice = choice_of(scene, runs, kind);
    let (key, why) = match kind {
        ParameterKind::DryK(sphere) => {
            let of_all = choice.is_some_and(|choice| choice.particle.is_none());
            let sphere = runs.spheres[sphere];
            let key = if of_all {
                "dry_k".to_owned()
            } else {
                format!("dry_k.{}", scene.particles[sphere.particle].name)
            };
            let name = sphere.words(scene);
            (key, format!(", or e_dry of {name} turns negative at a speed in use"))
        }
        other => (other.key().to_owned(), String::new()),
    };
    let default = if choice.is_none() { "the default " } else { "" };
    let problem = Problem {
        line: choice.and_then(|choice| choice.line),
        place: format!("[priors] {key}"),
        found: Some(format!("{default}{}", quoted(&prior.text()))),
        expected: format!("expected {expected}{why}"),
    };
    Error::input(&scene.file, vec![problem])
}

/// Largest speed at which e_dry of a sphere is used, m/s; `None` for one without runs.
fn fastest(runs: &Runs, sphere: usize, form: Form) -> Option<f64> {
    let of = |range: std::ops::Range<usize>| runs.impact_speed[range].iter().copied();
    let dry = runs.dry.iter().filter(|group| group.sphere == sphere);
    let dry = dry.flat_map(|group| of(group.rebounds.start..group.stuck.end));
    let wet = runs.series.iter().filter(|series| series.sphere == sphere);
    let wet = wet.flat_map(|series| of(series.runs())).map(|v| form.dry_speed.of(v));
    dry.chain(wet).reduce(f64::max)
}

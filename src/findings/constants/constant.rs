//! Names the constants of a scene, and changes one of them by a little.

use std::borrow::Cow;

use crate::runs::{Runs, Series};
use crate::scene::{Liquid, Particle, Scene};

/// A constant taken as exact, or all of one kind at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Constant {
    /// η of one liquid, or of all
    Viscosity(Option<usize>),
    /// ρl of one liquid, or of all
    LiquidDensity(Option<usize>),
    /// ρp of one particle, or of all
    ParticleDensity(Option<usize>),
    /// ε of one particle, or of all
    Roughness(Option<usize>),
    /// δ of all runs, by one factor
    Film,
    /// δ of all runs, by one length, in units of their mean
    FilmOffset,
    /// all speeds, by one factor; restitutions stay
    Speed,
}

/// Liquids and particles that have rebounds, and the mean film of these.
pub(super) struct MaterialsInUse {
    liquids: Vec<usize>,
    particles: Vec<usize>,
    /// those of the particles whose roughness is given
    with_roughness: Vec<usize>,
    /// m
    mean_film: f64,
}

/// A kind of constant with those of it that are in use.
pub(super) struct ConstantKind {
    /// all of them at once
    pub(super) all: Constant,
    /// each alone
    pub(super) each: Vec<Constant>,
    /// whether each is varied wherever there is more than one
    always_each: bool,
}

impl MaterialsInUse {
    pub(super) fn new(scene: &Scene, runs: &Runs) -> MaterialsInUse {
        let with_rebounds = || runs.series.iter().filter(|series| !series.rebounds.is_empty());
        let has = |of: &dyn Fn(&Series) -> usize, count: usize| {
            let mut found = vec![false; count];
            with_rebounds().for_each(|series| found[of(series)] = true);
            (0..count).filter(|index| found[*index]).collect()
        };
        let films = || with_rebounds().flat_map(|series| &runs.film[series.rebounds.clone()]);
        let particles = has(&|series| series.particle, scene.particles.len());
        let has_roughness = |index: &usize| scene.particles[*index].roughness.is_some();
        MaterialsInUse {
            liquids: has(&|series| series.liquid, scene.liquids.len()),
            with_roughness: particles.iter().copied().filter(has_roughness).collect(),
            particles,
            mean_film: films().sum::<f64>() / films().count().max(1) as f64,
        }
    }

    pub(super) fn kinds(&self, scene: &Scene) -> Vec<ConstantKind> {
        let of_liquids = |of: fn(Option<usize>) -> Constant, always_each: bool| ConstantKind {
            all: of(None),
            each: self.liquids.iter().map(|index| of(Some(*index))).collect(),
            always_each,
        };
        let of_particles = |of: fn(Option<usize>) -> Constant, among: &[usize]| ConstantKind {
            all: of(None),
            each: among.iter().map(|index| of(Some(*index))).collect(),
            always_each: false,
        };
        let mut kinds = vec![
            of_liquids(Constant::Viscosity, true),
            of_liquids(Constant::LiquidDensity, false),
            of_particles(Constant::ParticleDensity, &self.particles),
        ];
        if !self.with_roughness.is_empty() {
            kinds.push(of_particles(Constant::Roughness, &self.with_roughness));
        }
        kinds.push(ConstantKind {
            all: Constant::Film,
            each: vec![],
            always_each: false,
        });
        // a scale of speeds is one of the runs, not of a material: it is varied where the scene says that it errs
        if scene.data.speed_rel_sd.is_some() {
            kinds.push(ConstantKind {
                all: Constant::Speed,
                each: vec![],
                always_each: false,
            });
        }
        kinds
    }

    /// sd of a constant over its value as the scene gives it; `None` for all of several at once.
    pub(super) fn rel_sd(&self, scene: &Scene, constant: Constant) -> Option<f64> {
        let of_liquid = |index: Option<usize>, of: fn(&Liquid) -> Option<f64>| {
            let only = (self.liquids.len() == 1).then(|| self.liquids[0]);
            of(&scene.liquids[index.or(only)?])
        };
        let of_particle = |index: Option<usize>, among: &[usize], of: fn(&Particle) -> Option<f64>| {
            let only = (among.len() == 1).then(|| among[0]);
            of(&scene.particles[index.or(only)?])
        };
        match constant {
            Constant::Viscosity(index) => of_liquid(index, |liquid| liquid.viscosity_rel_sd),
            Constant::LiquidDensity(index) => of_liquid(index, |liquid| liquid.density_rel_sd),
            Constant::ParticleDensity(index) => of_particle(index, &self.particles, |particle| particle.density_rel_sd),
            Constant::Roughness(index) => {
                of_particle(index, &self.with_roughness, |particle| particle.roughness_rel_sd)
            }
            Constant::Film => None,
            Constant::Speed => scene.data.speed_rel_sd,
            Constant::FilmOffset => scene.data.film_sd.map(|sd| sd / self.mean_film),
        }
    }

    /// The scene and the runs with a constant changed by this share of itself, as an exponent.
    pub(super) fn perturbed<'a>(
        &self,
        scene: &Scene,
        runs: &'a Runs,
        constant: Constant,
        share: f64,
    ) -> (Scene, Cow<'a, Runs>) {
        let (mut scene, mut runs) = (scene.clone(), Cow::Borrowed(runs));
        let factor = share.exp();
        let meant = |index: usize, wanted: Option<usize>| wanted.is_none_or(|wanted| wanted == index);
        match constant {
            Constant::Viscosity(wanted) | Constant::LiquidDensity(wanted) => {
                for (index, liquid) in scene.liquids.iter_mut().enumerate() {
                    match constant {
                        Constant::Viscosity(_) if meant(index, wanted) => liquid.viscosity *= factor,
                        _ if meant(index, wanted) => liquid.density *= factor,
                        _ => (),
                    }
                }
            }
            Constant::ParticleDensity(wanted) | Constant::Roughness(wanted) => {
                for (index, particle) in scene.particles.iter_mut().enumerate() {
                    match constant {
                        Constant::ParticleDensity(_) if meant(index, wanted) => particle.density *= factor,
                        _ if meant(index, wanted) => particle.roughness = particle.roughness.map(|own| own * factor),
                        _ => (),
                    }
                }
            }
            // the film ratios that name the groups stay: a result keeps the film ratio it is reported at
            Constant::Film => runs.to_mut().film.iter_mut().for_each(|film| *film *= factor),
            Constant::Speed => runs.to_mut().impact_speed.iter_mut().for_each(|speed| *speed *= factor),
            Constant::FilmOffset => {
                let offset = share * self.mean_film;
                runs.to_mut().film.iter_mut().for_each(|film| *film += offset);
            }
        }
        if !matches!(constant, Constant::Roughness(_)) {
            runs.to_mut().compute_impacts(&scene);
        }
        (scene, runs)
    }
}

impl ConstantKind {
    /// The constants of this kind to vary: all at once, and each where that says more.
    pub(super) fn varied(&self, in_use: &MaterialsInUse, scene: &Scene) -> Vec<Constant> {
        let given = |constant: &Constant| in_use.rel_sd(scene, *constant).is_some();
        let mut varied = vec![self.all];
        if self.each.len() > 1 && (self.always_each || self.each.iter().any(given)) {
            varied.extend(&self.each);
        }
        if self.all == Constant::Film && given(&Constant::FilmOffset) {
            varied.push(Constant::FilmOffset);
        }
        varied
    }

    /// The constants of this kind that the scene gives no uncertainty of.
    pub(super) fn not_given(&self, in_use: &MaterialsInUse, scene: &Scene) -> Vec<Constant> {
        let given = |constant: &Constant| in_use.rel_sd(scene, *constant).is_some();
        if given(&self.all) || self.all == Constant::Film && given(&Constant::FilmOffset) {
            return vec![];
        }
        match self.each.iter().filter(|constant| given(constant)).count() {
            0 => vec![self.all],
            _ => self.each.iter().filter(|constant| !given(constant)).copied().collect(),
        }
    }
}

impl Constant {
    /// Its name in files.
    pub(super) fn name(self, scene: &Scene) -> String {
        let of_liquid = |index: Option<usize>| index.map(|index| scene.liquids[index].name.as_str());
        let of_particle = |index: Option<usize>| index.map(|index| scene.particles[index].name.as_str());
        let (name, of) = match self {
            Constant::Viscosity(index) => ("viscosity", of_liquid(index)),
            Constant::LiquidDensity(index) => ("liquid_density", of_liquid(index)),
            Constant::ParticleDensity(index) => ("particle_density", of_particle(index)),
            Constant::Roughness(index) => ("roughness", of_particle(index)),
            Constant::Film => ("film", None),
            Constant::FilmOffset => ("film_offset", None),
            Constant::Speed => ("speed", None),
        };
        of.map_or(name.to_owned(), |of| format!("{name}[{of}]"))
    }

    /// The key of a scene that gives its uncertainty.
    pub(super) fn key(self) -> &'static str {
        match self {
            Constant::Viscosity(_) => "viscosity_rel_sd in [liquids]",
            Constant::LiquidDensity(_) => "density_rel_sd in [liquids]",
            Constant::ParticleDensity(_) => "density_rel_sd in [particles]",
            Constant::Roughness(_) => "roughness_rel_sd in [particles]",
            Constant::Film | Constant::FilmOffset => "film_sd_um in [data]",
            Constant::Speed => "speed_rel_sd in [data]",
        }
    }

    /// Its name in a sentence.
    pub(super) fn words(self, scene: &Scene) -> String {
        let liquid = |index: Option<usize>| match index {
            Some(index) => format!("of {}", scene.liquids[index].name),
            None => "of the liquids".to_owned(),
        };
        let particle = |index: Option<usize>| match index {
            Some(index) => format!("of {}", scene.particles[index].name),
            None => "of the particles".to_owned(),
        };
        match self {
            Constant::Viscosity(index) => format!("viscosity {}", liquid(index)),
            Constant::LiquidDensity(index) => format!("density {}", liquid(index)),
            Constant::ParticleDensity(index) => format!("density {}", particle(index)),
            Constant::Roughness(index) => format!("roughness {}", particle(index)),
            Constant::Film | Constant::FilmOffset => "film thickness".to_owned(),
            Constant::Speed => "the scale of all speeds".to_owned(),
        }
    }
}

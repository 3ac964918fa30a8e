//! Names the constants of a scene, and changes one of them by a little.

use std::borrow::Cow;

use crate::runs::{Runs, Series};
use crate::scene::Scene;

/// What is taken as exact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Property {
    /// η of a liquid
    Viscosity,
    /// ρl of a liquid
    LiquidDensity,
    /// ρp of a particle
    ParticleDensity,
    /// ε of a particle
    Roughness,
    /// δ of all runs, by one factor
    Film,
    /// δ of all runs, by one length, in units of their mean
    FilmOffset,
    /// all speeds, by one factor; restitutions stay
    Speed,
}

/// A property of one material, or of all at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Constant {
    property: Property,
    /// index of the liquid or particle; `None` for all
    material: Option<usize>,
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

    /// The properties that are varied. An offset of films or a scale of speeds is one of the runs, not of a material: it is
    /// varied where the scene says that it errs.
    pub(super) fn properties(&self, scene: &Scene) -> Vec<Property> {
        let varied = |property: &Property| match property {
            Property::Roughness => !self.with_roughness.is_empty(),
            Property::FilmOffset => scene.data.film_sd.is_some(),
            Property::Speed => scene.data.speed_rel_sd.is_some(),
            _ => true,
        };
        Property::ALL.into_iter().filter(varied).collect()
    }

    /// The materials in use that have a property.
    fn with(&self, property: Property) -> &[usize] {
        match property {
            Property::Viscosity | Property::LiquidDensity => &self.liquids,
            Property::ParticleDensity => &self.particles,
            Property::Roughness => &self.with_roughness,
            Property::Film | Property::FilmOffset | Property::Speed => &[],
        }
    }

    fn each(&self, property: Property) -> impl Iterator<Item = Constant> + Clone + '_ {
        self.with(property).iter().map(move |index| Constant {
            property,
            material: Some(*index),
        })
    }

    /// The constants of a property to vary: all at once, and each where that says more.
    pub(super) fn varied(&self, scene: &Scene, property: Property) -> Vec<Constant> {
        let mut varied = vec![Constant::all(property)];
        let mut each = self.each(property);
        let several = self.with(property).len() > 1;
        if several && (property == Property::Viscosity || each.clone().any(|one| self.rel_sd(scene, one).is_some())) {
            varied.extend(&mut each);
        }
        varied
    }

    /// The constants of a property that the scene gives no uncertainty of.
    pub(super) fn not_given(&self, scene: &Scene, property: Property) -> Vec<Constant> {
        let all = Constant::all(property);
        if self.rel_sd(scene, all).is_some() || property == Property::Film && scene.data.film_sd.is_some() {
            return vec![];
        }
        let open: Vec<Constant> = self
            .each(property)
            .filter(|one| self.rel_sd(scene, *one).is_none())
            .collect();
        if open.len() == self.with(property).len() {
            vec![all]
        } else {
            open
        }
    }

    /// sd of a constant over its value as the scene gives it; `None` for all of several at once.
    pub(super) fn rel_sd(&self, scene: &Scene, constant: Constant) -> Option<f64> {
        let material = constant.material.or(match self.with(constant.property) {
            [only] => Some(*only),
            _ => None,
        });
        match constant.property {
            Property::Viscosity => scene.liquids[material?].viscosity_rel_sd,
            Property::LiquidDensity => scene.liquids[material?].density_rel_sd,
            Property::ParticleDensity => scene.particles[material?].density_rel_sd,
            Property::Roughness => scene.particles[material?].roughness_rel_sd,
            Property::Film => None,
            Property::FilmOffset => scene.data.film_sd.map(|sd| sd / self.mean_film),
            Property::Speed => scene.data.speed_rel_sd,
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
        let property = constant.property;
        let meant = |index: &&usize| constant.material.is_none_or(|material| material == **index);
        for index in self.with(property).iter().filter(meant) {
            match property {
                Property::Viscosity => scene.liquids[*index].viscosity *= factor,
                Property::LiquidDensity => scene.liquids[*index].density *= factor,
                Property::ParticleDensity => scene.particles[*index].density *= factor,
                _ => scene.particles[*index]
                    .roughness
                    .iter_mut()
                    .for_each(|own| *own *= factor),
            }
        }
        match property {
            // the film ratios that name the groups stay: a result keeps the film ratio it is reported at
            Property::Film => runs.to_mut().film.iter_mut().for_each(|film| *film *= factor),
            Property::FilmOffset => {
                let offset = share * self.mean_film;
                runs.to_mut().film.iter_mut().for_each(|film| *film += offset);
            }
            Property::Speed => runs.to_mut().impact_speed.iter_mut().for_each(|speed| *speed *= factor),
            _ => {}
        }
        if property != Property::Roughness {
            runs.to_mut().compute_impacts(&scene);
        }
        (scene, runs)
    }
}

impl Property {
    const ALL: [Property; 7] = [
        Property::Viscosity,
        Property::LiquidDensity,
        Property::ParticleDensity,
        Property::Roughness,
        Property::Film,
        Property::FilmOffset,
        Property::Speed,
    ];

    /// Its name in files, and in a sentence.
    fn names(self) -> [&'static str; 2] {
        match self {
            Property::Viscosity => ["viscosity", "viscosity"],
            Property::LiquidDensity => ["liquid_density", "density"],
            Property::ParticleDensity => ["particle_density", "density"],
            Property::Roughness => ["roughness", "roughness"],
            Property::Film => ["film", "film thickness"],
            Property::FilmOffset => ["film_offset", "film thickness"],
            Property::Speed => ["speed", "the scale of all speeds"],
        }
    }
}

impl Constant {
    fn all(property: Property) -> Constant {
        Constant {
            property,
            material: None,
        }
    }

    /// The name of its material.
    fn material(self, scene: &Scene) -> Option<&str> {
        Some(match self.property {
            Property::Viscosity | Property::LiquidDensity => &scene.liquids[self.material?].name,
            _ => &scene.particles[self.material?].name,
        })
    }

    /// Its name in files.
    pub(super) fn name(self, scene: &Scene) -> String {
        let [name, _] = self.property.names();
        let of = self.material(scene);
        of.map_or(name.to_owned(), |of| format!("{name}[{of}]"))
    }

    /// The key of a scene that gives its uncertainty.
    pub(super) fn key(self) -> &'static str {
        match self.property {
            Property::Viscosity => "viscosity_rel_sd in [liquids]",
            Property::LiquidDensity => "density_rel_sd in [liquids]",
            Property::ParticleDensity => "density_rel_sd in [particles]",
            Property::Roughness => "roughness_rel_sd in [particles]",
            Property::Film | Property::FilmOffset => "film_sd_um in [data]",
            Property::Speed => "speed_rel_sd in [data]",
        }
    }

    /// Its name in a sentence.
    pub(super) fn words(self, scene: &Scene) -> String {
        let [_, words] = self.property.names();
        let of = match self.property {
            Property::Viscosity | Property::LiquidDensity => self.material(scene).unwrap_or("the liquids"),
            Property::ParticleDensity | Property::Roughness => self.material(scene).unwrap_or("the particles"),
            Property::Film | Property::FilmOffset | Property::Speed => return words.to_owned(),
        };
        format!("{words} of {of}")
    }
}

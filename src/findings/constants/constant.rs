//! Lists the constants of a scene, and changes one of them by a little.

use std::borrow::Cow;

use crate::runs::{Runs, Series};
use crate::scene::{Liquid, Particle, Scene};

/// What is taken as exact.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Property {
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
    /// δ of all runs, by one length, in units of this mean in m
    FilmOffset(f64),
    /// all speeds, by one factor; restitutions stay
    Speed,
}

impl Property {
    /// Its name in files, its name in a sentence, and the key of a scene that gives its uncertainty.
    fn names(self) -> [&'static str; 3] {
        match self {
            Property::Viscosity => ["viscosity", "viscosity", "viscosity_rel_sd in [liquids]"],
            Property::LiquidDensity => ["liquid_density", "density", "density_rel_sd in [liquids]"],
            Property::ParticleDensity => ["particle_density", "density", "density_rel_sd in [particles]"],
            Property::Roughness => ["roughness", "roughness", "roughness_rel_sd in [particles]"],
            Property::Film => ["film", "film thickness", "film_sd_um in [data]"],
            Property::FilmOffset(_) => ["film_offset", "film thickness", "film_sd_um in [data]"],
            Property::Speed => ["speed", "the scale of all speeds", "speed_rel_sd in [data]"],
        }
    }

    /// Of these materials, each with its name and its uncertainty: all at once, under the name `together`, and each.
    ///
    /// Each is varied where that says more.
    fn of_materials(self, together: &str, materials: &[(usize, &str, Option<f64>)]) -> Vec<Constant> {
        let [name, words, _] = self.names();
        let all_rel_sd = materials.first().filter(|_| materials.len() == 1).and_then(|own| own.2);
        let none_given = materials.iter().all(|own| own.2.is_none());
        let all = Constant {
            materials: materials.iter().map(|own| own.0).collect(),
            words: format!("{words} of {together}"),
            ..self.of_runs(all_rel_sd, !none_given)
        };
        let each = materials.iter().map(|(index, of, rel_sd)| Constant {
            materials: vec![*index],
            name: format!("{name}[{of}]"),
            words: format!("{words} of {of}"),
            is_varied: materials.len() > 1 && (self == Property::Viscosity || !none_given),
            ..self.of_runs(*rel_sd, rel_sd.is_some() || none_given)
        });
        std::iter::once(all).chain(each).collect()
    }

    /// Of all runs.
    fn of_runs(self, rel_sd: Option<f64>, is_given: bool) -> Constant {
        let [name, words, key] = self.names();
        Constant {
            property: self,
            materials: vec![],
            name: name.to_owned(),
            words: words.to_owned(),
            key,
            rel_sd,
            is_varied: true,
            is_open: !is_given,
        }
    }
}

/// A property of one material, or of all at once.
pub(in crate::findings) struct Constant {
    property: Property,
    /// indices of the liquids or particles; none of a property of the runs
    materials: Vec<usize>,
    /// its name in files
    pub(in crate::findings) name: String,
    /// its name in a sentence
    pub(in crate::findings) words: String,
    /// the key of a scene that gives its uncertainty
    pub(in crate::findings) key: &'static str,
    /// its sd over its value, as the scene gives it; `None` for all of several at once
    pub(super) rel_sd: Option<f64>,
    /// whether results are told with it: all of a property at once are, and each where that says more
    pub(super) is_varied: bool,
    /// whether the scene could say how well it is known, and does not
    pub(in crate::findings) is_open: bool,
}

impl Constant {
    /// The scene and the runs with it changed by this share of itself, as an exponent.
    pub(super) fn changed<'a>(&self, scene: &Scene, runs: &'a Runs, share: f64) -> (Scene, Cow<'a, Runs>) {
        let (mut scene, mut runs) = (scene.clone(), Cow::Borrowed(runs));
        let factor = share.exp();
        for index in &self.materials {
            match self.property {
                Property::Viscosity => scene.liquids[*index].viscosity *= factor,
                Property::LiquidDensity => scene.liquids[*index].density *= factor,
                Property::ParticleDensity => scene.particles[*index].density *= factor,
                _ => scene.particles[*index].roughness = scene.particles[*index].roughness.map(|own| own * factor),
            }
        }
        match self.property {
            // the film ratios that name the groups stay: a result keeps the film ratio it is reported at
            Property::Film => runs.to_mut().film.iter_mut().for_each(|film| *film *= factor),
            Property::FilmOffset(mean) => {
                let offset = share * mean;
                runs.to_mut().film.iter_mut().for_each(|film| *film += offset);
            }
            Property::Speed => runs.to_mut().impact_speed.iter_mut().for_each(|speed| *speed *= factor),
            _ => {}
        }
        if self.property != Property::Roughness {
            runs.to_mut().compute_impacts(&scene);
        }
        (scene, runs)
    }
}

/// The constants of the liquids and particles that have rebounds, property by property, and of the runs. An offset of films or
/// a scale of speeds is there where the scene says that it errs.
pub(in crate::findings) fn list_constants(scene: &Scene, runs: &Runs) -> Vec<Constant> {
    let with_rebounds = || runs.series.iter().filter(|series| !series.rebounds.is_empty());
    let is_used = |index: usize, of: fn(&Series) -> usize| with_rebounds().any(|series| of(series) == index);
    let of_liquids = |property: Property, rel_sd: fn(&Liquid) -> Option<f64>| {
        let all = scene.liquids.iter().enumerate();
        let in_use = all.filter(|(index, _)| is_used(*index, |series| series.liquid));
        let each = in_use.map(|(index, own)| (index, own.name.as_str(), rel_sd(own)));
        property.of_materials("the liquids", &each.collect::<Vec<_>>())
    };
    let of_particles = |property: Property, rel_sd: fn(&Particle) -> Option<f64>| {
        let all = scene.particles.iter().enumerate();
        let has_it = |own: &Particle| property != Property::Roughness || own.roughness.is_some();
        let in_use = all.filter(|(index, own)| has_it(own) && is_used(*index, |series| series.particle));
        let each = in_use.map(|(index, own)| (index, own.name.as_str(), rel_sd(own)));
        property.of_materials("the particles", &each.collect::<Vec<_>>())
    };
    let films = || with_rebounds().flat_map(|series| &runs.film[series.rebounds.clone()]);
    let mean_film = films().sum::<f64>() / films().count().max(1) as f64;
    let (film_sd, speed_rel_sd) = (scene.data.film_sd, scene.data.speed_rel_sd);
    let film_offset = |sd: f64| Property::FilmOffset(mean_film).of_runs(Some(sd / mean_film), true);
    let mut all = of_liquids(Property::Viscosity, |own| own.viscosity_rel_sd);
    all.extend(of_liquids(Property::LiquidDensity, |own| own.density_rel_sd));
    all.extend(of_particles(Property::ParticleDensity, |own| own.density_rel_sd));
    // without any roughness there is none of all at once
    let roughness = of_particles(Property::Roughness, |own| own.roughness_rel_sd);
    all.extend(roughness.into_iter().filter(|own| !own.materials.is_empty()));
    all.push(Property::Film.of_runs(None, film_sd.is_some()));
    all.extend(film_sd.map(film_offset));
    all.extend(speed_rel_sd.map(|sd| Property::Speed.of_runs(Some(sd), true)));
    all
}

//! Reads the setting of the command line, and finds the law of a finished fit that holds there.

use clap::Args;
use wetcor::error::{quoted, Error};
use wetcor::findings::predict::{LiquidBasis, ParticleLaw};
use wetcor::physics::form::Term;
use wetcor::physics::Setting;
use wetcor::report::finished::Finished;
use wetcor::scene::{name_expected, DRY, LARGEST_FILM_RATIO};
use wetcor::units::Dimension;

use super::messages::warn;

/// A sphere, and what it falls on.
#[derive(Args)]
pub struct SettingArguments {
    /// A particle of the scene
    #[arg(long)]
    particle: Option<String>,
    /// A liquid of the scene, or `dry`; for another give its density and viscosity instead
    #[arg(long)]
    liquid: Option<String>,
    /// Density of a liquid the scene has not, kg/m³
    #[arg(long = "liquid-density-kg-m3", value_name = "X", value_parser = positive, allow_negative_numbers = true, requires = "viscosity", conflicts_with = "liquid")]
    liquid_density: Option<f64>,
    /// Its viscosity, mPa s
    #[arg(long = "viscosity-mPa-s", value_name = "X", value_parser = positive, allow_negative_numbers = true, requires = "liquid_density", conflicts_with = "liquid")]
    viscosity: Option<f64>,
    /// Diameter of the particle, mm; one of the fit's where each has its own k
    #[arg(long = "diameter-mm", value_name = "X", value_parser = positive, allow_negative_numbers = true)]
    diameter: Option<f64>,
    /// Thickness of the film, µm; not read of a dry plate
    #[arg(long = "film-um", value_name = "X", value_parser = positive, allow_negative_numbers = true)]
    film: Option<f64>,
}

/// A sphere and what it falls on, as they were asked for; lengths in m.
pub(super) struct AskedPair {
    pub particle: String,
    pub liquid: AskedLiquid,
    pub diameter: f64,
    /// `None` of a dry plate
    pub film: Option<f64>,
}

/// What is on the plate.
pub(super) enum AskedLiquid {
    Dry,
    /// a liquid of the scene
    Named(String),
    /// one that the scene has not
    Other(LiquidBasis),
}

impl AskedLiquid {
    /// Its name; `None` of one that the scene has not.
    pub fn name(&self) -> Option<&str> {
        match self {
            AskedLiquid::Dry => Some(DRY),
            AskedLiquid::Named(name) => Some(name),
            AskedLiquid::Other(_) => None,
        }
    }
}

impl SettingArguments {
    /// The pair. Fails with the names of all that is missing.
    pub fn pair(&self) -> Result<AskedPair, Error> {
        let liquid = match (&self.liquid, self.liquid_density.zip(self.viscosity)) {
            (Some(name), _) if name == DRY => Some(AskedLiquid::Dry),
            (Some(name), _) => Some(AskedLiquid::Named(name.clone())),
            (None, Some((density, viscosity))) => Some(AskedLiquid::Other(LiquidBasis {
                name: String::new(),
                density_kg_m3: Dimension::Density.usual_to_si(density),
                viscosity_pa_s: Dimension::Viscosity.usual_to_si(viscosity),
                surface_tension_n_m: None,
            })),
            (None, None) => None,
        };
        let film = self.film.map(|film| Dimension::Thickness.usual_to_si(film));
        let is_dry = matches!(liquid, Some(AskedLiquid::Dry));
        let missing: Vec<&str> = [
            ("--particle", self.particle.is_none()),
            (
                "--liquid (or --liquid-density-kg-m3 and --viscosity-mPa-s)",
                liquid.is_none(),
            ),
            ("--diameter-mm", self.diameter.is_none()),
            ("--film-um", film.is_none() && !is_dry),
        ]
        .into_iter()
        .filter_map(|(flag, missing)| missing.then_some(flag))
        .collect();
        match (&self.particle, liquid, self.diameter) {
            (Some(particle), Some(liquid), Some(diameter)) if missing.is_empty() => Ok(AskedPair {
                particle: particle.clone(),
                liquid,
                diameter: Dimension::Length.usual_to_si(diameter),
                film,
            }),
            _ => Err(Error::Usage(format!("expected {} as well", missing.join(", ")))),
        }
    }
}

/// Says what to mind of a fit.
pub(super) fn warn_of(finished: &Finished) {
    for check in &finished.failed {
        warn(&format!("the fit is not to be quoted, and this not either: {check}"));
    }
}

/// A number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
    number.ok_or_else(|| "expected a number above 0".to_owned())
}

/// What the sphere falls on, its film and liquid checked; `None`: a dry plate.
fn plate(asked: &AskedPair, finished: &Finished) -> Result<Option<Setting>, Error> {
    let liquid = match &asked.liquid {
        AskedLiquid::Dry => return Ok(None),
        AskedLiquid::Named(name) => named_liquid(name, finished)?,
        AskedLiquid::Other(liquid) => liquid,
    };
    let Some(film) = asked.film else {
        return Ok(None);
    };
    let particle = finished.particle(&asked.particle)?;
    let setting = Setting {
        density: particle.density_kg_m3,
        diameter: asked.diameter,
        roughness: particle.roughness_m,
        liquid_density: liquid.density_kg_m3,
        viscosity: liquid.viscosity_pa_s,
        film,
        surface_tension: liquid.surface_tension_n_m,
    };
    check_domain(&setting)?;
    Ok(Some(setting))
}

/// The wetted plate, `None` of a dry one, and the law that holds there: that of a new series, where series have offsets.
pub(super) fn find_law(asked: &AskedPair, finished: &Finished) -> Result<(Option<Setting>, ParticleLaw), Error> {
    let Some(setting) = plate(asked, finished)? else {
        return Ok((None, finished.law(&asked.particle, asked.diameter, false)?));
    };
    let law = finished.law(&asked.particle, setting.diameter, true)?;
    if Term::Bridge.is_held(law.form) && setting.surface_tension.is_none() {
        let text = "the fit holds the rupture of the bridge, and this liquid's surface tension is not known";
        return Err(Error::Usage(format!(
            "--liquid: {text}; name a liquid of the scene that has one"
        )));
    }
    Ok((Some(setting), law))
}

/// Fails where no formula is valid, or a number of the command line vanishes in SI.
fn check_domain(setting: &Setting) -> Result<(), Error> {
    for (flag, x) in [
        ("--diameter-mm", setting.diameter),
        ("--film-um", setting.film),
        ("--viscosity-mPa-s", setting.viscosity),
        ("--liquid-density-kg-m3", setting.liquid_density),
        ("the liquid's density over the particle's", setting.density_ratio()),
    ] {
        if !x.is_normal() {
            let expected = "expected a number that is neither too small nor too large to compute with";
            return Err(Error::Usage(format!("{flag}: found {x:e} in SI, {expected}")));
        }
    }
    let ratio = setting.film_ratio();
    if ratio > LARGEST_FILM_RATIO {
        return Err(Error::Usage(format!(
            "--film-um: found a film ratio of {ratio:.3}, expected at most {LARGEST_FILM_RATIO}: no formula is valid above"
        )));
    }
    Ok(())
}

/// A liquid of the scene.
fn named_liquid<'f>(name: &str, finished: &'f Finished) -> Result<&'f LiquidBasis, Error> {
    let liquids = &finished.basis().liquids;
    let listed = liquids.iter().find(|liquid| liquid.name == name);
    listed.ok_or_else(|| {
        let names = liquids.iter().map(|liquid| liquid.name.as_str()).chain([DRY]);
        let all: Vec<&str> = names.clone().collect();
        let expected = name_expected(&format!("one of {}", all.join(", ")), name, names);
        let other = "for another liquid give --liquid-density-kg-m3 and --viscosity-mPa-s";
        Error::Usage(format!("--liquid: found {}, {expected}; {other}", quoted(name)))
    })
}

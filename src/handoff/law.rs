//! Holds a law of a sphere on a plate, the speed at which a code is to have it, and what follows for the code.

use std::f64::consts::PI;

use super::numbers::number;
use crate::error::Error;
use crate::findings::predict::PredictedPoint;
use crate::physics::Setting;
use crate::roots::root_between;

/// A simulation code that takes a restitution.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// none: e at many speeds, as CSV
    Table,
    /// LAMMPS, `pair_style granular`
    Lammps,
    /// LIGGGHTS-PUBLIC
    Liggghts,
    /// YADE
    Yade,
}

impl Code {
    /// Every code, in the order of the command's help.
    pub const ALL: [Code; 4] = [Code::Table, Code::Lammps, Code::Liggghts, Code::Yade];

    /// The word of the command line.
    pub fn word(self) -> &'static str {
        match self {
            Code::Table => "table",
            Code::Lammps => "lammps",
            Code::Liggghts => "liggghts",
            Code::Yade => "yade",
        }
    }
}

/// A law of a sphere on a plate, and the speed at which a code is to have it.
#[derive(Clone, Copy)]
pub struct Handoff<'a> {
    /// title of the fit
    pub title: &'a str,
    /// where the law comes from, in words
    pub source: &'a str,
    /// name of the particle
    pub particle: &'a str,
    /// ρp, kg/m³
    pub density: f64,
    /// D, m
    pub diameter: f64,
    /// name of the liquid, which is not read of a dry plate
    pub liquid: &'a str,
    /// the wetted plate; `None`: a dry one
    pub wet: Option<Setting>,
    /// speed at which one restitution is taken, m/s
    pub reference_speed: f64,
    /// the law at an impact speed above zero, m/s
    pub law: &'a dyn Fn(f64) -> PredictedPoint,
    /// d ln e/d ln v at the reference speed
    pub log_slope: f64,
    /// slowest and fastest of the runs behind the law, m/s; `None` without any
    pub speeds: Option<[f64; 2]>,
    /// Stokes numbers they covered
    pub stokes: Option<[f64; 2]>,
    /// whether the fit passed its gating verdicts
    pub quotable: bool,
}

/// A file to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HandoffFile {
    /// its name, without folder
    pub name: &'static str,
    /// its whole text
    pub text: String,
}

/// Share by which e may leave the constant that stands for it.
pub(super) const CONSTANT_WITHIN: f64 = 0.05;

/// How far from the reference speed the constant is followed, as a factor.
pub(super) const FARTHEST: f64 = 100.0;

/// Where there are no runs, distances to the law are told from this share of the reference speed to its inverse.
const WITHOUT_RUNS: f64 = 0.5;

impl Handoff<'_> {
    pub(super) fn predicted(&self) -> PredictedPoint {
        (self.law)(self.reference_speed)
    }

    pub(super) fn radius(&self) -> f64 {
        0.5 * self.diameter
    }

    pub(super) fn mass(&self) -> f64 {
        self.density * PI / 6.0 * self.diameter.powi(3)
    }

    /// St on the plate; `None` dry.
    pub(super) fn stokes_at(&self, speed: f64) -> Option<f64> {
        Some(self.wet?.stokes(speed))
    }

    /// Slowest and fastest speed between which the constant stands for the law; `None` where it does still at
    /// [`FARTHEST`].
    pub(super) fn constant_holds(&self) -> [Option<f64>; 2] {
        let e = self.predicted().q50;
        let off = |factor: f64| ((self.law)(self.reference_speed * factor).q50 / e - 1.0).abs() - CONSTANT_WITHIN;
        [-1.0, 1.0].map(|direction: f64| {
            // walked in small steps, as a law need not be monotonic
            let steps = 460;
            let at = |step: f64| (direction * step / f64::from(steps) * FARTHEST.ln()).exp();
            let first = (1..=steps).map(f64::from).find(|step| off(at(*step)) > 0.0)?;
            let end = root_between([first - 1.0, first], |step| off(at(step))).unwrap_or(first);
            Some(self.reference_speed * at(end))
        })
    }

    /// Speeds over which a contact is set beside the law: those of the runs.
    pub(super) fn compared_speeds(&self) -> [f64; 2] {
        self.speeds
            .unwrap_or([WITHOUT_RUNS, 1.0 / WITHOUT_RUNS].map(|share| share * self.reference_speed))
    }

    /// The law where it gives the e of two equal spheres that meet at the reference speed, if their Stokes number decides:
    /// at twice that speed, dry at that speed itself.
    pub(super) fn for_two_spheres(&self) -> PredictedPoint {
        let doubled = if self.wet.is_some() { 2.0 } else { 1.0 };
        (self.law)(doubled * self.reference_speed)
    }

    /// e to give a code for two equal spheres: that of the plate where [`Handoff::for_two_spheres`] has none.
    pub(super) fn restitution_of_two(&self) -> f64 {
        let e = self.for_two_spheres().q50;
        if e > 0.0 && e <= 1.0 {
            e
        } else {
            self.predicted().q50
        }
    }

    /// Fails where the law has no number to hand over.
    pub(super) fn check(&self) -> Result<(), Error> {
        let of_wet = |number: fn(&Setting) -> f64| self.wet.as_ref().map_or(1.0, number);
        let numbers = [
            ("the reference speed", self.reference_speed),
            ("the sphere's density", self.density),
            ("the sphere's diameter", self.diameter),
            ("the film", of_wet(|own| own.film)),
            ("the viscosity", of_wet(|own| own.viscosity)),
        ];
        if let Some((what, x)) = numbers.iter().find(|(_, x)| !(x.is_normal() && *x > 0.0)) {
            let expected = "expected a number above 0";
            return Err(Error::Usage(format!("{what}: found {x} in SI, {expected}")));
        }
        let e = self.predicted().q50;
        let problem = if !e.is_finite() || e > 1.0 {
            format!("gives e = {e}, expected 0 < e <= 1: no code takes it")
        } else if e <= 0.0 {
            let threshold = self.rebounds_from();
            let from = threshold.map(|speed| format!("; it rebounds from {} m/s on", number(speed)));
            format!("gives no rebound, and no code takes e = 0{}", from.unwrap_or_default())
        } else {
            return Ok(());
        };
        let runs = self.speeds.map(|speeds| speeds.map(number));
        let runs = runs.map(|[lowest, highest]| format!("; runs of this particle covered {lowest} to {highest} m/s"));
        Err(Error::Usage(format!(
            "--speed-m-s: at {} m/s the law {problem}{}",
            number(self.reference_speed),
            runs.unwrap_or_default()
        )))
    }

    /// Slowest speed above the reference speed at which the law rebounds, m/s.
    fn rebounds_from(&self) -> Option<f64> {
        let rebounds = |speed: f64| (self.law)(speed).q50 > 0.0;
        let steps = (1..=400).map(|step| self.reference_speed * (f64::from(step) / 400.0 * FARTHEST.ln()).exp());
        steps.into_iter().find(|speed| rebounds(*speed))
    }
}

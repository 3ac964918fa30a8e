//! Lists the parameters that terms of the energy balance share among all particles, and holds a value of each.

use std::ops::{Index, IndexMut};

/// A parameter of a term, one number for all particles. What it is, the file of its term says: [`Coefficient::describe`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Coefficient {
    /// L = ln(δc/ε), of the viscous loss
    LubricationLog,
    /// C, of the inertial loss
    InertialPrefactor,
    /// δ̃0, of the saturating form of the inertial loss
    FilmScale,
    /// λ = δr/V_b^(1/3), of the viscous loss over the whole film
    RuptureScale,
}

impl Coefficient {
    /// Every one, in the order of files.
    pub const ALL: [Coefficient; 4] = [
        Coefficient::LubricationLog,
        Coefficient::InertialPrefactor,
        Coefficient::FilmScale,
        Coefficient::RuptureScale,
    ];

    /// How many there are.
    pub const COUNT: usize = Coefficient::ALL.len();
}

/// What a parameter of the physics is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// its word in scenes, files and reports
    pub name: &'static str,
    /// its letter in formulas
    pub symbol: &'static str,
    /// what it is, in a sentence's words
    pub words: &'static str,
    /// what it stands for in the formulas, in a few words
    pub meaning: &'static str,
    /// a value it may well have
    pub example: &'static str,
    /// its unit
    pub unit: &'static str,
    /// values to start a fit from, of a parameter that does not enter the energy linearly; empty for one that does
    pub grid: &'static [f64],
    /// whether a formula has no value where it is not above zero
    pub must_be_positive: bool,
    /// whether its interval is made on its logarithm
    pub in_logarithm: bool,
    /// whether it may be held at 0, the lower end of its range (0, ∞), which its logarithm cannot reach
    pub may_be_zero: bool,
    /// what is believed of it before any run
    pub prior: LogNormal,
}

/// A belief about a positive number, and what it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogNormal {
    /// its median, in the parameter's unit
    pub median: f64,
    /// sd of its logarithm
    pub ln_sd: f64,
    /// why
    pub reason: &'static str,
}

/// A value of each [`Coefficient`]; NaN where none was given, so that one a formula reads and lacks shows in its result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients([f64; Coefficient::COUNT]);

impl Default for Coefficients {
    fn default() -> Coefficients {
        Coefficients([f64::NAN; Coefficient::COUNT])
    }
}

impl Coefficients {
    /// Those at the front of a list that has them in the order of [`Coefficient::ALL`].
    pub fn first_of(values: &[f64]) -> Coefficients {
        let mut all = Coefficients::default();
        for (own, value) in all.0.iter_mut().zip(values) {
            *own = *value;
        }
        all
    }
}

impl Index<Coefficient> for Coefficients {
    type Output = f64;
    fn index(&self, coefficient: Coefficient) -> &f64 {
        &self.0[coefficient as usize]
    }
}

impl IndexMut<Coefficient> for Coefficients {
    fn index_mut(&mut self, coefficient: Coefficient) -> &mut f64 {
        &mut self.0[coefficient as usize]
    }
}

/// The parameters of the energy balance of one particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// k of the dry law, (m/s)^(-1/5)
    pub dry_k: f64,
    /// those that particles share
    pub shared: Coefficients,
}

impl Parameters {
    /// A particle's k, the shared parameters still missing.
    pub fn new(dry_k: f64) -> Parameters {
        Parameters {
            dry_k,
            shared: Coefficients::default(),
        }
    }

    /// The same with a value of a shared parameter.
    pub fn with(mut self, coefficient: Coefficient, value: f64) -> Parameters {
        self.shared[coefficient] = value;
        self
    }
}

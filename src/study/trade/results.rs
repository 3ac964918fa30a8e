//! Holds the content of `trade.json`.

use serde::Serialize;

/// What every method was found to cost and to miss. Field names are those of `trade.json`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trade {
    /// always [`super::SCHEMA`]
    pub schema: &'static str,
    /// the scene's title
    pub title: String,
    /// version that made this
    pub wetcor: &'static str,
    /// seed of every use of chance
    pub seed: u64,
    /// runs in use
    pub runs: usize,
    /// threads in use
    pub threads: usize,
    /// what the others are held against
    pub reference: Reference,
    /// the methods, cheapest kind first
    pub rungs: Vec<Rung>,
    /// what the linear law gets wrong on this design without any noise
    pub linear_bias: Vec<LinearBias>,
}

/// A long run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reference {
    /// how its draws were made
    pub method: &'static str,
    /// chains
    pub chains: usize,
    /// draws a chain
    pub draws: usize,
    /// s
    pub seconds: f64,
    /// largest Monte Carlo error of a mean, in sds
    pub mcse_mean: f64,
    /// largest Monte Carlo error of an sd, relative
    pub mcse_sd: f64,
    /// largest R-hat
    pub rhat: f64,
    /// each parameter
    pub parameters: Vec<NamedMarginal>,
}

/// A parameter by its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NamedMarginal {
    /// its name in files
    pub name: String,
    /// where it lies
    #[serde(flatten)]
    pub marginal: Marginal,
}

/// Where a parameter lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Marginal {
    /// mean
    pub mean: f64,
    /// standard deviation
    pub sd: f64,
    /// 5 % point
    pub q05: f64,
    /// 95 % point
    pub q95: f64,
}

/// One method for the parameters.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rung {
    /// its name
    pub name: String,
    /// seconds from runs in memory to the parameters, least squares' start included
    pub seconds: f64,
    /// nodes that stood for the wet runs; `None` where every row was used or no likelihood
    pub nodes: Option<usize>,
    /// how far each parameter is off; `None` where the method gives none
    pub errors: Vec<Option<MarginalError>>,
    /// largest error of a mean, in posterior sds
    pub worst_mean: Option<f64>,
    /// largest error of an sd, relative
    pub worst_sd: Option<f64>,
    /// the error its own check vouches for: Monte Carlo errors times 3.3; `None` without draws, or without a check
    pub vouched: Option<f64>,
    /// smallest number of effective draws
    pub effective: Option<f64>,
    /// the same a second
    pub effective_per_second: Option<f64>,
    /// a method that is clearly better in time or in error, and not clearly worse in the other
    pub dominated_by: Option<String>,
    /// why there is nothing, or why it is not reliable
    pub failed: Option<String>,
}

/// How far one parameter is off.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MarginalError {
    /// mean less the reference's, in posterior sds
    pub mean: f64,
    /// sd over the reference's, less 1
    pub sd: f64,
    /// 5 % point less the reference's, in posterior sds
    pub q05: f64,
    /// 95 % point less the reference's, in posterior sds
    pub q95: f64,
}

/// What the linear law gets wrong on this design.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LinearBias {
    /// name of the particle
    pub particle: String,
    /// film ratio; `None`: over all
    pub film_ratio: Option<f64>,
    /// in e_inf
    pub e_inf: f64,
    /// in standard errors of e_inf
    pub e_inf_se: Option<f64>,
    /// in St_c
    pub st_c: f64,
    /// in standard errors of St_c
    pub st_c_se: Option<f64>,
}

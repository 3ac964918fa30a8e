//! Holds the kinds of particles and the liquids of a scene.

/// A kind of particle.
#[derive(Debug, Clone, PartialEq)]
pub struct Particle {
    /// its name in the runs
    pub name: String,
    /// ρp, kg/m³
    pub density: f64,
    /// sd of ρp over ρp; absent: taken as exact
    pub density_rel_sd: Option<f64>,
    /// ε, m
    pub roughness: f64,
    /// sd of ε over ε; absent: taken as exact
    pub roughness_rel_sd: Option<f64>,
}

/// A liquid.
#[derive(Debug, Clone, PartialEq)]
pub struct Liquid {
    /// its name in the runs
    pub name: String,
    /// ρl, kg/m³
    pub density: f64,
    /// sd of ρl over ρl; absent: taken as exact
    pub density_rel_sd: Option<f64>,
    /// η, Pa s
    pub viscosity: f64,
    /// sd of η over η; absent: taken as exact
    pub viscosity_rel_sd: Option<f64>,
    /// γ, N/m
    pub surface_tension: Option<f64>,
}

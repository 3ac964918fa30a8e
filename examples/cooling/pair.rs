//! Gives the restitution of two equal wet spheres from that of one sphere on a wetted plate, where it is measured.
//!
//! Two equal spheres have half the effective mass and half the effective radius, so that St = m_eff v/(6 π η R_eff²) is twice
//! the plate's at the same relative speed. With e_dry at one speed, the plate's e depends on v by St alone, and a pair
//! rebounds as a sphere on the plate does at twice the speed. What has no St in it is taken from the plate as it is, which
//! no measurement here supports: e_dry, the inertial loss (each sphere carrying half of the film) and L.

use wetcor::physics::{viscous, Coefficient, DrySpeed, Form, Inertia, Parameters, Restitution, Setting};

/// Each of the spheres, and the film that two carry together.
pub const SPHERE: Setting = Setting {
    density: 2150.0,       // PTFE, kg/m³
    diameter: 4.762e-3,    // m
    roughness: None,       // m; lubrication over the whole film alone reads it
    liquid_density: 930.0, // AK10, kg/m³
    viscosity: 9.3e-3,     // Pa s
    film: 286e-6,          // m
    surface_tension: None, // N/m; the bridge alone reads it
};

/// L, as on the crate's page.
pub const LUBRICATION_LOG: f64 = 1.85;

/// The law of two such spheres.
pub struct Pair {
    plate: Restitution,
}

impl Pair {
    /// With the parameters of the crate's page.
    pub fn new() -> Pair {
        let parameters = Parameters::new(0.183)
            .with(Coefficient::LubricationLog, LUBRICATION_LOG)
            .with(Coefficient::InertialPrefactor, 0.47)
            .with(Coefficient::FilmScale, 0.069);
        let form = Form::new(Inertia::Saturating, DrySpeed::Reference(2.0));
        let plate = Restitution::new(&SPHERE, form, &parameters);
        Pair { plate }
    }

    /// e at a normal relative speed above zero, m/s. Where it is 0 the pair loses its normal relative velocity and parts by
    /// the rest: it is not merged, as a bridge that holds would merge it.
    pub fn at(&self, speed: f64) -> f64 {
        self.plate.at(2.0 * speed)
    }

    /// e of fast impacts.
    pub fn e_inf(&self) -> f64 {
        self.at(f64::INFINITY)
    }

    /// The normal relative speed below which e is 0, m/s.
    pub fn threshold(&self) -> f64 {
        let beta = viscous::beta(LUBRICATION_LOG, SPHERE.viscosity, SPHERE.density, SPHERE.diameter);
        -beta / self.e_inf().powi(2) / 2.0
    }
}

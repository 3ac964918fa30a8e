//! Gives the tests of several files a sphere, its parameters and every form.

use super::form::Term;
use super::{Coefficient, DrySpeed, Form, Inertia, Parameters, Setting, Viscous};

pub(super) const SETTING: Setting = Setting {
    density: 2150.0,
    diameter: 4.762e-3,
    roughness: Some(5e-6),
    liquid_density: 930.0,
    viscosity: 9.3e-3,
    film: 286e-6,
    surface_tension: Some(20.1e-3),
};

pub(super) fn parameters() -> Parameters {
    Parameters::new(0.183)
        .with(Coefficient::LubricationLog, 1.92)
        .with(Coefficient::InertialPrefactor, 0.41)
        .with(Coefficient::FilmScale, 0.068)
        .with(Coefficient::RuptureScale, 0.013)
}

/// Every form of inertia, with the terms that are usually not held, and without those that are.
pub(super) fn every_form() -> Vec<Form> {
    let of_inertia = |inertia: Inertia| {
        let [own, fixed] = [DrySpeed::Impact, DrySpeed::Reference(1.9)].map(|speed| Form::new(inertia, speed));
        let every = Term::DrySecondOrder.toggled(Term::Bridge.toggled(own));
        let over_the_film = [own, every].map(|form| Form {
            viscous: Viscous::Film,
            ..form
        });
        let [first, second] = over_the_film;
        [own, fixed, every, Term::Viscous.toggled(fixed), first, second]
    };
    Inertia::ALL.into_iter().flat_map(of_inertia).collect()
}

//! Times one evaluation of the restitution at fixed parameters, as a simulation code would call it.

use divan::{black_box, Bencher};
use wetcor::physics::{Coefficient, DrySpeed, Form, Inertia, Parameters, Restitution, Setting};

fn main() {
    divan::main();
}

/// Evaluations timed together: one alone is shorter than the clock can tell.
const SPEEDS: usize = 1000;

fn law(dry_speed: DrySpeed) -> Restitution {
    let sphere = Setting {
        density: 2150.0,
        diameter: 4.762e-3,
        roughness: Some(5e-6),
        liquid_density: 930.0,
        viscosity: 9.3e-3,
        film: 286e-6,
        surface_tension: None,
    };
    let parameters = Parameters::new(0.183)
        .with(Coefficient::LubricationLog, 1.85)
        .with(Coefficient::InertialPrefactor, 0.47)
        .with(Coefficient::FilmScale, 0.069);
    Restitution::new(&sphere, Form::new(Inertia::Saturating, dry_speed), &parameters)
}

fn evaluate(bencher: Bencher, dry_speed: DrySpeed) {
    let law = law(dry_speed);
    let speeds: Vec<f64> = (0..SPEEDS).map(|i| 0.05 + 2.0 * i as f64 / SPEEDS as f64).collect();
    let counted = bencher.counter(divan::counter::ItemsCount::new(SPEEDS));
    counted.bench(|| {
        for v in &speeds {
            black_box(black_box(&law).at(black_box(*v)));
        }
    });
}

/// e_dry at the reference speed: no power is taken.
#[divan::bench]
fn reference_dry_speed(bencher: Bencher) {
    evaluate(bencher, DrySpeed::Reference(2.0));
}

/// e_dry at the impact speed.
#[divan::bench]
fn own_dry_speed(bencher: Bencher) {
    evaluate(bencher, DrySpeed::Impact);
}

//! Lets a gas of wet spheres cool beside one of constant restitution: prints a table, and draws energy against time with
//! Haff's law.
//!
//!     cargo run --release --no-default-features --example cooling -- cooling.svg > cooling.csv
//!
//! The spheres fill a hundredth of space and start at 1 m/s in each direction. `haff_J` is Haff's law for the constant e,
//! which is that of fast wet impacts.

mod drawing;
mod gas;
mod haff;
mod pair;

use std::error::Error;
use std::f64::consts::PI;

use rand::{rngs::ChaCha8Rng, SeedableRng};

use drawing::{svg, Curve, Look};
use gas::{collide, Gas};
use haff::Haff;
use pair::{Pair, SPHERE};

const SPHERES: usize = 100_000;
/// powers of ten of the first and the last time told, s, and times a decade
const DECADES: [i32; 2] = [-2, 3];
const TIMES_A_DECADE: i32 = 8;

/// Of a sphere, J, by the variance of a component of its velocity, m²/s².
fn energy(temperature: f64) -> f64 {
    1.5 * SPHERE.density * PI / 6.0 * SPHERE.diameter.powi(3) * temperature
}

fn times() -> impl Iterator<Item = f64> {
    let steps = DECADES[0] * TIMES_A_DECADE..=DECADES[1] * TIMES_A_DECADE;
    steps.map(|step| 10f64.powf(f64::from(step) / f64::from(TIMES_A_DECADE)))
}

/// Prints how the gas that Haff's law starts with cools under a law of its own; its energies against time.
fn cool(name: &str, start: &Haff, law: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let stream = ChaCha8Rng::seed_from_u64(1);
    let mut gas = Gas::new(SPHERES, start.temperature, start.met_per_metre, stream);
    let told = times().map(|time| {
        let (mut met, mut without) = (0.0, 0.0);
        let mut rebound = |speed: f64| {
            let e = law(speed);
            met += 1.0;
            without += f64::from(e == 0.0);
            e
        };
        gas.advance(time, |pair, normal| collide(pair, normal, &mut rebound));
        let (time, now, collisions) = (gas.time(), energy(gas.temperature()), gas.collisions_per_sphere());
        let (haff, share) = (energy(start.temperature_at(time)), without / met);
        println!("{name},{time:.4e},{collisions:.3},{now:.4e},{haff:.4e},{share:.4}");
        [time, now]
    });
    told.collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1);
    let path = path.ok_or("name the file of the drawing: cooling.svg")?;
    let pair = Pair::new();
    let (e_inf, threshold) = (pair.e_inf(), pair.threshold());
    let [fast, slow] = [e_inf, 0.0].map(|e| Haff {
        e,
        temperature: 1.0,
        // π D² n, a sphere of volume π D³/6 having 100 times its volume
        met_per_metre: 6.0 * 0.01 / SPHERE.diameter,
    });
    eprintln!(
        "each sphere has {:.1} impacts a second at first; 1/τ = {:.3} 1/s",
        fast.frequency(),
        fast.cooling_rate()
    );

    println!("law,time_s,collisions_per_sphere,energy_J,haff_J,share_without_rebound");
    let constant = cool("constant", &fast, |_| e_inf);
    let wet = cool("wet", &fast, |speed| pair.at(speed));

    let law = |haff: &Haff| times().map(|time| [time, energy(haff.temperature_at(time))]).collect();
    // of normal velocities, the normal relative speed at impact has a mean square of 4 T
    let at_threshold = energy(threshold * threshold / 4.0);
    let at_threshold = DECADES.map(|power| [10f64.powi(power), at_threshold]).to_vec();
    let curves = [
        (format!("Haff's law, e = {e_inf:.3}"), Look::Line("#000000"), law(&fast)),
        ("Haff's law, e = 0".to_owned(), Look::Dashes("#000000"), law(&slow)),
        (format!("simulated, e = {e_inf:.3}"), Look::Circles("#0072b2"), constant),
        ("simulated, wet".to_owned(), Look::Circles("#d55e00"), wet),
        (
            format!("rms normal impact speed {threshold:.3} m/s, the threshold"),
            Look::Dashes("#7a7a7a"),
            at_threshold,
        ),
    ];
    let curves = curves.map(|(name, look, points)| Curve { name, look, points });
    let labels = ["time, s", "energy of a sphere, J"];
    std::fs::write(path, svg(labels, [DECADES, [-12, -3]], &curves)?)?;
    Ok(())
}

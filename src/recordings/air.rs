//! Computes what the air takes from a falling sphere, so that it can be taken off: it is not fitted.

use std::f64::consts::PI;

/// Of air at 20 °C and 1013 hPa, in kg/m³ and m²/s.
const AIR_DENSITY: f64 = 1.204;
const AIR_KINEMATIC_VISCOSITY: f64 = 1.516e-5;

/// By what share the drag may be another than is computed: what the formula is known to, and air in a warm room.
pub(super) const DRAG_REL_SD: f64 = 0.05;

/// A sphere in air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereInAir {
    /// D in m
    pub diameter: f64,
    /// in kg/m³
    pub density: f64,
}

impl SphereInAir {
    /// Deceleration at a speed, in m/s².
    ///
    /// Drag coefficient 24/Re (1 + 0.15 Re^0.687), to 5 % below Re = 800. Source: Schiller & Naumann, Z. Ver. Dtsch. Ing. 77,
    /// 318 (1933); its accuracy: Clift, Grace & Weber, Bubbles, Drops, and Particles (1978), table 5.2.
    pub fn deceleration(&self, speed: f64) -> f64 {
        let reynolds = speed * self.diameter / AIR_KINEMATIC_VISCOSITY;
        // 24/Re times the square of the speed, which has no pole at rest
        let of_square = 24.0 * AIR_KINEMATIC_VISCOSITY / self.diameter * speed * (1.0 + 0.15 * reynolds.powf(0.687));
        let area = 0.25 * PI * self.diameter * self.diameter;
        let mass = PI / 6.0 * self.diameter * self.diameter * self.diameter * self.density;
        0.5 * AIR_DENSITY * area * of_square / mass
    }

    /// The height that the air moves a sphere by within a time, of whose flight the first velocity and the gravity are known.
    /// The time may be negative.
    pub(super) fn moved(&self, time: f64, velocity: f64, gravity: f64) -> f64 {
        /// steps of Simpson's rule, which errs by 1e-4 of so small a thing
        const STEPS: usize = 16;
        let force = |t: f64| {
            let v = velocity - gravity * t;
            -self.deceleration(v.abs()).copysign(v)
        };
        let step = time / STEPS as f64;
        let parts = (0..=STEPS).map(|index| {
            let weight = match index {
                0 | STEPS => 1.0,
                _ if index % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let t = step * index as f64;
            weight * step / 3.0 * force(t) * (time - t)
        });
        parts.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPHERE: SphereInAir = SphereInAir {
        diameter: 3.175e-3,
        density: 940.0,
    };

    #[test]
    fn slow_spheres_feel_stokes_drag() {
        let (diameter, density, speed) = (1e-5, 1000.0, 1e-4);
        let stokes = 18.0 * AIR_KINEMATIC_VISCOSITY * AIR_DENSITY * speed / (density * diameter * diameter);
        let found = SphereInAir { diameter, density }.deceleration(speed);
        assert!((found / stokes - 1.0).abs() < 1e-2, "{found} {stokes}");
        assert_eq!(SPHERE.deceleration(0.0), 0.0);
    }

    #[test]
    fn a_flight_is_moved_as_its_equation_says() {
        let (gravity, start) = (9.81, 0.9);
        for time in [0.15, -0.1, 0.02] {
            // Euler's steps through the whole equation, and without air
            let (steps, mut with, mut without) = (200_000, [0.0f64, start], [0.0f64, start]);
            let step = time / f64::from(steps);
            for _ in 0..steps {
                let drag = SPHERE.deceleration(with[1].abs()).copysign(with[1]);
                with = [with[0] + step * with[1], with[1] - step * (gravity + drag)];
                without = [without[0] + step * without[1], without[1] - step * gravity];
            }
            let moved = SPHERE.moved(time, start, gravity);
            let found = moved / (with[0] - without[0]);
            // what the drag does to itself is left out: less than the drag is known to
            assert!((found - 1.0).abs() < DRAG_REL_SD, "{time}: {found}");
        }
    }
}

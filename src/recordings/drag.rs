//! Sizes what the air takes from a falling sphere, which no flight here is fitted with.

use std::f64::consts::PI;

/// Of air at 20 °C and 1013 hPa, in kg/m³ and m²/s.
const AIR_DENSITY: f64 = 1.204;
const AIR_KINEMATIC_VISCOSITY: f64 = 1.516e-5;

/// Deceleration by the air over g, of a sphere of this diameter in m and density in kg/m³ at a speed in m/s.
///
/// Drag coefficient 24/Re (1 + 0.15 Re^0.687), to 13 % or better below Re = 800. Source: Schiller & Naumann, Z. Ver. Dtsch.
/// Ing. 77, 318 (1933).
pub fn drag_over_weight(diameter: f64, density: f64, speed: f64) -> f64 {
    let reynolds = speed * diameter / AIR_KINEMATIC_VISCOSITY;
    let coefficient = 24.0 / reynolds * (1.0 + 0.15 * reynolds.powf(0.687));
    let area = 0.25 * PI * diameter * diameter;
    let mass = PI / 6.0 * diameter * diameter * diameter * density;
    let force = 0.5 * AIR_DENSITY * coefficient * area * speed * speed;
    force / (mass * crate::physics::numbers::GRAVITY)
}

#[cfg(test)]
mod tests {
    use super::drag_over_weight;

    #[test]
    fn slow_spheres_feel_stokes_drag() {
        let (diameter, density, speed) = (1e-5, 1000.0, 1e-4);
        let stokes =
            18.0 * super::AIR_KINEMATIC_VISCOSITY * super::AIR_DENSITY * speed / (density * diameter * diameter);
        let found = drag_over_weight(diameter, density, speed) * crate::physics::numbers::GRAVITY;
        assert!((found / stokes - 1.0).abs() < 1e-2, "{found} {stokes}");
    }
}

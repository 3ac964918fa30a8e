//! Holds the spheres that have a k of their own: the particles of the scene, or each diameter of a particle.

use crate::error::{Error, Problem};
use crate::rounding::to_digits;
use crate::scene::{DryKOf, Scene};
use crate::units::millimetres;

/// Most spheres of one fit: their k are fitted together, in matrices of all of them.
pub const MOST_SPHERES: usize = 300;

/// The spheres that share one k: a particle, or one diameter of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    /// index into the scene's particles
    pub particle: usize,
    /// mean D of its runs, m; `None` where the particle has one k at every diameter, or has no runs
    pub diameter: Option<f64>,
}

impl Sphere {
    /// Its words in names of files: `PTFE`, `PTFE,4.762`.
    pub fn label(&self, scene: &Scene) -> String {
        sphere_label(&scene.particles[self.particle].name, self.diameter)
    }

    /// Its words in a text: `PTFE`, `PTFE of 4.762 mm`.
    pub fn words(&self, scene: &Scene) -> String {
        sphere_words(&scene.particles[self.particle].name, self.diameter)
    }

    /// Whether a result is of it: by the particle's name, and the diameter where each has a k of its own.
    pub fn owns(&self, scene: &Scene, particle: &str, diameter: Option<f64>) -> bool {
        scene.particles[self.particle].name == particle && self.diameter == diameter
    }
}

/// Fails where there are more spheres than are fitted together.
pub(super) fn check_spheres(scene: &Scene, spheres: &[Sphere]) -> Result<(), Error> {
    let count = spheres.len();
    if count <= MOST_SPHERES {
        return Ok(());
    }
    let (place, what) = match scene.model.dry_k {
        DryKOf::Particle => ("[particles]", "particles"),
        DryKOf::Diameter => ("[model] dry_k", "diameters of particles"),
    };
    let expected = format!("expected at most {MOST_SPHERES}, since all k are fitted together: split the scene");
    let found = format!("{count} {what}, each with a k of its own");
    Err(Error::input(
        &scene.file,
        vec![Problem::new(place, expected).found(found)],
    ))
}

/// The words in names of files of a particle, and of its diameter in m where it is one of several.
pub fn sphere_label(particle: &str, diameter: Option<f64>) -> String {
    match diameter {
        Some(diameter) => format!("{particle},{}", diameter_in_mm(diameter)),
        None => particle.to_owned(),
    }
}

/// The words in a text of a particle, and of its diameter in m where it is one of several.
pub fn sphere_words(particle: &str, diameter: Option<f64>) -> String {
    match diameter {
        Some(diameter) => format!("{particle} of {} mm", diameter_in_mm(diameter)),
        None => particle.to_owned(),
    }
}

/// A diameter in mm as names have it: to five digits, which tell diameters apart that differ by 0.1 %.
pub fn diameter_in_mm(diameter: f64) -> f64 {
    to_digits(millimetres(diameter), 5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diameter_is_written_as_a_file_gives_it() {
        for mm in [3.175, 4.762, 8.0, 12.7, 0.5, 25.4] {
            assert_eq!(diameter_in_mm(mm / 1e3), mm);
        }
        assert_eq!(diameter_in_mm(4.762_000_3e-3), 4.762);
        assert_eq!(sphere_label("PTFE", Some(4.762e-3)), "PTFE,4.762");
    }
}

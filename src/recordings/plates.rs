//! Compares the heights at which recordings of one list and one scale meet the plate.
//!
//! A frame that is missing or repeated at a contact is seen in no flight, but lets both meet too high or too low.

use super::flights::SURE;
use super::impact::Level;

/// The height at which a recording meets the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlateHeight {
    /// in m
    pub level: Level,
    /// by how much it would be higher for each frame that is missing at the contact, in m
    pub by_a_frame: f64,
    /// thickness of the film
    pub film: f64,
    /// pixels per m, and diameter of the sphere: heights of others are not compared
    pub scale_and_diameter: [f64; 2],
}

/// Distance in m of each height from that of the other recordings, where it differs alone, or as few do: the others
/// agree. `None` of the others, and of fewer than three.
pub(super) fn alone(plates: &[Option<PlateHeight>]) -> Vec<Option<f64>> {
    let distance = |own: &Option<PlateHeight>| {
        let own = own.as_ref()?;
        let is_alike = |of: &&PlateHeight| of.scale_and_diameter == own.scale_and_diameter;
        // itself among them
        distance_from_others(own, plates.iter().flatten().filter(is_alike).collect())
    };
    plates.iter().map(distance).collect()
}

fn distance_from_others(own: &PlateHeight, all: Vec<&PlateHeight>) -> Option<f64> {
    /// recordings that show where the plate is, with the one that differs
    const ENOUGH: usize = 3;
    /// of what a frame does, by which a plate may be lifted
    const STEADY: f64 = 0.25;
    /// others for each, where several differ alike
    const OTHERS: usize = 8;
    /// frames: a plate or a camera that was moved farther was moved on purpose
    const MOST_FRAMES: f64 = 4.0;
    let is_near = |a: &PlateHeight, b: &PlateHeight| {
        let explained = a.film.max(b.film) + SURE * a.level.sd.hypot(b.level.sd) + STEADY * own.by_a_frame;
        (a.level.height - b.level.height).abs() <= explained
    };
    let near = |a: &PlateHeight| all.iter().filter(|b| is_near(a, b)).count();
    let usual = all.iter().max_by_key(|of| near(of))?;
    if all.len() < ENOUGH || is_near(own, usual) {
        return None;
    }
    // each is near itself
    let most_agree = near(usual) >= 2 && 3 * near(usual) >= 2 * (all.len() - 1);
    let is_alone = near(own) == 1 || OTHERS * near(own) <= near(usual);
    let distance = (own.level.height - usual.level.height).abs();
    (most_agree && is_alone && distance < MOST_FRAMES * own.by_a_frame).then_some(distance)
}

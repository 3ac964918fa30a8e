//! Holds that scenes read back in any unit.

use proptest::prelude::*;
use proptest::sample::select;
use wetcor::scene::Scene;
use wetcor::units::{Dimension, Unit};

use super::{hold, Folder};

/// One key of a scene: its table, name without unit, dimension, and value in SI.
pub type Line = (&'static str, &'static str, Dimension, f64);

/// The dimensional keys of a scene with values anywhere a file may have them.
pub fn scene_lines() -> impl Strategy<Value = Vec<(Line, Unit)>> {
    let keys = [
        ("data", "min_film", Dimension::Thickness),
        ("data", "min_impact_speed", Dimension::Speed),
        ("data", "max_impact_speed", Dimension::Speed),
        ("particles.PTFE", "density", Dimension::Density),
        ("particles.PTFE", "roughness", Dimension::Thickness),
        ("liquids.AK10", "density", Dimension::Density),
        ("liquids.AK10", "viscosity", Dimension::Viscosity),
        ("liquids.AK10", "surface_tension", Dimension::SurfaceTension),
        ("model", "dry_speed", Dimension::Speed),
    ];
    keys.map(|(table, key, dimension)| {
        let value = prop_oneof![4 => -6.0..6.0, 1 => -59.0..59.0].prop_map(|exponent: f64| 10f64.powf(exponent));
        (value, select(dimension.units().to_vec()))
            .prop_map(move |(value, unit)| ((table, key, dimension, value), unit))
    })
    .to_vec()
}

/// A scene of some lines; `\n` ends each.
pub fn scene_text(lines: &[(Line, Unit)]) -> String {
    let mut text = String::from("title = \"any\"\n");
    let mut open = "";
    for ((table, key, _, value), unit) in lines {
        if *table != open {
            text.push_str(&format!("[{table}]\n"));
            open = table;
            if open == "data" {
                text.push_str("runs = \"runs.csv\"\n");
            }
        }
        text.push_str(&format!("{key}{} = {:e}\n", unit.suffix, unit.from_si(*value)));
    }
    text
}

/// The values of [`scene_lines`], as a scene has them.
fn values(scene: &Scene) -> Option<[f64; 9]> {
    let (particle, liquid, screens) = (scene.particles.first()?, scene.liquids.first()?, &scene.data.screens);
    let dry_speed = match scene.model.dry_speed {
        wetcor::physics::DrySpeed::Reference(speed) => speed,
        wetcor::physics::DrySpeed::Impact => return None,
    };
    Some([
        screens.min_film?,
        screens.min_impact_speed?,
        screens.max_impact_speed?,
        particle.density,
        particle.roughness?,
        liquid.density,
        liquid.viscosity,
        liquid.surface_tension?,
        dry_speed,
    ])
}

#[test]
fn a_scene_reads_back_whatever_its_units_and_line_ends() {
    let folder = Folder::new();
    let dress = (select(vec!["\n", "\r\n"]), select(vec!["", "\u{feff}"]));
    let name = "a_scene_reads_back_whatever_its_units_and_line_ends";
    hold(name, 500, (scene_lines(), dress), |(lines, (end, mark))| {
        let text = format!("{mark}{}", scene_text(&lines).replace('\n', end));
        let scene = folder.scene(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let read = values(&scene).expect("all are there");
        for (read, ((_, key, _, written), _)) in read.into_iter().zip(&lines) {
            // equal but for the roundings of two changes of unit
            let is_same = (read - *written).abs() <= 4.0 * f64::EPSILON * written.abs();
            assert!(is_same, "{key}: {read:e} for {written:e}");
        }
    });
}

//! Holds that scenes read back in any unit, and that one mistake is named by its line and key.

use proptest::prelude::*;
use proptest::sample::{select, Index};
use wetcor::scene::Scene;
use wetcor::units::{Dimension, Unit};

use super::{assert_told, hold, same, Folder};

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
            assert!(same(read, *written), "{key}: {read:e} for {written:e}");
        }
    });
}

#[test]
fn one_mistake_in_a_scene_is_named_by_its_line_and_key() {
    let folder = Folder::new();
    let kinds = "= \"5\"|= []|= true|= nan|= inf|= -inf|= -1.0|= 0|= 1e308|= 1e-308|= 5e-324|= 1e999|= 99e99|x = 1\
        |_furlongs = 1|\u{e9} = 1";
    let name = "one_mistake_in_a_scene_is_named_by_its_line_and_key";
    let inputs = (
        scene_lines(),
        any::<Index>(),
        select(kinds.split('|').collect::<Vec<&str>>()),
    );
    hold(name, 1000, inputs, |(lines, which, kind)| {
        let ((_, key, _, _), unit) = &lines[which.index(lines.len())];
        let good = scene_text(&lines);
        let written = format!("{key}{} = ", unit.suffix);
        let bad: Vec<&str> = good.split('\n').collect();
        let table = format!("[{}]", lines[which.index(lines.len())].0 .0);
        let from = bad.iter().position(|line| *line == table).expect("its table");
        let at = from
            + bad[from..]
                .iter()
                .position(|line| line.starts_with(&written))
                .expect("its line");
        let mistake = if let Some(value) = kind.strip_prefix('=') {
            format!("{written}{value}")
        } else if let Some(ending) = kind.strip_prefix('_') {
            format!("{key}_{ending}")
        } else {
            // a key in quotes may hold any letter
            let (letters, rest) = kind.split_once(' ').expect("a letter more");
            format!("\"{key}{}{letters}\" {rest}", unit.suffix)
        };
        let mut lines: Vec<String> = bad.iter().map(|line| (*line).to_owned()).collect();
        lines[at] = mistake;
        let error = folder.scene(&lines.join("\n")).expect_err("a mistake");
        let text = assert_told(&error, "scene.toml");
        assert!(text.contains(&format!("line {}, {table} {key}", at + 1)), "{text}");
        assert!(text.contains(": 1 problem;"), "{text}");
    });
}

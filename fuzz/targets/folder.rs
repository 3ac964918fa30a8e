//! Reads any folder back and predicts from it: the input holds `findings.json`, the table of draws and the store's
//! `zarr.json`, with zero bytes between. Its first byte says whether the parts are tied to each other as ours are.
#![no_main]

use wetcor::physics::Setting;
use wetcor::report::draws::tie::{Tie, STORE, TABLE};
use wetcor::report::finished::Finished;
use wetcor::report::prediction::{self, Prediction};
use wetcor_fuzz::{folder, is_line};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else {
        return;
    };
    let mut parts = bytes.splitn(3, |byte| *byte == 0);
    let (Some(findings), Some(draws)) = (parts.next(), parts.next()) else {
        return;
    };
    let tied = format!("{{\"attributes\":{}}}", {
        let attributes = Tie::of(findings, draws).attributes();
        serde_json::Value::Object(attributes.into_iter().collect())
    });
    let root = match parts.next() {
        Some(root) if kind % 4 == 3 => root,
        _ => tied.as_bytes(),
    };
    let folder = folder().join("finished");
    std::fs::create_dir_all(folder.join(STORE)).expect("the folder is writable");
    for (name, bytes) in [
        ("findings.json", findings),
        (TABLE, draws),
        (&format!("{STORE}/zarr.json"), root),
    ] {
        std::fs::write(folder.join(name), bytes).expect("the folder is writable");
    }
    let table = Finished::read(&folder).and_then(|finished| {
        let particles: Vec<String> = finished.basis.particles.iter().map(|p| p.name.clone()).collect();
        let mut tables = vec![];
        for particle in particles.iter().take(2) {
            let law = finished.law(particle, 4e-3)?;
            for liquid in finished.basis.liquids.iter().take(2) {
                let setting = Setting {
                    density: 2150.0,
                    diameter: 4e-3,
                    roughness: Some(5e-6),
                    liquid_density: liquid.density_kg_m3,
                    viscosity: liquid.viscosity_pa_s,
                    film: 2e-4,
                    surface_tension: liquid.surface_tension_n_m,
                };
                let rows = law.curve(Some(&setting)).predict(&[0.05, 0.3, 2.0]);
                let name = Some(liquid.name.as_str());
                let prediction = Prediction::new(particle, name, setting.diameter, Some(&setting), rows);
                tables.push(prediction::csv(&[prediction], finished.drawn_from(), false)?);
            }
        }
        Ok(tables.concat().to_lowercase())
    });
    match table {
        Ok(table) => assert!(!table.contains("nan") && !table.contains("inf"), "{table}"),
        Err(error) => assert!(error.to_string().lines().all(is_line), "{error}"),
    }
});

//! Reads any `findings.json` back and predicts from it.
#![no_main]

use wetcor::physics::Setting;
use wetcor::report::finished::Finished;
use wetcor::report::prediction::{self, Prediction};
use wetcor_fuzz::{folder, is_line};

libfuzzer_sys::fuzz_target!(|findings: &[u8]| {
    let folder = folder().join("finished");
    std::fs::create_dir_all(&folder).expect("the folder is writable");
    std::fs::write(folder.join("findings.json"), findings).expect("the folder is writable");
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
                tables.push(prediction::csv(&[prediction], false)?);
            }
        }
        Ok(tables.concat().to_lowercase())
    });
    match table {
        Ok(table) => assert!(!table.contains("nan") && !table.contains("inf"), "{table}"),
        Err(error) => assert!(error.to_string().lines().all(is_line), "{error}"),
    }
});

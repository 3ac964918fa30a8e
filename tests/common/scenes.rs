//! Writes scenes, most of which hold the same spheres and liquids.

pub const PTFE: &str = "[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n";
pub const PE: &str = "[particles.PE]\ndensity_kg_m3 = 940\nroughness_um = 5\n";
pub const AK10: &str = "[liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
pub const M20: &str = "[liquids.M20]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 20\n";
pub const M50: &str = "[liquids.M50]\ndensity_kg_m3 = 965\nviscosity_mPa_s = 48.3\n";
/// As viscous as AK10.
pub const THIN: &str = "[liquids.thin]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";

/// The first line of a table of runs in the usual units.
pub const HEADER: &str = "particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution\n";

/// The beginning of a scene whose runs lie in `runs.csv`: these parts one after the other, the first of them still in `[data]`
/// if it opens no table of its own.
pub fn scene_of(title: &str, parts: &[&str]) -> String {
    format!("\ntitle = \"{title}\"\n[data]\nruns = \"runs.csv\"\n{}", parts.concat())
}

/// The model of most truths.
pub const STEPWISE: &str = "[model]\ninertia = \"stepwise\"\n";

/// The truth of PTFE: L and C, the sds of dry and wet runs, and more lines; its inertia is that of the model if none is among these.
pub fn truth([l, c, dry, wet]: [f64; 4], more: &str) -> String {
    format!(
        "[truth]\ndry_k = {{ PTFE = 0.183 }}\nlubrication_log = {l:?}\ninertial_prefactor = {c:?}\nsigma_dry = {dry:?}\n\
         sigma_wet = {wet:?}\n{more}"
    )
}

/// A design of PTFE: its diameters in mm and film ratios, its liquids, drop heights in mm and dry speeds in m/s, and more lines.
pub fn design([diameters, films]: [&str; 2], liquids: &[&str], [heights, dry_speeds]: [&str; 2], more: &str) -> String {
    format!(
        "[design]\ndiameter_mm = {{ PTFE = [{diameters}] }}\nliquids = {liquids:?}\nfilm_ratio = {{ PTFE = [{films}] }}\n\
         height_mm = [{heights}]\ndry_impact_speed_m_s = [{dry_speeds}]\n{more}"
    )
}

/// The model and the truth of the example.
pub const SATURATING: &str = r#"[model]
inertia = "saturating"
[truth]
dry_k = { PTFE = 0.183 }
lubrication_log = 1.85
inertia = "saturating"
inertial_prefactor = 0.47
film_scale = 0.069
dry_speed_m_s = 2.0
sigma_dry = 0.009
sigma_wet = 0.02
"#;

/// Two diameters, two liquids, three film ratios and five heights.
pub const DESIGN: &str = r#"[design]
diameter_mm = { PTFE = [3.175, 8.0] }
liquids = ["AK10", "M50"]
film_ratio = { PTFE = [0.04, 0.08, 0.15] }
height_mm = [30, 60, 90, 120, 150]
dry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]
"#;

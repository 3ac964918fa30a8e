//! Writes the report as markdown: verdict and main numbers first, then what they rest on.

use super::numbers::{self, NONE};
use super::Told;
use crate::findings::estimate::Estimate;
use crate::findings::overview::{Material, Overview};
use crate::findings::scaling::{reference_dry_speed, Scaling};
use crate::findings::verdicts::quotable;
use crate::findings::{Findings, Verdict};
use crate::physics::impact::DrySpeed;
use crate::scene::{Law, Published};
use crate::units::{micrometres, millimetres};

/// A markdown text in the making.
struct Page {
    text: String,
    figures: Vec<String>,
}

impl Page {
    fn heading(&mut self, title: &str) {
        self.text.push_str(&format!("## {title}\n\n"));
    }

    fn paragraph(&mut self, text: &str) {
        self.text.push_str(text);
        self.text.push_str("\n\n");
    }

    fn table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        let mut line = |cells: &[String]| {
            self.text.push_str("| ");
            self.text.push_str(&cells.join(" | "));
            self.text.push_str(" |\n");
        };
        line(&header.iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>());
        line(&vec!["---".to_owned(); header.len()]);
        for row in rows {
            line(&row.iter().map(|cell| escaped(cell)).collect::<Vec<_>>());
        }
        self.text.push('\n');
    }

    /// Places a figure that was drawn; nothing where figures were not asked for.
    fn figure(&mut self, name: &str, caption: &str) {
        if self.figures.iter().any(|drawn| drawn == name) {
            self.paragraph(&format!("![{caption}](figures/{name})\n*{caption}*"));
        }
    }
}

/// Keeps a cell one cell.
fn escaped(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

/// The whole report; `figures` are the names of those that were drawn.
pub fn report(told: Told, figures: &[&str]) -> String {
    let mut page = Page {
        text: format!("# {}\n\n", one_line(&told.scene.title)),
        figures: figures.iter().map(|name| (*name).to_owned()).collect(),
    };
    page.paragraph(&verdict_line(told.findings));
    if let Some(source) = &told.scene.source {
        page.paragraph(&format!("Runs: {}", one_line(source)));
    }
    main_numbers(&mut page, told);
    published(&mut page, told);
    data(&mut page, told);
    dry(&mut page, told);
    series(&mut page, told);
    scaling(&mut page, told);
    film(&mut page, told);
    energy(&mut page, told);
    cautions(&mut page, told);
    reproduce(&mut page, told);
    let mut text = page.text.trim_end().to_owned();
    text.push('\n');
    text
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The first line: whether the main numbers may be quoted.
pub fn verdict_line(findings: &Findings) -> String {
    let failed: Vec<&str> = findings
        .verdicts
        .iter()
        .filter(|check| check.gates && !check.passed)
        .map(|check| check.text.as_str())
        .collect();
    let cautions = findings
        .verdicts
        .iter()
        .filter(|check| !check.gates && !check.passed)
        .count()
        + findings.notices.len();
    let see = match cautions {
        0 => String::new(),
        1 => " One caution stands at the end.".to_owned(),
        n => format!(" {n} cautions stand at the end."),
    };
    if quotable(&findings.verdicts) {
        format!("**Verdict: the main numbers may be quoted.**{see}")
    } else {
        format!("**Verdict: not to be quoted: {}.**{see}", failed.join("; "))
    }
}

/// Names of the particles that have any estimate, in the order of the scene.
fn estimated(told: Told) -> Vec<String> {
    let findings = told.findings;
    let has = |name: &str| {
        findings.dry.iter().any(|dry| dry.particle == name) || findings.scaling.iter().any(|row| row.particle == name)
    };
    told.scene
        .particles
        .iter()
        .map(|p| p.name.clone())
        .filter(|name| has(name))
        .collect()
}

fn main_numbers(page: &mut Page, told: Told) {
    let findings = told.findings;
    page.heading("Main numbers");
    page.paragraph(
        "e_dry = 1 − k v^(1/5) and e² = e_dry² − C ρ̃ g(δ/D) − 4 L/St, with St = ρp D v/(9 η) and L = ln(δc/ε). \
         ± is one standard error (least squares, delta method); k comes from the dry runs, \
         the others from every rebound at once, together with what the dry runs say of k.",
    );
    let level = interval_header(told);
    let mut rows: Vec<Vec<String>> = findings
        .dry
        .iter()
        .map(|dry| number(format!("k / (m/s)^(−1/5), {}", dry.particle), &dry.dry_k))
        .collect();
    if let Some(balance) = &findings.energy_balance {
        for parameter in &balance.parameters {
            if let Some(name) = parameter_name(&parameter.name, balance.inertia) {
                rows.push(number(name, &parameter.estimate));
            }
        }
        rows.push(number("δc/ε = exp(L)".to_owned(), &balance.delta_c_over_roughness));
    }
    page.table(&["quantity", "value", &level], &rows);
    let rows: Vec<Vec<String>> = findings
        .scaling
        .iter()
        .filter(|row| row.law == Law::Sqrt.name())
        .filter_map(|row| {
            Some(vec![
                row.particle.clone(),
                numbers::short(row.film_ratio?),
                format!("{} ({})", row.runs, row.stuck),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c),
                row.st_no_rebound.as_ref().map_or(NONE.to_owned(), numbers::estimate),
                numbers::optional(row.correlation, 2),
            ])
            .map(|mut cells| {
                cells.extend(bias_cells(row));
                cells.extend([numbers::optional(row.residual_sd, 2), told_verdict(&row.verdict)]);
                cells
            })
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    let speed = numbers::short(reference_dry_speed(told.scene));
    page.paragraph(&format!(
        "e_inf and St_c by the square-root law e = e_inf √(1 − 2 St_c/St), at each film ratio; it is zero at \
         2 St_c, below which nothing rebounds. e_inf holds for e_dry at {speed} m/s. The law takes liquids of \
         different density ratio as one; its bias is what that gets wrong, by fitting it to the noise-free \
         energy balance at the same runs."
    ));
    page.table(
        &[
            "particle",
            "δ/D",
            "rebounds (stuck)",
            "e_inf",
            "St_c",
            "2 St_c",
            "corr(e_inf, St_c)",
            "bias of e_inf",
            "bias of St_c",
            "residual sd",
            "verdict",
        ],
        &rows,
    );
}

fn number(name: String, estimate: &Estimate) -> Vec<String> {
    vec![name, numbers::estimate(estimate), numbers::interval(estimate)]
}

/// How the report names a parameter of the energy balance; k is told from the dry runs alone.
fn parameter_name(name: &str, inertia: &str) -> Option<String> {
    match name {
        "lubrication_log" => Some("L".to_owned()),
        "inertial_prefactor" => Some(format!("C ({inertia})")),
        "film_scale" => Some("δ̃0, film scale".to_owned()),
        _ => None,
    }
}

fn published(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.published.is_empty() {
        return;
    }
    page.heading("Beside the literature");
    page.paragraph("Difference: ours minus published, in combined standard errors.");
    let rows: Vec<Vec<String>> = findings
        .published
        .iter()
        .map(|row| {
            let ours = match (row.ours, row.ours_se) {
                (Some(value), Some(se)) => numbers::with_se(value, se),
                (value, _) => numbers::optional(value, 4),
            };
            vec![
                row.particle.clone(),
                symbol(row.quantity).to_owned(),
                row.film_ratio.map_or("all".to_owned(), numbers::short),
                row.law.map_or(NONE.to_owned(), law_name),
                ours,
                // as published, not rounded again
                format!("{} ± {}", row.value, row.se),
                row.difference_in_se.map_or(NONE.to_owned(), numbers::signed),
            ]
        })
        .collect();
    page.table(
        &["particle", "quantity", "δ/D", "law", "ours", "published", "difference"],
        &rows,
    );
    let mut sources: Vec<&str> = told
        .scene
        .published
        .iter()
        .map(|p: &Published| p.source.as_str())
        .collect();
    sources.dedup();
    sources.sort_unstable();
    sources.dedup();
    page.paragraph(&format!("Published: {}.", sources.join("; ")));
}

fn symbol(quantity: &str) -> &str {
    match quantity {
        "dry_k" => "k",
        "st_c" => "St_c",
        other => other,
    }
}

fn law_name(law: &str) -> String {
    if law == Law::Sqrt.name() {
        "square root".to_owned()
    } else {
        law.to_owned()
    }
}

fn list(values: &[f64], scale: impl Fn(f64) -> f64) -> String {
    let texts: Vec<String> = values.iter().map(|x| numbers::short(scale(*x))).collect();
    match texts.as_slice() {
        // a long list says less than its ends
        [first, .., last] if texts.len() > 8 => format!("{} from {first} to {last}", texts.len()),
        _ => texts.join(", "),
    }
}

/// The table of what was read, for the report and the `check` command.
pub fn materials(materials: &[Material]) -> (Vec<&'static str>, Vec<Vec<String>>) {
    let header = vec![
        "particle",
        "liquid",
        "runs",
        "stuck",
        "D / mm",
        "δ/D",
        "δ / µm",
        "v / (m/s)",
        "St",
        "Re",
        "e",
    ];
    let range = |range: Option<[f64; 2]>| range.map_or(NONE.to_owned(), numbers::range);
    let rows = materials
        .iter()
        .map(|row| {
            let ratios = if row.film_ratios.is_empty() {
                NONE.to_owned()
            } else {
                list(&row.film_ratios, |x| x)
            };
            vec![
                row.particle.clone(),
                row.liquid.clone(),
                row.runs.to_string(),
                row.stuck.to_string(),
                list(&row.diameters_m, millimetres),
                ratios,
                range(row.film_m.map(|film| film.map(micrometres))),
                numbers::range(row.impact_speed_m_s),
                range(row.stokes),
                range(row.reynolds),
                range(row.restitution),
            ]
        })
        .collect();
    (header, rows)
}

fn data(page: &mut Page, told: Told) {
    let counts = &told.findings.counts;
    page.heading("Data");
    let screened: usize = counts.screened.iter().map(|s| s.runs).sum();
    page.paragraph(&format!(
        "{} runs read, {screened} screened, {} stuck, {} used by least squares. \
         St and Re = ρl δ v/η are ranges over the runs, e over the rebounds.",
        counts.runs, counts.stuck, counts.used
    ));
    let (header, rows) = materials(&told.overview.materials);
    page.table(&header, &rows);
}

fn dry(page: &mut Page, told: Told) {
    if told.findings.dry.is_empty() {
        return;
    }
    page.heading("Dry law");
    let mut rows = vec![];
    for dry in &told.findings.dry {
        let all = if dry.by_diameter.len() > 1 {
            "all".to_owned()
        } else {
            list(&diameters(dry), millimetres)
        };
        rows.push(vec![
            dry.particle.clone(),
            all,
            dry.runs.to_string(),
            numbers::estimate(&dry.dry_k),
            numbers::interval(&dry.dry_k),
            numbers::optional(dry.residual_sd, 2),
            told_verdict(&dry.verdict),
        ]);
        if dry.by_diameter.len() > 1 {
            rows.extend(dry.by_diameter.iter().map(|one| {
                vec![
                    dry.particle.clone(),
                    numbers::short(millimetres(one.diameter_m)),
                    one.runs.to_string(),
                    numbers::estimate(&one.dry_k),
                    numbers::interval(&one.dry_k),
                    String::new(),
                    one.dry_k.why_none.clone().unwrap_or_default(),
                ]
            }));
        }
    }
    let level = interval_header(told);
    page.table(
        &[
            "particle",
            "D / mm",
            "runs",
            "k / (m/s)^(−1/5)",
            &level,
            "residual sd",
            "verdict",
        ],
        &rows,
    );
    for dry in &told.findings.dry {
        if let Some(test) = &dry.heterogeneity {
            page.paragraph(&format!(
                "{}: one k for all diameters, F({}, {}) = {}, p {}.",
                dry.particle,
                test.df_between,
                test.df_within,
                numbers::significant(test.f, 3),
                equals(test.p)
            ));
        }
    }
}

fn diameters(dry: &crate::findings::dry::Dry) -> Vec<f64> {
    dry.by_diameter.iter().map(|one| one.diameter_m).collect()
}

fn equals(p: f64) -> String {
    let text = numbers::probability(p);
    if text.starts_with("below") {
        text
    } else {
        format!("= {text}")
    }
}

fn interval_header(told: Told) -> String {
    format!("{} % interval", numbers::short(100.0 * told.scene.bootstrap.level))
}

fn told_verdict(verdict: &Verdict) -> String {
    if verdict.passed {
        "usable".to_owned()
    } else {
        format!("not usable: {}", verdict.reason)
    }
}

fn series(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.series.is_empty() {
        return;
    }
    page.heading("Wet series");
    let offset = match told.scene.model.dry_speed {
        DrySpeed::Reference(_) => String::new(),
        DrySpeed::Impact => {
            " α is quoted at the reference dry speed; each run's own enters as a known offset.".to_owned()
        }
    };
    page.paragraph(&format!(
        "e = √(α + β/v), one law a series; the threshold is the speed −β/α below which it gives no rebound.{offset}"
    ));
    for name in estimated(told) {
        page.figure(
            &super::figures::speed_name(&name),
            &format!("{name}: restitution against impact speed at one film ratio. Points are means of repeated speeds with their standard errors, curves the fits of this section and the dry law (as figs. 2a and 2c of Müller & Huang 2016)."),
        );
    }
    let rows: Vec<Vec<String>> = findings
        .series
        .iter()
        .map(|row| {
            vec![
                row.particle.clone(),
                row.liquid.clone(),
                numbers::short(millimetres(row.diameter_m)),
                numbers::significant(micrometres(row.film_m), 3),
                format!("{} ({})", row.runs, row.stuck),
                numbers::estimate(&row.alpha),
                numbers::estimate(&row.beta),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.threshold_speed_m_s),
                numbers::optional(row.residual_sd, 2),
                told_verdict(&row.verdict),
            ]
        })
        .collect();
    page.table(
        &[
            "particle",
            "liquid",
            "D / mm",
            "δ / µm",
            "rebounds (stuck)",
            "α",
            "β / (m/s)",
            "e_inf",
            "threshold / (m/s)",
            "residual sd",
            "verdict",
        ],
        &rows,
    );
}

fn bias_cells(row: &Scaling) -> [String; 2] {
    row.bias.map_or([NONE.to_owned(), NONE.to_owned()], |bias| {
        [
            numbers::shift(bias.e_inf, row.e_inf.se),
            numbers::shift(bias.st_c, row.st_c.se),
        ]
    })
}

fn scaling(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.scaling.is_empty() {
        return;
    }
    page.heading("Scaling with the Stokes number");
    page.paragraph(
        "The linear law is e = e_inf (1 − St_c/St). Here both laws are fitted over all film ratios; \
         p is the probability, by an F test against one law at each film ratio, of so large a difference by chance. \
         Bias is what the linear law gets wrong when fitted to the noise-free square root at the same runs.",
    );
    for name in estimated(told) {
        page.figure(
            &super::figures::stokes_name(&name),
            &format!(
                "{name}: restitution against 1/St at one film ratio, with both laws fitted to it (as figs. 2b and 2d)."
            ),
        );
        page.figure(
            &super::figures::film_ratios_name(&name),
            &format!("{name}: restitution against 1/St at every film ratio, with both laws fitted over all of them (as fig. 3)."),
        );
    }
    let rows: Vec<Vec<String>> = findings
        .scaling
        .iter()
        .filter(|row| row.film_ratio.is_none())
        .map(|row| {
            let mut cells = vec![
                row.particle.clone(),
                law_name(row.law),
                format!("{} ({})", row.runs, row.stuck),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c),
                numbers::optional(row.correlation, 2),
            ];
            cells.extend(bias_cells(row));
            cells.extend([
                numbers::optional(row.residual_sd, 2),
                row.one_for_all
                    .map_or(NONE.to_owned(), |test| numbers::probability(test.p)),
                told_verdict(&row.verdict),
            ]);
            cells
        })
        .collect();
    page.table(
        &[
            "particle",
            "law",
            "rebounds (stuck)",
            "e_inf",
            "St_c",
            "corr",
            "bias of e_inf",
            "bias of St_c",
            "residual sd",
            "p",
            "verdict",
        ],
        &rows,
    );
}

fn film(page: &mut Page, told: Told) {
    let linear = told.findings.scaling.iter().filter(|row| row.law == Law::Linear.name());
    let rows: Vec<Vec<String>> = linear
        .filter_map(|row| {
            let mut cells = vec![
                row.particle.clone(),
                numbers::short(row.film_ratio?),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c),
                numbers::optional(row.correlation, 2),
            ];
            cells.extend(bias_cells(row));
            cells.extend([numbers::optional(row.residual_sd, 2), told_verdict(&row.verdict)]);
            Some(cells)
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    page.heading("Film thickness");
    page.paragraph("The linear law at each film ratio, to set beside the square root's e_inf and St_c above.");
    page.figure(
        super::figures::FILM,
        "e_inf and St_c against the film ratio by both laws; bars are standard errors (as fig. 4).",
    );
    page.table(
        &[
            "particle",
            "δ/D",
            "e_inf",
            "St_c",
            "corr",
            "bias of e_inf",
            "bias of St_c",
            "residual sd",
            "verdict",
        ],
        &rows,
    );
}

fn energy(page: &mut Page, told: Told) {
    let findings = told.findings;
    if findings.energy.is_empty() {
        return;
    }
    page.heading("Energy");
    page.paragraph(
        "(e_dry² − e_inf²)/ρ̃ is what the liquid's inertia takes, over the density ratio; eq. Eint2 (stepwise) and \
         eq. Eint1 (cap) are the paper's predictions for it. St_c e_inf² = 2 L gives δc = ε exp(L), \
         with its interval made on the logarithm.",
    );
    page.figure(
        super::figures::ENERGY,
        "Inertial loss over density ratio with both predictions, and St_c e_inf², against the film ratio by the square-root law; bars are standard errors (as fig. 5).",
    );
    let rows: Vec<Vec<String>> = findings
        .energy
        .iter()
        .map(|row| {
            vec![
                row.particle.clone(),
                numbers::short(row.film_ratio),
                law_name(row.law),
                numbers::significant(row.density_ratio, 3),
                numbers::estimate(&row.loss_over_density_ratio),
                numbers::significant(row.stepwise, 3),
                numbers::optional(row.cap, 3),
                numbers::estimate(&row.st_c_e_inf2),
                numbers::estimate_scaled(&row.delta_c_m, micrometres),
                numbers::interval_scaled(&row.delta_c_m, micrometres),
            ]
        })
        .collect();
    let level = interval_header(told);
    page.table(
        &[
            "particle",
            "δ/D",
            "law",
            "ρ̃",
            "(e_dry² − e_inf²)/ρ̃",
            "stepwise",
            "cap",
            "St_c e_inf²",
            "δc / µm",
            &level,
        ],
        &rows,
    );
}

fn cautions(page: &mut Page, told: Told) {
    let findings = told.findings;
    page.heading("Cautions");
    for notice in &findings.notices {
        page.text
            .push_str(&format!("* {}. Next: {}.\n", notice.text, notice.next_step));
    }
    if !findings.notices.is_empty() {
        page.text.push('\n');
    }
    let rows: Vec<Vec<String>> = findings
        .verdicts
        .iter()
        .filter(|check| check.gates || !check.passed)
        .map(|check| {
            let outcome = match (check.passed, check.gates) {
                (true, _) => "holds",
                (false, true) => "fails: not to be quoted",
                (false, false) => "fails",
            };
            vec![
                check.text.clone(),
                numbers::optional(check.value, 3),
                numbers::significant(check.threshold, 3),
                outcome.to_owned(),
                check.source.to_owned(),
            ]
        })
        .collect();
    page.table(&["check", "value", "line", "outcome", "why this line"], &rows);
}

fn reproduce(page: &mut Page, told: Told) {
    let findings = told.findings;
    page.heading("How to reproduce");
    let runs = told
        .scene
        .data
        .runs
        .file_name()
        .map_or(String::new(), |n| n.to_string_lossy().into_owned());
    page.paragraph(&format!(
        "`wetcor fit {}/scene.toml --seed {}`, wetcor {}. Full precision, further intervals and every reason stand in `findings.json`.",
        findings.scene, findings.seed, findings.wetcor
    ));
    page.table(
        &["input", "SHA-256"],
        &[
            vec!["scene".to_owned(), findings.scene_sha256.clone()],
            vec![runs, findings.data_sha256.clone()],
        ],
    );
}

/// The main numbers as lines for a terminal.
pub fn summary(told: Told) -> String {
    let findings = told.findings;
    let mut text = verdict_line(findings).replace("**", "");
    text.push('\n');
    for dry in &findings.dry {
        text.push_str(&format!("k[{}] = {}\n", dry.particle, numbers::estimate(&dry.dry_k)));
    }
    if let Some(balance) = &findings.energy_balance {
        for parameter in &balance.parameters {
            if parameter_name(&parameter.name, balance.inertia).is_some() {
                text.push_str(&format!(
                    "{} = {}\n",
                    parameter.name,
                    numbers::estimate(&parameter.estimate)
                ));
            }
        }
    }
    for row in findings.scaling.iter().filter(|row| row.law == Law::Sqrt.name()) {
        if let Some(ratio) = row.film_ratio {
            text.push_str(&format!(
                "{}, δ/D = {}: e_inf = {}, St_c = {}\n",
                row.particle,
                numbers::short(ratio),
                numbers::estimate(&row.e_inf),
                numbers::estimate(&row.st_c)
            ));
        }
    }
    text
}

/// What was read, for a terminal: plain columns.
pub fn overview_text(overview: &Overview) -> String {
    let mut text = format!("{}\n{} runs read", overview.title, overview.runs);
    for screened in &overview.screened {
        text.push_str(&format!(", {} left out ({})", screened.runs, screened.reason));
    }
    text.push_str("\n\n");
    let (header, rows) = materials(&overview.materials);
    let header: Vec<String> = header.into_iter().map(str::to_owned).collect();
    let all: Vec<&Vec<String>> = std::iter::once(&header).chain(&rows).collect();
    let width = |column: usize| all.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    for row in &all {
        let cells: Vec<String> = row
            .iter()
            .zip(&widths)
            .map(|(cell, width)| format!("{cell}{}", " ".repeat(width - cell.chars().count())))
            .collect();
        text.push_str(cells.join("  ").trim_end());
        text.push('\n');
    }
    text.push_str("\nWhat these runs can identify\n");
    for one in &overview.identifies {
        let answer = if one.identified { "yes" } else { "no " };
        text.push_str(&format!("  {answer}  {}: {}\n", one.quantity, one.reason));
    }
    text
}

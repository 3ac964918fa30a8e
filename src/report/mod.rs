//! Writes a report: markdown, the same as a page for a browser, its figures, and `findings.json`, whole or not at all.
//!
//! | file | job |
//! |---|---|
//! | `input.rs` | holds what a report is made of |
//! | `files.rs` | holds the files of a report before they are written |
//! | `markup.rs` | writes a text so that HTML and SVG take it as it is |
//! | `quantities.rs` | writes quantities under their symbols, in the units they are printed in |
//! | `escape.rs` | escapes for Markdown what a user wrote |
//! | `template.rs` | fills the templates, `templates/*.md`, with the filters that they use |
//! | `values/` | gathers what the templates of the report read |
//! | `figures/` | says what each figure shows |
//! | `html/` | makes a page of the report for a browser |
//! | `chart.rs` | draws a chart as SVG |
//! | `json.rs` | lays JSON out |
//! | `laws.rs` | writes the law of every pair as CSV |
//! | `draws/` | puts draws on disk |
//! | `finished.rs` | reads a report's folder back for predictions |
//! | `prediction.rs` | writes predictions |
//! | `tracking.rs` | writes the report of tracked recordings |
//! | `folder.rs` | says which folders may be written, and writes the files there |

pub mod chart;
pub mod draws;
mod escape;
pub mod figures;
mod files;
pub mod finished;
pub mod folder;
mod html;
mod input;
pub mod json;
mod laws;
mod markup;
pub mod prediction;
mod quantities;
pub(crate) mod template;
pub mod tracking;
mod values;

use schemars::generate::SchemaSettings;
use schemars::transform::RecursiveTransform;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::error::Error;
use crate::findings::estimates::EstimateRow;
use crate::findings::laws::{list_laws, PairLaw};
use crate::findings::overview::Overview;
use crate::findings::Findings;
use files::Files;

pub use input::ReportInput;

/// The whole report in Markdown; `figures` are the names of those that were drawn.
///
/// Fails where a template names what there is not.
pub fn markdown(input: ReportInput, figures: &[&str]) -> Result<String, Error> {
    template::page("report.md", &values::of_report(input), figures)
}

/// The verdict and the main numbers as lines for a terminal. Fails as [`markdown`] does.
pub fn summary(input: ReportInput) -> Result<String, Error> {
    template::plain("summary.txt", &values::of_report(input))
}

/// What was read, for a terminal. Fails as [`markdown`] does.
pub fn overview(overview: &Overview) -> Result<String, Error> {
    template::plain("overview.txt", &values::of_overview(overview))
}

/// Every file of a report by its path in the folder, `timing.json` excepted.
pub fn files(input: ReportInput, with_figures: bool) -> Result<Files, Error> {
    let figures = if with_figures { figures::all(input) } else { vec![] };
    let names: Vec<&str> = figures.iter().map(|figure| figure.name.as_str()).collect();
    let of_pairs = list_laws(input.scene, input.runs, input.findings, input.posterior);
    let file = FindingsFile {
        findings: input.findings,
        estimates: &input.findings.estimates(input.scene, input.runs, input.posterior),
        laws: &of_pairs,
        figures: &names,
    };
    let (texts, draws) = rayon::join(
        || {
            let report = markdown(input, &names)?;
            let page = html::page(&report, &figures, &html::Curves::of(input))?;
            Ok::<_, Error>([report, page, json::text(&file)?])
        },
        || {
            let draws = input.posterior.map(|own| draws::posterior::files(input, own));
            draws.transpose()
        },
    );
    let [report, page, findings] = texts?;
    let texts = [
        ("report.md".to_owned(), report),
        ("report.html".to_owned(), page),
        ("findings.json".to_owned(), findings),
    ];
    let laws = laws::files(&of_pairs)?;
    let figures = figures.into_iter();
    let figures = figures.map(|figure| (format!("figures/{}", figure.name), figure.svg));
    let mut files = Files::of(texts.into_iter().chain(laws).chain(figures));
    if let Some(draws) = draws? {
        files.whole.extend(draws.whole);
        files.streamed.extend(draws.streamed);
    }
    Ok(files)
}

/// What a fit of wetcor found. Lengths are in m, speeds in m/s, all other numbers in units of the SI, or without one. A stage
/// that was not run is null, as is a number that is not to be had; `reason` then says why.
#[derive(Serialize, JsonSchema)]
#[schemars(title = "findings.json of wetcor")]
struct FindingsFile<'a> {
    #[serde(flatten)]
    findings: &'a Findings,
    /// every estimate, one a row
    estimates: &'a [EstimateRow],
    /// the law e(v) of every pair of the runs, and of dry impacts
    laws: &'a [PairLaw],
    /// names of the figures in the folder `figures`, by which a later run knows the report's own files
    figures: &'a [&'a str],
}

/// The text of `docs/findings.schema.json`, which describes `findings.json` by the types that it is written from.
pub fn findings_schema() -> Result<String, Error> {
    // what comments say of types is told of the file
    let in_a_file = |schema: &mut schemars::Schema| {
        if let Some(Value::String(text)) = schema.get_mut("description") {
            *text = text.replace('\n', " ").replace("`None`", "null");
        }
    };
    let settings = SchemaSettings::draft2020_12().for_serialize();
    let settings = settings.with_transform(RecursiveTransform(in_a_file));
    json::text(&settings.into_generator().into_root_schema_for::<FindingsFile>())
}

//! Writes the report as markdown: verdict and main numbers first, then what they rest on.

mod bootstrap;
mod cautions;
mod cells;
mod constants;
mod errors;
pub(crate) mod escape;
mod laws;
mod main_numbers;
mod noise;
pub(crate) mod page;
mod posterior;
mod runs;
mod terms;
mod verdict;

pub use main_numbers::summary;
pub use runs::overview_text;

use super::sources::Told;
use escape::literal;
use page::Page;
use verdict::verdict_line;

/// The whole report; `figures` are the names of those that were drawn.
pub fn report(told: Told, figures: &[&str]) -> String {
    let mut page = Page::titled(&literal(&told.scene.title), figures);
    page.paragraph(&verdict_line(told.findings));
    if let Some(source) = &told.scene.source {
        page.paragraph(&format!("Runs: {}", literal(source)));
    }
    main_numbers::main_numbers(&mut page, told);
    main_numbers::published(&mut page, told);
    runs::data(&mut page, told);
    terms::terms(&mut page, told);
    laws::dry(&mut page, told);
    laws::series(&mut page, told);
    laws::scaling(&mut page, told);
    laws::film(&mut page, told);
    laws::energy(&mut page, told);
    errors::errors(&mut page, told);
    noise::noise(&mut page, told);
    constants::constants(&mut page, told);
    bootstrap::bootstrap(&mut page, told);
    posterior::posterior(&mut page, told);
    cautions::cautions(&mut page, told);
    cautions::reproduce(&mut page, told);
    let mut text = page.text.trim_end().to_owned();
    text.push('\n');
    text
}

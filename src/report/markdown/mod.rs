//! Writes the report as markdown: verdict and main numbers first, then what they rest on.

mod bootstrap;
mod cautions;
mod cells;
mod constants;
mod cross_check;
mod errors;
pub(crate) mod escape;
mod laws;
mod main_numbers;
mod noise;
pub(crate) mod page;
mod posterior;
mod runs;
pub(crate) mod table;
mod terminal;
mod terms;
mod verdict;

pub(super) use cautions::CAUTIONS;
pub use runs::overview_text;
pub use terminal::summary;

use super::input::ReportInput;
use escape::literal;
use page::Page;

/// The whole report; `figures` are the names of those that were drawn.
pub fn report(input: ReportInput, figures: &[&str]) -> String {
    let mut page = Page::titled(&literal(&input.scene.title), figures);
    verdict::opening(&mut page, input);
    main_numbers::main_numbers(&mut page, input);
    laws::first_figures(&mut page, input);
    verdict::learnt(&mut page, input);
    cautions::cautions(&mut page, input);
    cautions::reproduce(&mut page, input);
    page.appendix();
    page.paragraph("What the numbers above rest on, and the numbers of every setting.");
    main_numbers::other_film_ratios(&mut page, input);
    main_numbers::published(&mut page, input);
    runs::data(&mut page, input);
    runs::groups(&mut page, input);
    terms::terms(&mut page, input);
    laws::dry(&mut page, input);
    laws::series(&mut page, input);
    laws::scaling(&mut page, input);
    laws::film(&mut page, input);
    laws::energy(&mut page, input);
    cross_check::cross_check(&mut page, input);
    bootstrap::bootstrap(&mut page, input);
    errors::errors(&mut page, input);
    noise::noise(&mut page, input);
    constants::constants(&mut page, input);
    posterior::posterior(&mut page, input);
    cautions::checks(&mut page, input);
    cautions::also_noted(&mut page, input);
    let mut text = page.text.trim_end().to_owned();
    text.push('\n');
    text
}

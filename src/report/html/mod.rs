//! Writes the report as one page for a browser: the same Markdown, its figures inside, and a picker of pairs.
//!
//! The page loads nothing: style, script, figures and curves stand in it, and its policy forbids the rest.
//!
//! | file | job |
//! |---|---|
//! | `curves.rs` | gathers the restitution of every pair against the impact speed |
//! | `picker.rs` | writes the part in which a reader picks a pair |
//! | `picker.js` | draws the picked pair |
//! | `scripts.rs` | sets symbols with what stands below and above the line |
//! | `style.css` | how it looks: on a screen by day and night, on a telephone, on paper |

mod curves;
mod picker;
mod scripts;

use std::collections::HashMap;

use pulldown_cmark::{html, CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, TextMergeStream};

use super::escape;
use super::figures::Figure;
use super::markup::escaped;
use crate::error::Error;
pub(super) use curves::Curves;
use scripts::pieces;

/// What a page may load: nothing but what stands in it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// The report as a page: its Markdown, the figures it shows, and the curves a reader may pick from.
pub(super) fn page(markdown: &str, figures: &[Figure], curves: &Curves) -> Result<String, Error> {
    let picker = picker::section(curves)?;
    let parser = Parser::new_ext(markdown, Options::ENABLE_TABLES);
    let events: Vec<Event> = TextMergeStream::new(parser).collect();
    let headings = headings(&events);
    let figures = figures
        .iter()
        .map(|figure| (format!("figures/{}", escape::destination(&figure.name)), figure))
        .collect();
    let mut body = String::with_capacity(4 * markdown.len());
    html::push_html(&mut body, shown(events, &headings, &figures, &picker).into_iter());
    let title = headings
        .first()
        .map_or_else(String::new, |heading| escaped(&heading.text));
    let style = include_str!("style.css");
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n"
    ))
}

/// A heading of the text.
struct Heading {
    level: HeadingLevel,
    text: String,
    /// by which a link finds it
    id: String,
}

fn headings(events: &[Event]) -> Vec<Heading> {
    let mut headings: Vec<Heading> = vec![];
    let mut open = None;
    for event in events {
        match event {
            Event::Start(Tag::Heading { level, .. }) => open = Some((*level, String::new())),
            Event::Text(text) | Event::Code(text) => {
                if let Some((_, so_far)) = &mut open {
                    so_far.push_str(text);
                }
            }
            Event::End(TagEnd::Heading(_)) => {
                if let Some((level, text)) = open.take() {
                    // numbered, since names of users may be alike once they are written as an address
                    let id = format!("{}-{}", headings.len(), address(&text));
                    headings.push(Heading { level, text, id });
                }
            }
            _ => {}
        }
    }
    headings
}

/// The words of a heading as an address has them.
fn address(text: &str) -> String {
    let letters = text.chars().map(|c| match c {
        c if c.is_ascii_alphanumeric() => c.to_ascii_lowercase(),
        _ => '-',
    });
    letters.collect()
}

/// The events of the text as the page shows them: figures inside, tables that scroll in themselves, headings that links
/// find, the contents below the title, the picker before the cautions, and no HTML but ours.
fn shown<'a>(
    events: Vec<Event<'a>>,
    headings: &[Heading],
    figures: &HashMap<String, &Figure>,
    picker: &'a str,
) -> Vec<Event<'a>> {
    let mut shown = Vec::with_capacity(events.len());
    let mut next_heading = headings.iter();
    // the words that stand for a figure, while they are read
    let mut picture: Option<(CowStr, String)> = None;
    for event in events {
        match (event, &mut picture) {
            (Event::Start(Tag::Image { dest_url, .. }), _) => picture = Some((dest_url, String::new())),
            (Event::End(TagEnd::Image), _) => {
                if let Some((address, words)) = picture.take() {
                    shown.push(raw(figure(figures.get(address.as_ref()).copied(), &words)));
                }
            }
            (Event::Text(text) | Event::Code(text), Some((_, words))) => words.push_str(&text),
            (_, Some(_)) => {}
            (mut event @ Event::Start(Tag::Heading { .. }), None) => {
                let heading = next_heading.next();
                if heading.is_some_and(|heading| heading.text == "Cautions") {
                    shown.push(raw(picker));
                }
                if let Event::Start(Tag::Heading { id, .. }) = &mut event {
                    *id = heading.map(|heading| heading.id.clone().into());
                }
                shown.push(event);
            }
            (Event::End(TagEnd::Heading(level)), None) => {
                shown.push(Event::End(TagEnd::Heading(level)));
                if level == HeadingLevel::H1 {
                    shown.push(raw(contents(headings)));
                }
            }
            (Event::Start(Tag::Table(alignments)), None) => {
                shown.push(raw(
                    "<div class=\"wide\" role=\"region\" aria-label=\"table\" tabindex=\"0\">",
                ));
                shown.push(Event::Start(Tag::Table(alignments)));
            }
            (Event::End(TagEnd::Table), None) => {
                shown.push(Event::End(TagEnd::Table));
                shown.push(raw("</div>\n"));
            }
            (Event::End(TagEnd::TableCell), None) => {
                wrap_sentence(&mut shown);
                shown.push(Event::End(TagEnd::TableCell));
            }
            (Event::Html(text) | Event::InlineHtml(text), None) => shown.push(Event::Text(text)),
            (Event::Text(text), None) => {
                let pieces = pieces(&text).into_iter();
                shown.extend(pieces.flat_map(|(plain, set)| [Event::Text(plain.to_owned().into()), raw(set)]));
            }
            (event, None) => shown.push(event),
        }
    }
    shown
}

/// Lets the cell that has been shown last break its lines, where it holds a sentence: numbers stay on one.
fn wrap_sentence(shown: &mut Vec<Event>) {
    /// letters from which on a cell is a sentence
    const LONG: usize = 40;
    let is_start = |event: &Event| matches!(event, Event::Start(Tag::TableCell));
    let Some(start) = shown.iter().rposition(is_start) else {
        return;
    };
    let letters = shown[start..].iter().map(|event| match event {
        Event::Text(text) | Event::Code(text) => text.chars().count(),
        _ => 0,
    });
    if letters.sum::<usize>() > LONG {
        shown.insert(start + 1, raw("<div class=\"sentence\">"));
        shown.push(raw("</div>"));
    }
}

fn raw<'a>(text: impl Into<CowStr<'a>>) -> Event<'a> {
    Event::Html(text.into())
}

/// A figure where it stands in the text, or its words where it was not drawn.
fn figure(figure: Option<&Figure>, words: &str) -> String {
    let words = escaped(words);
    match figure {
        Some(figure) => format!(
            "<span class=\"figure\" role=\"img\" aria-label=\"{words}\">{}</span>",
            figure.svg.trim_end()
        ),
        None => words,
    }
}

/// Links to the sections below the title.
fn contents(headings: &[Heading]) -> String {
    let links = headings
        .iter()
        .filter(|heading| matches!(heading.level, HeadingLevel::H2 | HeadingLevel::H3))
        .map(|heading| {
            let class = if heading.level == HeadingLevel::H2 {
                ""
            } else {
                " class=\"below\""
            };
            format!(
                "<li{class}><a href=\"#{}\">{}</a></li>\n",
                heading.id,
                escaped(&heading.text)
            )
        });
    let links: String = links.collect();
    format!("<nav><details><summary>Contents</summary>\n<ul>\n{links}</ul>\n</details></nav>\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page_of(markdown: &str, figures: &[Figure]) -> String {
        page(markdown, figures, &Curves::default()).expect("a page")
    }

    #[test]
    fn a_figure_stands_inside_by_its_address_and_its_words_where_it_was_not_drawn() {
        let figures = [Figure {
            name: "µ of PE.svg".to_owned(),
            svg: "<svg id=\"own\"/>\n".to_owned(),
        }];
        let page = page_of(
            "![PE: e_n \"here\"](figures/%C2%B5%20of%20PE.svg)\n\n![gone](figures/no.svg)\n",
            &figures,
        );
        assert!(
            page.contains("aria-label=\"PE: e_n &quot;here&quot;\"><svg id=\"own\"/></span>"),
            "{page}"
        );
        assert!(page.contains("<p>gone</p>") && !page.contains("<img"), "{page}");
    }

    #[test]
    fn tables_scroll_in_themselves_and_headings_are_found_by_their_links() {
        let page = page_of("# T\n\n## Wet & dry\n\n| a |\n| --- |\n| 1 |\n\n### Wet & dry\n", &[]);
        assert_eq!(
            page.matches("<div class=\"wide\"").count(),
            page.matches("</table>").count()
        );
        for link in ["1-wet---dry", "2-wet---dry"] {
            assert_eq!(page.matches(&format!("href=\"#{link}\"")).count(), 1, "{page}");
            assert_eq!(page.matches(&format!(" id=\"{link}\"")).count(), 1, "{page}");
        }
        assert!(page.contains("Wet &amp; dry</a>"));
    }
}

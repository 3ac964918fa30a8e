//! Runs `wetcor man`: prints the manual page of the program or of one of its commands.

use clap::Command;
use clap_mangen::roff::{bold, roman, Roff};
use clap_mangen::Man;
use wetcor::error::Error;

use super::arguments;
use super::messages::print_result;

pub(super) fn man(command: Option<&str>) -> Result<u8, Error> {
    let mut program = arguments::definition();
    program.build();
    // only names of commands are read
    let described = command.and_then(|name| program.find_subcommand(name));
    let source = format!("{} {}", program.get_name(), program.get_version().unwrap_or_default());
    let page = page(described.unwrap_or(&program), source).map_err(|error| Error::Internal {
        doing: "write a manual page",
        reason: error.to_string(),
    })?;
    print_result(&page)?;
    Ok(0)
}

fn page(described: &Command, source: String) -> std::io::Result<String> {
    let mut page = vec![];
    // what stands after the help has sections of its own here
    let without_notes = described.clone().after_help(None);
    let in_our_words = without_notes
        .subcommand_value_name("command")
        .subcommand_help_heading("COMMANDS");
    Man::new(in_our_words).source(source).render(&mut page)?;
    let notes = described.get_after_help().map(ToString::to_string).unwrap_or_default();
    sections(&notes).to_writer(&mut page)?;
    Ok(ascii(&String::from_utf8_lossy(&page)))
}

/// The paragraphs after a help: examples line by line, the exit status, and the rest as notes.
fn sections(text: &str) -> Roff {
    let mut roff = Roff::new();
    let mut has_notes = false;
    for paragraph in text.split("\n\n").filter(|paragraph| !paragraph.is_empty()) {
        match paragraph.split_once(':') {
            Some(("Example" | "Examples", lines)) => {
                // to be copied: a long line is broken between words, neither spread nor hyphenated
                roff.control("SH", ["EXAMPLES"]).control("ad", ["l"]).control("nh", []);
                for line in lines.lines().filter(|line| !line.is_empty()) {
                    roff.text([bold(line.trim_start())]).control("br", []);
                }
                roff.control("ad", ["b"]).control("hy", []);
            }
            Some(("Exit status", each)) => {
                roff.control("SH", ["EXIT STATUS"]).text([roman(each.trim_start())]);
            }
            _ => {
                let heading = if has_notes {
                    ("PP", vec![])
                } else {
                    ("SH", vec!["NOTES"])
                };
                roff.control(heading.0, heading.1).text([roman(paragraph)]);
                has_notes = true;
            }
        }
    }
    roff
}

/// The same page in ASCII, which every reader of manual pages shows alike.
fn ascii(page: &str) -> String {
    let mut plain = String::with_capacity(page.len());
    for c in page.chars() {
        if c.is_ascii() {
            plain.push(c);
        } else {
            plain.push_str(&format!("\\[u{:04X}]", u32::from(c)));
        }
    }
    plain
}

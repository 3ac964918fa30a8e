//! Tells every key of a scene and every column of a table of runs: as a page in Markdown, and as plain text for a terminal.

use std::path::Path;

use super::choices::{bootstrap, guide_to_priors, model, parameters, sampler};
use super::data::data;
use super::keys::{title, KeyGuide, Section, Without};
use super::materials::{liquid, particle};
use super::naming::SceneNames;
use super::plan::{design, truth};
use super::published::published;
use super::read::of_report;
use super::run_columns::{RunColumn, HEAD};
use super::table::{read_nothing, section};

/// Every table of a scene with its keys, in the order a scene has them.
pub fn guide() -> Vec<Section> {
    let names = SceneNames::default();
    let (usual, _) = read_nothing(|table| model(table, &[], &[]));
    let mut of_truth = section("[truth]", |table| truth(table, &[], (&[], &[]), &usual));
    for key in of_truth.keys.iter_mut().filter(|key| key.meaning.is_empty()) {
        if let Some(own) = parameters().find(|own| own.name == key.base) {
            (key.meaning, key.example) = (own.meaning, own.example.to_owned());
        }
    }
    vec![
        section("", of_report),
        section("[data]", |table| data(table, Path::new(""), &names)),
        section("[particles.NAME]", |table| particle(String::new(), table)),
        section("[liquids.NAME]", |table| liquid(String::new(), table)),
        section("[model]", |table| model(table, &[], &[])),
        guide_to_priors(),
        section("[sampler]", sampler),
        section("[bootstrap]", bootstrap),
        section("[[published]]", |table| published(table, &[])),
        of_truth,
        section("[design]", |table| design(table, &names)),
    ]
}

/// The columns of a table of runs.
fn columns() -> Section {
    Section::new(HEAD, RunColumn::ALL.map(RunColumn::guide).to_vec())
}

/// What holds of every key.
const RULES: &str =
    "A unit is a part of a name, and any one of those told may be used. What has a default may be left \
                     out. An unknown key is an error that names the nearest known one.";

/// A page of all keys.
pub fn markdown() -> String {
    let mut page = format!("# The keys of a scene, and the columns of its runs\n\n{RULES}\n");
    for section in guide().into_iter().chain([columns()]) {
        let mark = if section.head.starts_with('[') { "`" } else { "" };
        let head = title(section.head);
        page.push_str(&format!("\n## {mark}{head}{mark}\n\n{}.\n\n", section.about));
        page.push_str("| name | what it is | takes | without it | example |\n|---|---|---|---|---|\n");
        for key in &section.keys {
            let mut names = format!("`{}`", key.usual_name());
            for suffix in other_suffixes(key) {
                names.push_str(&format!(", `{suffix}`"));
            }
            let without = match &key.without {
                Without::Refused => "**required**".to_owned(),
                Without::Value(value) => format!("`{value}`"),
                Without::Words(words) => (*words).to_owned(),
            };
            let (meaning, takes, example) = (key.meaning, &key.takes, &key.example);
            page.push_str(&format!(
                "| {names} | {meaning} | {takes} | {without} | `{example}` |\n"
            ));
        }
    }
    page
}

/// All keys for a terminal.
pub fn plain() -> String {
    let mut text = format!("{}\n", wrapped(RULES, ""));
    for section in guide().into_iter().chain([columns()]) {
        let head = title(section.head);
        let about = wrapped(&format!("{}.", section.about), "  ");
        text.push_str(&format!("\n{head}\n{about}\n"));
        for key in &section.keys {
            let suffixes: Vec<&str> = other_suffixes(key).collect();
            let units = if suffixes.is_empty() {
                String::new()
            } else {
                format!("; or {}", suffixes.join(", "))
            };
            let without = match &key.without {
                Without::Refused => "required".to_owned(),
                Without::Value(value) => format!("default {value}"),
                Without::Words(words) => format!("without it: {words}"),
            };
            text.push_str(&format!("\n  {} = {}\n", key.usual_name(), key.example));
            for line in [key.meaning.to_owned(), format!("{}; {without}{units}", key.takes)] {
                text.push_str(&format!("{}\n", wrapped(&line, "      ")));
            }
        }
    }
    text
}

/// What a name ends with in each unit but the usual one.
fn other_suffixes(key: &KeyGuide) -> impl Iterator<Item = &'static str> {
    key.dimension.units().iter().skip(1).map(|unit| unit.suffix)
}

/// A text in lines of at most 100 letters, where no word is longer, each after some blanks.
pub(crate) fn wrapped(text: &str, indent: &str) -> String {
    let options = textwrap::Options::new(100)
        .initial_indent(indent)
        .subsequent_indent(indent)
        .break_words(false)
        .word_splitter(textwrap::WordSplitter::NoHyphenation);
    textwrap::fill(text, options)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::keys::KEYS;

    /// A scene with every key, as the guide has its example, and with a particle and a liquid of the names in these.
    fn scene_of_examples() -> String {
        let mut text = String::new();
        for section in guide() {
            let head = section.head.replace(
                "[particles.NAME]",
                "[particles.PE]\ndensity_kg_m3 = 940\nroughness_um = 5\n[particles.PTFE]",
            );
            text.push_str(&format!("{}\n", head.replace("NAME", "AK10")));
            for key in &section.keys {
                // either of them, not both
                let other = section.head == "[design]" && key.base == "height";
                if !other {
                    text.push_str(&format!("{} = {}\n", key.usual_name(), key.example));
                }
            }
        }
        text
    }

    fn parsed(text: &str) -> Result<crate::scene::Scene, String> {
        crate::scene::parse(text, Path::new("scene.toml"), String::new()).map_err(|error| error.to_string())
    }

    /// Each line of `keys.txt` is of a key that is read, and each key is told of; priors and what they are of have their words
    /// from the model.
    #[test]
    fn every_key_is_told_of_in_its_line() {
        let sections: Vec<Section> = guide().into_iter().chain([columns()]).collect();
        let of_file = sections.iter().filter(|section| section.head != "[priors]");
        let keys: usize = of_file.map(|section| section.keys.len()).sum();
        assert_eq!(KEYS.lines().filter(|line| line.contains(" | ")).count(), keys);
        for key in sections.iter().flat_map(|section| &section.keys) {
            let is_told = !key.meaning.is_empty() && !key.example.is_empty() && key.without != Without::Words("");
            assert!(is_told, "{}", key.base);
        }
    }

    #[test]
    fn the_examples_of_all_keys_are_a_scene() {
        let scene = parsed(&scene_of_examples()).expect("the examples are a scene");
        assert_eq!(scene.particles.len(), 2);
    }

    #[test]
    fn a_default_is_what_holds_without_its_key() {
        let short = "[data]\nruns = \"runs.csv\"\n[particles.PE]\ndensity_kg_m3 = 940\nroughness_um = 5\n";
        let mut long = String::new();
        for section in guide() {
            let needs_more =
                section.head.starts_with("[[") || ["[truth]", "[design]", "[priors]"].contains(&section.head);
            if needs_more || section.head.contains("NAME") {
                continue;
            }
            long.push_str(&format!("{}\n", section.head));
            for key in &section.keys {
                match &key.without {
                    Without::Refused => long.push_str(&format!("{} = {}\n", key.usual_name(), key.example)),
                    Without::Value(value) => long.push_str(&format!("{} = {value}\n", key.usual_name())),
                    Without::Words(_) => {}
                }
            }
        }
        long.push_str("[particles.PE]\ndensity_kg_m3 = 940\nroughness_um = 5\n");
        let [mut short, mut long] = [short, &long].map(|text| parsed(text).expect("a scene"));
        // what is known of a key beside its value: whether anything reads it, and whether it is there
        for scene in [&mut short, &mut long] {
            scene.unused.clear();
            scene.data.naming.heights_of_is_told = false;
        }
        assert_eq!(short, long);
    }
}

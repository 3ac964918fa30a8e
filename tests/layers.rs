//! Holds the order of the modules: no file names a module that stands below its own in the table of the crate, and in the
//! folders that have such a table no file names one below it.
//!
//! A path is followed as far as it names files; where an item is handed on from, and methods, are not seen. Tests inside
//! `src/` are left out.

use std::collections::BTreeMap;
use std::path::Path;

/// The modules of the program, which stand after those of the library.
const PROGRAM: [&str; 2] = ["progress", "cli"];

/// The folders whose table lists their files in order, before the `mod.rs` it stands in.
const ORDERED: [&str; 3] = ["findings", "runs", "scene"];

/// The text of each file by its module, `findings::dry`; that of `lib.rs` has none.
type Sources = BTreeMap<String, String>;

/// Every source by its module; the two roots hold no code to order, `lib.rs` is kept for its table.
fn sources() -> Sources {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut found, mut folders) = (Sources::new(), vec![root.clone()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("the folder is there") {
            let path = entry.expect("an entry").path();
            let name = path.strip_prefix(&root).expect("below src").with_extension("");
            let mut parts: Vec<&str> = name.iter().map(|part| part.to_str().expect("plain names")).collect();
            if parts.contains(&"tests") || parts == ["main"] {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                if parts == ["lib"] || parts.last() == Some(&"mod") {
                    parts.pop();
                }
                found.insert(parts.join("::"), std::fs::read_to_string(&path).expect("readable"));
            }
        }
    }
    found
}

/// The code of a file: without comments, and without its tests, which stand at the end.
fn code(text: &str) -> String {
    let code = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or(text);
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<&str>>().join("\n")
}

/// What stands in the braces that a text begins with, cut at the commas between its own items; else the text itself.
fn items(text: &str) -> Vec<&str> {
    let Some(inside) = text.strip_prefix('{') else {
        return vec![text];
    };
    let (mut depth, mut start, mut found) = (0, 0, vec![]);
    for (at, c) in inside.char_indices() {
        match c {
            '{' => depth += 1,
            ',' | '}' if depth == 0 => {
                found.push(inside[start..at].trim_start());
                start = at + 1;
                if c == '}' {
                    break;
                }
            }
            '}' => depth -= 1,
            _ => {}
        }
    }
    found
}

/// The files that a path leads to, seen from a module: the last of each of its branches.
fn add_named(sources: &Sources, module: &str, path: &str, found: &mut Vec<String>) {
    for item in items(path) {
        let end = item
            .find(|c: char| !c.is_alphanumeric() && c != '_')
            .unwrap_or(item.len());
        let next = match &item[..end] {
            "crate" => String::new(),
            "super" => module.rsplit_once("::").map_or("", |(parent, _)| parent).to_owned(),
            name => format!("{module}::{name}").trim_start_matches("::").to_owned(),
        };
        if !sources.contains_key(&next) {
            found.push(module.to_owned());
        } else if let Some(rest) = item[end..].strip_prefix("::") {
            add_named(sources, &next, rest, found);
        } else {
            found.push(next);
        }
    }
}

/// The files that the code of a file names by a path from the crate or from its folder.
fn named(sources: &Sources, module: &str) -> Vec<String> {
    let code = code(&sources[module]);
    let mut found = vec![];
    for word in ["crate::", "super::"] {
        for (at, _) in code.match_indices(word) {
            let is_inside = code[..at].ends_with(|c: char| c.is_alphanumeric() || ":_".contains(c));
            // what stands in the brackets of `pub(in crate::…)` names no item
            if !is_inside && !code[..at].ends_with("pub(in ") {
                add_named(sources, module, &code[at..], &mut found);
            }
        }
    }
    found
}

/// What a table of modules names in its first column, in order.
fn table(text: &str) -> Vec<String> {
    let rows = text.lines().filter_map(|line| line.strip_prefix("//! | "));
    let first = rows.filter_map(|row| row.split(" | ").next());
    let names = first.flat_map(|column| column.split('`').skip(1).step_by(2));
    let plain = |name: &str| name.trim_end_matches(".rs").trim_end_matches('/').to_owned();
    names.map(plain).collect()
}

/// The entry of a folder in which a file stands; `None` outside the folder and for its own file.
fn entry<'a>(folder: &str, file: &'a str) -> Option<&'a str> {
    let inside = match folder {
        "" => file,
        _ => file.strip_prefix(folder)?.strip_prefix("::")?,
    };
    inside.split("::").next().filter(|entry| !entry.is_empty())
}

/// What stands against the order of a folder's entries.
fn out_of_order(sources: &Sources, folder: &str, order: &[String]) -> Vec<String> {
    let place = |file: &str| entry(folder, file).map(|entry| order.iter().position(|name| name == entry));
    let mut faults = vec![];
    for file in sources.keys() {
        let Some(own) = place(file) else { continue };
        let Some(own) = own else {
            faults.push(format!("{file} is missing from the table"));
            continue;
        };
        let is_later = |other: &String| place(other).flatten().is_some_and(|place| place > own);
        let upwards = named(sources, file).into_iter().filter(is_later);
        faults.extend(upwards.map(|other| format!("{file} imports upwards from {other}")));
    }
    faults
}

/// Everything that stands against the order.
fn faults(sources: &Sources) -> Vec<String> {
    let modules = [table(&sources[""]), PROGRAM.map(str::to_owned).to_vec()].concat();
    let mut faults = out_of_order(sources, "", &modules);
    for folder in ORDERED {
        faults.extend(out_of_order(sources, folder, &table(&sources[folder])));
    }
    faults
}

#[test]
fn no_file_names_what_stands_below_it() {
    let sources = sources();
    assert_eq!(faults(&sources), Vec::<String>::new());
    // the planted faults: the file, what is planted in it, and what is then found
    for [module, code, found] in [
        [
            "scene::prior",
            "use crate::findings::{Counts, dry::{self, Dry}};",
            "prior imports upwards from findings::dry",
        ],
        [
            "units",
            "fn x() -> f64 { crate::physics::viscous::st_c(1.0, 1.0) }",
            "units imports upwards from physics::viscous",
        ],
        [
            "findings::fit_verdict",
            "fn x(series: &super::series::SeriesFit) {}",
            "upwards from findings::series",
        ],
        [
            "findings::dry",
            "// crate::report::json\npub(in crate::report) fn x() {}\n",
            "",
        ],
    ] {
        let mut planted = sources.clone();
        planted.get_mut(module).expect("it is there").insert_str(0, code);
        let faults = faults(&planted);
        assert!(
            found.is_empty() || faults.iter().any(|fault| fault.ends_with(found)),
            "{code}: {faults:?}"
        );
        assert!(!found.is_empty() || faults.is_empty(), "{code}: {faults:?}");
    }
    let mut planted = sources;
    planted.insert("planted".to_owned(), String::new());
    assert_eq!(faults(&planted), ["planted is missing from the table"]);
}

//! Holds the order of the modules: no import upwards, and no circle of files.
//!
//! An import goes from the file that names a path to the file that defines the item: a re-export is followed to its
//! source, and neither it nor a `mod` line is an import by itself. Tests inside `src/` are left out. Not seen is a method
//! that stands in another file than its type.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::Path;

/// Imports that still close a circle. Each must close one, so that this list shrinks to nothing and is deleted.
const STILL_KNOTTED: [(&str, &str); 21] = [
    ("findings::constants::caution", "findings::constants"),
    ("findings::identify::instead", "findings::identify"),
    ("findings::identify::sight", "findings::identify::words"),
    ("findings::noise::offsets", "findings::noise"),
    ("findings::noise::spread", "findings::noise"),
    ("findings::terms::size", "findings::terms"),
    ("inference::bootstrap::lines", "inference::bootstrap"),
    ("inference::bootstrap::nodes", "inference::bootstrap"),
    ("inference::bootstrap::schemes", "inference::bootstrap"),
    ("inference::least_squares::covariance", "inference::least_squares"),
    ("inference::least_squares::solver", "inference::least_squares"),
    ("inference::least_squares::walk", "inference::least_squares"),
    ("report::chart::grid", "report::chart"),
    ("report::chart::legend", "report::chart"),
    ("report::chart::mark", "report::chart"),
    ("report::chart::panel", "report::chart"),
    ("report::figures::joint", "report::figures"),
    ("report::figures::posterior", "report::figures"),
    ("report::figures::posterior::pairs", "report::figures::posterior"),
    ("report::figures::posterior::priors", "report::figures::posterior"),
    ("report::figures::posterior::ranks", "report::figures::posterior"),
];

/// The modules of the program, which stand after those of the library.
const PROGRAM: [&str; 2] = ["progress", "cli"];

/// The folders whose table lists their files in order, before the `mod.rs` it stands in.
const ORDERED: [&str; 4] = ["findings", "runs", "scene", "study::trade"];

/// The text of each file by its module, `findings::dry`; that of `lib.rs` has none.
type Sources = BTreeMap<String, String>;

/// The files that each file imports from.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// What one file holds that matters here.
#[derive(Default)]
struct File {
    /// items defined at its top level
    defined: BTreeSet<String>,
    /// names that `use` binds, with their paths
    bound: BTreeMap<String, Vec<String>>,
    /// paths that it imports or that its code names
    named: Vec<Vec<String>>,
}

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
                continue;
            }
            if parts == ["lib"] || parts.last() == Some(&"mod") {
                parts.pop();
            }
            found.insert(parts.join("::"), std::fs::read_to_string(&path).expect("readable"));
        }
    }
    found
}

/// Identifiers, `::` and other signs; comments, strings, characters and lifetimes are left out.
fn tokens(text: &str) -> Vec<&str> {
    let mut found = vec![];
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let raw = rest.strip_prefix('r').map(|after| after.trim_start_matches('#'));
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if raw.is_some_and(|after| after.starts_with('"')) {
            let hashes = "#".repeat(rest.len() - 1 - raw.map_or(0, str::len));
            let start = hashes.len() + 2;
            start + rest[start..].find(&format!("\"{hashes}")).expect("a raw string ends") + hashes.len() + 1
        } else if first == '"' || is_character(rest) {
            let mut escaped = false;
            let ends = |(_, c): &(usize, char)| {
                let end = *c == first && !escaped;
                escaped = *c == '\\' && !escaped;
                end
            };
            rest.char_indices().skip(1).find(ends).expect("a string ends").0 + 1
        } else if is_word(first) {
            let length = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
            found.push(&rest[..length]);
            length
        } else {
            let length = if rest.starts_with("::") { 2 } else { first.len_utf8() };
            if !first.is_whitespace() {
                found.push(&rest[..length]);
            }
            length
        };
        rest = &rest[length..];
    }
    found
}

/// Whether a character literal begins here, and no lifetime.
fn is_character(text: &str) -> bool {
    let mut chars = text.chars();
    chars.next() == Some('\'') && (chars.next() == Some('\\') || chars.next() == Some('\''))
}

/// Adds the paths of a `use` tree, each with the name it binds, and gives the place after it.
fn add_tree(tokens: &[&str], mut at: usize, mut path: Vec<String>, found: &mut Vec<(String, Vec<String>)>) -> usize {
    loop {
        match tokens[at] {
            "{" => {
                while tokens[at] != "}" {
                    at += 1; // the brace or a comma
                    if tokens[at] != "}" {
                        at = add_tree(tokens, at, path.clone(), found);
                    }
                }
                return at + 1;
            }
            "as" => {
                found.push((tokens[at + 1].to_owned(), path));
                return at + 2;
            }
            "," | "}" | ";" => {
                found.push((path.last().expect("a path has a name").clone(), path));
                return at;
            }
            "::" => {}
            "self" if !path.is_empty() => {}
            word => path.push(word.to_owned()),
        }
        at += 1;
    }
}

fn read(text: &str) -> File {
    // tests stand at the end
    let tokens = tokens(text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or(text));
    let mut file = File::default();
    let (mut words, mut handed_on) = (BTreeSet::new(), vec![]);
    let (mut at, mut depth, mut public) = (0, 0, false);
    while at < tokens.len() {
        let was_public = std::mem::take(&mut public);
        match tokens[at] {
            "{" => depth += 1,
            "}" => depth -= 1,
            "pub" => {
                public = true;
                if tokens[at + 1] == "(" {
                    // what stands in brackets names no item
                    at = (at..).find(|at| tokens[*at] == ")").expect("it is closed");
                }
            }
            // not the `use<…>` of a type
            "use" if tokens[at + 1] != "<" => {
                let mut found = vec![];
                at = add_tree(&tokens, at + 1, vec![], &mut found);
                if was_public {
                    handed_on.extend(found.clone());
                } else {
                    file.named.extend(found.iter().map(|(_, path)| path.clone()));
                }
                file.bound.extend(found);
            }
            "fn" | "struct" | "enum" | "trait" | "type" | "const" | "static" if depth == 0 => {
                file.defined.insert(tokens[at + 1].to_owned());
            }
            word => {
                let mut path = vec![word.to_owned()];
                while tokens.get(at + 1) == Some(&"::") && tokens[at + 2] != "<" {
                    path.push(tokens[at + 2].to_owned());
                    at += 2;
                }
                words.insert(word);
                file.named.extend((path.len() > 1).then_some(path));
            }
        }
        at += 1;
    }
    // what is handed on is no import, unless the code uses it, too
    handed_on.retain(|(name, _)| words.contains(name.as_str()));
    file.named.extend(handed_on.into_iter().map(|(_, path)| path));
    file
}

/// The file that defines what a path names, seen from a module; `None` for a module itself and what is not ours.
fn definer(files: &BTreeMap<String, File>, module: &str, path: &[String]) -> Option<String> {
    let parent = |module: &str| module.rsplit_once("::").map_or("", |(parent, _)| parent).to_owned();
    let mut at = module.to_owned();
    for (place, name) in path.iter().enumerate() {
        let child = format!("{at}::{name}").trim_start_matches("::").to_owned();
        match name.as_str() {
            "crate" | "wetcor" => at = String::new(),
            "self" => {}
            "super" => at = parent(&at),
            _ if files.contains_key(&child) => at = child,
            _ => {
                let file = files.get(&at)?;
                if file.defined.contains(name) {
                    return Some(at);
                }
                let bound = file.bound.get(name).filter(|bound| *bound != path)?;
                return definer(files, &at, &[bound, &path[place + 1..]].concat());
            }
        }
    }
    None
}

fn imports(sources: &Sources) -> Imports {
    let files: BTreeMap<String, File> = sources.iter().map(|(m, text)| (m.clone(), read(text))).collect();
    let of = |(module, file): (&String, &File)| {
        let from = file.named.iter().filter_map(|path| definer(&files, module, path));
        (module.clone(), from.filter(|other| other != module).collect())
    };
    files.iter().map(of).collect()
}

/// What a table of modules names in its first column, in order.
fn table(text: &str) -> Vec<String> {
    let rows = text.lines().filter_map(|line| line.strip_prefix("//! | "));
    let first = rows.filter_map(|row| row.split(" | ").next());
    let names = first.flat_map(|column| column.split('`').skip(1).step_by(2));
    let plain = |name: &str| name.trim_end_matches(".rs").trim_end_matches('/').to_owned();
    names.map(plain).collect()
}

/// What stands against the order of a folder's entries, whose own file stands after them.
fn out_of_order(imports: &Imports, folder: &str, order: &[String]) -> Vec<String> {
    let entry = |module: &str| {
        let inside = module.strip_prefix(folder)?;
        let inside = if folder.is_empty() {
            inside
        } else {
            inside.strip_prefix("::")?
        };
        Some(inside.split("::").next()?.to_owned()).filter(|entry| !entry.is_empty())
    };
    let rank = |entry: String| order.iter().position(|name| *name == entry);
    let mut faults = vec![];
    for (module, others) in imports {
        let Some(own) = entry(module) else { continue };
        let Some(place) = rank(own) else {
            faults.push(format!("{module} is missing from the table"));
            continue;
        };
        let is_later = |other: &&String| match entry(other) {
            Some(entry) => rank(entry).is_some_and(|rank| rank > place),
            None => *other == folder,
        };
        let upwards = others.iter().filter(is_later);
        faults.extend(upwards.map(|other| format!("{module} imports upwards from {other}")));
    }
    faults
}

/// The shortest chain of imports from a file to another, both named, of one import at least.
fn chain<'a>(imports: &'a Imports, from: &'a str, to: &str) -> Option<Vec<&'a str>> {
    let mut seen = BTreeSet::new();
    let mut chains = VecDeque::from([vec![from]]);
    while let Some(chain) = chains.pop_front() {
        for next in imports.get(chain[chain.len() - 1]).into_iter().flatten() {
            let longer = [chain.as_slice(), &[next.as_str()]].concat();
            if next == to {
                return Some(longer);
            }
            if seen.insert(next) {
                chains.push_back(longer);
            }
        }
    }
    None
}

/// Everything that stands against the order.
fn faults(sources: &Sources) -> Vec<String> {
    let mut imports = imports(sources);
    let mut faults = vec![];
    for (from, to) in STILL_KNOTTED {
        let is_import = imports.get(from).is_some_and(|others| others.contains(to));
        if !is_import || chain(&imports, to, from).is_none() {
            faults.push(format!(
                "{from} -> {to} closes no circle any more: strike it from the list"
            ));
        }
    }
    for (from, to) in STILL_KNOTTED {
        imports.get_mut(from).map(|others| others.remove(to));
    }
    let circles = imports.keys().filter_map(|file| chain(&imports, file, file));
    let shortest = circles.min_by_key(Vec::len);
    faults.extend(shortest.map(|circle| format!("a circle: {}", circle.join(" -> "))));
    let mut rooms = table(&sources[""]);
    rooms.extend(PROGRAM.map(str::to_owned));
    faults.extend(out_of_order(&imports, "", &rooms));
    for folder in ORDERED {
        faults.extend(out_of_order(&imports, folder, &table(&sources[folder])));
    }
    faults
}

#[test]
fn no_import_goes_upwards_and_no_files_stand_in_a_circle() {
    let faults = faults(&sources());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The faults after this code is put before that of a file.
fn with(module: &str, code: &str) -> Vec<String> {
    let mut sources = sources();
    sources.get_mut(module).expect("the file is there").insert_str(0, code);
    faults(&sources)
}

#[test]
fn a_planted_import_is_found() {
    let finds = |module: &str, code: &str, fault: &str| {
        let found = with(module, code);
        assert!(found.iter().any(|found| found == fault), "{module}: {found:?}");
    };
    let upwards = "scene::prior imports upwards from findings::dry";
    finds(
        "scene::prior",
        "use crate::findings::{Counts, dry::{self, Dry}};",
        upwards,
    );
    let upwards = "units imports upwards from physics::viscous";
    finds(
        "units",
        "fn planted() -> f64 { crate::physics::viscous::st_c(1.0, 1.0) }",
        upwards,
    );
    let upwards = "runs::part imports upwards from report::numbers";
    finds(
        "runs::part",
        "use crate::report::numbers as planted; const X: f64 = planted::short(1.0);",
        upwards,
    );
    let upwards = "findings::judge imports upwards from findings::series";
    finds(
        "findings::judge",
        "fn planted(series: &super::series::SeriesFit) {}",
        upwards,
    );
    let circle = "a circle: findings::dry -> findings::judge -> findings::dry";
    finds("findings::judge", "use super::{dry::Dry as Planted};", circle);
    let circle = "a circle: model::likelihood -> model::likelihood::law -> model::likelihood";
    finds("model::likelihood::law", "use super::OutsideDomain;", circle);
}

#[test]
fn what_is_no_import_is_not_taken_for_one() {
    for code in [
        "// use crate::findings::Findings;\n",
        "const PLANTED: &str = r#\"use crate::findings::Findings;\"#;",
        "const PLANTED: char = '\"'; // crate::findings::Findings\n",
        "\n#[cfg(test)]\nmod tests { use crate::findings::Findings; fn f() { \"}\"; } }",
        "pub(in crate::findings) fn planted() {}",
        "use std::collections::HashMap;",
    ] {
        assert_eq!(with("units", code), Vec::<String>::new(), "{code}");
    }
    // handed on, not used
    assert_eq!(with("scene", "pub use claim::claim as planted;"), Vec::<String>::new());
}

#[test]
fn a_module_missing_from_its_table_is_found() {
    let mut sources = sources();
    sources.insert("planted".to_owned(), String::new());
    assert_eq!(faults(&sources), ["planted is missing from the table"]);
}

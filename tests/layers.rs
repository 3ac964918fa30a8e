//! Holds the order of the modules: no import upwards, and no circle of files.
//!
//! An import goes from the file that names a path to the file that defines the item: a re-export is followed to its
//! source, and neither it nor a `mod` line is an import by itself. Tests inside `src/` are left out. Not seen is a method
//! that stands in another file than its type.

use crate::common::{contents, in_project, table_of};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;

/// The modules of the program, which stand after those of the library.
const PROGRAM: [&str; 2] = ["progress", "cli"];

/// The folders whose table lists their files in order, before the `mod.rs` it stands in.
const ORDERED: [&str; 3] = ["findings", "runs", "scene"];

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
    let module = |(path, bytes): (PathBuf, Vec<u8>)| {
        let name = path.with_extension("");
        let mut parts: Vec<&str> = name.iter().map(|part| part.to_str().expect("plain names")).collect();
        // a text that a module takes in is none
        let is_code = path.extension().is_some_and(|ending| ending == "rs");
        if !is_code || parts.contains(&"tests") || parts == ["main"] {
            return None;
        }
        if parts == ["lib"] || parts.last() == Some(&"mod") {
            parts.pop();
        }
        Some((parts.join("::"), String::from_utf8(bytes).expect("text")))
    };
    contents(&in_project("src")).into_iter().filter_map(module).collect()
}

/// Length of the comment, string or character that a text begins with.
fn skipped(text: &str) -> Option<usize> {
    if text.starts_with("//") {
        return text.find('\n').or(Some(text.len()));
    }
    let raw = text.strip_prefix('r').map(|after| after.trim_start_matches('#'));
    if let Some(raw) = raw.filter(|raw| raw.starts_with('"')) {
        let start = text.len() - raw.len();
        let end = format!("\"{}", "#".repeat(start - 1));
        return Some(start + 1 + raw[1..].find(&end)? + end.len());
    }
    let mut chars = text.char_indices();
    let (_, quote) = chars.next()?;
    // else a lifetime
    let is_character = || text[1..].starts_with('\\') || text.chars().nth(2) == Some('\'');
    if quote != '"' && (quote != '\'' || !is_character()) {
        return None;
    }
    while let Some((at, c)) = chars.next() {
        match c {
            '\\' => _ = chars.next(),
            _ if c == quote => return Some(at + 1),
            _ => {}
        }
    }
    None
}

/// Identifiers, `::` and other signs; comments, strings and characters are left out.
fn tokens(text: &str) -> Vec<&str> {
    let mut found = vec![];
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let skipped = skipped(rest).or(first.is_whitespace().then_some(first.len_utf8()));
        let is_sign = |c: char| !c.is_alphanumeric() && c != '_';
        let length = skipped.unwrap_or_else(|| match rest.find(is_sign) {
            Some(0) if rest.starts_with("::") => 2,
            Some(0) => first.len_utf8(),
            end => end.unwrap_or(rest.len()),
        });
        found.extend(skipped.is_none().then_some(&rest[..length]));
        rest = &rest[length..];
    }
    found
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
                // what is called as the crate it comes from is not ours
                let bound = file.bound.get(name).filter(|bound| bound[0] != *name)?;
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

/// The entry of a folder in which a file stands; `None` outside the folder and for its own file.
fn entry<'a>(folder: &str, file: &'a str) -> Option<&'a str> {
    let inside = match folder {
        "" => file,
        _ => file.strip_prefix(folder)?.strip_prefix("::")?,
    };
    inside.split("::").next().filter(|entry| !entry.is_empty())
}

/// What stands against the order of a folder's entries, whose own file stands after them.
fn out_of_order(imports: &Imports, folder: &str, order: &[String]) -> Vec<String> {
    let place = |entry: &str| order.iter().position(|name| name == entry);
    let mut faults = vec![];
    for (file, others) in imports {
        let Some(own) = entry(folder, file) else { continue };
        let Some(own) = place(own) else {
            faults.push(format!("{file} is missing from the table"));
            continue;
        };
        let is_later = |other: &&String| match entry(folder, other) {
            Some(entry) => place(entry).is_some_and(|place| place > own),
            None => *other == folder,
        };
        let upwards = others.iter().filter(is_later);
        faults.extend(upwards.map(|other| format!("{file} imports upwards from {other}")));
    }
    faults
}

/// The shortest chain of imports from a file back to itself.
fn circle<'a>(imports: &'a Imports, file: &'a str) -> Option<Vec<&'a str>> {
    let mut seen = BTreeSet::new();
    let mut chains = VecDeque::from([vec![file]]);
    while let Some(chain) = chains.pop_front() {
        for next in imports.get(chain[chain.len() - 1]).into_iter().flatten() {
            let longer = [chain.as_slice(), &[next.as_str()]].concat();
            if next == file {
                return Some(longer);
            }
            if seen.insert(next) {
                chains.push_back(longer);
            }
        }
    }
    None
}

/// Everything that stands against the order; of several circles the shortest.
fn faults(sources: &Sources) -> Vec<String> {
    let imports = imports(sources);
    let circles = imports.keys().filter_map(|file| circle(&imports, file));
    let shortest = circles.min_by_key(Vec::len);
    let mut faults = Vec::from_iter(shortest.map(|files| format!("a circle: {}", files.join(" -> "))));
    let modules = [table(&sources[""]), PROGRAM.map(str::to_owned).to_vec()].concat();
    faults.extend(out_of_order(&imports, "", &modules));
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
    // the file, what is planted in it, the end of the fault
    let planted = "\
        scene::prior | use crate::findings::{Counts, dry::{self, Dry}}; | prior imports upwards from findings::dry
        units | fn x() -> f64 { crate::physics::viscous::st_c(1.0, 1.0) } | units imports upwards from physics::viscous
        runs::part | use crate::report::json as x; fn y() { x::text(&1.0); } | upwards from report::json
        findings::fit_verdict | fn x(series: &super::series::SeriesFit) {} | fit_verdict imports upwards from findings::series
        findings::fit_verdict | use super::{dry::Dry as X}; | circle: findings::dry -> findings::fit_verdict -> findings::dry
        report::chart::layout | use super::svg; | circle: report::chart -> report::chart::layout -> report::chart";
    for [file, code, end] in table_of(planted) {
        let found = with(file, code);
        assert!(found.iter().any(|fault| fault.ends_with(end)), "{code}: {found:?}");
    }
    let mut sources = sources();
    sources.insert("planted".to_owned(), String::new());
    assert_eq!(faults(&sources), ["planted is missing from the table"]);
}

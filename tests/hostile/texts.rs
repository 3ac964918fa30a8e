//! Attacks with names and texts, with a standard output that refuses, and without threads.

use crate::common::{contents, Says};
use std::path::{Path, PathBuf};

#[cfg(target_os = "linux")]
use super::attack::finish;
use super::attack::{is_hostile, Outcome, Place};

/// Clears a terminal, ends a line, turns the direction, hides, and is markup wherever it goes.
const HOSTILE: &str =
    "\u{1b}[2J\u{1b}]0;x\u{7}\r\n\u{202e}<img src=x onerror=alert(1)> ![a](b) `c` **d** | \u{200b}\u{9b}0m\u{2028}&lt;";

/// The same for a string of a TOML file.
fn toml(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        if c.is_ascii_graphic() && !matches!(c, '"' | '\\') || c == ' ' {
            quoted.push(c);
        } else {
            quoted.push_str(&format!("\\U{:08X}", u32::from(c)));
        }
    }
    quoted + "\""
}

/// The plain example with a particle for each of these names, every one with the same runs, and little sampling.
fn with_particles(names: &[&str]) -> Place {
    let place = Place::plain();
    let runs = place.read("runs.csv");
    let mut lines = runs.lines();
    let mut table = lines.next().expect("a header").to_owned() + "\n";
    for line in lines {
        for name in names {
            table += &line.replacen("PTFE", name, 1);
            table.push('\n');
        }
    }
    place.write("runs.csv", table);
    let of = |name: &&str| format!("[particles.{}]\ndensity_kg_m3 = 2150\nroughness_um = 5\n", toml(name));
    let scene = place.read("scene.toml");
    let one = "[particles.PTFE]\ndensity_kg_m3 = 2150\nroughness_um = 5\n";
    assert!(scene.contains(one), "{scene}");
    let all: String = names.iter().map(of).collect();
    place.write("scene.toml", scene.replace(one, &all));
    place.add_to_scene("[sampler]\nchains = 2\nwarmup = 50\ndraws = 50\n[bootstrap]\nreplicates = 100");
    place
}

/// The plain example with a title and sources that nobody should write.
fn with_hostile_texts() -> Place {
    let place = Place::plain();
    let hostile = toml(HOSTILE);
    let scene = place.read("scene.toml");
    let rest = scene.split_once('\n').expect("a title").1;
    place.write("scene.toml", format!("title = {hostile}\nsource = {hostile}\n{rest}"));
    place.add_to_scene(&format!(
        "[[published]]\nquantity = \"dry_k\"\nparticle = \"PTFE\"\nvalue = 0.183\nse = 0.001\nsource = {hostile}"
    ));
    place.add_to_scene("[sampler]\nchains = 2\nwarmup = 50\ndraws = 50\n[bootstrap]\nreplicates = 100");
    let runs = place.read("runs.csv");
    let (header, rows) = runs.split_once('\n').expect("a header");
    let odd = HOSTILE.replace(['\r', '\n', ','], "").replace('"', "");
    let rows: String = rows.lines().map(|row| format!("{row},1\n")).collect();
    place.write("runs.csv", format!("{header},{odd}\n{rows}"));
    place
}

/// Every file below a folder, as a path from there.
fn files(folder: &Path) -> Vec<String> {
    let path = |path: PathBuf| path.to_str().expect("a plain path").to_owned();
    contents(folder).into_keys().map(path).collect()
}

fn assert_ran(outcome: &Outcome, of: &str) {
    outcome.assert_mannered(of);
    assert!(matches!(outcome.status, Some(0 | 1)), "{of}: {outcome:?}");
}

#[test]
fn d11_no_text_of_a_scene_or_a_table_moves_a_terminal() {
    let place = with_hostile_texts();
    for arguments in [
        &["check", "scene.toml"][..],
        &["check", "scene.toml", "--json"],
        &["fit", "scene.toml", "--out", "o", "--stages", "least_squares"],
    ] {
        let outcome = place.run(arguments, 20.0);
        assert_ran(&outcome, &arguments.join(" "));
    }
    // another title at the same place: that of the first is shown in the refusal
    let scene = place.read("scene.toml");
    let rest = scene.split_once('\n').expect("a title").1;
    place.write("scene.toml", format!("title = \"another\"\n{rest}"));
    let outcome = place.run(&["fit", "scene.toml", "--out", "o"], 20.0);
    outcome.assert_refused("the title of another report", &["\\u{1b}[2J", "\\u{202e}"]);
    // what is looked for is seen where it is
    let shown = Outcome {
        status: Some(0),
        out: "a\u{202e}b".to_owned(),
        err: String::new(),
        seconds: 0.0,
    };
    let seen = std::panic::catch_unwind(|| shown.assert_mannered("planted"));
    assert!(seen.is_err());
}

/// Every value and key of the scene, and every cell of the header and the first row, one at a time.
#[test]
fn d11_no_value_that_is_refused_moves_a_terminal() {
    let plain = Place::plain();
    let (scene, runs) = (plain.read("scene.toml"), plain.read("runs.csv"));
    let hostile = toml(HOSTILE);
    let mut mutants = vec![];
    for (index, line) in scene.lines().enumerate() {
        let with = |new: String| {
            let lines = scene.lines().enumerate();
            let all: Vec<&str> = lines
                .map(|(at, line)| if at == index { new.as_str() } else { line })
                .collect();
            (all.join("\n") + "\n", runs.clone())
        };
        if let Some((key, value)) = line.split_once(" = ") {
            mutants.push(with(format!("{key} = {hostile}")));
            mutants.push(with(format!("{hostile} = {value}")));
            // not as TOML has it
            mutants.push(with(format!("{key} = {HOSTILE}")));
        } else if let Some(name) = line.strip_prefix('[') {
            mutants.push(with(format!("[{}.{hostile}]", name.trim_end_matches(']'))));
            mutants.push(with(format!("[{HOSTILE}]")));
        }
    }
    let cell = HOSTILE.replace(['\r', '\n'], "").replace('"', "");
    for row in 0..2 {
        for column in 0..7 {
            let line = runs.lines().nth(row).expect("a line");
            let mut cells: Vec<&str> = line.split(',').collect();
            cells[column] = &cell;
            mutants.push((scene.clone(), runs.replacen(line, &cells.join(","), 1)));
        }
    }
    assert!(mutants.len() > 35, "{}", mutants.len());
    let mut refused = 0;
    for (scene, runs) in mutants {
        plain.write("scene.toml", &scene);
        plain.write("runs.csv", &runs);
        let outcome = plain.run(&["check", "scene.toml"], 20.0);
        outcome.assert_mannered(&scene);
        refused += usize::from(outcome.status == Some(2));
    }
    assert!(refused > 30, "{refused}");
}

#[test]
fn d11_no_argument_moves_a_terminal_or_ends_a_line() {
    let place = Place::plain();
    let odd = HOSTILE;
    let folder = format!("{}.csv", HOSTILE.replace('/', ""));
    let with_dashes = format!("--{HOSTILE}");
    let asked = "--diameter-mm 4 --film-um 200 --speed-m-s 1:2:3".split(' ');
    let named = ["predict", ".", "--particle", odd, "--liquid", odd];
    let predict: Vec<&str> = named.into_iter().chain(asked).collect();
    for arguments in [
        &[odd][..],
        &["fit", odd],
        &["fit", "scene.toml", "--out", odd, "--stages", odd],
        &["fit", "scene.toml", odd],
        &["fit", &with_dashes],
        &["fit", "scene.toml", "--seed", odd],
        &["fit", "scene.toml", "--accuracy", odd],
        &["check", "scene.toml", "--threads", odd],
        &["simulate", "scene.toml", "--out", odd],
        &["simulate", "scene.toml", "--out", &folder],
        &["predict", odd, "--speed-m-s", odd],
        &predict,
        &["trade", odd],
    ] {
        let outcome = place.run(arguments, 20.0);
        outcome.assert_refused(&format!("{arguments:?}"), &[]);
        // wherever it is shown, it is on one line from its beginning
        for line in outcome.err.lines().filter(|line| line.contains("onerror")) {
            assert!(line.contains("\\u{1b}[2J"), "{}", outcome.err);
        }
    }
}

#[test]
fn d11_a_report_shows_titles_and_sources_as_they_are() {
    let place = with_hostile_texts();
    let outcome = place.run(&["fit", "scene.toml", "--out", "o"], 60.0);
    assert_ran(&outcome, "hostile texts");
    let page = place.read("o/report.md");
    let literal = "\\u{1b}\\[2J\\u{1b}\\]0;x\\u{7} \\u{202e}\\<img src=x onerror=alert(1)\\> !\\[a\\](b) \\`c\\` \\*\\*d\\*\\* | \
                   \\u{200b}\\u{9b}0m \\&lt;";
    assert_eq!(page.lines().next(), Some(format!("# {literal}").as_str()));
    assert!(page.contains(&format!("\n\nRuns: {literal}\n\n")), "source");
    page.says(&format!("\n\nPublished: {literal}.\n\n"));
    assert_eq!(bare(&page, "<img"), 0);
    assert!(page.chars().all(|c| c == '\n' || !is_hostile(c)));
    let for_browsers = place.read("o/report.html");
    let shown = "\\u{1b}[2J\\u{1b}]0;x\\u{7} \\u{202e}&lt;img src=x onerror=alert(1)&gt; ![a](b) `c` **d** | \
                 \\u{200b}\\u{9b}0m &amp;lt;";
    for_browsers.says(&format!("<title>{shown}</title>"));
    assert!(!for_browsers.contains("<img") && !for_browsers.contains("<strong>d"));
    // what is looked for is seen where it is
    assert_eq!(bare("a <img \\<img `<img` `` ` <img ``", "<img"), 1);
    for name in files(&place.path("o")) {
        let is_text = [".md", ".html", ".json", ".svg", ".csv"]
            .iter()
            .any(|end| name.ends_with(end));
        if is_text {
            let text = place.read(&format!("o/{name}"));
            let odd = text.chars().find(|c| *c != '\n' && is_hostile(*c));
            assert_eq!(odd, None, "{name}");
        }
    }
    let findings: serde_json::Value = serde_json::from_str(&place.read("o/findings.json")).expect("JSON");
    assert_eq!(findings["title"], HOSTILE, "the same text comes back");
}

/// How often a piece of markup stands on a page outside code and without an escape.
fn bare(page: &str, markup: &str) -> usize {
    let mut count = 0;
    for line in page.lines() {
        let mut rest = line;
        // code spans of one and of two marks, the longer first
        let mut outside = String::new();
        while let Some(at) = rest.find('`').filter(|at| !rest[..*at].ends_with('\\')) {
            let marks = if rest[at..].starts_with("``") { "``" } else { "`" };
            outside.push_str(&rest[..at]);
            let inside = &rest[at + marks.len()..];
            rest = inside.split_once(marks).map_or("", |(_, after)| after);
        }
        outside.push_str(rest);
        count += outside.matches(markup).count() - outside.matches(&format!("\\{markup}")).count();
    }
    count
}

#[test]
fn d11_names_stay_inside_the_folder_the_pictures_and_the_tables() {
    let names = ["..", "con", "_a_", "__b__", "שלום", "a\u{3164}", "x_{y}"].map(|name| name.replace(['{', '}'], ""));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let place = with_particles(&names);
    let stages = "least_squares,bootstrap,posterior,figures";
    let outcome = place.run(&["fit", "scene.toml", "--out", "o", "--stages", stages], 60.0);
    assert_ran(&outcome, "odd names");
    assert_eq!(place.entries(), ["o", "runs.csv", "scene.toml"]);
    let found = files(&place.path("o"));
    let mut pictures = 0;
    for name in &found {
        if name.starts_with("figures/") {
            let text = place.read(&format!("o/{name}"));
            let document = roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{name}: {error}"));
            let known = [
                "svg", "g", "rect", "line", "path", "circle", "text", "tspan", "polyline", "polygon", "defs",
                "clipPath",
            ];
            let odd = document
                .descendants()
                .find(|node| node.is_element() && !known.contains(&node.tag_name().name()));
            assert!(odd.is_none(), "{name}: {odd:?}");
            pictures += 1;
        } else if name.starts_with("draws/draws.zarr/") {
            assert!(
                name.chars()
                    .all(|c| c.is_ascii_alphanumeric() || matches!(c, '/' | '.' | '_')),
                "{name}"
            );
            assert!(!name.contains(".."), "{name}");
        }
    }
    assert!(pictures > 14, "{pictures}");
    let page = place.read("o/report.md");
    page.says("| \\_a\\_ |");
    page.says("| \\_\\_b\\_\\_ |");
    assert!(page.contains("a\\u{3164}") && !page.contains('\u{3164}'));
    links(&page, &found);
}

/// Every link to a figure leads to one, and every figure of a particle is linked.
fn links(page: &str, found: &[String]) {
    let mut linked = vec![];
    for (at, _) in page.match_indices("](figures/") {
        let address = page[at + 2..].split_once(')').expect("an end").0;
        assert!(address.is_ascii(), "{address}");
        let mut bytes = vec![];
        let mut rest = address.bytes();
        while let Some(byte) = rest.next() {
            if byte == b'%' {
                let digits = [rest.next(), rest.next()].map(|digit| char::from(digit.expect("two digits")));
                let digits: String = digits.iter().collect();
                bytes.push(u8::from_str_radix(&digits, 16).expect("hexadecimal"));
            } else {
                bytes.push(byte);
            }
        }
        linked.push(String::from_utf8(bytes).expect("UTF-8"));
    }
    for name in found.iter().filter(|name| name.starts_with("figures/")) {
        let times = linked.iter().filter(|link| *link == name).count();
        assert_eq!(times, 1, "{name} in {linked:?}");
    }
    assert_eq!(
        linked.len(),
        found.iter().filter(|name| name.starts_with("figures/")).count()
    );
}

/// Runs a command whose standard output takes nothing.
#[cfg(target_os = "linux")]
fn to_a_full_device(place: &Place, arguments: &[&str]) -> Outcome {
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .expect("the full device");
    let mut command = place.command(arguments);
    command
        .stdin(std::process::Stdio::null())
        .stdout(full)
        .stderr(std::process::Stdio::piped());
    let output = command.output().expect("the command can be started");
    Outcome {
        status: output.status.code(),
        out: String::new(),
        err: String::from_utf8(output.stderr).expect("UTF-8"),
        seconds: 0.0,
    }
}

#[cfg(target_os = "linux")]
#[test]
fn d12_a_full_standard_output_is_said_with_what_stands() {
    let place = Place::plain();
    place.add_to_scene(
        "[truth]\ndry_k = { PTFE = 0.183 }\nlubrication_log = 1.9\ninertia = \"stepwise\"\ninertial_prefactor = 0.6\n\
         sigma_dry = 0.01\nsigma_wet = 0.01\n[design]\ndiameter_mm = { PTFE = [4.0] }\nliquids = [\"AK10\"]\n\
         film_ratio = { PTFE = [0.05] }\nimpact_speed_m_s = [1.0]\ndry_impact_speed_m_s = [1.0]\nrepeats = 2",
    );
    let reason = "standard output: cannot write: No space left on device";
    for (arguments, written) in [
        (
            &["fit", "scene.toml", "--out", "o", "--stages", "least_squares"][..],
            Some("o/report.md"),
        ),
        (&["simulate", "scene.toml", "--out", "s.csv"], Some("s.csv")),
        (&["check", "scene.toml"], None),
        (&["--version"], None),
        (&["fit", "--help"], None),
    ] {
        let outcome = to_a_full_device(&place, arguments);
        outcome.assert_refused(&arguments.join(" "), &[reason]);
        match written {
            Some(path) => {
                outcome.err.says(&format!("; {path} was written whole\n"));
                assert!(place.path(path).is_file(), "{path}");
            }
            None => assert!(!outcome.err.contains("was written"), "{}", outcome.err),
        }
    }
    assert!(place.path("o/findings.json").is_file());
    // nothing is printed, so nothing can be refused
    let quiet = "fit scene.toml --out o --stages least_squares --quiet".split(' ');
    let quiet = to_a_full_device(&place, &quiet.collect::<Vec<&str>>());
    assert_eq!((quiet.status, quiet.err.as_str()), (Some(0), ""));
}

/// The command with so many kilobytes of address space, in which a thread takes a quarter of a gigabyte.
#[cfg(target_os = "linux")]
fn with_room(place: &Place, kilobytes: u64, arguments: &[&str]) -> Outcome {
    let mut command = std::process::Command::new("sh");
    command
        .arg("-c")
        .arg(format!("ulimit -v {kilobytes} && exec \"$0\" \"$@\""));
    command.arg(env!("CARGO_BIN_EXE_wetcor")).args(arguments);
    command
        .current_dir(place.folder.path())
        .env("RUST_MIN_STACK", (256 << 20).to_string());
    finish(command, 60.0)
}

#[cfg(target_os = "linux")]
#[test]
fn d16_fewer_threads_are_used_where_no_more_are_to_be_had() {
    /// megabytes for the program and its work, less than one stack
    const WORK: u64 = 200;
    let place = Place::plain();
    let words = "fit scene.toml --out o --threads 5 --stages least_squares";
    let arguments: Vec<&str> = words.split(' ').collect();
    let mut seen = [0; 3];
    // less is refused before threads are started
    for quarters in 2..=20 {
        let outcome = with_room(&place, (WORK + 256 * quarters) << 10, &arguments);
        outcome.assert_mannered(&format!("{quarters} stacks"));
        let fewer = outcome.err.contains(" in place of 5 threads: no more could be started");
        let none = outcome
            .err
            .contains("cannot start the 4 threads that the least work takes");
        assert_eq!(none, outcome.status == Some(2), "{outcome:?}");
        seen[usize::from(fewer) + 2 * usize::from(none)] += 1;
    }
    assert!(seen.iter().all(|count| *count > 0), "{seen:?}");
    let folder = place.entries();
    assert_eq!(folder, ["o", "runs.csv", "scene.toml"]);
}

#[test]
fn d16_more_threads_than_are_of_use_are_not_started() {
    let place = Place::plain();
    let outcome = place.run(&["check", "scene.toml", "--threads", "65535"], 20.0);
    assert_ran(&outcome, "65535 threads");
    outcome.err.says(" in place of 65535 threads: this machine runs ");
    let few = place.run(&["check", "scene.toml", "--threads", "64"], 20.0);
    assert!(!few.err.contains("in place of"), "{}", few.err);
    assert_eq!(few.out, outcome.out);
}

/// Whatever terms a model holds and whatever runs it has, what is not a number is shown as a dash.
#[test]
fn no_report_prints_what_is_no_number() {
    let place = Place::plain();
    place.add_to_scene("[sampler]\nchains = 2\nwarmup = 50\ndraws = 50\n[bootstrap]\nreplicates = 50");
    let (scene, runs) = (place.read("scene.toml"), place.read("runs.csv"));
    let some = |keep: &dyn Fn(usize, &str) -> bool| -> String {
        let lines = runs.lines().enumerate();
        lines
            .filter(|(at, line)| *at == 0 || keep(*at, line))
            .map(|(_, line)| format!("{line}\n"))
            .collect()
    };
    let stuck: String = some(&|_, _| true)
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((start, _)) if line.contains("AK10") => format!("{start},0\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    for (model, runs) in [
        ("terms = [\"bridge\"]", runs.clone()),
        ("terms = [\"viscous\"]", runs.clone()),
        ("terms = [\"inertia\", \"bridge\", \"dry_second_order\"]", runs.clone()),
        ("noise = \"both\"", runs.clone()),
        ("dry_speed_m_s = 1e-9", runs.clone()),
        ("likelihood = \"student\"", some(&|at, _| at % 3 == 0)),
        ("inertia = \"saturating\"", some(&|_, line| line.contains("dry"))),
        ("inertia = \"none\"", some(&|_, line| line.contains("AK10"))),
        ("terms = [\"bridge\"]", some(&|at, _| at == 1)),
        ("sticking = \"censored\"", stuck),
    ] {
        place.write("scene.toml", format!("{scene}\n[model]\n{model}\n"));
        place.write("runs.csv", runs);
        let stages = "least_squares,bootstrap,posterior,figures";
        let fitted = place.run(&["fit", "scene.toml", "--stages", stages, "--out", "report"], 120.0);
        fitted.assert_mannered(model);
        let checked = place.run(&["check", "scene.toml"], 60.0);
        let [report, page] = ["report.md", "report.html"]
            .map(|name| std::fs::read_to_string(place.path("report").join(name)).unwrap_or_default());
        // in the figures of the page `inf` is a subscript
        let page = page.replace(">inf<", "><");
        for text in [fitted.out, fitted.err, checked.out, checked.err, report, page] {
            let odd = |word: &&str| ["NaN", "inf", "infinity"].contains(word);
            let words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
            assert_eq!(words.collect::<Vec<_>>().into_iter().find(odd), None, "{model}");
        }
        let _ = std::fs::remove_dir_all(place.path("report"));
    }
}

/// A folder may be called as a sheet of a workbook is named, and a path need not be text.
#[cfg(target_os = "linux")]
#[test]
fn a_table_is_read_where_its_path_leads() {
    use std::os::unix::ffi::OsStrExt;
    let place = Place::plain();
    std::fs::create_dir(place.path("b.xlsx#1")).expect("writable");
    place
        .run(&["new", "b.xlsx#1", "--out", "made.toml"], 10.0)
        .assert_refused("a folder", &["b.xlsx#1: expected a file ending in"]);
    std::fs::copy(place.path("runs.csv"), place.path("b.xlsx#1/runs.csv")).expect("writable");
    let drafted = place.run(&["new", "b.xlsx#1/runs.csv", "--out", "made.toml"], 10.0);
    assert_eq!(drafted.status, Some(0), "{drafted:?}");
    assert!(place.read("made.toml").contains("runs = \"b.xlsx#1/runs.csv\""));
    let odd = std::ffi::OsStr::from_bytes(b"a\xff.csv");
    std::fs::copy(place.path("runs.csv"), place.folder.path().join(odd)).expect("writable");
    let mut command = place.command(&["new"]);
    command.arg(odd);
    finish(command, 10.0).assert_refused("no text", &["a\u{fffd}.csv: ", "expected a path that is UTF-8"]);
}

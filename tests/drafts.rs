//! Drafts a scene from the table of every good example, and holds it to what the example's own scene says.

use std::path::PathBuf;

use crate::common::{entries, in_project, read_in_project, wetcor, Folder, Says};
use wetcor::runs::Runs;
use wetcor::scene::{HeightsTo, Scene};
use wetcor::{runs, scene};

/// The good examples with one table, and their scenes; but for those whose numbers mark something, which no draft can know.
fn examples() -> Vec<(PathBuf, Scene)> {
    let folder = in_project("tests/data/good");
    let folders = entries(&folder).into_iter().map(|name| folder.join(name));
    let with_scene = |folder: PathBuf| {
        let scene = scene::read(&folder.join("scene.toml")).unwrap_or_else(|error| panic!("{error}"));
        let has_marks = scene.data.naming.words.iter().any(|(column, _)| column.is_number());
        (scene.data.runs.len() == 1 && !has_marks).then_some((folder, scene))
    };
    folders.filter_map(with_scene).collect()
}

/// The text with the first mark after a table's head and a key replaced.
fn filled_in(text: &str, key: &str, value: &str) -> String {
    let (head, name) = key.split_once("] ").expect("a table and a key");
    let table = text.find(&format!("\n{head}]")).expect("the table is there");
    let name = name.split('.').next_back().expect("a name");
    let (before, after) = text.split_at(table);
    assert!(after.contains(&format!("{name} = \"fill in\"")), "{name} is not open");
    let filled = after.replacen(&format!("{name} = \"fill in\""), &format!("{name} = {value}"), 1);
    format!("{before}{filled}")
}

/// What the example's scene says of a key that the draft leaves open.
fn told(scene: &Scene, key: &str) -> String {
    // the examples have one particle and one liquid
    let liquid = || &scene.liquids[0];
    let number = match key.rsplit(' ').next().expect("a key") {
        "heights_to" if scene.data.naming.heights_to == HeightsTo::Film => return "\"film\"".to_owned(),
        "heights_to" => return "\"plate\"".to_owned(),
        "heights_of" => return "\"lowest\"".to_owned(),
        "density_kg_m3" if key.starts_with("[particles") => scene.particles[0].density,
        "density_kg_m3" => liquid().density,
        "viscosity_mPa_s" => 1e3 * liquid().viscosity,
        "constants.diameter_mm" => 4.0,
        other => panic!("{other} is left open"),
    };
    number.to_string()
}

/// Impact speed, restitution, film and diameter of every run, in order.
fn measured(runs: &Runs) -> Vec<[f64; 4]> {
    let columns = [&runs.impact_speed, &runs.restitution, &runs.film, &runs.diameter];
    let each = (0..runs.len()).map(|run| columns.map(|column| column[run]));
    let mut all: Vec<[f64; 4]> = each.collect();
    all.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    all
}

#[test]
fn a_draft_lacks_what_check_names_and_then_reads_the_runs_as_the_example_does() {
    let examples = examples();
    assert!(examples.len() > 25, "the examples are lost");
    for (folder, example) in &examples {
        let place = Folder::new();
        let file = &example.data.runs[0];
        let table = file.path.file_name().and_then(|name| name.to_str()).expect("plain");
        std::fs::copy(&file.path, place.join(table)).expect("writable");
        let sheet = file.sheet.as_ref().map_or(String::new(), |sheet| format!("#{sheet}"));
        let table = format!("{table}{sheet}");
        let (status, out, err) = wetcor(place.path(), &["new", &table]);
        assert_eq!((status, err.as_str()), (Some(0), ""), "{}", folder.display());
        let to_fill_in = out.lines().filter_map(|line| line.strip_prefix("to fill in: "));
        let to_fill_in: Vec<&str> = to_fill_in.collect();
        assert!(!to_fill_in.is_empty(), "{out}");
        // `check` names exactly these
        let err = place.refused("check scene.toml");
        let named = err.lines().filter(|line| line.contains("found `\"fill in\"`")).count();
        let lines = err.lines().count() - 1;
        assert_eq!([named, lines], [to_fill_in.len(); 2], "{err}");
        let path = place.join("scene.toml");
        let mut text = place.read("scene.toml");
        for key in to_fill_in {
            text = filled_in(&text, key, &told(example, key));
        }
        place.write("scene.toml", text);
        let (status, _, err) = place.run("check scene.toml");
        assert_eq!(status, Some(0), "{}: {err}", folder.display());
        let read = |scene: &Scene| runs::read(scene).unwrap_or_else(|error| panic!("{error}"));
        let drafted = scene::read(&path).unwrap_or_else(|error| panic!("{error}"));
        let (drafted, example) = (measured(&read(&drafted).runs), measured(&read(example).runs));
        assert_eq!(drafted.len(), example.len(), "{}", folder.display());
        for (a, b) in drafted.iter().flatten().zip(example.iter().flatten()) {
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{}: {a} {b}", folder.display());
        }
    }
}

/// What a draft of a table leaves to be filled in, and what it says of its columns.
fn drafted(table: &str) -> (Vec<String>, String) {
    let place = Folder::new();
    place.write("runs.csv", table);
    let (status, out, err) = place.run("new runs.csv");
    assert_eq!((status, err.as_str()), (Some(0), ""));
    let marks = out.lines().filter_map(|line| line.strip_prefix("to fill in: [data] "));
    (marks.map(str::to_owned).collect(), out)
}

/// The lines of a block of `tests/data/drafts.txt` that begin with a mark, filled with the words of a variant.
fn lines(block: &str, mark: &str, words: &[&str]) -> Vec<String> {
    let lines = block.lines().filter_map(|line| line.strip_prefix(mark));
    let filled = lines.map(|line| {
        let places = words.iter().zip(1..);
        places.fold(line.replace("\\n", "\n"), |line, (word, place)| {
            line.replace(&format!("{{{place}}}"), word)
        })
    });
    filled.collect()
}

#[test]
fn a_draft_says_what_it_took_and_asks_for_what_it_cannot_know() {
    let text = read_in_project("tests/data/drafts.txt");
    // the first block says how they are written
    let blocks: Vec<&str> = text.split("\n\n").skip(1).collect();
    assert!(blocks.len() > 20, "the tables are lost");
    for block in blocks {
        let mut variants = lines(block, "= ", &[]);
        if variants.is_empty() {
            variants.push(String::new());
        }
        for variant in variants {
            let words: Vec<&str> = variant.split(" ~ ").collect();
            let of = |mark: &str| lines(block, mark, &words);
            let (marks, out) = drafted(&(of("| ").join("\n") + "\n"));
            match of("? ") {
                asked if asked.is_empty() => {}
                asked if asked == ["nothing"] => assert!(marks.is_empty(), "{variant}: {marks:?}\n{block}"),
                asked => assert_eq!(marks, asked, "{variant}:\n{block}"),
            }
            of("+ ").iter().for_each(|said| out.says(said));
            of("- ").iter().for_each(|unsaid| out.lacks(unsaid));
        }
    }
}

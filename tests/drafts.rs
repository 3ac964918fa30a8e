//! Drafts a scene from the table of every good example, and holds it to what the example's own scene says.

use std::path::PathBuf;

use crate::common::{in_project, read_in_project, table_of, wetcor, Folder, Says};
use wetcor::runs::Runs;
use wetcor::scene::{HeightsTo, Scene};
use wetcor::{runs, scene};

/// The good examples with one table, and their scenes; but for those whose numbers mark something, which no draft can know.
fn examples() -> Vec<(PathBuf, Scene)> {
    let folder = in_project("tests/data/good");
    let entries = std::fs::read_dir(folder).expect("the examples are there");
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    folders.sort();
    let with_scene = |folder: PathBuf| {
        let scene = scene::read(&folder.join("scene.toml")).unwrap_or_else(|error| panic!("{error}"));
        let has_marks = scene.data.naming.words.iter().any(|(column, _)| column.is_number());
        (scene.data.runs.len() == 1 && !has_marks).then_some((folder, scene))
    };
    folders.into_iter().filter_map(with_scene).collect()
}

/// The text with the first mark after a table's head and a key replaced.
fn filled_in(text: &str, key: &str, value: &str) -> String {
    let (head, name) = key.split_once("] ").expect("a table and a key");
    let table = text.find(&format!("\n{head}]")).expect("the table is there");
    let name = name.split('.').next_back().expect("a name");
    let at = table
        + text[table..]
            .find(&format!("{name} = \"fill in\""))
            .expect("the key is there");
    let mark = at + text[at..].find("\"fill in\"").expect("the mark is there");
    format!("{}{value}{}", &text[..mark], &text[mark + "\"fill in\"".len()..])
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
    let each = (0..runs.len()).map(|run| {
        [
            runs.impact_speed[run],
            runs.restitution[run],
            runs.film[run],
            runs.diameter[run],
        ]
    });
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
        let table = example.data.runs[0]
            .path
            .file_name()
            .and_then(|name| name.to_str())
            .expect("plain");
        std::fs::copy(folder.join(table), place.join(table)).expect("writable");
        let table = example.data.runs[0]
            .sheet
            .as_ref()
            .map_or(table.to_owned(), |sheet| format!("{table}#{sheet}"));
        let (status, out, err) = wetcor(place.path(), &["new", &table]);
        assert_eq!((status, err.as_str()), (Some(0), ""), "{}", folder.display());
        let to_fill_in: Vec<&str> = out
            .lines()
            .filter_map(|line| line.strip_prefix("to fill in: "))
            .collect();
        assert!(!to_fill_in.is_empty(), "{out}");
        // `check` names exactly these
        let err = place.refused("check scene.toml");
        let named = err.lines().filter(|line| line.contains("found `\"fill in\"`")).count();
        assert_eq!(
            (named, err.lines().count()),
            (to_fill_in.len(), to_fill_in.len() + 1),
            "{err}"
        );
        let path = place.join("scene.toml");
        let mut text = std::fs::read_to_string(&path).expect("the draft is there");
        for key in to_fill_in {
            text = filled_in(&text, key, &told(example, key));
        }
        std::fs::write(&path, text).expect("writable");
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

#[test]
fn what_is_there_is_kept_and_what_is_no_table_is_refused() {
    let place = Folder::new();
    let files = || std::fs::read_dir(place.path()).expect("readable").count();
    place.write(
        "runs.csv",
        "particle,liquid,diameter_mm,film_um,v_i\nPE,oil,4,200,1.2\n",
    );
    place.write("scene.toml", "somebody's work");
    let before = files();
    for [words, told] in table_of(
        "new runs.csv | scene.toml: exists; --out names another file; nothing was written
         new none.csv --out a.toml | none.csv: cannot read the runs
         new runs.pdf --out a.toml | expected a file ending in .csv, .tsv, .txt, .xlsx or .parquet
         new scene.toml --out a.toml | expected a file ending in
         new runs.csv --out nowhere/a.toml | there is no folder",
    ) {
        place.refused(words).says(told);
        assert_eq!(files(), before, "{words}");
    }
    assert_eq!(place.read("scene.toml"), "somebody's work");
    // a guess says so, and a table elsewhere is named from where the scene lies
    std::fs::create_dir(place.join("scenes")).expect("writable");
    let (status, out, err) = place.run("new runs.csv --out scenes/a.toml");
    assert_eq!((status, err.as_str()), (Some(0), ""), "{out}");
    out.says("guessed: `v_i` is impact_speed_m_s, its unit by the size of its numbers");
    assert!(out.contains("to fill in: [data] columns.restitution"), "{out}");
    let text = place.read("scenes/a.toml");
    text.says("\nruns = \"../runs.csv\"");
    text.says("# guessed: `v_i` is");
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

/// A scene that names liquids, with a table that says of no run which one it has.
#[test]
fn liquids_that_no_table_tells_of_are_asked_for() {
    let place = Folder::new();
    let liquid = "density_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
    let checked = |header: &str, cell: &str, data: &str, liquids: &[&str]| {
        let rows: String = (0..9)
            .map(|run| format!("PTFE,4,{cell},{}.5,0.7{run}\n", 1 + run % 2))
            .collect();
        place.write(
            "runs.csv",
            format!("particle,diameter_mm,{header},impact_speed_m_s,restitution\n{rows}"),
        );
        let liquids: String = liquids
            .iter()
            .map(|name| format!("[liquids.{name}]\n{liquid}"))
            .collect();
        let text = format!("[data]\nruns = \"runs.csv\"\n{data}\n[particles.PTFE]\ndensity_kg_m3 = 2150\n{liquids}");
        place.write("scene.toml", text);
        place.run("check scene.toml")
    };
    let (status, _, err) = checked("oil,thick", "AK10,200", "", &["AK10", "M50"]);
    assert_eq!(status, Some(2), "{err}");
    err.says("runs.csv: 1 problem");
    err.says("no column `liquid`, though the scene has [liquids]");
    err.says("constants = { liquid = \"AK10\" }");
    // told by the scene, and a liquid of two that no run has
    for (header, cell, data) in [
        ("oil,film_um", "AK10,200", "columns = { liquid = \"oil\" }"),
        ("film_um", "200", "constants = { liquid = \"AK10\" }"),
    ] {
        let (status, _, err) = checked(header, cell, data, &["AK10", "M50"]);
        assert_eq!(status, Some(0), "{err}");
        err.lacks("no run in use has a liquid");
    }
    // every run said to be dry
    let (status, _, err) = checked("liquid", "dry", "", &["AK10"]);
    assert_eq!(status, Some(0), "{err}");
    err.says("no run in use has a liquid; the scene names AK10");
    let (status, _, err) = checked("oil", "AK10", "", &[]);
    assert_eq!(status, Some(0), "{err}");
}

/// What a draft leaves out the reader of runs leaves out, too.
#[test]
fn foot_rows_are_left_out_and_named() {
    let place = Folder::new();
    let table = "particle,diameter_mm,impact_speed_m_s,restitution\nPTFE,4,1,0.8\nPTFE,4,1.2,0.79\nn=2,,,\n";
    place.write("runs.csv", table);
    let text = "[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\n";
    place.write("scene.toml", text);
    let (status, out, err) = place.run("check scene.toml");
    assert_eq!(status, Some(0), "{err}");
    out.says("3 runs read, 1 left out");
    err.says("line 4 `n=2`");
}

/// A column that is not read is refused only where it may be one that nothing gives.
#[test]
fn columns_that_are_not_read_are_not_refused_for_a_likeness() {
    let place = Folder::new();
    let checked = |name: &str| {
        let rows: String = (0..9)
            .map(|run| format!("PE,dry,5,,{}.5,0.7{run},{run}\n", 1 + run % 2))
            .collect();
        place.write(
            "runs.csv",
            format!("particle,liquid,diameter_mm,film_um,impact_speed_m_s,e,{name}\n{rows}"),
        );
        let text =
            "[data]\nruns = \"runs.csv\"\ncolumns = { restitution = \"e\" }\n[particles.PE]\ndensity_kg_m3 = 940\n";
        place.write("scene.toml", text);
        place.run("check scene.toml")
    };
    for name in "n rep rank rain sun ran rn gun liquids particles restitution2 film diameter include".split(' ') {
        let (status, _, err) = checked(name);
        assert_eq!(status, Some(0), "{name}: {err}");
    }
    for (name, meant) in [
        ("exlude", "exclude"),
        ("film_ratios", "film_ratio"),
        ("impact_speed_sd_ms", "impact_speed_sd_m_s"),
    ] {
        let (status, _, err) = checked(name);
        assert_eq!(status, Some(2), "{name}");
        err.says(&format!("did you mean `{meant}`?"));
    }
}

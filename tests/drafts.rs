//! Drafts a scene from the table of every good example, and holds it to what the example's own scene says.

use std::path::PathBuf;

use crate::common::{in_project, table_of, wetcor, Folder, Says};
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

#[test]
fn what_two_units_or_two_columns_could_be_is_left_to_be_filled_in() {
    let run = |header: &str, row: &str| format!("{header}\n{row}\n{row}\n");
    // 0.4762 cm, and 0.015 cm of film
    let (marks, _) = drafted(&run("ball,liquid,D,film,v (m/s),e", "PTFE,AK10,0.4762,0.015,0.9,0.7"));
    assert_eq!(marks, ["columns.diameter_mm", "columns.film_um"]);
    // of two columns of speeds the one that says which it is
    let (marks, out) = drafted(&run(
        "ball,liquid,D (mm),film (um),v (m/s),v0 (m/s),e",
        "PTFE,AK10,4,150,0.6,0.9,0.7",
    ));
    assert!(marks.is_empty(), "{marks:?}");
    out.says("`v0 (m/s)` is impact_speed_m_s");
    // a column of words that nobody knows may name the spheres
    let (marks, out) = drafted(&run("stuff,liquid,D (mm),film (um),v (m/s),e", "PTFE,AK10,4,200,1,0.7"));
    assert_eq!(marks, ["columns.particle"]);
    out.says("no column is known to say the particle: if `stuff` does");
    let (marks, out) = drafted(&run(
        "liquid,D (mm),film (um),v (m/s),e,comment",
        "AK10,4,200,1,0.7,bad",
    ));
    assert!(marks.is_empty(), "{marks:?}");
    out.says("`comment` is not read: if it says which runs to leave out");
    let (marks, out) = drafted(&run(
        "ball,liquid,D (mm),film (um),h_drop (cm),h_rebound (cm)",
        "PTFE,\"dry, no oil\",4,,9,5",
    ));
    assert_eq!(marks, ["heights_to", "heights_of"]);
    assert!(out.contains("`dry, no oil` in `liquid` is dry"), "{out}");
}

/// A table whose liquids or films stand under names that nobody knows is not taken for dry.
#[test]
fn columns_that_may_say_what_is_wet_are_asked_for() {
    let run = |header: &str, row: &str| drafted(&format!("ball,D (mm),v (m/s),e,{header}\nPTFE,4,1,0.8,{row}\n"));
    for (header, row) in [
        ("condition", "A10"),
        ("Oleje,Tloušťka (µm)", "M50,200"),
        ("h_l [mm]", "0.2"),
        ("depth / mm", "0.2"),
        ("Filmdicke/D", "0.05"),
        ("film mass (mg)", "3"),
        ("wet", "1"),
        ("Ca", "0.01"),
    ] {
        let (marks, out) = run(header, row);
        assert_eq!(marks, ["columns.liquid"], "{header}");
        out.lacks("every run is dry;");
        out.says("; no liquid known");
        out.says("no column is known to say the liquid or the film: if `");
        out.says("if every run is dry, take `liquid` out of columns");
    }
    let (_, out) = run("film ratio", "0.05");
    assert!(out.contains("no column says the liquid: all runs are wet"), "{out}");
    // the twins: what holds neither
    for (header, row) in [
        ("date", "May 3"),
        ("No.", "7"),
        ("T (°C)", "21.5"),
        ("angle (deg)", "1.2"),
    ] {
        let (marks, out) = run(header, row);
        assert!(marks.is_empty(), "{header}: {marks:?}");
        out.says("; every run is dry");
    }
}

/// What stands above the names may say that runs are wet: a line about the table, or a small table of constants.
#[test]
fn titles_that_speak_of_a_liquid_are_asked_about() {
    let rows = "ball,v (m/s),e\nPTFE,1,0.8\nPTFE,1.2,0.8\nPTFE,1.4,0.8\n";
    for title in ["Drops on an oil film,,", "liquid,film_um,D_mm\nAK10,286,4.762"] {
        let (marks, out) = drafted(&format!("{title}\n{rows}"));
        assert!(marks.contains(&"columns.liquid".to_owned()), "{title}: {marks:?}");
        out.says("; no liquid known");
        out.says("constants and write a table [liquids.NAME] for each liquid");
    }
    // nor does size tell a unit that a title may
    let plain = rows.replace(" (m/s)", "");
    let (marks, out) = drafted(&format!("speeds in ft/s,,\n{plain}"));
    assert!(marks.contains(&"columns.impact_speed_m_s".to_owned()), "{marks:?}");
    out.says("`v` may be impact_speed, but `speeds in ft/s` may say its unit");
    let (_, out) = drafted(&format!("Room 22.5 °C; D = 4 mm,,\n{plain}"));
    out.says("`v` is impact_speed_m_s");
    let (_, out) = drafted(&format!("Drops of May: Universität zu Köln,,\n{rows}"));
    out.says("; every run is dry");
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

/// A foot row is no sphere, in any language that the reader of runs knows.
#[test]
fn foot_rows_are_left_out_and_named() {
    let rows = "PTFE,4,1,0.8\nPTFE,4,1.2,0.79\nPTFE,4,1.5,0.78\nPE,4,1.5,0.81\n";
    for label in "Mittelwert; mean; Average; Summe; Total; moyenne; Std. dev.; Median; n=12; n = 4".split("; ") {
        let (_, out) = drafted(&format!("Kugel,D (mm),v (m/s),e\n{rows}{label},4,1000,0.8\n"));
        assert!(out.contains(": 5 rows; particles PTFE, PE; every run is dry"), "{out}");
        let told = format!(
            "guessed: left out, since their labels say mean, total, spread or count of other rows: row 6 `{label}`"
        );
        assert!(out.contains(&told), "{out}");
    }
    // the twin: names, and labels that are all that stands there
    let (_, out) = drafted(&format!("Kugel,D (mm),v (m/s),e\n{rows}nylon,4,1,0.8\n"));
    out.says(": 5 rows; particles PTFE, PE, nylon;");
    out.lacks("left out");
    let (_, out) = drafted("Kugel,D (mm),v (m/s),e,n,sd\nmean,4,1,0.8,5,0.01\nmean,4,1.2,0.79,5,0.01\n");
    out.says(": 2 rows; particles mean;");
    out.lacks("left out");
    // and the reader of runs leaves the count out, too
    let place = Folder::new();
    let table = "particle,diameter_mm,impact_speed_m_s,restitution\nPTFE,4,1,0.8\nPTFE,4,1.2,0.79\nn=2,,,\n";
    place.write("runs.csv", table);
    let text = "[data]\nruns = \"runs.csv\"\n[particles.PTFE]\ndensity_kg_m3 = 2150\n";
    place.write("scene.toml", text);
    let (status, out, err) = place.run("check scene.toml");
    assert_eq!(status, Some(0), "{err}");
    assert!(out.contains("3 runs read, 1 left out"), "{out}");
    assert!(err.contains("line 4 `n=2`"), "{err}");
}

/// What laboratories write in a column of liquids for a dry run, and liquids whose names begin like that.
#[test]
fn only_a_whole_word_says_that_a_run_is_dry() {
    let of = |word: &str| {
        let rows = format!("PE,{word},5,,1,0.8\nPE,{word},5,,1.2,0.8\nPE,S100,5,250,1,0.7\n");
        drafted(&format!("ball,liquid,D (mm),film (um),v (m/s),e\n{rows}")).1
    };
    let dry =
        "Dry.; dry run; DRY (no film); no oil; ohne Öl; kein; keine; sec; seco; secco; w/o; n/a; none; --; —; air";
    for word in dry.split("; ") {
        let out = of(word);
        out.says(&format!("`{word}` in `liquid` is dry"));
        out.says("; liquids S100\n");
    }
    for word in [
        "dry vermouth",
        "No 5",
        "Air-foam",
        "none such 3",
        "Secret",
        "nonanol",
        "dry/wet",
    ] {
        let out = of(word);
        out.lacks("in `liquid` is dry\n");
        assert!(!out.contains("; liquids S100\n"), "{word}: {out}");
    }
}

/// Numbers that tell liquids apart, and a column that says which rows are dry beside a liquid named in every row.
#[test]
fn columns_that_tell_liquids_apart_are_asked_about() {
    for name in [
        "viscosity (mPa s)",
        "η",
        "glycerol wt%",
        "water content",
        "liquid (vol%)",
    ] {
        let table = |other: &str| {
            format!("ball,{name},D (mm),film (um),v (m/s),e\nPE,20,5,250,1,0.7\nPE,{other},5,250,1,0.6\n")
        };
        let (marks, out) = drafted(&table("35"));
        assert_eq!(marks, ["columns.liquid"], "{name}");
        out.says("no column is known to say the liquid: if `");
        // the twin: one liquid
        let (marks, _) = drafted(&table("20"));
        assert!(marks.is_empty(), "{name}: {marks:?}");
    }
    let of = |name: &str, cells: [&str; 2], liquid: &str| {
        let [dry, wet] = cells;
        drafted(&format!(
            "ball,liquid,{name},D (mm),film (um),v (m/s),e\nPE,{liquid},{dry},5,250,1,0.8\nPE,S100,{wet},5,250,1,0.6\n"
        ))
    };
    for (name, cells) in [
        ("surface", ["dry", "wet"]),
        ("Zustand", ["trocken", "nass"]),
        ("wet?", ["0", "1"]),
        ("dry", ["yes", "no"]),
        ("état", ["sec", "mouillé"]),
    ] {
        let (marks, out) = of(name, cells, "S100");
        assert_eq!(marks, ["columns.liquid"], "{name}");
        out.says(&format!(
            "`liquid` names a liquid in every row, but `{name}` says which are dry"
        ));
        // the twins: the liquid says it, too
        for liquid in ["dry", ""] {
            let (marks, _) = of(name, cells, liquid);
            assert!(marks.is_empty(), "{name}: {marks:?}");
        }
    }
    let (marks, _) = of("plate", ["dry glass", "steel"], "S100");
    assert!(marks.is_empty(), "{marks:?}");
}

/// Footnotes and rows that are commented out are neither spheres nor liquids.
#[test]
fn notes_and_marked_names_get_no_table() {
    let rows = "PE,5,1,0.8\n#PE,5,1.2,0.79\nPE,5,1.5,0.78\nPP,5,1.5,0.81\n*2,5,1.5,0.8\n";
    let (_, out) = drafted(&format!("ball,D (mm),v (m/s),e\n{rows}1) D by caliper,,,\n"));
    out.says(": 6 rows; particles PE, PP, _2; every run is dry");
    out.says("no runs, but one cell alone, so to be taken out of the table: row 7 `1) D by caliper`");
    out.says("`#PE` in `ball` is no name, since `PE` stands there, too");
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

//! Holds what is read of workbooks: which sheet, which rows, in which units, and what a draft makes of a laboratory's own.

use crate::common::workbook::{workbook, Cell, Sheet};
use crate::common::{read_in_project, table_of, Folder, Says};
use serde_json::Value;

const PTFE: &str = "[particles.PTFE]\ndensity_kg_m3 = 2150\n";

/// Dry rebounds of one sphere from some heights in mm, with a k of its own and a little scatter; without a header.
fn dry_rows(k: f64) -> String {
    let rows = (0..24).map(|row| {
        let height = 20.0 + 12.0 * f64::from(row / 3);
        let v = (2.0 * 9.81 * height * 1e-3).sqrt();
        let e = 1.0 - k * v.powf(0.2) + [-0.006, 0.001, 0.005][row as usize % 3];
        format!("PTFE,4.762,{height},{:.3}\n", e * e * height)
    });
    rows.collect()
}

const HEADER: &str = "particle,diameter_mm,drop_height_mm,rebound_height_mm\n";

fn sheet(name: &'static str, k: f64) -> Sheet {
    Sheet::of(name, &format!("{HEADER}{}", dry_rows(k)))
}

fn place(data: &str, sheets: &[Sheet]) -> Folder {
    let place = Folder::new();
    place.write("book.xlsx", workbook(sheets));
    let scene = format!("[data]\nruns = \"book.xlsx\"\n{data}\n{PTFE}");
    place.write("scene.toml", scene);
    place
}

/// Fits by least squares: exit status, notices, and the findings.
fn fit(folder: &Folder) -> (Option<i32>, String, Value) {
    let (status, out, err) = folder.run("fit scene.toml --stages least_squares --out out --verbose");
    assert_ne!(status, Some(2), "{out}{err}");
    (status, err, folder.json("out/findings.json"))
}

/// What is said of a draft of the workbook in place of the scene.
fn drafted(folder: &Folder) -> String {
    std::fs::remove_file(folder.join("scene.toml")).expect("there");
    folder.run("new book.xlsx").1
}

fn main_numbers(findings: &Value) -> Vec<&Value> {
    let all = findings["estimates"].as_array().expect("a list");
    all.iter().filter(|row| row["main"] == true).collect()
}

fn main_number(findings: &Value, quantity: &str) -> f64 {
    let all = main_numbers(findings);
    let own = all.iter().find(|one| one["quantity"] == quantity);
    own.unwrap_or_else(|| panic!("{quantity} in {all:?}"))["value"]
        .as_f64()
        .expect("a number")
}

#[test]
fn a_hidden_sheet_is_never_read_in_silence() {
    let hidden = Sheet {
        is_hidden: true,
        ..sheet("old", 0.23)
    };
    let sheets = [hidden, sheet("May", 0.18), sheet("June", 0.18)];
    let place_of = place("", &sheets);
    let (_, err, findings) = fit(&place_of);
    assert!((main_number(&findings, "dry_k") - 0.18).abs() < 0.003);
    err.says("book.xlsx: sheet `May` is read, not `June`, nor the hidden `old`");
    assert_eq!(findings["counts"]["sheets"], serde_json::json!(["book.xlsx#May"]));
    let (_, checked, _) = place_of.run("check scene.toml");
    assert!(checked.contains("24 runs read from `book.xlsx#May`"), "{checked}");
    let report = place_of.read("out/report.md");
    assert!(report.contains("runs read from `book.xlsx#May`"));
    // by name it is read, and said to be hidden
    let place = place("", &sheets);
    place.replace("scene.toml", "book.xlsx", "book.xlsx#old");
    let (_, err, findings) = fit(&place);
    assert!((main_number(&findings, "dry_k") - 0.23).abs() < 0.003);
    err.says("book.xlsx: sheet `old` is hidden; it is read since the scene names it");
    // a draft names the sheets that it means
    drafted(&place).says("not from `old` (hidden)");
    let scene = place.read("scene.toml");
    scene.says("runs = [\"book.xlsx#May\", \"book.xlsx#June\"]");
}

#[test]
fn hidden_rows_are_asked_about_and_then_taken_or_left() {
    let hidden = Sheet {
        hidden_rows: vec![3, 4, 5, 9],
        ..sheet("May", 0.18)
    };
    let sheets = [hidden];
    let refused = place("", &sheets);
    let err = refused.refused("check scene.toml");
    err.says("found hidden rows 3 to 5, 9, expected none, or in [data] `hidden_rows = \"leave\"`");
    for (key, runs, said) in [("leave", 20, "are left out"), ("take", 24, "are read")] {
        let place = place(&format!("hidden_rows = \"{key}\"\n"), &sheets);
        let (_, err, findings) = fit(&place);
        assert_eq!(findings["counts"]["runs"], runs);
        err.says(&format!("book.xlsx, sheet `May`: hidden rows 3 to 5, 9 {said}"));
    }
    // a draft leaves the answer open
    drafted(&refused).says("to fill in: [data] hidden_rows");
    // hidden rows without cells, or above the header, are nobody's runs
    let mut empty = sheet("May", 0.18);
    empty.rows.insert(4, vec![]);
    empty.hidden_rows = vec![5];
    let place = place("", &[empty]);
    assert_eq!(fit(&place).2["counts"]["runs"], 24);
}

/// What is written once a block: in cells that are merged it is every row's; in others an empty cell may be a dry run's.
#[test]
fn a_liquid_in_merged_cells_is_that_of_every_row() {
    let row = |v: f64, wet: &str, loss: f64| {
        let e = ((1.0 - 0.18 * v.powf(0.2)).powi(2) - loss / v).sqrt();
        format!("PTFE,4.762,{v},{e:.4},{wet}\n")
    };
    let speeds = || (0..12).map(|at| 0.6 + 0.1 * f64::from(at));
    let dry: String = speeds().map(|v| row(v, "", 0.0)).collect();
    let wet: String = speeds()
        .map(|v| row(v, if v < 0.65 { "AK10,286" } else { "" }, 0.03))
        .collect();
    let header = "particle,diameter_mm,impact_speed_m_s,restitution,liquid,film_um\n";
    let mut book = Sheet::of("May", &format!("{header}{dry}{wet}"));
    let data = "[liquids.AK10]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
    let err = place(data, &[book.clone()]).refused("check scene.toml");
    err.says("row 15, column liquid: found an empty cell");
    err.says("11 cells below names are empty, as if each name");
    book.merged = vec!["E14:E25".to_owned(), "F14:F25".to_owned()];
    let out = place(data, &[book.clone()]).succeed("check scene.toml");
    let words: Vec<&str> = out.split_whitespace().collect();
    for of_rows in ["PTFE dry 12", "PTFE AK10 12"] {
        words.join(" ").says(of_rows);
    }
    // the planted fault: films merged over too few rows
    book.merged[1] = "F14:F24".to_owned();
    let (_, _, err) = place(data, &[book]).run("check scene.toml");
    err.says("row 25, column film_um");
}

#[test]
fn hidden_columns_that_are_read_are_named() {
    let hidden = Sheet {
        hidden_columns: vec![2, 3, 5],
        ..sheet("May", 0.18)
    };
    let place = place("", &[hidden]);
    let (_, err, findings) = fit(&place);
    assert_eq!(findings["counts"]["runs"], 24);
    err.says("book.xlsx, sheet `May`: hidden columns `diameter_mm`, `drop_height_mm` are read");
    drafted(&place).says("the spreadsheet hides `diameter_mm`, `drop_height_mm`");
}

/// Two gross outliers on three sheets forbid quoting as they do on one, and are named by sheet, row and label.
#[test]
fn runs_on_several_sheets_are_all_kept_and_named_as_a_person_sees_them() {
    let rows = dry_rows(0.18);
    let lines: Vec<&str> = rows.lines().collect();
    let header = "Nr.,particle,diameter_mm,drop_height_mm,rebound_height_mm\n";
    let part = |range: std::ops::Range<usize>| -> String {
        let own = range.map(|at| match at {
            13 => format!("r{at},PTFE,4.762,68,20\n"),
            _ => format!("r{at},{}\n", lines[at]),
        });
        format!("{header}{}", own.collect::<String>())
    };
    let data = "columns = { run = \"Nr.\" }\n";
    let model = "[model]\ninertia = \"stepwise\"\n";
    let sheets = [
        Sheet::of("Mai", &part(0..8)),
        Sheet::of("Öl <A>", &part(8..16)),
        Sheet::of("Juli", &part(16..24)),
    ];
    let of_three = place(data, &sheets);
    let three = "[\"book.xlsx#Mai\", \"book.xlsx#Öl <A>\", \"book.xlsx#Juli\"]";
    of_three.replace("scene.toml", "\"book.xlsx\"", three);
    of_three.write("scene.toml", of_three.read("scene.toml") + model);
    let (status, err, findings) = fit(&of_three);
    assert!(!err.contains("more than are kept"), "{err}");
    let outlier = &findings["noise"]["outliers"][0];
    assert_eq!(
        outlier["place"], "book.xlsx, sheet `Öl <A>`, row 7 (run `r13`)",
        "{outlier}"
    );
    err.says("book.xlsx, sheet `Öl <A>`, row 7 (run `r13`): PTFE, dry");
    assert_eq!(outlier["row"], 14);
    // what is so of all three is said once
    let notices = findings["remarks"].as_array().expect("remarks");
    let heights = notices.iter().filter(|notice| notice["code"] == "heights_assumed");
    let counts: Vec<&Value> = heights.map(|notice| &notice["value"]).collect();
    assert_eq!(counts, [24.0]);
    let of_one = place(data, &[Sheet::of("all", &part(0..24))]);
    let scene = of_one.read("scene.toml") + model;
    of_one.write("scene.toml", scene);
    let (status_of_one, _, of_one) = fit(&of_one);
    assert_eq!(status, status_of_one);
    assert_eq!(main_numbers(&findings), main_numbers(&of_one));
    assert_eq!(findings["noise"]["outliers_found"], of_one["noise"]["outliers_found"]);
}

/// A cell far out costs no more than one beside the others, and is told of.
#[test]
fn a_note_beside_the_table_is_no_run_and_is_told_of() {
    let mut own = sheet("May", 0.18);
    own.rows[2].resize(20, Cell::Empty);
    own.rows[2].push(Cell::Text("a note".to_owned()));
    own.rows.push(vec![Cell::Empty; 6]);
    own.rows[25].push(Cell::Text("another".to_owned()));
    let place = place("", &[own]);
    let (_, err, findings) = fit(&place);
    assert_eq!(findings["counts"]["runs"], 24);
    err.says("columns no. 7 (without a name), no. 21 (without a name) not read");
}

/// `check` of a CSV: exit status, standard output and error.
fn checked(data: &str, table: &str) -> (Option<i32>, String, String) {
    let place = Folder::new();
    place.write("runs.csv", table);
    let scene = format!("[data]\nruns = \"runs.csv\"\n{data}\n{PTFE}");
    place.write("scene.toml", scene);
    place.run("check scene.toml")
}

#[test]
fn a_unit_above_the_names_is_held_against_the_key() {
    let data = "header_row = 3\ncolumns = { drop_height_mm = \"h\" }\nheights_of = \"lowest\"\n";
    let names = "particle,diameter_mm,h,rebound_height_mm";
    let table = |above: &str| format!("Drops of May,,,\n{above}\n{names}\n{}", dry_rows(0.18));
    let of_both = |above: &str| {
        let place = place(data, &[Sheet::of("May", &table(above))]);
        let [text, book] = [checked(data, &table(above)), place.run("check scene.toml")];
        [(text.0, text.2), (book.0, book.2)]
    };
    for above in [",,(in),", "Heights,,cm,", ",mm,(1/16 in),mm"] {
        for (status, err) in of_both(above) {
            assert_eq!(status, Some(2), "{above}");
            err.says("by the row above its name it ");
        }
    }
    let (_, _, err) = checked(data, &table(",,cm,"));
    err.says(
        "line 3, column h: by the row above its name it has another unit than `drop_height_mm`; expected it as \
         `drop_height_cm` in the scene's columns",
    );
    // units that agree, titles, and a line about the whole table
    for above in [",mm,(mm),mm", "Trial,4.762 mm,[draft],", "Fall through,21.5,cm,"] {
        assert_eq!(
            of_both(above),
            [(Some(0), String::new()), (Some(0), String::new())],
            "{above}"
        );
    }
    // a draft reads it
    let place = Folder::new();
    let text = format!("May,mm,(cm),cm\nsphere,D,Fallhöhe,Steighöhe\n{}", dry_rows(0.18));
    place.write("runs.csv", text);
    let (_, out, _) = place.run("new runs.csv");
    out.says("row 2 names the columns, their units stand above");
    out.says("`Fallhöhe` is drop_height_cm, its unit by the row above, `(cm)`");
}

/// What contradicts the key is refused: `tests/data/bad/runs_*` has the words.
#[test]
fn a_header_that_states_the_unit_of_its_key_or_none_is_read() {
    let heights = "particle,diameter_mm,drop_height_mm,rebound_height_mm";
    let drops = "PTFE,25.4,250,170\nPTFE,25.4,350,236\nPTFE,25.4,450,301\n";
    let films = "particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution,film_ratio";
    let wet = |at: u32| format!("PTFE,oil,4,240,{},0.{},0.06\n", 1.0 + 0.2 * f64::from(at), 60 + 2 * at);
    let runs: String = (0..6).map(wet).collect();
    let liquid = "[liquids.oil]\ndensity_kg_m3 = 930\nviscosity_mPa_s = 9.3\n";
    let checked = |liquid: &str, [ours, theirs]: [&str; 2], header: &str, rows: &str| {
        let header = header.replace(ours, &format!("\"{theirs}\""));
        let (status, _, err) = checked(
            &format!("{liquid}[data.columns]\n{ours} = '{theirs}'\n"),
            &format!("{header}\n{rows}"),
        );
        assert_eq!(status, Some(0), "{theirs}: {err}");
        err
    };
    let names = ["drop_height_mm", "h"];
    checked("", names, heights, &format!("-,[mm],mm,(mm)\n{drops}"));
    for names in table_of(
        "impact_speed_m_s | v (in)
         impact_speed_m_s | v / m s^-1
         diameter_mm | 2R (mm)
         restitution | √(E_r/E_i)
         film_um | film 1e-6 m
         film_ratio | δ/D",
    ) {
        checked(liquid, names, films, &runs).reads("");
    }
}

/// Yes and no, and what is no reason, as a table says them; the run in the middle is left out.
#[test]
fn a_word_that_is_no_reason_keeps_a_run() {
    let of = |words: [&str; 3]| {
        let rows = dry_rows(0.18);
        let rows = rows.lines().enumerate().map(|(at, row)| {
            let word = if at == 12 { words[1] } else { words[at % 2 * 2] };
            format!("{row},{word}\n")
        });
        let table = format!("{},exclude\n{}", HEADER.trim(), rows.collect::<String>());
        let (_, of_text, _) = checked("", &table);
        let (_, out, err) = place("", &[Sheet::of("May", &table)]).run("check scene.toml");
        let count = |out: &str| {
            out.lines()
                .nth(1)
                .unwrap_or_default()
                .replace(" from `book.xlsx#May`", "")
        };
        assert_eq!(count(&out), count(&of_text), "{words:?}");
        (count(&out), err)
    };
    for words in [["0", "1", "0"], ["FALSE", "TRUE", "false"], ["nein", "ja", "Nein"]] {
        let (count, err) = of(words);
        assert_eq!(count, format!("24 runs read, 1 left out (excluded: `{}`)", words[1]));
        err.says(&format!("runs with `{}`", words[0]));
        err.says("in the column `exclude` are kept");
    }
    assert_eq!(of(["0", "0", "0"]).0, "24 runs read");
    // a no is no reason beside one either, as a dash is none
    for word in ["no", "–", "okay"] {
        let (count, err) = of(["", "no film", word]);
        count.reads("24 runs read, 1 left out (excluded: `no film`)");
        err.says(&format!("runs with `{word}` in the column `exclude` are kept"));
    }
    let (count, err) = of(["", "no film", "n"]);
    count.reads("24 runs read, 12 left out (excluded: `n`), 1 left out (excluded: `no film`)");
    err.lacks("are kept");
}

#[test]
fn heights_of_the_centre_are_counted_from_half_a_diameter_higher() {
    let fit_of = |data: &str, above: f64| {
        let rows = dry_rows(0.18);
        let moved = rows.lines().map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let [drop, rebound] = [2, 3].map(|at| cells[at].parse::<f64>().expect("a number") + above);
            format!("{},{},{drop},{rebound:.3}\n", cells[0], cells[1])
        });
        let place = place(
            data,
            &[Sheet::of("May", &format!("{HEADER}{}", moved.collect::<String>()))],
        );
        let (_, err, findings) = fit(&place);
        let is_told = data.contains("heights_of");
        assert_eq!(
            err.contains("heights are taken as those of the sphere's lowest point"),
            !is_told,
            "{err}"
        );
        main_number(&findings, "dry_k")
    };
    let right = fit_of("", 0.0);
    assert!((right - 0.18).abs() < 0.003, "{right}");
    let centre = fit_of("heights_of = \"centre\"\n", 2.381);
    assert!((centre - right).abs() < 1e-4, "{centre} {right}");
    // the planted fault: heights of the centre, not said to be
    let wrong = fit_of("", 2.381);
    assert!((wrong - right).abs() > 0.003, "{wrong} {right}");
}

/// Titles, names in two rows, units below, per cent, a sheet a liquid, runs marked as bad.
#[test]
fn a_laboratorys_workbook_takes_one_edit_and_three_commands() {
    let place = Folder::new();
    let sheet = |name, table: &str| {
        Sheet::of(
            name,
            &read_in_project(&format!("tests/data/tables/laboratory_{table}.csv")),
        )
    };
    let sheets = [
        sheet("trocken", "dry"),
        sheet("Öl AK10", "AK10"),
        sheet("Öl AK20", "AK20"),
    ];
    place.write("Versuche.xlsx", workbook(&sheets));
    let (status, out, err) = place.run("new Versuche.xlsx");
    assert_eq!((status, err.as_str()), (Some(0), ""), "{out}");
    let listed =
        "row 5 names the columns, their units stand below; `e` is restitution_percent, its unit by the row below, \
        `[%]`; `ungültig` is exclude: runs marked `x` are left out; `Steighöhe` is not read: `e` says the same of \
        more runs; sheet `trocken` is of liquid dry; diameter_mm is 4.762, by `Sphere D = 4.762 mm`; sheets trocken, \
        Öl AK10, Öl AK20";
    listed.split("; ").for_each(|said| out.says(said));
    // the one edit: what only the experimentalist knows
    let open: Vec<&str> = out
        .lines()
        .filter_map(|line| line.strip_prefix("to fill in: "))
        .collect();
    assert_eq!(open.len(), 5, "{open:?}");
    let mut scene = place.read("scene.toml");
    for value in ["2150", "930", "9.3", "950", "20"] {
        scene = scene.replacen("= \"fill in\"", &format!("= {value}"), 1);
    }
    place.write("scene.toml", scene);
    let (_, err, findings) = fit(&place);
    assert!((main_number(&findings, "dry_k") - 0.183).abs() < 0.003, "{err}");
    let l = main_number(&findings, "lubrication_log");
    assert!((l - 1.85).abs() < 0.15, "{l}: {err}");
    let screened = findings["counts"]["screened"].as_array().expect("a list");
    assert_eq!(screened[0]["reason"], "excluded: `x`");
}

/// A diameter in the title of one sheet holds for no other.
#[test]
fn a_diameter_in_the_title_of_one_sheet_is_asked_for_where_others_say_another() {
    let sheet = |name, title: &str| {
        let rows: String = (0..6).map(|run| format!("PTFE,0.{}5,0.8\n", run + 4)).collect();
        Sheet::of(name, &format!("{title},,\nball,v (m/s),e\n{rows}"))
    };
    let drafted = |titles: [&str; 2]| {
        let sheets = [sheet("small", titles[0]), sheet("large", titles[1])];
        let place = Folder::new();
        place.write("book.xlsx", workbook(&sheets));
        place.succeed("new book.xlsx")
    };
    let asked = "to fill in: [data] constants.diameter_mm";
    drafted(["D = 8 mm", "D = 8 mm"]).says("diameter_mm is 8, by `D = 8 mm`");
    drafted(["D = 4.762 mm", "D = 8 mm"]).says(asked);
    drafted(["plate D = 50 mm", "plate D = 50 mm"]).says(asked);
}

/// A list of recordings on one of several sheets is named, so that none is read that was not meant.
#[test]
fn a_list_on_one_of_several_sheets_is_asked_for_by_name() {
    let place = Folder::new();
    let list = |file: &str| format!("file,particle,diameter_mm,frame_rate_Hz\n{file},PTFE,4.762,1000\n");
    let sheets = [Sheet::of("May", &list("may.csv")), Sheet::of("June", &list("june.csv"))];
    place.write("book.xlsx", workbook(&sheets));
    let track = |list: &str| place.refused(&format!("track {list} --out runs.csv"));
    let several = track("book.xlsx");
    several.says("the workbook has 2 sheets: expected the one to read");
    several.says("`May`, `June`");
    assert!(track("book.xlsx#June").contains("june.csv"));
    let sheets = [Sheet::of("May", &list("may.csv")), Sheet::of("Sheet2", "")];
    place.write("book.xlsx", workbook(&sheets));
    assert!(track("book.xlsx").contains("may.csv"));
}

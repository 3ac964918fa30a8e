use std::path::{Path, PathBuf};

use rand::RngExt;

use super::*;
use crate::scene;

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/good").join(name)
}

fn plain() -> (Scene, String) {
    let scene = scene::read(&example("plain/scene.toml")).unwrap_or_else(|error| panic!("{error}"));
    let text = std::fs::read_to_string(example("plain/runs.csv")).expect("the example is there");
    (scene, text)
}

/// What the fast and the text reader make of a file; `None` where a reader refuses it.
fn both(text: &str, scene: &Scene) -> (Option<String>, Option<String>) {
    let separator = text::separator(text.as_bytes(), &scene.data.naming).expect("a line");
    let mut reader = text::Text::new(text.as_bytes(), separator);
    let Ok(header) = reader.header() else {
        return (None, None);
    };
    let Ok(layout) = columns::TableLayout::new(&header.names, Some(header.line), &scene.data.naming) else {
        return (None, None);
    };
    let printed = |collected: collect::Collected| format!("{collected:?}");
    // windows so small that even these files take several, with pieces of one and of several lines
    let [fast, of_larger] = [256, 2048].map(|window| {
        let read = stream::read_streamed(text.as_bytes(), text.len() as u64, window, scene);
        read.map(|(collected, _)| printed(collected))
    });
    assert_eq!(fast, of_larger, "{text:?}");
    let slow = reader.rows(&layout, scene).ok();
    (fast, slow.map(printed))
}

/// The plain table with a column of errors, most of them missing.
fn with_errors(text: &str) -> String {
    let line = |(index, line): (usize, &str)| match index {
        0 => format!("{line},impact_speed_sd_m_s,restitution_sd\n"),
        _ if index % 7 == 3 => format!("{line},0.0{index},0.02\n"),
        _ if index % 5 == 0 => format!("{line},0,\n"),
        _ => format!("{line},,NA\n"),
    };
    text.lines().enumerate().map(line).collect()
}

/// The plain table with semicolons and decimal commas, and a column that leaves some runs out.
fn german(text: &str) -> String {
    let line = |(index, line): (usize, &str)| {
        let line = line.replace(',', ";").replace('.', ",");
        match index {
            0 => format!("{line};exclude\n"),
            _ if index % 6 == 2 => format!("{line};unscharf\n"),
            _ => format!("{line};\n"),
        }
    };
    text.lines().enumerate().map(line).collect()
}

/// Where the fast reader takes a file, the text reader must make the same of it.
fn assert_agree(text: &str, scene: &Scene) -> bool {
    let (fast, slow) = both(text, scene);
    if let Some(fast) = &fast {
        assert_eq!(Some(fast), slow.as_ref(), "{text:?}");
    }
    fast.is_some()
}

#[test]
fn the_fast_reader_takes_a_plain_file() {
    let (scene, text) = plain();
    assert!(assert_agree(&text, &scene));
    assert!(assert_agree(&text.replace('\n', "\r\n"), &scene));
    assert!(assert_agree(&with_errors(&text), &scene));
    assert!(assert_agree(&german(&text), &scene));
    assert!(assert_agree(&german(&text).replace(';', "\t"), &scene));
    // of marks that are mixed the text reader tells where
    assert!(!assert_agree(&german(&text).replacen("0,6482", "0.6482", 1), &scene));
}

#[test]
fn both_readers_mean_the_same_by_every_spelling_of_a_number() {
    let (scene, text) = plain();
    let mut taken = 0;
    for spelling in [
        "1",
        "+1",
        "+1.0",
        "1.",
        ".5",
        "1e-3",
        "1E-3",
        "1e+0",
        "1e0",
        "01",
        "-0",
        "0x1",
        "1_0",
        "1d0",
        "1f",
        "inf",
        "+inf",
        "Infinity",
        "1e999",
        "1e-999",
        "nan",
        "NaN",
        "-nan",
        "NA",
        "na",
        "null",
        "",
        " ",
        " 1",
        "1 ",
        "1 1",
        "1,0",
        "1;0",
        "½",
        "１",
        "1\u{a0}",
        "--1",
        "e1",
        ".",
        "+",
        "1e",
        "0.30000000000000000000001",
        "9007199254740993e-16",
        "2.2250738585072011e-308",
    ] {
        for column in 2..7 {
            let mut cells = ["PTFE", "AK10", "4", "240", "0.06", "0.3", "0.58"];
            cells[column] = spelling;
            taken += usize::from(assert_agree(&format!("{text}{}\n", cells.join(",")), &scene));
        }
    }
    assert!(taken > 40, "the fast reader took only {taken} files");
}

#[test]
fn both_readers_agree_on_files_with_accidents() {
    let (scene, text) = plain();
    let tables = [&with_errors(&text), &text, &german(&text)];
    let mut rng = crate::seed::stream(1, "accidents", 0);
    let accidents = [
        ",", ";", "\n", "\r\n", "\r", " ", "\t", "\"", "0", "9", ".", "-", "+", "e", "NA", "dry", "#", "δ", "\n\n",
        ",,", "1,234",
    ];
    let (mut taken, mut refused) = (0, 0);
    for attempt in 0..12_000 {
        let text = tables[attempt % 3];
        let lines: Vec<&str> = text.lines().collect();
        // a few rows with one or two accidents, so that many still pass
        let first = rng.random_range(1..lines.len() - 4);
        let mut bytes = format!("{}\n{}\n", lines[0], lines[first..first + 4].join("\n"));
        for _ in 0..rng.random_range(1..3) {
            let places: Vec<usize> = bytes.char_indices().map(|(at, _)| at).collect();
            let at = places[rng.random_range(0..places.len())];
            let with = accidents[rng.random_range(0..accidents.len())];
            let cut = rng.random_range(0..2);
            let end = places.iter().copied().find(|end| *end >= at + cut).unwrap_or(at);
            bytes.replace_range(at..end, with);
        }
        match assert_agree(&bytes, &scene) {
            true => taken += 1,
            false => refused += 1,
        }
    }
    assert!(taken > 300 && refused > 3000, "{taken} taken, {refused} refused");
}

#[test]
fn a_damaged_parquet_file_is_refused_or_read_but_never_panics() {
    let (scene, _) = plain();
    let bytes = std::fs::read(example("parquet/runs.parquet")).expect("the example is there");
    assert!(parquet::read_parquet(&bytes, &scene).is_ok());
    let mut rng = crate::seed::stream(1, "damage", 0);
    let mut refused = 0;
    for _ in 0..600 {
        let mut damaged = bytes.clone();
        for _ in 0..rng.random_range(1..6) {
            // the footer, where the structure is described
            let at = rng.random_range(damaged.len() / 3..damaged.len());
            damaged[at] = rng.random();
        }
        refused += usize::from(parquet::read_parquet(&damaged, &scene).is_err());
    }
    assert!(refused > 300, "{refused} refused");
}

/// The runs of a workbook's first sheet.
fn first_sheet(bytes: &[u8], scene: &Scene) -> Result<collect::Collected, Refused> {
    workbook::read_sheet(workbook::Sheet::read(bytes, None)?, scene)
}

#[test]
fn a_damaged_workbook_is_refused_or_read_but_never_panics() {
    let (scene, _) = plain();
    let bytes = std::fs::read(example("workbook/runs.xlsx")).expect("the example is there");
    assert!(first_sheet(&bytes, &scene).is_ok());
    let mut rng = crate::seed::stream(1, "damaged workbook", 0);
    let mut refused = 0;
    for _ in 0..2000 {
        let mut damaged = bytes.clone();
        for _ in 0..rng.random_range(1..6) {
            let at = rng.random_range(0..damaged.len());
            damaged[at] = rng.random();
        }
        if rng.random_bool(0.1) {
            damaged.truncate(rng.random_range(0..damaged.len()));
        }
        refused += usize::from(first_sheet(&damaged, &scene).is_err());
    }
    assert!(refused > 300, "{refused} refused");
}

/// A workbook of one sheet with these rows, in XML.
fn workbook_of(rows: &str) -> Vec<u8> {
    use std::io::Write;
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    const OF_OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const OF_PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006/relationships";
    let files = [
        (
            "_rels/.rels",
            format!(
                "<Relationships xmlns=\"{OF_PACKAGE}\"><Relationship Id=\"a\" Type=\"{OF_OFFICE}/officeDocument\" \
                 Target=\"xl/workbook.xml\"/></Relationships>"
            ),
        ),
        (
            "xl/workbook.xml",
            format!(
                "<workbook xmlns=\"{MAIN}\" xmlns:r=\"{OF_OFFICE}\"><sheets><sheet name=\"S\" sheetId=\"1\" \
                 r:id=\"a\"/></sheets></workbook>"
            ),
        ),
        (
            "xl/_rels/workbook.xml.rels",
            format!(
                "<Relationships xmlns=\"{OF_PACKAGE}\"><Relationship Id=\"a\" Type=\"{OF_OFFICE}/worksheet\" \
                 Target=\"worksheets/s.xml\"/></Relationships>"
            ),
        ),
        (
            "xl/worksheets/s.xml",
            format!("<worksheet xmlns=\"{MAIN}\"><sheetData>{rows}</sheetData></worksheet>"),
        ),
    ];
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(vec![]));
    for (name, text) in files {
        let options = zip::write::SimpleFileOptions::default();
        archive.start_file(name, options).expect("room");
        archive.write_all(text.as_bytes()).expect("room");
    }
    archive.finish().expect("room").into_inner()
}

/// What would fill the memory as a table does not: a cell at the far end of a sheet.
#[test]
fn a_cell_far_out_is_refused_and_fills_no_memory() {
    let (scene, _) = plain();
    let text = |at: &str, text: &str| format!("<c r=\"{at}\" t=\"str\"><v>{text}</v></c>");
    let number = |at: &str, number: &str| format!("<c r=\"{at}\"><v>{number}</v></c>");
    let row = |row: usize, cells: &[String]| format!("<row r=\"{row}\">{}</row>", cells.concat());
    let header = ["particle", "diameter_mm", "impact_speed_m_s", "restitution"];
    let header: Vec<String> = ["A2", "B2", "C2", "D2"]
        .iter()
        .zip(header)
        .map(|(at, name)| text(at, name))
        .collect();
    let run = |at: usize| {
        let cells =
            [("B", "4"), ("C", "1"), ("D", "0.8")].map(|(column, value)| number(&format!("{column}{at}"), value));
        row(at, &[vec![text(&format!("A{at}"), "PTFE")], cells.to_vec()].concat())
    };
    let read = |rows: &str| first_sheet(&workbook_of(rows), &scene);
    let good = format!("{}{}{}", row(2, &header), run(4), run(1_048_576));
    let collected = read(&good).unwrap_or_else(|refused| panic!("{refused:?}"));
    assert_eq!((collected.rows, collected.columns.restitution), (2, vec![0.8, 0.8]));
    let wide = format!("{good}{}", row(1_048_576, &[number("XFD1048576", "7")]));
    let refused = read(&wide).expect_err("too many columns");
    assert!(refused.problems[0].expected.contains("16384 columns"), "{refused:?}");
}

#[test]
fn dry_runs_alone_need_no_film() {
    let (scene, _) = plain();
    for header in [
        "particle,liquid,diameter_mm,impact_speed_m_s,restitution\nPTFE,dry,4,1,0.8\n",
        "particle,diameter_mm,impact_speed_m_s,restitution\nPTFE,4,1,0.8\n",
    ] {
        assert!(assert_agree(header, &scene), "{header}");
    }
    let wet = "particle,liquid,diameter_mm,impact_speed_m_s,restitution\nPTFE,AK10,4,1,0.8\n";
    assert_eq!(both(wet, &scene), (None, None));
}

#[test]
fn two_unknown_columns_of_one_name_shift_nothing() {
    let (scene, text) = plain();
    let doubled: String = text
        .lines()
        .enumerate()
        .map(|(index, line)| {
            let note = if index == 0 { "note" } else { "7" };
            format!("{note},{line},{note}\n")
        })
        .collect();
    assert!(assert_agree(&doubled, &scene));
    let Ok(read) = read_text(doubled.as_bytes(), b',', &scene) else {
        panic!("it is read");
    };
    let Ok(reference) = read_text(text.as_bytes(), b',', &scene) else {
        panic!("it is read");
    };
    assert_eq!(format!("{:?}", read.columns), format!("{:?}", reference.columns));
}

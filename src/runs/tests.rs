use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};

use rand::RngExt;

use super::collect::Collected;
use super::parquet::ParquetTable;
use super::*;
use crate::error::Problems;
use crate::scene;

/// The examples of `headers/examples.txt` that a question is asked of, by their answer.
pub(super) fn examples(question: &str) -> Vec<(&'static str, Vec<&'static str>)> {
    let of_line = |line: &'static str| {
        let line = line.strip_prefix(question)?.strip_prefix(' ')?;
        let (answer, written) = line.split_once(": ").expect("an answer and its examples");
        Some((answer, written.split(" | ").collect()))
    };
    let found: Vec<_> = include_str!("headers/examples.txt")
        .lines()
        .filter_map(of_line)
        .collect();
    assert!(!found.is_empty(), "{question}");
    found
}

fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/good").join(name)
}

pub(super) fn plain() -> (Scene, String) {
    let scene = scene::read(&example("plain/scene.toml")).unwrap_or_else(|error| panic!("{error}"));
    let text = std::fs::read_to_string(example("plain/runs.csv")).expect("the example is there");
    (scene, text)
}

fn read_parquet(bytes: &[u8], scene: &Scene) -> Result<Collected, Problems> {
    let mut file = tempfile::tempfile().expect("a file");
    file.write_all(bytes).expect("room for it");
    let table = ParquetTable::open(&file)?;
    parquet::read_parquet(&table, scene, None)
}

fn read_csv(text: &str, scene: &Scene) -> Result<Collected, Problems> {
    let separator = csv::separator(text.as_bytes(), &scene.data.naming).expect("a line");
    let table = records::Records::new(text.as_bytes(), separator).expect("it is read");
    table.runs(scene, None)
}

#[test]
fn unknown_columns_of_one_name_shift_nothing() {
    let (scene, text) = plain();
    let columns = |text: &str| {
        let collected = read_csv(text, &scene).unwrap_or_else(|refused| panic!("{text:?}: {refused:?}"));
        format!("{:?}", collected.in_use)
    };
    let noted = |(index, line): (usize, &str)| {
        let note = if index == 0 { "note" } else { "7" };
        format!("{note},{line},{note}\n")
    };
    let doubled: String = text.lines().enumerate().map(noted).collect();
    assert_eq!(columns(&doubled), columns(&text));
}

#[test]
fn a_damaged_parquet_file_is_refused_or_read_but_never_panics() {
    let (scene, _) = plain();
    let bytes = std::fs::read(example("parquet/runs.parquet")).expect("the example is there");
    assert!(read_parquet(&bytes, &scene).is_ok());
    let mut rng = crate::seed::stream(1, "damage", 0);
    let (mut refused, mut whole) = (0, 0);
    for _ in 0..600 {
        let mut damaged = bytes.clone();
        for _ in 0..rng.random_range(1..6) {
            // the footer, where the structure is described
            let at = rng.random_range(damaged.len() / 3..damaged.len());
            damaged[at] = rng.random();
        }
        match read_parquet(&damaged, &scene) {
            Ok(_) => whole += 1,
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 300 && whole > 10, "{refused} refused, {whole} not");
}

/// Else each would take room on the stack, which ends the process.
#[test]
fn lists_within_lists_without_end_are_a_broken_footer() {
    let (scene, _) = plain();
    let lists = vec![0x19; 1 << 20];
    let length = (lists.len() as u32).to_le_bytes();
    let bytes = [&b"PAR1"[..], &lists, &length, b"PAR1"].concat();
    let refused = read_parquet(&bytes, &scene).expect_err("no footer");
    assert_eq!(refused.first[0].expected, "its footer is broken");
}

/// The runs of a workbook's first sheet.
fn first_sheet(bytes: &[u8], scene: &Scene) -> Result<Collected, Problems> {
    let mut book = Workbook::open(bytes)?;
    let sheet = book.sheet(None)?;
    workbook::read_sheet(sheet, scene)
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

/// The workbook of the example with these rows, in XML, in its first sheet.
fn workbook_of(rows: &str) -> Vec<u8> {
    const SHEET: &str = "xl/worksheets/sheet1.xml";
    const MAIN: &str = "http://schemas.openxmlformats.org/spreadsheetml/2006/main";
    let bytes = std::fs::read(example("workbook/runs.xlsx")).expect("the example is there");
    let mut of_example = zip::ZipArchive::new(Cursor::new(bytes)).expect("a workbook");
    let mut archive = zip::ZipWriter::new(Cursor::new(vec![]));
    for place in 0..of_example.len() {
        let part = of_example.by_index_raw(place).expect("a part");
        if part.name().expect("text") != SHEET {
            archive.raw_copy_file(part).expect("room");
        }
    }
    let options = zip::write::SimpleFileOptions::default();
    archive.start_file(SHEET, options).expect("room");
    let sheet = format!("<worksheet xmlns=\"{MAIN}\"><sheetData>{rows}</sheetData></worksheet>");
    archive.write_all(sheet.as_bytes()).expect("room");
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
    let restitutions: Vec<f64> = collected.in_use.iter().map(|run| run.restitution).collect();
    assert_eq!((collected.rows, restitutions), (2, vec![0.8, 0.8]));
    // a row holds what is there, and not what might be beside it
    let far = |at: usize| row(at, &[number(&format!("A{at}"), "7"), number(&format!("EZZ{at}"), "7")]);
    let far = format!("{}{}", row(2, &header), (3..2000).map(far).collect::<String>());
    let bytes = workbook_of(&far);
    let mut book = Workbook::open(&bytes).expect("a workbook");
    let mut sheet = book.sheet(None).expect("a sheet");
    sheet.header(&scene.data.naming).expect("a header");
    let mut rows = 0;
    while let Some(row) = sheet.next_row().expect("rows") {
        assert_eq!(row.cells.len(), 2);
        rows += 1;
    }
    assert_eq!(rows, 1997);
    let wide = format!("{good}{}", row(1_048_576, &[number("XFD1048576", "7")]));
    let refused = read(&wide).expect_err("too many columns");
    assert!(refused.first[0].expected.contains("16384 columns"), "{refused:?}");
}

/// By the digits that are written, 0.42 over 0.50 may be 0.82 to 0.86.
#[test]
fn a_restitution_agrees_with_speeds_as_far_as_their_digits_tell() {
    let (scene, _) = plain();
    for (row, is_read) in [
        ("PTFE,4.762,0.50,0.43,0.84", true),
        ("PTFE,4.762,0.50,0.42,0.86", true),
        ("PTFE,4.762,0.50,0.42,0.87", false),
        ("PTFE,4.762,0.500,0.420,0.85", false),
        ("PTFE,4.762,0.500,0.420,0.842", true),
        ("PTFE,4.762,0.5,0.4,0.86", false),
    ] {
        let table = format!("particle,diameter_mm,impact_speed_m_s,rebound_speed_m_s,restitution\n{row}\n");
        assert_eq!(read_csv(&table, &scene).is_ok(), is_read, "{table}");
    }
}

/// A total at the foot is no run; what is called so from the first run on is a name.
#[test]
fn a_word_for_all_runs_labels_a_row_unless_it_is_a_name() {
    let (scene, _) = plain();
    let rows_of = |cells: &str| {
        let row = |name: &str| format!("{name},PTFE,4.762,1.0,0.8\n");
        let rows: String = cells.split(' ').map(row).collect();
        let table = format!("block,particle,diameter_mm,impact_speed_m_s,restitution\n{rows}");
        let collected = read_csv(&table, &scene).unwrap_or_else(|refused| panic!("{cells}: {refused:?}"));
        collected.in_use.len()
    };
    for (cells, runs) in [
        ("1 2 3 all", 3),
        ("1 2 Tous 1 2 TOUS", 4),
        ("1 2 Σ", 2),
        ("all all all", 3),
        ("all left right all", 4),
        ("all all mean", 2),
    ] {
        assert_eq!(rows_of(cells), runs, "{cells}");
    }
}

/// By its digits a height of 0.49 mm may be 0.485 mm, which lies in a film of 486 µm.
#[test]
fn a_run_that_stuck_may_have_come_to_rest_at_the_surface_of_its_film() {
    let (scene, _) = plain();
    for (film, height, is_read) in [
        ("485.8", "0.49", true),
        ("485.8", "0.490", false),
        ("450", "0.49", false),
    ] {
        let table = format!(
            "particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution,rebound_height_mm\n\
             PTFE,AK10,4.762,{film},0.5,0,{height}\n"
        );
        assert_eq!(read_csv(&table, &scene).is_ok(), is_read, "{table}");
    }
}

#[test]
fn a_zero_has_no_sign_and_what_is_too_small_is_none() {
    let (scene, _) = plain();
    let read = |restitution: &str| {
        let table = format!("particle,diameter_mm,impact_speed_m_s,restitution\nPTFE,4.762,1.0,{restitution}\n");
        read_csv(&table, &scene)
    };
    let collected = read("-0.0").unwrap_or_else(|refused| panic!("{refused:?}"));
    assert_eq!(collected.in_use[0].restitution.to_bits(), 0);
    let refused = read("1e-400").expect_err("it is not 0");
    assert!(refused.first[0].expected.contains("not so small"), "{refused:?}");
}

#[test]
fn a_word_that_leaves_out_most_runs_is_told() {
    let (scene, _) = plain();
    let told = |words: &str| {
        let row = |word: &str| format!("PTFE,4.762,1.0,0.8,{word}\n");
        let rows: String = words.split(' ').map(|word| row(word.trim_matches('_'))).collect();
        let table = format!("particle,diameter_mm,impact_speed_m_s,restitution,exclude\n{rows}");
        let collected = read_csv(&table, &scene).unwrap_or_else(|refused| panic!("{words}: {refused:?}"));
        collected.excluded_most(Path::new("runs.csv")).map(|remark| remark.text)
    };
    let expected = "runs.csv: `✔` in the column `exclude` leaves out 2 of 3 runs";
    assert_eq!(told("✔ splash ✔").as_deref(), Some(expected));
    for few in ["✔ _ splash _", "splash _", "a b c"] {
        assert_eq!(told(few), None, "{few}");
    }
}

#[test]
fn a_single_run_that_rebounds_faster_is_one() {
    let (scene, _) = plain();
    let table = "particle,diameter_mm,impact_speed_m_s,restitution\nPTFE,4.762,1.0,1.05\nPTFE,4.762,1.0,0.8\n";
    let collected = read_csv(table, &scene).unwrap_or_else(|refused| panic!("{refused:?}"));
    let text = collected.above_one().expect("one is above 1").text;
    assert!(text.starts_with("1 run rebounded faster than it fell"), "{text}");
}

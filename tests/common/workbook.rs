//! Writes small workbooks for tests, with what a spreadsheet may hide.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::ZipWriter;

/// What a cell holds.
#[derive(Debug, Clone)]
pub enum Cell {
    Empty,
    Number(f64),
    Text(String),
}

/// A sheet of a workbook.
#[derive(Debug, Clone)]
pub struct Sheet {
    pub name: &'static str,
    pub is_hidden: bool,
    /// rows of cells, from row 1 on
    pub rows: Vec<Vec<Cell>>,
    /// numbers of hidden rows
    pub hidden_rows: Vec<usize>,
    /// numbers of hidden columns, from 1
    pub hidden_columns: Vec<usize>,
    /// cells that are merged, as `B2:B5`
    pub merged: Vec<String>,
}

impl Sheet {
    /// Rows of cells with commas between them; what looks like a number is one.
    pub fn of(name: &'static str, text: &str) -> Sheet {
        let cell = |cell: &str| match (cell, cell.parse()) {
            ("", _) => Cell::Empty,
            (_, Ok(number)) => Cell::Number(number),
            _ => Cell::Text(cell.to_owned()),
        };
        Sheet {
            name,
            is_hidden: false,
            rows: text.lines().map(|line| line.split(',').map(cell).collect()).collect(),
            hidden_rows: vec![],
            hidden_columns: vec![],
            merged: vec![],
        }
    }

    fn xml(&self) -> String {
        let mut xml = String::from(r#"<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main">"#);
        if !self.hidden_columns.is_empty() {
            let column = |number: &usize| {
                let hidden = ["hidden=\"1\" width=\"9\"", "width=\"0\""][number % 2];
                format!(r#"<col min="{number}" max="{number}" {hidden}/>"#)
            };
            let columns: String = self.hidden_columns.iter().map(column).collect();
            xml.push_str(&format!("<cols>{columns}</cols>"));
        }
        xml.push_str("<sheetData>");
        for (row, number) in self.rows.iter().zip(1..) {
            let hidden = match (self.hidden_rows.contains(&number), number % 2) {
                (true, 0) => r#" ht="0" customHeight="1""#,
                (true, _) => r#" hidden="1""#,
                (false, _) => "",
            };
            xml.push_str(&format!(r#"<row r="{number}"{hidden}>"#));
            for (cell, column) in row.iter().zip(0..) {
                let place = format!("{}{number}", letters(column));
                match cell {
                    Cell::Empty => {}
                    Cell::Number(value) => xml.push_str(&format!(r#"<c r="{place}"><v>{value}</v></c>"#)),
                    Cell::Text(text) => xml.push_str(&format!(
                        r#"<c r="{place}" t="inlineStr"><is><t>{}</t></is></c>"#,
                        escaped(text)
                    )),
                }
            }
            xml.push_str("</row>");
        }
        xml.push_str("</sheetData>");
        if !self.merged.is_empty() {
            let each = self.merged.iter().map(|cells| format!(r#"<mergeCell ref="{cells}"/>"#));
            xml.push_str(&format!("<mergeCells>{}</mergeCells>", each.collect::<String>()));
        }
        xml + "</worksheet>"
    }
}

fn letters(column: usize) -> String {
    let letter = char::from(b'A' + (column % 26) as u8);
    match column / 26 {
        0 => letter.to_string(),
        more => format!("{}{letter}", letters(more - 1)),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// A workbook of some sheets.
pub fn workbook(sheets: &[Sheet]) -> Vec<u8> {
    const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006";
    const TYPE: &str = "application/vnd.openxmlformats-officedocument.spreadsheetml";
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    let mut add = |path: &str, text: &str| {
        zip.start_file(path, SimpleFileOptions::default()).expect("a new file");
        zip.write_all(text.as_bytes()).expect("room");
    };
    let (mut types, mut listed, mut relations) = (String::new(), String::new(), String::new());
    for (sheet, at) in sheets.iter().zip(1..) {
        let (name, state) = (
            escaped(sheet.name),
            if sheet.is_hidden { r#" state="hidden""# } else { "" },
        );
        types += &format!(r#"<Override PartName="/xl/worksheets/sheet{at}.xml" ContentType="{TYPE}.worksheet+xml"/>"#);
        listed += &format!(r#"<sheet name="{name}" sheetId="{at}"{state} r:id="rId{at}"/>"#);
        relations +=
            &format!(r#"<Relationship Id="rId{at}" Type="{OFFICE}/worksheet" Target="worksheets/sheet{at}.xml"/>"#);
        add(&format!("xl/worksheets/sheet{at}.xml"), &sheet.xml());
    }
    let of_package = format!(
        r#"<Types xmlns="{PACKAGE}/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Override PartName="/xl/workbook.xml" ContentType="{TYPE}.sheet.main+xml"/>{types}</Types>"#
    );
    let root = format!(r#"<Relationship Id="rId1" Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/>"#);
    let book = format!(
        r#"<workbook xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main" xmlns:r="{OFFICE}"><sheets>{listed}</sheets></workbook>"#
    );
    let related =
        |relations: &str| format!(r#"<Relationships xmlns="{PACKAGE}/relationships">{relations}</Relationships>"#);
    add("[Content_Types].xml", &of_package);
    add("_rels/.rels", &related(&root));
    add("xl/workbook.xml", &book);
    add("xl/_rels/workbook.xml.rels", &related(&relations));
    zip.finish().expect("room").into_inner()
}

//! Writes a workbook that a text describes, with what a spreadsheet may hide.
//!
//! A sheet begins with a line such as `== May | hidden | rows 3 4 | columns 2 5 | merged E14:E25 | formats 3:0.0"mm" 4:0%`, of
//! which only the name must be there; below stand its rows, with commas between cells. What looks like a number is one.

use std::io::{Cursor, Write};

use zip::write::SimpleFileOptions;
use zip::ZipWriter;

/// A sheet as the text describes it.
struct Sheet<'t> {
    name: &'t str,
    /// what stands beside the name
    marks: Vec<&'t str>,
    rows: Vec<&'t str>,
}

impl<'t> Sheet<'t> {
    fn of(text: &'t str) -> Sheet<'t> {
        let mut lines = text.lines();
        let mut head = lines.next().expect("a name").split(" | ");
        Sheet {
            name: head.next().expect("a name"),
            marks: head.collect(),
            rows: lines.collect(),
        }
    }

    /// The words behind a mark.
    fn marked(&self, mark: &str) -> Vec<&'t str> {
        let own = self.marks.iter().find_map(|own| own.strip_prefix(mark));
        own.unwrap_or_default().split_whitespace().collect()
    }

    /// Columns with a number format, each with its code.
    fn formats(&self) -> impl Iterator<Item = (&'t str, &'t str)> {
        let each = self.marked("formats").into_iter();
        each.map(|format| format.split_once(':').expect("a column and a format"))
    }

    /// The sheet, whose formats come after so many others.
    fn xml(&self, others: usize) -> String {
        let mut xml = String::from(r#"<worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main">"#);
        let columns = self.marked("columns");
        if !columns.is_empty() {
            let column = |(place, number): (usize, &&str)| {
                let hidden = ["hidden=\"1\" width=\"9\"", "width=\"0\""][place % 2];
                format!(r#"<col min="{number}" max="{number}" {hidden}/>"#)
            };
            let columns: String = columns.iter().enumerate().map(column).collect();
            xml.push_str(&format!("<cols>{columns}</cols>"));
        }
        xml.push_str("<sheetData>");
        let hidden_rows = self.marked("rows");
        for (row, number) in self.rows.iter().zip(1..) {
            let hidden = match (hidden_rows.contains(&number.to_string().as_str()), number % 2) {
                (true, 0) => r#" ht="0" customHeight="1""#,
                (true, _) => r#" hidden="1""#,
                (false, _) => "",
            };
            xml.push_str(&format!(r#"<row r="{number}"{hidden}>"#));
            for (cell, column) in row.split(',').zip(0..).filter(|(cell, _)| !cell.is_empty()) {
                let place = format!("{}{number}", letters(column));
                let own = self.formats().position(|(own, _)| own == (column + 1).to_string());
                let style = own.map_or(0, |own| others + own + 1);
                xml.push_str(&match cell.parse::<f64>() {
                    Ok(_) => format!(r#"<c r="{place}" s="{style}"><v>{cell}</v></c>"#),
                    Err(_) => format!(r#"<c r="{place}" t="inlineStr"><is><t>{}</t></is></c>"#, escaped(cell)),
                });
            }
            xml.push_str("</row>");
        }
        xml.push_str("</sheetData>");
        let merged = self.marked("merged");
        if !merged.is_empty() {
            let each = merged.iter().map(|cells| format!(r#"<mergeCell ref="{cells}"/>"#));
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

/// The workbook of a text.
pub fn workbook(text: &str) -> Vec<u8> {
    const OFFICE: &str = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
    const PACKAGE: &str = "http://schemas.openxmlformats.org/package/2006";
    const TYPE: &str = "application/vnd.openxmlformats-officedocument.spreadsheetml";
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    let mut add = |path: &str, text: &str| {
        zip.start_file(path, SimpleFileOptions::default()).expect("a new file");
        zip.write_all(text.as_bytes()).expect("room");
    };
    let (mut types, mut listed, mut relations) = (String::new(), String::new(), String::new());
    let mut codes: Vec<&str> = vec![];
    for (text, at) in text.split("== ").skip(1).zip(1..) {
        let sheet = Sheet::of(text);
        let name = escaped(sheet.name);
        let state = if sheet.marks.contains(&"hidden") {
            r#" state="hidden""#
        } else {
            ""
        };
        types += &format!(r#"<Override PartName="/xl/worksheets/sheet{at}.xml" ContentType="{TYPE}.worksheet+xml"/>"#);
        listed += &format!(r#"<sheet name="{name}" sheetId="{at}"{state} r:id="rId{at}"/>"#);
        relations +=
            &format!(r#"<Relationship Id="rId{at}" Type="{OFFICE}/worksheet" Target="worksheets/sheet{at}.xml"/>"#);
        add(&format!("xl/worksheets/sheet{at}.xml"), &sheet.xml(codes.len()));
        codes.extend(sheet.formats().map(|(_, code)| code));
    }
    let each = || codes.iter().zip(164..);
    let formats = each().map(|(code, id)| format!(r#"<numFmt numFmtId="{id}" formatCode="{}"/>"#, escaped(code)));
    let styles = each().map(|(_, id)| format!(r#"<xf numFmtId="{id}"/>"#));
    let styles = format!(
        r#"<styleSheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><numFmts>{}</numFmts><cellXfs><xf numFmtId="0"/>{}</cellXfs></styleSheet>"#,
        formats.collect::<String>(),
        styles.collect::<String>()
    );
    add("xl/styles.xml", &styles);
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

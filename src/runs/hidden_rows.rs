//! Finds the rows of a sheet that its workbook hides, by a filter, by hand or by a height of 0. The only file that names quick-xml.

use std::io::{BufReader, Cursor};

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use quick_xml::XmlVersion;

use super::refusals::readable;
use crate::error::Problem;

type Archive<'b> = zip::ZipArchive<Cursor<&'b [u8]>>;

/// The numbers of the hidden rows of a sheet, from 1, ascending. The sheet is read as a stream.
pub(super) fn hidden_rows(bytes: &[u8], sheet: &str) -> Result<Vec<u64>, Vec<Problem>> {
    readable("workbook", || {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
        let book = target(&mut archive, "_rels/.rels", |relation| {
            value(relation, "Type").is_some_and(|of| of.ends_with("/officeDocument"))
        })?;
        let book = book.unwrap_or_else(|| "xl/workbook.xml".to_owned());
        let mut id = None;
        each_start(&mut archive, &book, "sheet", |of_sheet| {
            if value(of_sheet, "name").as_deref() == Some(sheet) {
                id = value(of_sheet, "id");
            }
        })?;
        let (folder, file) = book.rsplit_once('/').unwrap_or(("", &book));
        let relations = format!("{folder}/_rels/{file}.rels");
        let found = target(&mut archive, &relations, |relation| value(relation, "Id") == id)?;
        let path = match found.as_deref().map(|path| (path, path.strip_prefix('/'))) {
            Some((_, Some(from_root))) => from_root.to_owned(),
            Some((path, None)) => format!("{folder}/{}", path.trim_start_matches("./")),
            None => return Err(format!("it does not say where its sheet {sheet} is")),
        };
        let mut hidden = vec![];
        let mut number = 0;
        each_start(&mut archive, &path, "row", |row| {
            let given = value(row, "r").and_then(|number| number.parse().ok());
            number = given.unwrap_or(number + 1);
            let is_hidden = value(row, "hidden").is_some_and(|hidden| hidden == "1" || hidden == "true");
            let is_flat = value(row, "ht").is_some_and(|height| height.parse() == Ok(0.0));
            if is_hidden || is_flat {
                hidden.push(number);
            }
        })?;
        hidden.sort_unstable();
        Ok(hidden)
    })
}

/// Where the first relation of a kind leads.
fn target(archive: &mut Archive, path: &str, is_meant: impl Fn(&BytesStart) -> bool) -> Result<Option<String>, String> {
    let mut found = None;
    each_start(archive, path, "Relationship", |relation| {
        if found.is_none() && is_meant(relation) {
            found = value(relation, "Target");
        }
    })?;
    Ok(found)
}

/// Goes through the elements of a name in a part of the workbook.
fn each_start(archive: &mut Archive, path: &str, name: &str, mut each: impl FnMut(&BytesStart)) -> Result<(), String> {
    let wanted = path.trim_start_matches('/').to_lowercase();
    let at = (0..archive.len()).find(|at| {
        let own = archive.name_for_index(*at).and_then(Result::ok).unwrap_or_default();
        own.replace('\\', "/").to_lowercase() == wanted
    });
    let at = at.ok_or_else(|| format!("it lacks {path}"))?;
    let part = archive.by_index(at).map_err(|error| error.to_string())?;
    let mut reader = Reader::from_reader(BufReader::new(part));
    reader.config_mut().check_end_names = false;
    let mut buffer = vec![];
    loop {
        match reader.read_event_into(&mut buffer).map_err(|error| error.to_string())? {
            Event::Start(start) | Event::Empty(start) if start.local_name().as_ref() == name => each(&start),
            Event::Eof => return Ok(()),
            _ => {}
        }
        buffer.clear();
    }
}

/// What an element says under a name, whatever its namespace.
fn value(of: &BytesStart, name: &str) -> Option<String> {
    let mut all = of.attributes();
    let mut attributes = all.with_checks(false).flatten();
    let attribute = attributes.find(|own| own.key.local_name().as_ref() == name)?;
    let value = attribute.normalized_value(XmlVersion::Implicit1_0).ok()?;
    Some(value.into_owned())
}

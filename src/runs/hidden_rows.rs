//! Finds the rows and columns of a sheet that its workbook hides, by a filter, by hand or by a size of 0. The only file that
//! names quick-xml.

use std::io::{BufReader, Cursor};
use std::ops::RangeInclusive;

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use quick_xml::XmlVersion;

use super::refusals::readable;
use crate::error::Problem;

type Archive<'b> = zip::ZipArchive<Cursor<&'b [u8]>>;

/// What a sheet hides.
pub(super) struct Hidden {
    /// numbers of rows, from 1, ascending
    pub rows: Vec<u64>,
    /// numbers of columns, from 1
    pub columns: Vec<RangeInclusive<usize>>,
}

/// What a sheet hides, which is read as a stream.
pub(super) fn hidden_in(bytes: &[u8], sheet: &str) -> Result<Hidden, Vec<Problem>> {
    readable("workbook", || {
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
        let book = target(&mut archive, "_rels/.rels", |relation| {
            value(relation, "Type").is_some_and(|of| of.ends_with("/officeDocument"))
        })?;
        let book = book.unwrap_or_else(|| "xl/workbook.xml".to_owned());
        let mut id = None;
        each_start(&mut archive, &book, &["sheet"], |of_sheet| {
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
        let (mut rows, mut columns) = (vec![], vec![]);
        let mut number = 0;
        each_start(&mut archive, &path, &["row", "col"], |line| {
            let given = |name: &str| value(line, name)?.parse().ok();
            let is_column = line.local_name().as_ref() == "col";
            let is_hidden = value(line, "hidden").is_some_and(|hidden| hidden == "1" || hidden == "true");
            let size = if is_column { "width" } else { "ht" };
            let is_hidden = is_hidden || value(line, size).is_some_and(|size| size.parse() == Ok(0.0));
            if is_column {
                let ends = given("min").zip(given("max")).filter(|_| is_hidden);
                columns.extend(ends.map(|(first, last)| first as usize..=last as usize));
                return;
            }
            number = given("r").unwrap_or(number + 1);
            if is_hidden {
                rows.push(number);
            }
        })?;
        rows.sort_unstable();
        Ok(Hidden { rows, columns })
    })
}

/// Where the first relation of a kind leads.
fn target(archive: &mut Archive, path: &str, is_meant: impl Fn(&BytesStart) -> bool) -> Result<Option<String>, String> {
    let mut found = None;
    each_start(archive, path, &["Relationship"], |relation| {
        if found.is_none() && is_meant(relation) {
            found = value(relation, "Target");
        }
    })?;
    Ok(found)
}

/// Goes through the elements of some names in a part of the workbook.
fn each_start(
    archive: &mut Archive,
    path: &str,
    names: &[&str],
    mut each: impl FnMut(&BytesStart),
) -> Result<(), String> {
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
            Event::Start(start) | Event::Empty(start) if names.contains(&start.local_name().as_ref()) => each(&start),
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

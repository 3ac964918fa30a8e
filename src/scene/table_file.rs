//! Names a table of runs: its file, and the sheet of a workbook.

use std::path::{Path, PathBuf};

/// A table of runs.
#[derive(Debug, Clone, PartialEq)]
pub struct TableFile {
    /// the file
    pub path: PathBuf,
    /// which sheet of a workbook; absent: the first that is not hidden
    pub sheet: Option<String>,
}

impl TableFile {
    /// What ends the name of a workbook.
    pub const WORKBOOK: &str = ".xlsx";

    /// What the name of a table may end with.
    const ENDINGS: [&str; 5] = [".csv", ".tsv", ".txt", TableFile::WORKBOOK, ".parquet"];

    /// What is expected of its name.
    pub const ENDING_EXPECTED: &str = "a file ending in .csv, .tsv, .txt, .xlsx or .parquet";

    /// Whether its name says that it is a table.
    pub fn has_known_ending(&self) -> bool {
        TableFile::ENDINGS.iter().any(|ending| self.ends_with(ending))
    }

    /// Whether both are one sheet or file, by whatever path or link.
    pub fn is_same_as(&self, other: &TableFile) -> bool {
        let place = |file: &TableFile| std::fs::canonicalize(&file.path).unwrap_or_else(|_| file.path.clone());
        self.sheet == other.sheet && place(self) == place(other)
    }

    /// The table that a scene names; the name of a sheet, which has no slash, stands after that of its workbook.
    pub fn named(folder: Option<&Path>, name: &str) -> TableFile {
        let lower = name.to_ascii_lowercase();
        let last = name.rfind('/').map_or(0, |slash| slash + 1);
        let sheet_at = lower[last..]
            .find(&format!("{}#", TableFile::WORKBOOK))
            .map(|at| last + at + TableFile::WORKBOOK.len());
        let (file, sheet) = match sheet_at {
            Some(at) => (&name[..at], Some(name[at + 1..].to_owned())),
            None => (name, None),
        };
        TableFile {
            path: folder.map_or_else(|| PathBuf::from(file), |folder| folder.join(file)),
            sheet,
        }
    }

    /// The table that a command line names: a path that exists as it is given, or is no text, names no sheet.
    pub fn given(path: &Path) -> TableFile {
        match path.to_str() {
            Some(name) if path.symlink_metadata().is_err() => TableFile::named(None, name),
            _ => path.to_path_buf().into(),
        }
    }

    /// The same file, with a sheet of it.
    pub fn of_sheet(&self, sheet: &str) -> TableFile {
        TableFile {
            path: self.path.clone(),
            sheet: Some(sheet.to_owned()),
        }
    }

    /// As the scene names it.
    pub fn shown(&self) -> PathBuf {
        match &self.sheet {
            Some(sheet) => {
                let mut name = self.path.clone().into_os_string();
                name.push(format!("#{sheet}"));
                name.into()
            }
            None => self.path.clone(),
        }
    }

    /// Whether a file has an ending that only tables have.
    pub(super) fn is_named_as_one(path: &Path) -> bool {
        let file = TableFile::from(path.to_path_buf());
        TableFile::ENDINGS
            .iter()
            .any(|ending| *ending != ".txt" && file.ends_with(ending))
    }

    /// Whether it is a file of this ending.
    pub fn ends_with(&self, ending: &str) -> bool {
        let name = self.path.file_name().map(|name| name.to_string_lossy().to_lowercase());
        name.is_some_and(|name| name.ends_with(ending))
    }
}

impl From<PathBuf> for TableFile {
    fn from(path: PathBuf) -> TableFile {
        TableFile { path, sheet: None }
    }
}

//! Runs `wetcor new`: drafts a scene from a table of runs.

use std::path::{Component, Path, PathBuf};

use clap::Args;
use wetcor::error::{named, plain, quoted, Error};
use wetcor::runs::{draft_scene, Draft};
use wetcor::scene::TableFile;
use wetcor::staging::{self, Staging};

use super::messages::print_after_writing;
use crate::progress::Progress;

/// How the file is called where nothing else is asked for, beside the table.
const SCENE: &str = "scene.toml";

/// Columns that the summary names of those that are not read.
const MOST_SHOWN: usize = 20;

#[derive(Args)]
#[command(after_help = include_str!("help/new.txt").trim_ascii_end())]
pub(super) struct New {
    /// The table: .csv, .tsv, .txt, .parquet or .xlsx (`book.xlsx#May` for another than the first sheet)
    table: PathBuf,
    /// File to write [default: scene.toml beside the table]
    #[arg(long)]
    out: Option<PathBuf>,
}

pub(super) fn new(request: &New) -> Result<u8, Error> {
    let table = request.table.as_path();
    if table.to_str().is_none() {
        let text = "a scene cannot name it: expected a path that is UTF-8";
        return Err(Error::Usage(format!("{}: {text}", named(table))));
    }
    let table = TableFile::given(table);
    if !table.has_known_ending() {
        let text = format!("{}: expected {}", named(&table.path), TableFile::ENDING_EXPECTED);
        return Err(Error::Usage(text));
    }
    let out = request.out.clone();
    let out = out.unwrap_or_else(|| table.path.with_file_name(SCENE));
    let place = staging::prepare(&out)?;
    // a scene is somebody's work
    place.check_free("file")?;
    let folder = place.path().parent().unwrap_or(Path::new(""));
    if !folder.is_dir() {
        let reason = format!("there is no folder {}", folder.display());
        return Err(Error::io(
            &out,
            "write",
            std::io::Error::new(std::io::ErrorKind::NotFound, reason),
        ));
    }
    let progress = Progress::spinner("read");
    let draft = draft_scene(&table, &from_folder(folder, &table.shown()));
    drop(progress);
    let draft = draft?;
    let staging = Staging::beside(&place)?;
    staging.write(draft.text.as_bytes())?;
    staging.put(|place| place.check_free("file"))?;
    print_after_writing(&out, &summary(&draft, &out))?;
    Ok(0)
}

/// How a scene in a folder names a file, with slashes.
fn from_folder(folder: &Path, file: &Path) -> String {
    let whole = |path: &Path| {
        let folder = path.parent().filter(|parent| !parent.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
        Some(folder.join(path.file_name()?))
    };
    let (Some(file), Ok(folder)) = (whole(file), folder.canonicalize()) else {
        return file.to_string_lossy().into_owned();
    };
    let shared = folder
        .components()
        .zip(file.components())
        .take_while(|(a, b)| a == b)
        .count();
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(file.components().skip(shared)).collect();
    let parts = path.components().map(|part| part.as_os_str().to_string_lossy());
    parts.collect::<Vec<_>>().join("/")
}

/// What was found and guessed, and what is still to be done.
fn summary(draft: &Draft, out: &Path) -> String {
    let one_line = |text: &String| plain(text, usize::MAX);
    let list = |words: &[String]| words.iter().map(one_line).collect::<Vec<_>>().join(", ");
    let mut text = format!(
        "{}: {} rows; particles {}",
        named(out),
        draft.rows,
        list(&draft.particles)
    );
    if draft.may_be_wet {
        text.push_str("; no liquid known");
    } else if draft.liquids.is_empty() {
        text.push_str("; every run is dry");
    } else {
        text.push_str(&format!("; liquids {}", list(&draft.liquids)));
    }
    if !draft.sheets.is_empty() {
        let noun = if draft.sheets.len() == 1 { "sheet" } else { "sheets" };
        text.push_str(&format!("; {noun} {}", list(&draft.sheets)));
    }
    text.push('\n');
    for guessed in &draft.guessed {
        text.push_str(&format!("guessed: {}\n", one_line(guessed)));
    }
    if !draft.unused.is_empty() {
        let shown = draft.unused.iter().take(MOST_SHOWN).map(|column| quoted(column));
        let more = draft.unused.len().saturating_sub(MOST_SHOWN);
        let more = match more {
            0 => String::new(),
            _ => format!(" and {more} more"),
        };
        text.push_str(&format!(
            "columns not read: {}{more}\n",
            shown.collect::<Vec<_>>().join(", ")
        ));
    }
    for key in &draft.to_fill_in {
        text.push_str(&format!("to fill in: {}\n", one_line(key)));
    }
    let out = named(out);
    let out = if out.contains(' ') { format!("\"{out}\"") } else { out };
    text.push_str(&format!("then: wetcor check {out}\n"));
    text
}

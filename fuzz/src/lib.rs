//! Keeps what the fuzz targets share: a scene, a place for a table, and what an error must look like.

use std::path::PathBuf;
use std::sync::OnceLock;

use wetcor::error::Error;
use wetcor::runs::{self, Table};
use wetcor::scene::{self, Scene, TableFile};

/// The scene that tables are read against; like that of the kept inputs.
pub const SCENE: &str = include_str!("../../tests/data/good/plain/scene.toml");

/// A scene whose table of runs is a file of this process.
pub struct Place {
    pub scene: Scene,
}

/// A folder of this process.
pub fn folder() -> &'static PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let folder = std::env::temp_dir().join(format!("wetcor-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a temporary folder");
        folder
    })
}

impl Place {
    /// A scene that is known to be good, with a table of some name.
    pub fn with(scene: &str, runs: &str) -> Place {
        let mut place = Place::of(scene).expect("a good scene");
        place.scene.data.runs = vec![folder().join(runs).into()];
        place
    }

    /// A scene that may be bad; its table is a CSV.
    pub fn of(scene: &str) -> Option<Place> {
        let mut scene = scene::parse(scene, &folder().join("scene.toml"), String::new()).ok()?;
        scene.data.runs = vec![folder().join("runs.csv").into()];
        Some(Place { scene })
    }

    pub fn read(&self, bytes: &[u8]) -> Result<Table, Error> {
        std::fs::write(&self.scene.data.runs[0].path, bytes).expect("the folder is writable");
        runs::read(&self.scene)
    }
}

/// All that a table holds, without its hash; or its error.
pub fn outcome(read: &Result<Table, Error>) -> String {
    match read {
        Ok(table) => format!("{:?}", (&table.runs, table.rows, &table.screened, &table.notices)),
        Err(error) => error.to_string(),
    }
}

/// An error names its file, and the sheet of a workbook after it; no line of it holds a control character.
pub fn assert_told(error: &Error, file: &str) {
    let text = error.to_string();
    let sheet = format!("{file}#");
    let names = |first: &str| first.ends_with(file) || first.contains(&sheet);
    assert!(text.split(": ").next().is_some_and(names), "{text}");
    for (index, line) in text.lines().enumerate() {
        assert!(is_line(line), "{text:?}");
        assert!(index == 0 || line.starts_with("  "), "{text:?}");
    }
}

/// Nothing on a line moves a terminal or turns its text.
pub fn is_line(line: &str) -> bool {
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    !line.chars().any(|c| c.is_control() || turns(c))
}

/// A drafted scene is one, or lacks what it says.
pub fn assert_drafted(table: &TableFile) {
    if let Ok(draft) = runs::draft_scene(table, "runs.csv") {
        let scene = scene::parse(&draft.text, std::path::Path::new("scene.toml"), String::new());
        assert_eq!(scene.is_ok(), draft.to_fill_in.is_empty(), "{scene:?}");
    }
}

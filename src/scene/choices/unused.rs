//! Remembers which keys a scene sets that nothing reads yet.

use crate::scene::table::SceneTable;

/// Remembers which keys the scene sets that no stage reads yet.
pub(super) fn note_unused(name: &str, table: &SceneTable, keys: &[&str], unused: &mut Vec<String>) {
    for key in keys.iter().filter(|key| table.has(key)) {
        unused.push(format!("{name}.{key}"));
    }
}

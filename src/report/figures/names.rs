//! Names the file of each figure, no two alike on any file system, whatever the particles are called.

use std::collections::HashSet;

use crate::error::is_unseen;
use crate::runs::Runs;
use crate::scene::Scene;

/// Longest part of a file name, in bytes, that a particle gives: with what stands about it, below the 255 of a file system.
const LONGEST: usize = 160;

/// File names of the figures of each sphere of some runs: restitution against impact speed, and against 1/St at one film ratio.
///
/// A particle stands in them by its name, with a number after it where a file system that folds capitals or composes letters
/// could take the name for another's; the first of two alike keeps its own.
pub fn file_names(scene: &Scene, runs: &Runs) -> Vec<[String; 2]> {
    let labels: Vec<String> = runs.spheres.iter().map(|sphere| sphere.label(scene)).collect();
    let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
    of_particles(&labels)
}

fn of_particles(names: &[&str]) -> Vec<[String; 2]> {
    let called: HashSet<String> = names.iter().map(|name| folded(&in_file(name))).collect();
    let mut taken: HashSet<String> = HashSet::new();
    let mut files = vec![];
    for name in names {
        let own = in_file(name);
        let numbered = (2u64..).map(|number| format!("{own}-{number}"));
        // nobody is given by a number what another is called
        let numbered = numbered.filter(|stem| !called.contains(&folded(stem)));
        let mut stems = std::iter::once(own.clone()).chain(numbered);
        let stem = stems.find(|stem| taken.insert(folded(stem))).unwrap_or_default();
        files.push(["speed", "stokes"].map(|figure| format!("restitution-{figure}-{stem}.svg")));
    }
    files
}

/// The beginning of a name that a file name has room for; a diameter follows a hyphen.
fn in_file(name: &str) -> String {
    name[..name.floor_char_boundary(LONGEST)].replace(',', "-")
}

/// What two names have in common that some file system takes for one: capitals are folded, what is not seen falls away, and
/// letters beyond ASCII, which may be written in several ways, are all one.
fn folded(name: &str) -> String {
    let letters = name.chars().filter(|c| !is_unseen(*c));
    let folded = letters.flat_map(char::to_uppercase).flat_map(char::to_lowercase);
    let mut key = String::new();
    for c in folded {
        let c = if c.is_ascii() { c } else { char::REPLACEMENT_CHARACTER };
        // several may be one composed
        if c.is_ascii() || !key.ends_with(c) {
            key.push(c);
        }
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alike(files: &[String]) -> usize {
        let keys: HashSet<String> = files.iter().map(|file| folded(file)).collect();
        files.len() - keys.len()
    }

    #[test]
    fn d14_no_two_figures_share_a_name() {
        let long = ["a".repeat(255), "a".repeat(254), "ä".repeat(200)];
        let sets: [&[&str]; 6] = [
            &["pe", "PE", "Pe", "PE-2", "pe-3"],
            &[".", "..", "con", "CON", "-", "_"],
            &["가", "\u{1100}\u{1161}", "가-2"],
            &["straße", "STRASSE", "K", "\u{212a}", "k"],
            &["a", "a\u{3164}"],
            &[&long[0], &long[1], &long[2], "a"],
        ];
        for names in sets {
            let files = of_particles(names).concat();
            assert_eq!(alike(&files), 0, "{files:?}");
            assert!(
                files.iter().all(|file| file.len() < 255 && !file.contains('/')),
                "{files:?}"
            );
        }
        assert_eq!(of_particles(&["PE", "pe"])[1][1], "restitution-stokes-pe-2.svg");
        // what is looked for here is there where names are only put together
        let plain = ["PE", "pe"].map(|name| format!("restitution-stokes-{name}.svg"));
        assert_eq!(alike(&plain), 1);
    }
}

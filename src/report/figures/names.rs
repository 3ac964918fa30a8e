//! Names the file of each figure, no two alike on any file system, whatever the particles are called.

use std::collections::{HashMap, HashSet};

use crate::error::is_unseen;
use crate::runs::Runs;
use crate::scene::Scene;

/// Longest part of a file name, in bytes, that a particle gives: with what stands about it, below the 255 of a file system.
const LONGEST: usize = 160;

/// File names of the figures of each particle, or of each diameter that has a k of its own.
///
/// A particle stands in them by its name, with a number after it where a file system that folds capitals or composes letters
/// could take the name for another's.
#[derive(Debug, Clone)]
pub struct Names {
    /// how each particle stands in a file name, by its label
    stems: HashMap<String, String>,
}

impl Names {
    /// The names for the spheres of some runs, the first of two alike keeping its own.
    pub fn of(scene: &Scene, runs: &Runs) -> Names {
        let labels: Vec<String> = runs.spheres.iter().map(|sphere| sphere.label(scene)).collect();
        let labels: Vec<&str> = labels.iter().map(String::as_str).collect();
        Names::of_particles(&labels)
    }

    fn of_particles(names: &[&str]) -> Names {
        let own: Vec<String> = names.iter().map(|name| folded(&in_file(name))).collect();
        // nobody is given by a number what another is called
        let called: HashSet<&String> = own.iter().collect();
        let mut taken: HashSet<String> = HashSet::new();
        let mut stems = HashMap::new();
        for (name, own) in names.iter().zip(&own) {
            let mut stem = in_file(name);
            let mut key = own.clone();
            let mut number = 1u64;
            while taken.contains(&key) || number > 1 && called.contains(&key) {
                number += 1;
                stem = format!("{}-{number}", in_file(name));
                key = folded(&stem);
            }
            taken.insert(key);
            stems.insert((*name).to_owned(), stem);
        }
        Names { stems }
    }

    /// How a particle stands in a file name; one that is not of the scene by its own name.
    fn stem<'a>(&'a self, particle: &'a str) -> &'a str {
        self.stems.get(particle).map_or(particle, String::as_str)
    }

    /// Restitution against impact speed.
    pub fn speed(&self, particle: &str) -> String {
        format!("restitution-speed-{}.svg", self.stem(particle))
    }

    /// Restitution against 1/St at one film ratio.
    pub fn stokes(&self, particle: &str) -> String {
        format!("restitution-stokes-{}.svg", self.stem(particle))
    }
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

    /// Every file of these particles.
    fn files(names: &[&str]) -> Vec<String> {
        let all = Names::of_particles(names);
        let of = |name: &&str| [all.speed(name), all.stokes(name)];
        names.iter().flat_map(of).collect()
    }

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
            let files = files(names);
            assert_eq!(alike(&files), 0, "{files:?}");
            assert!(
                files.iter().all(|file| file.len() < 255 && !file.contains('/')),
                "{files:?}"
            );
        }
        assert_eq!(
            Names::of_particles(&["PE", "pe"]).stokes("pe"),
            "restitution-stokes-pe-2.svg"
        );
        // what is looked for here is there where names are only put together
        let plain = ["PE", "pe"].map(|name| format!("restitution-stokes-{name}.svg"));
        assert_eq!(alike(&plain), 1);
    }
}

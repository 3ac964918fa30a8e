//! Knows headers that name another quantity than that of the column they are read as.

use super::words::is_among;
use crate::scene::RunColumn;
use crate::units::Dimension;

/// What a radius is called, in small letters.
const RADII: &str = "radius radii halbmesser rayon raggio radio straal r";

/// What a diameter is called, in small letters.
const DIAMETERS: &str = "d dia diam diameter diameters durchmesser diamètre diametre diametro diámetro ∅";

/// Words that say that a quantity is squared.
const SQUARES: &str = "squared square sq quadrat quadriert quadratisch carré carre quadrato cuadrado e2 en2 cor2";

/// Words and signs of a square root.
const ROOTS: &str = "sqrt √ root wurzel racine ^0.5";

/// What beginnings of words say that a column is of energies.
const ENERGIES: &str = "energ énerg kinetic kinetisch";

/// Words for what an impact takes.
const LOSSES: &str = "loss losses lost verlust verluste perte dissipation";

/// Signs of a product.
const TIMES: [char; 5] = ['*', '×', '·', '⋅', 'x'];

/// What a header names in place of the quantity of a column, and what to do about it; `None` where it names none.
pub(super) fn other_quantity(name: &str, column: RunColumn) -> Option<&'static str> {
    let name = name.to_lowercase();
    let words: Vec<&str> = name.split(|c: char| !c.is_alphanumeric() && c != '∅').collect();
    match column {
        RunColumn::Diameter if is_radius(&name, &words) => Some(
            "by its name it is a radius; expected the diameter: add a column with twice its numbers to the table, and name \
             that one",
        ),
        RunColumn::FilmRatio if is_over_radius(&name, &words) => Some(
            "by its name it is the film over the radius; expected δ/D, the film over the diameter: add a column with half its \
             numbers to the table, and name that one",
        ),
        RunColumn::Restitution if is_square(&name, &words) => Some(
            "by its name it is the square of a restitution or a share of energy; expected e, rebound over impact speed: add \
             a column of e to the table (of e² its square root), and name that one",
        ),
        RunColumn::Restitution if is_loss(&name, &words) => Some(
            "by its name it is what the impact takes, as 1 − e; expected e, rebound over impact speed: add a column of e to the \
             table, and name that one",
        ),
        RunColumn::ImpactSpeed | RunColumn::ReboundSpeed if is_square(&name, &words) => Some(
            "by its name it is the square of a speed or an energy; expected the speed: add a column of it to the table, and \
             name that one",
        ),
        // of a share in per cent the factor is the unit
        _ if column.is_number() && column.dimension() != Dimension::Share && has_factor(&name) => Some(
            "by its name its numbers are multiplied by a power of ten; expected the quantity itself: add a column of it to the \
             table, and name that one",
        ),
        _ => None,
    }
}

/// Whether a name, in small letters, says that its numbers are multiplied, as `1000 × v` does; the `x 10^-3 mm` of another is
/// a unit.
pub(super) fn has_factor(name: &str) -> bool {
    let is_power = |digits: &str| {
        digits.len() > 1
            && digits
                .strip_prefix('1')
                .is_some_and(|rest| rest.bytes().all(|b| b == b'0'))
    };
    let is_number = |c: char| c.is_ascii_digit() || "^.,".contains(c);
    name.match_indices(TIMES).any(|(at, sign)| {
        let (before, after) = (name[..at].trim_end(), name[at + sign.len()..].trim_start());
        // an `x` inside a word is a letter
        let is_letter = sign == "x" && name[..at].ends_with(char::is_alphabetic);
        let [first, last] = [
            before.rsplit(|c| !is_number(c)).next(),
            after.split(|c| !is_number(c)).next(),
        ];
        !is_letter && [first, last].into_iter().flatten().any(is_power)
    })
}

fn is_radius(name: &str, words: &[&str]) -> bool {
    if words.iter().any(|word| is_among(DIAMETERS, word)) {
        // the 2R of `D (2R)` says no radius
        return is_halved(name, words);
    }
    words.iter().any(|word| is_of_radius(word)) && !is_doubled(name, words)
}

fn is_over_radius(name: &str, words: &[&str]) -> bool {
    let is_double_film = ["2δ", "2 δ", "2delta", "2 delta", "2*δ", "2·δ"]
        .iter()
        .any(|double| name.contains(double));
    let of_radius = words.iter().any(|word| is_of_radius(word));
    is_double_film || of_radius && !is_doubled(name, words)
}

/// Whether a word says radius, by itself or at its end as in `Kugelradius`.
fn is_of_radius(word: &str) -> bool {
    let is_end = |radius: &str| radius.len() > "radio".len() && word.ends_with(radius);
    is_among(RADII, word) || RADII.split(' ').any(is_end)
}

/// Whether half of a quantity is named, as in `D/2`; a date as 12/24 halves nothing.
fn is_halved(name: &str, words: &[&str]) -> bool {
    let by_sign = name.match_indices('/').any(|(at, _)| {
        let after = name[at + 1..].trim_start().strip_prefix('2');
        after.is_some_and(|after| !after.starts_with(|c: char| c.is_ascii_digit() || c == '/'))
    });
    by_sign || name.contains('½') || words.iter().any(|word| ["half", "halb", "halber"].contains(word))
}

/// Whether a radius is written with a 2 before or after it, and so is a diameter.
fn is_doubled(name: &str, words: &[&str]) -> bool {
    // the 2 and the R of `2 x R`, too
    let is_meant = |word: &&str| !word.is_empty() && *word != "x";
    let meant: Vec<&str> = words.iter().copied().filter(is_meant).collect();
    let by_word = meant.windows(2).any(|both| both[0] == "2" && is_of_radius(both[1]));
    let by_sign = ["*2", "* 2", "×2", "× 2", "x2", "x 2", "twice", "double", "doppelt"];
    by_word || by_sign.iter().any(|sign| name.contains(sign))
}

fn is_loss(name: &str, words: &[&str]) -> bool {
    let tight: String = name.chars().filter(|c| !c.is_whitespace()).collect();
    let is_rest = ["1-", "1−", "1–", "(1-", "(1−"]
        .iter()
        .any(|start| tight.starts_with(start));
    is_rest || words.iter().any(|word| is_among(LOSSES, word))
}

fn is_square(name: &str, words: &[&str]) -> bool {
    if ROOTS.split(' ').any(|root| name.contains(root)) {
        return false;
    }
    let by_sign = ["²", "^2", "**2"].iter().any(|sign| name.contains(sign));
    let by_word = words.iter().any(|word| is_among(SQUARES, word));
    let of_energy = words
        .iter()
        .any(|word| ENERGIES.split(' ').any(|energy| word.starts_with(energy)));
    by_sign || by_word || of_energy
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_and_squares_are_known_by_their_names() {
        for (column, others, own) in [
            (
                RunColumn::Diameter,
                &[
                    "radius_mm",
                    "radius",
                    "R (mm)",
                    "r",
                    "sphere radius",
                    "Kugelradius",
                    "D/2",
                    "r_p [mm]",
                    "half diameter",
                ][..],
                &[
                    "D (mm)",
                    "2R",
                    "2*R",
                    "2 x radius",
                    "diameter (2R)",
                    "Kugel",
                    "dia.",
                    "size",
                    "D (0.5 mm)",
                    "Durchmesser 12/24",
                ][..],
            ),
            (
                RunColumn::Restitution,
                &[
                    "e²",
                    "e^2",
                    "e2",
                    "energy restitution",
                    "restitution squared",
                    "E_kin energy kept",
                    "e**2",
                    "e²(%)",
                ],
                &[
                    "e",
                    "e_n",
                    "COR",
                    "restitution 2",
                    "e (from heights)",
                    "sqrt(e^2)",
                    "√(E_r/E_i) of energies",
                    "e_2",
                ],
            ),
            (
                RunColumn::Restitution,
                &["1-e", "1 − e", "(1-e)/1", "e loss", "Verlust"],
                &["e", "e (1-3 drops)", "e 1-2", "COR x100"],
            ),
            (
                RunColumn::ImpactSpeed,
                &["v²", "v_i^2", "kinetic energy", "v*100 (m/s)", "1000 × v", "v x10"],
                &[
                    "v",
                    "v2",
                    "v_i (m/s)",
                    "vx",
                    "v x 2",
                    "v (10^-2 m/s)",
                    "max100",
                    "v x 10^-2 m/s",
                    "v (run 100)",
                ],
            ),
            (
                RunColumn::FilmRatio,
                &["δ/R", "film / radius", "2δ/D", "delta_R"],
                &["δ/D", "δ/(2R)", "film ratio", "delta over D", "δ / 2 R"],
            ),
        ] {
            for name in others {
                assert!(other_quantity(name, column).is_some(), "{name}");
            }
            for name in own {
                assert_eq!(other_quantity(name, column), None, "{name}");
            }
        }
        // a radius of another column is none
        assert_eq!(other_quantity("radius", RunColumn::Run), None);
    }
}

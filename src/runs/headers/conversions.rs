//! Knows headers whose numbers a factor, a power or a difference turns into the quantity of their column.

use super::super::words::is_among;
use super::called::columns_called;
use super::header::{Header, MEASURED, ROOTS, SOURCES};
use super::quantities::{quantities_in, quantities_of_symbol};
use super::units::has_factor;
use crate::scene::RunColumn;
use crate::units::Dimension;

/// What a radius is called, in small letters.
const RADII: &str = "radius radii halbmesser rayon raggio radio straal raio радиус 半径 r";

/// What a diameter is called, in small letters.
const DIAMETERS: &str = "d dia diam diameter diameters durchmesser diamètre diametre diametro diámetro ∅";

/// Words that say that a quantity is squared.
const SQUARES: &str =
    "ke kin ekin squared square sq quadrat quadriert quadratisch carré carre quadrato cuadrado e2 en2 cor2";

/// What beginnings of words say that a column is of energies.
const ENERGIES: &str = "energ énerg kinetic kinetisch";

/// Words for what an impact takes.
const LOSSES: &str = "loss losses lost verlust verluste perte dissipation dissipated absorbed";

/// What a header says that some power or factor turns into the quantity of its column, and how.
pub(super) fn known_conversion(header: &Header, column: RunColumn) -> Option<String> {
    let [found, expected, added] = match column {
        RunColumn::Diameter if is_radius(header) => {
            ["it is a radius", "the diameter", "with twice its numbers to the table"]
        }
        RunColumn::Stokes if names_radius(header) && !is_doubled(header) || header.has("9") => [
            "it is a Stokes number with the radius or without its 9",
            "ρ D v / (9 η)",
            "of that to the table",
        ],
        RunColumn::FilmRatio if is_over_radius(header) => [
            "it is the film over the radius",
            "δ/D, the film over the diameter",
            "with half its numbers to the table",
        ],
        RunColumn::Restitution if is_square(header) || is_ratio_of_squares(header) => [
            "it is the square of a restitution or a share of energy",
            "e, rebound over impact speed",
            "of e to the table (of e² its square root)",
        ],
        RunColumn::Restitution if is_loss(header) => [
            "it is what the impact takes, as 1 − e",
            "e, rebound over impact speed",
            "of e to the table",
        ],
        RunColumn::ImpactSpeed | RunColumn::ReboundSpeed if is_square(header) => [
            "it is the square of a speed or an energy",
            "the speed",
            "of it to the table",
        ],
        RunColumn::Diameter | RunColumn::Film | RunColumn::DropHeight | RunColumn::ReboundHeight
            if is_symbol_squared(header) =>
        {
            ["it is a square", "the length itself", "of its root to the table"]
        }
        // of a share in per cent the factor is the unit
        _ if column.is_number() && column.dimension() != Dimension::Share && is_multiplied(header) => [
            "its numbers are multiplied by a power of ten",
            "the quantity itself",
            "of it to the table",
        ],
        _ if MEASURED.contains(&column) && is_scaled(header, column) => [
            "its numbers are multiplied or divided by another number",
            "the quantity itself",
            "of it to the table",
        ],
        _ => return None,
    };
    Some(format!(
        "by its name {found}; expected {expected}: add a column {added}, and name that one"
    ))
}

/// Whether its numbers are multiplied, or divided as in `h/10`, by a power of ten.
fn is_multiplied(header: &Header) -> bool {
    let divisor = header.divisor().and_then(|after| after.split_whitespace().next());
    has_factor(&header.lower) || divisor.is_some_and(|number| is_among(POWERS_OF_TEN, number))
}

const POWERS_OF_TEN: &str = "10 100 1000";

/// Whether the quantity of a column stands in its name with another number, as in `2h`, `v*3` or `film/2`.
fn is_scaled(header: &Header, column: RunColumn) -> bool {
    const SIGNS: [char; 5] = ['/', '*', '×', '·', '⋅'];
    let is_own = |text: Option<&str>| {
        let text = text.unwrap_or_default();
        let symbol = text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        let mut quantities = quantities_of_symbol(symbol).into_iter().chain(quantities_in(text));
        quantities.any(|quantity| quantity.is_of(column)) || columns_called(text).contains(&column)
    };
    let is_factor = |text: &str| {
        // a share times a hundred is in per cent
        let is_unit = column.dimension() == Dimension::Share && is_among(POWERS_OF_TEN, text);
        let number: Result<f64, _> = text.replace(',', ".").parse();
        !is_unit && !text.ends_with('.') && number.is_ok_and(|number| number > 0.0 && number != 1.0)
    };
    let name = header.outside.trim();
    if name.contains('^') || name.contains("**") {
        return false;
    }
    let own = name.trim_start_matches(|c: char| c.is_numeric() || ".,".contains(c));
    let first = &name[..name.len() - own.len()];
    let is_first = is_factor(first) || is_among("½ ⅓ ¼", first);
    let after = own.trim_start_matches(|c: char| c == ' ' || SIGNS.contains(&c));
    let is_last = |(before, number): (&str, &str)| is_factor(number.trim()) && is_own(before.split_whitespace().last());
    is_first && is_own(after.split_whitespace().next()) || name.rsplit_once(SIGNS).is_some_and(is_last)
}

fn is_radius(header: &Header) -> bool {
    if header.has(DIAMETERS) || header.name.contains('∅') {
        // the 2R of `D (2R)` says no radius
        return is_halved(header);
    }
    names_radius(header) && !is_doubled(header)
}

fn is_over_radius(header: &Header) -> bool {
    let is_double_film = ["2δ", "2 δ", "2delta", "2 delta", "2*δ", "2·δ"]
        .iter()
        .any(|double| header.lower.contains(double));
    is_double_film || names_radius(header) && !is_doubled(header)
}

fn names_radius(header: &Header) -> bool {
    header.words.iter().any(|word| is_of_radius(word))
}

/// Whether a word says radius, by itself or at its end as in `Kugelradius`.
fn is_of_radius(word: &str) -> bool {
    let is_end = |radius: &str| radius.len() > "radio".len() && word.ends_with(radius);
    is_among(RADII, word) || RADII.split(' ').any(is_end)
}

/// Whether half of a quantity is named, as in `D/2`; a date as 12/24 halves nothing.
fn is_halved(header: &Header) -> bool {
    let by_sign = header.lower.match_indices('/').any(|(at, _)| {
        let after = header.lower[at + 1..].trim_start().strip_prefix('2');
        after.is_some_and(|after| !after.starts_with(|c: char| c.is_ascii_digit() || c == '/'))
    });
    by_sign || header.name.contains('½') || header.has("half halb halber")
}

/// Whether a radius is written with a 2 before or after it, and so is a diameter.
fn is_doubled(header: &Header) -> bool {
    // the 2 and the R of `2 x R`, too
    let meant: Vec<&String> = header.words.iter().filter(|word| *word != "x").collect();
    let by_word = meant.windows(2).any(|both| both[0] == "2" && is_of_radius(both[1]));
    let by_sign = ["*2", "* 2", "×2", "× 2", "x2", "x 2", "twice", "double", "doppelt"];
    by_word || by_sign.iter().any(|sign| header.lower.contains(sign))
}

fn is_loss(header: &Header) -> bool {
    let tight: String = header.lower.chars().filter(|c| !c.is_whitespace()).collect();
    let is_rest = ["1-", "1−", "1–", "(1-", "(1−"]
        .iter()
        .any(|start| tight.starts_with(start));
    is_rest || header.has(LOSSES)
}

fn is_square(header: &Header) -> bool {
    let of_energy = |word: &String| ENERGIES.split(' ').any(|energy| word.starts_with(energy));
    let is_squared = header.has_square_sign() || header.has(SQUARES) || header.words.iter().any(of_energy);
    is_squared && !header.contains(ROOTS)
}

/// Whether it begins with a square, as `D^2` does; the `g/m²` of another is its unit.
fn is_symbol_squared(header: &Header) -> bool {
    let symbol = header.outside.split([' ', '/', ',']).next().unwrap_or_default();
    ["²", "^2", "**2"].iter().any(|square| symbol.ends_with(square))
}

/// Whether a name says that one height or energy is divided by another, which gives the square of a restitution.
fn is_ratio_of_squares(header: &Header) -> bool {
    let has_root = header.contains(ROOTS);
    let is_told = header.has_end(SOURCES) || header.names(RunColumn::Restitution) || has_root;
    let is_first = |first: &String| columns_called(first).contains(&RunColumn::Restitution);
    let of_restitution = header.words.first().is_some_and(is_first);
    let is_of_height = header.is_called_ratio() && is_among("h H", header.symbol);
    let of_heights = is_of_height || header.is_quotient() && header.names(RunColumn::ReboundHeight) && !of_restitution;
    let of_energies = is_quotient_of(header.name, 'E') && !has_root;
    of_energies || (is_quotient_of(&header.lower, 'h') || of_heights) && !is_told
}

/// Whether the names on both sides of a slash or colon begin with a letter, as in `h2/h1`.
fn is_quotient_of(name: &str, letter: char) -> bool {
    let begins = |side: Option<&str>| {
        let side = side.unwrap_or_default().trim_start_matches(['(', 'Δ', 'δ']);
        side.starts_with(letter) && side.chars().take_while(|c| c.is_alphabetic()).count() <= 2
    };
    let sides = name.split_once(['/', ':']);
    sides.is_some_and(|(above, below)| {
        begins(above.split_whitespace().last()) && begins(below.split_whitespace().next())
    })
}

//! Knows headers that name another quantity than that of the column they are read as.

use super::guess::{called_as, columns_called};
use super::words::{is_among, without_brackets};
use super::written_units::unit_of;
use crate::scene::RunColumn;
use crate::units::Dimension;

/// What a radius is called, in small letters.
const RADII: &str = "radius radii halbmesser rayon raggio radio straal r";

/// What a diameter is called, in small letters.
const DIAMETERS: &str = "d dia diam diameter diameters durchmesser diamètre diametre diametro diámetro ∅";

/// Words that say that a quantity is squared.
const SQUARES: &str = "squared square sq quadrat quadriert quadratisch carré carre quadrato cuadrado e2 en2 cor2";

/// Words and signs of a square root.
const ROOTS: &str = "sqrt √ root wurzel racine ^0.5 **0.5 ^(0.5) ^(1/2) ^1/2 ^½ **(1/2)";

/// What beginnings of words say that a column is of energies.
const ENERGIES: &str = "energ énerg kinetic kinetisch";

/// Words for what an impact takes.
const LOSSES: &str = "loss losses lost verlust verluste perte dissipation";

/// Signs of a product.
const TIMES: [char; 5] = ['*', '×', '·', '⋅', 'x'];

/// What a header may name.
struct Quantity {
    name: &'static str,
    words: &'static str,
    /// what the columns that take it are called, the one of the impact first
    columns: &'static str,
    symbols: &'static str,
}

impl Quantity {
    fn is_of(&self, column: RunColumn) -> bool {
        is_among(self.columns, column.base())
    }

    fn columns(&self) -> impl Iterator<Item = RunColumn> {
        self.columns.split(' ').filter_map(RunColumn::of_base)
    }
}

/// Every quantity that a header may name.
fn quantities() -> impl Iterator<Item = Quantity> {
    let lines = include_str!("quantities.txt")
        .lines()
        .filter(|line| !line.starts_with('#'));
    lines.filter_map(|line| {
        let mut parts = line.split(':').map(str::trim);
        Some(Quantity {
            name: parts.next()?,
            words: parts.next()?,
            columns: parts.next()?,
            symbols: parts.next().unwrap_or_default(),
        })
    })
}

/// Those that the words of a header name.
fn quantities_in(words: &[&str]) -> Vec<Quantity> {
    let is_named = |quantity: &Quantity| words.iter().any(|word| is_called(quantity.words, word));
    quantities().filter(is_named).collect()
}

/// Those that a symbol stands for, perhaps with a number behind it.
fn quantities_of_symbol(symbol: &str) -> Vec<Quantity> {
    let symbol = symbol.trim_end_matches(char::is_numeric);
    quantities()
        .filter(|quantity| !symbol.is_empty() && is_among(quantity.symbols, symbol))
        .collect()
}

/// Symbols of dimensionless numbers, which begin a name.
const NUMBERS: &str = "We Re Fr Bo Oh St";

/// Columns whose headers name what is measured.
const MEASURED: [RunColumn; 9] = [
    RunColumn::Diameter,
    RunColumn::Film,
    RunColumn::ImpactSpeed,
    RunColumn::ReboundSpeed,
    RunColumn::Restitution,
    RunColumn::DropHeight,
    RunColumn::ReboundHeight,
    RunColumn::Stokes,
    RunColumn::FilmRatio,
];

/// Words for a quotient.
const RATIOS: &str = "ratio ratios quotient verhältnis verhaeltnis rapport";

/// What a length or speed is divided by in a name: no unit is written so.
const DIVISORS: &str = "d r 2r dp d_p rp r_p ds d_s h0 h_0 v0 v_0 vi v_i diameter durchmesser radius";

/// Words before what a quantity was made from.
const SOURCES: &str = "from by via aus durch par using";

/// Words for the direction along the plate.
const ALONG: &str = "tangential tangentiell tangentielle horizontal transverse";

/// Words of what comes before an impact, and of what comes after it.
const ROLES: [&str; 2] = [
    "impact incoming incident aufprall auftreff aufprallgeschwindigkeit auftreffgeschwindigkeit drop release fallhöhe",
    "rebound reb bounce outgoing rückprall rücksprung rückprallgeschwindigkeit rückprallhöhe rücksprunghöhe rebond out",
];

/// Words that say that a quantity was taken before one of the two, and after it.
const MOMENTS: [&str; 2] = ["before vor avant prior pre", "after nach après post danach"];

/// Words of what comes before the impact, after which a speed is that of the impact.
const FALLS: &str = "release drop fall";

/// Words for what was worked out and not measured.
const MODELS: &str = "theory theoretical theorie model modell fit fitted predicted";

/// Words for a standard deviation, and for a standard error.
const SPREADS: [&str; 2] = [
    "sd std stdev stdv stddev stabw standardabweichung écarttype σ",
    "se sem stderr standardfehler",
];

/// Words for a spread that is neither.
const OTHER_SPREADS: &str = "var variance varianz cv rsd ci ci95 confidence konfidenzintervall iqr range spannweite";

/// Words of a column that marks the runs to keep.
const KEPT: &str = "in valid valide gültig gueltig ok good gut use used keep kept include included brauchbar bon";

/// What a header names in place of the quantity of a column that is read under a key, and what to do about it; `None` where it
/// names none.
pub(super) fn other_quantity(name: &str, column: RunColumn, key: &str) -> Option<String> {
    if let Some(expected) = known_conversion(name, column) {
        return Some(expected.to_owned());
    }
    let lower = name.to_lowercase();
    let words = words_of(&lower);
    if column == RunColumn::Exclude && words.iter().all(|word| is_among(KEPT, word)) {
        return Some(format!(
            "by its name it marks the runs to keep; `{key}` takes why a run is left out: add a column that marks the others, \
             and name that one"
        ));
    }
    let (found, right) = named_quantity(name, column)?;
    let step = match right {
        Some(right) => format!("name it as `{}` in the scene's columns", right.usual_name()),
        None => "name the right column, or add one to the table".to_owned(),
    };
    Some(format!(
        "by its name it holds {found}; `{key}` takes {}: {step}",
        head_of(column)
    ))
}

/// What a header names that its column does not take, with the column that does.
fn named_quantity(name: &str, column: RunColumn) -> Option<(&'static str, Option<RunColumn>)> {
    let lower = name.to_lowercase();
    let words = words_of(&lower);
    if let Some(found) = other_spread(&lower, &words, column) {
        return Some(found);
    }
    if !MEASURED.contains(&column) {
        return None;
    }
    let has = |list: &str| words.iter().any(|word| is_among(list, word));
    let is_made = has(SOURCES);
    let has_root = ROOTS.split(' ').any(|root| lower.contains(root));
    if words.first().is_some_and(|word| is_among("ln log lg log10", word)) {
        return Some(("a logarithm", None));
    }
    let is_along = matches!(words[..], ["e" | "cor" | "ε", "t", ..]);
    if matches!(
        column,
        RunColumn::Restitution | RunColumn::ImpactSpeed | RunColumn::ReboundSpeed
    ) && (has(ALONG) || is_along)
    {
        return Some(("what happens along the plate, not normal to it", None));
    }
    if column.is_of_rebound() && matches!(words[..], [_, second] if is_among(MODELS, second)) {
        return Some(("what a model gives, not what was measured", None));
    }
    let is_quotient =
        words.iter().any(|word| is_called(RATIOS, word)) || lower.contains(['/', ':']) || has("over relative");
    let first = name.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    let of_symbol = quantities_of_symbol(first);
    let is_one_of = |quantities: &[Quantity]| quantities.iter().any(|quantity| quantity.is_of(column));
    let (letters, called) = called_as(name);
    let has_symbol = is_one_of(&of_symbol) || columns_called(first).contains(&column);
    // behind a symbol, brackets tell more of it, as the `(time of flight)` of a `v`
    let outside = without_brackets(&lower);
    let naming = words_of(if has_symbol { &outside } else { &lower });
    let named = quantities_in(&naming);
    if matches!(column.dimension(), Dimension::Length | Dimension::Thickness) && has_root {
        return Some(("a square root", None));
    }
    if column == RunColumn::Restitution && has_root && named.is_empty() && !is_quotient && !is_square_sign(&lower) {
        return Some(("a square root", None));
    }
    let takes_ratios = matches!(
        column,
        RunColumn::Restitution | RunColumn::FilmRatio | RunColumn::Stokes
    );
    let divisor = lower.split_once('/').map(|(_, after)| after.trim());
    if is_inverse(&lower, column) {
        return Some(("the inverse of what is expected", None));
    }
    let is_ratio =
        words.iter().any(|word| is_called(RATIOS, word)) || divisor.is_some_and(|after| is_among(DIVISORS, after));
    if !takes_ratios && is_ratio && !is_made {
        return Some(("a ratio", None));
    }
    let is_stokes = first == "St";
    if is_among(NUMBERS, first) && !name[first.len()..].starts_with('-') && !(is_stokes && column == RunColumn::Stokes)
    {
        return Some(("a dimensionless number", is_stokes.then_some(RunColumn::Stokes)));
    }
    if let Some(right) = is_of_other_side(&lower, &words, column) {
        return Some((head_of(right), Some(right)));
    }
    if takes_ratios && (is_quotient || has_symbol) {
        return None;
    }
    if let Some(right) = column_elsewhere(&letters, column, &called, is_one_of(&of_symbol).then_some(first)) {
        return Some((head_of(right), Some(right)));
    }
    if is_one_of(&named) || is_made {
        return None;
    }
    let has_own_word = words.iter().any(|word| columns_called(word).contains(&column));
    let by_symbol = if has_own_word || has_symbol || !called.is_empty() {
        &[]
    } else {
        of_symbol.as_slice()
    };
    let found = named.first().or(by_symbol.first())?;
    let right = found
        .columns()
        .find(|other| other.is_of_rebound() == column.is_of_rebound());
    Some((found.name, right.or(found.columns().next())))
}

/// The column of the same quantity on the other side of the impact, where a header names that side.
fn is_of_other_side(lower: &str, words: &[&str], column: RunColumn) -> Option<RunColumn> {
    let right = column.other_side()?;
    let has = |list: &str| words.iter().any(|word| is_among(list, word));
    let has_role = |at: usize| words.iter().any(|word| is_called(ROLES[at], word));
    let (own, other) = if column.is_of_rebound() { (1, 0) } else { (0, 1) };
    let is_primed = lower.trim_start_matches(char::is_alphanumeric).starts_with(['\'', '′']);
    let is_other = if has(MOMENTS[0]) || has(MOMENTS[1]) {
        // what comes before a rebound is the impact, and what comes after an impact the rebound
        let is_of_this_impact = !(has(FALLS) || own == 1 && has_role(own));
        has(MOMENTS[other]) && !has(MOMENTS[own]) && is_of_this_impact
    } else {
        let is_made = has(SOURCES);
        has_role(other) && !has_role(own) && !is_made || is_primed && other == 1
    };
    is_other.then_some(right)
}

/// The first of the columns that a header is called like, if the own one is none of them.
fn column_elsewhere(letters: &str, column: RunColumn, called: &[RunColumn], symbol: Option<&str>) -> Option<RunColumn> {
    // a column of spheres may hold their diameters, and one of liquids the films
    let may_hold = match column {
        RunColumn::Diameter => Some(RunColumn::Particle),
        RunColumn::Film => Some(RunColumn::Liquid),
        RunColumn::FilmRatio => Some(RunColumn::Film),
        _ => None,
    };
    let is_own = |of: &RunColumn| *of == column || Some(*of) == may_hold;
    let stem_of = |name: &str| name.to_lowercase().trim_end_matches(char::is_numeric).to_owned();
    let stem = stem_of(letters);
    // the `v` of a rebound, the `h0` of a film; a number says before or after an impact
    let has_number = stem != letters && column.other_side().is_some();
    let is_symbol = !has_number && symbol.is_some_and(|symbol| stem_of(symbol) == stem);
    let is_word = quantities().any(|of| of.is_of(column) && is_among(of.words, letters));
    let is_elsewhere = !is_symbol && !is_word && !called.iter().any(is_own);
    called.first().copied().filter(|_| is_elsewhere)
}

/// What a column holds, in a few words.
fn head_of(column: RunColumn) -> &'static str {
    let means = column.guide().meaning.trim_start_matches("of a mean: ");
    let ends = [",", ";", " ("].into_iter().filter_map(|end| means.find(end));
    &means[..ends.min().unwrap_or(means.len())]
}

fn words_of(name: &str) -> Vec<&str> {
    let words = name.split(|c: char| !c.is_alphanumeric());
    words.filter(|word| !word.is_empty()).collect()
}

/// Whether a name says that one height or energy is divided by another, which gives the square of a restitution.
fn is_ratio_of_squares(name: &str) -> bool {
    let lower = name.to_lowercase();
    let words = words_of(&lower);
    let has = |list: &str| words.iter().any(|word| is_called(list, word));
    let named = quantities_in(&words);
    let is_named = |column: RunColumn| named.iter().any(|quantity| quantity.is_of(column));
    let is_told = has(SOURCES) || is_named(RunColumn::Restitution) || ROOTS.split(' ').any(|root| lower.contains(root));
    let has_symbol = words
        .first()
        .is_some_and(|first| columns_called(first).contains(&RunColumn::Restitution));
    let is_quotient = lower.contains(['/', ':']) || has(RATIOS) || has("over");
    is_quotient_of(name, 'E')
        || is_quotient_of(&lower, 'h') && !is_told
        || is_quotient && is_named(RunColumn::ReboundHeight) && !is_told && !has_symbol
}

/// A spread that a header names where its column takes another, or the quantity itself.
fn other_spread(lower: &str, words: &[&str], column: RunColumn) -> Option<(&'static str, Option<RunColumn>)> {
    use RunColumn::{Diameter, Film, ImpactSpeedSd, ReboundSpeedSd, RestitutionSd, RestitutionSdOfRuns, RestitutionSe};
    let has = |list: &str| words.iter().any(|word| is_among(list, word));
    let of_mean = ["of the mean", "√", "sqrt"].iter().any(|of| lower.contains(of)) || has("mittelwerts");
    let is_error = has("err error errors fehler erreur") && (has("standard std st type") || of_mean);
    let is_deviation = has(SPREADS[0]) || has("standard") && has("deviation dev") || has("écart ecart") && has("type");
    let is_se = has(SPREADS[1]) || is_error || is_deviation && of_mean || lower.starts_with("s.e");
    let is_sd = is_deviation && !is_se;
    let se = ("a standard error", Some(RestitutionSe));
    let sd = ("a standard deviation", Some(RestitutionSdOfRuns));
    let is_extent = has("min") && has("max") || has("half") && has("width");
    let is_other = has(OTHER_SPREADS) || is_square_sign(lower) || is_multiple(lower) || is_extent;
    let other = ("a spread that is neither sd nor standard error", None);
    match column {
        RestitutionSdOfRuns | RestitutionSe if is_other => Some(other),
        RestitutionSdOfRuns => is_se.then_some(se),
        RestitutionSe => is_sd.then_some(sd),
        ImpactSpeedSd | ReboundSpeedSd | RestitutionSd => {
            let called = columns_called(lower);
            if !called.is_empty() && !lower.contains('±') && called.iter().all(|of| MEASURED.contains(of)) {
                return Some(("a quantity itself", called.first().copied()));
            }
            let divisor = lower.split_once('/').map(|(_, after)| after.trim());
            let is_relative = has("rel relative relativ") || divisor.is_some_and(|of| is_among("e en v vi v_i", of));
            let relative = ("a relative spread", None);
            is_other.then_some(other).or(is_relative.then_some(relative))
        }
        // the first word or the last, and no `mean and sd`
        _ if MEASURED.contains(&column) => {
            let ends = [words.first()?, words.last()?];
            // a film or sphere is measured by SEM, a microscope
            let may_be_se = !matches!(column, Film | Diameter);
            let is_end = |list: &str| ends.iter().any(|word| is_among(list, word));
            let is_spread = is_error || is_end(SPREADS[0]) || may_be_se && is_end(SPREADS[1]) || is_end("error fehler");
            (is_spread && !has("mean avg average mittel mittelwert"))
                .then_some(("the spread or error of a quantity", None))
        }
        _ => None,
    }
}

/// Whether a spread is written with a number before it, as `2σ` is.
fn is_multiple(lower: &str) -> bool {
    let after = lower.trim_start_matches(['±', ' ']);
    let spread = after.trim_start_matches(|c: char| c.is_ascii_digit() || ".,".contains(c));
    let of = spread.trim_start_matches(['·', '*', '×', ' ']);
    let is_spread = |word: &&str| *word == "s" || SPREADS.iter().any(|list| is_among(list, word));
    spread.len() < after.len() && words_of(of).first().is_some_and(is_spread)
}

/// Whether a quotient stands upside down, as `v_i/v_r` does of a restitution.
fn is_inverse(lower: &str, column: RunColumn) -> bool {
    if lower.starts_with("1/") {
        return true;
    }
    let below = match column {
        RunColumn::Restitution => [RunColumn::ReboundSpeed, RunColumn::Restitution],
        RunColumn::FilmRatio => [RunColumn::Film, RunColumn::FilmRatio],
        _ => return false,
    };
    let after = lower.split_once(['/', ':']).map(|(_, after)| columns_called(after));
    after.is_some_and(|called| !called.is_empty() && called.iter().all(|of| below.contains(of)))
}

/// Whether a word is one of a list, or ends with one as `falltime` does.
fn is_called(list: &str, word: &str) -> bool {
    let is_end = |own: &str| own.chars().count() >= "time".len() && word.ends_with(own);
    list.split(' ').any(|own| own == word || is_end(own))
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

/// What a header says that some power or factor turns into the quantity of its column, and how.
fn known_conversion(written: &str, column: RunColumn) -> Option<&'static str> {
    let name = written.to_lowercase();
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
        RunColumn::Restitution if is_square(&name, &words) || is_ratio_of_squares(written) => Some(
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
    // the `10 v` of nobody's unit
    let mut words = name.split_whitespace();
    let is_first = words.next().is_some_and(is_power);
    if is_first
        && words
            .next()
            .is_some_and(|next| next.starts_with(char::is_alphabetic) && unit_of(next).is_none())
    {
        return true;
    }
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
    let by_sign = is_square_sign(name);
    let by_word = words.iter().any(|word| is_among(SQUARES, word));
    let of_energy = words
        .iter()
        .any(|word| ENERGIES.split(' ').any(|energy| word.starts_with(energy)));
    by_sign || by_word || of_energy
}

fn is_square_sign(name: &str) -> bool {
    // the `²⁾` of a footnote squares nothing
    let is_footnote = name.contains("²)") || name.contains("²⁾");
    !is_footnote && ["²", "^2", "**2"].iter().any(|sign| name.contains(sign))
}

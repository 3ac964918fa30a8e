//! Reads from a header which point of the sphere a height refers to, and what it is measured from.

use super::super::words::is_among;
use super::header::Header;
use super::named::ROLES;
use crate::error::quoted;
use crate::scene::{HeightsOf, HeightsTo, Naming, RunColumn};

const CENTRE: &str =
    "centre center ctr centroid barycentre barycenter com cog cg mid midpoint zentrum kugelzentrum mitte kugelmitte \
     mittelpunkt mittelpunkts mittelpunktes kugelmittelpunkt kugelmittelpunkts kugelmittelpunktes mittelpunktshöhe \
     schwerpunkt schwerpunkts schwerpunktes schwerpkt kugelschwerpunkt kugelschwerpunkts schwerpunktshöhe schwerpunkthöhe \
     massenmittelpunkt massenmittelpunkts massenmittelpunktes";
const LOWEST: &str =
    "lowest bottom underside unterkante unterseite kugelunterkante kugelunterseite tiefster tiefsten tiefste";
// the `top` of a rebound, like an apex, may be where the sphere turns, unless it is said to be the sphere's
const TOP: &str = "oberkante oberseite kugeloberkante kugeloberseite";
const SPHERE: &str = "sphere ball bead kugel";
const ABOVE: &str = "above over über ueber";
/// The same before what is not the sphere.
const FROM: &str = "from ab";
/// The same before what is neither plate nor film.
const BELOW_OR_TO: &str = "below under beneath to unter von bis zur zum";
const OF: &str = "the of a an der die das dem den des silicone";
const FILM: &str =
    "film liquid oil layer flüssigkeit fluessigkeit flüssigkeitsfilm öl oel ölfilm schicht filmoberfläche \
     flüssigkeitsoberfläche öloberfläche";
const PLATE: &str = "plate glass wall substrate platte glas wand substrat";
const OTHERS: &str =
    "image picture frame bild view tray dish cell box table line ruler scale camera sensor lens wanne \
                      schale tisch linie lineal kamera";
/// What a height is measured from that falls on neither plate nor film.
const ELSEWHERE: &str =
    "ceiling roof lid floor table tabletop bench desk decke deckel dach tisch tischplatte fußboden plafond";
const AFTER_FILM: &str = "surface oberfläche layer film mm cm m µm um in";

/// Words of which point of the sphere a height refers to, and of what it is measured from.
pub(super) const OF_HEIGHTS: [&str; 10] = [CENTRE, LOWEST, TOP, SPHERE, ABOVE, FROM, OF, FILM, PLATE, OTHERS];

/// What a name or title of heights asks for in place of what `[data]` says of them: another value of a key, or other heights;
/// `None` where it agrees or says nothing. `by` is what says so.
pub(in crate::runs) fn other_height(name: &str, by: &str, column: RunColumn, naming: &Naming) -> Option<String> {
    if !matches!(column, RunColumn::DropHeight | RunColumn::ReboundHeight) {
        return None;
    }
    let name = name.replace("c.o.g", "cog").replace("c.o.m", "com");
    let header = Header::new(&name);
    let words: Vec<&str> = header.words.iter().map(String::as_str).collect();
    let is_from = |word: &str| [ABOVE, FROM, BELOW_OR_TO].iter().any(|list| is_among(list, word));
    let bare = without_articles(&words);
    if let Some(from) = bare
        .windows(2)
        .find(|both| is_from(both[0]) && is_among(ELSEWHERE, both[1]))
    {
        let place = quoted(from[1]);
        return Some(format!(
            "by {by} its heights are measured from {place}: expected those above the plate or the film"
        ));
    }
    let is_above = |at: &usize| {
        let next = words[at + 1..].iter().find(|word| !is_among(OF, word));
        let is_of_plate = next.is_some_and(|word| is_among(FILM, word) || is_among(PLATE, word));
        is_among(ABOVE, words[*at]) || is_among(FROM, words[*at]) && is_of_plate
    };
    let at = (0..words.len()).find(is_above).unwrap_or(words.len());
    let (point, above) = words.split_at(at);
    // the centre of the plate is not the sphere's
    let of_sphere = |list: &str| {
        let named = without_articles(point);
        let found = named.iter().position(|word| is_among(list, word));
        let is_others = |at: usize| {
            let word = named.get(at);
            word.is_some_and(|word| is_among(PLATE, word) || is_among(OTHERS, word))
        };
        found.is_some_and(|found| !is_others(found + 1) && !is_others(found.wrapping_sub(1)))
    };
    let may_turn_there = column == RunColumn::ReboundHeight || header.has_end(ROLES[1]);
    let is_of_sphere = || words.iter().any(|word| is_among(SPHERE, word));
    let is_top = of_sphere(TOP) || of_sphere("top oben") && (!may_turn_there || is_of_sphere());
    if is_top && !of_sphere(CENTRE) && !of_sphere(LOWEST) {
        return Some(format!(
            "by {by} its heights are of the sphere's top: expected those of its lowest point or centre"
        ));
    }
    let is_of = |list: &str, other: &str| of_sphere(list) && !of_sphere(other);
    let above = without_articles(above.get(1..).unwrap_or_default());
    let is_above = |list: &str| match above.split_first() {
        Some((first, rest)) => is_among(list, first) && rest.iter().all(|word| is_among(AFTER_FILM, word)),
        None => false,
    };
    let (key, value, says) = match (naming.heights_of, naming.heights_to) {
        (HeightsOf::Lowest, _) if is_of(CENTRE, LOWEST) => ("heights_of", "centre", "of the sphere's centre"),
        (HeightsOf::Centre, _) if is_of(LOWEST, CENTRE) => ("heights_of", "lowest", "of its lowest point"),
        (_, HeightsTo::Plate) if is_above(FILM) => ("heights_to", "film", "above the film"),
        (_, HeightsTo::Film) if is_above(PLATE) => ("heights_to", "plate", "above the plate"),
        _ => return None,
    };
    Some(format!(
        "by {by} its heights are {says}: expected `{key} = \"{value}\"` in [data], or another name or column"
    ))
}

/// The same of a line about the whole table that says of which point of the sphere heights are, where the scene does not.
pub(in crate::runs) fn other_height_by_line(line: &str, column: RunColumn, naming: &Naming) -> Option<String> {
    const HEIGHTS: &str = "height höhe hoehe";
    /// words of a line that says no more than the point
    const FEW: usize = 3;
    let lower = line.to_lowercase();
    let has = |list: &str| list.split(' ').any(|word| lower.contains(word));
    let speaks = has(HEIGHTS) || has(SPHERE) && lower.split_whitespace().count() <= FEW;
    if naming.heights_of_is_told || !speaks {
        return None;
    }
    let told = other_height(line, &format!("the line {}", quoted(line)), column, naming)?;
    told.contains("heights_of")
        .then(|| told.replace(", or another name or column", ", or \"lowest\" where it is not so"))
}

fn without_articles<'w>(words: &[&'w str]) -> Vec<&'w str> {
    words.iter().copied().filter(|word| !is_among(OF, word)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::tests::examples;

    #[test]
    fn a_header_says_of_which_point_and_above_what_heights_are() {
        let told = |name: &str, heights_of, heights_to| {
            let naming = Naming {
                heights_of,
                heights_to,
                ..Naming::default()
            };
            other_height(name, "its name", RunColumn::DropHeight, &naming).unwrap_or_default()
        };
        let asked = |name: &str, heights_of, heights_to| {
            let told = told(name, heights_of, heights_to);
            told.split('`').nth(1).unwrap_or_default().to_owned()
        };
        let [lowest, centre] = [HeightsOf::Lowest, HeightsOf::Centre];
        let [plate, film] = [HeightsTo::Plate, HeightsTo::Film];
        for (answer, names) in examples("height") {
            let (expected, where_right) = match answer {
                "centre" => ("heights_of = \"centre\"", (centre, plate)),
                "film" => ("heights_to = \"film\"", (lowest, film)),
                _ => ("", (centre, film)),
            };
            for name in names {
                assert_eq!(asked(name, lowest, plate), expected, "{name}");
                assert_eq!(asked(name, where_right.0, where_right.1), "", "{name}");
            }
        }
        let of_lowest = asked("height (mm, lowest point)", centre, plate);
        assert_eq!(of_lowest, "heights_of = \"lowest\"");
        assert_eq!(asked("h above glass", lowest, film), "heights_to = \"plate\"");
        assert!(told("h (mm), top of the ball", lowest, plate).contains("sphere's top"));
    }
}

//! Reads from a header which point of the sphere a height refers to, and what it is measured from.

use super::super::words::is_among;
use super::header::Header;
use crate::scene::{HeightsOf, HeightsTo, Naming, RunColumn};

const CENTRE: &str = "centre center zentrum mitte mittelpunkt kugelmitte kugelmittelpunkt schwerpunkt centroid";
const LOWEST: &str = "lowest bottom underside unterkante unterseite";
const ABOVE: &str = "above over über ueber";
const ARTICLES: &str = "the of a an der die das dem den";
const FILM: &str = "film liquid oil layer flüssigkeit fluessigkeit öl oel schicht";
const PLATE: &str = "plate glass wall substrate platte glas wand substrat";

/// The key of `[data]` that a header of heights contradicts, with the value that it asks for; `None` where it agrees or says
/// nothing.
pub(in crate::runs) fn other_height(name: &str, column: RunColumn, naming: &Naming) -> Option<String> {
    if !matches!(column, RunColumn::DropHeight | RunColumn::ReboundHeight) {
        return None;
    }
    let header = Header::new(name);
    // what stands after `above`
    let words = header.words.iter().skip_while(|word| !is_among(ABOVE, word)).skip(1);
    let above = words.map(String::as_str).find(|word| !is_among(ARTICLES, word));
    let is_above = |list: &str| above.is_some_and(|word| is_among(list, word));
    let has_one = |list: &str, other: &str| header.has(list) && !header.has(other);
    let (key, value, says) = match (naming.heights_of, naming.heights_to) {
        (HeightsOf::Lowest, _) if has_one(CENTRE, LOWEST) => ("heights_of", "centre", "of the sphere's centre"),
        (HeightsOf::Centre, _) if has_one(LOWEST, CENTRE) => ("heights_of", "lowest", "of its lowest point"),
        (_, HeightsTo::Plate) if is_above(FILM) => ("heights_to", "film", "above the film"),
        (_, HeightsTo::Film) if is_above(PLATE) => ("heights_to", "plate", "above the plate"),
        _ => return None,
    };
    Some(format!(
        "by its name its heights are {says}: expected `{key} = \"{value}\"` in [data], or another name or column"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_says_of_which_point_and_above_what_heights_are() {
        let asked = |name: &str, heights_of, heights_to| {
            let naming = Naming {
                heights_of,
                heights_to,
                ..Naming::default()
            };
            let told = other_height(name, RunColumn::DropHeight, &naming).unwrap_or_default();
            told.split('`').nth(1).unwrap_or_default().to_owned()
        };
        let [lowest, centre] = [HeightsOf::Lowest, HeightsOf::Centre];
        let [plate, film] = [HeightsTo::Plate, HeightsTo::Film];
        for name in ["h centre (mm)", "Höhe der Kugelmitte", "height of the center"] {
            assert_eq!(asked(name, lowest, plate), "heights_of = \"centre\"");
            assert_eq!(asked(name, centre, plate), "");
        }
        assert_eq!(
            asked("height (mm, lowest point)", centre, plate),
            "heights_of = \"lowest\""
        );
        for name in [
            "h above film",
            "Höhe über der Flüssigkeit",
            "drop height above the liquid",
        ] {
            assert_eq!(asked(name, lowest, plate), "heights_to = \"film\"");
            assert_eq!(asked(name, lowest, film), "");
        }
        assert_eq!(asked("h above glass", lowest, film), "heights_to = \"plate\"");
        for name in [
            "h",
            "drop height",
            "height above surface",
            "film height",
            "Mitte über Unterkante",
        ] {
            assert_eq!(asked(name, lowest, plate), "");
            assert_eq!(asked(name, centre, film), "");
        }
    }
}

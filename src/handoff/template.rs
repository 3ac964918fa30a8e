//! Fills the places of a template, written `{{name}}`, with texts.

/// The template with each place filled; a place without a text keeps its name, which a test would see.
pub(super) fn filled(template: &str, places: &[(&str, String)]) -> String {
    let mut parts = template.split("{{");
    let mut text = parts.next().unwrap_or_default().to_owned();
    // in one pass, so that what a text holds is never taken for a place
    for part in parts {
        let found = part.split_once("}}").and_then(|(name, rest)| {
            let place = places.iter().find(|(place, _)| *place == name)?;
            Some((&place.1, rest))
        });
        match found {
            Some((filling, rest)) => text.extend([filling, rest]),
            None => text.extend(["{{", part]),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_filled_once() {
        let places = [("a", "{{b}}".to_owned()), ("b", "1".to_owned())];
        assert_eq!(filled("x {{a}} {{b}}{{c}}", &places), "x {{b}} 1{{c}}");
    }
}

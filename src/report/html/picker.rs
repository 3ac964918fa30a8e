//! Writes the part of the page in which a reader picks a pair and sees its restitution.

use super::super::json;
use super::super::markup::escaped;
use super::curves::Curves;
use crate::error::Error;

/// The part; nothing where no pair has a curve.
pub(super) fn section(curves: &Curves) -> Result<String, Error> {
    if curves.pairs.is_empty() {
        return Ok(String::new());
    }
    let options: String = curves
        .pairs
        .iter()
        .enumerate()
        .map(|(place, pair)| format!("<option value=\"{place}\">{}</option>\n", escaped(&pair.name)))
        .collect();
    let left_out = match curves.left_out {
        0 => String::new(),
        n => format!(" {n} more pairs had no room here; <code>wetcor predict</code> has them."),
    };
    let source = escaped(&curves.source);
    // a script of this type is data: all it must not hold is what would end it
    let data = json::text(curves)?.replace('<', "\\u003c");
    Ok(format!(
        "<section id=\"picker\">\n<h2>Restitution of one pair</h2>\n\
         <p>Pick a pair to see its e_n(v): {source}; dashed beyond the speeds of its runs. Points are means of repeated \
         speeds with their standard errors, hollow ones runs that stuck.{left_out}</p>\n\
         <noscript><p>Picking needs JavaScript; nothing is loaded or sent.</p></noscript>\n\
         <p class=\"controls\"><label>Pair <select id=\"pair\">\n{options}</select></label>\n\
         <label>v <input id=\"speed\" type=\"range\" min=\"0\" step=\"1\"></label></p>\n\
         <p><output id=\"answer\" for=\"pair speed\"></output></p>\n\
         <svg id=\"curve\" role=\"img\" aria-label=\"restitution against impact speed of the picked pair\"></svg>\n\
         <script type=\"application/json\" id=\"curves\">{data}</script>\n<script>\n{}</script>\n</section>\n",
        include_str!("picker.js")
    ))
}

#[cfg(test)]
mod tests {
    use super::super::curves::PairCurve;
    use super::*;

    #[test]
    fn no_name_ends_the_script_or_an_option() {
        let name = "</script><b>".to_owned();
        let pair = PairCurve {
            name,
            wet: true,
            measured: vec![0.5, 1.0],
            restitution: vec![0.7],
            band: vec![],
            rebounds: vec![],
            stuck: vec![],
        };
        let curves = Curves {
            speeds: vec![0.5],
            pairs: vec![pair],
            left_out: 2,
            ..Curves::default()
        };
        let text = section(&curves).expect("a section");
        assert_eq!(text.matches("</script>").count(), 2, "{text}");
        assert!(text.contains(">&lt;/script&gt;&lt;b&gt;</option>") && text.contains(" 2 more pairs"));
        assert_eq!(section(&Curves::default()).expect("none"), "");
    }
}

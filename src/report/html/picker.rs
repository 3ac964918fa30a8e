//! Writes the part of the page in which a reader picks a pair and sees its restitution.

use minijinja::context;

use super::super::markup::escaped;
use super::super::{json, template};
use super::curves::Curves;
use crate::error::Error;

/// The part; nothing where no pair has a curve.
pub(super) fn section(curves: &Curves) -> Result<String, Error> {
    let options = curves.pairs.iter().map(|pair| escaped(&pair.name));
    let values = context! {
        options => options.collect::<Vec<_>>(),
        left_out => curves.left_out,
        source => escaped(&curves.source),
        // a script of this type is data: all it must not hold is what would end it
        data => json::text(curves)?.replace('<', "\\u003c"),
        script => include_str!("picker.js"),
    };
    template::plain("picker.html", &values)
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

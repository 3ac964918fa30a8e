//! Fills the templates of the report, `templates/*`, which are Markdown, text or CSV with the commands of minijinja.
//!
//! A template may break the lines of a paragraph or of an entry of a list wherever it likes: they are joined. What stands
//! between `{% filter table %}` and `{% endfilter %}` is a table, a row a line with ` | ` between the cells, its headers
//! first; a column whose header ends with `?` stands only where something stands in it. Between
//! `{% filter figure("name.svg", "short") %}` and `{% endfilter %}` stands the caption of a figure, which is placed once and
//! only where it was drawn. The other filters are below: numbers with as many digits as they have, and names.

use std::sync::{Arc, Mutex};

use minijinja::syntax::SyntaxConfig;
use minijinja::value::{merge_maps, Kwargs, Serde};
use minijinja::{Environment, UndefinedBehavior, Value};
use serde::Serialize;
use textwrap::core::display_width;

use super::escape::{code, destination, guarded, literal};
use crate::error::{quoted, Error};
use crate::findings::learnt::capital;
use crate::findings::remarks::in_symbols;
use crate::rounding::{self, by_number, positive, NONE};
use crate::units::micrometres;

/// The templates by their names.
const TEMPLATES: [(&str, &str); 32] = [
    ("against_film.md", include_str!("templates/against_film.md")),
    ("against_speed.md", include_str!("templates/against_speed.md")),
    ("bands.txt", include_str!("templates/bands.txt")),
    ("calibration.md", include_str!("templates/calibration.md")),
    ("cautions.txt", include_str!("templates/cautions.txt")),
    ("constants.md", include_str!("templates/constants.md")),
    ("errors.md", include_str!("templates/errors.md")),
    ("film_groups.md", include_str!("templates/film_groups.md")),
    ("fitted_runs.txt", include_str!("templates/fitted_runs.txt")),
    ("held.md", include_str!("templates/held.md")),
    ("laws.csv", include_str!("templates/laws.csv")),
    ("laws.md", include_str!("templates/laws.md")),
    ("laws_table.csv", include_str!("templates/laws_table.csv")),
    ("main_numbers.md", include_str!("templates/main_numbers.md")),
    ("materials.md", include_str!("templates/materials.md")),
    ("noise.md", include_str!("templates/noise.md")),
    ("other_forms.txt", include_str!("templates/other_forms.txt")),
    ("overview.txt", include_str!("templates/overview.txt")),
    ("picker.html", include_str!("templates/picker.html")),
    ("places.md", include_str!("templates/places.md")),
    ("posterior.md", include_str!("templates/posterior.md")),
    ("predicted.csv", include_str!("templates/predicted.csv")),
    ("report.md", include_str!("templates/report.md")),
    ("scaling.md", include_str!("templates/scaling.md")),
    ("seen.txt", include_str!("templates/seen.txt")),
    ("source.txt", include_str!("templates/source.txt")),
    ("summary.txt", include_str!("templates/summary.txt")),
    ("terms.md", include_str!("templates/terms.md")),
    ("tracking.md", include_str!("templates/tracking.md")),
    ("tracking.txt", include_str!("templates/tracking.txt")),
    ("trade.md", include_str!("templates/trade.md")),
    ("verdict.txt", include_str!("templates/verdict.txt")),
];

/// Longer tables are cut to so many rows: nobody reads more, and a file has them all.
const MOST_ROWS: usize = 60;

/// Stands for a `|` of a value, until it is known whether it stands in a table.
const BAR: char = '\u{1}';

/// Stands for a `|` between the cells of a table that is made.
const RULE: char = '\u{2}';

/// A page of the report in Markdown. `figures` are the names of those that were drawn.
///
/// Fails where a template asks for what there is not.
pub(crate) fn page(name: &str, values: &Value, figures: &[&str]) -> Result<String, Error> {
    Ok(laid_out(&filled(name, values, figures)?))
}

/// The same as a text for a terminal or as CSV, line by line as the template has it.
pub(super) fn plain(name: &str, values: &Value) -> Result<String, Error> {
    Ok(filled(name, values, &[])?.replace(BAR, "|"))
}

/// What a template may name of a row: its fields as files have them, and more.
pub(crate) fn with(row: &impl Serialize, more: Value) -> Value {
    merge_maps([serialized(row), more])
}

/// The fields of a row as files have them.
pub(crate) fn serialized(row: impl Serialize) -> Value {
    Value::from(Serde(row))
}

fn filled(name: &str, values: &Value, figures: &[&str]) -> Result<String, Error> {
    filled_from(&TEMPLATES, name, values, figures)
}

/// The template of this name, filled; it may include the others.
fn filled_from(templates: &[(&str, &str)], name: &str, values: &Value, figures: &[&str]) -> Result<String, Error> {
    let fail = |error: minijinja::Error| {
        let whole = std::iter::successors(Some(&error as &dyn std::error::Error), |error| error.source());
        Error::Internal {
            doing: "fill the template of the report",
            reason: whole.map(ToString::to_string).collect::<Vec<_>>().join(": "),
        }
    };
    let mut environment = Environment::new();
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build();
    environment.set_syntax(syntax.map_err(fail)?);
    for (name, text) in templates {
        environment.add_template(name, text).map_err(fail)?;
    }
    environment.set_undefined_behavior(UndefinedBehavior::SemiStrict);
    environment.set_formatter(|out, _, value| {
        let text = if value.is_none() {
            NONE.to_owned()
        } else {
            value.to_string()
        };
        Ok(out.write_str(&text.replace('|', &BAR.to_string()))?)
    });
    add_filters(&mut environment);
    let drawn: Vec<String> = figures.iter().map(|name| (*name).to_owned()).collect();
    let left = Arc::new(Mutex::new(drawn));
    environment.add_filter("figure", move |caption: String, name: String, short: String| {
        let mut left = left.lock().unwrap_or_else(|broken| broken.into_inner());
        let Some(at) = left.iter().position(|own| *own == name) else {
            return String::new();
        };
        left.remove(at);
        let address = destination(&name);
        format!("![{}](figures/{address})\n\n*{}*\n", guarded(&short), caption.trim())
    });
    let template = environment.get_template(name).map_err(fail)?;
    template.render(values).map_err(fail)
}

/// What stands in a page of a number that there may be none of.
fn or_none<T>(of: Option<T>, text: impl FnOnce(T) -> String) -> String {
    of.map_or(NONE.to_owned(), text)
}

fn add_filters(environment: &mut Environment) {
    let mut number = |name: &'static str, text: fn(f64) -> String| {
        environment.add_filter(name, move |x: Option<f64>| or_none(x, text));
    };
    number("short", rounding::short);
    number("signed", rounding::signed);
    number("probability", rounding::probability);
    environment.add_filter("digits", rounding::optional);
    environment.add_filter("fixed", |x: Option<f64>, places: usize| {
        or_none(x, |x| format!("{x:.places$}"))
    });
    environment.add_filter("signed_to", |x: Option<f64>, place: i32| {
        or_none(x, |x| rounding::signed_to(x, place))
    });
    environment.add_filter("shift", |x: Option<f64>, se: Option<f64>| {
        or_none(x, |x| rounding::shift(x, se))
    });
    environment.add_filter("by_mcse", rounding::by_mcse);
    environment.add_filter("range", |ends: Option<Vec<f64>>, factor: Option<f64>| {
        let factor = factor.unwrap_or(1.0);
        or_none(ends_of(ends), |ends| rounding::range(ends.map(|x| x * factor)))
    });
    environment.add_filter("between", |ends: Option<Vec<f64>>, se: f64| {
        or_none(ends_of(ends), |[lo, hi]| rounding::between(lo, hi, se))
    });
    environment.add_filter("listed", listed);
    environment.add_filter("full", |x: Option<f64>| {
        let finite = x.filter(|x| x.is_finite());
        finite.map_or(String::new(), |x| format!("{x:?}"))
    });
    environment.add_filter("estimate", |own: Value, factor: Option<f64>| {
        Number::of(&own, factor).map(|own| own.with_its_interval())
    });
    environment.add_filter("pm", |own: Value, factor: Option<f64>, is_exponential: Option<bool>| {
        Number::of(&own, factor).map(|own| {
            let wide = own.wide_exponential().filter(|_| is_exponential == Some(true));
            wide.unwrap_or_else(|| own.with_its_error())
        })
    });
    environment.add_filter("length_of_exponential", |own: Value| {
        Number::of(&own, Some(micrometres(1.0))).map(|own| own.length_of_exponential())
    });
    environment.add_filter("value", |own: Value, factor: Option<f64>| {
        Number::of(&own, factor).map(|own| rounding::optional(own.value, 4))
    });
    environment.add_filter(
        "interval",
        |own: Value, factor: Option<f64>, is_exponential: Option<bool>| {
            Number::of(&own, factor).map(|own| match own.interval {
                Some(ends) if is_exponential == Some(true) && own.wide_exponential().is_some() => rounding::range(ends),
                _ => own.interval_alone(),
            })
        },
    );
    environment.add_filter("with_se", |x: Option<f64>, se: Option<f64>, factor: Option<f64>| {
        let factor = factor.unwrap_or(1.0);
        or_none(x.zip(se), |(x, se)| rounding::with_se(factor * x, factor * se))
    });
    environment.add_filter("source", |name: String| {
        name.replace("square_root", "square-root").replace('_', " ")
    });
    environment.add_filter("code", |text: String| code(&text));
    environment.add_filter("quoted", |text: String| quoted(&text));
    environment.add_filter("literal", |text: String| literal(&text));
    environment.add_filter("capital", |text: String| capital(&text));
    environment.add_filter("symbol", |name: String| in_symbols(&name));
    environment.add_filter("counted", |count: usize, one: String, more: String| {
        by_number(count, &one, &more).to_owned()
    });
    environment.add_filter("why_not", |verdict: Value| -> Result<String, minijinja::Error> {
        let passed = verdict.get_attr("passed")?.is_true();
        Ok(if passed {
            String::new()
        } else {
            verdict.get_attr("reason")?.to_string()
        })
    });
    environment.add_filter("table", table);
    environment.add_filter("columns", columns);
}

/// What stands for an exponential, as δc = ε exp(L), whose interval spans too much.
const UNTOLD: &str = "not told by the runs";

/// Whether the ends of an interval of an exponential are more than a factor of 1000 apart.
fn spans_too_much([lo, hi]: [f64; 2]) -> bool {
    const WIDEST: f64 = 1000.0;
    hi > WIDEST * lo
}

/// A value with its error and its interval, as an estimate, a main number or the summary of a posterior has them.
struct Number {
    value: Option<f64>,
    se: Option<f64>,
    mcse: Option<f64>,
    median: Option<f64>,
    interval: Option<[f64; 2]>,
}

impl Number {
    /// Of a row of the findings, times a factor.
    fn of(row: &Value, factor: Option<f64>) -> Result<Number, minijinja::Error> {
        let factor = factor.unwrap_or(1.0);
        let field = |names: [&str; 2]| {
            let found = names
                .into_iter()
                .find_map(|name| row.get_attr(name).ok()?.try_into().ok());
            found.map(|x: f64| factor * x)
        };
        Ok(Number {
            value: field(["value", "mean"]),
            se: positive(field(["se", "sd"])),
            mcse: positive(field(["mcse", "mcse_mean"])),
            median: field(["median", "median"]),
            interval: interval_of(row).map(|ends| ends.map(|x| factor * x)),
        })
    }

    /// `value ± se`, without a standard error the value, with its interval where that is all there is.
    fn with_its_interval(&self) -> String {
        match (self.value, self.se, self.interval) {
            (Some(value), None, Some(_)) => {
                format!("{} (no ±: {})", rounding::significant(value, 4), self.interval_alone())
            }
            _ => self.with_its_error(),
        }
    }

    /// The same where the interval stands beside it. A posterior has no digit that its Monte Carlo error leaves open.
    fn with_its_error(&self) -> String {
        rounding::with_error(self.value, self.se, self.mcse)
    }

    /// An exponential whose interval spans so much that a mean ± sd says nothing of it.
    fn wide_exponential(&self) -> Option<String> {
        const WIDE: f64 = 10.0;
        let [lo, hi] = self.interval?;
        if spans_too_much([lo, hi]) {
            return Some(UNTOLD.to_owned());
        }
        let median = self.median.filter(|_| hi > WIDE * lo)?;
        Some(format!("{} (median)", rounding::significant(median, 3)))
    }

    /// The median with the interval of a length that is an exponential, in µm.
    fn length_of_exponential(&self) -> String {
        let told = match self.interval.filter(|ends| spans_too_much(*ends)) {
            Some(_) => UNTOLD.to_owned(),
            None => format!("{} µm", rounding::optional(self.median, 3)),
        };
        let interval = self.interval.map(|ends| format!(", {} µm", rounding::range(ends)));
        told + &interval.unwrap_or_default()
    }

    /// The interval, rounded as its error is, without one by a quarter of its width.
    fn interval_alone(&self) -> String {
        or_none(self.interval, |[lo, hi]| {
            rounding::between(lo, hi, self.se.unwrap_or(0.25 * (hi - lo)))
        })
    }
}

fn interval_of(row: &Value) -> Option<[f64; 2]> {
    let interval = row.get_attr("interval").ok()?;
    let end = |index: usize| f64::try_from(interval.get_item_by_index(index).ok()?).ok();
    Some([end(0)?, end(1)?])
}

fn ends_of(ends: Option<Vec<f64>>) -> Option<[f64; 2]> {
    ends?.try_into().ok()
}

/// Numbers in a row; a long list says less than its ends.
fn listed(values: Vec<f64>, factor: Option<f64>) -> String {
    const LONG: usize = 8;
    let texts: Vec<String> = values
        .iter()
        .map(|x| rounding::short(x * factor.unwrap_or(1.0)))
        .collect();
    match texts.as_slice() {
        [first, .., last] if texts.len() > LONG => format!("{} from {first} to {last}", texts.len()),
        _ => texts.join(", "),
    }
}

/// Lines of cells, cell by cell.
fn rows_of(text: &str) -> Vec<Vec<&str>> {
    let lines = text.lines().filter(|line| !line.trim().is_empty());
    lines.map(|line| line.split('|').map(str::trim).collect()).collect()
}

/// Lines whose cells stand below each other, with this between two columns; `room` is what the letters of a cell take.
fn below_each_other(rows: &[Vec<&str>], between: &str, room: fn(&str) -> usize) -> Vec<String> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let widest = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| room(cell)).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(widest).collect();
    let line = |row: &Vec<&str>| {
        let padded = row.iter().zip(&widths);
        let padded = padded.map(|(cell, width)| format!("{cell}{}", " ".repeat(width - room(cell))));
        format!("{}\n", padded.collect::<Vec<_>>().join(between).trim_end())
    };
    rows.iter().map(line).collect()
}

/// Makes a table of lines of cells: in Markdown, or with `plain` in columns as wide as what stands in them. With `whole` it has
/// every row, where no file has what would be left out.
fn table(text: String, options: Kwargs) -> Result<String, minijinja::Error> {
    let is = |name: &str| Ok::<_, minijinja::Error>(options.get::<Option<bool>>(name)?.unwrap_or(false));
    let (plain, whole) = (is("plain")?, is("whole")?);
    let mut rows = rows_of(&text);
    let Some(headers) = rows.first() else {
        return Ok(String::new());
    };
    let has_text = |cell: &&str| !cell.is_empty() && *cell != NONE;
    let is_filled = |column: usize| rows[1..].iter().any(|row| row.get(column).is_some_and(has_text));
    let stands = |column: &usize| !headers[*column].ends_with('?') || is_filled(*column);
    let kept: Vec<usize> = (0..headers.len()).filter(stands).collect();
    let most = if whole { usize::MAX } else { MOST_ROWS };
    let below = rows.len() - 1;
    rows.truncate(most.saturating_add(1));
    for row in &mut rows {
        let cells = kept.iter().map(|column| row.get(*column).copied().unwrap_or_default());
        *row = cells.collect();
    }
    for header in &mut rows[0] {
        *header = header.trim_end_matches('?');
    }
    let mut text = String::new();
    if plain {
        text.extend(below_each_other(&rows, "  ", |cell| cell.chars().count()));
    } else {
        let line = |cells: &[&str]| format!("{RULE} {} {RULE}\n", cells.join(&format!(" {RULE} ")));
        for (number, row) in rows.iter().enumerate() {
            text.push_str(&line(row));
            if number == 0 {
                text.push_str(&line(&vec!["---"; row.len()]));
            }
        }
        text.push('\n');
    }
    if below > most {
        text.push_str(&format!("The first {most} of {below} rows; findings.json has all.\n"));
    }
    Ok(text)
}

/// Makes lines of cells stand below each other on a terminal, the first of them where they are many.
fn columns(text: String) -> String {
    const SHOWN: usize = 20;
    let lines = below_each_other(&rows_of(&text), " ", display_width);
    let mut text = lines[..lines.len().min(SHOWN)].concat();
    if lines.len() > SHOWN {
        let more = lines.len() - SHOWN;
        text.push_str(&format!("and {more} more lines of this kind in findings.json\n"));
    }
    text
}

/// A page with one line for each paragraph, entry of a list and row, and one blank line between its blocks.
fn laid_out(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let blocks = lines.split(|line| line.is_empty()).filter(|block| !block.is_empty());
    let joined = |block: &[&str]| {
        let mut joined = String::new();
        for line in block {
            if !joined.is_empty() {
                let begins = line.starts_with([RULE, '#']) || line.starts_with("* ");
                joined.push(if begins { '\n' } else { ' ' });
            }
            joined.push_str(line);
        }
        let safe = joined.lines().map(|line| match line.starts_with(RULE) {
            true => guarded(&line.replace(BAR, "\\|").replace(RULE, "|")),
            // the words and the address of a figure are safe already
            false if line.starts_with("![") => line.to_owned(),
            false => guarded(&line.replace(BAR, "|")),
        });
        safe.collect::<Vec<_>>().join("\n")
    };
    let mut page = blocks.map(joined).collect::<Vec<_>>().join("\n\n");
    page.push('\n');
    page
}

#[cfg(test)]
mod tests {
    use minijinja::context;

    use super::*;

    /// A page of a template that is not among those of the report.
    fn page_of(template: &str, values: Value) -> String {
        let text = filled_from(&[("test.md", template)], "test.md", &values, &["a_b.svg"]);
        laid_out(&text.expect("a page"))
    }

    #[test]
    fn an_exponential_whose_interval_spans_too_much_is_not_told() {
        let template =
            "{{ row|pm(10, true) }}; {{ row|interval(10, true) }}; {{ row|pm(10) }}; {{ near|pm(1, true) }}; \
                        {{ wide|pm(1, true) }}, {{ wide|interval(1, true) }}";
        let row = context! { value => 4.1, se => 3.1, interval => [0.0024, 57000.0] };
        let wide = context! { value => 41.0, se => 90.0, median => 8.0, interval => [0.9, 190.0] };
        let near = context! { value => 4.1, se => 3.1, median => 3.9, interval => [2.1, 19.0] };
        let expected = "not told by the runs; 0.0240 to 570000; 41 ± 31; 4.1 ± 3.1; 8.00 (median), 0.900 to 190\n";
        assert_eq!(page_of(template, context! { row, near, wide }), expected);
    }

    #[test]
    fn columns_stand_below_each_other_whatever_the_letters() {
        let rows = "k[球] | = 0.18 ± 0.01 | (a)\nL | = 2 | (posterior)\n";
        assert_eq!(
            columns(rows.to_owned()),
            "k[球] = 0.18 ± 0.01 (a)\nL     = 2           (posterior)\n"
        );
    }
}

//! Holds figures that the pages quote against the reports they come from.

use super::{numbers_in, read, rows};
use crate::common::Says;

/// The least and the largest of a column's numbers over some rows.
fn range(rows: &[Vec<String>], column: usize, which: impl Fn(&[String]) -> bool) -> String {
    let of_rows = rows.iter().filter(|row| row.len() > column && which(row));
    let values: Vec<f64> = of_rows.flat_map(|row| numbers_in(&row[column])).collect();
    assert!(values.len() >= 2, "too few rows");
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(0.0, f64::max);
    format!("{least:.1} to {most:.1} %")
}

/// The first row of a report whose cells begin so.
fn first<'r>(report: &'r [Vec<String>], cells: &[&str]) -> &'r [String] {
    let begins = |row: &&Vec<String>| row.len() > 6 && row.iter().zip(cells).all(|(own, cell)| own.starts_with(cell));
    report.iter().find(begins).expect("a row")
}

#[test]
fn the_coverage_of_stuck_runs_is_that_of_the_report() {
    let report = rows(&read("reports/sticking.md"));
    let page = read("docs/stuck-runs.md");
    let told: Vec<Vec<String>> = rows(&page).into_iter().filter(|row| row.len() == 3).collect();
    assert_eq!(told.len(), 4);
    for row in told {
        for (noise, cell) in [("e", &row[1]), ("r", &row[2])] {
            let found = range(&report, 6, |own| own[0] == noise && own[2] == row[0]);
            assert_eq!(cell, &found, "{}", row[0]);
        }
    }
    let bias = &first(&report, &["r", "80 %", "linear"])[4];
    let bias = format!("too large by {:.1}", numbers_in(bias)[0]);
    page.says(&bias);
}

#[test]
fn the_coverage_of_offsets_is_that_of_the_report() {
    let report = rows(&read("reports/series_offsets.md"));
    let page = read("docs/scatter.md");
    let of = |columns: std::ops::Range<usize>, offsets: &str| {
        let own = report.iter().filter(|row| row.len() == 10 && row[1] == offsets);
        let cells = own.flat_map(|row| row[columns.clone()].iter().map(|cell| vec![cell.clone()]));
        range(&Vec::from_iter(cells), 0, |_| true)
    };
    let with = format!("its 95 % intervals cover {}", of(3..8, "yes"));
    let without = format!("those of L, C, e_inf and St_c cover {}", of(4..8, "no"));
    page.says(&with);
    page.says(&without);
}

#[test]
fn the_coverage_of_intervals_is_that_of_the_report() {
    let report: Vec<Vec<String>> = rows(&read("reports/calibration.md"));
    let laws = |row: &[String]| row.len() == 9 && ["sqrt", "linear"].contains(&row[1].as_str());
    // against the true e_inf the linear law is biased, which no interval mends
    let percentile = |which: &str| {
        let is_own = |row: &[String]| laws(row) && row[2] != "true e_inf" && row[0].contains(which);
        range(&report, 6, is_own)
    };
    let least = |range: &str| range.split(' ').next().unwrap_or_default().to_owned();
    let page = read("docs/uncertainty.md");
    let (paper, worst) = (percentile("paper"), least(&percentile("")));
    page.says(&format!("the default, percentile, cover {paper}"));
    page.says(&format!("on the worst of the designs {worst} %"));
    let of_st_c = &first(&report, &["heteroscedastic", "sqrt", "st_c"])[4];
    page.says(&format!("The delta method's cover {of_st_c} %"));
    let report = rows(&read("reports/accuracy.md"));
    let [of_tenths, finer] = ["0.1", "0.05"].map(|x| first(&report, &[x]));
    let told = format!(
        "It was kept in {} of {} simulated scenes, and 0.05 in {}",
        of_tenths[2], of_tenths[1], finer[2]
    );
    read("docs/speed.md").says(&told);
}

#[test]
fn times_and_errors_of_methods_are_those_of_the_reports() {
    let page = read("docs/speed.md");
    let parts: Vec<&str> = page.split("Where every run has a film of its own").collect();
    assert_eq!(parts.len(), 2);
    let mut compared = 0;
    for (part, report) in parts.into_iter().zip(["mueller2016-trade", "own_films-trade"]) {
        let report = rows(&read(&format!("reports/{report}/trade.md")));
        for row in rows(part).into_iter().filter(|row| row.len() == 3) {
            let name = row[0].split(':').next().unwrap_or_default();
            let own = report.iter().find(|own| own[0] == name).expect("its row");
            assert_eq!([&row[1], &row[2]], [&own[1], &own[2]], "{name}");
            compared += 1;
        }
    }
    assert_eq!(compared, 8);
}

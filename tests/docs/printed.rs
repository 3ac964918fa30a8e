//! Holds that the program prints what the pages show.

use super::{block, numbers_in, read};
use crate::common::{wetcor_here, Folder, Says};
use crate::laws;

/// A line without its numbers, and these.
fn words_and_numbers(line: &str) -> (String, Vec<f64>) {
    let of_number = |c: char| c.is_ascii_digit() || c == '.';
    let words = line.split(of_number).collect::<Vec<_>>().concat();
    let numbers = line.split(|c| !of_number(c)).filter_map(|number| number.parse().ok());
    (words, numbers.collect())
}

/// Another processor draws other numbers, within their Monte Carlo error.
fn is_nearly(shown: &str, printed: &str) -> bool {
    // differences of log density are near 0 here, of either sign
    let differs = shown.starts_with("inertia ");
    let most: f64 = if differs { 0.6 } else { 0.0 };
    let signs: &[char] = if differs { &['+', '−'] } else { &[] };
    let [shown, printed] = [shown, printed].map(|line| line.replace(signs, ""));
    let ((words, numbers), (other_words, others)) = (words_and_numbers(&shown), words_and_numbers(&printed));
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= most.max(0.1 * a.abs());
    words == other_words && numbers.len() == others.len() && numbers.iter().zip(&others).all(near)
}

#[test]
fn the_scene_and_runs_of_the_readme_are_fitted_as_it_says() {
    let folder = Folder::new();
    let text = read("README.md");
    std::fs::create_dir(folder.join("folder")).expect("writable");
    for (language, name) in [("toml", "folder/scene.toml"), ("csv", "folder/runs.csv")] {
        folder.write(name, block(&text, language));
    }
    let out = folder.succeed("check folder/scene.toml");
    out.says("9 runs read");
    let (status, out, err) = folder.run("fit folder/scene.toml");
    assert_eq!(status, Some(0), "{err}");
    let shown = block(&text, "text");
    let mut lines = shown.lines().zip(out.lines());
    let alike = lines.all(|(shown, printed)| is_nearly(shown, printed));
    let is_whole = shown.lines().count() == out.lines().count();
    assert!(alike && is_whole, "shown:\n{shown}\nprinted:\n{out}");
    assert!(!is_nearly("L = 1.85 ± 0.15", "L = 1.45 ± 0.15") && !is_nearly("k = 1", "L = 1"));
    assert!(folder.join("reports/folder/report.md").exists());
    out.begins(shown.lines().next().expect("a verdict"));
    assert_eq!(err.matches("notice: ").count(), 3, "{err}");
}

#[test]
fn the_prediction_is_what_the_page_shows() {
    let text = read("docs/prediction.md");
    let command = text.lines().find_map(|line| line.strip_prefix("    wetcor predict "));
    let words: Vec<&str> = command.expect("the page has this command").split(' ').collect();
    let (status, out, err) = wetcor_here(&[&["predict"], &words[..]].concat());
    assert_eq!(status, Some(0), "{err}");
    err.begins("notice: 2 of 5 speeds extrapolated: ");
    assert_eq!(err.lines().count(), 1, "{err}");
    let names = "restitution restitution_q05 restitution_q95 run_q05 run_q95 stuck_probability log_slope";
    let predicted = laws::rows(&out);
    assert_eq!(predicted.len(), 5);
    for row in predicted {
        let speed = &row["impact_speed_m_s"];
        let shown = text.lines().find(|line| line.starts_with(&format!("| {speed} |")));
        let shown = shown.unwrap_or_else(|| panic!("no row of {speed} m/s"));
        let shown = &numbers_in(shown)[1..];
        let printed: Vec<f64> = names.split(' ').filter_map(|name| row[name].parse().ok()).collect();
        // another processor draws other numbers, within their Monte Carlo error
        let near = shown.iter().zip(&printed).all(|(a, b)| (a - b).abs() < 2e-3);
        assert!(near && shown.len() == printed.len(), "{speed}: {shown:?} {printed:?}");
    }
}

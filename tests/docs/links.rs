//! Holds that links lead somewhere, also in the package, and that the README lists every page.

use std::process::Command;

use super::{assert_none, fenced, in_repository, pages, read, Page};

/// Where links and pictures of a text lead.
fn links(text: &str) -> Vec<&str> {
    let (_, outside) = fenced(text);
    let after = outside.into_iter().flat_map(|line| line.split("](").skip(1));
    after.filter_map(|rest| rest.split(')').next()).collect()
}

/// Where a link of a page leads, by its path from the root of the repository; `None` where nothing is.
fn target(page: &str, link: &str) -> Option<String> {
    let page = in_repository(page);
    let folder = page.parent().filter(|_| !link.is_empty());
    let path = folder.map_or(page.clone(), |folder| folder.join(link));
    let root = in_repository("").canonicalize().ok()?;
    let path = path.canonicalize().ok()?;
    Some(path.strip_prefix(root).ok()?.to_str()?.to_owned())
}

/// The name that a heading has in a link.
fn anchor(heading: &str) -> String {
    let is_kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
    let kept = heading.trim().chars().filter(is_kept);
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

fn has_heading(path: &str, name: &str) -> bool {
    let text = read(path);
    let (_, outside) = fenced(&text);
    let mut headings = outside.into_iter().filter(|line| line.starts_with('#'));
    headings.any(|line| anchor(line.trim_start_matches('#')) == name)
}

/// Links of a page that lead nowhere.
fn broken_links(page: &Page) -> Vec<String> {
    let leads_nowhere = |link: &&str| {
        let (file, heading) = link
            .split_once('#')
            .map_or((*link, None), |(file, name)| (file, Some(name)));
        let is_there = |path: String| heading.is_none_or(|name| has_heading(&path, name));
        !target(&page.path, file).is_some_and(is_there)
    };
    let inside = links(&page.text).into_iter().filter(|link| !link.contains("://"));
    let lost = inside.filter(leads_nowhere);
    lost.map(|link| format!("{}: {link}", page.path)).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let pages = pages();
    let count: usize = pages.iter().map(|page| links(&page.text).len()).sum();
    assert!(count > 40, "{count}");
    for page in &pages {
        assert_none(&broken_links(page), &page.path);
        let is_listed = links(&pages[0].text).contains(&page.path.as_str());
        assert!(is_listed || page.path == "README.md", "{}", page.path);
    }
    let linking = |link: &str| Page {
        path: "docs/any.md".to_owned(),
        text: format!("see [there]({link})\n"),
    };
    let leads = |link: &str| broken_links(&linking(link)).is_empty();
    assert!(leads("verdict.md") && leads("../README.md#your-own-data") && leads("verdict.md#the-report"));
    assert!(!leads("verdicts.md") && !leads("docs/verdict.md") && !leads("../README.md#your-runs"));
}

#[test]
fn the_package_holds_what_a_user_needs() {
    let output = Command::new(env!("CARGO"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["package", "--list", "--allow-dirty", "--offline"])
        .output()
        .expect("cargo can be started");
    let list = String::from_utf8_lossy(&output.stdout).replace('\\', "/");
    let is_in = |path: &str| {
        let inside = format!("{path}/");
        list.lines().any(|line| line == path || line.starts_with(&inside))
    };
    let pages = pages();
    let linked = pages.iter().flat_map(|page| {
        let inside = links(&page.text).into_iter().filter(|link| !link.contains("://"));
        inside.filter_map(|link| target(&page.path, link.split('#').next()?))
    });
    let needed = "LICENSE-MIT LICENSE-APACHE src/main.rs datasets/mueller2016/runs.csv";
    let needed = needed.split(' ').map(str::to_owned);
    let paths = pages.iter().map(|page| page.path.clone());
    for path in needed.chain(paths).chain(linked) {
        assert!(is_in(&path), "{path} is not in the package:\n{list}");
    }
    assert!(!is_in("docs/no_such_page.md") && !list.lines().any(|line| line.ends_with("timing.json")));
}

//! README, its neighbours and the pages of `docs/`: links lead somewhere, a number that stands twice is the same twice, the table of dependencies is whole.
#![allow(missing_docs)]

use std::fs;
use std::path::{Path, PathBuf};

use quadcal_host_tests::firmware::workspace;

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn pages() -> Vec<PathBuf> {
    let entries = fs::read_dir(workspace().join("docs")).unwrap();
    let files = entries.map(|entry| entry.unwrap().path());
    let mut pages: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|end| end == "md"))
        .collect();
    let top = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"];
    pages.extend(top.map(|name| workspace().join(name)));
    pages
}

/// Targets of Markdown links, but for those to the network.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let targets = text.split("](").skip(1);
    targets
        .filter_map(|rest| rest.split(')').next())
        .filter(|target| !target.starts_with("http"))
}

/// The anchor that a heading gets.
fn anchor(heading: &str) -> String {
    let kept = heading
        .trim_start_matches('#')
        .trim()
        .to_lowercase()
        .replace(' ', "-");
    kept.chars()
        .filter(|c| c.is_alphanumeric() || "-_".contains(*c))
        .collect()
}

#[test]
fn every_link_leads_to_a_file_and_a_heading_in_it() {
    let mut followed = 0;
    for page in pages() {
        for link in links(&read(&page)) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => page.clone(),
                file => page.parent().unwrap().join(file),
            };
            let from = page.display();
            assert!(target.exists(), "{from}: no {link}");
            if !heading.is_empty() {
                let text = read(&target);
                let found = text
                    .lines()
                    .any(|line| line.starts_with('#') && anchor(line) == heading);
                assert!(found, "{from}: no heading for {link}");
            }
            followed += 1;
        }
    }
    assert!(followed > 40, "{followed} links");
}

/// Whether a number stands in a text by itself, not as a part of a longer one.
fn holds(text: &str, number: &str) -> bool {
    let digit = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit());
    text.match_indices(number).any(|(at, _)| {
        !digit(text[..at].chars().next_back()) && !digit(text[at + number.len()..].chars().next())
    })
}

#[test]
fn the_figures_of_the_readme_are_those_of_the_pages_that_they_link_to() {
    let readme = read(&workspace().join("README.md"));
    let (_, rest) = readme.split_once("<!-- figures -->").unwrap();
    let (table, _) = rest.split_once("<!-- /figures -->").unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .filter(|line| line.starts_with("| ") && line.contains("]("))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    assert!((6..=10).contains(&rows.len()), "{} rows", rows.len());
    for row in rows {
        let page = read(&workspace().join(links(row[5]).next().unwrap()));
        for cell in &row[2..4] {
            let number = cell.split("**").nth(1).unwrap_or(cell);
            assert!(holds(&page, number), "{}: {number}", row[1]);
        }
    }
}

/// Crates and versions in the dependency sections of a manifest; crates of the workspace have none.
fn dependencies(manifest: &str) -> Vec<(String, String)> {
    let text = read(&workspace().join(manifest));
    let mut inside = false;
    let mut found = Vec::new();
    for line in text.lines() {
        if line.starts_with('[') {
            inside = ["[dependencies]", "[dev-dependencies]"].contains(&line);
        } else if let Some((name, rest)) = line.split_once(" = ").filter(|_| inside) {
            let version = match rest.split_once("version = ") {
                Some((_, version)) => version,
                None => rest,
            };
            if let Some(version) = version.strip_prefix('"') {
                let version = version.split('"').next().unwrap_or_default();
                found.push((name.to_owned(), version.to_owned()));
            }
        }
    }
    found
}

#[test]
fn the_table_of_dependencies_has_each_with_its_version_and_no_other() {
    let page = read(&workspace().join("docs/architecture.md"));
    let (_, table) = page.split_once("## Dependencies").unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| crate"))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    let manifests = [
        "Cargo.toml",
        "c/Cargo.toml",
        "host/Cargo.toml",
        "host-tests/Cargo.toml",
        "host-tests/blind/Cargo.toml",
        "examples/bare_stm32f4/Cargo.toml",
        "examples/embassy_rp2040/Cargo.toml",
        "examples/rtic_stm32g4/Cargo.toml",
    ];
    let needed: Vec<_> = manifests.into_iter().flat_map(dependencies).collect();
    for (name, version) in &needed {
        let row = rows.iter().find(|row| row[1] == name);
        let row = row.unwrap_or_else(|| panic!("no row for {name}"));
        let versions: Vec<_> = row[2].split([' ', ',']).collect();
        assert!(
            versions.contains(&version.as_str()),
            "{name} {version}: {}",
            row[2]
        );
    }
    for row in rows {
        assert!(
            needed.iter().any(|(name, _)| name == row[1]),
            "{} is not needed",
            row[1]
        );
    }
}

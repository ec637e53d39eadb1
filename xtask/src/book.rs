//! The documentation as a book: the pages of `docs/SUMMARY.md`, staged below `target/book/src` at their own paths, so
//! that links between them are the same in the book and in the repository.

use crate::tools::{CargoTool, root, run};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};

const MDBOOK: CargoTool = CargoTool {
    name: "mdbook",
    version: "0.5.4",
    options: &["--no-default-features", "--features", "search"],
};

/// Builds the book into `target/book/html`, and checks the links of its pages.
pub fn book() -> Result<(), String> {
    let mdbook = MDBOOK.program()?;
    let stage = root().join("target/book");
    let pages = pages()?;
    let broken = broken_links(&pages)?;
    if !broken.is_empty() {
        return Err(format!("broken links:\n  {}", broken.join("\n  ")));
    }
    stage_book(&stage, &pages).map_err(|cause| format!("{}: {cause}", stage.display()))?;
    let book = stage.display().to_string();
    let html = stage.join("html").display().to_string();
    run(&mdbook, &["build", &book, "--dest-dir", &html])?;
    println!("xtask book: {html}/index.html");
    Ok(())
}

/// The pages that the summary lists, relative to the workspace.
fn pages() -> Result<BTreeSet<PathBuf>, String> {
    let summary = read(Path::new("docs/SUMMARY.md"))?;
    let pages = links(&summary).map(|link| normalised(&Path::new("docs").join(link)));
    Ok(pages.collect())
}

fn stage_book(stage: &Path, pages: &BTreeSet<PathBuf>) -> std::io::Result<()> {
    let source = stage.join("src");
    if source.exists() {
        fs::remove_dir_all(&source)?;
    }
    for page in pages {
        copy(page, &source.join(page))?;
        let text = fs::read_to_string(root().join(page))?;
        let folder = page.parent().unwrap_or(Path::new(""));
        for link in links(&text) {
            let path = link.split('#').next().unwrap_or(link);
            let file = normalised(&folder.join(path));
            // Pictures, and sources that a page points to.
            if root().join(&file).is_file() && !pages.contains(&file) {
                copy(&file, &source.join(&file))?;
            }
        }
    }
    copy(Path::new("docs/book.toml"), &stage.join("book.toml"))?;
    // mdBook wants the summary at the top of the source; the paths of its links are relative to it.
    let summary = fs::read_to_string(root().join("docs/SUMMARY.md"))?;
    let summary = summary.replace("](", "](docs/").replace("](docs/../", "](");
    fs::write(source.join("SUMMARY.md"), summary)
}

fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::copy(root().join(from), to).map(|_| ())
}

/// Links of the pages to files that do not exist or headings that their file lacks.
fn broken_links(pages: &BTreeSet<PathBuf>) -> Result<Vec<String>, String> {
    let mut broken = Vec::new();
    for page in pages {
        let folder = page.parent().unwrap_or(Path::new(""));
        for link in links(&read(page)?) {
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() {
                page.clone()
            } else {
                normalised(&folder.join(path))
            };
            let exists = root().join(&target).exists();
            let has_heading = || {
                let text = read(&target).unwrap_or_default();
                text.lines().any(|line| anchor(line) == heading)
            };
            if !exists || !heading.is_empty() && !has_heading() {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    Ok(broken)
}

/// Relative targets of the links and images of a page, without those in code.
fn links(text: &str) -> impl Iterator<Item = &str> {
    let mut is_code = false;
    let prose = text.lines().filter(move |line| {
        let is_fence = line.starts_with("```");
        is_code ^= is_fence;
        !is_code && !is_fence && !line.starts_with("    ")
    });
    prose
        .flat_map(|line| line.split("](").skip(1))
        .filter_map(|rest| rest.split_once(')').map(|(link, _)| link))
        .filter(|link| !link.contains("://") && !link.contains('`'))
}

/// The anchor of a heading, as renderers of Markdown make it; empty for other lines.
fn anchor(line: &str) -> String {
    let Some(heading) = line.strip_prefix('#') else {
        return String::new();
    };
    let heading = heading.trim_start_matches('#').trim().to_lowercase();
    heading
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

fn normalised(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for component in path.components() {
        match component {
            Component::ParentDir => {
                normal.pop();
            }
            Component::CurDir => {}
            other => normal.push(other),
        }
    }
    normal
}

fn read(page: &Path) -> Result<String, String> {
    fs::read_to_string(root().join(page)).map_err(|cause| format!("{}: {cause}", page.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_of_prose_are_found_and_those_of_code_are_not() {
        let text = "see [a](b.md) and [c](../d.md#e)\n    let x = y[0](z)\n```\n[f](g.md)\n```\n[web](https://h)\n";
        assert_eq!(links(text).collect::<Vec<_>>(), ["b.md", "../d.md#e"]);
    }

    #[test]
    fn headings_have_the_usual_anchors() {
        assert_eq!(
            anchor("## How the contract changes"),
            "how-the-contract-changes"
        );
        assert_eq!(anchor("no heading"), "");
    }

    #[test]
    fn every_page_of_the_documentation_is_in_the_book() {
        let pages = pages().expect("a summary");
        let files = fs::read_dir(root().join("docs")).expect("a folder");
        for file in files.flatten() {
            let name = file.file_name().into_string().expect("a name");
            if name.ends_with(".md") && name != "SUMMARY.md" {
                assert!(pages.contains(&Path::new("docs").join(&name)), "{name}");
            }
        }
        assert_eq!(broken_links(&pages), Ok(Vec::new()));
    }
}

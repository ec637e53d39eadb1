//! Every command of `sextant` in README and guides names a subcommand and options that exist.

#![allow(clippy::expect_used, reason = "a test ends by panicking")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use system_tests::sextant;

#[test]
fn commands_in_the_documentation_exist() {
    let mut helps = Helps::default();
    let mut checked = 0;
    for page in pages() {
        let text = fs::read_to_string(&page).expect("a page");
        for line in text.lines().map(str::trim_start) {
            let Some(command) = line.strip_prefix("sextant ") else {
                continue;
            };
            if let Some(fault) = helps.fault(command) {
                panic!("{}: `sextant {command}`: {fault}", page.display());
            }
            checked += 1;
        }
    }
    assert!(checked > 60, "{checked} commands");
}

fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = fs::read_dir(root.join("docs")).expect("a folder");
    let docs = docs.flatten().map(|entry| entry.path());
    let mut pages: Vec<PathBuf> = docs
        .filter(|path| path.extension().is_some_and(|end| end == "md"))
        .collect();
    pages.extend(["README.md", "deploy/README.md"].map(|page| root.join(page)));
    pages
}

/// Help texts by subcommand, such as `calibrate lens`.
#[derive(Default)]
struct Helps(BTreeMap<String, String>);

impl Helps {
    /// What is wrong with a command line, given without the program's name.
    fn fault(&mut self, command: &str) -> Option<String> {
        let command = command.split(" #").next().expect("a first part");
        let words: Vec<&str> = command.split_whitespace().collect();
        let first = words.first()?;
        // `camera|fusion --config FILE` and `config get|set ...` stand for several commands.
        for alternative in first.split('|') {
            let mut path = alternative.to_owned();
            if alternative.starts_with('-') {
                continue;
            }
            if !self.lists("", alternative) {
                return Some(format!("no command {alternative}"));
            }
            for word in &words[1..] {
                let next = word.split('|').next().expect("a first part");
                if !self.lists(&path, next) {
                    break;
                }
                path = format!("{path} {next}");
            }
            let help = self.text(&path);
            for word in words.iter().filter(|word| word.starts_with("--")) {
                let option = word.split(['=', ']', '`', ')', ',', ':']).next()?;
                if option.len() > 2 && !help.contains(option) {
                    return Some(format!("no option {option} of `{path}`"));
                }
            }
        }
        None
    }

    /// Whether a command has this subcommand.
    fn lists(&mut self, path: &str, subcommand: &str) -> bool {
        let help = self.text(path);
        let Some((_, commands)) = help.split_once("\nCommands:\n") else {
            return false;
        };
        let own = commands.lines().take_while(|line| !line.is_empty());
        own.filter_map(|line| line.split_whitespace().next())
            .any(|name| name == subcommand)
    }

    fn text(&mut self, path: &str) -> String {
        let help = self.0.entry(path.to_owned()).or_insert_with(|| {
            let output = sextant()
                .args(path.split_whitespace())
                .arg("--help")
                .output()
                .expect("the program runs");
            String::from_utf8_lossy(&output.stdout).into_owned()
        });
        help.clone()
    }
}

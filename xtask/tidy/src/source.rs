//! The sources: which files there are, what is Rust in them, and where their comments and verbatim texts are.

use proc_macro2::{TokenStream, TokenTree};
use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;
use std::process::Command;

/// Folders and files whose contents nobody writes by hand, or that are data.
const DATA: &[&str] = &["/dist/", "fuzz/seeds/", "sextant/tests/board-on-robot/"];

/// A file with its text, and what is known of it.
pub struct Source {
    /// From the root of the workspace.
    pub path: String,
    pub text: String,
    /// `None` of files in other languages.
    pub rust: Option<Rust>,
}

/// What is known of a Rust file beside its text.
pub struct Rust {
    pub file: syn::File,
    pub comments: Vec<Comment>,
    /// Identifiers with their lines, those in macros too.
    pub identifiers: Vec<Identifier>,
    /// Lines of raw strings: their contents are verbatim.
    pub verbatim: Vec<RangeInclusive<usize>>,
    /// Whether all of the file is test code.
    pub is_test: bool,
}

/// A line of comment without its marker; block comments are not in use.
pub struct Comment {
    pub line: usize,
    pub text: String,
}

pub struct Identifier {
    pub line: usize,
    pub name: String,
}

impl Source {
    /// # Errors
    /// Where a Rust file does not parse.
    pub fn new(path: &str, text: String) -> Result<Self, String> {
        let is_rust = path.ends_with(".rs");
        let rust = is_rust.then(|| Rust::new(path, &text)).transpose();
        let rust = rust.map_err(|cause| format!("{path}: {cause}"))?;
        let path = path.to_owned();
        Ok(Self { path, text, rust })
    }
}

impl Rust {
    fn new(path: &str, text: &str) -> Result<Self, String> {
        let file = syn::parse_file(text).map_err(|cause| cause.to_string())?;
        let tokens: TokenStream = text.parse().map_err(|cause| format!("{cause}"))?;
        let mut rust = Self {
            file,
            comments: Vec::new(),
            identifiers: Vec::new(),
            verbatim: Vec::new(),
            is_test: is_test(path),
        };
        let mut strings = Vec::new();
        rust.collect(tokens, &mut strings);
        rust.comments = comments(text, &strings);
        Ok(rust)
    }

    /// Collects identifiers and the lines of literals that go over several.
    fn collect(&mut self, tokens: TokenStream, strings: &mut Vec<RangeInclusive<usize>>) {
        for token in tokens {
            match token {
                TokenTree::Group(group) => self.collect(group.stream(), strings),
                TokenTree::Ident(name) => self.identifiers.push(Identifier {
                    line: name.span().start().line,
                    name: name.to_string(),
                }),
                TokenTree::Literal(literal) => {
                    let (start, end) = (literal.span().start().line, literal.span().end().line);
                    let text = literal.to_string();
                    if ["r\"", "r#", "br"].iter().any(|raw| text.starts_with(raw)) {
                        self.verbatim.push(start..=end);
                    }
                    if end > start {
                        strings.push(start + 1..=end);
                    }
                }
                TokenTree::Punct(_) => {}
            }
        }
    }
}

/// Lines that are comments, those within strings left out. Comments behind code are not looked at: rustfmt and the
/// rule of width keep them short.
fn comments(text: &str, strings: &[RangeInclusive<usize>]) -> Vec<Comment> {
    let lines = text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim_start()));
    let comments = lines.filter(|(at, line)| {
        line.starts_with("//") && !strings.iter().any(|string| string.contains(at))
    });
    let comments = comments.map(|(line, text)| Comment {
        line,
        text: text.trim_start_matches(['/', '!']).trim().to_owned(),
    });
    comments.collect()
}

fn is_test(path: &str) -> bool {
    let folders = ["tests/", "benches/", "fuzz/"];
    let file = path.rsplit('/').next().unwrap_or(path);
    folders
        .iter()
        .any(|folder| path.starts_with(folder) || path.contains(&format!("/{folder}")))
        || file == "tests.rs"
        || file.ends_with("_tests.rs")
}

/// The files of the workspace that git knows, those with data or made by programs left out.
///
/// # Errors
/// Without git, and where a file cannot be read.
pub fn read_all(root: &Path) -> Result<Vec<Source>, String> {
    let listed = Command::new("git")
        .arg("ls-files")
        .current_dir(root)
        .output();
    let listed = listed.map_err(|cause| format!("git ls-files: {cause}"))?;
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    let own = listed
        .lines()
        .filter(|path| !DATA.iter().any(|data| path.contains(data)));
    let mut sources = Vec::new();
    for path in own {
        // Pictures and other bytes are no text; a file that is deleted and not yet committed is none at all.
        let Ok(text) = fs::read_to_string(root.join(path)) else {
            continue;
        };
        if !is_generated(&text) {
            sources.push(Source::new(path, text)?);
        }
    }
    Ok(sources)
}

fn is_generated(text: &str) -> bool {
    text.lines()
        .take(3)
        .any(|line| line.contains("do not edit"))
}

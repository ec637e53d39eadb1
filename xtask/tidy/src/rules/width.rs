//! Lines end at column 120: two of them stand beside each other on a screen.

use super::Finding;
use crate::source::Source;

const WIDTH: usize = 120;
/// Languages with a limit for every line.
const ALL_LINES: &[&str] = &[
    ".rs", ".py", ".sh", ".toml", ".yaml", ".c", ".jl", ".m", ".service", ".conf",
];
/// Languages whose code no formatter of this project wraps: their comments have the limit.
const COMMENTS: &[&str] = &[".ts", ".mjs", ".js"];

pub fn check(source: &Source) -> Vec<Finding> {
    let ends_with = |ends: &[&str]| ends.iter().any(|end| source.path.ends_with(end));
    let is_comment = |line: &str| {
        let line = line.trim_start();
        line.starts_with("//") || line.starts_with("/*") || line.starts_with("* ")
    };
    let applies = |line: &str| ends_with(ALL_LINES) || ends_with(COMMENTS) && is_comment(line);
    let is_verbatim = |at: usize| match &source.rust {
        Some(rust) => rust.verbatim.iter().any(|lines| lines.contains(&at)),
        None => false,
    };
    let lines = source
        .text
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line));
    let wide = lines
        .filter(|(at, line)| line.chars().count() > WIDTH && applies(line) && !is_verbatim(*at));
    let finding = |(at, line): (usize, &str)| {
        let remedy = format!("{} columns: wrap it at {WIDTH}", line.chars().count());
        Finding::new(&source.path, at, "width", remedy)
    };
    wide.map(finding).collect()
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(path: &str, text: String) -> Vec<String> {
        let findings = check(&Source::new(path, text).unwrap());
        findings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn columns_are_characters() {
        let line = |n: usize| format!("# {}\n", "é".repeat(n - 2));
        assert_eq!(lines("a.py", line(120)), Vec::<String>::new());
        let expected = "a.py:2: width: 121 columns: wrap it at 120";
        assert_eq!(lines("a.py", line(120) + &line(121)), [expected]);
    }

    #[test]
    fn verbatim_texts_and_code_of_the_page_may_be_wide() {
        let wide = "x".repeat(130);
        let raw = format!("const A: &str = r#\"\n{wide}\n\"#;\n");
        assert_eq!(lines("a.rs", raw), Vec::<String>::new());
        assert_eq!(lines("a.ts", wide.clone()), Vec::<String>::new());
        assert_eq!(lines("a.ts", format!("  // {wide}")).len(), 1);
    }
}

//! The table of faults and promises of BENCHMARKS.md: runs the tests of its rows in full length and writes what they
//! measure.

use crate::tools::{command, root, run};
use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

const PAGE: &str = "BENCHMARKS.md";
const BEGIN: &str = "<!-- cargo xtask faults writes from here -->\n";
const END: &str = "<!-- to here -->\n";

/// Runs every row and writes the table; a promise that is broken is an error, but its figure is written too.
pub fn faults() -> Result<(), String> {
    let programs = ["build", "--release", "--workspace", "--bin", "sextant"];
    run("cargo", &programs)?;
    let mut child = command("cargo")
        .args(["test", "--release", "--workspace", "--test", "fault_table"])
        .args(["--", "--nocapture", "--test-threads", "1"])
        .env("SEXTANT_FAULTS", "full")
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|cause| format!("cargo: {cause}"))?;
    let output = child.stdout.take().ok_or("cargo has no output")?;
    let mut figures = Vec::new();
    for line in BufReader::new(output).lines().map_while(Result::ok) {
        println!("{line}");
        // After the name of the test, which stands on the same line.
        figures.extend(
            line.split_once("FIGURE\t")
                .and_then(|(_, rest)| Figure::read(rest)),
        );
    }
    let status = child.wait().map_err(|cause| format!("cargo: {cause}"))?;
    let page = root().join(PAGE);
    let text = fs::read_to_string(&page).map_err(|cause| format!("{PAGE}: {cause}"))?;
    let text =
        with_table(&text, &table(&figures)).ok_or(format!("{PAGE}: no place for the table"))?;
    fs::write(&page, text).map_err(|cause| format!("{PAGE}: {cause}"))?;
    match status.success() {
        true => Ok(()),
        false => Err("a promise is broken: see the output above".to_owned()),
    }
}

/// As a test prints it: row, figure and promise.
#[derive(Debug, PartialEq, Eq)]
struct Figure {
    row: String,
    measured: String,
    promise: String,
}

impl Figure {
    fn read(line: &str) -> Option<Self> {
        let mut fields = line.split('\t').map(str::to_owned);
        Some(Self {
            row: fields.next()?,
            measured: fields.next()?,
            promise: fields.next()?,
        })
    }
}

fn table(figures: &[Figure]) -> String {
    let mut text = "| fault | measured | promise |\n|---|---|---|\n".to_owned();
    let mut figures: Vec<&Figure> = figures.iter().collect();
    figures.sort_by_key(|figure| &figure.row);
    for Figure {
        row,
        measured,
        promise,
    } in figures
    {
        text.push_str(&format!("| {row} | {measured} | {promise} |\n"));
    }
    text
}

/// The page with the table between its two marks.
fn with_table(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{table}\n{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_become_rows_between_the_marks() {
        let line = "test a ... FIGURE\tkill -9\tgap: 80 ms\tat most 300 ms";
        let figure = line
            .split_once("FIGURE\t")
            .and_then(|(_, rest)| Figure::read(rest));
        let page = format!("# Faults\n{BEGIN}old\n{END}end\n");
        let written = with_table(&page, &table(&[figure.unwrap()])).unwrap();
        assert!(written.contains("| kill -9 | gap: 80 ms | at most 300 ms |\n"));
        assert!(!written.contains("old") && written.ends_with("end\n"));
        assert_eq!(with_table("no marks", ""), None);
    }
}

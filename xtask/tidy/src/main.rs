//! Checks of the sources that a reader would otherwise make: `cargo xtask tidy`.
//!
//! Each finding is a line `file:line: rule: remedy`; the exit code is 1 if there is any. Generated files, committed
//! bundles, lock files and tables of data are not looked at. There are no exceptions: what a rule finds is mended.

mod rules;
mod source;

use rules::{Finding, syntax, width, words};
use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    match check(&root) {
        Ok(findings) if findings.is_empty() => ExitCode::SUCCESS,
        Ok(findings) => {
            for finding in &findings {
                eprintln!("{finding}");
            }
            eprintln!("tidy: {} findings", findings.len());
            ExitCode::FAILURE
        }
        Err(cause) => {
            eprintln!("tidy: {cause}");
            ExitCode::FAILURE
        }
    }
}

/// Findings of all sources below a folder, in the order of their files and lines.
fn check(root: &Path) -> Result<Vec<Finding>, String> {
    let mut findings = Vec::new();
    let mut generic_types = Vec::new();
    let sources = source::read_all(root)?;
    for source in &sources {
        findings.extend(width::check(source));
        if let Some(rust) = &source.rust {
            findings.extend(words::check(source, rust));
            let (by_syntax, types) = syntax::check(source, rust);
            findings.extend(by_syntax);
            generic_types.extend(types);
        }
    }
    findings.extend(syntax::check_generic_types(generic_types));
    findings.sort();
    Ok(findings)
}

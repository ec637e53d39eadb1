//! `sextant check`: are these files right, before anything runs with them.

mod cross_checks;
mod dataset;
mod file;

use crate::config::ConfigKind;
use crate::output::{Format, print_line};
use anyhow::bail;
use clap::Args;
pub use cross_checks::CrossChecks;
use serde_json::json;
use sextant_process::{Exit, Failure};
use std::path::{Path, PathBuf};

/// Arguments of `sextant check`.
#[derive(Args, Debug)]
#[command(
    after_help = "The kind of a file is recognised by its contents; --kind sets it for all files. Rigs, objects and
recordings are also checked against each other: tags in two objects, cameras missing from the rig, images of another
size. With --json, one line per file: {\"file\",\"kind\",\"ok\",\"summary\"} or {\"file\",\"ok\",\"error\"}. The exit
code is 3 if anything is wrong."
)]
pub struct CheckArguments {
    /// Rigs, objects, calibrations and boards of other tools, configurations of nodes, and recordings.
    #[arg(value_name = "FILE|DIR", required = true)]
    files: Vec<PathBuf>,
    /// What the files are.
    #[arg(long)]
    kind: Option<ConfigKind>,
}

/// Runs `sextant check`.
///
/// # Errors
/// [`Exit::Input`] when anything is wrong.
pub fn run(arguments: &CheckArguments, format: Format) -> anyhow::Result<()> {
    let mut together = CrossChecks::default();
    let mut wrong = 0_usize;
    for path in &arguments.files {
        let found = check_path(path, arguments.kind, &mut together);
        wrong += usize::from(found.is_err());
        let name = path.display().to_string();
        match (found, format) {
            (Ok((kind, summary)), Format::Text) => {
                print_line(&format!("{name}: {kind}, {summary}: right"))?;
            }
            (Ok((kind, summary)), Format::Json) => {
                print_line(
                    &json!({"file": name, "kind": kind, "ok": true, "summary": summary})
                        .to_string(),
                )?;
            }
            (Err(error), Format::Text) => eprintln!("error: {error:#}"),
            (Err(error), Format::Json) => {
                print_line(
                    &json!({"file": name, "ok": false, "error": format!("{error:#}")}).to_string(),
                )?;
            }
        }
    }
    for complaint in together.complaints() {
        wrong += 1;
        match format {
            Format::Text => eprintln!("error: {complaint}"),
            Format::Json => print_line(&json!({"ok": false, "error": complaint}).to_string())?,
        }
    }
    if wrong > 0 {
        let things = if wrong == 1 { "thing is" } else { "things are" };
        bail!(Failure::new(
            Exit::Input,
            anyhow::anyhow!("{wrong} {things} wrong")
        ));
    }
    Ok(())
}

/// Checks a file or a recording, and adds its contents to those that are checked together.
///
/// # Errors
/// What is wrong with it.
pub fn check_path(path: &Path, stated: Option<ConfigKind>, together: &mut CrossChecks) -> Found {
    if path.is_dir() {
        dataset::check(path, together)
    } else {
        file::check(path, stated, together)
    }
}

/// What a file is and a word on what it holds.
pub type Found = anyhow::Result<(&'static str, String)>;

//! A run of chores: its plan, said before anything happens; the chores one after the other; and what became of each.

use crate::install::{Missing, lacks, missing_targets};
use crate::report::{ChoreOutcome, Report, Row};
use sextant_test_needs::{GUARDED, Need, SKIPS, is_ci};
use std::fs;
use std::time::{Duration, Instant};

/// One chore: its word on the command line, and what it takes.
pub struct Chore {
    pub word: &'static str,
    pub what: &'static str,
    pub run: fn() -> Result<(), String>,
    /// What the machine must have beside Rust and a C compiler.
    pub needs: &'static [&'static Need],
    /// Rust's targets beside this machine's own.
    pub targets: &'static [&'static str],
    /// What it downloads, and where that goes.
    pub fetches: &'static [&'static str],
    /// A chore without which this one is skipped where both are run.
    pub after: Option<&'static str>,
    /// How long it takes on two processors with everything to compile.
    pub minutes: u32,
}

impl Chore {
    pub const fn new(
        word: &'static str,
        what: &'static str,
        run: fn() -> Result<(), String>,
    ) -> Self {
        Self {
            word,
            what,
            run,
            needs: &[],
            targets: &[],
            fetches: &[],
            after: None,
            minutes: 0,
        }
    }

    /// Why it cannot run on this machine.
    fn lack(&self) -> Option<String> {
        let lack = lacks(self.needs).into_iter().next();
        let target = || missing_targets(self.targets).into_iter().next();
        lack.or_else(|| {
            target()
                .map(|target| format!("needs Rust's target {target}: rustup target add {target}"))
        })
    }
}

/// What is run, and what is allowed meanwhile.
#[derive(Default)]
pub struct Options {
    /// Ends after the plan.
    pub only_plan: bool,
    /// Ends when everything is installed.
    pub only_install: bool,
    /// Skips what needs Debian's packages that are missing and may not be installed.
    pub may_skip: bool,
}

/// Runs chores, each also when one before it has failed.
///
/// # Errors
/// What failed; in continuous integration also what cannot run, before anything does.
pub fn run_in_order(chores: &[&Chore], options: &Options) -> Result<(), String> {
    let guarded: Vec<_> = GUARDED
        .iter()
        .filter(|_| runs_guarded_tests(chores))
        .collect();
    let needs = chores.iter().flat_map(|chore| chore.needs);
    let needs = needs.chain(guarded.iter().flat_map(|test| test.needs));
    let targets: Vec<&str> = chores
        .iter()
        .flat_map(|chore| chore.targets)
        .copied()
        .collect();
    let missing = Missing::new(&needs.copied().collect::<Vec<_>>(), &targets);
    let blocked = || {
        let blocked = chores
            .iter()
            .filter_map(|chore| Some(format!("{} {}", chore.word, chore.lack()?)));
        let tests = guarded
            .iter()
            .filter_map(|test| Some(format!("{} {}", test.test, test.lack()?)));
        blocked.chain(tests).collect::<Vec<String>>()
    };
    if chores.len() > 1 || options.only_plan {
        print!("{}", plan(chores));
    }
    print_list("Installed first:", &missing.lines());
    if options.only_plan {
        print_list("Missing now:", &blocked());
        return Ok(());
    }
    missing.install(options.may_skip)?;
    let blocked = blocked();
    if is_ci() && !blocked.is_empty() {
        return Err(format!(
            "cannot run everything here:\n  {}",
            blocked.join("\n  ")
        ));
    }
    print_list("Skipped on this machine:", &blocked);
    if options.only_install {
        return Ok(());
    }
    run_all(chores)
}

fn run_all(chores: &[&Chore]) -> Result<(), String> {
    let mut report = Report::default();
    for chore in chores {
        let row = run(chore, &report);
        report.0.push(row);
    }
    if !report.is_trivial() {
        println!("\n{report}");
    }
    match report.failed().as_slice() {
        [] => Ok(()),
        failed => Err(format!("failed: {}", failed.join(", "))),
    }
}

fn runs_guarded_tests(chores: &[&Chore]) -> bool {
    chores
        .iter()
        .any(|chore| ["nodes", "system"].contains(&chore.word))
}

fn plan(chores: &[&Chore]) -> String {
    let total: u32 = chores.iter().map(|chore| chore.minutes).sum();
    let mut text = format!(
        "{} chores, about {total} minutes on two processors with everything to compile:\n",
        chores.len()
    );
    for chore in chores {
        let minutes = match chore.minutes {
            0 => "      ".to_owned(),
            minutes => format!("{minutes:>2} min"),
        };
        text += &format!("  {:<12} {minutes}  {}\n", chore.word, chore.what);
    }
    let fetches: Vec<_> = chores
        .iter()
        .flat_map(|chore| chore.fetches.iter().map(|what| (chore.word, what)))
        .collect();
    if !fetches.is_empty() {
        text += "Downloaded where missing:\n";
    }
    for (word, what) in fetches {
        text += &format!("  {word:<12} {what}\n");
    }
    text
}

fn print_list(head: &str, lines: &[String]) {
    if !lines.is_empty() {
        println!("{head}\n  {}", lines.join("\n  "));
    }
}

fn run(chore: &Chore, report: &Report) -> Row {
    let word = chore.word;
    let skipped = |why| Row {
        word,
        outcome: ChoreOutcome::Skipped(why),
        took: Duration::ZERO,
        skips: Vec::new(),
    };
    if let Some(before) = chore.after.filter(|before| report.has_failed(before)) {
        return skipped(format!("{before} failed"));
    }
    if let Some(lack) = chore.lack() {
        return skipped(lack);
    }
    println!("\nxtask {word}: {}", chore.what);
    let started = Instant::now();
    let outcome = match (chore.run)() {
        Ok(()) => ChoreOutcome::Passed,
        Err(cause) => {
            eprintln!("xtask {word}: {cause}");
            ChoreOutcome::Failed(cause)
        }
    };
    let took = started.elapsed();
    println!("xtask {word}: {} s", took.as_secs());
    Row {
        word,
        outcome,
        took,
        skips: take_skips(),
    }
}

/// What was noted since this was last asked.
fn take_skips() -> Vec<String> {
    let Some(file) = std::env::var_os(SKIPS) else {
        return Vec::new();
    };
    let noted = fs::read_to_string(&file).unwrap_or_default();
    // There is none where nothing was noted.
    let _ = fs::remove_file(&file);
    noted.lines().map(str::to_owned).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chore(run: fn() -> Result<(), String>) -> Chore {
        Chore::new("one", "does something", run)
    }

    #[test]
    fn the_plan_names_each_chore_with_its_time_and_downloads() {
        let slow = Chore {
            minutes: 5,
            fetches: &["packages, in a folder"],
            ..chore(|| Ok(()))
        };
        let text = plan(&[&slow, &slow]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("2 chores, about 10 minutes"), "{text}");
        assert_eq!(lines[1], "  one           5 min  does something");
        assert_eq!(lines[4], "  one          packages, in a folder");
    }

    #[test]
    fn a_failure_hides_no_other_chore_but_those_that_build_on_it() {
        let failing = chore(|| Err("no".to_owned()));
        let passing = Chore {
            word: "two",
            ..chore(|| Ok(()))
        };
        let dependent = Chore {
            word: "three",
            after: Some("one"),
            ..chore(|| Ok(()))
        };
        let mut report = Report::default();
        for chore in [&failing, &passing, &dependent] {
            let row = run(chore, &report);
            report.0.push(row);
        }
        let outcomes = report.0.iter().map(|row| match &row.outcome {
            ChoreOutcome::Passed => "passed",
            ChoreOutcome::Skipped(_) => "skipped",
            ChoreOutcome::Failed(_) => "failed",
        });
        assert_eq!(
            outcomes.collect::<Vec<_>>(),
            ["failed", "passed", "skipped"]
        );
    }
}

//! The project's chores, each a word: what continuous integration runs is what a person runs.
//!
//! No dependency but the standard library, so that the first chore on a fresh machine starts in seconds.

mod board;
mod book;
mod chores;
mod dependencies;
mod faults;
mod fuzz;
mod package;
mod python;
mod ros2;
mod tools;

use std::process::ExitCode;
use std::time::Instant;

type Chore = fn() -> Result<(), String>;

/// Every chore: its word, what it does, and the function.
const CHORES: &[(&str, &str, Chore)] = &[
    (
        "test",
        "everything that can fail: page, workspace, whole system in a browser, boards' processor",
        test,
    ),
    (
        "check",
        "everything beside tests: format, lint, documentation, dependencies, cross builds",
        check,
    ),
    ("ci", "test, then check", ci),
    ("fmt", "formatting is rustfmt's", chores::fmt),
    ("lint", "clippy, warnings are errors", chores::lint),
    (
        "docs",
        "documentation builds without a warning",
        chores::docs,
    ),
    (
        "book",
        "the documentation as a book, its links checked: target/book/html",
        book::book,
    ),
    (
        "deny",
        "licences, bans and sources of every dependency",
        dependencies::deny,
    ),
    (
        "advisories",
        "no dependency has a known fault; passed over, with a word, where the database is out of reach",
        dependencies::advisories,
    ),
    (
        "sbom",
        "what the program is made of, as CycloneDX: target/sbom/sextant.cdx.json",
        dependencies::sbom,
    ),
    (
        "page",
        "the web page: types, unit tests, and the committed bundle equals a fresh build",
        chores::page,
    ),
    (
        "workspace",
        "tests of every crate and of the whole system on this machine",
        chores::workspace,
    ),
    (
        "ros2",
        "what `sextant ros2` publishes, read by other people's code: rosbags, zenoh's Python binding, ROS 2's own packages",
        ros2::ros2,
    ),
    (
        "arm",
        "tests of the pure crates for armv7 and of the detector's kernels for aarch64, under qemu",
        chores::arm,
    ),
    (
        "cross",
        "the camera node compiles for the boards' processors",
        chores::cross,
    ),
    (
        "fuzz",
        "every decoder of foreign bytes, the detector and the estimator under libFuzzer, 10 s each: SEXTANT_FUZZ_SECONDS for more",
        fuzz::fuzz,
    ),
    (
        "board",
        "the camera node's package for armv7, its units and a real camera driver on an emulated Cortex-A9; at most 25 minutes",
        board::board,
    ),
    (
        "python-test",
        "the Python client: messages as the contract has them, types, tests, guide and notebook against a demo",
        python::test,
    ),
    (
        "python",
        "writes the Python client's messages from proto/CONTRACT.md",
        python::generate,
    ),
    (
        "package",
        "packages and tarballs for boards and PCs: target/package/",
        package::all,
    ),
    (
        "faults",
        "breaks a site in every way that a promise is made for, and writes the figures into BENCHMARKS.md; 45 minutes, on an idle machine",
        faults::faults,
    ),
    (
        "bench",
        "what detection costs on this machine, beside AprilTag's own detector in C",
        chores::bench,
    ),
];

const TEST: &[&str] = &["page", "workspace", "python-test", "ros2", "arm", "fuzz"];
const CHECK: &[&str] = &[
    "fmt",
    "lint",
    "docs",
    "book",
    "deny",
    "advisories",
    "sbom",
    "cross",
];

fn test() -> Result<(), String> {
    run_in_order(TEST)
}

fn check() -> Result<(), String> {
    run_in_order(CHECK)
}

fn ci() -> Result<(), String> {
    test().and_then(|()| check())
}

fn run_in_order(words: &[&str]) -> Result<(), String> {
    let chores = words
        .iter()
        .map(|word| find(word).ok_or_else(|| usage(word)));
    let chores: Vec<_> = chores.collect::<Result<_, _>>()?;
    tools::require_all(words)?;
    for (word, what, run) in chores {
        let started = Instant::now();
        println!("xtask {word}: {what}");
        run().map_err(|cause| format!("{word}: {cause}"))?;
        println!("xtask {word}: done in {} s", started.elapsed().as_secs());
    }
    Ok(())
}

fn find(word: &str) -> Option<&'static (&'static str, &'static str, Chore)> {
    CHORES.iter().find(|chore| chore.0 == word)
}

fn usage(word: &str) -> String {
    let list: Vec<String> = CHORES
        .iter()
        .map(|(word, what, _)| format!("  {word:<12} {what}"))
        .collect();
    format!(
        "no chore named '{word}'. cargo xtask CHORE...\n{}",
        list.join("\n")
    )
}

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let outcome = match words.as_slice() {
        [] => Err(usage("")),
        ["test"] => test(),
        ["check"] => check(),
        ["ci"] => ci(),
        chosen => run_in_order(chosen),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(cause) => {
            eprintln!("xtask: {cause}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `.ci/run` is `test`, `check` and `board`; what is in none of them is measured or made.
    #[test]
    fn continuous_integration_runs_each_chore_once() {
        let chores = CHORES.iter().map(|chore| chore.0);
        let mut once: Vec<_> = chores
            .filter(|word| {
                ![
                    "test", "check", "ci", "bench", "board", "faults", "package", "python",
                ]
                .contains(word)
            })
            .collect();
        let mut run = [TEST, CHECK].concat();
        once.sort_unstable();
        run.sort_unstable();
        assert_eq!(run, once);
        let script = include_str!("../../.ci/run");
        let steps = script
            .lines()
            .filter_map(|line| line.strip_prefix("cargo xtask ")?.split(' ').next());
        assert_eq!(steps.collect::<Vec<_>>(), ["test", "board", "check"]);
    }
}

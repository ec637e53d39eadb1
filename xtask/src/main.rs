//! The project's chores, each a word: what continuous integration runs is what a person runs.
//!
//! No dependency but the standard library, so that the first chore on a fresh machine starts in seconds.

mod board;
mod book;
mod chores;
mod dependencies;
mod faults;
mod fuzz;
mod generated;
mod install;
mod package;
mod page_types;
mod plan;
mod python;
mod release;
mod report;
mod ros2;
mod suites;
mod tools;
mod wasm;

use plan::{Chore, Options, run_in_order};
use sextant_test_needs::{
    CXX, DISK, DPKG_DEB, GCC_AARCH64, GCC_ARM, LINTIAN, MMDEBSTRAP, MOSQUITTO, NAME_SPACES, NODE,
    OCTAVE, PIP, PYTHON, QEMU_AARCH64, QEMU_ARM, QEMU_BINFMT, SHARED_MEMORY, SKIPS, SYSUSERS,
};
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitCode};

const AARCH64: &str = "aarch64-unknown-linux-gnu";
const ARMV7: &str = "armv7-unknown-linux-gnueabihf";
const WINDOWS: &str = "x86_64-pc-windows-gnu";
const MACOS: &str = "aarch64-apple-darwin";
const NEON: &str = "thumbv7neon-unknown-linux-gnueabihf";

/// Every chore. Those of a list run in the order of the list.
const CHORES: &[Chore] = &[
    Chore {
        needs: &[&NODE],
        fetches: &["npm packages, in node-viewer-bridge/page/node_modules"],
        minutes: 1,
        ..Chore::new(
            "page",
            "the web page: types, unit tests, and the committed bundle equals a fresh build",
            chores::page,
        )
    },
    Chore {
        needs: &[&NODE],
        targets: &[wasm::TARGET],
        fetches: &["npm packages, in node-viewer-bridge/page/node_modules"],
        minutes: 2,
        ..Chore::new(
            "web",
            "the detector for browsers: the committed package equals a fresh build",
            wasm::web,
        )
    },
    Chore {
        needs: &[&DISK],
        minutes: 12,
        ..Chore::new("build", "compiles every program and test", suites::build)
    },
    Chore {
        needs: &[&DISK, &SHARED_MEMORY],
        after: Some("build"),
        minutes: 5,
        ..Chore::new(
            "crates",
            "tests of all crates, of the nodes and of the command line",
            suites::crates,
        )
    },
    Chore {
        needs: &[&DISK, &SHARED_MEMORY],
        after: Some("build"),
        minutes: 10,
        ..Chore::new(
            "system",
            "tests of whole systems on this machine, and of the page in a browser",
            suites::system,
        )
    },
    Chore {
        needs: &[&PYTHON, &MOSQUITTO, &OCTAVE],
        after: Some("build"),
        fetches: &["Python packages, in target/python"],
        minutes: 3,
        ..Chore::new(
            "python-test",
            "the Python client: messages as the contract has them, types, tests, guide and notebook against a demo",
            python::test,
        )
    },
    Chore {
        needs: &[&PYTHON],
        after: Some("build"),
        fetches: &["Python packages, in target/tools"],
        minutes: 2,
        ..Chore::new(
            "ros2",
            "what `sextant ros2` and `convert --ros2` write, read by other people's code: \
             rosbags, zenoh's Python binding, ROS 2's own packages, Rerun",
            ros2::ros2,
        )
    },
    Chore {
        needs: &[&DISK, &QEMU_ARM, &QEMU_AARCH64, &GCC_ARM, &GCC_AARCH64],
        targets: &[AARCH64, ARMV7, NEON],
        minutes: 7,
        ..Chore::new(
            "arm",
            "tests of the pure crates for armv7 and of the detector's kernels for aarch64, under qemu",
            chores::arm,
        )
    },
    Chore {
        needs: &[&DISK, &CXX],
        minutes: 6,
        ..Chore::new(
            "fuzz",
            "every decoder of foreign bytes, the detector and the estimator under libFuzzer, 5 s \
             each: SEXTANT_FUZZ_SECONDS for more",
            fuzz::fuzz,
        )
    },
    Chore::new("fmt", "formatting is rustfmt's", chores::fmt),
    Chore::new(
        "tidy",
        "lengths, widths, words and names of the sources (xtask/tidy)",
        chores::tidy,
    ),
    Chore {
        minutes: 4,
        ..Chore::new(
            "lint",
            "clippy, warnings are errors; planted faults fit the code",
            || suites::patches_apply().and_then(|()| chores::lint()),
        )
    },
    Chore {
        minutes: 3,
        ..Chore::new(
            "docs",
            "documentation builds without a warning",
            chores::docs,
        )
    },
    Chore {
        fetches: &["mdbook, in $XDG_CACHE_HOME/sextant or ~/.cache/sextant"],
        minutes: 2,
        ..Chore::new(
            "book",
            "the documentation as a book, its links checked: target/book/html",
            book::book,
        )
    },
    Chore {
        fetches: &["cargo-deny, in $XDG_CACHE_HOME/sextant or ~/.cache/sextant"],
        minutes: 4,
        ..Chore::new(
            "deny",
            "licences, bans and sources of every dependency",
            dependencies::deny,
        )
    },
    Chore {
        minutes: 1,
        ..Chore::new(
            "advisories",
            "no dependency has a known fault; skipped where the database is out of reach",
            dependencies::advisories,
        )
    },
    Chore {
        fetches: &["cargo-cyclonedx, in $XDG_CACHE_HOME/sextant or ~/.cache/sextant"],
        minutes: 2,
        ..Chore::new(
            "sbom",
            "what the program is made of, as CycloneDX: target/sbom/sextant.cdx.json",
            dependencies::sbom,
        )
    },
    Chore {
        needs: &[&GCC_AARCH64],
        targets: &[AARCH64],
        minutes: 2,
        ..Chore::new(
            "cross",
            "the camera node compiles for 64-bit boards",
            chores::cross,
        )
    },
    Chore {
        needs: &[&PIP],
        targets: &[WINDOWS, MACOS],
        fetches: &["cargo-zigbuild and zig, in target/tools"],
        minutes: 5,
        ..Chore::new(
            "elsewhere",
            "the Rust client compiles for Windows and macOS",
            || chores::elsewhere(&[WINDOWS, MACOS]),
        )
    },
    Chore {
        needs: &[&PIP, &DPKG_DEB, &SYSUSERS, &LINTIAN],
        targets: &[ARMV7],
        fetches: &[
            "cargo-zigbuild and zig, in target/tools",
            "the board's image, in $XDG_CACHE_HOME/sextant or ~/.cache/sextant",
        ],
        minutes: 25,
        ..Chore::new(
            "board",
            "the camera node's package for armv7, its units and a real camera driver on an \
             emulated Cortex-A9; at most 25 minutes",
            board::board,
        )
    },
    Chore::new(
        "page-types",
        "writes the page's messages from proto/CONTRACT.md and the bridge's PROTOCOL.md",
        page_types::page_types,
    ),
    Chore {
        needs: &[&NODE],
        targets: &[wasm::TARGET],
        fetches: &["npm packages, in node-viewer-bridge/page/node_modules"],
        minutes: 2,
        ..Chore::new(
            "wasm",
            "writes the detector for browsers: clients/web/dist",
            wasm::wasm,
        )
    },
    Chore::new(
        "python",
        "writes the Python client's messages from proto/CONTRACT.md",
        python::generate,
    ),
    Chore {
        needs: &[
            &PIP,
            &DPKG_DEB,
            &SYSUSERS,
            &LINTIAN,
            &MMDEBSTRAP,
            &NAME_SPACES,
            &QEMU_BINFMT,
        ],
        targets: &[AARCH64, ARMV7, NEON],
        fetches: &[
            "cargo-zigbuild and zig, in target/tools",
            "Debian's essential packages, in target/package/systems",
        ],
        minutes: 30,
        ..Chore::new(
            "package",
            "packages and tarballs for boards and PCs: target/package/",
            package::all,
        )
    },
    Chore {
        needs: &[&PYTHON, &PIP, &MMDEBSTRAP, &NAME_SPACES, &QEMU_BINFMT],
        targets: &[AARCH64],
        fetches: &[
            "cargo-zigbuild and zig, in target/tools",
            "Debian's essential packages, in target/package/systems",
        ],
        minutes: 30,
        ..Chore::new(
            "wheel",
            "Python wheels with the command line in them, tried in a clean system: target/package/wheels/",
            package::wheels,
        )
    },
    Chore {
        needs: &[&NODE],
        minutes: 1,
        ..Chore::new(
            "npm",
            "the detector for browsers as npm gets it, tried in an empty folder: target/package/npm/",
            release::npm,
        )
    },
    Chore {
        minutes: 25,
        ..Chore::new(
            "crates-io",
            "every crate as crates.io would get it compiles from its package",
            release::crates_io,
        )
    },
    Chore {
        needs: &[&PYTHON],
        minutes: 1,
        ..Chore::new(
            "assemble",
            "what these have made, with notes and checksums: target/releases/",
            release::assemble,
        )
    },
    Chore {
        minutes: 45,
        ..Chore::new(
            "faults",
            "breaks a site in every way that a promise is made for, and writes the figures into \
             BENCHMARKS.md; on an idle machine",
            faults::faults,
        )
    },
    Chore {
        minutes: 60,
        ..Chore::new(
            "simulate",
            "whole sites in simulated time from many seeds; what follows is for it: --seeds N, --hours H, --trace SEED",
            || suites::simulate(&[]),
        )
    },
    Chore {
        minutes: 40,
        ..Chore::new(
            "planted",
            "plants faults one at a time and has the simulation find each",
            suites::planted,
        )
    },
    Chore {
        minutes: 10,
        ..Chore::new(
            "bench",
            "what detection costs on this machine, beside AprilTag's own detector in C",
            chores::bench,
        )
    },
];

/// Words that stand for several chores. Quick ones come first, so that a failure shows within minutes.
const LISTS: &[(&str, &str, &[&str])] = &[
    (
        "test",
        "everything that can fail",
        &[
            "web",
            "page",
            "build",
            "crates",
            "system",
            "python-test",
            "ros2",
            "arm",
            "fuzz",
        ],
    ),
    (
        "workspace",
        "tests of every crate and of the whole system on this machine",
        &["build", "crates", "system"],
    ),
    (
        "check",
        "everything beside tests: format, names and sizes, lint, documentation, dependencies, cross builds",
        &[
            "fmt",
            "tidy",
            "lint",
            "docs",
            "deny",
            "advisories",
            "cross",
            "elsewhere",
        ],
    ),
    ("ci", "test, then check", &["test", "check"]),
    (
        "release",
        "makes and checks all that a release consists of; uploads nothing",
        &[
            "npm",
            "book",
            "sbom",
            "package",
            "wheel",
            "crates-io",
            "assemble",
        ],
    ),
];

/// The chores that a word stands for.
fn chores_of(word: &str) -> Result<Vec<&'static Chore>, String> {
    if let Some((_, _, words)) = LISTS.iter().find(|list| list.0 == word) {
        let chores: Result<Vec<_>, _> = words.iter().map(|word| chores_of(word)).collect();
        return chores.map(|chores| chores.concat());
    }
    let chore = CHORES.iter().find(|chore| chore.word == word);
    chore.map(|chore| vec![chore]).ok_or_else(|| usage(word))
}

fn usage(word: &str) -> String {
    let lists = LISTS.iter().map(|(word, what, _)| (word, what));
    let chores = CHORES.iter().map(|chore| (&chore.word, &chore.what));
    let lines: Vec<String> = lists
        .chain(chores)
        .map(|(word, what)| format!("  {word:<12} {what}"))
        .collect();
    format!(
        "no chore named '{word}'. cargo xtask [--plan] [--install] [--ci] [--skip-missing] CHORE...
  --plan          says what would be done, installed and skipped
  --install       installs what is missing, and does nothing else
  --ci            a skip is a failure, as where the environment variable CI is set
  --skip-missing  skips what needs Debian's packages that are missing
{}",
        lines.join("\n")
    )
}

fn run(words: &[String]) -> Result<(), String> {
    if let Some((word, arguments)) = words.split_first()
        && word == "simulate"
    {
        return suites::simulate(arguments);
    }
    let mut options = Options::default();
    let mut chores = Vec::new();
    for word in words {
        match word.as_str() {
            "--plan" => options.only_plan = true,
            "--install" => options.only_install = true,
            "--skip-missing" => options.may_skip = true,
            // Said to everything that runs, by its environment.
            "--ci" => {}
            word => chores.extend(chores_of(word)?),
        }
    }
    if chores.is_empty() {
        return Err(usage(""));
    }
    run_in_order(&chores, &options)
}

/// Becomes this program again, with the environment that all chores and what they run share.
fn enter_environment() -> std::io::Error {
    let program = std::env::current_exe().unwrap_or_default();
    let mut again = Command::new(program);
    again.args(std::env::args_os().skip(1));
    let path = std::env::var_os("PATH").unwrap_or_default();
    let own = tools::root().join("target/tools/bin");
    let path = std::iter::once(own).chain(std::env::split_paths(&path));
    again.envs(std::env::join_paths(path).map(|path| ("PATH", path)));
    let skips = format!("target/skips-{}", std::process::id());
    again.env(SKIPS, tools::root().join(skips));
    // npm waits forever for a cache that it cannot write.
    let home = std::env::var_os("HOME").map(|home| Path::new(&home).join(".npm"));
    if home.is_none_or(|cache| fs::create_dir_all(cache).is_err()) {
        again.env("npm_config_cache", tools::root().join("target/npm"));
    }
    if std::env::args().any(|argument| argument == "--ci") {
        again.env("CI", "true");
    }
    // What `cargo run` tells a program of its own package. ring's build script watches such variables, and all that
    // needs TLS would be compiled anew whenever a chore follows a plain `cargo build`.
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        if name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") {
            again.env_remove(name.as_ref());
        }
    }
    again.exec()
}

fn main() -> ExitCode {
    if std::env::var_os(SKIPS).is_none() {
        eprintln!("xtask: {}", enter_environment());
        return ExitCode::FAILURE;
    }
    let words: Vec<String> = std::env::args().skip(1).collect();
    match run(&words) {
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
    use sextant_test_needs::PACKAGED;
    use std::collections::BTreeSet;

    /// `.ci/run` is `test`, `check` and `board`, some beside others; what is in none of them is measured or made.
    #[test]
    fn continuous_integration_runs_each_chore_once() {
        let chores = CHORES.iter().map(|chore| chore.word);
        let mut once: Vec<_> = chores
            .filter(|word| {
                ![
                    "assemble",
                    "bench",
                    "board",
                    "book",
                    "crates-io",
                    "faults",
                    "npm",
                    "package",
                    "page-types",
                    "planted",
                    "python",
                    "sbom",
                    "simulate",
                    "wasm",
                    "wheel",
                ]
                .contains(word)
            })
            .collect();
        let mut run: Vec<_> = chores_of("ci")
            .unwrap()
            .iter()
            .map(|chore| chore.word)
            .collect();
        once.sort_unstable();
        run.sort_unstable();
        assert_eq!(run, once);
        let script = include_str!("../../.ci/run");
        let mut steps: Vec<_> = script
            .lines()
            .filter_map(|line| line.trim().strip_prefix("cargo xtask "))
            .filter(|words| !words.starts_with("--install"))
            .flat_map(|words| {
                words
                    .split(' ')
                    .take_while(|word| ![">", "||"].contains(word))
            })
            .flat_map(|word| chores_of(word).unwrap())
            .map(|chore| chore.word)
            .collect();
        steps.sort_unstable();
        once.push("board");
        once.sort_unstable();
        assert_eq!(steps, once);
    }

    #[test]
    fn the_container_has_the_packages_that_chores_install() {
        let file = fs::read_to_string(tools::root().join("Containerfile")).unwrap();
        let (_, rest) = file.split_once("apt-get install --yes").unwrap();
        let words = rest.split("&&").next().unwrap().split_whitespace();
        let listed: BTreeSet<_> = words
            .filter(|word| *word != "\\" && !word.starts_with("--"))
            .collect();
        let installed: BTreeSet<_> = PACKAGED.iter().filter_map(|need| need.package).collect();
        assert_eq!(listed, installed);
        // Every need of a chore that has a package is among them.
        let needed = CHORES
            .iter()
            .flat_map(|chore| chore.needs)
            .chain(board::NEEDS);
        for package in needed.filter_map(|need| need.package) {
            assert!(installed.contains(package), "{package}");
        }
    }

    #[test]
    fn the_container_has_the_toolchain_of_the_workspace() {
        let read = |name| fs::read_to_string(tools::root().join(name)).unwrap();
        let toolchain = read("rust-toolchain.toml");
        let channel = toolchain
            .lines()
            .find_map(|line| line.strip_prefix("channel = "))
            .unwrap();
        let image = format!("FROM rust:{}-", channel.trim_matches('"'));
        assert!(
            read("Containerfile")
                .lines()
                .any(|line| line.starts_with(&image)),
            "{image}"
        );
    }
}

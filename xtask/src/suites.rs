//! The tests of Rust code, quick ones first: crates and nodes, then the whole system. The programs that cargo builds
//! for all of the workspace are run one by one, so that each package is tested once, with the features that all others
//! are built with, and one failure does not hide the next.

use crate::chores::{PAGE, page_packages};
use crate::tools::{command, root, run};
use sextant_test_needs::NODE;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Packages that test or measure all others.
const SYSTEM: &[&str] = &["tests", "tests/simulation", "benches", "benches/examine"];

/// The test program whose modules are run one after the other, each as a program of its own: many of them measure
/// latencies.
const BY_MODULE: &str = "tests/tests/system.rs";

/// Files of tests that take a minute or more; they run after the others of their chore.
const SLOW: &[&str] = &[
    "tests/tests/page.rs",
    "tests/tests/play.rs",
    "tests/tests/fault_table/main.rs",
];

/// Compiles every program and test.
pub fn build() -> Result<(), String> {
    programs().map(drop)
}

/// Tests of all packages but those of the whole system, and of all documentation.
pub fn crates() -> Result<(), String> {
    let tested = run_programs("crates", |folder| !SYSTEM.contains(&folder));
    let doc = ["test", "--release", "--workspace", "--doc", "--quiet"];
    tested.and(run("cargo", &doc))
}

/// Tests of several processes and hosts, and of the page in a browser.
pub fn system() -> Result<(), String> {
    // What drives the browser. A test that lacks it says so.
    if NODE.is_met() && !root().join(PAGE).join("node_modules").is_dir() {
        let _ = page_packages();
    }
    run_programs("system", |folder| SYSTEM.contains(&folder))
}

/// Whole sites in simulated time.
pub fn simulate(arguments: &[String]) -> Result<(), String> {
    // Not of its package: with the features of the whole workspace nothing is compiled anew.
    let run_it = ["run", "--release", "--quiet", "--bin", "simulate", "--"];
    let arguments = arguments.iter().map(String::as_str);
    run(
        "cargo",
        &run_it.into_iter().chain(arguments).collect::<Vec<_>>(),
    )
}

/// Seeds within which a planted fault is to be found.
const PLANTED_SEEDS: &str = "2000";
/// Begins the line of a patch that names the promise which the fault breaks.
const BREAKS: &str = "Breaks: ";

/// Plants each fault of `tests/simulation/planted` in a copy of the last commit, and has the simulation find it.
pub fn planted() -> Result<(), String> {
    let copy = root().join("target/planted");
    let at = copy.to_string_lossy().into_owned();
    if !copy.is_dir() {
        run("git", &["clone", "--quiet", &root().to_string_lossy(), &at])?;
    }
    let git = |arguments: &[&str]| run("git", &[&["-C", &at], arguments].concat());
    git(&["fetch", "--quiet", "origin", "HEAD"])?;
    let reset = || git(&["checkout", "--quiet", "--force", "--detach", "FETCH_HEAD"]);
    let mut missed = Vec::new();
    for patch in &planted_patches()? {
        let name = patch.file_stem().unwrap_or_default().to_string_lossy();
        let text = std::fs::read_to_string(patch).map_err(|cause| format!("{name}: {cause}"))?;
        let promise = text.lines().find_map(|line| line.strip_prefix(BREAKS));
        let promise = promise.ok_or_else(|| format!("{name}: no line '{BREAKS}...'"))?;
        reset()?;
        git(&["apply", &patch.to_string_lossy()])?;
        println!("planted: {name}");
        let found = simulated(&copy)?;
        println!("{}", found.trim_end());
        if !found.lines().any(|line| line.contains(promise)) {
            missed.push(name.into_owned());
        }
    }
    reset()?;
    match missed.as_slice() {
        [] => Ok(()),
        _ => Err(format!("not found: {}", missed.join(", "))),
    }
}

fn planted_patches() -> Result<Vec<PathBuf>, String> {
    let folder = root().join("tests/simulation/planted");
    let entries =
        std::fs::read_dir(&folder).map_err(|cause| format!("{}: {cause}", folder.display()))?;
    let mut patches: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    patches.sort();
    Ok(patches)
}

/// Whether every planted fault still fits the code that it breaks.
pub fn patches_apply() -> Result<(), String> {
    for patch in planted_patches()? {
        run("git", &["apply", "--check", &patch.to_string_lossy()])?;
    }
    Ok(())
}

/// What the simulation of a copy of this workspace says of the first promise that is broken.
fn simulated(copy: &Path) -> Result<String, String> {
    let cargo = |arguments: &[&str]| {
        let mut cargo = command("cargo");
        // In a folder of its own: Cargo would take what it has built of the copy for this workspace's.
        cargo.env("CARGO_TARGET_DIR", copy.join("target"));
        cargo.current_dir(copy).args(arguments);
        cargo.args(["--release", "--quiet", "--bin", "simulate"]);
        cargo
    };
    let built = cargo(&["build"])
        .status()
        .map_err(|cause| cause.to_string())?;
    if !built.success() {
        return Err("a patch does not compile".to_owned());
    }
    let mut run = cargo(&["run"]);
    run.args(["--", "--until-broken", "--seeds", PLANTED_SEEDS]);
    let output = run.output().map_err(|cause| cause.to_string())?;
    let words = String::from_utf8_lossy(&output.stdout);
    let of_seeds = words.lines().filter(|line| line.starts_with("seed "));
    Ok(of_seeds.collect::<Vec<_>>().join("\n"))
}

fn run_programs(word: &str, is_wanted: impl Fn(&str) -> bool) -> Result<(), String> {
    let programs = programs()?;
    let mut suites = Vec::new();
    for program in programs.iter().filter(|one| is_wanted(&one.folder())) {
        suites.extend(program.suites()?);
    }
    suites.sort_by_key(|suite| (SLOW.contains(&suite.file.as_str()), suite.file.clone()));
    let mut failed = Vec::new();
    for suite in suites {
        println!("xtask {word}: {}", suite.file);
        let mut test = suite.program.command();
        test.arg("--quiet").args(&suite.arguments);
        if !test.status().is_ok_and(|status| status.success()) {
            failed.push(suite.file);
        }
    }
    match failed.as_slice() {
        [] => Ok(()),
        _ => Err(failed.join(", ")),
    }
}

/// What of a test program is run at once.
struct Suite<'a> {
    program: &'a Program,
    /// Where the tests are.
    file: String,
    arguments: Vec<String>,
}

/// A test program of a package.
#[derive(Debug, PartialEq)]
struct Program {
    manifest: PathBuf,
    source: PathBuf,
    executable: String,
}

impl Program {
    /// Of a line that cargo prints about what it has built.
    fn read(line: &str) -> Option<Self> {
        let (target, profile) = line.split_once("\"profile\":{")?;
        let (profile, _) = profile.split_once('}')?;
        profile.contains("\"test\":true").then_some(())?;
        Some(Self {
            manifest: text(target, "manifest_path")?.into(),
            source: text(target, "src_path")?.into(),
            executable: text(line, "executable")?,
        })
    }

    /// Runs it in the folder of its package, as cargo does.
    fn command(&self) -> Command {
        let mut test = command(&self.executable);
        let package = root().join(self.folder());
        test.env("CARGO_MANIFEST_DIR", &package)
            .current_dir(&package);
        test
    }

    /// The whole program, or each of its modules.
    fn suites(&self) -> Result<Vec<Suite<'_>>, String> {
        let file = self.relative(&self.source);
        if file != BY_MODULE {
            return Ok(vec![Suite {
                program: self,
                file,
                arguments: Vec::new(),
            }]);
        }
        let list = self
            .command()
            .args(["--list", "--format", "terse"])
            .output();
        let list = list.map_err(|cause| format!("{file}: {cause}"))?;
        let modules = modules(&String::from_utf8_lossy(&list.stdout), &file);
        let suites = modules.into_iter().map(|(file, tests)| Suite {
            program: self,
            file,
            arguments: std::iter::once("--exact".to_owned()).chain(tests).collect(),
        });
        Ok(suites.collect())
    }

    /// The package's, within the workspace.
    fn folder(&self) -> String {
        self.relative(self.manifest.parent().unwrap_or(Path::new("")))
    }

    fn relative(&self, path: &Path) -> String {
        let root = root().canonicalize().unwrap_or_default();
        path.strip_prefix(root)
            .unwrap_or(path)
            .display()
            .to_string()
    }
}

/// Builds the test programs of the whole workspace.
fn programs() -> Result<Vec<Program>, String> {
    let mut build = command("cargo");
    build.args(["test", "--release", "--workspace", "--no-run"]);
    build.arg("--message-format=json-render-diagnostics");
    let output = build.stderr(Stdio::inherit()).output();
    let output = output.map_err(|cause| format!("cargo: {cause}"))?;
    if !output.status.success() {
        return Err("the tests do not compile".to_owned());
    }
    let lines = String::from_utf8_lossy(&output.stdout);
    Ok(lines.lines().filter_map(Program::read).collect())
}

/// The tests that a program lists, by the file of their module.
fn modules(list: &str, root: &str) -> BTreeMap<String, Vec<String>> {
    let mut modules = BTreeMap::<_, Vec<_>>::new();
    for test in list.lines().filter_map(|line| line.strip_suffix(": test")) {
        let file = match test.split_once("::") {
            Some((module, _)) => Path::new(root).with_file_name(format!("{module}.rs")),
            None => PathBuf::from(root),
        };
        let file = file.display().to_string();
        modules.entry(file).or_default().push(test.to_owned());
    }
    modules
}

/// The text of a field of JSON, where it is one without a quotation mark or backslash in it.
fn text(json: &str, field: &str) -> Option<String> {
    let (_, rest) = json.split_once(&format!("\"{field}\":\""))?;
    rest.split_once('"').map(|(text, _)| text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_of_tests_are_found_in_what_cargo_prints() {
        let line = |test: &str, executable: &str| {
            format!(
                r#"{{"reason":"compiler-artifact","package_id":"x","manifest_path":"/a b/tests/Cargo.toml","target":{{"kind":["test"],"name":"fleet","src_path":"/a b/tests/tests/fleet.rs","test":true}},"profile":{{"opt_level":"3","test":{test}}},"features":[],"executable":{executable},"fresh":true}}"#
            )
        };
        let program = Program::read(&line("true", "\"/a b/target/fleet-1\"")).expect("a program");
        assert_eq!(program.executable, "/a b/target/fleet-1");
        assert_eq!(program.folder(), "/a b/tests");
        assert_eq!(Program::read(&line("false", "\"/a b/target/fleet\"")), None);
        assert_eq!(Program::read(&line("true", "null")), None);
    }

    #[test]
    fn tests_of_a_program_are_sorted_by_their_modules() {
        let list = "doors::open: test\ndoors::shut: test\nall: test\n\n3 tests, 0 benchmarks\n";
        let modules: Vec<_> = modules(list, "tests/tests/system.rs").into_iter().collect();
        let of = |file: &str, tests: &[&str]| {
            let tests = tests.iter().map(|&test| test.to_owned());
            (format!("tests/tests/{file}"), tests.collect())
        };
        let doors = of("doors.rs", &["doors::open", "doors::shut"]);
        assert_eq!(modules, [doors, of("system.rs", &["all"])]);
    }

    /// The list is that of ARCHITECTURE.md.
    #[test]
    fn packages_are_listed_by_the_floors_of_the_map() {
        let map = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("a page");
        for line in map.lines() {
            let mut cells = line.split(" | ");
            let floor = cells.next().and_then(|cell| cell.strip_prefix("| "));
            let (Some(Ok(floor)), Some(packages)) = (floor.map(str::parse::<u32>), cells.next())
            else {
                continue;
            };
            for folder in packages.split('`').skip(1).step_by(2) {
                let is_own = folder == "crates/test-needs" || folder.starts_with("xtask");
                assert_eq!(SYSTEM.contains(&folder), floor == 10 && !is_own, "{folder}");
            }
        }
    }
}

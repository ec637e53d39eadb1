//! The fuzz targets of `fuzz/`, each for some seconds: libFuzzer by a stable compiler, by the flags that cargo-fuzz
//! would pass.

use crate::tools::{root, run, run_with, target};
use std::env;
use std::fs;
use std::process::Command;

/// Each target's seconds where the variable below says nothing: enough to notice what one input in ten thousand does.
const SECONDS: u32 = 5;
const SECONDS_VARIABLE: &str = "SEXTANT_FUZZ_SECONDS";
/// Coverage of edges, comparisons as hints.
const FLAGS: &[&str] = &[
    "-Cpasses=sancov-module",
    "-Cllvm-args=-sanitizer-coverage-level=4",
    "-Cllvm-args=-sanitizer-coverage-inline-8bit-counters",
    "-Cllvm-args=-sanitizer-coverage-pc-table",
    "-Cllvm-args=-sanitizer-coverage-trace-compares",
    "-Ccodegen-units=1",
    "--cfg=fuzzing",
];

/// Builds and runs every target; what it finds is left in `target/fuzz/TARGET`, with the inputs that it knows.
pub fn fuzz() -> Result<(), String> {
    let seconds = seconds()?;
    let host = host()?;
    let flags = FLAGS.join(" ");
    let build = ["build", "--release", "--manifest-path", "fuzz/Cargo.toml"];
    // Beside the workspace's own build, whose macros and build scripts it shares.
    let target = target().display().to_string();
    let place = ["--target-dir", &target, "--target", &host];
    run_with(
        &[("RUSTFLAGS", &flags)],
        "cargo",
        &[&build[..], &place].concat(),
    )?;
    for name in targets()? {
        let program = format!("{target}/{host}/release/{name}");
        let folder = format!("target/fuzz/{name}/");
        let corpus = format!("{folder}corpus");
        fs::create_dir_all(root().join(&corpus)).map_err(|cause| format!("{corpus}: {cause}"))?;
        println!("xtask fuzz: {name}, {seconds} s");
        let time = format!("-max_total_time={seconds}");
        let found = format!("-artifact_prefix={folder}");
        // No input may take longer than a second; ten, for machines that do other things beside.
        let limits = ["-timeout=10", "-rss_limit_mb=2048", "-max_len=65536"];
        let report = ["-len_control=0", "-print_final_stats=1", "-verbosity=0"];
        let seeds = format!("fuzz/seeds/{name}");
        let inputs = if root().join(&seeds).is_dir() {
            vec![corpus.as_str(), seeds.as_str()]
        } else {
            vec![corpus.as_str()]
        };
        run(
            &program,
            &[&[time.as_str(), &found][..], &limits, &report, &inputs].concat(),
        )?;
    }
    Ok(())
}

fn seconds() -> Result<u32, String> {
    match env::var(SECONDS_VARIABLE) {
        Ok(text) => text
            .parse()
            .map_err(|_| format!("{SECONDS_VARIABLE}={text}: give whole seconds")),
        Err(_) => Ok(SECONDS),
    }
}

/// By the files of `fuzz/targets`.
fn targets() -> Result<Vec<String>, String> {
    let folder = root().join("fuzz/targets");
    let failed = |cause| format!("{}: {cause}", folder.display());
    let mut targets = Vec::new();
    for file in fs::read_dir(&folder).map_err(failed)? {
        let path = file.map_err(failed)?.path();
        targets.extend(
            path.file_stem()
                .map(|stem| stem.to_string_lossy().into_owned()),
        );
    }
    targets.sort_unstable();
    Ok(targets)
}

/// Flags are for a named target only: build scripts and macros do without.
fn host() -> Result<String, String> {
    let output = Command::new("rustc").arg("-vV").output();
    let output = output.map_err(|cause| format!("rustc: {cause}"))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let host = text.lines().find_map(|line| line.strip_prefix("host: "));
    host.map(str::to_owned)
        .ok_or_else(|| "rustc -vV names no host".to_owned())
}

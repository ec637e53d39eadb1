//! Programs that chores call: those that they install for themselves below `target`, and how one is run.

use sextant_test_needs::locate;
use std::env;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An extension of cargo, in exactly this version.
pub struct CargoTool {
    pub name: &'static str,
    pub version: &'static str,
    /// Further options of `cargo install`.
    pub options: &'static [&'static str],
}

impl CargoTool {
    /// The program of this version: the one on the path, else one of our own, installed where it is missing. It takes
    /// minutes to compile and is
    /// kept in the user's cache, so that a fresh checkout finds it.
    pub fn program(&self) -> Result<String, String> {
        let folder = cache().unwrap_or_else(|_| root().join("target"));
        let folder = folder.join(format!("tools/{}-{}", self.name, self.version));
        let own = folder.join("bin").join(self.name);
        let installed = locate(self.name).filter(|file| self.is(file));
        if let Some(program) = installed.or_else(|| Some(own.clone()).filter(|file| self.is(file)))
        {
            return Ok(program.display().to_string());
        }
        println!("xtask: installing {} {}", self.name, self.version);
        let folder = folder.display().to_string();
        // Optimising them takes longer than all that they do here. What they are made of is largely the same.
        let built = root().join("target/tools/build").display().to_string();
        let quickly = [
            ("CARGO_PROFILE_RELEASE_LTO", "off"),
            ("CARGO_PROFILE_RELEASE_CODEGEN_UNITS", "16"),
            ("CARGO_PROFILE_RELEASE_DEBUG", "false"),
            ("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0"),
            ("CARGO_TARGET_DIR", &built),
        ];
        let install = [
            "install",
            self.name,
            "--version",
            self.version,
            "--locked",
            "--quiet",
            "--root",
            &folder,
        ];
        run_with(&quickly, "cargo", &[&install[..], self.options].concat())?;
        Ok(own.display().to_string())
    }

    fn is(&self, program: &Path) -> bool {
        let Self { name, version, .. } = self;
        // Cargo calls an extension with its own name first, and some ask for that.
        let subcommand = name.trim_start_matches("cargo-");
        let says = |arguments: &[&str]| {
            let output = Command::new(program).args(arguments).output();
            output.is_ok_and(|output| {
                String::from_utf8_lossy(&output.stdout)
                    .split_whitespace()
                    .any(|word| word.trim_start_matches('v') == *version)
            })
        };
        says(&["--version"]) || says(&[subcommand, "--version"])
    }
}

/// The user's cache, for what takes long to make and outlives a checkout.
pub fn cache() -> Result<PathBuf, String> {
    let set = |name: &str| env::var_os(name).filter(|value| !value.is_empty());
    let folder = set("XDG_CACHE_HOME").map(PathBuf::from);
    folder
        .or_else(|| set("HOME").map(|home| Path::new(&home).join(".cache")))
        .map(|folder| folder.join("sextant"))
        .ok_or_else(|| {
            "set XDG_CACHE_HOME or HOME: what takes long to make is kept there".to_owned()
        })
}

/// Cargo with zig as the linker and C compiler, so that a program needs no newer C library than the one named.
pub struct Zigbuild {
    pub program: String,
    pub compiler: String,
}

/// Both as wheels of one version, below `target`.
const ZIGBUILD: [&str; 2] = ["cargo-zigbuild==0.24.0", "ziglang==0.17.1"];

impl Zigbuild {
    /// Installs it where it is missing.
    pub fn installed() -> Result<Self, String> {
        let versions = ZIGBUILD.join("-").replace("==", "-");
        let folder = root().join(format!("target/tools/{versions}"));
        let zigbuild = Self {
            program: folder.join("bin/cargo-zigbuild").display().to_string(),
            compiler: folder.join("ziglang/zig").display().to_string(),
        };
        if !Path::new(&zigbuild.program).is_file() {
            println!("xtask: installing {}", ZIGBUILD.join(" and "));
            let target = ["--target", &folder.display().to_string()];
            let quiet = ["install", "--quiet", "--root-user-action=ignore"];
            run("pip3", &[&quiet[..], &target, &ZIGBUILD].concat())?;
        }
        Ok(zigbuild)
    }
}

/// The folder of the workspace.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Where cargo builds, as its variable `CARGO_TARGET_DIR` gives it; by default below the root.
pub fn target() -> PathBuf {
    let configured = env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    root().join(configured.unwrap_or_else(|| "target".into()))
}

/// Runs a program in the workspace's root and fails with its command line.
pub fn run(program: &str, arguments: &[&str]) -> Result<(), String> {
    run_in(".", program, arguments)
}

/// Runs a program in the workspace's root with variables more in its environment.
pub fn run_with(
    variables: &[(&str, &str)],
    program: &str,
    arguments: &[&str],
) -> Result<(), String> {
    wait(
        command(program)
            .envs(variables.iter().copied())
            .args(arguments),
    )
}

/// Copies a file into a folder, made when missing, under the name and with the rights that it has there.
pub fn copy(file: &Path, folder: &Path, mode: u32) -> Result<(), String> {
    let name = file.file_name().unwrap_or_default();
    let failed = |cause: std::io::Error| format!("{}: {cause}", file.display());
    fs::create_dir_all(folder).map_err(failed)?;
    fs::copy(file, folder.join(name)).map_err(failed)?;
    fs::set_permissions(folder.join(name), fs::Permissions::from_mode(mode)).map_err(failed)
}

/// Every file below a folder, by its path there.
pub fn files_below(folder: &Path) -> Result<Vec<(String, Vec<u8>)>, String> {
    let failed = |cause: std::io::Error| format!("{}: {cause}", folder.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if path.is_dir() {
            found.extend(
                files_below(&path)?
                    .into_iter()
                    .map(|(below, bytes)| (format!("{name}/{below}"), bytes)),
            );
        } else {
            found.push((name, fs::read(&path).map_err(failed)?));
        }
    }
    found.sort();
    Ok(found)
}

/// Packs a file, the same bytes at any time.
pub fn gzip(file: &Path, packed: &Path) -> Result<(), String> {
    let failed = |cause: std::io::Error| format!("{}: {cause}", packed.display());
    if let Some(folder) = packed.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    let output = Command::new("gzip")
        .args(["-9", "--no-name", "--stdout"])
        .arg(file)
        .output();
    fs::write(packed, output.map_err(failed)?.stdout).map_err(failed)
}

/// A command in the workspace's root.
pub fn command(program: &str) -> Command {
    let mut command = Command::new(program);
    command.current_dir(root());
    command
}

/// Runs a program in a folder below the workspace's root.
pub fn run_in(folder: &str, program: &str, arguments: &[&str]) -> Result<(), String> {
    wait(
        command(program)
            .args(arguments)
            .current_dir(root().join(folder)),
    )
}

/// Runs a command to its end.
pub fn wait(command: &mut Command) -> Result<(), String> {
    let words = |command: &Command| {
        let words = std::iter::once(command.get_program()).chain(command.get_args());
        let words: Vec<_> = words.map(|word| word.to_string_lossy()).collect();
        words.join(" ")
    };
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("`{}` ended with {status}", words(command))),
        Err(cause) => Err(format!("`{}`: {cause}", words(command))),
    }
}

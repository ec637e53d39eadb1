//! Programs that are not Rust's: which chore needs which, found, installed where that is possible, or named.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A program that a chore calls.
pub struct Tool {
    /// The program looked for on the path.
    pub program: &'static str,
    /// Debian's package; `None` where Debian's is too old.
    pub package: Option<&'static str>,
    /// What a person does who has no Debian.
    pub remedy: &'static str,
}

const NODE: Tool = Tool {
    program: "node",
    package: None,
    remedy: "install Node.js 20.19 or newer (https://nodejs.org)",
};
const NPM: Tool = Tool {
    program: "npm",
    package: None,
    remedy: "install npm (it comes with Node.js)",
};
const CHROMIUM: Tool = Tool {
    program: "chromium",
    package: Some("chromium"),
    remedy: "install Chromium",
};
const UNSHARE: Tool = Tool {
    program: "unshare",
    package: Some("util-linux"),
    remedy: "install util-linux",
};
const QEMU_ARM: Tool = Tool {
    program: "qemu-arm",
    package: Some("qemu-user"),
    remedy: "install qemu's user-mode emulation",
};
const QEMU_AARCH64: Tool = Tool {
    program: "qemu-aarch64",
    package: Some("qemu-user"),
    remedy: "install qemu's user-mode emulation",
};
const GCC_ARM: Tool = Tool {
    program: "arm-linux-gnueabihf-gcc",
    package: Some("gcc-arm-linux-gnueabihf"),
    remedy: "install a C compiler for arm-linux-gnueabihf",
};
const GCC_AARCH64: Tool = Tool {
    program: "aarch64-linux-gnu-gcc",
    package: Some("gcc-aarch64-linux-gnu"),
    remedy: "install a C compiler for aarch64-linux-gnu",
};

const SSHD: Tool = Tool {
    program: "sshd",
    package: Some("openssh-server"),
    remedy: "install the OpenSSH server",
};
const IP: Tool = Tool {
    program: "ip",
    package: Some("iproute2"),
    remedy: "install iproute2",
};
const FFMPEG: Tool = Tool {
    program: "ffmpeg",
    package: Some("ffmpeg"),
    remedy: "install FFmpeg",
};
const PIP: Tool = Tool {
    program: "pip3",
    package: Some("python3-pip"),
    remedy: "install Python's pip",
};
const PYTHON: Tool = Tool {
    program: "python3",
    package: Some("python3-venv"),
    remedy: "install Python 3.9 or newer",
};
/// Not a program: a module that may be missing beside `python3`.
pub const VENV: Tool = Tool {
    program: "python3 -m venv",
    package: Some("python3-venv"),
    remedy: "install Python's module venv",
};
const DPKG_DEB: Tool = Tool {
    program: "dpkg-deb",
    package: None,
    remedy: "build packages on Debian or one of its descendants",
};
const SYSUSERS: Tool = Tool {
    program: "systemd-sysusers",
    package: Some("systemd"),
    remedy: "install systemd",
};
const LINTIAN: Tool = Tool {
    program: "lintian",
    package: Some("lintian"),
    remedy: "install lintian",
};

const CXX: Tool = Tool {
    program: "c++",
    package: Some("g++"),
    remedy: "install a C++ compiler",
};

/// What a chore needs beside Rust and a C compiler.
fn needs(chore: &str) -> &'static [Tool] {
    match chore {
        "page" => &[NODE, NPM],
        "workspace" => &[NODE, CHROMIUM, UNSHARE, FFMPEG, SSHD, IP],
        "ros2" => &[PYTHON],
        "arm" => &[QEMU_ARM, QEMU_AARCH64, GCC_ARM, GCC_AARCH64],
        "cross" => &[GCC_ARM, GCC_AARCH64],
        "python-test" => &[PYTHON],
        "fuzz" => &[CXX],
        "package" | "board" => &[PIP, DPKG_DEB, SYSUSERS, LINTIAN],
        _ => &[],
    }
}

/// Compilation targets a chore needs beside this machine's own.
fn targets(chore: &str) -> &'static [&'static str] {
    match chore {
        "cross" => &["aarch64-unknown-linux-gnu", "armv7-unknown-linux-gnueabihf"],
        "board" => &["armv7-unknown-linux-gnueabihf"],
        "arm" | "package" => &[
            "aarch64-unknown-linux-gnu",
            "armv7-unknown-linux-gnueabihf",
            "thumbv7neon-unknown-linux-gnueabihf",
        ],
        _ => &[],
    }
}

/// Finds or installs what the chores need; names everything that is missing at once.
pub fn require_all(chores: &[&str]) -> Result<(), String> {
    let needed: Vec<&Tool> = chores.iter().flat_map(|chore| needs(chore)).collect();
    let unmet = unmet(&needed);
    if !unmet.is_empty() {
        return Err(format!("missing programs\n{}", unmet.join("\n")));
    }
    chores
        .iter()
        .flat_map(|chore| targets(chore))
        .try_for_each(|target| add_target(target))
}

/// Finds or installs programs; a line for each that is not to be had.
pub fn unmet(needed: &[&Tool]) -> Vec<String> {
    let mut missing: Vec<&Tool> = Vec::new();
    for tool in needed {
        if locate(tool.program).is_none() && !missing.iter().any(|m| m.program == tool.program) {
            missing.push(tool);
        }
    }
    install(&missing);
    let unmet = missing.iter().filter(|tool| locate(tool.program).is_none());
    unmet
        .map(|tool| format!("  {}: {}", tool.program, tool.advice()))
        .collect()
}

impl Tool {
    /// What a person does who lacks it.
    pub fn advice(&self) -> String {
        let package = self.package;
        let hint = package.map(|name| format!("; on Debian: sudo apt-get install {name}"));
        self.remedy.to_owned() + &hint.unwrap_or_default()
    }
}

/// As root on a Debian machine the packages are installed; elsewhere the caller names them.
pub fn install(missing: &[&Tool]) {
    let packages: Vec<&str> = missing.iter().filter_map(|tool| tool.package).collect();
    if packages.is_empty() || locate("apt-get").is_none() || !is_root() {
        return;
    }
    println!("xtask: installing {}", packages.join(" "));
    let apt = |arguments: &[&str]| {
        let quiet = Command::new("apt-get")
            // Another chore may be installing its own.
            .args(["-o", "DPkg::Lock::Timeout=600"])
            .args(arguments)
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdout(Stdio::null())
            .status();
        matches!(quiet, Ok(status) if status.success())
    };
    let _ =
        apt(&["update", "-q"]) && apt(&[&["install", "-y", "-q"], packages.as_slice()].concat());
}

fn is_root() -> bool {
    Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|output| output.stdout.starts_with(b"0\n"))
}

/// The first file of that name on the path.
pub fn locate(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    // Servers are on root's path alone.
    std::env::split_paths(&path)
        .chain(["/usr/sbin".into()])
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

/// An extension of cargo, in exactly this version.
pub struct CargoTool {
    pub name: &'static str,
    pub version: &'static str,
    /// Further options of `cargo install`.
    pub options: &'static [&'static str],
}

impl CargoTool {
    /// The program of this version: the one on the path, else one of our own below `target`, installed where it is missing.
    pub fn program(&self) -> Result<String, String> {
        let folder = root().join("target/tools");
        let own = folder.join("bin").join(self.name);
        let installed = locate(self.name).filter(|file| self.is(file));
        if let Some(program) = installed.or_else(|| Some(own.clone()).filter(|file| self.is(file)))
        {
            return Ok(program.display().to_string());
        }
        println!("xtask: installing {} {}", self.name, self.version);
        let folder = folder.display().to_string();
        // As they come, both are optimised as a whole, which takes longer than all that they do here.
        let install = [
            "CARGO_PROFILE_RELEASE_LTO=off",
            "CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16",
            "CARGO_PROFILE_RELEASE_OPT_LEVEL=1",
            "cargo",
            "install",
            self.name,
            "--version",
            self.version,
            "--locked",
            "--quiet",
            "--root",
            &folder,
        ];
        run("env", &[&install[..], self.options].concat())?;
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

/// Cargo with zig as the linker and C compiler, so that a program needs no newer C library than it is told.
pub struct Zigbuild {
    pub program: String,
    /// Where the compiler is.
    pub environment: (&'static str, String),
}

/// Both as wheels of one version, below `target`.
const ZIGBUILD: [&str; 2] = ["cargo-zigbuild==0.24.0", "ziglang==0.17.1"];

impl Zigbuild {
    /// Installs it where it is missing.
    pub fn installed() -> Result<Self, String> {
        // No equals sign: `env` would take the program's path for a variable.
        let versions = ZIGBUILD.join("-").replace("==", "-");
        let folder = root().join(format!("target/tools/{versions}"));
        let zigbuild = Self {
            program: folder.join("bin/cargo-zigbuild").display().to_string(),
            environment: (
                "CARGO_ZIGBUILD_ZIG_PATH",
                folder.join("ziglang/zig").display().to_string(),
            ),
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

fn add_target(target: &str) -> Result<(), String> {
    let listed = Command::new("rustup")
        .args(["target", "list", "--installed"])
        .output();
    if listed.is_ok_and(|output| {
        String::from_utf8_lossy(&output.stdout)
            .lines()
            .any(|line| line == target)
    }) {
        return Ok(());
    }
    run("rustup", &["target", "add", target])
}

/// The workspace's root.
pub fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Runs a program in the workspace's root and fails with its command line.
pub fn run(program: &str, arguments: &[&str]) -> Result<(), String> {
    run_in(".", program, arguments)
}

/// Runs a program with a variable more in its environment.
pub fn run_with(
    (variable, value): &(&str, String),
    program: &str,
    arguments: &[&str],
) -> Result<(), String> {
    let variable = format!("{variable}={value}");
    run(
        "env",
        &[&[variable.as_str(), program][..], arguments].concat(),
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
    // What `cargo run` tells a program of its own package. ring's build script watches such variables, and all that needs TLS
    // would be compiled anew whenever a chore follows a plain `cargo build`.
    for (name, _) in std::env::vars_os() {
        let name = name.to_string_lossy();
        if name.starts_with("CARGO_PKG_") || name.starts_with("CARGO_MANIFEST_") {
            command.env_remove(name.as_ref());
        }
    }
    command
}

/// Runs a program in a folder below the workspace's root.
pub fn run_in(folder: &str, program: &str, arguments: &[&str]) -> Result<(), String> {
    let status = command(program)
        .args(arguments)
        .current_dir(root().join(folder))
        .status()
        .map_err(|cause| format!("{program}: {cause}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!(
            "`{program} {}` ended with {status}",
            arguments.join(" ")
        ))
    }
}

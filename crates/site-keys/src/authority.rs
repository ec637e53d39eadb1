//! The authority's folder: adds, renews and revokes members, one process at a time.

use crate::KeysError;
use crate::certificates::{self, Issuer, Subject};
use crate::folder::{FolderFiles, in_place_of, remove_keys, remove_leftovers, write_secret};
use crate::secrets::random_text;
use sextant_process::host::host_name;
use sextant_proto::{NodeId, SiteId};
use sextant_site_files::{read_toml, write_atomically};
use sextant_zenoh_bus::{KeyFiles, Member, Members, NodeKeys, Role};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::net::IpAddr;
use std::path::{Path, PathBuf};

const DAY_S: u64 = 86_400;
/// Validity of an authority.
const AUTHORITY_DAYS: u64 = 20 * 365;
/// A file of the authority's folder whose name could be a member's.
const PASSWORDS: &str = "passwords";

/// A site's authority, locked by this process.
pub struct Authority {
    dir: PathBuf,
    members: Members,
    _lock: File,
}

/// A request for a certificate.
pub struct CertificateRequest<'a> {
    /// Seconds since the Unix epoch.
    pub now_s: u64,
    /// Its validity.
    pub days: u32,
    /// Names and addresses of its machine.
    pub hosts: &'a [String],
}

impl Authority {
    /// Creates an authority.
    ///
    /// # Errors
    /// A folder that is not empty, or an error of the system.
    pub fn init(dir: &Path, site: &SiteId, now_s: u64) -> Result<(), KeysError> {
        let is_free = fs::read_dir(dir).map_or(true, |mut entries| entries.next().is_none());
        if !is_free {
            return Err(KeysError::NotEmpty(dir.to_owned()));
        }
        if dir.is_dir() {
            fs::remove_dir(dir).map_err(KeysError::system(dir, ": cannot be made private"))?;
        }
        let valid_until_s = now_s + AUTHORITY_DAYS * DAY_S;
        let made = certificates::authority(site, valid_until_s)?;
        in_place_of(dir, |folder| {
            write_secret(&folder.join("authority.key"), &made.key)?;
            write_atomically(&folder.join("authority.pem"), made.certificate.as_bytes())?;
            write_secret(&folder.join(PASSWORDS), "")?;
            let members = Members {
                site: site.clone(),
                authority_valid_until_s: valid_until_s,
                members: Vec::new(),
            };
            write_atomically(&folder.join("members.toml"), toml_of(&members)?.as_bytes())?;
            Ok(())
        })
    }

    /// Opens an authority's folder; waits for another process that has it open.
    ///
    /// # Errors
    /// A folder without an authority.
    pub fn open(dir: &Path) -> Result<Self, KeysError> {
        let lock = File::open(dir).map_err(|cause| no_authority(dir, Some(cause.into())))?;
        lock.lock()
            .map_err(|cause| no_authority(dir, Some(cause.into())))?;
        let members = read_toml(&dir.join("members.toml"))
            .map_err(|cause| no_authority(dir, Some(cause.into())))?;
        if !dir.join("authority.key").is_file() {
            return Err(no_authority(dir, None));
        }
        // The lock is ours: whatever is half made was left behind by a process that was killed.
        remove_leftovers(dir)?;
        Ok(Self {
            dir: dir.to_owned(),
            members,
            _lock: lock,
        })
    }

    /// All members, including revoked ones.
    pub fn members(&self) -> &Members {
        &self.members
    }

    /// The files of a member's keys, whether or not there is such a member.
    pub fn folder_of(&self, name: &str) -> KeyFiles {
        KeyFiles::within(&self.dir.join(name))
    }

    /// Creates a member.
    ///
    /// # Errors
    /// A name in use, an expired authority, or an error of the system.
    pub fn add(
        &mut self,
        name: &NodeId,
        role: Role,
        new: &CertificateRequest<'_>,
    ) -> Result<Member, KeysError> {
        if name.as_str() == PASSWORDS {
            return Err(KeysError::ReservedName(name.clone()));
        }
        if let Some(member) = self.members.find(name.as_str()) {
            return Err(KeysError::NameTaken {
                name: name.clone(),
                role: member.role,
            });
        }
        let folder = self.folder_of(name.as_str());
        if folder.folder().exists() {
            return Err(KeysError::InTheWay {
                folder: folder.folder().to_owned(),
                name: name.clone(),
            });
        }
        let same_name = |member: &&Member| member.name == *name;
        let number = self.members.members.iter().filter(same_name).count() + 1;
        let member = Member {
            name: name.clone(),
            role,
            common_name: format!("{name}.{number}"),
            valid_until_s: self.valid_until_s(new)?,
            revoked: false,
        };
        let secrets = Secrets {
            password: random_text()?,
            page_tokens: page_tokens()?,
        };
        self.make(&member, &secrets, new)?;
        self.members.members.push(member.clone());
        let mut passwords = self.passwords()?;
        passwords.push_str(&format!("{}:{}\n", member.common_name, secrets.password));
        self.save(&passwords)?;
        Ok(member)
    }

    /// Renews the keys of a member; its password and the tokens of its page stay.
    ///
    /// # Errors
    /// An unknown name, an expired authority, or an error of the system.
    pub fn renew(
        &mut self,
        name: &NodeId,
        new: &CertificateRequest<'_>,
    ) -> Result<Member, KeysError> {
        let name = name.as_str();
        let valid_until_s = self.valid_until_s(new)?;
        let member = self.find(name)?;
        member.valid_until_s = valid_until_s;
        let member = member.clone();
        let passwords = self.passwords()?;
        let head = format!("{}:", member.common_name);
        let password = passwords.lines().find_map(|line| line.strip_prefix(&head));
        let tokens = self.folder_of(name).page_tokens();
        let secrets = Secrets {
            password: password.ok_or(KeysError::NoPassword)?.to_owned(),
            page_tokens: fs::read_to_string(tokens).or_else(|_| page_tokens())?,
        };
        self.make(&member, &secrets, new)?;
        self.save(&passwords)?;
        Ok(member)
    }

    /// Revokes a member's keys and removes its folder.
    ///
    /// # Errors
    /// An unknown name, or an error of the system.
    pub fn revoke(&mut self, name: &NodeId) -> Result<Member, KeysError> {
        let member = self.find(name.as_str())?;
        member.revoked = true;
        let member = member.clone();
        self.save(&self.passwords()?)?;
        remove_keys(&self.folder_of(name.as_str()))?;
        Ok(member)
    }

    fn find(&mut self, name: &str) -> Result<&mut Member, KeysError> {
        let dir = &self.dir;
        let mut members = self.members.members.iter_mut();
        let found = members.find(|member| member.name.as_str() == name && !member.revoked);
        found.ok_or_else(|| KeysError::UnknownMember {
            name: name.to_owned(),
            dir: dir.clone(),
        })
    }

    fn valid_until_s(&self, new: &CertificateRequest<'_>) -> Result<u64, KeysError> {
        let last_s = self.members.authority_valid_until_s;
        if new.now_s >= last_s {
            return Err(KeysError::Expired(self.dir.clone()));
        }
        Ok(last_s.min(new.now_s + u64::from(new.days) * DAY_S))
    }

    /// Writes a member's folder and replaces its former one.
    fn make(
        &self,
        member: &Member,
        secrets: &Secrets,
        new: &CertificateRequest<'_>,
    ) -> Result<(), KeysError> {
        let files = FolderFiles::read(&self.dir)?;
        let issuer = Issuer::new(self.members.site.as_str(), &files.authority_key)?;
        let hosts = hosts(new.hosts)?;
        let node = issuer.sign(&Subject::node(member, &hosts))?;
        let page = member
            .role
            .has_page()
            .then(|| issuer.sign(&Subject::page(member, &hosts)))
            .transpose()?;
        in_place_of(self.folder_of(member.name.as_str()).folder(), |folder| {
            let to = KeyFiles::within(folder);
            write_secret(&to.private_key(), &node.key)?;
            write_secret(&to.password(), &secrets.password)?;
            let node_toml = NodeKeys::node_toml(&self.members.site, member);
            let node_toml = node_toml.map_err(|cause| KeysError::Text(cause.to_string()))?;
            write_atomically(&to.certificate(), node.certificate.as_bytes())?;
            write_atomically(&to.authority(), files.authority.as_bytes())?;
            write_atomically(&to.node(), node_toml.as_bytes())?;
            if let Some(page) = page {
                write_secret(&to.page_private_key(), &page.key)?;
                write_secret(&to.page_tokens(), &secrets.page_tokens)?;
                write_atomically(&to.page_certificate(), page.certificate.as_bytes())?;
            }
            Ok(())
        })
    }

    /// The passwords of all members, one per line: `<common name>:<password>`.
    fn passwords(&self) -> Result<String, KeysError> {
        let file = self.dir.join(PASSWORDS);
        fs::read_to_string(&file).map_err(KeysError::system(&file, ": cannot be read"))
    }

    /// The tokens of phones, which are their passwords, as `phones.toml`.
    fn phones(&self, passwords: &str) -> String {
        let head =
            "# Browsers that may be cameras, and the token of each. Written by `sextant keys`.\n";
        let phones = self.members.accepted().filter(|it| it.role == Role::Phone);
        let lines = phones.filter_map(|phone| {
            let head = format!("{}:", phone.common_name);
            let token = passwords.lines().find_map(|line| line.strip_prefix(&head));
            Some(format!("{} = \"{}\"\n", phone.name, token?))
        });
        lines.fold(head.to_owned(), |text, line| text + &line)
    }

    /// Writes the list of members here and in the folders of fusion nodes and routers below, with these passwords,
    /// except those of revoked members.
    fn save(&self, passwords: &str) -> Result<(), KeysError> {
        let accepted: BTreeSet<&str> = self
            .members
            .accepted()
            .map(|member| member.common_name.as_str())
            .collect();
        let is_accepted = |line: &&str| {
            line.split_once(':')
                .is_some_and(|(name, _)| accepted.contains(name))
        };
        let kept: Vec<&str> = passwords.lines().filter(is_accepted).collect();
        let passwords: String = kept.iter().map(|line| format!("{line}\n")).collect();
        let text = toml_of(&self.members)?;
        write_atomically(&self.dir.join("members.toml"), text.as_bytes())?;
        write_secret(&self.dir.join(PASSWORDS), &passwords)?;
        let is_router = |member: &&Member| member.role.can_be_router();
        for member in self.members.accepted().filter(is_router) {
            let files = self.folder_of(member.name.as_str());
            if files.folder().is_dir() {
                write_atomically(&files.members(), text.as_bytes())?;
                write_secret(&files.passwords(), &passwords)?;
            }
        }
        let phones = self.phones(&passwords);
        for member in self.members.accepted().filter(|it| it.role.has_page()) {
            let files = self.folder_of(member.name.as_str());
            if files.folder().is_dir() {
                write_secret(&files.phones(), &phones)?;
            }
        }
        Ok(())
    }
}

/// A file with new tokens.
fn page_tokens() -> Result<String, KeysError> {
    let (read, operate) = (random_text()?, random_text()?);
    Ok(format!(
        "# Who may use the page: who says the first token may look, who says the second may also \
         change the site.\nread = \"{read}\"\noperate = \"{operate}\"\n"
    ))
}

/// Parts of a member's folder that survive a renewal.
struct Secrets {
    password: String,
    page_tokens: String,
}

/// The given hosts, and those of this machine.
fn hosts(given: &[String]) -> Result<Vec<String>, KeysError> {
    let is_host = |host: &&String| {
        let mut letters = host.bytes();
        host.parse::<IpAddr>().is_ok()
            || !host.is_empty()
                && letters.all(|letter| letter.is_ascii_alphanumeric() || b".-".contains(&letter))
    };
    if let Some(wrong) = given.iter().find(|host| !is_host(host)) {
        return Err(KeysError::Host(wrong.clone()));
    }
    let own = [
        host_name(),
        "localhost".to_owned(),
        "127.0.0.1".to_owned(),
        "::1".to_owned(),
    ];
    let mut hosts = given.to_vec();
    for host in own {
        if !hosts.contains(&host) && !host.is_empty() {
            hosts.push(host);
        }
    }
    Ok(hosts)
}

fn toml_of(members: &Members) -> Result<String, KeysError> {
    members
        .to_toml()
        .map_err(|cause| KeysError::Text(cause.to_string()))
}

fn no_authority(dir: &Path, source: Option<Box<dyn std::error::Error + Send + Sync>>) -> KeysError {
    KeysError::NoAuthority {
        dir: dir.to_owned(),
        source,
    }
}

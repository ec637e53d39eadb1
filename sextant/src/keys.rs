//! `sextant keys`: a site's authority, the keys of its members, and their revocation.

use crate::output::{Format, print_line};
use anyhow::Context;
use clap::{Args, Subcommand, ValueEnum};
use serde_json::json;
use sextant_process::{Exit, WithExit, now_ns};
use sextant_proto::{NodeId, SiteId};
use sextant_site_keys::{Authority, CertificateRequest};
use sextant_zenoh_bus::{Member, Role};
use std::path::PathBuf;
use time::OffsetDateTime;

/// What to do with the keys of a site's members.
#[derive(Args, Debug)]
#[command(after_help = "For example:
  sextant keys init site-keys --site lab
  sextant keys add site-keys fusion --role fusion --host fusion.lab
  sextant keys add site-keys north --role camera
  sextant keys add site-keys pocket --role phone
then copy site-keys/north to the board and name it in camera.toml: [security] profile = \"site\", keys = \"north\".
After add, renew and revoke copy the folders of fusion nodes and routers again and restart those nodes: they enforce the
list of members. With --json, a line a member: {\"name\",\"role\",\"common_name\",\"valid_until\",\"state\"}, state
being valid, expired or revoked. Exit code 3 when something is refused. docs/security-setup.md goes the whole way.")]
pub struct KeysArguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Create a site's authority in a new folder.
    Init {
        /// The folder; it must not exist or must be empty.
        dir: PathBuf,
        /// Name of the site, which is part of every key.
        #[arg(long)]
        site: SiteId,
    },
    /// Create the keys of a new member in DIR/NAME.
    Add {
        /// The authority's folder.
        dir: PathBuf,
        /// Name of the member: a camera's id or a node's name.
        name: NodeId,
        /// Its role.
        #[arg(long, value_enum)]
        role: RoleWord,
        #[command(flatten)]
        validity: Validity,
    },
    /// Renew the keys of a member.
    Renew {
        /// The authority's folder.
        dir: PathBuf,
        /// Name of the member.
        name: NodeId,
        #[command(flatten)]
        validity: Validity,
    },
    /// Revoke the keys of a member.
    Revoke {
        /// The authority's folder.
        dir: PathBuf,
        /// Name of the member.
        name: NodeId,
    },
    /// List the members with role and validity.
    List {
        /// The authority's folder.
        dir: PathBuf,
    },
}

#[derive(Args, Debug)]
struct Validity {
    /// Validity of the certificate in days, at most that of the authority, which is 20 years.
    #[arg(long, default_value_t = 730, value_parser = clap::value_parser!(u32).range(1..=7300))]
    days: u32,
    /// For a fusion node or a router: a name or address under which nodes connect to it. For a viewer or an operator:
    /// one under which browsers reach its page. This machine's name, localhost and 127.0.0.1 are always included. May
    /// be repeated.
    #[arg(long = "host", value_name = "NAME|ADDRESS")]
    hosts: Vec<String>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum RoleWord {
    /// Publishes below its own camera's key.
    Camera,
    /// Publishes poses and configuration; can be the router.
    Fusion,
    /// Is a router apart from the fusion nodes.
    Router,
    /// Reads everything.
    Viewer,
    /// Reads everything; changes the rig and the objects.
    Operator,
    /// A browser that is a camera, by the page of a viewer or operator.
    Phone,
}

impl From<RoleWord> for Role {
    fn from(word: RoleWord) -> Self {
        match word {
            RoleWord::Camera => Self::Camera,
            RoleWord::Fusion => Self::Fusion,
            RoleWord::Router => Self::Router,
            RoleWord::Viewer => Self::Viewer,
            RoleWord::Operator => Self::Operator,
            RoleWord::Phone => Self::Phone,
        }
    }
}

/// Runs `sextant keys`.
///
/// # Errors
/// [`Exit::Input`] for refused requests.
pub fn run(arguments: &KeysArguments, format: Format) -> anyhow::Result<()> {
    obey(&arguments.command, format).exit_with(Exit::Input)
}

fn obey(command: &Command, format: Format) -> anyhow::Result<()> {
    let now_s = now_ns() / 1_000_000_000;
    match command {
        Command::Init { dir, site } => {
            Authority::init(dir, site, now_s)?;
            let (folder, site) = (dir.display().to_string(), site.as_str());
            match format {
                Format::Json => print_line(&json!({"folder": folder, "site": site}).to_string())?,
                Format::Text => print_line(&format!(
                    "{folder} is the authority of site {site}. Keep it on one safe machine: \
                     anyone who can read authority.key can create members."
                ))?,
            }
        }
        Command::Add {
            dir,
            name,
            role,
            validity,
        } => {
            let mut authority = Authority::open(dir)?;
            let member = authority.add(name, Role::from(*role), &validity.request(now_s))?;
            say(&authority, &member, now_s, format)?;
        }
        Command::Renew {
            dir,
            name,
            validity,
        } => {
            let mut authority = Authority::open(dir)?;
            let member = authority.renew(name, &validity.request(now_s))?;
            say(&authority, &member, now_s, format)?;
        }
        Command::Revoke { dir, name } => {
            let mut authority = Authority::open(dir)?;
            let member = authority.revoke(name)?;
            line(&member, now_s, format)?;
            advise(&authority, format)?;
        }
        Command::List { dir } => {
            let authority = Authority::open(dir)?;
            let members = &authority.members().members;
            members
                .iter()
                .try_for_each(|member| line(member, now_s, format))?;
        }
    }
    Ok(())
}

impl Validity {
    fn request(&self, now_s: u64) -> CertificateRequest<'_> {
        CertificateRequest {
            now_s,
            days: self.days,
            hosts: &self.hosts,
        }
    }
}

/// Describes what was created and what to do with it.
fn say(authority: &Authority, member: &Member, now_s: u64, format: Format) -> anyhow::Result<()> {
    line(member, now_s, format)?;
    if format == Format::Json {
        return Ok(());
    }
    let folder = authority.folder_of(member.name.as_str());
    print_line(&format!("keys in {}", folder.folder().display()))?;
    if member.role == Role::Phone {
        print_line(
            "copy the folders of viewers and operators again, restart those nodes, and run \
             `sextant phone --config viewer.toml` there: it shows the phone's link",
        )?;
    }
    if member.role.has_page() {
        let tokens = folder.page_tokens();
        print_line(&format!("tokens of its page in {}", tokens.display()))?;
    }
    advise(authority, format)
}

fn advise(authority: &Authority, format: Format) -> anyhow::Result<()> {
    let mut routers = authority
        .members()
        .accepted()
        .filter(|member| member.role.can_be_router())
        .map(|member| {
            authority
                .folder_of(member.name.as_str())
                .folder()
                .display()
                .to_string()
        })
        .peekable();
    if format == Format::Text && routers.peek().is_some() {
        let folders: Vec<String> = routers.collect();
        print_line(&format!(
            "copy {} to its machine again and restart the node: it enforces the list of members",
            folders.join(", ")
        ))?;
    }
    Ok(())
}

fn line(member: &Member, now_s: u64, format: Format) -> anyhow::Result<()> {
    let state = if member.revoked {
        "revoked"
    } else if now_s >= member.valid_until_s {
        "expired"
    } else {
        "valid"
    };
    let until = date(member.valid_until_s)?;
    match format {
        Format::Json => print_line(
            &json!({
                "name": member.name, "role": member.role, "common_name": member.common_name,
                "valid_until": until, "state": state,
            })
            .to_string(),
        )?,
        Format::Text => print_line(&format!(
            "{:<20} {:<9} {state:<8} until {until}  {}",
            member.name.as_str(),
            member.role.name(),
            member.common_name
        ))?,
    }
    Ok(())
}

/// A date, UTC.
fn date(seconds: u64) -> anyhow::Result<String> {
    let time = OffsetDateTime::from_unix_timestamp(i64::try_from(seconds)?)
        .context("a time of the distant future")?;
    Ok(format!(
        "{:04}-{:02}-{:02}",
        time.year(),
        u8::from(time.month()),
        time.day()
    ))
}

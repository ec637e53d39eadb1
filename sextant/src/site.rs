//! The way to a running site for commands that watch it: which site, through which router.

use crate::words;
use anyhow::{anyhow, bail};
use clap::Args;
use sextant_gateways::site::{OpenError, RouterWatch, SiteSession};
use sextant_process::{Exit, Failure, Shutdown, WithExit, now_ns};
use sextant_proto::{Keys, SiteId};
use sextant_zenoh_bus::{Bus, NO_SESSION, Role, Security};
use std::path::PathBuf;

/// Which site, and where its router is.
#[derive(Args, Debug, Clone)]
pub struct SiteArguments {
    /// Endpoint of the router of the site [default: tcp/127.0.0.1:7447].
    #[arg(long, env = "SEXTANT_CONNECT", value_name = "ENDPOINT")]
    connect: Option<String>,
    /// Name of the site, which is part of every key [default: demo].
    #[arg(long, env = "SEXTANT_SITE", value_name = "NAME")]
    site: Option<SiteId>,
    /// Keys of a protected site, as `sextant keys add` makes them for a viewer or an operator.
    #[arg(long, env = "SEXTANT_KEYS", value_name = "DIR/NAME")]
    keys: Option<PathBuf>,
    /// End as at Ctrl-C when standard input ends: for programs that run this one.
    #[arg(long, hide_short_help = true)]
    until_input_ends: bool,
}

/// The site of a node, as its file says it.
#[derive(Debug, Clone)]
pub struct SiteOfFile {
    /// Its name.
    pub site: SiteId,
    /// Endpoint of a router at which programs of this machine find it; none where the file names none.
    pub connect: Option<String>,
    /// The node's keys.
    pub keys: Option<PathBuf>,
}

/// Default endpoint of the router.
const USUAL_ROUTER: &str = "tcp/127.0.0.1:7447";
/// Default name of the site.
const USUAL_SITE: &str = "demo";

impl SiteArguments {
    /// Command line options of this site, with a leading space; empty for the defaults.
    pub fn as_typed(&self) -> String {
        let mut typed = String::new();
        if self.site().as_str() != USUAL_SITE {
            typed.push_str(&format!(" --site {}", self.site()));
        }
        if self.connect() != USUAL_ROUTER {
            typed.push_str(&format!(" --connect {}", self.connect()));
        }
        if let Some(keys) = &self.keys {
            typed.push_str(&format!(" --keys {}", keys.display()));
        }
        typed
    }

    /// Endpoint of the router.
    pub fn connect(&self) -> &str {
        self.connect.as_deref().unwrap_or(USUAL_ROUTER)
    }

    /// Name of the site.
    pub fn site(&self) -> SiteId {
        let usual = || USUAL_SITE.parse().ok();
        // The usual name is a name.
        (self.site.clone().or_else(usual)).unwrap_or_else(|| unreachable!())
    }

    /// What is not given is as a node's file says it.
    #[must_use]
    pub fn or_as_in_file(&self, file: &SiteOfFile) -> Self {
        let Self {
            connect,
            site,
            keys,
            until_input_ends,
        } = self.clone();
        Self {
            connect: connect.or_else(|| file.connect.clone()),
            site: site.or_else(|| Some(file.site.clone())),
            keys: keys.or_else(|| file.keys.clone()),
            until_input_ends,
        }
    }

    /// Whether the site is a protected one.
    pub fn has_keys(&self) -> bool {
        self.keys.is_some()
    }

    fn security(&self) -> anyhow::Result<Security> {
        let site = self.site();
        let security = Security::of_client(self.connect(), self.keys.as_deref(), site.as_str());
        let security = security.exit_with(Exit::Input)?;
        if let Some(words) = security.warning(now_ns() / 1_000_000_000) {
            eprintln!("warning: {words}");
        }
        Ok(security)
    }

    /// Connects; Ctrl-C is the request to stop.
    ///
    /// # Errors
    /// [`Exit::Unavailable`] when no router answers within three seconds, or the router has other sites and not this
    /// one.
    pub fn open(&self) -> anyhow::Result<SiteSession> {
        let site = self.open_any()?;
        let others = site.other_sites().exit_with(Exit::Unavailable)?;
        if others.is_empty() {
            return Ok(site);
        }
        let sites: Vec<String> = others.iter().map(|site| words::plain(site)).collect();
        let cause = anyhow!(
            "nothing runs on site {} at {}; this router has: {} (name a site with --site)",
            self.site(),
            self.connect(),
            sites.join(", ")
        );
        bail!(Failure::new(Exit::Unavailable, cause))
    }

    /// As [`Self::open`], also to a site of which nothing runs yet.
    ///
    /// # Errors
    /// [`Exit::Unavailable`] when no router answers within three seconds.
    pub fn open_any(&self) -> anyhow::Result<SiteSession> {
        let shutdown = Shutdown::install()?;
        if self.until_input_ends {
            shutdown.request_at_end_of_input();
        }
        let security = self.security()?;
        SiteSession::open(self.connect(), self.site(), &security, shutdown).map_err(|error| {
            let failure = match error {
                OpenError::Interrupted => Failure::new(Exit::Interrupted, error),
                OpenError::NoRouter {
                    endpoint,
                    cause: Some(cause),
                } if cause.contains(NO_SESSION) => {
                    let words = anyhow!("no session at {endpoint}: {NO_SESSION}");
                    Failure::new(Exit::Unavailable, words)
                }
                OpenError::NoRouter { endpoint, cause } => {
                    let cause = cause.map_or_else(String::new, |cause| format!(" ({cause})"));
                    let words = anyhow!(
                        "no router answers at {endpoint}; start a site (`sextant demo` or \
                         `sextant fusion`), or name its router with --connect and keys for it with --keys{cause}"
                    );
                    Failure::new(Exit::Unavailable, words)
                }
                OpenError::Bus(error) => Failure::new(Exit::Unavailable, error),
            };
            failure.into()
        })
    }
}

/// Reports once on standard error that the router is unreachable, and once that it is back.
pub fn report_router(watch: &mut RouterWatch, bus: &Bus) {
    if let Some(notice) = watch.notice(bus) {
        eprintln!("{notice}");
    }
}

/// Asks whether this program may change the site. The router asks the same, but refuses without a word.
///
/// # Errors
/// [`Exit::Input`] for keys of another role than operator.
pub fn check_may_change(site: &SiteSession) -> anyhow::Result<()> {
    match site.role {
        None | Some(Role::Operator | Role::Fusion) => Ok(()),
        Some(role) => {
            let cause = anyhow!(
                "keys of the role {role} may not change the site: name those of an operator with --keys"
            );
            bail!(Failure::new(Exit::Input, cause))
        }
    }
}

/// Key expression for an argument: a whole key, a key below the site (`camera/north/preview`, `config/**`), or the name
/// of a camera, object or node, which selects all of its keys.
pub fn expression(keys: &Keys, said: &str) -> String {
    let everything = keys.everything();
    let root = everything.trim_end_matches("/**");
    if said.starts_with("sextant/") {
        said.to_owned()
    } else if said.contains(['/', '*']) {
        format!("{root}/{said}")
    } else {
        format!("{root}/*/{said}/*")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_keys_are_understood() {
        let keys = Keys::new("lab").unwrap();
        for (said, meant) in [
            ("north", "sextant/v1/lab/*/north/*"),
            (
                "camera/north/preview",
                "sextant/v1/lab/camera/north/preview",
            ),
            ("**", "sextant/v1/lab/**"),
            ("sextant/v1/other/**", "sextant/v1/other/**"),
        ] {
            assert_eq!(expression(&keys, said), meant);
        }
    }
}

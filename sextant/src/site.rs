//! The way to a running site for commands that watch it: which site, through which router.

use anyhow::bail;
use clap::Args;
use sextant_process::{Exit, Failure, Shutdown, WithExit, now_ns};
use sextant_proto::{ANNOUNCED, KeyRef, Keys, SiteId, limits};
use sextant_site_mirror::{SiteMirror, Update};
use sextant_zenoh_bus::{Bus, BusError, BusOptions, Item, Presence, Role, Security, why_no_router};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// How long a router may take to answer.
const PATIENCE: Duration = Duration::from_secs(3);
/// Timeout of a query for last values.
const ANSWER: Duration = Duration::from_secs(1);
/// Most names in a sentence.
const MOST_NAMES: usize = 10;

/// Which site, and where its router is.
#[derive(Args, Debug)]
pub struct SiteArguments {
    /// Endpoint of the router of the site.
    #[arg(
        long,
        env = "SEXTANT_CONNECT",
        value_name = "ENDPOINT",
        default_value = USUAL_ROUTER
    )]
    connect: String,
    /// Name of the site, which is part of every key.
    #[arg(
        long,
        env = "SEXTANT_SITE",
        value_name = "NAME",
        default_value = USUAL_SITE
    )]
    site: SiteId,
    /// Keys of a protected site, as `sextant keys add` makes them for a viewer or an operator.
    #[arg(long, env = "SEXTANT_KEYS", value_name = "DIR/NAME")]
    keys: Option<PathBuf>,
}

/// A session on a site's network.
pub struct Site {
    /// The network.
    pub bus: Bus,
    /// The site's keys.
    pub keys: Keys,
    /// The wish to stop: Ctrl-C.
    pub shutdown: Shutdown,
    /// What the site lets this program do; none where nobody has a role.
    role: Option<Role>,
}

/// Default endpoint of the router.
const USUAL_ROUTER: &str = "tcp/127.0.0.1:7447";
/// Default name of the site.
const USUAL_SITE: &str = "demo";

impl SiteArguments {
    /// Command line options of this site, with a leading space; empty for the defaults.
    pub fn as_typed(&self) -> String {
        let mut typed = String::new();
        if self.site.to_string() != USUAL_SITE {
            typed.push_str(&format!(" --site {}", self.site));
        }
        if self.connect != USUAL_ROUTER {
            typed.push_str(&format!(" --connect {}", self.connect));
        }
        if let Some(keys) = &self.keys {
            typed.push_str(&format!(" --keys {}", keys.display()));
        }
        typed
    }

    /// Endpoint of the router.
    pub fn connect(&self) -> &str {
        &self.connect
    }

    /// Name of the site.
    pub fn site(&self) -> &SiteId {
        &self.site
    }

    fn security(&self) -> anyhow::Result<Security> {
        let security = Security::of_client(&self.connect, self.keys.as_deref(), self.site.as_str());
        let security = security.exit_with(Exit::Input)?;
        if let Some(words) = security.warning(now_ns() / 1_000_000_000) {
            eprintln!("warning: {words}");
        }
        Ok(security)
    }

    /// Connects.
    ///
    /// # Errors
    /// [`Exit::Unavailable`] when no router answers within three seconds.
    pub fn open(&self) -> anyhow::Result<Site> {
        let shutdown = Shutdown::install()?;
        let security = self.security()?;
        let deadline = Instant::now() + PATIENCE;
        let give_up = || shutdown.is_requested() || Instant::now() >= deadline;
        let options = BusOptions::client_of(&self.connect);
        let bus = match Bus::open_unless(&options, &security, &give_up) {
            Err(BusError::Abandoned { .. }) if shutdown.is_requested() => {
                bail!(Failure::new(
                    Exit::Interrupted,
                    anyhow::anyhow!("interrupted")
                ))
            }
            Err(BusError::Abandoned { .. }) => {
                let why = why_no_router(&options, &security);
                let cause = anyhow::anyhow!(
                    "no router answers at {}; start a site (`sextant demo` or `sextant fusion`), or name its router with --connect and keys for it with --keys{}",
                    self.connect,
                    why.map_or(String::new(), |why| format!(" ({why})"))
                );
                bail!(Failure::new(Exit::Unavailable, cause))
            }
            opened => opened.exit_with(Exit::Unavailable)?,
        };
        Ok(Site {
            bus,
            keys: Keys::of(self.site.clone()),
            shutdown,
            role: security.role(),
        })
    }
}

/// Notices when the router goes out of reach, and when it is back.
#[derive(Debug, Default)]
pub struct RouterWatch {
    lost: Option<Instant>,
    is_said: bool,
}

/// Time without a router before it is reported.
const HICCUP: Duration = Duration::from_secs(3);

impl RouterWatch {
    /// Seconds since the router is unreachable, if that is reported.
    pub fn silent_s(&mut self, bus: &Bus) -> Option<f64> {
        if bus.is_connected() {
            self.lost = None;
            return None;
        }
        let lost = *self.lost.get_or_insert_with(Instant::now);
        let silent = lost.elapsed();
        (silent >= HICCUP).then_some(silent.as_secs_f64())
    }

    /// Reports once on standard error that the router is unreachable, and once that it is back.
    pub fn say(&mut self, bus: &Bus) {
        match self.silent_s(bus) {
            Some(seconds) if !self.is_said => {
                eprintln!("the router has not answered for {seconds:.0} s; waiting for it");
                self.is_said = true;
            }
            None if self.is_said && self.lost.is_none() => {
                eprintln!("the router is back");
                self.is_said = false;
            }
            _ => {}
        }
    }
}

impl Site {
    /// Asks whether this program may change the site. The router asks the same, but refuses without a word.
    ///
    /// # Errors
    /// [`Exit::Input`] for keys of another role than operator.
    pub fn check_may_change(&self) -> anyhow::Result<()> {
        match self.role {
            None | Some(Role::Operator | Role::Fusion) => Ok(()),
            Some(role) => {
                let cause = anyhow::anyhow!(
                    "keys of the role {role} may not change the site: name those of an operator with --keys"
                );
                bail!(Failure::new(Exit::Input, cause))
            }
        }
    }

    /// The site as its nodes answer: their tokens, and their last messages under these keys. Waits for a second at most a key.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn mirror(&self, keys: &[String]) -> anyhow::Result<SiteMirror> {
        let mut mirror = SiteMirror::default();
        for token in self.bus.alive_keys(&self.keys.all_alive())? {
            take_token(&self.keys, &mut mirror, &Presence::Joined(token), now_ns());
        }
        for key in keys {
            let items = self.bus.latest(key, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
            for item in &items {
                take(&self.keys, &mut mirror, item, now_ns());
            }
        }
        Ok(mirror)
    }

    /// The objects that the site has, for a person who waits for messages of another one. Takes up to two seconds.
    pub fn objects_in_words(&self) -> String {
        let mirror = self.mirror(&[self.keys.all_config_objects()]);
        let mirror = mirror.unwrap_or_default();
        let names: Vec<String> = mirror
            .configs()
            .map(|object| object.id.to_string())
            .collect();
        match names.as_slice() {
            [] => "the site has no objects".to_owned(),
            [one] => format!("the site has the object {one}"),
            _ if names.len() > MOST_NAMES => {
                let further = names.len() - MOST_NAMES;
                let names = names[..MOST_NAMES].join(", ");
                format!("the site has the objects {names} and {further} more")
            }
            _ => format!("the site has the objects {}", names.join(", ")),
        }
    }

    /// Key expression for an argument: a whole key, a key below the site (`camera/north/preview`, `config/**`), or the name of a
    /// camera, object or node, which selects all of its keys.
    pub fn expression(&self, said: &str) -> String {
        expression(&self.keys, said)
    }
}

/// Hands a message that arrived at `now_ns` to a mirror of its site; returns what it brought. Refused ones change nothing: `echo` and the
/// statuses of the fusion nodes show them.
pub fn take(keys: &Keys, mirror: &mut SiteMirror, item: &Item, now_ns: u64) -> Option<Update> {
    let key = keys.parse(&item.key)?;
    let update = mirror.handle(now_ns, &key, item.sender.as_deref(), item.try_bytes());
    update.ok()
}

/// Hands a change of liveliness to a mirror of its site.
pub fn take_token(keys: &Keys, mirror: &mut SiteMirror, presence: &Presence, now_ns: u64) {
    let (Presence::Joined(key) | Presence::Left(key)) = presence;
    let Some(KeyRef::Alive(kind, id)) = keys.parse(key) else {
        return;
    };
    match presence {
        // Beyond the limit it is left out.
        Presence::Joined(_) => drop(mirror.handle_joined(now_ns, kind, &id)),
        Presence::Left(_) => mirror.handle_left(now_ns, kind, &id),
    }
}

/// A wish to change a model, as opposed to what a fusion node announces to be in force.
pub fn is_request(keys: &Keys, item: &Item) -> bool {
    let is_config = matches!(
        keys.parse(&item.key),
        Some(KeyRef::ConfigRig | KeyRef::ConfigObject(_) | KeyRef::ConfigCamera(_))
    );
    let sender = item.sender.as_deref().unwrap_or_default();
    is_config && !sender.starts_with(ANNOUNCED)
}

fn expression(keys: &Keys, said: &str) -> String {
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

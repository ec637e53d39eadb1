//! `sextant router`: the site's router in a process of its own, for sites with more than one fusion node.

use crate::output::print_line;
use anyhow::{Context, bail};
use clap::{ArgGroup, Args};
use serde::Deserialize;
use sextant_process::{Exit, Shutdown, WithExit, logging, now_ns, watchdog};
use sextant_proto::{NodeId, SiteId};
use sextant_site_files::read_toml;
use sextant_zenoh_bus::{
    Bus, BusError, BusOptions, Identity, Mode, Profile, Role, Security, SecurityOptions,
};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How often the watchdog is fed.
const PERIOD: Duration = Duration::from_millis(500);

/// Arguments of `sextant router`.
#[derive(Args, Debug)]
#[command(
    group = ArgGroup::new("network").args(["config", "listen"]).required(true),
    after_help = "The file: site = \"lab\", node = \"router\", and the sections [network] \
        (listen, connect, ...) and [security] of every node's file; \
docs/several-hosts.md. Two routers name each other in connect; the other nodes name both, and go on when one dies."
)]
pub struct RouterArguments {
    /// The router's configuration.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// In place of a file, on this machine only: an endpoint to listen on. May be repeated.
    #[arg(long, value_name = "ENDPOINT")]
    listen: Vec<String>,
    /// In place of a file: another router. May be repeated.
    #[arg(long, value_name = "ENDPOINT", conflicts_with = "config")]
    connect: Vec<String>,
    /// Print the equivalent configuration of zenohd, which then is the router in place of this program, and end.
    #[arg(long)]
    zenohd: bool,
}

/// The settings of a router: contents of `router.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RouterConfig {
    site: SiteId,
    node: NodeId,
    /// Where it listens, and which routers it connects to.
    pub network: BusOptions,
    /// Who may connect.
    #[serde(default)]
    pub security: SecurityOptions,
}

/// Runs a router until a signal.
///
/// # Errors
/// [`Exit::Input`] for a wrong file, [`Exit::Unavailable`] for a port that is taken.
pub fn run(arguments: &RouterArguments) -> anyhow::Result<()> {
    logging::init("router");
    let (network, security) = arguments.read().exit_with(Exit::Input)?;
    if arguments.zenohd {
        let text = network.zenohd_config(&security).exit_with(Exit::Input)?;
        return Ok(print_line(&text)?);
    }
    if let Some(words) = security.warning(now_ns() / 1_000_000_000) {
        tracing::warn!("{words}");
    }
    let shutdown = Shutdown::install()?;
    let stop = || shutdown.is_requested();
    let bus = match Bus::open_unless(&network, &security, &stop) {
        Err(BusError::Abandoned { .. }) => return Ok(()),
        opened => opened.exit_with(Exit::Unavailable)?,
    };
    tracing::info!(endpoints = ?bus.endpoints(), "routing");
    while !shutdown.wait(PERIOD) {
        watchdog::feed();
    }
    bus.close();
    Ok(())
}

impl RouterArguments {
    fn read(&self) -> anyhow::Result<(BusOptions, Security)> {
        match &self.config {
            Some(file) => read(file).map(|(_, network, security)| (network, security)),
            None => {
                let network = BusOptions {
                    mode: Mode::Router,
                    listen: self.listen.clone(),
                    connect: Some(self.connect.clone()),
                    ..BusOptions::default()
                };
                Ok((network, Security::none(Profile::Demo)))
            }
        }
    }
}

/// Reads a router's file and its keys.
///
/// # Errors
/// What is wrong with either.
pub fn read(file: &Path) -> anyhow::Result<(NodeId, BusOptions, Security)> {
    let config: RouterConfig = read_toml(file)?;
    let network = BusOptions {
        mode: Mode::Router,
        ..config.network
    };
    if network.listen.is_empty() {
        bail!(
            "{}: [network] listen: a router needs an endpoint to listen on, such as \"quic/0.0.0.0:7447\"",
            file.display()
        );
    }
    let identity = Identity {
        site: config.site.as_str(),
        name: config.node.as_str(),
        roles: &[Role::Router, Role::Fusion],
    };
    let folder = file.parent().unwrap_or(Path::new(""));
    let security = config.security.load(folder, identity, &network);
    let security = security.with_context(|| file.display().to_string())?;
    Ok((config.node, network, security))
}

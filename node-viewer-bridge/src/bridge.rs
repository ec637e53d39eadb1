//! The process: bind first (a taken port is said at once), then network and server side by side until asked to stop.

use crate::config::ViewerConfig;
use crate::network;
use crate::protection::Protection;
use crate::server;
use crate::shared::Shared;
use crate::wizard;
use anyhow::{Context, anyhow};
use sextant_process::{Exit, Shutdown, WithExit, memory, now_ns};
use sextant_site_files::read_toml;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::sync::Arc;

/// Runs a viewer bridge until `shutdown`.
///
/// # Errors
/// [`Exit::Input`] for a wrong file, [`Exit::Unavailable`] when the address or the network can't be had.
pub fn run(config_file: &Path, shutdown: &Shutdown) -> anyhow::Result<()> {
    memory::keep_heap_small();
    let config: ViewerConfig = read_toml(config_file).exit_with(Exit::Input)?;
    let folder = config_file.parent().unwrap_or(Path::new(""));
    let protection = Protection::load(&config, folder)
        .with_context(|| config_file.display().to_string())
        .exit_with(Exit::Input)?;
    if let Some(words) = protection.network.warning(now_ns() / 1_000_000_000) {
        tracing::warn!("{words}");
    }
    let listener = listen(config.listen).exit_with(Exit::Unavailable)?;
    let address = listener.local_addr().context("the address listened on")?;
    let scheme = if protection.tls.is_some() {
        "https"
    } else {
        "http"
    };
    tracing::info!("the page: {scheme}://{}/", for_browsers(address));
    let shared = Shared::new(config, config_file, address, protection).exit_with(Exit::Input)?;
    let shared = Arc::new(shared);
    serve_both(&shared, listener, shutdown)
}

/// Whichever part ends first, be it by a fault, takes the other with it.
fn serve_both(
    shared: &Arc<Shared>,
    listener: TcpListener,
    shutdown: &Shutdown,
) -> anyhow::Result<()> {
    std::thread::scope(|scope| {
        let network = std::thread::Builder::new()
            .name("network".into())
            .spawn_scoped(scope, || {
                let result = network::run(shared, shutdown);
                shutdown.request();
                result
            })?;
        let own = Arc::clone(shared);
        std::thread::Builder::new()
            .name("wizard".into())
            .spawn_scoped(scope, move || wizard::run(&own.wizard, &own.hub, shutdown))?;
        let served = server::run(shared, listener, shutdown);
        shutdown.request();
        let connected = network
            .join()
            .unwrap_or_else(|_| Err(anyhow!("the network thread panicked")));
        served.and(connected)
    })
}

fn listen(address: SocketAddr) -> anyhow::Result<TcpListener> {
    let listener = TcpListener::bind(address)
        .map_err(|cause| anyhow!("cannot listen on {address}: {}", remedy(&cause, address)))?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

fn remedy(cause: &std::io::Error, address: SocketAddr) -> String {
    let port = address.port();
    match cause.kind() {
        ErrorKind::AddrInUse => format!(
            "the port is in use; choose another `listen` in viewer.toml, or end the program that \
             holds it (`ss -ltnp 'sport = :{port}'` names it)"
        ),
        ErrorKind::AddrNotAvailable => {
            "this machine has no such address; `ip address` lists those it has".to_owned()
        }
        ErrorKind::PermissionDenied => {
            format!("port {port} is reserved for the superuser; choose one from 1024 on")
        }
        _ => cause.to_string(),
    }
}

/// The address as a browser on this machine would write it.
fn for_browsers(address: SocketAddr) -> SocketAddr {
    let mut shown = address;
    if address.ip().is_unspecified() {
        shown.set_ip(std::net::Ipv4Addr::LOCALHOST.into());
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_taken_port_is_said_with_a_remedy() {
        let holder = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = holder.local_addr().unwrap();
        let error = listen(address).unwrap_err().to_string();
        assert!(error.contains("in use") && error.contains("viewer.toml"));
    }
}

//! Value of `--listen`: addresses that servers of other programs' protocols listen at.

use crate::site::SiteArguments;
use anyhow::{Context, anyhow, bail};
use sextant_gateways::listening::{self, ListenError};
use sextant_process::{Exit, Failure, WithExit};
use std::net::{SocketAddr, TcpListener, UdpSocket};

/// Listens at `HOST:PORT`, or at `HOST` and this port; a warning where other machines reach it, as these protocols have
/// no passwords.
///
/// # Errors
/// [`Exit::Usage`] for an invalid address, [`Exit::Unavailable`] for one that is in use.
pub fn listen(address: &str, port: u16) -> anyhow::Result<TcpListener> {
    let listener = opened(address, listening::listen(address, port))?;
    warn_unless_loopback(address, listener.local_addr()?);
    Ok(listener)
}

/// As [`listen`] for a protocol by which a protected site is read at this machine only.
///
/// # Errors
/// As [`listen`]; [`Exit::Usage`] where other machines would read a protected site.
pub fn listen_unprotected(
    address: &str,
    port: u16,
    protocol: &str,
    site: &SiteArguments,
) -> anyhow::Result<TcpListener> {
    let listener = opened(address, listening::listen(address, port))?;
    check_protection(address, listener.local_addr()?, protocol, site)?;
    Ok(listener)
}

/// As [`listen_unprotected`], by UDP.
///
/// # Errors
/// As [`listen_unprotected`].
pub fn bind_unprotected(
    address: &str,
    port: u16,
    protocol: &str,
    site: &SiteArguments,
) -> anyhow::Result<UdpSocket> {
    let socket = opened(address, listening::bind(address, port))?;
    check_protection(address, socket.local_addr()?, protocol, site)?;
    Ok(socket)
}

fn check_protection(
    address: &str,
    bound: SocketAddr,
    protocol: &str,
    site: &SiteArguments,
) -> anyhow::Result<()> {
    if site.has_keys() && !bound.ip().is_loopback() {
        let port = bound.port();
        let cause = anyhow!(
            "--listen {address}: {protocol} has no passwords, so that every client that can \
             connect would read this protected site; listen at 127.0.0.1:{port}"
        );
        bail!(Failure::new(Exit::Usage, cause));
    }
    warn_unless_loopback(address, bound);
    Ok(())
}

fn opened<T>(address: &str, result: Result<T, ListenError>) -> anyhow::Result<T> {
    result.or_else(|error| {
        let exit = match &error {
            ListenError::Address { .. } => Exit::Usage,
            ListenError::Unavailable(_) => Exit::Unavailable,
            ListenError::Socket(_) => Exit::Fault,
        };
        Err(error)
            .with_context(|| format!("--listen {address}"))
            .exit_with(exit)
    })
}

fn warn_unless_loopback(address: &str, bound: SocketAddr) {
    if !bound.ip().is_loopback() {
        eprintln!(
            "warning: --listen {address}: every client that can connect reads the site without a \
             password; 127.0.0.1 keeps it to this machine"
        );
    }
}

//! Value of `--listen`: addresses that servers of other programs' protocols listen at.

use anyhow::Context;
use sextant_gateways::listening::{self, ListenError};
use sextant_process::{Exit, WithExit};
use std::net::{SocketAddr, TcpListener, UdpSocket};

/// Listens at `HOST:PORT`, or at `HOST` and this port; a warning where other machines reach it, as these protocols have no passwords.
///
/// # Errors
/// [`Exit::Usage`] for what is no address, [`Exit::Unavailable`] for one that is in use.
pub fn listen(address: &str, port: u16) -> anyhow::Result<TcpListener> {
    let listener = opened(address, listening::listen(address, port))?;
    warn_unless_loopback(address, listener.local_addr()?);
    Ok(listener)
}

/// As [`listen`], by UDP.
///
/// # Errors
/// As [`listen`].
pub fn bind(address: &str, port: u16) -> anyhow::Result<UdpSocket> {
    let socket = opened(address, listening::bind(address, port))?;
    warn_unless_loopback(address, socket.local_addr()?);
    Ok(socket)
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
            "warning: --listen {address}: whoever reaches it reads the site without a password; 127.0.0.1 keeps it to this machine"
        );
    }
}

//! Value of `--listen`: addresses that servers of other programs' protocols listen at.

use anyhow::Context;
use sextant_gateways::listening::{self, ListenError};
use sextant_process::{Exit, WithExit};
use std::net::TcpListener;

/// Listens at `HOST:PORT`, or at `HOST` and this port; a warning where other machines reach it, as these protocols have no passwords.
///
/// # Errors
/// [`Exit::Usage`] for what is no address, [`Exit::Unavailable`] for one that is in use.
pub fn listen(address: &str, port: u16) -> anyhow::Result<TcpListener> {
    let listener = listening::listen(address, port).or_else(|error| {
        let exit = match &error {
            ListenError::Address { .. } => Exit::Usage,
            ListenError::Unavailable(_) => Exit::Unavailable,
            ListenError::Socket(_) => Exit::Fault,
        };
        Err(error)
            .with_context(|| format!("--listen {address}"))
            .exit_with(exit)
    })?;
    if !listener.local_addr()?.ip().is_loopback() {
        eprintln!(
            "warning: --listen {address}: whoever reaches it reads the site without a password; 127.0.0.1 keeps it to this machine"
        );
    }
    Ok(listener)
}

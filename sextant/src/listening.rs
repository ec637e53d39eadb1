//! Addresses that servers of other programs' protocols listen at.

use anyhow::{Context, anyhow};
use sextant_process::{Exit, Failure, WithExit};
use std::net::{IpAddr, SocketAddr, TcpListener, ToSocketAddrs};

/// Listens at `HOST:PORT`, or at `HOST` and this port; a warning where other machines reach it, as these protocols have no passwords.
/// The listener does not block.
///
/// # Errors
/// [`Exit::Usage`] for what is no address, [`Exit::Unavailable`] for one that is in use.
pub fn listen(address: &str, port: u16) -> anyhow::Result<TcpListener> {
    let addresses = resolved(address, port)?;
    let listener = TcpListener::bind(&addresses[..])
        .with_context(|| {
            format!("--listen {address}: cannot listen there; name another address or port")
        })
        .exit_with(Exit::Unavailable)?;
    listener.set_nonblocking(true)?;
    if !listener.local_addr()?.ip().is_loopback() {
        eprintln!(
            "warning: --listen {address}: whoever reaches it reads the site without a password; 127.0.0.1 keeps it to this machine"
        );
    }
    Ok(listener)
}

fn resolved(address: &str, port: u16) -> anyhow::Result<Vec<SocketAddr>> {
    let with_port = match address.parse::<IpAddr>() {
        Ok(ip) => SocketAddr::new(ip, port).to_string(),
        Err(_) if address.contains(':') => address.to_owned(),
        Err(_) => format!("{address}:{port}"),
    };
    let addresses = with_port.to_socket_addrs().map_err(|cause| {
        let cause =
            anyhow!("--listen {address}: {cause}; write HOST:PORT, such as 127.0.0.1:{port}");
        Failure::new(Exit::Usage, cause)
    })?;
    Ok(addresses.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_without_a_port_has_the_usual_one() {
        for (text, whole) in [
            ("127.0.0.1", "127.0.0.1:3883"),
            ("::1", "[::1]:3883"),
            ("0.0.0.0:70", "0.0.0.0:70"),
        ] {
            let addresses = resolved(text, 3883).expect("an address");
            assert_eq!(addresses, [whole.parse().expect("an address")]);
        }
        assert!(resolved("127.0.0.1:port", 3883).is_err());
    }
}

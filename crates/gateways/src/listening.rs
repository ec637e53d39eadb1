//! Addresses that servers of other programs' protocols listen at.

use std::io;
use std::net::{IpAddr, SocketAddr, TcpListener, ToSocketAddrs, UdpSocket};

/// Why a server cannot listen.
#[derive(Debug, thiserror::Error)]
pub enum ListenError {
    /// What is no address.
    #[error("{cause}; write HOST:PORT, such as 127.0.0.1:{port}")]
    Address {
        /// The system's reason.
        cause: io::Error,
        /// The usual port.
        port: u16,
    },
    /// The address is in use or of another machine.
    #[error("cannot listen there; name another address or port")]
    Unavailable(#[source] io::Error),
    /// The system refuses to make the listener one that does not block.
    #[error("no socket")]
    Socket(#[source] io::Error),
}

/// Listens at `HOST:PORT`, or at `HOST` and this port. The listener does not block.
///
/// # Errors
/// See [`ListenError`].
pub fn listen(address: &str, port: u16) -> Result<TcpListener, ListenError> {
    let addresses = resolved(address, port)?;
    let listener = TcpListener::bind(&addresses[..]).map_err(ListenError::Unavailable)?;
    listener
        .set_nonblocking(true)
        .map_err(ListenError::Socket)?;
    Ok(listener)
}

/// A UDP socket at `HOST:PORT`, or at `HOST` and this port.
///
/// # Errors
/// See [`ListenError`].
pub fn bind(address: &str, port: u16) -> Result<UdpSocket, ListenError> {
    let addresses = resolved(address, port)?;
    UdpSocket::bind(&addresses[..]).map_err(ListenError::Unavailable)
}

fn resolved(address: &str, port: u16) -> Result<Vec<SocketAddr>, ListenError> {
    let with_port = match address.parse::<IpAddr>() {
        Ok(ip) => SocketAddr::new(ip, port).to_string(),
        Err(_) if address.contains(':') => address.to_owned(),
        Err(_) => format!("{address}:{port}"),
    };
    let addresses = with_port.to_socket_addrs();
    let addresses = addresses.map_err(|cause| ListenError::Address { cause, port })?;
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

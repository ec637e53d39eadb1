//! UDP to one machine, and the counts that its senders end with.

use crate::pose_feed::FeedCounts;
use crate::report::{Notice, Reporter};
use serde::Serialize;
use std::io::{self, ErrorKind};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, SocketAddrV4, ToSocketAddrs, UdpSocket};
use std::time::Duration;

/// Longest wait for room in the system's buffer.
const LONGEST_SEND: Duration = Duration::from_millis(1);

/// One machine's port, and what was sent there.
#[derive(Debug)]
pub struct DatagramTarget {
    socket: UdpSocket,
    address: SocketAddr,
    counts: DatagramCounts,
    reporter: Reporter,
}

/// Why datagrams cannot be sent to a target.
#[derive(Debug, thiserror::Error)]
pub enum TargetError {
    /// What is no address of one machine.
    #[error("{0}")]
    Address(&'static str),
    /// A name without an address.
    #[error("{cause}")]
    Host {
        /// What is wrong with the name.
        cause: &'static str,
        /// The system's reason, if it gives one.
        source: Option<io::Error>,
    },
    /// No way to the machine.
    #[error("{0}; look at this machine's network")]
    Unreachable(io::Error),
    /// The system gives no socket.
    #[error("no UDP socket")]
    Socket(#[source] io::Error),
}

/// Datagrams since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct DatagramCounts {
    /// Handed to the network.
    pub sent: u64,
    /// Not sent because the network did not take them.
    pub unsent: u64,
    /// Number of answers that the port is closed.
    pub unheard: u64,
}

impl DatagramTarget {
    /// Resolves `HOST:PORT`.
    ///
    /// # Errors
    /// See [`TargetError`].
    pub fn open(target: &str, reporter: Reporter) -> Result<Self, TargetError> {
        if target
            .rsplit_once(':')
            .is_none_or(|(_, port)| port.parse::<u16>().is_err())
        {
            return Err(TargetError::Address(
                "write HOST:PORT, such as 192.168.1.20:9000",
            ));
        }
        let unknown = |source| TargetError::Host {
            cause: "no such host",
            source: Some(source),
        };
        let mut addresses = target.to_socket_addrs().map_err(unknown)?;
        let address = addresses.next().ok_or(TargetError::Host {
            cause: "the host has no address",
            source: None,
        })?;
        if let Some(cause) = not_one_machine(address) {
            return Err(TargetError::Address(cause));
        }
        let any: IpAddr = match address {
            SocketAddr::V4(_) => Ipv4Addr::UNSPECIFIED.into(),
            SocketAddr::V6(_) => Ipv6Addr::UNSPECIFIED.into(),
        };
        let socket = UdpSocket::bind((any, 0)).map_err(TargetError::Socket)?;
        socket
            .connect(address)
            .map_err(|cause| match cause.kind() {
                // A network's own broadcast address, which only the system knows.
                ErrorKind::PermissionDenied => TargetError::Address(BROADCAST),
                _ => TargetError::Unreachable(cause),
            })?;
        socket
            .set_write_timeout(Some(LONGEST_SEND))
            .map_err(TargetError::Socket)?;
        Ok(Self {
            socket,
            address,
            counts: DatagramCounts::default(),
            reporter,
        })
    }

    /// A multicast group, on the network of this machine's address `interface`.
    ///
    /// # Errors
    /// See [`TargetError`].
    pub fn group(
        group: SocketAddrV4,
        interface: Ipv4Addr,
        reporter: Reporter,
    ) -> Result<Self, TargetError> {
        let unavailable = |cause: io::Error| match cause.kind() {
            ErrorKind::AddrNotAvailable => {
                TargetError::Address("this machine has no such address; `ip address` lists them")
            }
            _ => TargetError::Socket(cause),
        };
        let socket = UdpSocket::bind((interface, 0)).map_err(unavailable)?;
        socket.connect(group).map_err(TargetError::Unreachable)?;
        socket
            .set_write_timeout(Some(LONGEST_SEND))
            .map_err(TargetError::Socket)?;
        Ok(Self {
            socket,
            address: group.into(),
            counts: DatagramCounts::default(),
            reporter,
        })
    }

    /// The same socket, for what the machine sends back.
    ///
    /// # Errors
    /// The system gives no handle.
    pub fn receiver(&self) -> io::Result<UdpSocket> {
        self.socket.try_clone()
    }

    /// Sends a datagram, or counts that it was not sent. Waits for a millisecond at most.
    pub fn send(&mut self, datagram: &[u8]) {
        let mut result = self.socket.send(datagram);
        if result
            .as_ref()
            .is_err_and(|e| e.kind() == ErrorKind::ConnectionRefused)
        {
            // The answer to an earlier datagram; this one was not sent.
            if self.counts.unheard == 0 {
                self.reporter.report(&Notice::NobodyListens(self.address));
            }
            self.counts.unheard += 1;
            result = self.socket.send(datagram);
        }
        match result {
            Ok(_) => self.counts.sent += 1,
            Err(cause) => {
                if self.counts.unsent == 0 {
                    self.reporter.report(&Notice::Unsent {
                        address: self.address,
                        cause: cause.to_string(),
                    });
                }
                self.counts.unsent += 1;
            }
        }
    }

    /// Address that datagrams are sent to.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Numbers of datagrams, sent and not.
    pub fn counts(&self) -> DatagramCounts {
        self.counts
    }
}

/// Counts of a gateway that sends poses as datagrams.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct SenderCounts {
    /// Poses of the site.
    #[serde(flatten)]
    pub feed: FeedCounts,
    /// Datagrams made of them.
    #[serde(flatten)]
    pub datagrams: DatagramCounts,
    /// Poses held back by the rate limit.
    pub skipped: u64,
}

const BROADCAST: &str =
    "this is a broadcast address, which would reach every machine of the network; name one machine";

fn not_one_machine(address: SocketAddr) -> Option<&'static str> {
    match address.ip().to_canonical() {
        _ if address.port() == 0 => Some("port 0 is invalid"),
        IpAddr::V4(ip) if ip.is_broadcast() => Some(BROADCAST),
        ip if ip.is_multicast() => {
            Some("this is a multicast address, which could reach many machines; name one machine")
        }
        ip if ip.is_unspecified() => {
            Some("this is the address of no machine; 127.0.0.1 is this one")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn silent() -> Reporter {
        Reporter::new(|_| {})
    }

    #[test]
    fn only_one_machine_is_a_target() {
        for (target, cause) in [
            ("224.0.0.1:9000", "multicast"),
            ("[ff02::1]:9000", "multicast"),
            ("255.255.255.255:9000", "broadcast"),
            ("127.255.255.255:9000", "broadcast"),
            ("0.0.0.0:9000", "no machine"),
            ("127.0.0.1:0", "port 0"),
            ("127.0.0.1", "HOST:PORT"),
            ("127.0.0.1:70000", "HOST:PORT"),
        ] {
            let error = DatagramTarget::open(target, silent())
                .unwrap_err()
                .to_string();
            assert!(error.contains(cause), "{target}: {error}");
        }
        assert!(DatagramTarget::open("127.0.0.1:9000", silent()).is_ok());
    }

    #[test]
    fn a_port_without_a_listener_is_counted_and_sending_goes_on() {
        let listener = UdpSocket::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        drop(listener);
        let mut target = DatagramTarget::open(&address.to_string(), silent()).unwrap();
        while target.counts().unheard == 0 {
            target.send(b"x");
        }
        let listener = UdpSocket::bind(address).unwrap();
        target.send(b"heard");
        let mut datagram = [0; 8];
        let length = listener.recv(&mut datagram).unwrap();
        assert_eq!(&datagram[..length], b"heard");
        assert_eq!(target.counts().unsent, 0);
    }
}

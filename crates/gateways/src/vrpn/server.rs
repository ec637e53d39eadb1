//! The sockets of a VRPN server: TCP for messages, UDP for clients that ask to be connected to. One thread, which never
//! waits for a client.

use super::dialler::Dialler;
use crate::report::{Notice, Reporter};
use serde::Serialize;
use sextant_pose_streams::{TrackerReport, VrpnConnection, VrpnTrackers, requested_port};
use sextant_process::now_ns;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::time::{Duration, Instant};

const MAX_CLIENTS: usize = 64;
/// Bytes that wait for a client beyond those in the system's queue; a client that is behind by more is closed.
const MAX_WAITING_BYTES: usize = 256 << 10;
/// Time until a client must have sent its cookie.
const GREETING: Duration = Duration::from_secs(5);
/// Between two looks at the sockets.
const PERIOD: Duration = Duration::from_millis(5);
/// Connections and datagrams taken at a look, so that a flood of them does not hold up poses.
const MOST_AT_ONCE: usize = 16;

/// The server and its clients.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    requests: UdpSocket,
    dialler: Dialler,
    clients: Vec<Client>,
    counts: ServerCounts,
    reporter: Reporter,
    due: Instant,
}

/// Why a server cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The UDP port of the same number is in use.
    #[error("the UDP port is in use; name another one")]
    UdpPort(#[source] io::Error),
    /// The system refuses a socket's settings or a thread.
    #[error(transparent)]
    System(#[from] io::Error),
}

/// Counts of clients and messages since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct ServerCounts {
    /// Reports handed to the network, one for each client.
    pub sent: u64,
    /// Clients that have shown their cookie.
    pub clients: u64,
    /// Clients closed because they did not read.
    pub slow: u64,
    /// Connections that were no client's, or one too many.
    pub turned_away: u64,
}

#[derive(Debug)]
struct Client {
    stream: TcpStream,
    peer: SocketAddr,
    connection: VrpnConnection,
    waiting: Vec<u8>,
    since: Instant,
}

/// Why a client's connection ends.
enum End {
    /// It has closed it.
    Closed,
    Slow,
    /// It is no client of VRPN.
    Wrong(String),
}

impl Server {
    /// Serves at the address of a listener that does not block, by TCP and UDP.
    pub fn start(listener: TcpListener, reporter: Reporter) -> Result<Self, StartError> {
        let requests = UdpSocket::bind(listener.local_addr()?).map_err(StartError::UdpPort)?;
        requests.set_nonblocking(true)?;
        Ok(Self {
            listener,
            requests,
            dialler: Dialler::start()?,
            clients: Vec::new(),
            counts: ServerCounts::default(),
            reporter,
            due: Instant::now(),
        })
    }

    /// Address that the server listens on.
    pub fn address(&self) -> SocketAddr {
        // A bound socket has an address.
        self.listener
            .local_addr()
            .unwrap_or(SocketAddr::from(([0; 4], 0)))
    }

    /// Counts of clients and messages since the start.
    pub fn counts(&self) -> ServerCounts {
        self.counts
    }

    /// Sends a report to all clients.
    pub fn send(&mut self, report: &TrackerReport) {
        let (counts, reporter) = (&mut self.counts, &self.reporter);
        self.clients.retain_mut(|client| {
            if !client.connection.is_open() {
                return true;
            }
            client.waiting.extend(report.description.iter().flatten());
            client.waiting.extend(&report.pose);
            counts.sent += 1;
            counts.keeps(client.peer, client.flush(), reporter)
        });
    }

    /// Looks after connections, if it is time.
    pub fn turn(&mut self, trackers: &VrpnTrackers, now: Instant) {
        if now < self.due {
            return;
        }
        self.due = now + PERIOD;
        self.take_requests();
        self.take_connections(now);
        let (counts, reporter) = (&mut self.counts, &self.reporter);
        self.clients.retain_mut(|client| {
            let was_open = client.connection.is_open();
            let result = client.turn(trackers, now);
            counts.clients += u64::from(!was_open && client.connection.is_open());
            counts.keeps(client.peer, result, reporter)
        });
    }

    /// Clients that want to be connected to. Only their own address counts: the one in the datagram could be anybody's.
    fn take_requests(&mut self) {
        let mut datagram = [0; 256];
        for _ in 0..MOST_AT_ONCE {
            let Ok((length, from)) = self.requests.recv_from(&mut datagram) else {
                return;
            };
            if let Some(port) = requested_port(&datagram[..length]) {
                let address = SocketAddr::new(from.ip(), port);
                if !self.clients.iter().any(|client| client.peer == address) {
                    self.dialler.dial(address);
                }
            }
        }
    }

    fn take_connections(&mut self, now: Instant) {
        for _ in 0..MOST_AT_ONCE {
            let dialled = self.dialler.connected();
            let stream = dialled.or_else(|| Some(self.listener.accept().ok()?.0));
            let Some(stream) = stream else { return };
            if self.clients.len() >= MAX_CLIENTS {
                let notice = Notice::TooManyClients { most: MAX_CLIENTS };
                self.counts.turn_away(&notice, &self.reporter);
            } else if let Ok(client) = Client::new(stream, now) {
                self.clients.push(client);
            }
        }
    }
}

impl ServerCounts {
    /// Whether a client stays.
    fn keeps(&mut self, peer: SocketAddr, result: Result<(), End>, reporter: &Reporter) -> bool {
        match result {
            Ok(()) => return true,
            Err(End::Closed) => {}
            Err(End::Slow) => {
                if self.slow == 0 {
                    reporter.report(&Notice::Disconnected(peer));
                }
                self.slow += 1;
            }
            Err(End::Wrong(cause)) => {
                self.turn_away(&Notice::TurnedAway { peer, cause }, reporter);
            }
        }
        false
    }

    /// Counts a connection that is turned away; the first few are reported.
    fn turn_away(&mut self, notice: &Notice, reporter: &Reporter) {
        const REPORTED: u64 = 10;
        if self.turned_away < REPORTED {
            reporter.report(notice);
        }
        self.turned_away += 1;
    }
}

impl Client {
    fn new(stream: TcpStream, since: Instant) -> io::Result<Self> {
        stream.set_nonblocking(true)?;
        stream.set_nodelay(true)?;
        Ok(Self {
            peer: stream.peer_addr()?,
            stream,
            connection: VrpnConnection::default(),
            waiting: VrpnTrackers::cookie().to_vec(),
            since,
        })
    }

    fn turn(&mut self, trackers: &VrpnTrackers, now: Instant) -> Result<(), End> {
        let mut buffer = [0; 64 << 10];
        match self.stream.read(&mut buffer) {
            Ok(0) => return Err(End::Closed),
            Ok(length) => {
                let answer = self.connection.take(&buffer[..length], trackers, now_ns());
                let answer = answer.map_err(|cause| End::Wrong(cause.to_string()))?;
                self.waiting.extend(answer);
            }
            Err(cause) if is_later(&cause) => {}
            Err(_) => return Err(End::Closed),
        }
        if !self.connection.is_open() && now.saturating_duration_since(self.since) > GREETING {
            return Err(End::Wrong("it has not greeted within 5 s".to_owned()));
        }
        self.flush()
    }

    /// Writes what the network takes.
    fn flush(&mut self) -> Result<(), End> {
        while !self.waiting.is_empty() {
            match self.stream.write(&self.waiting) {
                Ok(0) => return Err(End::Closed),
                Ok(written) => drop(self.waiting.drain(..written)),
                Err(cause) if is_later(&cause) => break,
                Err(_) => return Err(End::Closed),
            }
        }
        if self.waiting.len() > MAX_WAITING_BYTES {
            return Err(End::Slow);
        }
        Ok(())
    }
}

fn is_later(cause: &io::Error) -> bool {
    matches!(cause.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

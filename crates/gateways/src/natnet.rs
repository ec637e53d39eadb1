//! Each object as a rigid body of a NatNet server: frames to a multicast group and to every client that asks for them
//! at its own address.
//!
//! One socket for commands and frames. A thread answers commands at once, and sends the poses of one instant in one
//! frame: when there is a new one of every tracked object, or shortly after the first.

use crate::pose_feed::{FeedCounts, GATHER, Gathering, Next, PoseReceiver};
use crate::relay;
use crate::report::{Notice, Reporter};
use serde::Serialize;
use sextant_pose_streams::{
    NatNetBodies, NatNetRequest, NatNetServer, NatNetVersion, natnet_bitstream, natnet_echo,
};
use sextant_process::now_ns;
use sextant_proto::ObjectPose;
use sextant_site_model::{ObjectId, ObjectModel};
use sextant_zenoh_bus::BusError;
use std::io;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

const MAX_CLIENTS: usize = 64;
/// A client without a sign of life for this long gets no frames any more; those in use send one every two seconds or
/// more often.
const SILENCE: Duration = Duration::from_secs(10);
/// Longest wait for room in the system's buffer.
const LONGEST_SEND: Duration = Duration::from_millis(1);
/// Longest datagram that is read: a greeting has 275 bytes.
const MOST_BYTES: usize = 1024;

/// A NatNet server whose rigid bodies are the objects.
#[derive(Debug)]
pub struct BodyServer {
    shared: Arc<Mutex<Shared>>,
    /// Ends the thread.
    stop: Arc<AtomicBool>,
}

/// Counts of frames, datagrams and clients since the start.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct BodyCounts {
    /// Frames made.
    pub frames: u64,
    /// Datagrams handed to the network, answers included.
    pub sent: u64,
    /// Datagrams that the network did not take.
    pub unsent: u64,
    /// Clients that asked for frames at their own address.
    pub clients: u64,
    /// Clients beyond the limit.
    pub turned_away: u64,
    /// Datagrams that are no message, and requests that are not recognised.
    pub unrecognized: u64,
}

/// Counts of a server.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct BodyServerCounts {
    /// Poses of the site.
    #[serde(flatten)]
    pub feed: FeedCounts,
    /// Frames made of them, and their clients.
    #[serde(flatten)]
    pub server: BodyCounts,
}

/// Which objects a NatNet server serves, and by which version.
#[derive(Debug)]
pub struct BodyOptions {
    /// What the server says of itself.
    pub server: NatNetServer,
    /// The version of the protocol, unless a client chooses another one for itself.
    pub version: NatNetVersion,
    /// Objects that are served, numbered in this order; all when empty, numbered by name.
    pub objects: Vec<ObjectId>,
}

#[derive(Debug)]
struct Shared {
    socket: UdpSocket,
    options: BodyOptions,
    bodies: NatNetBodies,
    clients: Vec<Client>,
    counts: BodyCounts,
    reporter: Reporter,
    gathering: Gathering,
}

#[derive(Debug)]
struct Client {
    address: SocketAddr,
    version: NatNetVersion,
    /// Whether it has asked for frames at its own address.
    wants_frames: bool,
    heard: Instant,
}

impl BodyServer {
    /// Serves by this socket.
    ///
    /// # Errors
    /// The system refuses a socket's settings or a thread.
    pub fn start(socket: UdpSocket, options: BodyOptions, reporter: Reporter) -> io::Result<Self> {
        socket.set_read_timeout(Some(GATHER))?;
        socket.set_write_timeout(Some(LONGEST_SEND))?;
        let commands = socket.try_clone()?;
        let shared = Arc::new(Mutex::new(Shared {
            bodies: NatNetBodies::new(options.server.axes, &options.objects),
            gathering: Gathering::new(options.server.rate_hz),
            socket,
            options,
            clients: Vec::new(),
            counts: BodyCounts::default(),
            reporter,
        }));
        let server = Self {
            shared: Arc::clone(&shared),
            stop: Arc::default(),
        };
        let stop = Arc::clone(&server.stop);
        Builder::new().name("natnet".into()).spawn(move || {
            let mut datagram = [0; MOST_BYTES];
            while !stop.load(Ordering::Relaxed) {
                let received = commands.recv_from(&mut datagram);
                // A client's machine may report a closed port; a lasting error must not spin.
                if received
                    .as_ref()
                    .is_err_and(|error| !relay::is_later(error))
                {
                    std::thread::sleep(GATHER);
                }
                let mut shared = locked(&shared);
                if let Ok((length, from)) = received {
                    shared.answer(&datagram[..length], from);
                }
                shared.send_if_due(Instant::now());
            }
        })?;
        Ok(server)
    }

    /// The counts at the end of a feed.
    pub fn counts(&self, feed: FeedCounts) -> BodyServerCounts {
        BodyServerCounts {
            feed,
            server: locked(&self.shared).counts,
        }
    }
}

impl Drop for BodyServer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl PoseReceiver for BodyServer {
    type Error = BusError;
    const WANTS_MODELS: bool = true;

    fn take(&mut self, pose: &ObjectPose) -> Result<Next, BusError> {
        let (mut shared, now) = (locked(&self.shared), Instant::now());
        let is_complete = shared.bodies.take(pose);
        shared.gathering.note(now, is_complete);
        shared.send_if_due(now);
        Ok(Next::More)
    }

    fn describe(&mut self, model: &ObjectModel) {
        locked(&self.shared).bodies.describe(model);
    }
}

impl Shared {
    fn answer(&mut self, datagram: &[u8], from: SocketAddr) {
        let version = self.version_of(from);
        let Some(request) = NatNetRequest::read(datagram) else {
            self.counts.unrecognized += 1;
            return;
        };
        let answer = match request {
            NatNetRequest::Connect(wanted) => {
                // Clients of the group all get its version.
                let is_alone = self.options.server.multicast.is_none();
                let wanted = wanted.filter(|_| is_alone).unwrap_or(version);
                self.note(from, |client| client.version = wanted);
                self.options.server.info(self.version_of(from))
            }
            NatNetRequest::ModelDefinitions => self.bodies.definitions(version),
            NatNetRequest::Frame => self.bodies.frame(version, now_ns()),
            NatNetRequest::Echo(theirs) => natnet_echo(theirs, now_ns()),
            NatNetRequest::KeepAlive => {
                let is_new = self.note(from, |client| {
                    let was_silent = !client.wants_frames;
                    client.wants_frames = true;
                    was_silent
                });
                self.counts.clients += u64::from(is_new == Some(true));
                return;
            }
            NatNetRequest::Disconnect => {
                self.clients.retain(|client| client.address != from);
                return;
            }
            NatNetRequest::Command(command) => self.command(command, from),
            NatNetRequest::Unrecognized => {
                self.counts.unrecognized += 1;
                self.options.server.answer("", version)
            }
        };
        self.send(&answer, from);
    }

    fn command(&mut self, command: &str, from: SocketAddr) -> Vec<u8> {
        if let Some(wanted) = command.strip_prefix("Bitstream") {
            let wanted = wanted.trim_start_matches(',').parse();
            let client = self.clients.iter_mut().find(|c| c.address == from);
            if let (Ok(wanted), Some(client)) = (wanted, client.filter(|c| c.wants_frames)) {
                client.version = wanted;
            }
            return natnet_bitstream(self.version_of(from));
        }
        self.options.server.answer(command, self.version_of(from))
    }

    fn version_of(&self, from: SocketAddr) -> NatNetVersion {
        let client = self.clients.iter().find(|client| client.address == from);
        client.map_or(self.options.version, |client| client.version)
    }

    /// Changes what is known of a client; `None` for one too many.
    fn note<T>(&mut self, from: SocketAddr, change: impl FnOnce(&mut Client) -> T) -> Option<T> {
        let now = Instant::now();
        self.clients
            .retain(|client| now.saturating_duration_since(client.heard) < SILENCE);
        let known = self.clients.iter().position(|c| c.address == from);
        if known.is_none() {
            if self.clients.len() >= MAX_CLIENTS {
                if self.counts.turned_away == 0 {
                    let notice = Notice::TooManyClients { most: MAX_CLIENTS };
                    self.reporter.report(&notice);
                }
                self.counts.turned_away += 1;
                return None;
            }
            self.clients.push(Client {
                address: from,
                version: self.options.version,
                wants_frames: false,
                heard: now,
            });
        }
        let place = known.unwrap_or(self.clients.len() - 1);
        let client = &mut self.clients[place];
        client.heard = now;
        Some(change(client))
    }

    /// Sends a frame if poses wait for one and its time has come.
    fn send_if_due(&mut self, now: Instant) {
        if !self.gathering.is_due(now) {
            return;
        }
        self.clients
            .retain(|client| now.saturating_duration_since(client.heard) < SILENCE);
        let group = self.options.server.multicast.map(SocketAddr::V4);
        let group = group.map(|group| (group, self.options.version));
        let clients = self.clients.iter().filter(|client| client.wants_frames);
        let receivers: Vec<(SocketAddr, NatNetVersion)> = clients
            .map(|client| (client.address, client.version))
            .chain(group)
            .collect();
        let mut frames: Vec<(NatNetVersion, Vec<u8>)> = Vec::new();
        for (address, version) in receivers {
            let made = frames.iter().position(|(made, _)| *made == version);
            let place = made.unwrap_or_else(|| {
                frames.push((version, self.bodies.frame(version, now_ns())));
                frames.len() - 1
            });
            self.send(&frames[place].1, address);
        }
        self.bodies.next_frame();
        self.counts.frames += 1;
    }

    fn send(&mut self, datagram: &[u8], address: SocketAddr) {
        match self.socket.send_to(datagram, address) {
            Ok(_) => self.counts.sent += 1,
            Err(cause) => {
                if self.counts.unsent == 0 {
                    self.reporter.report(&Notice::Unsent {
                        address,
                        cause: cause.to_string(),
                    });
                }
                self.counts.unsent += 1;
            }
        }
    }
}

fn locked(shared: &Mutex<Shared>) -> MutexGuard<'_, Shared> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

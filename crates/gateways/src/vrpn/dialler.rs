//! Connects to clients that asked for it by a datagram, in a thread of its own, since an address that does not answer
//! takes a while.

use std::net::{SocketAddr, TcpStream};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

/// Clients that wait for a connection; further ones ask again every two seconds.
const WAITING: usize = 16;
const PATIENCE: Duration = Duration::from_secs(1);

/// The thread, the addresses it has been given, and the connections it has made.
#[derive(Debug)]
pub struct Dialler {
    requests: SyncSender<SocketAddr>,
    answers: Receiver<(SocketAddr, Option<TcpStream>)>,
    pending: Vec<SocketAddr>,
}

impl Dialler {
    /// Starts the thread, which ends with this value.
    pub fn start() -> std::io::Result<Self> {
        let (requests, addresses) = sync_channel::<SocketAddr>(WAITING);
        let (made, answers) = sync_channel(WAITING);
        let thread = std::thread::Builder::new().name("vrpn-dialler".to_owned());
        thread.spawn(move || {
            for address in addresses {
                let stream = TcpStream::connect_timeout(&address, PATIENCE).ok();
                if made.send((address, stream)).is_err() {
                    break;
                }
            }
        })?;
        Ok(Self {
            requests,
            answers,
            pending: Vec::new(),
        })
    }

    /// Connects to `address` unless that is under way already, or too many others are.
    pub fn dial(&mut self, address: SocketAddr) {
        let is_new = !self.pending.contains(&address) && self.pending.len() < WAITING;
        if is_new && self.requests.try_send(address).is_ok() {
            self.pending.push(address);
        }
    }

    /// Takes a connection that has come about.
    pub fn connected(&mut self) -> Option<TcpStream> {
        while let Ok((address, stream)) = self.answers.try_recv() {
            self.pending.retain(|pending| *pending != address);
            if stream.is_some() {
                return stream;
            }
        }
        None
    }
}

//! A TCP proxy between two processes that does what a bad network does. It knows the framing of zenoh's TCP links, so
//! that it loses whole batches of messages, as a congested link does, and not bytes.

use sextant_simulator::Random;
use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::os::fd::AsRawFd;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

/// What happens to traffic from now on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Faults {
    /// Connections are closed and refused.
    pub is_cut: bool,
    /// Connections stay open, and nothing passes: half-open, as behind a switch that has lost its power.
    pub is_frozen: bool,
    /// Share of the batches towards the target that are lost.
    pub loss: f64,
    /// Delay of a batch, and by how much more it may be delayed; order is kept.
    pub delay: Duration,
    /// As above.
    pub jitter: Duration,
    /// Most bytes a second in each direction; 0: any. The proxy's own socket holds 64 KiB of what waits.
    pub bytes_per_s: u32,
}

/// A proxy; dropping it cuts its connections.
#[derive(Debug)]
pub struct FaultProxy {
    /// Where it listens: `tcp/127.0.0.1:<port>`.
    pub endpoint: String,
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    faults: Mutex<Faults>,
    connections: Mutex<Vec<TcpStream>>,
}

/// How often a frozen link looks whether it is thawed.
const THAW_POLL: Duration = Duration::from_millis(5);
/// What each socket of the proxy holds of data that were not passed on: as much as the queue of a small switch.
const HELD_BYTES: libc::c_int = 64 * 1024;
/// Batches under way in each direction of a connection; then its sender has to wait.
const WAITING: usize = 1024;
/// Batches of zenoh's handshake, which are never lost: loss is meant for messages.
const HANDSHAKE: u32 = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Direction {
    ToTarget,
    FromTarget,
}

impl FaultProxy {
    /// A proxy in front of the endpoint `tcp/<address>:<port>`, without faults.
    ///
    /// # Panics
    /// When there is no free port.
    #[must_use]
    pub fn start(target: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        hold_little(&listener);
        let address = listener.local_addr().expect("an address");
        let shared = Arc::new(Shared {
            faults: Mutex::default(),
            connections: Mutex::default(),
        });
        let target = target.trim_start_matches("tcp/").to_owned();
        let accepting = Arc::clone(&shared);
        std::thread::spawn(move || accepting.accept(&listener, &target));
        Self {
            endpoint: format!("tcp/{address}"),
            shared,
        }
    }

    /// Changes what happens from now on.
    pub fn set(&self, faults: Faults) {
        *lock(&self.shared.faults) = faults;
        if faults.is_cut {
            self.shared.close();
        }
    }
}

impl Drop for FaultProxy {
    fn drop(&mut self) {
        self.set(Faults {
            is_cut: true,
            ..Faults::default()
        });
    }
}

impl Shared {
    fn faults(&self) -> Faults {
        *lock(&self.faults)
    }

    fn close(&self) {
        for connection in lock(&self.connections).drain(..) {
            let _ = connection.shutdown(Shutdown::Both);
        }
    }

    /// Until the test's process ends.
    fn accept(self: Arc<Self>, listener: &TcpListener, target: &str) {
        for (near, number) in listener.incoming().flatten().zip(0_u64..) {
            if self.faults().is_cut {
                continue;
            }
            let Ok(far) = TcpStream::connect(target) else {
                continue;
            };
            hold_little(&far);
            let _ = (near.set_nodelay(true), far.set_nodelay(true));
            for (from, to, direction) in [
                (&near, &far, Direction::ToTarget),
                (&far, &near, Direction::FromTarget),
            ] {
                let (Ok(from), Ok(to)) = (from.try_clone(), to.try_clone()) else {
                    continue;
                };
                let shared = Arc::clone(&self);
                std::thread::spawn(move || {
                    let _ = shared.pass(&from, &to, direction, number);
                    let _ = (from.shutdown(Shutdown::Both), to.shutdown(Shutdown::Both));
                });
            }
            lock(&self.connections).extend([near, far]);
        }
    }

    /// Takes batches in: two bytes of length, little-endian, and so many bytes; another thread passes them on when they
    /// are due.
    fn pass(
        self: &Arc<Self>,
        mut from: &TcpStream,
        to: &TcpStream,
        direction: Direction,
        seed: u64,
    ) -> io::Result<()> {
        let mut random = Random::from_keys(&[seed, u64::from(direction == Direction::ToTarget)]);
        let (due, batches) = mpsc::sync_channel(WAITING);
        let (shared, to) = (Arc::clone(self), to.try_clone()?);
        std::thread::spawn(move || {
            let _ = shared.deliver(&batches, &to);
            let _ = to.shutdown(Shutdown::Both);
        });
        for number in 0_u32.. {
            let mut batch = vec![0; 2];
            from.read_exact(&mut batch)?;
            let length = usize::from(u16::from_le_bytes([batch[0], batch[1]]));
            batch.resize(2 + length, 0);
            from.read_exact(&mut batch[2..])?;
            let faults = self.faults();
            if faults.bytes_per_s > 0 {
                let seconds = batch.len() as f64 / f64::from(faults.bytes_per_s);
                std::thread::sleep(Duration::from_secs_f64(seconds));
            }
            let may_be_lost = direction == Direction::ToTarget && number >= HANDSHAKE;
            if may_be_lost && random.uniform() < faults.loss {
                continue;
            }
            let delay = faults.delay + faults.jitter.mul_f64(random.uniform());
            if due.send((Instant::now() + delay, batch)).is_err() {
                break;
            }
        }
        Ok(())
    }

    /// In the order in which they came.
    fn deliver(
        &self,
        batches: &mpsc::Receiver<(Instant, Vec<u8>)>,
        mut to: &TcpStream,
    ) -> io::Result<()> {
        for (due, batch) in batches {
            std::thread::sleep(due.saturating_duration_since(Instant::now()));
            while self.faults().is_frozen {
                std::thread::sleep(THAW_POLL);
            }
            to.write_all(&batch)?;
        }
        Ok(())
    }
}

/// Bounds what the kernel receives before the proxy reads it, also on the connections of a listener.
fn hold_little(socket: &impl AsRawFd) {
    let value = HELD_BYTES;
    let bytes = (&raw const value).cast();
    let length = size_of_val(&value) as libc::socklen_t;
    let (level, option) = (libc::SOL_SOCKET, libc::SO_RCVBUF);
    // SAFETY: the value is a live integer of the length given; the descriptor is open.
    let result = unsafe { libc::setsockopt(socket.as_raw_fd(), level, option, bytes, length) };
    assert_eq!(result, 0, "{}", io::Error::last_os_error());
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits until a condition holds.
///
/// # Panics
/// When it never does.
pub(crate) fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + crate::PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "never: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

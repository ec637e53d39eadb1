//! The watchdog of systemd, which restarts a process that is silent for `WatchdogSec`. Main loops call [`feed`] in each
//! iteration, so that a hanging loop is detected; without a watchdog it does nothing.
//!
//! The protocol is `sd_notify`'s: a datagram `WATCHDOG=1` to the socket in `NOTIFY_SOCKET`, at least every
//! `WATCHDOG_USEC`, from the process that `WATCHDOG_PID` names.

use std::ffi::{OsStr, OsString};
use std::io;
use std::os::linux::net::SocketAddrExt;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Notifies the watchdog, if there is one, at most four times in its period. Cheap enough for every iteration of a
/// loop.
pub fn feed() {
    static WATCHDOG: OnceLock<Option<Watchdog>> = OnceLock::new();
    if let Some(watchdog) = WATCHDOG.get_or_init(Watchdog::from_environment) {
        watchdog.feed();
    }
}

struct Watchdog {
    socket: UnixDatagram,
    period: Duration,
    started: Instant,
    /// Microseconds after `started`.
    due: AtomicU64,
}

impl Watchdog {
    fn from_environment() -> Option<Self> {
        let read = |name: &str| std::env::var_os(name);
        let (socket, period) = wanted(
            read("NOTIFY_SOCKET"),
            read("WATCHDOG_USEC"),
            read("WATCHDOG_PID"),
        )?;
        let connected = Self::new(&socket, period);
        connected
            .inspect_err(|cause| tracing::warn!("the watchdog's socket {socket:?}: {cause}"))
            .ok()
    }

    fn new(socket: &OsStr, period: Duration) -> io::Result<Self> {
        let address = match socket.as_bytes() {
            [b'@', name @ ..] => SocketAddr::from_abstract_name(name)?,
            _ => SocketAddr::from_pathname(socket)?,
        };
        let socket = UnixDatagram::unbound()?;
        socket.connect_addr(&address)?;
        // A full socket must not block a loop; the next iteration tries again.
        socket.set_nonblocking(true)?;
        Ok(Self {
            socket,
            period,
            started: Instant::now(),
            due: AtomicU64::new(0),
        })
    }

    fn feed(&self) {
        let now = self.started.elapsed();
        let micros = |duration: Duration| u64::try_from(duration.as_micros()).unwrap_or(u64::MAX);
        if micros(now) >= self.due.load(Ordering::Relaxed)
            && self.socket.send(b"WATCHDOG=1").is_ok()
        {
            self.due
                .store(micros(now + self.period / 4), Ordering::Relaxed);
        }
    }
}

/// Socket and period, if the watchdog watches this process.
fn wanted(
    socket: Option<OsString>,
    micros: Option<OsString>,
    process: Option<OsString>,
) -> Option<(OsString, Duration)> {
    let number = |text: OsString| text.to_str().and_then(|text| text.parse::<u64>().ok());
    let period = Duration::from_micros(number(micros?)?);
    let is_ours = process.is_none_or(|id| number(id) == Some(std::process::id().into()));
    (is_ours && !period.is_zero()).then_some((socket?, period))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: &str) -> Option<OsString> {
        Some(value.into())
    }

    #[test]
    fn a_process_that_is_not_watched_says_nothing() {
        let own = std::process::id().to_string();
        let (socket, micros) = (text("/run/notify"), text("3000000"));
        let expected = Some(("/run/notify".into(), Duration::from_secs(3)));
        assert_eq!(wanted(socket.clone(), micros.clone(), text(&own)), expected);
        assert_eq!(wanted(socket.clone(), micros.clone(), None), expected);
        assert_eq!(wanted(socket.clone(), micros.clone(), text("1")), None);
        assert_eq!(wanted(socket.clone(), None, None), None);
        assert_eq!(wanted(socket, text("0"), None), None);
        assert_eq!(wanted(None, micros, None), None);
    }

    #[test]
    fn it_is_fed_at_once_and_then_four_times_a_period() {
        let name = format!("sextant-watchdog-{}", std::process::id());
        let address = SocketAddr::from_abstract_name(&name).unwrap();
        let systemd = UnixDatagram::bind_addr(&address).unwrap();
        let socket = OsString::from(format!("@{name}"));
        let watchdog = Watchdog::new(&socket, Duration::from_secs(1000)).unwrap();
        watchdog.feed();
        watchdog.feed();
        let mut bytes = [0; 64];
        let length = systemd.recv(&mut bytes).unwrap();
        assert_eq!(&bytes[..length], b"WATCHDOG=1");
        systemd.set_nonblocking(true).unwrap();
        assert!(systemd.recv(&mut bytes).is_err(), "it was fed twice");
        watchdog.due.store(0, Ordering::Relaxed);
        watchdog.feed();
        assert_eq!(systemd.recv(&mut bytes).unwrap(), length);
    }
}

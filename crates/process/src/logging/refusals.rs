//! Clear messages for refused connections. Zenoh reports them as a lack of file descriptors, as an internal error of its
//! handshake, or at a low level.

use std::fmt::{self, Write};
use tracing::Event;
use tracing::field::{Field, Visit};

/// Zenoh's targets that are enabled only for these messages.
pub(super) const FILTER: &str = "zenoh_link_tls=warn,zenoh_transport::unicast::establishment::accept=debug,\
                                 zenoh::net::routing::interceptor::access_control=info";

const TLS: &str = "zenoh_link_tls";
const HANDSHAKE: &str = "zenoh_transport::unicast::establishment::accept";
const MEMBERSHIP: &str = "zenoh::net::routing::interceptor::access_control";

/// How an event is logged.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Wording {
    /// Unchanged.
    Own,
    /// With this message, as a warning.
    Instead(String),
    /// Not at all: it passes the filter only because of others of its target.
    Beside,
}

pub(super) fn wording(event: &Event<'_>) -> Wording {
    let target = event.metadata().target();
    if ![TLS, HANDSHAKE, MEMBERSHIP]
        .iter()
        .any(|place| target.starts_with(place))
    {
        return Wording::Own;
    }
    let mut message = Message::default();
    event.record(&mut message);
    wording_of(target, &message.0)
}

fn wording_of(target: &str, message: &str) -> Wording {
    if target.starts_with(TLS) {
        return match message.split_once(". Hint: increase the system open file limit") {
            // Refusals by the system have an error number, and zenoh's hint may be right.
            Some((cause, _)) if cause.contains("InvalidContentType") => {
                Wording::Instead("connection refused: the other end speaks no TLS".into())
            }
            Some((cause, _)) if !cause.contains("os error") => {
                Wording::Instead(format!("connection refused: {cause}"))
            }
            _ => Wording::Own,
        };
    }
    if target.starts_with(HANDSHAKE) {
        let cause = message.split_once("UsrPwd extension - ");
        return match cause.map(|(_, cause)| cause) {
            Some(cause) if cause.contains("Invalid user") => {
                Wording::Instead("connection refused: no user of that name".into())
            }
            Some(cause) if cause.contains("Invalid password") => {
                Wording::Instead("connection refused: wrong password".into())
            }
            Some(_) => Wording::Instead("connection refused: no user name and password".into()),
            None => Wording::Beside,
        };
    }
    match message.split_once(" did not match any configured ACL subject") {
        Some((process, _)) => Wording::Instead(format!(
            "process {process} connected with keys of no member, perhaps revoked ones: it reads and writes nothing"
        )),
        None => Wording::Beside,
    }
}

/// The message of an event.
#[derive(Default)]
struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            let _ = write!(self.0, "{value:?}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_is_not_let_in_is_named_plainly() {
        for (target, message, expected) in [
            (
                TLS,
                "peer sent no certificates. Hint: increase the system open file limit.",
                "connection refused: peer sent no certificates",
            ),
            (
                HANDSHAKE,
                "UsrPwd extension - Recv OpenSyn. Invalid password. at auth.rs:1.",
                "connection refused: wrong password",
            ),
            (
                HANDSHAKE,
                "UsrPwd extension - Recv InitSyn. Expected extension. at auth.rs:1.",
                "connection refused: no user name and password",
            ),
            (
                MEMBERSHIP,
                "1f did not match any configured ACL subject. Default permission `Deny` will be applied on all messages",
                "process 1f connected with keys of no member, perhaps revoked ones: it reads and writes nothing",
            ),
        ] {
            assert_eq!(
                wording_of(target, message),
                Wording::Instead(expected.into())
            );
        }
    }

    #[test]
    fn everything_else_is_told_as_it_is_or_not_at_all() {
        let full = "Too many open files (os error 24). Hint: increase the system open file limit.";
        assert_eq!(wording_of(TLS, full), Wording::Own);
        assert_eq!(wording_of(HANDSHAKE, "New transport link"), Wording::Beside);
    }
}

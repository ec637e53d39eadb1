//! Clear messages for refused connections and denied messages. Zenoh reports them as a lack of file descriptors, as an
//! internal error of its handshake, or at a low level.

use std::cell::RefCell;
use std::fmt::{self, Write};
use tracing::field::{Field, Visit};
use tracing::{Event, Level};

/// Zenoh's targets that are enabled only for these messages.
pub(super) const FILTER: &str = "zenoh_link_commons::quic=warn,zenoh_transport::unicast::establishment::accept=debug,\
                                 zenoh_transport::unicast::manager=trace,\
                                 zenoh::net::routing::interceptor::access_control=trace";

const QUIC: &str = "zenoh_link_commons::quic";
const HANDSHAKE: &str = "zenoh_transport::unicast::establishment::accept";
const MANAGER: &str = "zenoh_transport::unicast::manager";
const ACCESS: &str = "zenoh::net::routing::interceptor::access_control";

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
    if ![QUIC, HANDSHAKE, MANAGER, ACCESS]
        .iter()
        .any(|place| target.starts_with(place))
    {
        return Wording::Own;
    }
    if target.starts_with(MANAGER) && *event.metadata().level() == Level::ERROR {
        return Wording::Own;
    }
    let mut message = Message::default();
    event.record(&mut message);
    let is_computed_ahead =
        target.starts_with(ACCESS) && COMPUTED.with_borrow_mut(|one| one.covers(&message.0));
    match is_computed_ahead {
        true => Wording::Beside,
        false => wording_of(target, &message.0),
    }
}

thread_local! {
    static COMPUTED: RefCell<ComputedPermissions> = const { RefCell::new(ComputedPermissions { are_open: false }) };
}

/// Permissions that zenoh computes ahead when a link declares a key, for every kind of message that may come under it.
/// They are traced as decisions about messages are, and nothing is denied yet: prefixes of keys that a member reads or
/// answers for are declared in the ordinary course of a start, and nobody publishes under them. A message that is
/// denied by them afterwards is traced again, as a "cached result".
#[derive(Debug, Default)]
struct ComputedPermissions {
    /// Between the announcement of a key's permissions and the last of them.
    are_open: bool,
}

impl ComputedPermissions {
    /// Whether a line is one of them.
    fn covers(&mut self, message: &str) -> bool {
        if message.contains(": caching permissions for `") {
            self.are_open = true;
            return true;
        }
        let is_covered = self.are_open
            && !message.starts_with("Using cached result")
            && message.contains("authorized to ");
        self.are_open = is_covered && !message.contains(" Declare Liveliness Subscriber (");
        is_covered
    }
}

fn wording_of(target: &str, message: &str) -> Wording {
    if target.starts_with(QUIC) {
        // Zenoh prints the whole error of its QUIC crate; the reason in it is that of the handshake.
        let Some((_, error)) = message.split_once("QUIC acceptor failed: ") else {
            return Wording::Own;
        };
        let who = match error.starts_with("ConnectionClosed") {
            true => " by the other end",
            false => "",
        };
        return match quoted_after(error, "reason: ") {
            Some(reason) => Wording::Instead(format!("connection refused{who}: {reason}")),
            None => Wording::Own,
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
    if target.starts_with(MANAGER) {
        let most = message.strip_prefix("Max transports reached (");
        let most = most.and_then(|rest| rest.split_once(')'));
        return most.map_or(Wording::Beside, |(most, _)| {
            Wording::Instead(format!(
                "connection refused: all {most} links are taken; raise max_links in [network], or end what needs none"
            ))
        });
    }
    wording_of_access(message).map_or(Wording::Beside, Wording::Instead)
}

/// Zenoh traces each decision of its access control; those on subscriptions and queries are denied as a matter of
/// course, since everyone hears of them.
fn wording_of_access(message: &str) -> Option<String> {
    if let Some((process, _)) = message.split_once(" did not match any configured ACL subject") {
        return Some(format!(
            "process {process} connected with keys of no member, perhaps revoked ones: it reads and writes nothing"
        ));
    }
    let (who, key) = message.split_once(" is unauthorized to Put (ingress) on ")?;
    let process = who.trim_start_matches("Using cached result: ");
    Some(format!(
        "a message was denied: process {process} may not publish on {key}"
    ))
}

/// The text after `name` in the output of a `Debug`, if it is not empty.
fn quoted_after(text: &str, name: &str) -> Option<String> {
    let (_, value) = text.split_once(name)?;
    let (_, value) = value.split_once('"')?;
    let mut escaped = false;
    let end = value.find(|letter| {
        let is_end = letter == '"' && !escaped;
        escaped = letter == '\\' && !escaped;
        is_end
    })?;
    (end > 0).then(|| value[..end].replace("\\\"", "\""))
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
                QUIC,
                "QUIC acceptor failed: TransportError(Error \
                 { code: Code::crypto(74), frame: None, reason: \"peer sent no certificates\" }) \
                 at unicast.rs:1. Hint: increase the system open file limit.",
                "connection refused: peer sent no certificates",
            ),
            (
                QUIC,
                r#"QUIC acceptor failed: ConnectionClosed(ConnectionClose { error_code: Code::crypto(2a), frame_type: None, reason: b"not valid for name \"a.lab\"" })"#,
                "connection refused by the other end: not valid for name \"a.lab\"",
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
                MANAGER,
                "Max transports reached (2). Denying new transport with peer: 1f at manager.rs:628.",
                "connection refused: all 2 links are taken; raise max_links in [network], or end what needs none",
            ),
            (
                ACCESS,
                "1f did not match any configured ACL subject. Default permission `Deny` will be \
                 applied on all messages",
                "process 1f connected with keys of no member, perhaps revoked ones: it reads and writes nothing",
            ),
            (
                ACCESS,
                "Using cached result: 1f is unauthorized to Put (ingress) on a/b",
                "a message was denied: process 1f may not publish on a/b",
            ),
        ] {
            assert_eq!(
                wording_of(target, message),
                Wording::Instead(expected.into())
            );
        }
    }

    /// As zenoh 1.10 traces the declaration of a key and then two messages.
    #[test]
    fn permissions_that_are_computed_ahead_are_no_denials() {
        let mut computed = ComputedPermissions::default();
        let mut denied = Vec::new();
        for line in [
            "ACL (ingress): caching permissions for `lab/alive` ...",
            "1f on page is unauthorized to Query (ingress) on lab/alive",
            "1f on page is unauthorized to Put (ingress) on lab/alive",
            "1f on page is authorized to Declare/Undeclare Liveliness Token (ingress) on lab/alive",
            "1f on page is unauthorized to Declare Liveliness Subscriber (ingress) on lab/alive",
            "1f on page is unauthorized to Put (ingress) on lab/config/rig",
            "Using cached result: 1f is unauthorized to Put (ingress) on lab/alive",
            "ACL (ingress): caching permissions for `lab/camera` ...",
            "Using cached result: 1f is unauthorized to Put (ingress) on lab/rig",
            "1f on page is unauthorized to Put (ingress) on lab/config/rig",
        ] {
            if !computed.covers(line) {
                denied.extend(wording_of_access(line));
            }
        }
        assert_eq!(denied.len(), 4, "{denied:?}");
    }

    #[test]
    fn everything_else_is_logged_as_it_is_or_not_at_all() {
        let full = "Too many open files (os error 24). Hint: increase the system open file limit.";
        assert_eq!(wording_of(QUIC, full), Wording::Own);
        for (target, message) in [
            (HANDSHAKE, "New transport link"),
            (MANAGER, "New transport opened"),
            (ACCESS, "1f on a is authorized to Put (ingress) on a/b"),
            (
                ACCESS,
                "1f is unauthorized to Declare Subscriber (egress) on a/b",
            ),
        ] {
            assert_eq!(wording_of(target, message), Wording::Beside);
        }
    }
}

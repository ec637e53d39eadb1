//! Who may read the site through a browser: requests that name this bridge as their host and come from its own page.
//!
//! A web page elsewhere can make a visitor's browser connect to loopback or lab addresses, by DNS rebinding even under
//! a name of its own. Such requests carry that name as `Host`, or the page's address as `Origin`; both give it away.

use std::net::{IpAddr, SocketAddr};

/// The hosts that a request may name.
#[derive(Debug, Clone)]
pub(crate) struct HostRule {
    listening: IpAddr,
    names: Vec<String>,
}

impl HostRule {
    /// The rule of a bridge that listens on `address` and is known by `names`.
    pub(crate) fn new(address: SocketAddr, names: &[String]) -> Self {
        Self {
            listening: address.ip().to_canonical(),
            names: names.iter().map(|name| canonical(name)).collect(),
        }
    }

    /// Whether a request with these headers may be answered.
    pub(crate) fn admits(&self, host: Option<&str>, origin: Option<&str>) -> bool {
        host.is_some_and(|host| {
            self.is_ours(host) && origin.is_none_or(|origin| same_place(origin, host))
        })
    }

    fn is_ours(&self, host: &str) -> bool {
        let name = canonical(without_port(host));
        if name == "localhost" || self.names.contains(&name) {
            return true;
        }
        let bare = name.trim_start_matches('[').trim_end_matches(']');
        bare.parse::<IpAddr>().is_ok_and(|address| {
            let address = address.to_canonical();
            address.is_loopback() || self.listening.is_unspecified() || address == self.listening
        })
    }
}

/// An origin is scheme and host; `null` and other schemes than the web's are nobody's.
fn same_place(origin: &str, host: &str) -> bool {
    ["http://", "https://"]
        .iter()
        .find_map(|scheme| origin.strip_prefix(scheme))
        .is_some_and(|place| place.eq_ignore_ascii_case(host))
}

fn without_port(host: &str) -> &str {
    match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => name,
        _ => host,
    }
}

fn canonical(name: &str) -> String {
    name.trim_end_matches('.').to_ascii_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(listen: &str) -> HostRule {
        HostRule::new(listen.parse().unwrap(), &["Viewer.lab".to_owned()])
    }

    #[test]
    fn loopback_and_configured_names_are_ours() {
        for listen in ["127.0.0.1:8600", "[::1]:8600", "0.0.0.0:8600"] {
            for host in [
                "localhost:8600",
                "127.0.0.1:8600",
                "[::1]:8600",
                "LOCALHOST",
                "viewer.lab:80",
                "viewer.lab.",
            ] {
                assert!(rule(listen).admits(Some(host), None), "{listen} {host}");
            }
        }
    }

    #[test]
    fn a_foreign_name_is_refused_whatever_it_resolves_to() {
        for listen in ["127.0.0.1:8600", "192.168.1.5:8600", "0.0.0.0:8600"] {
            for host in [
                "evil.example:8600",
                "localhost.evil.example",
                "127.0.0.1.evil.example",
                "",
            ] {
                assert!(!rule(listen).admits(Some(host), None), "{listen} {host}");
            }
            assert!(!rule(listen).admits(None, None));
        }
    }

    #[test]
    fn addresses_count_as_far_as_the_bridge_listens() {
        assert!(!rule("127.0.0.1:8600").admits(Some("192.168.1.5:8600"), None));
        assert!(rule("192.168.1.5:8600").admits(Some("192.168.1.5:8600"), None));
        assert!(!rule("192.168.1.5:8600").admits(Some("192.168.1.6:8600"), None));
        assert!(rule("0.0.0.0:8600").admits(Some("192.168.1.6:8600"), None));
        assert!(rule("[::]:8600").admits(Some("[fe80::1]:8600"), None));
    }

    #[test]
    fn only_the_bridges_own_page_may_ask() {
        let asks = |origin| rule("127.0.0.1:8600").admits(Some("localhost:8600"), Some(origin));
        assert!(asks("http://localhost:8600"));
        assert!(!asks("http://localhost:3000"));
        assert!(!asks("https://evil.example"));
        assert!(!asks("null"));
        assert!(!asks("file://localhost:8600"));
    }
}

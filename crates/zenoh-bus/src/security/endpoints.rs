//! Which endpoints fit which profile.

use std::net::{IpAddr, ToSocketAddrs};

use super::Profile;
use crate::{BusOptions, Mode, SecurityError};

impl BusOptions {
    /// The endpoints to connect to, with defaults.
    pub fn connect_endpoints(&self, profile: Profile) -> Vec<String> {
        match (&self.connect, self.mode) {
            (Some(endpoints), _) => endpoints.clone(),
            (None, Mode::Client) => vec![format!("{}/127.0.0.1:7447", profile.protocol())],
            (None, _) => Vec::new(),
        }
    }
}

/// Refuses endpoints that the profile does not protect.
///
/// A client chooses whom to trust, so profile demo restricts listening only.
pub(super) fn check(
    profile: Profile,
    network: &BusOptions,
    listen: &[String],
) -> Result<(), SecurityError> {
    check_all(profile, &network.connect_endpoints(profile), listen)
}

/// As [`check`], for the endpoints of a finished configuration.
pub(crate) fn check_all(
    profile: Profile,
    connect: &[String],
    listen: &[String],
) -> Result<(), SecurityError> {
    match profile {
        Profile::Open => Ok(()),
        Profile::Demo => listen.iter().try_for_each(|endpoint| check_local(endpoint)),
        Profile::Lab | Profile::Site => listen
            .iter()
            .chain(connect)
            .try_for_each(|endpoint| check_protocol(profile, endpoint)),
    }
}

fn check_protocol(profile: Profile, endpoint: &str) -> Result<(), SecurityError> {
    let protocol = profile.protocol();
    if endpoint.split('/').next() == Some(protocol) {
        return Ok(());
    }
    Err(SecurityError::Protocol {
        endpoint: endpoint.to_owned(),
        profile: profile.name(),
        protocol,
    })
}

impl Profile {
    /// Protocol of the profile's links.
    pub(crate) fn protocol(self) -> &'static str {
        match self {
            Self::Site => "quic",
            Self::Demo | Self::Lab | Self::Open => "tcp",
        }
    }
}

fn check_local(endpoint: &str) -> Result<(), SecurityError> {
    if is_local(endpoint) {
        return Ok(());
    }
    Err(SecurityError::OpenDoor {
        endpoint: endpoint.to_owned(),
    })
}

/// Whether only this machine can reach the endpoint; false if that is unknown.
fn is_local(endpoint: &str) -> bool {
    let address = endpoint.split_once('/').map_or("", |(_, address)| address);
    let address = address.split(['?', '#']).next().unwrap_or_default();
    let Ok(mut addresses) = address.to_socket_addrs().map(Iterator::peekable) else {
        return false;
    };
    addresses.peek().is_some() && addresses.all(|address| is_loopback(address.ip()))
}

fn is_loopback(address: IpAddr) -> bool {
    address.to_canonical().is_loopback()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loopback_is_local_and_nothing_else_is() {
        for endpoint in [
            "tcp/127.0.0.1:7447",
            "tcp/127.1.2.3:0",
            "tcp/[::1]:7447",
            "tcp/localhost:7447",
            "tcp/127.0.0.1:7447?prio=1",
            "tcp/127.0.0.1:7447#so_sndbuf=65000",
        ] {
            assert!(is_local(endpoint), "{endpoint}");
        }
        for endpoint in [
            "tcp/0.0.0.0:7447",
            "tcp/[::]:7447",
            "tcp/192.0.2.1:7447",
            "tcp/127.0.0.1",
            "nonsense",
        ] {
            assert!(!is_local(endpoint), "{endpoint}");
        }
    }

    #[test]
    fn a_demo_that_listens_to_the_network_gets_a_remedy() {
        let network = BusOptions::router_on("tcp/0.0.0.0:7447");
        let words = check(Profile::Demo, &network, &network.listen).unwrap_err();
        assert!(words.to_string().contains("profile = \"open\""), "{words}");
        assert!(check(Profile::Open, &network, &network.listen).is_ok());
        let client = BusOptions::client_of("tcp/192.0.2.1:7447");
        assert!(check(Profile::Demo, &client, &[]).is_ok());
    }

    #[test]
    fn a_site_has_no_plain_endpoints_and_a_lab_only_such() {
        for (profile, wrong, right) in [
            (Profile::Site, "tcp/h:1", "quic/h:1"),
            (Profile::Lab, "quic/h:1", "tcp/h:1"),
        ] {
            for network in [BusOptions::client_of(wrong), BusOptions::router_on(wrong)] {
                assert!(check(profile, &network, &network.listen).is_err());
            }
            for network in [BusOptions::client_of(right), BusOptions::router_on(right)] {
                check(profile, &network, &network.listen).unwrap();
            }
        }
    }
}

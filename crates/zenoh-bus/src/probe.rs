//! Diagnoses why no router answers by a connection attempt, since zenoh does not report it. Each step takes at most
//! half a second.

use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::Duration;

use crate::{BusOptions, Security};

const STEP: Duration = Duration::from_millis(500);

/// A router, or another program, that is reached and does not admit this one.
pub const NO_SESSION: &str = "something listens there and admits no session: a router whose \
    links are all taken (`max_links` in [network] of its file), one that wants keys (--keys), or another program";

/// What prevents a client from connecting to each of its routers, as far as it can tell; `None` without an endpoint.
pub fn why_no_router(options: &BusOptions, security: &Security) -> Option<String> {
    let endpoints = options.connect_endpoints(security.profile());
    let causes = endpoints.iter().filter_map(|endpoint| {
        let cause = try_endpoint(endpoint, security).err()?;
        Some(format!("{endpoint}: {cause}"))
    });
    let causes: Vec<String> = causes.collect();
    (!causes.is_empty()).then(|| causes.join("; "))
}

fn try_endpoint(endpoint: &str, security: &Security) -> Result<(), String> {
    let Some((protocol, address)) = endpoint.split_once('/') else {
        return Ok(());
    };
    let address = address.split(['?', '#']).next().unwrap_or_default();
    let addresses: Vec<SocketAddr> = address
        .to_socket_addrs()
        .map_err(|cause| cause.to_string())?
        .collect();
    let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
    let mut last = Err("the name has no address".to_owned());
    for address in addresses {
        last = match protocol {
            "quic" => quic::connect(address, host, security),
            _ => TcpStream::connect_timeout(&address, STEP)
                .map(drop)
                .map_err(|cause| cause.to_string()),
        };
        if last.is_ok() {
            return Err(NO_SESSION.to_owned());
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;
    use std::net::TcpListener;

    #[test]
    fn a_listener_without_a_session_differs_from_no_listener() {
        let silent = TcpListener::bind("127.0.0.1:0").unwrap();
        let endpoint = format!("tcp/{}", silent.local_addr().unwrap());
        let why = || {
            let options = BusOptions::client_of(&endpoint);
            why_no_router(&options, &Security::none(Profile::Demo)).unwrap()
        };
        assert!(why().contains("whose links are all taken"), "{}", why());
        drop(silent);
        assert!(!why().contains(NO_SESSION), "{}", why());
    }
}

#[cfg(not(feature = "quic"))]
mod quic {
    use super::{Security, SocketAddr};

    pub(super) fn connect(_: SocketAddr, _: &str, _: &Security) -> Result<(), String> {
        Ok(())
    }
}

#[cfg(feature = "quic")]
mod quic {
    use std::net::{Ipv4Addr, Ipv6Addr};
    use std::sync::Arc;

    use quinn::crypto::rustls::QuicClientConfig;
    use quinn::{ConnectError, ConnectionError, Endpoint};
    use rustls::crypto::ring;
    use rustls::pki_types::pem::PemObject;
    use rustls::pki_types::{CertificateDer, PrivateKeyDer};
    use rustls::{ClientConfig, RootCertStore};
    use tokio::time::timeout;

    use super::{STEP, Security, SocketAddr};

    /// What zenoh's routers since 1.9 offer.
    const PROTOCOL: &[u8] = b"zenoh";

    /// Performs the handshake of a session, and waits whether the router accepts it.
    pub(super) fn connect(
        address: SocketAddr,
        host: &str,
        security: &Security,
    ) -> Result<(), String> {
        let config = config(security).ok_or("no keys that can be read")?;
        let probe = || {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()
                .map_err(|cause| cause.to_string())?;
            runtime.block_on(handshake(address, host, config))
        };
        // In a thread of its own: the caller may be within a runtime, where another one must not block.
        let probed = std::thread::scope(|scope| scope.spawn(probe).join());
        probed.unwrap_or_else(|_| Err("the attempt failed".to_owned()))
    }

    async fn handshake(
        address: SocketAddr,
        host: &str,
        config: quinn::ClientConfig,
    ) -> Result<(), String> {
        let any: SocketAddr = match address {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let endpoint = Endpoint::client(any).map_err(|cause| cause.to_string())?;
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let connecting = endpoint
            .connect_with(config, address, host)
            .map_err(|cause: ConnectError| cause.to_string())?;
        let Ok(connected) = timeout(STEP, connecting).await else {
            return Err("no answer: nothing listens there, or UDP does not get through".to_owned());
        };
        let connection = connected.map_err(|cause| words(&cause))?;
        // The router judges the client's certificate after the client has finished; if it accepts the connection, it is
        // silent.
        match timeout(STEP, connection.closed()).await {
            Ok(cause) => Err(words(&cause)),
            Err(_) => Ok(()),
        }
    }

    fn words(cause: &ConnectionError) -> String {
        match cause {
            ConnectionError::TransportError(error) if !error.reason.is_empty() => {
                error.reason.clone()
            }
            ConnectionError::ConnectionClosed(close) if !close.reason.is_empty() => {
                format!(
                    "the router refuses: {}",
                    String::from_utf8_lossy(&close.reason)
                )
            }
            cause => cause.to_string(),
        }
    }

    fn config(security: &Security) -> Option<quinn::ClientConfig> {
        let files = &security.keys()?.files;
        let mut roots = RootCertStore::empty();
        roots
            .add(CertificateDer::from_pem_file(files.authority()).ok()?)
            .ok()?;
        let certificate = CertificateDer::from_pem_file(files.certificate()).ok()?;
        let key = PrivateKeyDer::from_pem_file(files.private_key()).ok()?;
        let mut tls = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_protocol_versions(&[&rustls::version::TLS13])
            .ok()?
            .with_root_certificates(roots)
            .with_client_auth_cert(vec![certificate], key)
            .ok()?;
        tls.alpn_protocols = vec![PROTOCOL.to_vec()];
        let tls = QuicClientConfig::try_from(tls).ok()?;
        Some(quinn::ClientConfig::new(Arc::new(tls)))
    }
}

//! Diagnoses why no router answers by a connection attempt, since zenoh does not report it. Each step takes at most half a second.

use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use crate::{BusOptions, Security};

const STEP: Duration = Duration::from_millis(500);

/// What prevents a client from connecting to each of its routers, as far as it can tell; `None` if nothing seems to.
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
    let addresses = address
        .to_socket_addrs()
        .map_err(|cause| cause.to_string())?;
    let mut last = Err("the name has no address".to_owned());
    for address in addresses {
        last = TcpStream::connect_timeout(&address, STEP).map_err(|cause| cause.to_string());
        if last.is_ok() {
            break;
        }
    }
    let stream = last?;
    if protocol != "tls" {
        return Ok(());
    }
    tls::shake_hands(stream, address, security)
}

#[cfg(not(feature = "tls"))]
mod tls {
    use super::{Security, TcpStream};

    pub(super) fn shake_hands(_: TcpStream, _: &str, _: &Security) -> Result<(), String> {
        Ok(())
    }
}

#[cfg(feature = "tls")]
mod tls {
    use std::io::{ErrorKind, Read};
    use std::sync::Arc;

    use rustls::crypto::ring;
    use rustls::pki_types::pem::PemObject;
    use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName};
    use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};

    use super::{STEP, Security, TcpStream};

    /// Performs the handshake of a session, and waits whether the router accepts it.
    pub(super) fn shake_hands(
        stream: TcpStream,
        address: &str,
        security: &Security,
    ) -> Result<(), String> {
        let host = address.rsplit_once(':').map_or(address, |(host, _)| host);
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let name = ServerName::try_from(host.to_owned()).map_err(|cause| cause.to_string())?;
        let config = Arc::new(config(security).ok_or("no keys that can be read")?);
        let client = ClientConnection::new(config, name).map_err(|cause| cause.to_string())?;
        let set = stream.set_read_timeout(Some(STEP));
        set.map_err(|cause| cause.to_string())?;
        match StreamOwned::new(client, stream).read(&mut [0]) {
            // A router that has accepted the connection waits for the client's first message.
            Err(cause) if matches!(cause.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                Ok(())
            }
            Err(cause) => Err(cause.to_string()),
            Ok(_) => Err("the router closes the connection".into()),
        }
    }

    fn config(security: &Security) -> Option<ClientConfig> {
        let files = &security.keys()?.files;
        let mut roots = RootCertStore::empty();
        roots
            .add(CertificateDer::from_pem_file(files.authority()).ok()?)
            .ok()?;
        let certificate = CertificateDer::from_pem_file(files.certificate()).ok()?;
        let key = PrivateKeyDer::from_pem_file(files.private_key()).ok()?;
        ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .ok()?
            .with_root_certificates(roots)
            .with_client_auth_cert(vec![certificate], key)
            .ok()
    }
}

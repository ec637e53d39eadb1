//! Protection of the page according to the node's `[security]`: tokens once a profile protects an address, TLS once
//! other machines reach one.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, anyhow, bail};
use sextant_zenoh_bus::{NodeKeys, Profile, Role, Security};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};

use crate::access::{PageAccess, PageRole, Tokens};
use crate::certificate::{self, outward};
use crate::config::ViewerConfig;

/// Protection of the network and the page.
pub struct Protection {
    /// Protection of the network.
    pub network: Security,
    pub(crate) access: PageAccess,
    /// None: plain HTTP.
    pub(crate) tls: Option<TlsAcceptor>,
}

impl Protection {
    /// Reads the keys of a bridge; `folder` is that of its configuration file.
    ///
    /// # Errors
    /// Keys and addresses that do not fit the profile.
    pub fn load(config: &ViewerConfig, folder: &Path) -> anyhow::Result<Self> {
        let Admission {
            network,
            access,
            is_secure,
        } = Admission::load(config, folder)?;
        let tls = match network.keys() {
            _ if !is_secure => None,
            Some(keys) => Some(tls(keys)?),
            None => Some(own_tls(config, folder)?),
        };
        Ok(Self {
            network,
            access,
            tls,
        })
    }
}

/// Who may use the page, without the secrets of its TLS.
pub(crate) struct Admission {
    pub(crate) network: Security,
    pub(crate) access: PageAccess,
    /// Whether the page is served by TLS.
    pub(crate) is_secure: bool,
}

impl Admission {
    /// As [`Protection::load`]. Writes nothing.
    ///
    /// # Errors
    /// As [`Protection::load`].
    pub(crate) fn load(config: &ViewerConfig, folder: &Path) -> anyhow::Result<Self> {
        let network = config.network_protection(folder)?;
        let is_local = config.listen.ip().to_canonical().is_loopback();
        let (access, is_secure) = match network.keys() {
            Some(keys) => (by_token(keys, is_local)?, !is_local),
            None if is_local || network.profile() == Profile::Open => {
                (PageAccess::open(), config.https)
            }
            None => bail!(
                "listen = \"{}\": other machines reach the page there, and with [security] \
                 profile \"demo\" everybody may change the site: choose profile = \"site\" or \
                 \"lab\" with keys (docs/security-setup.md), an address of 127.0.0.1, or profile \
                 = \"open\" to let everybody in knowingly",
                config.listen
            ),
        };
        Ok(Self {
            network,
            access,
            is_secure,
        })
    }
}

fn by_token(keys: &NodeKeys, is_local: bool) -> anyhow::Result<PageAccess> {
    let tokens = Tokens::read(&keys.files.page_tokens())?.with_phones(&keys.files.phones())?;
    let most = match keys.member.role {
        Role::Operator => PageRole::Operator,
        _ => PageRole::Viewer,
    };
    Ok(PageAccess::by_token(tokens, most, !is_local))
}

fn tls(keys: &NodeKeys) -> anyhow::Result<TlsAcceptor> {
    let (certificate, key) = (keys.files.page_certificate(), keys.files.page_private_key());
    let chain = CertificateDer::pem_file_iter(&certificate)
        .and_then(Iterator::collect)
        .map_err(|cause| anyhow!("{}: {cause}", certificate.display()))?;
    let private = PrivateKeyDer::from_pem_file(&key)
        .map_err(|cause| anyhow!("{}: {cause}", key.display()))?;
    acceptor(chain, private)
        .with_context(|| format!("{}: the page's certificate", certificate.display()))
}

/// By a certificate of the bridge's own.
fn own_tls(config: &ViewerConfig, folder: &Path) -> anyhow::Result<TlsAcceptor> {
    let kept = config.folder.as_ref().map(|kept| folder.join(kept));
    let mut names = config.host_names.clone();
    let address = config.listen.ip();
    names.push(match address.is_unspecified() {
        true => outward().to_string(),
        false => address.to_string(),
    });
    let own = certificate::own(kept.as_deref(), &names)?;
    let chain: Result<_, _> = CertificateDer::pem_slice_iter(own.certificate.as_bytes()).collect();
    let private = PrivateKeyDer::from_pem_slice(own.key.as_bytes())?;
    acceptor(chain?, private).context("page.pem and page.key of `folder`")
}

fn acceptor(
    chain: Vec<CertificateDer<'static>>,
    private: PrivateKeyDer<'static>,
) -> anyhow::Result<TlsAcceptor> {
    let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .and_then(|builder| {
            builder
                .with_no_client_auth()
                .with_single_cert(chain, private)
        })?;
    Ok(TlsAcceptor::from(Arc::new(config)))
}

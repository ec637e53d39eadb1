//! X.509 certificates (RFC 5280), ECDSA on P-256: that of the authority, and those that it signs.
//!
//! Certificates are valid from the start of 2018: boards without a battery-backed clock begin there after each start
//! and could not connect otherwise before their clock is set. Only the end of validity protects.

use crate::KeysError;
use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, KeyPair,
    KeyUsagePurpose, date_time_ymd,
};
use sextant_proto::SiteId;
use sextant_zenoh_bus::Member;
use time::OffsetDateTime;

/// A key and its certificate, PEM.
pub struct Made {
    /// Secret.
    pub key: String,
    /// Not secret.
    pub certificate: String,
}

/// A certificate for the authority, signed by itself.
///
/// # Errors
/// A system without a source of random numbers.
pub fn authority(site: &SiteId, valid_until_s: u64) -> Result<Made, KeysError> {
    let key = KeyPair::generate().map_err(KeysError::certificate("a key pair"))?;
    let mut params = authority_params(site.as_str())?;
    params.not_after = time_of(valid_until_s)?;
    let certificate = params
        .self_signed(&key)
        .map_err(KeysError::certificate("a certificate"))?;
    Ok(Made {
        key: key.serialize_pem(),
        certificate: certificate.pem(),
    })
}

fn authority_params(site: &str) -> Result<CertificateParams, KeysError> {
    let mut params = params(&format!("authority of sextant site {site}"), &[])?;
    params.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::CrlSign];
    Ok(params)
}

fn params(common_name: &str, hosts: &[String]) -> Result<CertificateParams, KeysError> {
    let mut params = CertificateParams::new(hosts.to_vec()).map_err(KeysError::certificate(
        format!("--host: none of {hosts:?} may be other than a name or an address"),
    ))?;
    params.distinguished_name = rcgen::DistinguishedName::new();
    params
        .distinguished_name
        .push(DnType::CommonName, common_name);
    params.not_before = date_time_ymd(2018, 1, 1);
    Ok(params)
}

/// Subject and purpose of a certificate.
pub struct Subject<'a> {
    common_name: String,
    valid_until_s: u64,
    hosts: &'a [String],
    usages: Vec<ExtendedKeyUsagePurpose>,
}

impl<'a> Subject<'a> {
    /// A member on the site's network. Only some roles may be a router, so that no camera can pose as one.
    pub fn node(member: &Member, hosts: &'a [String]) -> Self {
        let is_router = member.role.can_be_router();
        let mut usages = vec![ExtendedKeyUsagePurpose::ClientAuth];
        usages.extend(is_router.then_some(ExtendedKeyUsagePurpose::ServerAuth));
        Self {
            common_name: member.common_name.clone(),
            valid_until_s: member.valid_until_s,
            hosts: if is_router { hosts } else { &[] },
            usages,
        }
    }

    /// The page of a member, for browsers.
    pub fn page(member: &Member, hosts: &'a [String]) -> Self {
        Self {
            common_name: format!("page of {}", member.common_name),
            valid_until_s: member.valid_until_s,
            hosts,
            usages: vec![ExtendedKeyUsagePurpose::ServerAuth],
        }
    }
}

/// Signs certificates for the authority.
pub struct Issuer(rcgen::Issuer<'static, KeyPair>);

impl Issuer {
    /// The authority of a site, from its private key.
    ///
    /// # Errors
    /// An invalid key.
    pub fn new(site: &str, key: &str) -> Result<Self, KeysError> {
        let key = KeyPair::from_pem(key).map_err(KeysError::certificate("authority.key"))?;
        Ok(Self(rcgen::Issuer::new(authority_params(site)?, key)))
    }

    /// Creates a key and its certificate.
    ///
    /// # Errors
    /// A host that is neither a name nor an address.
    pub fn sign(&self, subject: &Subject<'_>) -> Result<Made, KeysError> {
        let key = KeyPair::generate().map_err(KeysError::certificate("a key pair"))?;
        let mut params = params(&subject.common_name, subject.hosts)?;
        params.not_after = time_of(subject.valid_until_s)?;
        params.key_usages = vec![KeyUsagePurpose::DigitalSignature];
        params.extended_key_usages = subject.usages.clone();
        params.use_authority_key_identifier_extension = true;
        let certificate = params
            .signed_by(&key, &self.0)
            .map_err(KeysError::certificate("a certificate"))?;
        Ok(Made {
            key: key.serialize_pem(),
            certificate: certificate.pem(),
        })
    }
}

fn time_of(seconds: u64) -> Result<OffsetDateTime, KeysError> {
    let seconds = i64::try_from(seconds).map_err(|_| KeysError::Time)?;
    OffsetDateTime::from_unix_timestamp(seconds).map_err(|_| KeysError::Time)
}

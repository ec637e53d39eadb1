//! A certificate that this bridge makes for itself, for pages without keys of a site: browsers warn of it once, and
//! give cameras to such pages.

use anyhow::{Context, anyhow};
use rcgen::{CertifiedKey, KeyPair, generate_simple_self_signed};
use sextant_process::host::host_name;
use sextant_site_files::write_atomically;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::net::{IpAddr, UdpSocket};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use tokio_rustls::rustls::client::verify_server_name;
use tokio_rustls::rustls::pki_types::pem::PemObject;
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::server::ParsedCertificate;

/// Its name in the folder of the bridge.
pub(crate) const FILE: &str = "page.pem";

/// Certificate and secret key, PEM.
pub(crate) struct Certificate {
    pub(crate) certificate: String,
    pub(crate) key: String,
}

/// The certificate kept in a folder, made where there is none that has these names; without a folder a new one, which
/// browsers warn of after each start.
///
/// # Errors
/// A folder that cannot be read or written, or names that no certificate can have.
pub(crate) fn own(folder: Option<&Path>, names: &[String]) -> anyhow::Result<Certificate> {
    let names = all_names(names);
    let Some(folder) = folder else {
        return made(names);
    };
    let [certificate, key] = [FILE, "page.key"].map(|name| folder.join(name));
    if certificate.exists() && key.exists() {
        let read = |file: &Path| {
            fs::read_to_string(file).with_context(|| format!("{}: cannot be read", file.display()))
        };
        let kept = Certificate {
            certificate: read(&certificate)?,
            key: read(&key)?,
        };
        if first_missing(&kept.certificate, &names).is_none() {
            return Ok(kept);
        }
    }
    let made = made(names)?;
    let failed = |file: &Path| format!("{}: cannot be written", file.display());
    fs::create_dir_all(folder).with_context(|| failed(folder))?;
    write_secret(&key, &made.key).with_context(|| failed(&key))?;
    write_atomically(&certificate, made.certificate.as_bytes())?;
    Ok(made)
}

/// The first of these names that a certificate in PEM does not have; all are missing from one that cannot be read. What
/// is no name of a server is in no certificate.
pub(crate) fn first_missing<'a>(certificate: &str, names: &'a [String]) -> Option<&'a String> {
    let der = CertificateDer::from_pem_slice(certificate.as_bytes()).ok();
    let parsed = der.as_ref().map(ParsedCertificate::try_from);
    names.iter().find(|name| {
        let Ok(server) = ServerName::try_from(name.as_str()) else {
            return false;
        };
        let has_it = |parsed: &ParsedCertificate<'_>| verify_server_name(parsed, &server).is_ok();
        !matches!(&parsed, Some(Ok(parsed)) if has_it(parsed))
    })
}

/// This machine's address on its network: the one from which it would send elsewhere. Nothing is sent.
pub(crate) fn outward() -> IpAddr {
    const ANYWHERE: &str = "192.0.2.1:9";
    let socket = UdpSocket::bind("0.0.0.0:0").and_then(|socket| {
        socket.connect(ANYWHERE)?;
        socket.local_addr()
    });
    socket.map_or(IpAddr::from([127, 0, 0, 1]), |address| address.ip())
}

/// These names and this machine's own.
fn all_names(names: &[String]) -> Vec<String> {
    let own = [
        host_name(),
        "localhost".to_owned(),
        "127.0.0.1".to_owned(),
        "::1".to_owned(),
    ];
    names.iter().cloned().chain(own).collect()
}

fn made(names: Vec<String>) -> anyhow::Result<Certificate> {
    let CertifiedKey { cert, signing_key } = generate_simple_self_signed(names)
        .map_err(|cause| anyhow!("host_names are no names of a certificate: {cause}"))?;
    Ok(Certificate {
        certificate: cert.pem(),
        key: KeyPair::serialize_pem(&signing_key),
    })
}

fn write_secret(file: &Path, text: &str) -> std::io::Result<()> {
    let mut options = OpenOptions::new();
    let mut file = options
        .write(true)
        .create(true)
        .truncate(true)
        .mode(0o600)
        .open(file)?;
    file.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    fn names(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn a_new_name_gets_a_new_certificate_and_a_missing_one_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let made = |of: &[&str]| own(Some(folder.path()), &names(of)).unwrap().certificate;
        let first = made(&["viewer.lab", "192.168.1.5"]);
        assert_eq!(made(&["viewer.lab"]), first);
        let second = made(&["viewer.lab", "192.168.1.6"]);
        assert_ne!(second, first);
        assert_eq!(
            first_missing(&second, &names(&["localhost", "192.168.1.6"])),
            None
        );
        assert_eq!(
            first_missing(&second, &names(&["192.168.1.5"])),
            Some(&"192.168.1.5".to_owned())
        );
    }

    #[test]
    fn a_certificate_is_made_once_and_its_key_is_secret() {
        let folder = tempfile::tempdir().unwrap();
        let names = names(&["192.168.1.5", "viewer.lab"]);
        let first = own(Some(folder.path()), &names).unwrap();
        let again = own(Some(folder.path()), &names).unwrap();
        assert_eq!(first.certificate, again.certificate);
        let key = fs::metadata(folder.path().join("page.key")).unwrap();
        assert_eq!(key.permissions().mode() & 0o777, 0o600);
        assert_ne!(own(None, &names).unwrap().certificate, first.certificate);
    }
}

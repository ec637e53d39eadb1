//! A certificate that this bridge makes for itself, for pages without keys of a site: browsers warn of it once, and give cameras to such pages.

use anyhow::{Context, anyhow};
use rcgen::{CertifiedKey, KeyPair, generate_simple_self_signed};
use sextant_process::host::host_name;
use sextant_site_files::write_atomically;
use std::fs::{self, OpenOptions};
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Certificate and secret key, PEM.
pub(crate) struct Certificate {
    pub(crate) certificate: String,
    pub(crate) key: String,
}

/// The certificate kept in a folder, made where there is none; without a folder a new one, which browsers warn of after each start.
///
/// # Errors
/// A folder that cannot be read or written, or names that no certificate can have.
pub(crate) fn own(folder: Option<&Path>, names: &[String]) -> anyhow::Result<Certificate> {
    let Some(folder) = folder else {
        return made(names);
    };
    let [certificate, key] = ["page.pem", "page.key"].map(|name| folder.join(name));
    if certificate.exists() && key.exists() {
        let read = |file: &Path| {
            fs::read_to_string(file).with_context(|| format!("{}: cannot be read", file.display()))
        };
        return Ok(Certificate {
            certificate: read(&certificate)?,
            key: read(&key)?,
        });
    }
    let made = made(names)?;
    let failed = |file: &Path| format!("{}: cannot be written", file.display());
    fs::create_dir_all(folder).with_context(|| failed(folder))?;
    write_secret(&key, &made.key).with_context(|| failed(&key))?;
    write_atomically(&certificate, made.certificate.as_bytes())?;
    Ok(made)
}

fn made(names: &[String]) -> anyhow::Result<Certificate> {
    let own = [
        host_name(),
        "localhost".to_owned(),
        "127.0.0.1".to_owned(),
        "::1".to_owned(),
    ];
    let names: Vec<String> = names.iter().cloned().chain(own).collect();
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

    #[test]
    fn a_certificate_is_made_once_and_its_key_is_secret() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["192.168.1.5".to_owned(), "viewer.lab".to_owned()];
        let first = own(Some(folder.path()), &names).unwrap();
        let again = own(Some(folder.path()), &names).unwrap();
        assert_eq!(first.certificate, again.certificate);
        let key = fs::metadata(folder.path().join("page.key")).unwrap();
        assert_eq!(key.permissions().mode() & 0o777, 0o600);
        assert_ne!(own(None, &names).unwrap().certificate, first.certificate);
    }
}

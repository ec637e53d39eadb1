//! Zenoh's settings for a profile.

use std::path::Path;

use serde_json::json;
use sextant_proto::Keys;

use super::access::{Proof, access_control};
use super::{Members, NodeKeys, Profile, Security, endpoints};
use crate::compiled::segments;
use crate::{BusError, BusOptions, SecurityError};

/// Sections of zenoh's configuration that a profile sets.
const SET_BY_PROFILE: [&str; 5] = [
    "access_control",
    "connect/endpoints",
    "listen/endpoints",
    "transport/auth",
    "transport/link/tls",
];

/// Refuses overrides that would silently weaken the profile.
pub(crate) fn check_overrides(options: &BusOptions, security: &Security) -> Result<(), BusError> {
    if !matches!(security.profile, Profile::Lab | Profile::Site) {
        return Ok(());
    }
    let set_by_profile = |key: &&String| {
        let (path, mut sections) = (segments(key), SET_BY_PROFILE.iter());
        sections.any(|section| {
            let section = segments(section);
            path.starts_with(&section) || section.starts_with(&path)
        })
    };
    match options.overrides.keys().find(set_by_profile) {
        None => Ok(()),
        Some(key) => Err(BusError::Override {
            key: key.clone(),
            cause: format!(
                "[security] profile \"{}\" sets this; remove the override, or write profile = \
                 \"open\" and set everything by hand",
                security.profile.name()
            ),
        }),
    }
}

/// The settings, path and JSON value, of a process that listens on `listen`.
///
/// # Errors
/// Endpoints and keys that do not fit the profile.
pub(crate) fn settings(
    security: &Security,
    network: &BusOptions,
    listen: &[String],
) -> Result<Vec<(&'static str, String)>, SecurityError> {
    endpoints::check(security.profile, network, listen)?;
    let Some(keys) = &security.keys else {
        return Ok(Vec::new());
    };
    let is_router = !listen.is_empty();
    let (mut settings, proof) = match security.profile {
        Profile::Demo | Profile::Open => return Ok(Vec::new()),
        Profile::Lab => (user_name(keys, is_router)?, Proof::UserName),
        Profile::Site => (certificates(keys), Proof::CertificateName),
    };
    if is_router {
        let members = members(keys)?;
        let rules = access_control(
            &Keys::for_site(keys.site.clone()),
            members.accepted(),
            proof,
        );
        settings.push(("access_control", rules.to_string()));
    }
    Ok(settings)
}

fn members(keys: &NodeKeys) -> Result<&Members, SecurityError> {
    keys.members
        .as_ref()
        .ok_or_else(|| SecurityError::NotARouter {
            path: keys.files.folder().to_owned(),
        })
}

fn user_name(
    keys: &NodeKeys,
    is_router: bool,
) -> Result<Vec<(&'static str, String)>, SecurityError> {
    let passwords = is_router.then(|| keys.files.passwords());
    // As one object: zenoh refuses a user without a password, and a password without a user.
    let section = json!({
        "user": keys.member.common_name,
        "password": keys.password()?,
        "dictionary_file": passwords.map(|file| file.to_string_lossy().into_owned()),
    });
    Ok(vec![("transport/auth/usrpwd", section.to_string())])
}

fn certificates(keys: &NodeKeys) -> Vec<(&'static str, String)> {
    let files = &keys.files;
    let (certificate, key) = (path(&files.certificate()), path(&files.private_key()));
    vec![
        ("transport/link/tls/enable_mtls", "true".into()),
        (
            "transport/link/tls/root_ca_certificate",
            path(&files.authority()),
        ),
        ("transport/link/tls/listen_certificate", certificate.clone()),
        ("transport/link/tls/listen_private_key", key.clone()),
        ("transport/link/tls/connect_certificate", certificate),
        ("transport/link/tls/connect_private_key", key),
        // Zenoh also trusts the public web authorities for a router's certificate; only the name excludes certificates
        // of their customers.
        ("transport/link/tls/verify_name_on_connect", "true".into()),
        ("transport/link/tls/close_link_on_expiration", "true".into()),
    ]
}

fn path(path: &Path) -> String {
    json!(path.to_string_lossy()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_beside_the_profile_weakens_it() {
        let security = Security {
            profile: Profile::Site,
            keys: None,
        };
        for key in [
            "access_control/enabled",
            "/access_control",
            "transport//auth/usrpwd",
            "transport/link/tls/enable_mtls",
            "listen/endpoints",
            "connect",
        ] {
            let mut options = BusOptions::default();
            options.overrides.insert(key.into(), "false".into());
            let words = check_overrides(&options, &security)
                .unwrap_err()
                .to_string();
            assert!(words.contains(key) && words.contains("open"), "{words}");
            assert!(check_overrides(&options, &Security::none(Profile::Open)).is_ok());
        }
    }
}

//! Settings without code in this build of zenoh. Zenoh accepts and ignores them: a router with users and
//! passwords in its configuration would be open to everyone. Such settings are refused with the reason.
//!
//! The tables follow the features of zenoh in the workspace's `Cargo.toml`; with a new feature its lines go.

use crate::{BusError, BusOptions};
use serde_json::Value;

/// The protocols of endpoints that are compiled in (`transport_tcp`, `transport_quic`).
const PROTOCOLS: &[&str] = if cfg!(feature = "quic") {
    &["tcp", "quic"]
} else {
    &["tcp"]
};

/// Sections of zenoh's configuration without code, and the features that would add it.
const ABSENT: &[(&str, &str)] = &[
    ("transport/auth/pubkey", "auth_pubkey"),
    ("transport/link/unixpipe", "transport_unixpipe"),
    ("transport/shared_memory", "shared-memory"),
    ("transport/unicast/compression", "transport_compression"),
    ("transport/unicast/max_links", "transport_multilink"),
    ("transport/multicast", "transport_udp"),
    ("plugins", "plugins"),
    ("plugins_loading", "plugins"),
    ("stats", "stats"),
];

/// The same, of QUIC, whose certificates are in the section `tls`.
const QUIC: (&str, &str) = ("transport/link/tls", "transport_quic");

fn absent() -> impl Iterator<Item = &'static (&'static str, &'static str)> {
    let quic = (!cfg!(feature = "quic")).then_some(&QUIC);
    ABSENT.iter().chain(quic)
}

/// Refuses overrides of sections without code, and of sections around them, which would silently replace fixed options.
pub(crate) fn check_overrides(options: &BusOptions) -> Result<(), BusError> {
    for key in options.overrides.keys() {
        let path = segments(key);
        for (section, feature) in absent() {
            let absent = segments(section);
            if path.starts_with(&absent) {
                return Err(not_compiled_in(key, feature));
            }
            if absent.starts_with(&path) {
                return Err(BusError::Override {
                    key: key.clone(),
                    cause: "it would replace a whole section; give each setting by its full path"
                        .into(),
                });
            }
        }
    }
    Ok(())
}

/// Refuses endpoints of other protocols and rules that can never apply, wherever they are set.
pub(crate) fn check_values(config: &zenoh::Config) -> Result<(), BusError> {
    for key in ["connect/endpoints", "listen/endpoints"] {
        for text in texts(&value(config, key)) {
            // Besides endpoints, there are keywords for choosing among several.
            if let Some((protocol, _)) = text.split_once('/') {
                check_protocol(key, &text, protocol)?;
            }
            if key == "connect/endpoints" && text.starts_with("quic/[") {
                return Err(BusError::Option {
                    key: key.to_owned(),
                    value: text,
                    cause: "zenoh checks no certificate against an IPv6 address; write the \
                        router's name, which `sextant keys add --host NAME` puts into its certificate".into(),
                });
            }
        }
    }
    for key in ["transport/link/protocols", "access_control/subjects"] {
        let found = value(config, key);
        let protocols = match key {
            "access_control/subjects" => members(&found, "link_protocols"),
            _ => texts(&found),
        };
        for protocol in protocols {
            check_protocol(key, &protocol, &protocol)?;
        }
    }
    let subjects = value(config, "access_control/subjects");
    if !cfg!(feature = "quic") && !members(&subjects, "cert_common_names").is_empty() {
        let key = "access_control/subjects/cert_common_names";
        return Err(not_compiled_in(key, QUIC.1));
    }
    Ok(())
}

/// The endpoints of a finished configuration, without keywords for choosing among several.
pub(crate) fn endpoints(config: &zenoh::Config, key: &str) -> Vec<String> {
    let mut endpoints = texts(&value(config, key));
    endpoints.retain(|text| text.contains('/'));
    endpoints
}

fn check_protocol(key: &str, whole: &str, protocol: &str) -> Result<(), BusError> {
    if PROTOCOLS.contains(&protocol) {
        return Ok(());
    }
    let cause = match protocol {
        "tls" if cfg!(feature = "quic") => {
            "zenoh's links over TLS can crash the process (zenoh 2557) and are left out; write \
             quic/..., by the same certificates over UDP"
                .to_owned()
        }
        _ => format!(
            "this program is built without zenoh's protocol \"{protocol}\"; it speaks {} only",
            PROTOCOLS.join(" and ")
        ),
    };
    Err(BusError::Option {
        key: key.to_owned(),
        value: whole.to_owned(),
        cause,
    })
}

fn not_compiled_in(key: &str, feature: &str) -> BusError {
    BusError::Override {
        key: key.to_owned(),
        cause: format!(
            "this program is built without zenoh's feature {feature}, so that the setting would \
             have no effect; remove it"
        ),
    }
}

/// Normalises a path of zenoh's configuration, in which several slashes count as one.
pub(crate) fn segments(path: &str) -> Vec<&str> {
    path.split('/').filter(|part| !part.is_empty()).collect()
}

fn value(config: &zenoh::Config, key: &str) -> Value {
    let json = config.get_json(key).unwrap_or_default();
    serde_json::from_str(&json).unwrap_or_default()
}

/// Every string of a list, or of the lists of a value that differs by mode.
fn texts(value: &Value) -> Vec<String> {
    match value {
        Value::String(text) => vec![text.clone()],
        Value::Array(items) => items.iter().flat_map(texts).collect(),
        Value::Object(items) => items.values().flat_map(texts).collect(),
        _ => Vec::new(),
    }
}

fn members(subjects: &Value, property: &str) -> Vec<String> {
    let subjects = subjects.as_array().into_iter().flatten();
    subjects
        .flat_map(|subject| texts(&subject[property]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mode;

    /// The reason why a router with this override does not start.
    fn refusal(key: &str, value: &str) -> Option<String> {
        let mut options = BusOptions::router_on("tcp/127.0.0.1:7447");
        options.overrides.insert(key.into(), value.into());
        options.check().err().map(|error| error.to_string())
    }

    #[test]
    fn what_is_absent_is_refused_with_the_feature_that_is_missing() {
        for (key, value, feature) in [
            (
                "/transport//auth/pubkey/public_key_file",
                "\"key\"",
                "auth_pubkey",
            ),
            (
                "transport/unicast/compression/enabled",
                "true",
                "transport_compression",
            ),
            ("transport/shared_memory/enabled", "true", "shared-memory"),
            ("plugins/storage_manager", "{}", "plugins"),
        ] {
            let words = refusal(key, value).unwrap_or_else(|| panic!("{key} is accepted"));
            assert!(words.contains(feature) && words.contains(key), "{words}");
        }
    }

    #[test]
    fn a_refusal_does_not_print_the_secret() {
        let words = refusal("transport/auth/pubkey/private_key_pem", "\"secret\"").unwrap();
        assert!(!words.contains("secret"), "{words}");
    }

    #[test]
    fn a_section_around_absent_code_cannot_be_replaced() {
        for key in [
            "",
            "/",
            "transport",
            "transport/auth",
            "transport/link",
            "transport/unicast",
        ] {
            let words = refusal(key, "{}").unwrap_or_else(|| panic!("{key:?} is accepted"));
            assert!(words.contains("full path"), "{words}");
        }
    }

    #[test]
    fn endpoints_of_other_protocols_are_refused_wherever_they_stand() {
        for protocol in [
            "udp",
            "ws",
            "unixsock-stream",
            "unixpipe",
            "vsock",
            "serial",
        ] {
            let endpoint = format!("{protocol}/127.0.0.1:7447");
            for options in [
                BusOptions::client_of(&endpoint),
                BusOptions::router_on(&endpoint),
            ] {
                let error = options.check().unwrap_err().to_string();
                assert!(error.contains(&format!("\"{protocol}\"")), "{error}");
            }
            for (key, value) in [
                ("listen/endpoints", format!("[\"{endpoint}\"]")),
                ("connect/endpoints", format!("{{router: [\"{endpoint}\"]}}")),
                (
                    "connect/endpoints",
                    format!(
                        "[{{strategy: \"allOf\", locators: [\"tcp/127.0.0.1:1\", \"{endpoint}\"]}}]"
                    ),
                ),
                ("transport/link/protocols", format!("[\"{protocol}\"]")),
            ] {
                let words = refusal(key, &value).unwrap_or_else(|| panic!("{key} = {value}"));
                assert!(words.contains(&format!("\"{protocol}\"")), "{words}");
            }
        }
    }

    #[test]
    fn links_that_cannot_be_protected_are_refused_with_the_remedy() {
        for (key, endpoint, remedy) in [
            ("listen/endpoints", "tls/127.0.0.1:7447", "write quic/"),
            ("connect/endpoints", "tls/fusion.lab:7447", "write quic/"),
            ("connect/endpoints", "quic/[::1]:7447", "the router's name"),
        ] {
            let words = refusal(key, &format!("[\"{endpoint}\"]")).unwrap();
            assert!(
                words.contains(remedy) && words.contains(endpoint),
                "{words}"
            );
        }
        assert_eq!(refusal("listen/endpoints", "[\"quic/[::]:7447\"]"), None);
    }

    #[test]
    fn rules_for_links_that_cannot_be_are_refused() {
        let subjects = |property: &str| format!("[{{id: \"a\", {property}}}]");
        let words = refusal(
            "access_control/subjects",
            &subjects("link_protocols: [\"udp\"]"),
        );
        assert!(words.unwrap().contains("\"udp\""));
        for possible in ["interfaces: [\"lo\"]", "usernames: [\"a\"]"] {
            assert_eq!(
                refusal("access_control/subjects", &subjects(possible)),
                None
            );
        }
    }

    #[test]
    fn what_is_compiled_in_is_taken() {
        for (key, value) in [
            ("transport/link/tcp/so_sndbuf", "65000"),
            ("transport/link/protocols", "[\"tcp\"]"),
            ("listen/endpoints", "[\"tcp/127.0.0.1:7448\"]"),
            (
                "connect/endpoints",
                "[{strategy: \"allOf\", locators: [\"tcp/127.0.0.1:1\"]}]",
            ),
            ("access_control/enabled", "false"),
        ] {
            assert_eq!(refusal(key, value), None, "{key}");
        }
        for mode in [Mode::Client, Mode::Peer, Mode::Router] {
            BusOptions {
                mode,
                ..BusOptions::default()
            }
            .check()
            .unwrap();
        }
    }
}

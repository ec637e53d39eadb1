//! Zenoh's configuration for our options. Every option that changes behaviour is set here, since zenoh's defaults
//! differ between its releases.

use std::path::Path;

use crate::compiled::{check_overrides, check_values, endpoints};
use crate::security::{self, Identity, Security, SecurityOptions};
use crate::{BusError, BusOptions, Mode, Profile};

/// Batch size of a link's queues in bytes (zenoh: 65535). A preview of 100 kB is four batches; every priority in use
/// owns `queue size` of them, which is most of the memory of a link.
const BATCH_BYTES: u32 = 32 * 1024;

/// Batches of observations and poses that wait on a link of a client, which sends those of one node.
const CLIENT_BATCHES: u32 = 2;
/// The same on a link of a router: cameras that expose together cause a burst of all their observations and of the
/// poses of all objects, each a batch of its own, and what finds no room within a millisecond is dropped. Zenoh's
/// maximum.
const ROUTER_BATCHES: u32 = 16;

/// Zenoh's configuration for `options`, protected by `security`, listening on `listen` (ports resolved).
pub(crate) fn zenoh_config(
    options: &BusOptions,
    security: &Security,
    listen: &[String],
) -> Result<zenoh::Config, BusError> {
    check_ranges(options)?;
    check_overrides(options)?;
    security::check_overrides(options, security)?;
    let protection = security::settings(security, options, listen)?;
    let mut config = zenoh::Config::default();
    let fixed = topology(options, security.profile(), listen)
        .into_iter()
        .chain(transport(options))
        .chain(protection);
    let overrides = options
        .overrides
        .iter()
        .map(|(key, value)| (key.as_str(), value.clone()));
    for (key, value) in fixed.chain(overrides) {
        let inserted = config.insert_json5(key, &value);
        inserted.map_err(|cause| refusal(key, &value, &cause.to_string()))?;
    }
    check_values(&config)?;
    // Whatever the overrides made of them.
    let [connect, listen] =
        ["connect/endpoints", "listen/endpoints"].map(|key| endpoints(&config, key));
    security::check_all(security.profile(), &connect, &listen)?;
    Ok(config)
}

impl SecurityOptions {
    /// Reads the keys and checks that `network` goes with the profile; `folder` is that of the configuration file.
    ///
    /// # Errors
    /// Keys that are missing, unreadable, readable for others, or of another node; endpoints that do not go with the
    /// profile; and what [`BusOptions::check`] refuses.
    pub fn load(
        &self,
        folder: &Path,
        identity: Identity<'_>,
        network: &BusOptions,
    ) -> Result<Security, BusError> {
        let security = self.load_keys(folder, identity)?;
        zenoh_config(network, &security, &network.listen)?;
        Ok(security)
    }
}

impl BusOptions {
    /// The configuration file of zenohd (JSON5) that makes it this router.
    ///
    /// # Errors
    /// The first invalid option.
    pub fn zenohd_config(&self, security: &Security) -> Result<String, BusError> {
        Ok(zenoh_config(self, security, &self.listen)?.to_string())
    }

    /// Checks that the options are in range, known to zenoh and implemented in this build, whatever their protection:
    /// [`crate::SecurityOptions::load`] checks further.
    ///
    /// # Errors
    /// The first invalid option.
    pub fn check(&self) -> Result<(), BusError> {
        zenoh_config(self, &Security::none(Profile::Open), &self.listen).map(drop)
    }
}

fn topology(
    options: &BusOptions,
    profile: Profile,
    listen: &[String],
) -> Vec<(&'static str, String)> {
    vec![
        ("mode", quoted(options.mode.name())),
        (
            "connect/endpoints",
            list(&options.connect_endpoints(profile)),
        ),
        // A client waits for its router without limit (`Bus::open` abandons it when asked to); others connect in the
        // background.
        ("connect/timeout_ms", "-1".into()),
        ("connect/exit_on_failure", "false".into()),
        (
            "connect/retry",
            "{ period_init_ms: 100, period_max_ms: 1000, period_increase_factor: 2 }".into(),
        ),
        (
            "listen/endpoints",
            list(&listen.iter().map(|one| in_order(one)).collect::<Vec<_>>()),
        ),
        ("listen/timeout_ms", "0".into()),
        ("listen/exit_on_failure", "true".into()),
        ("open/return_conditions/connect_scouted", "true".into()),
        ("open/return_conditions/declares", "true".into()),
        ("scouting/multicast/enabled", "false".into()),
        ("scouting/gossip/enabled", "false".into()),
        // How long a peer waits for its listed peers while opening; a router would wait without need.
        (
            "scouting/delay",
            if options.mode == Mode::Peer {
                "500"
            } else {
                "0"
            }
            .into(),
        ),
        // Capture times travel in the messages; zenoh's own timestamps would reject those of a host whose clock is
        // ahead.
        ("timestamping/enabled", "false".into()),
        (
            "queries_default_timeout",
            options.query_timeout_ms.to_string(),
        ),
        ("routing/interests/timeout", "2000".into()),
        ("adminspace/enabled", "false".into()),
        // zenohd turns it on whatever the configuration says.
        ("adminspace/permissions/read", "false".into()),
        ("adminspace/permissions/write", "false".into()),
    ]
}

/// A listening endpoint whose links keep the order of messages. By default zenoh opens a QUIC stream for each priority,
/// and data may overtake the declaration of its key, upon which it is dropped.
fn in_order(endpoint: &str) -> String {
    if !endpoint.starts_with("quic/") || endpoint.contains("multistream=") {
        return endpoint.to_owned();
    }
    let (address, config) = endpoint.split_at(endpoint.find('#').unwrap_or(endpoint.len()));
    let separator = if address.contains('?') { ';' } else { '?' };
    format!("{address}{separator}multistream=0{config}")
}

fn transport(options: &BusOptions) -> Vec<(&'static str, String)> {
    vec![
        ("transport/unicast/open_timeout", "2000".into()),
        ("transport/unicast/accept_timeout", "2000".into()),
        ("transport/unicast/accept_pending", "16".into()),
        (
            "transport/unicast/max_sessions",
            options.max_links.to_string(),
        ),
        ("transport/unicast/max_links", "1".into()),
        ("transport/unicast/lowlatency", "false".into()),
        ("transport/unicast/qos/enabled", "true".into()),
        ("transport/shared_memory/enabled", "false".into()),
        ("transport/link/tx/lease", options.lease_ms.to_string()),
        ("transport/link/tx/keep_alive", "4".into()),
        ("transport/link/tx/batch_size", BATCH_BYTES.to_string()),
        ("transport/link/tx/threads", "1".into()),
        (
            "transport/link/tx/queue/size",
            format!(
                "{{ control: 1, real_time: 1, interactive_high: {}, interactive_low: 1, \
                 data_high: 1, data: 2, data_low: 1, background: 4 }}",
                if options.mode == Mode::Router {
                    ROUTER_BATCHES
                } else {
                    CLIENT_BATCHES
                }
            ),
        ),
        ("transport/link/tx/queue/allocation/mode", quoted("lazy")),
        ("transport/link/tx/queue/batching/enabled", "true".into()),
        ("transport/link/tx/queue/batching/time_limit", "1".into()),
        // Droppable messages wait in the caller's thread for at most this many microseconds; previews have their own
        // thread.
        (
            "transport/link/tx/queue/congestion_control/drop/wait_before_drop",
            "1000".into(),
        ),
        (
            "transport/link/tx/queue/congestion_control/drop/max_wait_before_drop_fragments",
            "50000".into(),
        ),
        (
            "transport/link/tx/queue/congestion_control/block/wait_before_close",
            "5000000".into(),
        ),
        ("transport/link/rx/buffer_size", "65535".into()),
        (
            "transport/link/rx/max_message_size",
            options.max_message_bytes.to_string(),
        ),
    ]
}

fn check_ranges(options: &BusOptions) -> Result<(), BusError> {
    let ranges = [
        ("lease_ms", options.lease_ms, 500, 60_000),
        ("query_timeout_ms", options.query_timeout_ms, 10, 60_000),
        (
            "max_message_bytes",
            options.max_message_bytes,
            65_536,
            1 << 30,
        ),
        ("max_links", u32::from(options.max_links), 1, 1000),
    ];
    for (key, value, least, most) in ranges {
        if !(least..=most).contains(&value) {
            return Err(option_error(
                key,
                &value.to_string(),
                &format!("must be from {least} to {most}"),
            ));
        }
    }
    Ok(())
}

/// Omits the value where it may be a secret.
fn refusal(key: &str, value: &str, cause: &str) -> BusError {
    if key.contains("auth") {
        return BusError::Override {
            key: key.to_owned(),
            cause: cause.to_owned(),
        };
    }
    option_error(key, value, cause)
}

fn option_error(key: &str, value: &str, cause: &str) -> BusError {
    BusError::Option {
        key: key.to_owned(),
        value: value.to_owned(),
        cause: cause.to_owned(),
    }
}

fn quoted(text: &str) -> String {
    format!("{text:?}")
}

fn list(endpoints: &[String]) -> String {
    format!("{endpoints:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fixed_option_is_one_that_zenoh_knows() {
        for mode in [Mode::Client, Mode::Peer, Mode::Router] {
            let options = BusOptions {
                mode,
                ..BusOptions::default()
            };
            zenoh_config(
                &options,
                &Security::default(),
                &["tcp/127.0.0.1:7447".to_owned()],
            )
            .unwrap();
        }
    }

    #[test]
    fn links_over_quic_keep_the_order_of_messages() {
        for (endpoint, expected) in [
            ("tcp/h:1", "tcp/h:1"),
            ("quic/h:1", "quic/h:1?multistream=0"),
            ("quic/h:1?prio=1#a=b", "quic/h:1?prio=1;multistream=0#a=b"),
            ("quic/h:1?multistream=1", "quic/h:1?multistream=1"),
        ] {
            assert_eq!(in_order(endpoint), expected);
        }
    }

    #[test]
    fn an_override_wins_over_the_fixed_option() {
        let mut options = BusOptions::default();
        options
            .overrides
            .insert("transport/link/tx/lease".into(), "7000".into());
        let config = zenoh_config(&options, &Security::default(), &[]).unwrap();
        assert_eq!(config.get_json("transport/link/tx/lease").unwrap(), "7000");
    }

    #[test]
    fn an_override_opens_no_door_of_a_demo() {
        let demo = Security::none(Profile::Demo);
        for (key, value) in [
            ("listen/endpoints", "[\"tcp/0.0.0.0:7661\"]"),
            ("listen", "{ endpoints: [\"tcp/0.0.0.0:7661\"] }"),
            ("listen/endpoints", "{ router: [\"tcp/0.0.0.0:7661\"] }"),
            ("/listen//endpoints", "[\"tcp/[::]:7661\"]"),
        ] {
            let mut options = BusOptions::router_on("tcp/127.0.0.1:7660");
            options.overrides.insert(key.into(), value.into());
            let opened = zenoh_config(&options, &demo, &options.listen);
            let words = opened.unwrap_err().to_string();
            assert!(words.contains("profile = \"open\""), "{words}");
        }
        let mut options = BusOptions::router_on("tcp/127.0.0.1:7660");
        let local = "[\"tcp/127.0.0.1:7661\"]";
        options
            .overrides
            .insert("listen/endpoints".into(), local.into());
        zenoh_config(&options, &demo, &options.listen).unwrap();
    }

    #[test]
    fn zenohd_keeps_its_admin_space_closed() {
        let options = BusOptions::router_on("tcp/127.0.0.1:7447");
        let text = options.zenohd_config(&Security::default()).unwrap();
        let config = zenoh::Config::from_json5(&text).unwrap();
        let permissions = config.get_json("adminspace/permissions").unwrap();
        assert_eq!(permissions, r#"{"read":false,"write":false}"#);
    }

    #[test]
    fn an_unknown_override_and_a_bad_endpoint_name_themselves() {
        let mut options = BusOptions::default();
        options
            .overrides
            .insert("transport/nonsense".into(), "1".into());
        assert!(
            zenoh_config(&options, &Security::default(), &[])
                .unwrap_err()
                .to_string()
                .contains("transport/nonsense")
        );
        let error =
            zenoh_config(&BusOptions::client_of("nowhere"), &Security::default(), &[]).unwrap_err();
        assert!(error.to_string().contains("nowhere"), "{error}");
    }

    #[test]
    fn a_value_out_of_range_is_refused() {
        let options = BusOptions {
            lease_ms: 1,
            ..BusOptions::default()
        };
        assert!(matches!(
            zenoh_config(&options, &Security::default(), &[]),
            Err(BusError::Option { .. })
        ));
    }
}

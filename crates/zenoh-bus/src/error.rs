//! Errors of the network, by who has to act.

mod security;

pub use security::SecurityError;

/// Errors of the bus.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BusError {
    /// An option that zenoh refuses.
    #[error("network option {key} = {value}: {cause}")]
    Option {
        /// The option, in zenoh's path notation.
        key: String,
        /// The refused value.
        value: String,
        /// Zenoh's reason.
        cause: String,
    },
    /// An override is refused; its value may be a secret and is not repeated.
    #[error("network override {key}: {cause}")]
    Override {
        /// The override's path.
        key: String,
        /// Cause and remedy.
        cause: String,
    },
    /// Keys or endpoints do not fit the profile of `[security]`.
    #[error(transparent)]
    Security(#[from] SecurityError),
    /// Another program listens on the port.
    #[error(
        "cannot listen on {endpoint}: the address is in use; choose another port, or end the program that holds it"
    )]
    InUse {
        /// The endpoint as configured.
        endpoint: String,
    },
    /// The address cannot be listened on for another reason.
    #[error("cannot listen on {endpoint}: {cause}")]
    Listen {
        /// The endpoint as configured.
        endpoint: String,
        /// The operating system's reason.
        cause: String,
    },
    /// The caller stopped waiting for the router.
    #[error("gave up waiting for a router at {endpoints}")]
    Abandoned {
        /// The endpoints that were tried.
        endpoints: String,
    },
    /// The session could not be opened.
    #[error("cannot open the network session: {0}")]
    Open(String),
    /// The router is connected, and zenoh's control plane is dead.
    #[error(
        "the router is connected and has answered no query for {silent_s} s; a new session is needed"
    )]
    Silent {
        /// How long, s.
        silent_s: u64,
    },
    /// Another process of the site has this node's name.
    #[error(
        "{name} runs on host {host} already: end it there, or give this one another name in its configuration"
    )]
    NameTaken {
        /// The node, as in "camera north".
        name: String,
        /// Host of the process that has the name.
        host: String,
    },
    /// A key or key expression is malformed.
    #[error("key {key:?}: {cause}")]
    Key {
        /// The key.
        key: String,
        /// Zenoh's reason.
        cause: String,
    },
    /// The session is closed, or failed for another reason.
    #[error("network: {0}")]
    Session(String),
    /// A message violates its contract.
    #[error("message for {key}: {cause}")]
    Message {
        /// The key it was meant for.
        key: String,
        /// The violation.
        cause: String,
    },
    /// The thread that opens the session could not be started.
    #[error("cannot start a thread")]
    Thread(#[source] std::io::Error),
}

impl BusError {
    pub(crate) fn of_key(key: &str, cause: &zenoh::Error) -> Self {
        Self::Key {
            key: key.to_owned(),
            cause: cause.to_string(),
        }
    }
}

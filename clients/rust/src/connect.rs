//! How a client gets into a site: router, keys, patience.

use crate::{Error, Site};
use sextant_proto::{Keys, SiteId};
use sextant_zenoh_bus::{Bus, BusError, BusOptions, Profile, Security, why_no_router};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Zenoh's section for a user name with a password.
const USER_SECTION: &str = "transport/auth/usrpwd";

/// How to connect to a site, as [`Site::options`] begins it.
#[derive(Debug, Clone)]
#[must_use]
pub struct SiteOptions {
    site: String,
    endpoints: Vec<String>,
    keys: Option<PathBuf>,
    user: Option<(String, String)>,
    timeout: Duration,
}

impl SiteOptions {
    pub(crate) fn new(site: &str) -> Self {
        Self {
            site: site.to_owned(),
            endpoints: Vec::new(),
            keys: None,
            user: None,
            timeout: Duration::from_secs(5),
        }
    }

    /// A router of the site, `tcp/<address>:<port>` or, with keys, `quic/<address>:<port>`. Of several the first that
    /// answers is used; they speak the same protocol. Default: `tcp/127.0.0.1:7447`, with keys that port by TLS.
    pub fn endpoint(mut self, endpoint: &str) -> Self {
        self.endpoints.push(endpoint.to_owned());
        self
    }

    /// The folder of keys of a protected site, as `sextant keys add` makes it for a viewer or an operator: certificates
    /// with a `quic/` endpoint, user name and password with a `tcp/` endpoint.
    pub fn keys(mut self, folder: impl AsRef<Path>) -> Self {
        self.keys = Some(folder.as_ref().to_owned());
        self
    }

    /// User name and password of a site of the profile lab, instead of a folder of keys.
    pub fn user(mut self, name: &str, password: &str) -> Self {
        self.user = Some((name.to_owned(), password.to_owned()));
        self
    }

    /// How long connecting may take, and how long to wait for a fusion node that still starts; 5 s by default.
    pub fn timeout(mut self, timeout: Duration) -> Self {
        self.timeout = timeout;
        self
    }

    /// Connects. Blocks for the timeout at most.
    ///
    /// # Errors
    /// No router in time, keys that cannot be used, or a name that no site can have.
    pub fn connect(self) -> Result<Site, Error> {
        let site = SiteId::new(&self.site).map_err(|cause| Error::Name {
            what: "site",
            name: self.site.clone(),
            cause: cause.to_string(),
        })?;
        let (options, security) = self.network()?;
        let deadline = Instant::now() + self.timeout;
        let late = || Instant::now() >= deadline;
        let bus = Bus::open_unless(&options, &security, &late).map_err(|error| match error {
            BusError::Abandoned { endpoints } => Error::NoRouter {
                endpoints,
                cause: why_no_router(&options, &security),
            },
            other => Error::Network(other),
        })?;
        Ok(Site::new(bus, Keys::for_site(site), self.timeout))
    }

    fn network(&self) -> Result<(BusOptions, Security), Error> {
        let mut options = BusOptions {
            connect: (!self.endpoints.is_empty()).then(|| self.endpoints.clone()),
            ..BusOptions::default()
        };
        let Some((name, password)) = &self.user else {
            let by_default = if self.keys.is_some() { "quic/" } else { "tcp/" };
            let endpoint = self.endpoints.first().map_or(by_default, String::as_str);
            let keys = self.keys.as_deref();
            let security =
                Security::of_client(endpoint, keys, &self.site).map_err(BusError::from)?;
            return Ok((options, security));
        };
        if self.keys.is_some() {
            return Err(Error::Options(
                "give either a folder of keys or a user name with a password",
            ));
        }
        let section = serde_json::json!({ "user": name, "password": password });
        let overrides = &mut options.overrides;
        overrides.insert(USER_SECTION.to_owned(), section.to_string());
        Ok((options, Security::none(Profile::Open)))
    }
}

//! Errors, with cause and remedy.

use sextant_zenoh_bus::BusError;
use std::time::Duration;

/// Why something could not be had from a site.
///
/// `Debug` is the same text as `Display`, since that is what a `main` that returns it prints.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// No router answered in time.
    #[error(
        "no router answers at {endpoints}{}: start the site (`sextant demo` or `sextant \
         fusion`), or check the endpoint and the keys",
        in_parentheses(.cause)
    )]
    NoRouter {
        /// The endpoints that were tried.
        endpoints: String,
        /// What a connection by hand shows, if anything.
        cause: Option<String>,
    },
    /// A name that no site, camera or object can have.
    #[error("{name:?} is no {what} name: {cause}")]
    Name {
        /// What was to be named.
        what: &'static str,
        /// The name.
        name: String,
        /// What is wrong with it.
        cause: String,
    },
    /// Options that exclude one another.
    #[error("{0}")]
    Options(&'static str),
    /// No fusion node of this site runs, so that there are no objects.
    #[error("no fusion node runs at site {site:?}{}", served(.others))]
    NoFusion {
        /// The site.
        site: String,
        /// Sites of the same router, with the version of their contract where it is another: `demo`, `demo (v2)`.
        others: Vec<String>,
    },
    /// The site has no object of this name.
    #[error("site {site:?} has no object {object:?}; it has {}", listed(.known))]
    UnknownObject {
        /// The object that was asked for.
        object: String,
        /// The site.
        site: String,
        /// The objects that it has.
        known: Vec<String>,
    },
    /// The site has no camera of this name.
    #[error("site {site:?} has no camera {camera:?}; it has {}", listed(.known))]
    UnknownCamera {
        /// The camera that was asked for.
        camera: String,
        /// The site.
        site: String,
        /// The cameras that it has.
        known: Vec<String>,
    },
    /// No pose arrived in time.
    #[error(
        "no pose of {object:?} within {:.1} s{}: {}", waited.as_secs_f64(), since(.silent), if *.is_connected {
            "check that cameras see it (`sextant top`)"
        } else {
            "the router is out of reach"
        }
    )]
    NoPose {
        /// The object.
        object: String,
        /// How long this waited.
        waited: Duration,
        /// How long ago the last pose came; none before the first.
        silent: Option<Duration>,
        /// Whether the router answers.
        is_connected: bool,
    },
    /// The history has no poses around this time.
    #[error(
        "no pose of {object:?} at {t_ns}: {}; poses are kept for {} s from the first request for this object",
        covered(.covered_ns), crate::history::KEPT.as_secs()
    )]
    NotCovered {
        /// The object.
        object: String,
        /// The time that was asked for, ns.
        t_ns: u64,
        /// First and last time of the history, ns; none while it is empty.
        covered_ns: Option<(u64, u64)>,
    },
    /// The object was not estimated around this time.
    #[error(
        "no pose of {object:?} at {t_ns}: its poses around that time are {:.3} s apart, too far \
         to interpolate", gap.as_secs_f64()
    )]
    Gap {
        /// The object.
        object: String,
        /// The time that was asked for, ns.
        t_ns: u64,
        /// Time between the poses before and after it.
        gap: Duration,
    },
    /// The network refuses: keys, endpoints, or a closed session.
    #[error(transparent)]
    Network(#[from] BusError),
}

impl std::fmt::Debug for Error {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{self}")
    }
}

fn in_parentheses(cause: &Option<String>) -> String {
    cause
        .as_ref()
        .map_or_else(String::new, |cause| format!(" ({cause})"))
}

fn listed(names: &[String]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

fn served(sites: &[String]) -> String {
    if sites.is_empty() {
        ": start one (`sextant fusion`), or check the site's name".to_owned()
    } else {
        format!(
            "; this router serves {}: check the site's name, and that client and site have the same version",
            sites.join(", ")
        )
    }
}

fn since(silent: &Option<Duration>) -> String {
    silent.map_or_else(String::new, |silent| {
        format!(", the last one came {:.1} s ago", silent.as_secs_f64())
    })
}

fn covered(covered_ns: &Option<(u64, u64)>) -> String {
    match covered_ns {
        Some((first, last)) => format!("known from {first} to {last}"),
        None => "none is known yet".to_owned(),
    }
}

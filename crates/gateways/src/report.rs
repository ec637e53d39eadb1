//! What a person should know while a gateway runs.

use sextant_site_model::ObjectId;
use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;

/// An event in a gateway. Its words may contain text from the network, control characters included.
#[derive(Debug, Clone, PartialEq)]
pub enum Notice {
    /// The router of the site is unreachable.
    RouterSilent {
        /// For how long, s.
        seconds: f64,
    },
    /// The router of the site answers again.
    RouterBack,
    /// No pose of some objects, or of any, has arrived since the start.
    NoPose {
        /// Objects that were asked for and have none; empty where all are wanted.
        unseen: Vec<ObjectId>,
        /// Objects of the site.
        objects: Vec<ObjectId>,
    },
    /// The address at which no program listens; datagrams are sent nevertheless.
    NobodyListens(SocketAddr),
    /// A datagram could not be sent; further ones are tried.
    Unsent {
        /// The receiver.
        address: SocketAddr,
        /// The system's reason.
        cause: String,
    },
    /// The server to which messages go is gone, or refuses.
    ServerGone {
        /// What and where it is.
        server: String,
        /// Why.
        cause: String,
    },
    /// That server is back.
    ServerBack {
        /// What and where it is.
        server: String,
    },
    /// A client was disconnected because it did not read.
    Disconnected(SocketAddr),
    /// A client beyond the limit was turned away.
    TooManyClients {
        /// The limit.
        most: usize,
    },
    /// A connection that is no client's was turned away.
    TurnedAway {
        /// Who connected.
        peer: SocketAddr,
        /// Why, and what to do.
        cause: String,
    },
    /// The router of ROS does not answer at the start.
    NoRosRouter {
        /// Its endpoint.
        endpoint: String,
        /// Why, if that is known.
        cause: Option<String>,
    },
    /// The router of ROS is unreachable.
    RosRouterGone,
    /// The router of ROS answers again.
    RosRouterBack,
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RouterSilent { seconds } => write!(
                f,
                "the router has not answered for {seconds:.0} s; waiting for it"
            ),
            Self::RouterBack => f.write_str("the router is back"),
            Self::NoPose { unseen, objects } => {
                let site = objects_in_words(objects);
                let (seen, absent) = unseen.iter().partition(|object| objects.contains(object));
                match (&names(seen)[..], &names(absent)[..]) {
                    ("", "") => write!(f, "no pose of any object so far; {site}"),
                    (late, "") => write!(f, "no pose of {late} so far: no camera sees its tags"),
                    (_, absent) => write!(f, "no object {absent}: {site}; check --object"),
                }
            }
            Self::NobodyListens(address) => {
                write!(f, "no program listens at {address} yet; sending continues")
            }
            Self::Unsent { address, cause } => {
                write!(f, "cannot send to {address}: {cause}; trying on")
            }
            Self::ServerGone { server, cause } => {
                write!(f, "{server} is gone: {cause}; waiting for it")
            }
            Self::ServerBack { server } => write!(f, "{server} is back"),
            Self::Disconnected(peer) => write!(
                f,
                "{peer} does not read what it is sent and was disconnected"
            ),
            Self::TooManyClients { most } => write!(
                f,
                "a client beyond the {most} that can be served was turned away"
            ),
            Self::TurnedAway { peer, cause } => write!(f, "{peer} was turned away: {cause}"),
            Self::NoRosRouter { endpoint, cause } => {
                write!(f, "no ROS router answers at {endpoint}")?;
                match cause {
                    Some(cause) => write!(f, " ({cause}); waiting for it"),
                    None => f.write_str("; waiting for it"),
                }
            }
            Self::RosRouterGone => f.write_str("the ROS router is gone; waiting for it"),
            Self::RosRouterBack => f.write_str("the ROS router is back"),
        }
    }
}

/// Most names in a sentence.
const MOST_NAMES: usize = 10;

fn names(objects: Vec<&ObjectId>) -> String {
    let names = objects.iter().map(|object| object.as_str());
    names.collect::<Vec<_>>().join(", ")
}

/// The objects of a site as a clause: `the site has the objects a, b`.
pub(crate) fn objects_in_words(objects: &[ObjectId]) -> String {
    let names: Vec<&str> = objects.iter().map(ObjectId::as_str).collect();
    match names.as_slice() {
        [] => "the site has no objects".to_owned(),
        [one] => format!("the site has the object {one}"),
        _ if names.len() > MOST_NAMES => {
            let further = names.len() - MOST_NAMES;
            let names = names[..MOST_NAMES].join(", ");
            format!("the site has the objects {names} and {further} more")
        }
        _ => format!("the site has the objects {}", names.join(", ")),
    }
}

/// Where the notices of a gateway go. They come from any of its threads.
#[derive(Clone)]
pub struct Reporter(Arc<dyn Fn(&Notice) + Send + Sync>);

impl Reporter {
    /// Calls `report` with each notice.
    pub fn new(report: impl Fn(&Notice) + Send + Sync + 'static) -> Self {
        Self(Arc::new(report))
    }

    pub(crate) fn report(&self, notice: &Notice) {
        (self.0)(notice);
    }
}

impl fmt::Debug for Reporter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Reporter")
    }
}

//! A site that this program is connected to: subscriptions, and poses now, at a time and relative to one another.

use crate::history::History;
use crate::messages::Inbox;
use crate::{Error, Messages, Pose, SiteOptions, Transform};
use sextant_proto::{AnyMessage, Keys, Message, MessageKind, ObjectPose, Observations};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{CameraId, ObjectId};
use sextant_zenoh_bus::{Bus, CallbackSubscription, Item};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// A connection to a site. Dropping it, and the last of its subscriptions, closes the connection.
#[derive(Debug)]
pub struct Site {
    pub(crate) bus: Arc<Bus>,
    pub(crate) keys: Keys,
    pub(crate) timeout: Duration,
    followed: Mutex<BTreeMap<ObjectId, Followed>>,
}

/// An object whose poses are kept. There are as many as the site has objects, since others are refused.
#[derive(Debug)]
struct Followed {
    history: Arc<History>,
    _subscription: CallbackSubscription,
}

impl Site {
    /// Connects to an unprotected site, such as a demo's. Waits for its router for 5 s.
    ///
    /// # Errors
    /// As [`SiteOptions::connect`].
    pub fn connect(endpoint: &str, site: &str) -> Result<Self, Error> {
        Self::options(site).endpoint(endpoint).connect()
    }

    /// Options to connect with: several routers, keys, a user name, patience.
    ///
    /// ```no_run
    /// # use sextant_client::{Error, Site};
    /// # fn main() -> Result<(), Error> {
    /// let site = Site::options("hall").endpoint("quic/fusion.local:7447").keys("keys/screen").connect()?;
    /// # Ok(()) }
    /// ```
    pub fn options(site: &str) -> SiteOptions {
        SiteOptions::new(site)
    }

    pub(crate) fn new(bus: Bus, keys: Keys, timeout: Duration) -> Self {
        Self {
            bus: Arc::new(bus),
            keys,
            timeout,
            followed: Mutex::default(),
        }
    }

    /// The name of the site.
    #[must_use]
    pub fn name(&self) -> &str {
        self.keys.site().as_str()
    }

    /// Whether the router answers now. While it does not, the connection is being made again.
    #[must_use]
    pub fn is_connected(&self) -> bool {
        self.bus.is_connected()
    }

    /// The poses of an object from now on, as an iterator that blocks or, by [`Messages::into_stream`], as a stream.
    ///
    /// ```no_run
    /// # use sextant_client::{Error, Site};
    /// # async fn follow(site: Site) -> Result<(), Error> {
    /// use futures_util::StreamExt;
    /// let mut poses = site.poses("cuboid")?.into_stream();
    /// while let Some(pose) = poses.next().await {
    ///     println!("{} {}", pose.t_ns, pose.position);
    /// }
    /// # Ok(()) }
    /// ```
    ///
    /// # Errors
    /// An object that the site does not have.
    pub fn poses(&self, object: &str) -> Result<Messages<Pose>, Error> {
        let object = self.known_object(object)?;
        self.subscribe(&self.keys.pose(&object), poses(self.keys.clone()))
    }

    /// The poses of all objects from now on, also of those that are added later.
    ///
    /// # Errors
    /// A session that is closed.
    pub fn all_poses(&self) -> Result<Messages<Pose>, Error> {
        self.subscribe(&self.keys.all_poses(), poses(self.keys.clone()))
    }

    /// What each image of a camera shows, from now on.
    ///
    /// # Errors
    /// A camera that the site does not have.
    pub fn observations(&self, camera: &str) -> Result<Messages<Observations>, Error> {
        let camera = self.known_camera(camera)?;
        let key = self.keys.observations(&camera);
        let read = messages(self.keys.clone());
        self.subscribe(&key, move |item| match read(item)? {
            AnyMessage::Observations(observations) => Some(observations),
            _ => None,
        })
    }

    /// The pose of an object now: the newest one, if it arrived within the last second; otherwise the next, waiting for
    /// it for at most `timeout`.
    ///
    /// # Errors
    /// An object that the site does not have, or none of its poses in time.
    pub fn pose(&self, object: &str, timeout: Duration) -> Result<Pose, Error> {
        let started = Instant::now();
        let history = self.follow(object)?;
        let pose = history.newest(started + timeout);
        pose.ok_or_else(|| self.no_pose(object, started, &history))
    }

    /// The pose of an object at a time, interpolated between the poses before and after it, with a covariance that
    /// allows for what happened in between. Waits for a pose after that time for at most `timeout`. Poses are kept for
    /// 10 s, from the first request for this object.
    ///
    /// # Errors
    /// An object that the site does not have, or a time without poses around it.
    pub fn pose_at(&self, object: &str, t_ns: u64, timeout: Duration) -> Result<Pose, Error> {
        let deadline = Instant::now() + timeout;
        self.follow(object)?.at(object, t_ns, deadline)
    }

    /// Where object `b` is in the frame of object `a`: both at the newest time at which both are known, waiting for
    /// that for at most `timeout`.
    ///
    /// # Errors
    /// An object that the site does not have, or none of its poses in time.
    pub fn transform(&self, a: &str, b: &str, timeout: Duration) -> Result<Transform, Error> {
        let started = Instant::now();
        let deadline = started + timeout;
        let histories = [(a, self.follow(a)?), (b, self.follow(b)?)];
        let mut newest_ns = u64::MAX;
        let mut begun_ns = 0;
        for (object, history) in &histories {
            let newest = history.newest(deadline);
            let newest = newest.ok_or_else(|| self.no_pose(object, started, history))?;
            newest_ns = newest_ns.min(newest.t_ns);
            begun_ns = begun_ns.max(history.oldest_ns());
        }
        // A history that has only begun may begin after the other's newest pose, which then has to wait for the next.
        let t_ns = newest_ns.max(begun_ns);
        let [a, b] = histories.map(|(object, history)| history.at(object, t_ns, deadline));
        Ok(Transform::between(&a?, &b?))
    }

    /// Where object `b` is in the frame of object `a` at a time, as [`Site::pose_at`].
    ///
    /// # Errors
    /// As [`Site::pose_at`].
    pub fn transform_at(
        &self,
        a: &str,
        b: &str,
        t_ns: u64,
        timeout: Duration,
    ) -> Result<Transform, Error> {
        let deadline = Instant::now() + timeout;
        let pose = |object: &str| self.follow(object)?.at(object, t_ns, deadline);
        Ok(Transform::between(&pose(a)?, &pose(b)?))
    }

    fn no_pose(&self, object: &str, started: Instant, history: &History) -> Error {
        Error::NoPose {
            object: object.to_owned(),
            waited: started.elapsed(),
            silent: history.silent(),
            is_connected: self.is_connected(),
        }
    }

    fn subscribe<T: Send + 'static>(
        &self,
        key: &str,
        read: impl Fn(&Item) -> Option<T> + Send + Sync + 'static,
    ) -> Result<Messages<T>, Error> {
        let inbox = Inbox::new();
        let intake = Arc::clone(&inbox);
        let most = MessageKind::Observations.max_bytes();
        let subscription = self
            .bus
            .subscribe_with(key, most, move |item| intake.push(read(&item)))?;
        Ok(Messages::new(inbox, subscription, Arc::clone(&self.bus)))
    }

    /// The history of an object, which begins with the first request.
    fn follow(&self, object: &str) -> Result<Arc<History>, Error> {
        let id = object_id(object)?;
        if let Some(followed) = self.followed().get(&id) {
            return Ok(Arc::clone(&followed.history));
        }
        let id = self.known_object(object)?;
        let history = Arc::new(History::default());
        let read = poses(self.keys.clone());
        let intake = Arc::clone(&history);
        let take = move |item: Item| {
            if let Some(pose) = read(&item) {
                intake.insert(pose);
            }
        };
        let most = ObjectPose::KIND.max_bytes();
        let subscription = self.bus.subscribe_with(&self.keys.pose(&id), most, take)?;
        let followed = Followed {
            history,
            _subscription: subscription,
        };
        // Of two threads that ask at once the first one's history stays.
        let mut all = self.followed();
        Ok(Arc::clone(&all.entry(id).or_insert(followed).history))
    }

    fn followed(&self) -> std::sync::MutexGuard<'_, BTreeMap<ObjectId, Followed>> {
        self.followed.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Reads valid messages of their key's camera or object; poses by the fusion node that publishes now, none of older
/// epochs.
fn messages(keys: Keys) -> impl Fn(&Item) -> Option<AnyMessage> + Send + Sync + 'static {
    let (mirror, begun) = (Mutex::new(SiteMirror::default()), Instant::now());
    move |item| {
        let key = keys.parse(&item.key)?;
        let now_ns = begun.elapsed().as_nanos() as u64;
        let mut mirror = mirror.lock().unwrap_or_else(PoisonError::into_inner);
        let update = mirror.handle(now_ns, &key, item.sender.as_deref(), item.try_bytes());
        Some(update.ok()?.message)
    }
}

fn poses(keys: Keys) -> impl Fn(&Item) -> Option<Pose> + Send + Sync + 'static {
    let read = messages(keys);
    move |item| match read(item)? {
        AnyMessage::ObjectPose(pose) => Some((*pose).into()),
        _ => None,
    }
}

pub(crate) fn object_id(object: &str) -> Result<ObjectId, Error> {
    ObjectId::new(object).map_err(|cause| Error::Name {
        what: "object",
        name: object.to_owned(),
        cause: cause.to_string(),
    })
}

pub(crate) fn camera_id(camera: &str) -> Result<CameraId, Error> {
    CameraId::new(camera).map_err(|cause| Error::Name {
        what: "camera",
        name: camera.to_owned(),
        cause: cause.to_string(),
    })
}

//! Translates the messages of a site to ROS messages: when each topic is published, and under whose name.

mod claims;
mod health;

use std::collections::BTreeMap;

use sextant_proto::{
    AnyMessage, CameraConfig, DecodeError, KeyRef, ObjectLinks, ObjectPose, Observations, Preview,
};
use sextant_site_mirror::SiteMirror;
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::State;

use self::claims::{Claims, Owner};
use crate::convert;
use crate::description::{RosMessage, encode};
use crate::messages::{TFMessage, TransformStamped};
use crate::names::{Namespace, token};
use crate::rate::{Passage, Stream};
use crate::topic::{Topic, TopicKind};

/// What a person may choose.
#[derive(Debug, Clone)]
pub struct BridgeOptions {
    /// Namespace of the topics of objects and cameras.
    pub namespace: Namespace,
    /// The world's frame.
    pub world: String,
    /// Most messages per second of an object, and of a camera's detections and pictures; none for all.
    pub max_rate_hz: Option<f64>,
    /// Further messages that poses become.
    pub also: Vec<Also>,
}

/// A message that the pose of an object becomes where a person asks for it, once its attitude is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Also {
    /// `object/ID/odom` in the namespace.
    Odometry,
    /// `/poses`, as `motion_capture_tracking` publishes them for Crazyswarm2.
    NamedPoses,
    /// `/rigid_bodies`, as the drivers of MOCAP4ROS2 publish them.
    RigidBodies,
}

/// A ROS message for a topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outgoing {
    /// Where it goes.
    pub topic: Topic,
    /// CDR.
    pub payload: Vec<u8>,
}

/// Messages of the site that were not published.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BridgeCounts {
    /// Those that break the site's contract, or name another object or camera than their key.
    pub invalid: u64,
    /// Those left out to keep to the rate.
    pub over_rate: u64,
    /// Those no newer than the last of their topic, and poses of a fusion node that another one has replaced.
    pub superseded: u64,
    /// Those whose topic or frame bears the name of another's, or that found no room.
    pub name_taken: u64,
}

/// The state machine. Time is an argument: ns since the Unix epoch.
#[derive(Debug)]
pub struct Bridge {
    options: BridgeOptions,
    mirror: SiteMirror,
    streams: BTreeMap<StreamId, Stream>,
    claims: Claims,
    /// Without those that the mirror counts.
    counts: BridgeCounts,
}

/// A stream of messages of increasing capture time.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
enum StreamId {
    Pose(ObjectId),
    Links(ObjectId),
    Detections(CameraId),
    Images(CameraId),
    Pictures(CameraId),
}

impl Bridge {
    /// Knows nothing of the site yet.
    #[must_use]
    pub fn new(options: BridgeOptions) -> Self {
        let claims = Claims::with_frame(&options.world);
        Self {
            options,
            mirror: SiteMirror::default(),
            streams: BTreeMap::new(),
            claims,
            counts: BridgeCounts::default(),
        }
    }

    /// Messages of the site that were not published.
    #[must_use]
    pub fn counts(&self) -> BridgeCounts {
        let refused = self.mirror.rejections();
        BridgeCounts {
            invalid: self.counts.invalid + refused.invalid(),
            over_rate: self.counts.over_rate,
            superseded: self.counts.superseded + refused.superseded(),
            name_taken: self.counts.name_taken + refused.too_many(),
        }
    }

    /// The ROS messages of a message of the site and its sender's signature, in the order in which they are to be
    /// published. Keys that nothing is made of are ignored.
    pub fn handle(
        &mut self,
        now_ns: u64,
        key: &KeyRef,
        sender: Option<&str>,
        payload: Result<&[u8], DecodeError>,
    ) -> Vec<Outgoing> {
        if !is_used(key) {
            return Vec::new();
        }
        let Ok(update) = self.mirror.handle(now_ns, key, sender, payload) else {
            return Vec::new();
        };
        match update.message {
            AnyMessage::ObjectPose(pose) => self.pose(&pose),
            AnyMessage::ObjectLinks(links) => self.links(&links),
            AnyMessage::Observations(image) => self.detections(&image),
            AnyMessage::Preview(preview) => self.picture(&preview),
            AnyMessage::RigConfig(rig) => self.rig(now_ns, &rig.cameras),
            AnyMessage::ObjectConfig(_) => vec![self.static_transforms(now_ns)],
            _ if !update.gone.is_empty() => vec![self.static_transforms(now_ns)],
            _ => Vec::new(),
        }
    }

    /// The state of the nodes, for about once a second, with values of the bridge's own.
    pub fn diagnostics(&mut self, now_ns: u64, own: &[(&str, u64)]) -> Outgoing {
        self.mirror.expire(now_ns);
        let counts = self.counts();
        let own = own.iter().copied().chain([
            ("messages invalid", counts.invalid),
            ("messages over the rate", counts.over_rate),
            ("messages superseded", counts.superseded),
            ("messages without a name", counts.name_taken),
        ]);
        let message = health::report(&self.mirror, now_ns, own);
        outgoing("/diagnostics".to_owned(), TopicKind::Diagnostics, &message)
    }

    /// Poses are published while they mean something: with their covariance from the first on, as transforms, which
    /// have none, once one attitude is known.
    fn pose(&mut self, pose: &ObjectPose) -> Vec<Outgoing> {
        let owner = Owner::Object(pose.object.clone());
        let folder = format!("object/{}", token(pose.object.as_str()));
        let name = format!("{folder}/pose");
        if pose.state == State::Lost
            || !self.may_pass(StreamId::Pose(pose.object.clone()), pose.capture_ns)
            || !self.owns(&[&name, pose.object.as_str()], &owner)
        {
            return Vec::new();
        }
        let world = &self.options.world;
        let message = convert::object_pose(pose, world);
        let message = outgoing(self.topic(&name), TopicKind::Pose, &message);
        let quality = self.topic(&format!("{folder}/quality"));
        let quality = outgoing(quality, TopicKind::Quality, &convert::quality(pose));
        if !is_known(pose.state) {
            return vec![message, quality];
        }
        let transform = transforms(vec![convert::object_transform(pose, world)]);
        let also = self.options.also.iter();
        let also = also.map(|also| self.also(*also, pose));
        [transform, message, quality]
            .into_iter()
            .chain(also)
            .collect()
    }

    fn also(&self, also: Also, pose: &ObjectPose) -> Outgoing {
        let world = &self.options.world;
        let absolute = |name: &str| name.to_owned();
        match also {
            Also::Odometry => {
                let name = format!("object/{}/odom", token(pose.object.as_str()));
                let message = convert::odometry(pose, world);
                outgoing(self.topic(&name), TopicKind::Odometry, &message)
            }
            Also::NamedPoses => {
                let message = convert::named_pose(pose, world);
                outgoing(absolute("/poses"), TopicKind::NamedPoses, &message)
            }
            Also::RigidBodies => {
                let message = convert::rigid_body(pose, world);
                outgoing(absolute("/rigid_bodies"), TopicKind::RigidBodies, &message)
            }
        }
    }

    fn links(&mut self, links: &ObjectLinks) -> Vec<Outgoing> {
        let stream = StreamId::Links(links.object.clone());
        if !is_known(links.state) || !self.may_pass(stream, links.capture_ns) {
            return Vec::new();
        }
        let world = &self.options.world;
        let all = links.links.iter();
        vec![transforms(
            all.map(|link| convert::link_transform(links, link, world))
                .collect(),
        )]
    }

    fn detections(&mut self, image: &Observations) -> Vec<Outgoing> {
        let stream = StreamId::Detections(image.camera.clone());
        self.may_pass(stream, image.capture_ns)
            .then(|| {
                self.of_camera(
                    &image.camera,
                    TopicKind::Detections,
                    &convert::detections(image),
                )
            })
            .flatten()
            .into_iter()
            .collect()
    }

    /// A whole image of a camera, a file of the named format, with the lens at its time.
    pub fn image(
        &mut self,
        camera: &CameraId,
        capture_ns: u64,
        format: &str,
        file: Vec<u8>,
    ) -> Vec<Outgoing> {
        if !self.may_pass(StreamId::Images(camera.clone()), capture_ns) {
            return Vec::new();
        }
        let info = self.mirror.camera_config(camera);
        let info = info.map(|config| convert::camera_info(config, capture_ns));
        let info = info.and_then(|info| self.of_camera(camera, TopicKind::CameraInfo, &info));
        let image = convert::image(camera, capture_ns, format, file);
        let image = self.of_camera(camera, TopicKind::Image, &image);
        info.into_iter().chain(image).collect()
    }

    fn picture(&mut self, preview: &Preview) -> Vec<Outgoing> {
        let stream = StreamId::Pictures(preview.camera.clone());
        if !self.may_pass(stream, preview.capture_ns) {
            return Vec::new();
        }
        let camera = self.mirror.camera_config(&preview.camera);
        let info = camera.and_then(|camera| convert::picture_info(camera, preview));
        let info =
            info.and_then(|info| self.of_camera(&preview.camera, TopicKind::PictureInfo, &info));
        let picture = convert::picture(preview);
        let picture = self.of_camera(&preview.camera, TopicKind::Picture, &picture);
        info.into_iter().chain(picture).collect()
    }

    fn rig(&mut self, now_ns: u64, cameras: &[CameraConfig]) -> Vec<Outgoing> {
        let infos = cameras.iter().filter_map(|camera| {
            let info = convert::camera_info(camera, now_ns);
            self.of_camera(&camera.id, TopicKind::CameraInfo, &info)
        });
        let mut all: Vec<Outgoing> = infos.collect();
        all.push(self.static_transforms(now_ns));
        all
    }

    /// All of them: a late subscriber gets the last message only.
    fn static_transforms(&self, now_ns: u64) -> Outgoing {
        let cameras = self.mirror.rig().into_iter().flat_map(|rig| &rig.cameras);
        let objects = self.mirror.configs();
        let transforms = convert::static_transforms(cameras, objects, &self.options.world, now_ns);
        let message = TFMessage { transforms };
        outgoing(
            "/tf_static".to_owned(),
            TopicKind::StaticTransforms,
            &message,
        )
    }

    fn of_camera(
        &mut self,
        camera: &CameraId,
        kind: TopicKind,
        message: &impl RosMessage,
    ) -> Option<Outgoing> {
        let leaf = match kind {
            TopicKind::Image => "image/compressed",
            TopicKind::Picture => "preview/image/compressed",
            TopicKind::PictureInfo => "preview/camera_info",
            TopicKind::CameraInfo => "camera_info",
            _ => "detections",
        };
        let folder = format!("camera/{}", token(camera.as_str()));
        let frame = convert::optical_frame(camera);
        self.owns(&[&folder, &frame], &Owner::Camera(camera.clone()))
            .then(|| outgoing(self.topic(&format!("{folder}/{leaf}")), kind, message))
    }

    fn topic(&self, name: &str) -> String {
        self.options.namespace.topic(name)
    }

    /// Whether these names of topics and frames are this owner's.
    fn owns(&mut self, names: &[&str], owner: &Owner) -> bool {
        let is_owner = names.iter().all(|name| self.claims.take(name, owner));
        self.counts.name_taken += u64::from(!is_owner);
        is_owner
    }

    fn may_pass(&mut self, stream: StreamId, capture_ns: u64) -> bool {
        if self.streams.len() >= claims::MOST && !self.streams.contains_key(&stream) {
            self.counts.name_taken += 1;
            return false;
        }
        let period_ns = self.options.max_rate_hz.map_or(0, |hz| (1e9 / hz) as u64);
        let stream = self.streams.entry(stream).or_default();
        let passage = stream.passage(capture_ns, period_ns);
        self.counts.over_rate += u64::from(passage == Passage::OverRate);
        self.counts.superseded += u64::from(passage == Passage::Superseded);
        passage == Passage::Passes
    }
}

fn is_used(key: &KeyRef) -> bool {
    matches!(
        key,
        KeyRef::Pose(_)
            | KeyRef::Links(_)
            | KeyRef::Observations(_)
            | KeyRef::Preview(_)
            | KeyRef::ConfigRig
            | KeyRef::ConfigObject(_)
            | KeyRef::CameraStatus(_)
            | KeyRef::FusionStatus(_)
    )
}

fn is_known(state: State) -> bool {
    matches!(state, State::Tracking | State::Coasting)
}

fn transforms(transforms: Vec<TransformStamped>) -> Outgoing {
    let message = TFMessage { transforms };
    outgoing("/tf".to_owned(), TopicKind::Transforms, &message)
}

fn outgoing(name: String, kind: TopicKind, message: &impl RosMessage) -> Outgoing {
    Outgoing {
        topic: Topic { name, kind },
        payload: encode(message),
    }
}

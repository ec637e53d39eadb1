//! Names, liveliness and messages of browsers' cameras on the site's network, by a thread of its own: an observation
//! waits for no other work of the bridge.

use crate::shared::Shared;
use crate::web_camera::registry::{JoinState, Outgoing, WebCameras, taken};
use nalgebra::Point2;
use sextant_geometry::Lens;
use sextant_geometry::planar_pose::tag_poses;
use sextant_process::fail_point;
use sextant_process::host::host_name;
use sextant_proto::{
    CameraNotice, CameraStatus, Keys, NodeId, NodeKind, Observations, Preview, TagObservation,
    TagPose, limits,
};
use sextant_site_model::{CameraId, TagId};
use sextant_zenoh_bus::{AliveToken, Bus, BusError, HeldName, Latest, Publisher, Qos};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// The longest sleep: how late a browser joins, and a shutdown is heard.
const LONGEST_WAIT: Duration = Duration::from_millis(50);
/// Between two looks for browsers that came or went.
const LOOK_PERIOD: Duration = Duration::from_millis(100);

/// Publishes until `is_over`.
///
/// # Errors
/// A network that can't be used.
pub(crate) fn run(shared: &Shared, bus: &Bus, is_over: &dyn Fn() -> bool) -> Result<(), BusError> {
    let mut network = Network {
        shared,
        bus,
        keys: Keys::for_site(shared.config.site.clone()),
        cameras: BTreeMap::new(),
    };
    let mut look_due = Instant::now();
    while !is_over() {
        fail_point!("web_cameras");
        if Instant::now() >= look_due {
            network.follow(&shared.web_cameras)?;
            look_due = Instant::now() + LOOK_PERIOD;
        }
        if let Some(message) = shared.web_cameras.next(LONGEST_WAIT) {
            network.publish(message)?;
        }
    }
    Ok(())
}

struct Network<'a> {
    shared: &'a Shared,
    bus: &'a Bus,
    keys: Keys,
    cameras: BTreeMap<CameraId, OnNetwork>,
}

/// A camera's tokens and streams.
struct OnNetwork {
    _name: HeldName,
    _alive: AliveToken,
    observations: Publisher<Observations>,
    status: Latest<CameraStatus>,
    previews: Publisher<Preview>,
}

impl Network<'_> {
    /// Lets cameras join that came, and leave that went.
    fn follow(&mut self, cameras: &WebCameras) -> Result<(), BusError> {
        let wanted = cameras.names();
        self.cameras.retain(|camera, _| wanted.contains(camera));
        for camera in wanted {
            if !self.cameras.contains_key(&camera) {
                match self.join(&camera)? {
                    Some(joined) => drop(self.cameras.insert(camera.clone(), joined)),
                    None => {
                        cameras.set(&camera, JoinState::Ended(taken(&camera)));
                        continue;
                    }
                }
            }
            cameras.set(&camera, JoinState::Joined);
        }
        Ok(())
    }

    /// None where another camera of the site has the name.
    fn join(&self, camera: &CameraId) -> Result<Option<OnNetwork>, BusError> {
        let Ok(id) = NodeId::new(camera.as_str()) else {
            return Ok(None);
        };
        let holder = self.keys.holder(NodeKind::Camera, &id);
        let Some(name) = self.bus.hold_name(&holder, &host_name(), &|| true)? else {
            return Ok(None);
        };
        let alive = self.keys.alive(NodeKind::Camera, &id);
        Ok(Some(OnNetwork {
            _name: name,
            _alive: self.bus.alive(&alive)?,
            observations: self
                .bus
                .publisher(&self.keys.observations(camera), Qos::Observation)?,
            status: self
                .bus
                .latest_publisher(&self.keys.camera_status(camera), Qos::Status)?,
            previews: self
                .bus
                .publisher(&self.keys.preview(camera), Qos::Preview)?,
        }))
    }

    /// Publishes a message of a camera that has joined; others are late ones of cameras that left.
    fn publish(&self, message: Outgoing) -> Result<(), BusError> {
        let Some(camera) = self.cameras.get(message.camera()) else {
            return Ok(());
        };
        let published = match message {
            Outgoing::Observations(mut observations) => {
                self.solve(&mut observations);
                camera.observations.put(&observations)
            }
            Outgoing::Status(mut status) => {
                if self.is_missing_in_rig(&status.camera) {
                    status.notices.push(CameraNotice::NotInRig);
                }
                camera.status.put(&status)
            }
            Outgoing::Preview(preview) => match camera.previews.has_subscribers() {
                true => camera.previews.put(&preview),
                false => Ok(()),
            },
        };
        match published {
            // It was checked; what remains are numbers that only this conversion made wrong.
            Err(BusError::Message { cause, .. }) => {
                tracing::warn!(cause, "a message of a browser is refused");
                Ok(())
            }
            other => other,
        }
    }

    fn is_missing_in_rig(&self, camera: &CameraId) -> bool {
        let site = self.shared.mirror();
        site.rig().is_some() && site.camera_config(camera).is_none()
    }

    /// Adds the poses of tags, as a camera node does, where lens and sizes are known.
    fn solve(&self, observations: &mut Observations) {
        let site = self.shared.mirror();
        let lens = site.camera_config(&observations.camera);
        let lens = lens.filter(|of| of.resolution == observations.resolution.map(u32::from));
        let lens = lens.and_then(|camera| Lens::try_from(&camera.lens).ok());
        let sizes: Vec<Option<f64>> = observations
            .tags
            .iter()
            .map(|tag| site.tag(id_of(tag)).map(|(_, size_m)| size_m))
            .collect();
        drop(site);
        for (tag, size_m) in observations.tags.iter_mut().zip(sizes) {
            tag.poses = match (&lens, size_m) {
                (Some(lens), Some(size_m)) => poses(lens, tag, size_m),
                _ => Vec::new(),
            };
        }
    }
}

fn id_of(tag: &TagObservation) -> TagId {
    TagId {
        family: tag.family,
        id: tag.id,
    }
}

fn poses(lens: &Lens, tag: &TagObservation, size_m: f64) -> Vec<TagPose> {
    let corners = tag
        .corners
        .map(|[x, y]| Point2::new(f64::from(x), f64::from(y)));
    let solved = tag_poses(lens, &corners, size_m).into_iter();
    let poses = solved.take(limits::MAX_TAG_POSES).map(|pose| TagPose {
        position: pose.camera_from_tag.translation.vector.cast::<f32>().into(),
        orientation: pose.camera_from_tag.rotation.coords.cast::<f32>().into(),
        rms_px: pose.rms_px as f32,
    });
    poses.collect()
}

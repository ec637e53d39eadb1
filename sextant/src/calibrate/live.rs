//! The images of a running site, as every calibration takes them in: the same observations that the fusion node gets.

use crate::site::Site;
use sextant_estimator::{CameraId, ImageObservation};
use sextant_proto::{Observations, decode, limits};
use sextant_zenoh_bus::{DropRule, Subscription};
use std::ops::ControlFlow;
use std::time::Duration;

/// Messages that wait while one is looked at; the oldest give way.
const QUEUE: usize = 256;
/// How late a Ctrl-C is heard.
const GLANCE: Duration = Duration::from_millis(50);

/// The observations of one camera.
pub struct LiveCamera<'a> {
    site: &'a Site,
    camera: CameraId,
    messages: Subscription,
}

/// An image, and the size of its picture.
pub struct LiveImage {
    /// Width and height, pixels.
    pub resolution: [u32; 2],
    /// What it shows.
    pub observation: ImageObservation,
}

impl<'a> LiveCamera<'a> {
    /// Listens to a camera.
    ///
    /// # Errors
    /// A network that does not let us.
    pub fn of(site: &'a Site, camera: &CameraId) -> anyhow::Result<Self> {
        let messages = site.bus.subscribe(
            &site.keys.observations(camera),
            QUEUE,
            DropRule::Oldest,
            limits::MAX_PAYLOAD_BYTES,
        )?;
        Ok(Self {
            site,
            camera: camera.clone(),
            messages,
        })
    }

    /// Hands over every image until `take` has enough or Ctrl-C; messages that are none of this camera's are passed over.
    ///
    /// # Errors
    /// The first of `take`.
    pub fn each(
        &self,
        mut take: impl FnMut(&LiveImage) -> anyhow::Result<ControlFlow<()>>,
    ) -> anyhow::Result<()> {
        while !self.site.shutdown.is_requested() {
            let item = self.messages.recv_timeout(GLANCE);
            let bytes = item.as_ref().and_then(|item| item.bytes());
            let message = bytes.and_then(|bytes| decode::<Observations>(bytes).ok());
            let Some(message) = message.filter(|message| message.camera == self.camera) else {
                continue;
            };
            let image = LiveImage {
                resolution: message.resolution.map(u32::from),
                observation: ImageObservation::from(&message),
            };
            if take(&image)?.is_break() {
                break;
            }
        }
        Ok(())
    }
}

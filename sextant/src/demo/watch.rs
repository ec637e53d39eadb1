//! Watches the demo's network: scores each pose, publishes the truth, keeps each camera's last status.

use crate::demo::Summary;
use crate::demo::processes::Processes;
use crate::demo::site_folder::SiteFolder;
use crate::demo::terminal::Terminal;
use crate::simulate::models::{Body, bodies};
use serde::Serialize;
use sextant_evaluation::PoseError;
use sextant_evaluation::live::{LiveScore, ScoredPose, WorldFrame};
use sextant_geometry::{Pose, PoseParts};
use sextant_process::shutdown::SHUTDOWN_POLL;
use sextant_process::{Shutdown, now_ns};
use sextant_proto::{
    CameraStatus, Keys, LinkPose, ObjectLinks, ObjectPose, ObjectTruth, decode, limits,
};
use sextant_simulator::{CameraFileError, Scenario, SceneCamera};
use sextant_site_model::{CameraId, ObjectId};
use sextant_zenoh_bus::{Bus, BusError, DropRule, Publisher, Qos, Subscription};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Period of publishing the truth, for display only.
const TRUTH_PERIOD_NS: u64 = 100_000_000;
/// Time in which the last messages of stopped children arrive.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// A camera in the summary.
#[derive(Debug, Default, Clone, PartialEq, Eq, Serialize)]
pub struct CameraSummary {
    /// Its name.
    pub id: String,
    /// Images taken.
    pub captured: u64,
    /// Images searched for tags.
    pub detected: u64,
    /// Images displaced by newer ones before detection.
    pub dropped: u64,
}

/// State of one demo's watch.
pub struct Watch<'a> {
    scenario: &'a Scenario,
    poses: Subscription,
    links: Subscription,
    statuses: Subscription,
    truths: BTreeMap<ObjectId, TruthOutlet>,
    cameras: BTreeMap<CameraId, CameraStatus>,
    score: LiveScore,
    terminal: &'a Terminal,
}

struct TruthOutlet {
    publisher: Publisher<ObjectTruth>,
    due_ns: u64,
}

impl<'a> Watch<'a> {
    /// Starts watching.
    ///
    /// # Errors
    /// If the network session has ended.
    pub fn start(
        bus: &Bus,
        keys: &Keys,
        scenario: &'a Scenario,
        terminal: &'a Terminal,
    ) -> Result<Self, BusError> {
        let subscribe =
            |key: String| bus.subscribe(&key, 1024, DropRule::Oldest, limits::MAX_PAYLOAD_BYTES);
        let mut truths = BTreeMap::new();
        for id in bodies(scenario).filter_map(|body| ObjectId::new(body.id()).ok()) {
            let publisher = bus.publisher(&keys.truth(&id), Qos::Status)?;
            truths.insert(
                id,
                TruthOutlet {
                    publisher,
                    due_ns: 0,
                },
            );
        }
        let rate_hz = scenario
            .cameras
            .first()
            .map_or(30.0, |camera| camera.rate_hz);
        let names = bodies(scenario).flat_map(names);
        let is_exact = |camera: &SceneCamera| camera.file_error == CameraFileError::default();
        let frame = if scenario.cameras.iter().all(is_exact) {
            WorldFrame::Exact
        } else {
            WorldFrame::Fitted
        };
        Ok(Self {
            scenario,
            poses: subscribe(keys.all_poses())?,
            links: subscribe(keys.all_links())?,
            statuses: subscribe(keys.all_camera_statuses())?,
            truths,
            cameras: BTreeMap::new(),
            score: LiveScore::new(names, rate_hz, now_ns(), frame),
            terminal,
        })
    }

    /// Watches until the duration is over or a stop is requested.
    ///
    /// # Errors
    /// If a child or the network session ends.
    pub fn until_end(
        &mut self,
        duration: Option<Duration>,
        processes: &mut Processes,
        shutdown: &Shutdown,
    ) -> anyhow::Result<()> {
        let end = duration.map(|duration| Instant::now() + duration);
        while !shutdown.is_requested() && end.is_none_or(|end| Instant::now() < end) {
            processes.check()?;
            self.glance()?;
            self.terminal.show(&self.score, &self.cameras);
        }
        Ok(())
    }

    /// Handles the last messages of the ended children, and prints the summary.
    pub fn finish(&mut self, folder: &SiteFolder) -> Summary {
        let end = Instant::now() + LAST_WORDS;
        while let Some(item) = self
            .statuses
            .recv_timeout(end.saturating_duration_since(Instant::now()))
        {
            self.take_status(item.bytes());
        }
        Summary {
            cameras: folder
                .cameras()
                .iter()
                .map(|id| summary_of(id, self.cameras.get(id)))
                .collect(),
            objects: self.score.objects(),
            latency_ms: self.score.latency(),
        }
    }

    fn glance(&mut self) -> anyhow::Result<()> {
        let end = Instant::now() + SHUTDOWN_POLL;
        while let Some(item) = self
            .poses
            .recv_timeout(end.saturating_duration_since(Instant::now()))
        {
            if let Some(Ok(pose)) = item.bytes().map(decode::<ObjectPose>) {
                self.take_pose(&pose)?;
            }
        }
        while let Some(item) = self.links.try_recv() {
            if let Some(Ok(links)) = item.bytes().map(decode::<ObjectLinks>) {
                self.take_links(&links);
            }
        }
        while let Some(item) = self.statuses.try_recv() {
            self.take_status(item.bytes());
        }
        Ok(())
    }

    fn take_pose(&mut self, message: &ObjectPose) -> anyhow::Result<()> {
        let Some(body) = self.body(&message.object) else {
            return Ok(());
        };
        let truth = body.base().world_from_object(message.capture_ns);
        let judged = ScoredPose {
            capture_ns: message.capture_ns,
            estimate: &message.world_from_object(),
            covariance: &message.covariance,
            truth: &truth,
        };
        self.score.count(message.object.as_str(), &judged);
        self.score
            .count_latency(message.capture_ns, message.published_ns);
        self.publish_truth(message, &truth)
    }

    /// Scores the links of an articulated object instead of its pose, which is that of its base.
    fn take_links(&mut self, message: &ObjectLinks) {
        let Some(body) = self.body(&message.object) else {
            return;
        };
        for (name, link) in body.links() {
            let of_name = |pose: &&LinkPose| pose.link.as_str() == name;
            if let Some(pose) = message.links.iter().find(of_name) {
                let truth = link.world_from_object(message.capture_ns);
                let judged = ScoredPose {
                    capture_ns: message.capture_ns,
                    estimate: &pose.world_from_link(),
                    covariance: &pose.covariance,
                    truth: &truth,
                };
                self.score.count(&name_of_link(&body, name), &judged);
            }
        }
    }

    fn body(&self, id: &ObjectId) -> Option<Body<'a>> {
        bodies(self.scenario).find(|body| body.id() == id.as_str())
    }

    /// Truth in the world frame of the estimates, in which the page draws both.
    fn publish_truth(&mut self, message: &ObjectPose, truth: &Pose) -> anyhow::Result<()> {
        let Some(outlet) = self.truths.get_mut(&message.object) else {
            return Ok(());
        };
        if message.capture_ns < outlet.due_ns {
            return Ok(());
        }
        outlet.due_ns = message.capture_ns + TRUTH_PERIOD_NS;
        let truth = self.score.site_from_world() * truth;
        let error = PoseError::between(&message.world_from_object(), &truth);
        let parts = PoseParts::from(&truth);
        outlet.publisher.put(&ObjectTruth {
            object: message.object.clone(),
            capture_ns: message.capture_ns,
            position: parts.position,
            orientation: parts.orientation,
            position_error_m: error.position_m(),
            attitude_error_rad: error.attitude_rad(),
        })?;
        Ok(())
    }

    fn take_status(&mut self, bytes: Option<&[u8]>) {
        if let Some(Ok(status)) = bytes.map(decode::<CameraStatus>) {
            self.cameras.insert(status.camera.clone(), status);
        }
    }
}

/// Names of the scores of an object: its own, or those of its links.
fn names(body: Body<'_>) -> Vec<String> {
    let links: Vec<String> = body
        .links()
        .map(|(name, _)| name_of_link(&body, name))
        .collect();
    if links.is_empty() {
        vec![body.id().to_owned()]
    } else {
        links
    }
}

/// Name as on the page.
fn name_of_link(body: &Body<'_>, link: &str) -> String {
    format!("{}.{link}", body.id())
}

fn summary_of(id: &CameraId, status: Option<&CameraStatus>) -> CameraSummary {
    let id = id.to_string();
    match status {
        Some(status) => CameraSummary {
            id,
            captured: status.captured,
            detected: status.detected,
            dropped: status.dropped,
        },
        None => CameraSummary {
            id,
            ..CameraSummary::default()
        },
    }
}

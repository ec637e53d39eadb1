//! The state of a site as `top` shows it. Pure: time is an argument, memory is bounded by the mirror's limits.
//!
//! What has left is shown as gone for a while. A camera of the rig is expected back and stays.

use crate::top::rows::{CameraRow, ObjectRow, PoseRate};
use crate::words;
use sextant_gateways::site::{take, take_token};
use sextant_proto::{AnyMessage, FusionStatus, Keys, NodeId, NodeKind};
use sextant_site_mirror::limits::SILENCE_NS;
use sextant_site_mirror::{Liveliness, Node, SiteMirror};
use sextant_site_model::{CameraId, ObjectId};
use sextant_site_report::{Severity, State};
use sextant_zenoh_bus::{Item, Presence};
use std::collections::BTreeMap;

/// Time for which departed cameras, nodes and objects are shown, ns.
const SHOWN_NS: u64 = 60_000_000_000;

/// The site as it is shown: what was heard of it, and rates of poses.
pub struct Board {
    /// Its keys.
    pub keys: Keys,
    /// Seconds since the router became unreachable; none while it is connected.
    pub disconnected_s: Option<f64>,
    mirror: SiteMirror,
    rates: BTreeMap<ObjectId, PoseRate>,
}

impl Board {
    /// The state before any message.
    pub fn new(keys: Keys) -> Self {
        Self {
            keys,
            disconnected_s: None,
            mirror: SiteMirror::default(),
            rates: BTreeMap::new(),
        }
    }

    /// Handles a message that arrived at `now_ns`; messages of other sites are ignored, since the fusion node counts
    /// those.
    pub fn take(&mut self, item: &Item, now_ns: u64) {
        let update = take(&self.keys, &mut self.mirror, item, now_ns);
        if let Some(AnyMessage::ObjectPose(pose)) = update.map(|update| update.message) {
            self.rates.entry(pose.object).or_default().count(now_ns);
        }
    }

    /// Handles a change of liveliness.
    pub fn presence(&mut self, presence: &Presence, now_ns: u64) {
        take_token(&self.keys, &mut self.mirror, presence, now_ns);
    }

    /// Forgets what left long ago.
    pub fn expire(&mut self, now_ns: u64) {
        self.mirror.expire(now_ns);
        self.rates.retain(|id, _| self.mirror.object(id).is_some());
    }

    /// The cameras, by name.
    pub fn cameras(&self, now_ns: u64) -> Vec<CameraRow<'_>> {
        let (intakes, clocks) = (self.mirror.intakes(), self.mirror.clocks());
        let mut rows = Vec::new();
        for (id, camera) in self.mirror.cameras() {
            let intake = intakes.get(id).copied();
            let heard_ns = camera.heard_ns();
            if intake.is_none() && !heard_ns.is_some_and(|at| is_shown(at, now_ns)) {
                continue;
            }
            rows.push(CameraRow {
                id,
                status: camera.status.as_ref().map(|status| &status.message),
                last_capture_ns: camera.last_capture_ns,
                intake,
                clock: clocks.get(id).copied(),
                gone_ns: heard_ns.filter(|at| now_ns.saturating_sub(*at) > SILENCE_NS),
                lacks_images: camera.lacks_images(0, now_ns),
            });
        }
        rows
    }

    /// The objects, by name.
    pub fn objects(&self, now_ns: u64) -> Vec<ObjectRow<'_>> {
        let objects = self.mirror.objects();
        let objects = objects.filter(|(_, object)| {
            let gone_ns = object.gone_ns;
            gone_ns.is_none_or(|gone_ns| is_shown(gone_ns, now_ns))
        });
        let row = objects.map(|(id, object)| ObjectRow {
            id,
            pose: object.pose.as_ref().map(|pose| &pose.message),
            state: object
                .recent_pose(now_ns)
                .map_or(State::Lost, |pose| pose.state),
            rate_hz: self.rates.get(id).map_or(0.0, |rate| rate.hz(now_ns)),
            gone_ns: object.gone_ns,
        });
        row.collect()
    }

    /// The processes, by kind and name.
    pub fn nodes(&self, now_ns: u64) -> impl Iterator<Item = (NodeKind, &NodeId, &Node)> {
        let intakes = self.mirror.intakes();
        self.mirror.nodes().filter(move |(kind, id, node)| {
            let is_expected = *kind == NodeKind::Camera
                && CameraId::new(id.as_str()).is_ok_and(|id| intakes.contains_key(&id));
            is_expected || is_node_shown(node, now_ns)
        })
    }

    /// The last status of each fusion node, unless that ended: then it is outdated.
    pub fn fusion(&self, now_ns: u64) -> Vec<&FusionStatus> {
        let statuses = self.mirror.statuses();
        let is_there = |status: &&FusionStatus| {
            let node = self.mirror.node(NodeKind::Fusion, &status.node);
            node.is_none_or(|node| is_node_shown(node, now_ns))
        };
        statuses.filter(is_there).collect()
    }

    /// What calls for action, with its source.
    pub fn faults(&self, now_ns: u64) -> Vec<(String, String)> {
        let mut faults = match self.disconnected_s {
            // Without the router everything is silent, which says nothing about the nodes.
            Some(seconds) => {
                let words =
                    format!("the router has not answered for {seconds:.0} s; waiting for it");
                vec![("network".to_owned(), words)]
            }
            None => self.silences(now_ns),
        };
        faults.extend(self.reports(now_ns, Severity::Fault));
        faults
    }

    /// What may be improved, with its source.
    pub fn information(&self, now_ns: u64) -> Vec<(String, String)> {
        self.reports(now_ns, Severity::Information).collect()
    }

    /// What nodes report.
    fn reports(&self, now_ns: u64, severity: Severity) -> impl Iterator<Item = (String, String)> {
        let fusion = words::merged_findings(self.fusion(now_ns).into_iter());
        let cameras = self.cameras(now_ns).into_iter();
        let cameras = cameras.filter_map(|row| Some(words::camera_findings(row.status?)));
        let all = fusion.into_iter().chain(cameras.flatten());
        let wanted = all.filter(move |finding| finding.severity == severity);
        wanted.map(|finding| (finding.from, finding.words))
    }

    /// Names of silent nodes.
    fn silences(&self, now_ns: u64) -> Vec<(String, String)> {
        let mut silences = Vec::new();
        for (kind, id, node) in self.nodes(now_ns) {
            let who = format!("{} node {id}", kind.as_str());
            if node.liveliness == Liveliness::Gone {
                silences.push(("network".to_owned(), format!("{who} is gone")));
            } else if kind != NodeKind::Viewer && node.is_silent(now_ns) {
                let age_s = now_ns.saturating_sub(node.heard_ns.unwrap_or(0)) as f64 * 1e-9;
                let words = format!("{who} has been silent for {age_s:.0} s");
                silences.push(("network".to_owned(), words));
            }
        }
        if self.mirror.statuses().next().is_none() {
            let words = "no fusion node has published a status yet".to_owned();
            silences.push(("network".to_owned(), words));
        }
        silences
    }
}

/// Whether what left at this time is still shown.
fn is_shown(left_ns: u64, now_ns: u64) -> bool {
    now_ns.saturating_sub(left_ns) <= SHOWN_NS
}

fn is_node_shown(node: &Node, now_ns: u64) -> bool {
    let is_up = node.liveliness != Liveliness::Gone;
    is_up || node.heard_ns.is_some_and(|at| is_shown(at, now_ns))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use sextant_proto::{
        CameraClock, CameraIntake, CameraStatus, ClockQuality, ClockReport, ClockSource, Message,
        Notice, ObjectHealth, ObjectPose, Rejections, encode,
    };
    use sextant_site_model::TagId;
    use sextant_site_report::{Fault, Imperfection, State};
    use sextant_tag_families::Family;
    use sextant_zenoh_bus::Payload;

    /// The message of a golden file of the contract.
    macro_rules! golden {
        ($name:literal) => {
            serde_json::from_str(include_str!(concat!("../../../proto/golden/", $name))).unwrap()
        };
    }

    pub const NOW_NS: u64 = 1_800_000_000_000_000_000;

    fn item<M: Message>(key: String, message: &M) -> Item {
        Item {
            key,
            payload: Payload::Bytes(encode(message).unwrap()),
            sender: None,
        }
    }

    fn fusion_status(objects: &[&str], faults: Vec<Fault>) -> FusionStatus {
        let north = CameraIntake {
            camera: CameraId::new("north").unwrap(),
            received: 300,
            rejected: Rejections {
                damaged: 2,
                ..Rejections::default()
            },
            unknown_tags: 9,
            late: 8,
            gated: 10,
            last_capture_ns: NOW_NS - 40_000_000,
            rate_hz: 30.0,
        };
        let health = |id: &&str| ObjectHealth {
            object: ObjectId::new(id).unwrap(),
            state: State::Tracking,
            rate_hz: 30.0,
        };
        FusionStatus {
            node: NodeId::new("fusion").unwrap(),
            epoch: Some(1),
            cameras: vec![north],
            foreign: Rejections::default(),
            objects: objects.iter().map(health).collect(),
            faults,
            faults_left_out: 0,
            imperfections: vec![],
            notices: vec![],
            ..golden!("fusion_status.json")
        }
    }

    fn pose(object: &str) -> ObjectPose {
        ObjectPose {
            object: ObjectId::new(object).unwrap(),
            capture_ns: NOW_NS - 30_000_000,
            published_ns: NOW_NS - 9_500_000,
            position: [0.1, -0.2, 0.3],
            covariance: std::array::from_fn(|k| if k % 7 == 0 { 1e-8 } else { 0.0 }),
            cameras: 3,
            tags: 5,
            ..golden!("object_pose.json")
        }
    }

    /// A site of one camera and two objects, one of them seen a second ago and now.
    pub fn board() -> Board {
        let keys = Keys::new("lab").unwrap();
        let (north, node) = (
            CameraId::new("north").unwrap(),
            NodeId::new("fusion").unwrap(),
        );
        let mut board = Board::new(keys.clone());
        let status = CameraStatus {
            camera: north.clone(),
            dropped: 10,
            rate_hz: 29.9,
            detect_ms: [3.25, 4.5],
            clock: ClockQuality {
                source: ClockSource::Ntp,
                error_ns: 250_000,
            },
            fallbacks: 0,
            controls: sextant_proto::CameraControls::default(),
            notices: vec![],
            ..golden!("camera_status.json")
        };
        board.take(&item(keys.camera_status(&north), &status), NOW_NS);
        let moved = Fault::CameraMoved {
            camera: north.clone(),
        };
        let fusion = fusion_status(&["ball", "cube"], vec![moved]);
        board.take(&item(keys.fusion_status(&node), &fusion), NOW_NS);
        let clock = CameraClock {
            camera: north,
            offset_s: -0.0125,
            sigma_s: 0.0001,
            drift: Some(2.5e-5),
        };
        let report = ClockReport {
            node: node.clone(),
            cameras: vec![clock],
        };
        board.take(&item(keys.clocks(&node), &report), NOW_NS);
        let key = keys.pose(&ObjectId::new("cube").unwrap());
        for k in 0..30 {
            let at_ns = NOW_NS - 1_000_000_000 + k * 33_333_333;
            board.take(&item(key.clone(), &pose("cube")), at_ns);
        }
        board
    }

    fn words(board: &Board, now_ns: u64) -> Vec<String> {
        let faults = board.faults(now_ns).into_iter();
        faults.map(|(_, words)| words).collect()
    }

    /// The same after the fusion node has dropped the cube, and the camera has left.
    pub fn left_board() -> Board {
        let mut board = board();
        let node = NodeId::new("fusion").unwrap();
        let key = board.keys.fusion_status(&node);
        let status = fusion_status(&["ball"], vec![]);
        board.take(&item(key, &status), NOW_NS + 1_000_000_000);
        board
    }

    #[test]
    fn rates_and_states_are_those_of_the_last_seconds() {
        let board = board();
        let row = |at: usize, now_ns: u64| {
            let rows = board.objects(now_ns);
            (rows[at].id.to_string(), rows[at].state, rows[at].rate_hz)
        };
        let (id, state, rate_hz) = row(1, NOW_NS);
        assert_eq!((id.as_str(), state), ("cube", State::Tracking));
        assert!((rate_hz - 30.0).abs() < 1.5);
        let later_ns = NOW_NS + 5_000_000_000;
        assert_eq!(row(1, later_ns), (id, State::Lost, 0.0));
        assert_eq!(row(0, NOW_NS), ("ball".to_owned(), State::Lost, 0.0));
    }

    #[test]
    fn faults_and_silence_are_shown() {
        let mut board = board();
        assert_eq!(
            words(&board, NOW_NS),
            ["camera north is not where the rig says: calibrate it again"]
        );
        let later = NOW_NS + 4_000_000_000;
        let said = words(&board, later);
        assert!(
            said.contains(&"fusion node fusion has been silent for 4 s".to_owned()),
            "{said:?}"
        );
        assert!(
            said.contains(&"camera node north has been silent for 4 s".to_owned()),
            "{said:?}"
        );
        let gone = Presence::Left("sextant/v1/lab/alive/camera/north".to_owned());
        board.presence(&gone, NOW_NS);
        assert_eq!(words(&board, NOW_NS)[0], "camera node north is gone");
        // Without the router everything is silent, which says nothing about the nodes.
        board.disconnected_s = Some(5.2);
        let said = words(&board, NOW_NS);
        assert_eq!(said.len(), 2, "{said:?}");
        assert_eq!(
            said[0],
            "the router has not answered for 5 s; waiting for it"
        );
    }

    #[test]
    fn errors_of_files_and_proposals_are_no_faults() {
        let mut board = board();
        let key = board.keys.fusion_status(&NodeId::new("fusion").unwrap());
        let mut status = fusion_status(&["ball"], vec![]);
        let camera = CameraId::new("north").unwrap();
        status.imperfections = vec![Imperfection::FocalLengthOff {
            camera,
            ratio: 1.003,
        }];
        status.notices = vec![Notice::RefinementProposed {
            n_images: 48,
            before_px: 2.0,
            after_px: 0.3,
        }];
        board.take(&item(key, &status), NOW_NS);
        assert_eq!(words(&board, NOW_NS), Vec::<String>::new());
        assert_eq!(board.information(NOW_NS).len(), 2);
    }

    #[test]
    fn a_fault_that_two_fusion_nodes_report_is_listed_once() {
        let mut board = board();
        let standby = NodeId::new("standby").unwrap();
        let moved = Fault::CameraMoved {
            camera: CameraId::new("north").unwrap(),
        };
        let size = |ratio| Fault::TagSize {
            object: ObjectId::new("ball").unwrap(),
            tag: TagId {
                family: Family::Tag36h11,
                id: 3,
            },
            ratio,
        };
        let key = board.keys.fusion_status(&standby);
        let mut status = fusion_status(&["ball"], vec![moved.clone(), size(1.02)]);
        status.node = standby;
        status.epoch = None;
        board.take(&item(key.clone(), &status), NOW_NS);
        let first = "camera north is not where the rig says: calibrate it again";
        // Of its own share of the objects each node alone reports faults.
        let said = words(&board, NOW_NS);
        assert_eq!(said.len(), 2, "{said:?}");
        assert_eq!(said[0], first);
        let other = NodeId::new("fusion").unwrap();
        let key = board.keys.fusion_status(&other);
        let fusion = fusion_status(&["ball", "cube"], vec![moved, size(1.03)]);
        board.take(&item(key, &fusion), NOW_NS);
        let from: Vec<String> = board
            .faults(NOW_NS)
            .into_iter()
            .map(|(from, _)| from)
            .collect();
        assert_eq!(from, ["fusion", "fusion"]);
    }

    #[test]
    fn an_object_that_the_fusion_node_has_no_more_is_gone() {
        let board = left_board();
        let left_ns = NOW_NS + 1_000_000_000;
        let gone = |now_ns: u64| -> Vec<(String, Option<u64>)> {
            let rows = board.objects(now_ns).into_iter();
            rows.map(|row| (row.id.to_string(), row.gone_ns)).collect()
        };
        let expected = [
            ("ball".to_owned(), None),
            ("cube".to_owned(), Some(left_ns)),
        ];
        assert_eq!(gone(left_ns + SHOWN_NS), expected);
        assert_eq!(gone(left_ns + SHOWN_NS + 1), expected[..1]);
    }

    #[test]
    fn a_camera_that_left_is_dropped_unless_the_rig_expects_it() {
        let mut board = board();
        let later_ns = NOW_NS + SHOWN_NS + 1;
        assert_eq!(board.cameras(later_ns)[0].gone_ns, Some(NOW_NS));
        let node = NodeId::new("fusion").unwrap();
        let key = board.keys.fusion_status(&node);
        let mut status = fusion_status(&["ball"], vec![]);
        status.cameras.clear();
        board.take(&item(key, &status), later_ns);
        assert!(board.cameras(later_ns).is_empty());
    }
}

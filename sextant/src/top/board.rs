//! The state of a site according to the messages of its nodes. Pure: time is an argument, memory is bounded.

use crate::top::rows::{CameraRow, NodeRow, ObjectRow, SILENCE_S};
use crate::words;
use sextant_proto::{
    CameraStatus, ClockReport, FusionStatus, KeyRef, Keys, NodeId, NodeKind, ObjectPose,
    Observations,
};
use sextant_site_model::{CameraId, ObjectId};
use sextant_zenoh_bus::{Item, Presence};
use std::collections::BTreeMap;

/// Most cameras, objects and nodes of each kind: a flood of invented names must not fill the memory.
const MOST: usize = 1024;

/// The site.
pub struct Board {
    /// Its keys.
    pub keys: Keys,
    /// Its cameras.
    pub cameras: BTreeMap<CameraId, CameraRow>,
    /// Its objects.
    pub objects: BTreeMap<ObjectId, ObjectRow>,
    /// All nodes that have ever been seen.
    pub nodes: BTreeMap<(NodeKind, NodeId), NodeRow>,
    /// Last status of each fusion node.
    pub fusion: BTreeMap<NodeId, FusionStatus>,
    /// Seconds since the router became unreachable; none while it is connected.
    pub disconnected_s: Option<f64>,
}

impl Board {
    /// The state before any message.
    pub fn new(keys: Keys) -> Self {
        Self {
            keys,
            cameras: BTreeMap::new(),
            objects: BTreeMap::new(),
            nodes: BTreeMap::new(),
            fusion: BTreeMap::new(),
            disconnected_s: None,
        }
    }

    /// Handles a message that arrived at `now_ns`; messages of other sites are ignored, since the fusion node counts those.
    pub fn take(&mut self, item: &Item, now_ns: u64) {
        match self.keys.parse(&item.key) {
            Some(KeyRef::CameraStatus(id)) => {
                if let Ok(status) = item.decode::<CameraStatus>() {
                    self.heard(NodeKind::Camera, id.as_str(), now_ns);
                    if let Some(row) = entry(&mut self.cameras, id) {
                        row.status = Some(status);
                        row.heard_ns = row.heard_ns.max(now_ns);
                    }
                }
            }
            Some(KeyRef::Observations(id)) => {
                if let Ok(image) = item.decode::<Observations>()
                    && let Some(row) = entry(&mut self.cameras, id)
                {
                    row.last_capture_ns = row.last_capture_ns.max(image.capture_ns);
                    row.heard_ns = row.heard_ns.max(now_ns);
                }
            }
            Some(KeyRef::Pose(id)) => {
                if let Ok(pose) = item.decode::<ObjectPose>() {
                    self.pose(id, pose, now_ns);
                }
            }
            Some(KeyRef::FusionStatus(id)) => {
                if let Ok(status) = item.decode::<FusionStatus>() {
                    self.heard(NodeKind::Fusion, id.as_str(), now_ns);
                    self.fusion_status(id, status, now_ns);
                }
            }
            Some(KeyRef::Clocks(_)) => {
                if let Ok(report) = item.decode::<ClockReport>() {
                    self.clocks(report);
                }
            }
            _ => {}
        }
    }

    /// Handles a change of liveliness.
    pub fn presence(&mut self, presence: &Presence, now_ns: u64) {
        let (key, up) = match presence {
            Presence::Joined(key) => (key, true),
            Presence::Left(key) => (key, false),
        };
        if let Some(KeyRef::Alive(kind, id)) = self.keys.parse(key)
            && let Some(row) = entry(&mut self.nodes, (kind, id))
        {
            row.up = up;
            row.heard_ns = row.heard_ns.max(if up { now_ns } else { 0 });
        }
    }

    fn heard(&mut self, kind: NodeKind, id: &str, now_ns: u64) {
        if let Ok(id) = NodeId::new(id)
            && let Some(row) = entry(&mut self.nodes, (kind, id))
        {
            *row = NodeRow {
                up: true,
                heard_ns: now_ns,
            };
        }
    }

    fn pose(&mut self, id: ObjectId, pose: ObjectPose, now_ns: u64) {
        let Some(row) = entry(&mut self.objects, id) else {
            return;
        };
        row.take(pose, now_ns);
    }

    /// The fusion nodes report which objects exist and which cameras the rig has.
    fn fusion_status(&mut self, node: NodeId, status: FusionStatus, now_ns: u64) {
        for intake in &status.cameras {
            if let Some(row) = entry(&mut self.cameras, intake.camera.clone()) {
                row.last_capture_ns = row.last_capture_ns.max(intake.last_capture_ns);
                row.intake = Some(intake.clone());
            }
        }
        for object in &status.objects {
            entry(&mut self.objects, object.object.clone());
        }
        if self.fusion.len() < MOST || self.fusion.contains_key(&node) {
            self.fusion.insert(node, status);
        }
        self.compare_with_statuses(now_ns);
    }

    fn clocks(&mut self, report: ClockReport) {
        for row in self.cameras.values_mut() {
            row.clock = None;
        }
        for clock in report.cameras {
            if let Some(row) = entry(&mut self.cameras, clock.camera.clone()) {
                row.clock = Some(clock);
            }
        }
    }

    /// Descriptions of faults, with their source.
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
        faults.extend(words::merged_findings(self.fusion.values()));
        let cameras = self
            .cameras
            .iter()
            .filter_map(|(id, row)| Some((id, row.status.as_ref()?)));
        faults.extend(cameras.flat_map(|(id, status)| {
            let findings = words::camera_findings(status).into_iter();
            findings.map(|finding| (id.to_string(), finding))
        }));
        faults
    }

    /// Names of silent nodes.
    fn silences(&self, now_ns: u64) -> Vec<(String, String)> {
        let mut silences = Vec::new();
        for ((kind, id), row) in &self.nodes {
            let age_s = now_ns.saturating_sub(row.heard_ns) as f64 * 1e-9;
            // A viewer publishes only its liveliness.
            let is_missed = *kind != NodeKind::Viewer && age_s > SILENCE_S;
            let who = format!("{} node {id}", kind.as_str());
            if !row.up {
                silences.push(("network".to_owned(), format!("{who} is gone")));
            } else if is_missed {
                let words = format!("{who} has been silent for {age_s:.0} s");
                silences.push(("network".to_owned(), words));
            }
        }
        if self.fusion.is_empty() {
            let words = "no fusion node has published a status yet".to_owned();
            silences.push(("network".to_owned(), words));
        }
        silences
    }
}

/// The row of a name; none when there are too many.
fn entry<K: Ord, R: Default>(rows: &mut BTreeMap<K, R>, key: K) -> Option<&mut R> {
    if rows.len() >= MOST && !rows.contains_key(&key) {
        return None;
    }
    Some(rows.entry(key).or_default())
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use sextant_proto::{
        CameraClock, CameraIntake, ClockQuality, ClockSource, Message, ObjectHealth, Rejections,
        encode,
    };
    use sextant_site_model::TagId;
    use sextant_site_report::{Fault, State};
    use sextant_tag_families::Family;
    use sextant_zenoh_bus::Payload;

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
            version: "0.1.0".into(),
            uptime_s: 60,
            epoch: Some(1),
            cameras: vec![north],
            foreign: Rejections::default(),
            objects: objects.iter().map(health).collect(),
            faults,
            faults_left_out: 0,
            imperfections: vec![],
            notices: vec![],
        }
    }

    fn pose(object: &str) -> ObjectPose {
        ObjectPose {
            object: ObjectId::new(object).unwrap(),
            epoch: 1,
            sequence: 7,
            capture_ns: NOW_NS - 30_000_000,
            published_ns: NOW_NS - 9_500_000,
            state: State::Tracking,
            position: [0.1, -0.2, 0.3],
            orientation: [0.0, 0.0, 0.0, 1.0],
            covariance: std::array::from_fn(|k| if k % 7 == 0 { 1e-8 } else { 0.0 }),
            twist: [0.0; 6],
            cameras: 3,
            tags: 5,
            rms_px: 0.1,
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
            version: "0.1.0".into(),
            host: "board".into(),
            captured: 310,
            detected: 300,
            dropped: 10,
            rate_hz: 29.9,
            detect_ms: [3.25, 4.5],
            clock: ClockQuality {
                source: ClockSource::Ntp,
                error_ns: 250_000,
            },
            uptime_s: 10,
            published: 300,
            fallbacks: 0,
            brightness: 0.0,
            controls: sextant_proto::CameraControls::default(),
            notices: vec![],
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

    #[test]
    fn rates_and_states_are_those_of_the_last_seconds() {
        let board = board();
        let cube = &board.objects[&ObjectId::new("cube").unwrap()];
        assert!((cube.rate_hz(NOW_NS) - 30.0).abs() < 1.5);
        assert_eq!(cube.state(NOW_NS), State::Tracking);
        assert_eq!(cube.state(NOW_NS + 5_000_000_000), State::Lost);
        assert_eq!(cube.rate_hz(NOW_NS + 5_000_000_000), 0.0);
        let ball = &board.objects[&ObjectId::new("ball").unwrap()];
        assert_eq!(ball.state(NOW_NS), State::Lost);
    }

    #[test]
    fn faults_and_silence_are_told() {
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
        let mut board = board();
        let node = NodeId::new("fusion").unwrap();
        let status = fusion_status(&["ball"], vec![]);
        let key = board.keys.fusion_status(&node);
        board.take(&item(key, &status), NOW_NS);
        let gone = |board: &Board| -> Vec<(String, Option<u64>)> {
            let rows = board.objects.iter();
            rows.map(|(id, row)| (id.to_string(), row.gone_ns))
                .collect()
        };
        let expected = [("ball".to_owned(), None), ("cube".to_owned(), Some(NOW_NS))];
        assert_eq!(gone(&board), expected);
        board.see_off(NOW_NS + 59_000_000_000);
        assert_eq!(gone(&board), expected);
        board.see_off(NOW_NS + 61_000_000_000);
        assert_eq!(gone(&board), expected[..1]);
    }

    #[test]
    fn a_flood_of_names_ends_at_the_bound() {
        let mut board = Board::new(Keys::new("lab").unwrap());
        for k in 0..2 * MOST {
            let id = ObjectId::new(&format!("o{k}")).unwrap();
            let key = board.keys.pose(&id);
            board.take(&item(key, &pose("cube")), NOW_NS);
        }
        assert_eq!(board.objects.len(), MOST);
    }
}

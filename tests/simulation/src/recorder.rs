//! A recorder at the site that misses nothing: from what it has, each fusion node's poses follow again, bit for bit.

use crate::world::node;
use node_fusion::Put;
use sextant_proto::{
    AnyMessage, FusionInputs, KeyRef, Keys, NodeId, ObjectPose, Observations, fingerprint,
};
use sextant_recordings::mcap::RecordingInfo;
use sextant_recordings::mcap::reader::Ending;
use sextant_recordings::mcap::site_recording::{Model, RecordedModel, SiteRecording, Timed};
use sextant_replay::{Order, Plan, Replacement, ReplayError, ReplayObserver, replay_plan};
use sextant_site_report::ObjectEstimate;
use std::collections::BTreeMap;

/// What it has.
#[derive(Default)]
pub struct Recorder {
    observations: Vec<Timed<Observations>>,
    models: Vec<Timed<RecordedModel>>,
    inputs: BTreeMap<NodeId, Vec<FusionInputs>>,
    poses: BTreeMap<NodeId, Vec<ObjectPose>>,
}

impl Recorder {
    /// A camera's message.
    pub fn image(&mut self, message: &Observations, arrival_ns: u64) {
        let item = message.clone();
        self.observations.push(Timed { arrival_ns, item });
    }

    /// A message of a fusion node.
    pub fn message(&mut self, index: usize, keys: &Keys, put: &Put, arrival_ns: u64) {
        let Ok(message) = AnyMessage::decode(&put.payload) else {
            return;
        };
        let model = match (keys.parse(&put.key), message) {
            (Some(KeyRef::Inputs(node)), AnyMessage::FusionInputs(inputs)) => {
                return self.inputs.entry(node).or_default().push(inputs);
            }
            (Some(KeyRef::Pose(_)), AnyMessage::ObjectPose(pose)) => {
                return self.poses.entry(node(index)).or_default().push(*pose);
            }
            (Some(KeyRef::ConfigRig), AnyMessage::RigConfig(rig)) => Model::Rig(rig),
            (Some(KeyRef::ConfigObject(_)), AnyMessage::ObjectConfig(one)) => Model::Object(one),
            _ => return,
        };
        let fingerprint = fingerprint(&put.payload);
        let item = RecordedModel { fingerprint, model };
        self.models.push(Timed { arrival_ns, item });
    }

    /// What a replay gives that was not so, if it does.
    pub fn contradiction(self) -> Option<String> {
        let mut recording = SiteRecording {
            info: RecordingInfo::default(),
            ending: Ending::Closed,
            observations: self.observations,
            models: self.models,
            inputs: self.inputs,
            poses: Vec::new(),
            truths: Vec::new(),
            images: BTreeMap::new(),
            rejected: 0,
            rejected_models: 0,
        };
        self.poses.into_iter().find_map(|(node, poses)| {
            recording.poses = poses;
            contradiction(&recording, &node)
        })
    }
}

fn contradiction(recording: &SiteRecording, node: &NodeId) -> Option<String> {
    let plan = match Plan::new(recording, Some(node), &Replacement::default()) {
        Ok(plan) => plan,
        Err(cause) => return Some(format!("{node}: {cause}")),
    };
    // A standby does not publish what it takes in: nobody has its inputs from before it took over.
    if !matches!(plan.order, Order::Inputs { first: 0, .. }) {
        return None;
    }
    if plan.missing > 0 {
        return Some(format!("{node}: {} images are missing", plan.missing));
    }
    match replay_plan(plan, &recording.poses, &mut Idle) {
        Ok(replayed) => {
            let live = replayed.live.unwrap_or_default();
            // Of a node that was in charge for a moment hardly anything can be compared.
            let is_wrong = live.different > 0 || recording.poses.len() > 100 && live.identical == 0;
            is_wrong.then(|| format!("{node}: {live:?}"))
        }
        Err(cause) => Some(format!("{node}: {cause}")),
    }
}

/// Does not follow the replay.
struct Idle;

impl ReplayObserver for Idle {
    type Error = ReplayError;

    fn before(&mut self, _: u64) -> Result<(), ReplayError> {
        Ok(())
    }

    fn take(&mut self, _: &[ObjectEstimate]) -> Result<(), ReplayError> {
        Ok(())
    }
}

//! The log of the estimator's inputs, from the first image on, so that a recording replays to identical poses.
//!
//! In: each input and the time given to the estimator with it. Out: numbered batches. Knows neither network nor clock.

use crate::models::ModelsInForce;
use sextant_proto::{
    FusionInput, FusionInputs, InputSource, NodeId, ObjectConfig, RigConfig, encode, fingerprint,
};
use sextant_site_model::{ObjectModel, Rig};

/// Longest delay of an input in this log, ns.
const DELAY_NS: u64 = 100_000_000;
/// Inputs of a batch, few enough for the longest message whatever their names.
const BATCH: usize = 128;

/// Inputs that are not published yet.
#[derive(Debug)]
pub struct InputLog {
    node: NodeId,
    /// Number of the first pending input.
    first: u64,
    pending: Vec<FusionInput>,
    has_begun: bool,
}

impl InputLog {
    /// An empty log of this node's inputs.
    pub fn new(node: NodeId) -> Self {
        Self {
            node,
            first: 0,
            pending: Vec::new(),
            has_begun: false,
        }
    }

    /// Adds an image; before the first, the models in force, with which the estimator has begun.
    pub fn add_image(&mut self, now_ns: u64, image: InputSource, models: &ModelsInForce) {
        if !self.has_begun {
            self.has_begun = true;
            self.push(now_ns, source_of_rig(&models.rig));
            self.push(now_ns, source_of_objects(&models.objects));
        }
        self.push(now_ns, image);
    }

    /// Adds another input. Before the first image the estimator has no state: it makes no difference.
    pub fn add(&mut self, now_ns: u64, source: InputSource) {
        if self.has_begun {
            self.push(now_ns, source);
        }
    }

    fn push(&mut self, now_ns: u64, source: InputSource) {
        self.pending.push(FusionInput { now_ns, source });
    }

    /// The next batch: of inputs that waited long enough, or as many as a message holds.
    pub fn poll(&mut self, now_ns: u64) -> Option<FusionInputs> {
        let oldest_ns = self.pending.first()?.now_ns;
        let is_due = self.pending.len() >= BATCH || now_ns.abs_diff(oldest_ns) >= DELAY_NS;
        is_due.then(|| self.batch())
    }

    /// Objects have a message of their own, since there may be many.
    fn batch(&mut self) -> FusionInputs {
        let is_long = |input: &FusionInput| matches!(input.source, InputSource::Objects(_));
        let before = self.pending.iter().position(is_long);
        let n_inputs = before.map_or(self.pending.len(), |before| before.max(1));
        let inputs: Vec<_> = self.pending.drain(..n_inputs.min(BATCH)).collect();
        let first = self.first;
        self.first += inputs.len() as u64;
        FusionInputs {
            node: self.node.clone(),
            first,
            inputs,
        }
    }
}

/// A rig as it is announced; models in force can be encoded.
pub fn source_of_rig(rig: &Rig) -> InputSource {
    let payload = encode(&RigConfig::from(rig)).unwrap_or_default();
    InputSource::Rig(fingerprint(&payload))
}

/// All objects as they are announced.
pub fn source_of_objects(objects: &[ObjectModel]) -> InputSource {
    let payloads = objects
        .iter()
        .map(|object| encode(&ObjectConfig::from(object)).unwrap_or_default());
    InputSource::Objects(payloads.map(|payload| fingerprint(&payload)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log() -> (InputLog, ModelsInForce) {
        let rig = Rig::new(Vec::new()).unwrap();
        let objects = Vec::new();
        let log = InputLog::new(NodeId::new("main").unwrap());
        let settings = Default::default();
        (
            log,
            ModelsInForce {
                rig,
                objects,
                settings,
            },
        )
    }

    fn image(sequence: u64) -> InputSource {
        InputSource::Image {
            camera: sextant_site_model::CameraId::new("north").unwrap(),
            sequence,
            capture_ns: 7,
        }
    }

    #[test]
    fn a_log_begins_with_the_models_before_the_first_image_and_has_no_gap() {
        let (mut log, models) = log();
        log.add(5, InputSource::Tick);
        log.add_image(10, image(1), &models);
        log.add(11, InputSource::Tick);
        assert_eq!(log.poll(10 + DELAY_NS - 1), None);
        let batches: Vec<_> = std::iter::from_fn(|| log.poll(10 + DELAY_NS)).collect();
        let firsts: Vec<_> = batches.iter().map(|batch| batch.first).collect();
        // Rig, objects, and the rest.
        assert_eq!(firsts, [0, 1, 2]);
        let sources = batches.into_iter().flat_map(|batch| batch.inputs);
        let sources: Vec<_> = sources.map(|input| input.source).collect();
        let models = [
            source_of_rig(&models.rig),
            source_of_objects(&models.objects),
        ];
        assert_eq!(sources[..2], models);
        assert_eq!(sources[2..], [image(1), InputSource::Tick]);
    }

    #[test]
    fn a_burst_is_split_and_every_batch_can_be_encoded() {
        let (mut log, models) = log();
        for sequence in 0..1000 {
            log.add_image(sequence, image(u64::MAX - sequence), &models);
            log.add(sequence, InputSource::Objects(vec![u64::MAX; 1024]));
        }
        let batches: Vec<_> = std::iter::from_fn(|| log.poll(u64::MAX)).collect();
        assert!(batches.iter().all(|batch| encode(batch).is_ok()));
        let n_inputs: usize = batches.iter().map(|batch| batch.inputs.len()).sum();
        assert_eq!(n_inputs, 2002);
    }
}

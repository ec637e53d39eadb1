//! What a recorded fusion node took in, in its order and with its times; where the recording lacks that, observations
//! in order of arrival.

use sextant_estimator::Input;
use sextant_proto::{FusionInputs, InputSource, NodeId, ObjectConfig, Observations, RigConfig};
use sextant_recordings::mcap::site_recording::{Model, SiteRecording};
use sextant_site_model::{CameraId, ImageObservation, ObjectModel, Rig};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Why a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The fusion node is not in it.
    #[error("the recording has no inputs of the fusion node {0}")]
    UnknownNode(NodeId),
    /// There is no rig, neither recorded nor given.
    #[error("the recording has no rig: no fusion node was running; name a rig file with --rig")]
    NoRig,
    /// There is a rig, or were objects, in a layout that is not known.
    #[error(
        "the recorded rig cannot be read: {0} of its rigs and objects are damaged or in the layout of another version \
         of Sextant; name files with --rig and --object"
    )]
    UnreadableModels(u64),
    /// There are pictures in place of detections.
    #[error(
        "the recording has {0} pictures and no detections: replay the folder that it was converted from, or run \
         `sextant detect --dataset` there and convert it again"
    )]
    Undetected(u64),
    /// The recorded rig breaks a rule of rigs.
    #[error("the recorded rig cannot be used: {0}")]
    Rig(String),
    /// A recorded object breaks a rule of objects.
    #[error("a recorded object cannot be used: {0}")]
    Object(String),
    /// There is no input.
    #[error("nothing to replay")]
    Empty,
}

/// The inputs of a replay.
#[derive(Debug)]
pub struct Plan {
    /// Runs of the node; a new one begins where it was restarted.
    pub runs: Vec<Run>,
    /// Where order and times come from.
    pub order: Order,
    /// Inputs whose observations the recording lacks.
    pub missing: usize,
    /// Whether the inputs say when each adjustment of the files applied: they are whole from the node's start on, with
    /// the models that it had. Otherwise adjustments are solved as they come.
    pub are_adjustments_known: bool,
}

/// One run of a fusion node.
#[derive(Debug)]
pub struct Run {
    /// Rig at its begin.
    pub rig: Rig,
    /// Objects at its begin, in the order of the estimator.
    pub objects: Vec<ObjectModel>,
    /// Its inputs with the times given to the estimator.
    pub steps: Vec<(u64, Input)>,
}

/// Where the order of the inputs comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Order {
    /// From a node's inputs.
    Inputs {
        /// The node.
        node: NodeId,
        /// Number of its first recorded input; 0 where the recording has all of them.
        first: u64,
    },
    /// From the arrival at the recorder.
    Arrival {
        /// Why not from a node's inputs.
        cause: String,
    },
}

/// Models that replace the recorded ones.
#[derive(Debug, Default)]
pub struct Replacement {
    /// The rig.
    pub rig: Option<Rig>,
    /// All objects.
    pub objects: Option<Vec<ObjectModel>>,
}

impl Run {
    /// With the images at the middle of their exposures, by the rig in force.
    fn timed(mut self) -> Self {
        let mut rig = self.rig.clone();
        for (_, input) in &mut self.steps {
            match input {
                Input::Image(image) => *image = rig.timed(image.clone()),
                Input::Rig(after) => rig = after.clone(),
                Input::Objects(_) | Input::ClockStep { .. } | Input::Adjusted | Input::Tick => {}
            }
        }
        self
    }
}

impl Plan {
    /// The plan of a recording; `node` is whose inputs are replayed, by default the node with the most.
    ///
    /// # Errors
    /// A recording without rig or objects, or with models that cannot be used.
    pub fn new(
        recording: &SiteRecording,
        node: Option<&NodeId>,
        replacement: &Replacement,
    ) -> Result<Self, PlanError> {
        let pictures = recording.images.values().sum();
        if recording.observations.is_empty() && pictures > 0 {
            return Err(PlanError::Undetected(pictures));
        }
        let planner = Planner::new(recording, replacement);
        let by_size = recording.inputs.iter().max_by_key(|(_, all)| all.len());
        let chosen = match node {
            Some(node) => {
                let inputs = recording.inputs.get_key_value(node);
                Some(inputs.ok_or_else(|| PlanError::UnknownNode(node.clone()))?)
            }
            None => by_size,
        };
        let Some((node, inputs)) = chosen else {
            let cause = "it has no inputs of a fusion node".to_owned();
            return planner.by_arrival(cause);
        };
        match planner.by_inputs(node, inputs) {
            Ok(plan) => Ok(plan),
            Err(cause) => planner.by_arrival(cause),
        }
    }

    fn timed(mut self) -> Self {
        self.runs = self.runs.into_iter().map(Run::timed).collect();
        self
    }

    /// Capture times of all images.
    pub fn capture_times_ns(&self) -> impl Iterator<Item = u64> {
        let steps = self.runs.iter().flat_map(|run| &run.steps);
        steps.filter_map(|(_, input)| match input {
            Input::Image(image) => Some(image.capture_ns),
            _ => None,
        })
    }

    /// Number of images of each camera.
    pub fn images(&self) -> BTreeMap<CameraId, usize> {
        let mut images = BTreeMap::new();
        for (_, input) in self.runs.iter().flat_map(|run| &run.steps) {
            if let Input::Image(image) = input {
                *images.entry(image.camera.clone()).or_default() += 1;
            }
        }
        images
    }

    /// From when until when the inputs of each run are, ns. Where the clock of the node was set a new span begins.
    pub fn spans_ns(&self) -> Vec<RangeInclusive<u64>> {
        let mut spans = Vec::new();
        for run in &self.runs {
            let is_set = |input: &Input| matches!(input, Input::ClockStep { .. });
            let between = run.steps.chunk_by(|_, (_, next)| !is_set(next));
            spans.extend(between.filter_map(|steps| {
                let times_ns = steps.iter().map(|(now_ns, _)| *now_ns);
                Some(times_ns.clone().min()?..=times_ns.max()?)
            }));
        }
        spans
    }
}

type ImageKey<'a> = (&'a CameraId, u64, u64);

struct Planner<'a> {
    recording: &'a SiteRecording,
    replacement: &'a Replacement,
    observations: BTreeMap<ImageKey<'a>, &'a Observations>,
    models: BTreeMap<u64, &'a Model>,
}

impl<'a> Planner<'a> {
    fn new(recording: &'a SiteRecording, replacement: &'a Replacement) -> Self {
        let observations = recording.observations.iter().map(|timed| {
            let image = &timed.item;
            ((&image.camera, image.sequence, image.capture_ns), image)
        });
        let models = recording.models.iter();
        let models = models.map(|timed| (timed.item.fingerprint, &timed.item.model));
        Self {
            recording,
            replacement,
            observations: observations.collect(),
            models: models.collect(),
        }
    }

    /// Says why the inputs cannot be used.
    fn by_inputs(&self, node: &NodeId, batches: &[FusionInputs]) -> Result<Plan, String> {
        let mut plan = Plan {
            runs: Vec::new(),
            order: Order::Inputs {
                node: node.clone(),
                first: batches.first().map_or(0, |batch| batch.first),
            },
            missing: 0,
            are_adjustments_known: false,
        };
        let mut next = None;
        for batch in batches {
            let is_begin = batch.first == 0 || next.is_none();
            if !is_begin && next != Some(batch.first) {
                return Err("some of the fusion node's inputs are not in it".to_owned());
            }
            if is_begin {
                let (rig, objects) = self.first_models().map_err(|cause| cause.to_string())?;
                plan.runs.push(Run {
                    rig,
                    objects,
                    steps: Vec::new(),
                });
            }
            next = Some(batch.first + batch.inputs.len() as u64);
            for (number, input) in (batch.first..).zip(&batch.inputs) {
                self.add(&mut plan, number, input.now_ns, &input.source)?;
            }
        }
        let is_replaced = self.replacement.rig.is_some() || self.replacement.objects.is_some();
        let is_whole = batches.first().is_some_and(|batch| batch.first == 0);
        plan.are_adjustments_known = is_whole && plan.missing == 0 && !is_replaced;
        Ok(plan.timed())
    }

    /// The first two inputs of a whole run are its models.
    fn add(
        &self,
        plan: &mut Plan,
        number: u64,
        now_ns: u64,
        source: &InputSource,
    ) -> Result<(), String> {
        let Some(run) = plan.runs.last_mut() else {
            return Ok(());
        };
        let input = match source {
            InputSource::Image {
                camera,
                sequence,
                capture_ns,
            } => match self.observations.get(&(camera, *sequence, *capture_ns)) {
                Some(image) => Input::Image(ImageObservation::from(*image)),
                None => {
                    plan.missing += 1;
                    return Ok(());
                }
            },
            InputSource::Rig(_) if self.replacement.rig.is_some() => return Ok(()),
            InputSource::Objects(_) if self.replacement.objects.is_some() => return Ok(()),
            InputSource::Rig(fingerprint) => {
                let rig = self.rig(*fingerprint)?;
                if number == 0 {
                    run.rig = rig;
                    return Ok(());
                }
                Input::Rig(rig)
            }
            InputSource::Objects(fingerprints) => {
                let objects = fingerprints.iter().map(|print| self.object(*print));
                let objects = objects.collect::<Result<_, _>>()?;
                if number == 1 {
                    run.objects = objects;
                    return Ok(());
                }
                Input::Objects(objects)
            }
            InputSource::ClockStep => Input::ClockStep { by_ns: 0 },
            InputSource::Tick => Input::Tick,
            InputSource::Adjusted => Input::Adjusted,
        };
        run.steps.push((now_ns, input));
        Ok(())
    }

    fn rig(&self, fingerprint: u64) -> Result<Rig, String> {
        match self.models.get(&fingerprint) {
            Some(Model::Rig(rig)) => Rig::try_from(rig).map_err(|cause| cause.to_string()),
            _ => Err("a rig that the fusion node used is not in it".to_owned()),
        }
    }

    fn object(&self, fingerprint: u64) -> Result<ObjectModel, String> {
        match self.models.get(&fingerprint) {
            Some(Model::Object(object)) => {
                ObjectModel::try_from(object).map_err(|cause| cause.to_string())
            }
            _ => Err("an object that the fusion node used is not in it".to_owned()),
        }
    }

    /// The replacement, and the first of each recorded model where there is none.
    fn first_models(&self) -> Result<(Rig, Vec<ObjectModel>), PlanError> {
        let models = self.recording.models.iter();
        let models: Vec<&Model> = models.map(|timed| &timed.item.model).collect();
        let rig = match &self.replacement.rig {
            Some(rig) => rig.clone(),
            None => {
                let mut rigs = models.iter().filter_map(|model| rig_of(model));
                let unreadable = self.recording.rejected_models;
                let rig = rigs.next().ok_or(match unreadable {
                    0 => PlanError::NoRig,
                    n => PlanError::UnreadableModels(n),
                })?;
                Rig::try_from(rig).map_err(|cause| PlanError::Rig(cause.to_string()))?
            }
        };
        let objects = match &self.replacement.objects {
            Some(objects) => objects.clone(),
            None => {
                let mut first: BTreeMap<_, &ObjectConfig> = BTreeMap::new();
                for object in models.iter().filter_map(|model| object_of(model)) {
                    first.entry(&object.id).or_insert(object);
                }
                let alive = first.into_values().filter(|object| !object.is_removal());
                let models = alive.map(ObjectModel::try_from);
                models
                    .collect::<Result<_, _>>()
                    .map_err(|cause| PlanError::Object(cause.to_string()))?
            }
        };
        Ok((rig, objects))
    }

    fn by_arrival(&self, cause: String) -> Result<Plan, PlanError> {
        let (rig, objects) = self.first_models()?;
        let images = self.recording.observations.iter().map(|timed| {
            let image = Input::Image(ImageObservation::from(&timed.item));
            (timed.arrival_ns, image)
        });
        let mut steps: Vec<_> = images.chain(self.changes(&rig, &objects)).collect();
        steps.sort_by_key(|(now_ns, _)| *now_ns);
        let plan = Plan {
            runs: vec![Run {
                rig,
                objects,
                steps,
            }],
            order: Order::Arrival { cause },
            missing: 0,
            are_adjustments_known: false,
        };
        Ok(plan.timed())
    }

    /// Announced changes of the models, by arrival.
    fn changes(&self, rig: &Rig, objects: &[ObjectModel]) -> Vec<(u64, Input)> {
        let (mut rig, mut objects) = (rig.clone(), objects.to_vec());
        let mut changes = Vec::new();
        for timed in &self.recording.models {
            match &timed.item.model {
                Model::Rig(config) if self.replacement.rig.is_none() => {
                    let Ok(after) = Rig::try_from(config) else {
                        continue;
                    };
                    if after != rig {
                        rig = after;
                        changes.push((timed.arrival_ns, Input::Rig(rig.clone())));
                    }
                }
                Model::Object(config) if self.replacement.objects.is_none() => {
                    let before = objects.clone();
                    put(&mut objects, config);
                    if objects != before {
                        changes.push((timed.arrival_ns, Input::Objects(objects.clone())));
                    }
                }
                Model::Rig(_) | Model::Object(_) => {}
            }
        }
        changes
    }
}

/// The objects after a message; one that cannot be used changes nothing.
fn put(objects: &mut Vec<ObjectModel>, config: &ObjectConfig) {
    if config.is_removal() {
        objects.retain(|object| *object.id() != config.id);
    } else if let Ok(model) = ObjectModel::try_from(config) {
        match objects.iter_mut().find(|object| object.id() == model.id()) {
            Some(known) => *known = model,
            None => objects.push(model),
        }
    }
}

fn rig_of<'a>(model: &&'a Model) -> Option<&'a RigConfig> {
    match *model {
        Model::Rig(rig) => Some(rig),
        Model::Object(_) => None,
    }
}

fn object_of<'a>(model: &&'a Model) -> Option<&'a ObjectConfig> {
    match *model {
        Model::Object(object) => Some(object),
        Model::Rig(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ClockQuality, FusionInput, Timing, encode, fingerprint};
    use sextant_recordings::mcap::RecordingInfo;
    use sextant_recordings::mcap::reader::Ending;
    use sextant_recordings::mcap::site_recording::{RecordedModel, Timed};
    use sextant_site_model::{ObjectId, ObjectTag, TagId};
    use sextant_tag_families::Family;

    fn image(sequence: u64) -> Observations {
        Observations {
            camera: CameraId::new("north").unwrap(),
            sequence,
            capture_ns: 100 + sequence,
            exposure_ns: 0,
            clock: ClockQuality::default(),
            resolution: [640, 480],
            timing: Timing::default(),
            tags: Vec::new(),
        }
    }

    fn object(size_m: f64) -> ObjectConfig {
        let tag = ObjectTag::new(
            TagId {
                family: Family::Tag36h11,
                id: 3,
            },
            size_m,
            Some(sextant_geometry::Pose::identity()),
        );
        let model = ObjectModel::new(ObjectId::new("cube").unwrap(), vec![tag]);
        ObjectConfig::from(&model.unwrap())
    }

    fn model(arrival_ns: u64, model: Model) -> Timed<RecordedModel> {
        let payload = match &model {
            Model::Rig(rig) => encode(rig).unwrap(),
            Model::Object(object) => encode(object).unwrap(),
        };
        let fingerprint = fingerprint(&payload);
        Timed {
            arrival_ns,
            item: RecordedModel { fingerprint, model },
        }
    }

    /// Images 1 to 4, which arrived in the order 1, 3, 2, 4, and an object that changed before the last.
    fn recording() -> SiteRecording {
        let rig = RigConfig::from(&Rig::default());
        let images = [(10, 1), (11, 3), (12, 2), (20, 4)];
        let timed = |(arrival_ns, sequence)| Timed {
            arrival_ns,
            item: image(sequence),
        };
        SiteRecording {
            info: RecordingInfo::default(),
            ending: Ending::Closed,
            observations: images.map(timed).into(),
            models: vec![
                model(1, Model::Rig(rig)),
                model(2, Model::Object(object(0.04))),
                model(15, Model::Object(object(0.05))),
            ],
            inputs: BTreeMap::new(),
            poses: Vec::new(),
            truths: Vec::new(),
            images: BTreeMap::new(),
            rejected: 0,
            rejected_models: 0,
        }
    }

    fn batch(first: u64, sources: &[InputSource]) -> FusionInputs {
        let input = |source: &InputSource| FusionInput {
            now_ns: 50,
            source: source.clone(),
        };
        FusionInputs {
            node: NodeId::new("main").unwrap(),
            first,
            inputs: sources.iter().map(input).collect(),
        }
    }

    fn source(sequence: u64) -> InputSource {
        InputSource::Image {
            camera: CameraId::new("north").unwrap(),
            sequence,
            capture_ns: 100 + sequence,
        }
    }

    fn plan(recording: &SiteRecording) -> Plan {
        Plan::new(recording, None, &Replacement::default()).unwrap()
    }

    /// Capture times less 100, and 0 for a change.
    fn steps(plan: &Plan) -> Vec<u64> {
        let steps = plan.runs.iter().flat_map(|run| &run.steps);
        let number = |(_, input): &(u64, Input)| match input {
            Input::Image(image) => image.capture_ns - 100,
            _ => 0,
        };
        steps.map(number).collect()
    }

    #[test]
    fn without_inputs_images_and_changes_come_as_they_arrived() {
        let plan = plan(&recording());
        assert!(matches!(plan.order, Order::Arrival { .. }));
        assert_eq!(steps(&plan), [1, 3, 2, 0, 4]);
        assert_eq!(plan.runs[0].objects[0].tags()[0].size_m, 0.04);
    }

    /// Poses after the last inputs of a node whose clock was set back do not count as poses between its inputs.
    #[test]
    fn a_clock_that_was_set_begins_a_new_span() {
        let mut plan = plan(&recording());
        let tick = |now_ns| (now_ns, Input::Tick);
        let step = (20, Input::ClockStep { by_ns: -70 });
        plan.runs[0].steps = vec![tick(80), tick(90), step, tick(30)];
        assert_eq!(plan.spans_ns(), [80..=90, 20..=30]);
    }

    #[test]
    fn what_a_recording_has_in_place_of_what_it_lacks_is_named() {
        let refused = |recording: &SiteRecording| {
            let plan = Plan::new(recording, None, &Replacement::default());
            plan.unwrap_err().to_string()
        };
        let camera = CameraId::new("north").unwrap();
        let pictures = SiteRecording {
            observations: Vec::new(),
            images: BTreeMap::from([(camera, 60)]),
            ..recording()
        };
        assert!(refused(&pictures).contains("60 pictures and no detections"));
        let foreign = SiteRecording {
            models: Vec::new(),
            rejected_models: 2,
            ..recording()
        };
        assert!(refused(&foreign).contains("layout of another version"));
        let without = SiteRecording {
            models: Vec::new(),
            ..recording()
        };
        assert!(refused(&without).contains("no fusion node was running"));
    }

    #[test]
    fn inputs_give_order_models_and_restarts() {
        let mut recording = recording();
        let prints: Vec<u64> = recording
            .models
            .iter()
            .map(|m| m.item.fingerprint)
            .collect();
        let (rig, late) = (
            InputSource::Rig(prints[0]),
            InputSource::Objects(vec![prints[2]]),
        );
        let batches = vec![
            batch(0, &[rig.clone(), late.clone(), source(2), source(1)]),
            batch(4, &[source(9), InputSource::Objects(vec![prints[1]])]),
            batch(0, &[rig, late, source(3)]),
        ];
        recording.inputs = [(batches[0].node.clone(), batches)].into();
        let plan = plan(&recording);
        assert_eq!(steps(&plan), [2, 1, 0, 3]);
        assert_eq!((plan.runs.len(), plan.missing), (2, 1));
        assert_eq!(plan.runs[0].objects[0].tags()[0].size_m, 0.05);
        assert!(matches!(plan.order, Order::Inputs { first: 0, .. }));
    }

    #[test]
    fn a_gap_in_the_inputs_is_named() {
        let mut recording = recording();
        let batches = vec![batch(7, &[source(1)]), batch(9, &[source(2)])];
        recording.inputs = [(batches[0].node.clone(), batches)].into();
        let Order::Arrival { cause } = plan(&recording).order else {
            panic!("inputs with a gap were used");
        };
        assert!(cause.contains("inputs are not in it"), "{cause}");
    }
}

//! The true site and its files: what cameras see, and by how much a pose is off.

use std::f64::consts::FRAC_PI_2;

use crate::plan::{ChangeRequest, Plan, SiteMistake};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use node_fusion::ModelsInForce;
use sextant_geometry::Pose;
use sextant_proto::{
    CameraSettings, Keys, Message, ModelPayload, NodeId, ObjectConfig, ObjectPose, Proposal,
    RigConfig, TagObservation, encode,
};
use sextant_simulator::{Imperfections, Observer, Occlusion, Random, Scenario, Visibility};
use sextant_site_model::{Camera, CameraId, ObjectId, ObjectModel, ObjectTag, Rig, TagId};

/// Noise of corners, px.
const SIGMA_PX: f64 = 0.1;
/// A world of the rig lies by so much beside the next, m.
const WORLD_M: f64 = 0.25;

/// The site.
pub struct Scene {
    truth: Scenario,
    written: Scenario,
    observer: Observer,
    /// What is seen from a true time on, ns.
    later: Option<(u64, Observer)>,
    random: Random,
    is_exact: bool,
}

impl Scene {
    /// Of a plan.
    ///
    /// # Panics
    /// If the simulator cannot make the demonstration's site.
    #[must_use]
    pub fn new(plan: &Plan) -> Self {
        let mut scenario = Scenario::demo(plan.cameras, plan.objects, plan.seed);
        if !plan.exact {
            scenario = scenario.with_imperfections(&Imperfections::TYPICAL);
        }
        let written = scenario.as_written().expect("lenses of the demonstration");
        let written = with_names_exchanged(written, plan.mistake);
        let before = with_print_scaled(scenario.clone(), plan.mistake);
        let visibility = Visibility {
            occlusion: Occlusion::Ignored,
            ..Visibility::default()
        };
        let observer =
            |scenario: &Scenario| Observer::new(scenario, visibility).expect("the demonstration");
        let later = plan.mistake.and_then(|mistake| {
            let after = with_camera_displaced(before.clone(), mistake)?;
            Some((mistake.at_ns(), observer(&after)))
        });
        Self {
            observer: observer(&before),
            later,
            random: Random::from_keys(&[plan.seed, 0x7363_656e]),
            truth: scenario,
            written,
            is_exact: plan.exact,
        }
    }

    /// A camera's name.
    ///
    /// # Panics
    /// If there is no such camera.
    #[must_use]
    pub fn camera(&self, index: usize) -> CameraId {
        self.truth.cameras[index].id.parse().expect("an id")
    }

    /// An object's name.
    ///
    /// # Panics
    /// If there is no such object.
    #[must_use]
    pub fn object(&self, index: usize) -> ObjectId {
        self.truth.objects[index].id.parse().expect("an id")
    }

    /// The names of all objects.
    pub fn objects(&self) -> impl Iterator<Item = ObjectId> {
        (0..self.truth.objects.len()).map(|index| self.object(index))
    }

    /// The site's files.
    #[must_use]
    pub fn models(&self) -> ModelsInForce {
        let objects = 0..self.written.objects.len();
        ModelsInForce {
            rig: self.rig(0),
            objects: objects.map(|index| self.model(index)).collect(),
            settings: Default::default(),
        }
    }

    fn rig(&self, world: i32) -> Rig {
        let shift = Pose::translation(f64::from(world) * WORLD_M, 0.0, 0.0);
        let cameras = self.written.cameras.iter().enumerate().map(|(at, camera)| {
            let world_from_camera = Some(shift * camera.world_from_camera);
            Camera::new(
                self.camera(at),
                camera.resolution,
                camera.lens,
                world_from_camera,
            )
        });
        let rig = Rig::new(cameras.collect()).expect("a rig");
        match self.is_exact {
            true => rig.exact(),
            false => rig,
        }
    }

    fn model(&self, index: usize) -> ObjectModel {
        let tags = self.written.objects[index].tags.iter().map(|tag| {
            let (family, id) = (tag.family, tag.id);
            ObjectTag::new(TagId { family, id }, tag.size, Some(tag.object_from_tag))
        });
        let model = ObjectModel::new(self.object(index), tags.collect()).expect("an object");
        match self.is_exact {
            true => model.exact(),
            false => model,
        }
    }

    /// Which world a rig has, in steps of a quarter of a metre.
    #[must_use]
    pub fn world_of(&self, rig: &Rig) -> i32 {
        let moved = |(ours, theirs): (&Camera, &sextant_simulator::SceneCamera)| {
            let pose = ours.world_from_camera?;
            Some(pose.translation.vector.x - theirs.world_from_camera.translation.vector.x)
        };
        let pairs = rig.cameras().iter().zip(&self.written.cameras);
        let moved: Vec<f64> = pairs.filter_map(moved).collect();
        (moved.iter().sum::<f64>() / moved.len() as f64 / WORLD_M).round() as i32
    }

    /// What a camera sees at a true time.
    pub fn observe(&mut self, camera: usize, true_ns: u64) -> Vec<TagObservation> {
        let observer = match &mut self.later {
            Some((from_ns, later)) if true_ns >= *from_ns => later,
            _ => &mut self.observer,
        };
        let seen = observer.observe(camera, true_ns, SIGMA_PX, &mut self.random);
        let variance = SIGMA_PX.powi(2) as f32;
        let tags = seen.iter().map(|seen| TagObservation {
            family: seen.family,
            id: seen.id,
            hamming: 0,
            margin: 60.0,
            corners: seen
                .corners
                .map(|corner| [corner.x as f32, corner.y as f32]),
            corner_covariance: [[variance, 0.0, variance]; 4],
            corner_cross_covariance: [[0.0; 4]; 6],
            poses: Vec::new(),
        });
        tags.collect()
    }

    /// The objects on which these tags are.
    #[must_use]
    pub fn objects_of(&self, tags: &[TagObservation]) -> Vec<ObjectId> {
        let has = |index: &usize| {
            let of_object = &self.truth.objects[*index].tags;
            let is_on = |seen: &TagObservation| {
                (of_object.iter()).any(|tag| (tag.family, tag.id) == (seen.family, seen.id))
            };
            tags.iter().any(is_on)
        };
        let indices = (0..self.truth.objects.len()).filter(has);
        indices.map(|index| self.object(index)).collect()
    }

    /// By how much a pose in a world is off from the truth at one of these true times, the best of them: metres, and in
    /// standard deviations that it states.
    #[must_use]
    pub fn error(&self, pose: &ObjectPose, world: i32, true_ns: &[u64]) -> (f64, f64) {
        let shift = Vector3::new(f64::from(world) * WORLD_M, 0.0, 0.0);
        let mut objects = self.truth.objects.iter();
        let Some(object) = objects.find(|object| object.id == pose.object.as_str()) else {
            return (f64::INFINITY, f64::INFINITY);
        };
        let errors = true_ns.iter().map(|at_ns| {
            let truth = object.world_from_object(*at_ns).translation.vector + shift;
            (Vector3::from(pose.position) - truth).norm()
        });
        let error_m = errors.fold(f64::INFINITY, f64::min);
        let variance: f64 = [0, 7, 14].iter().map(|at| pose.covariance[*at]).sum();
        (error_m, error_m / variance.sqrt())
    }

    /// By how much a pose is turned against the truth at one of these true times, the best of them, rad.
    #[must_use]
    pub fn turned_rad(&self, pose: &ObjectPose, true_ns: &[u64]) -> f64 {
        let mut objects = self.truth.objects.iter();
        let Some(object) = objects.find(|object| object.id == pose.object.as_str()) else {
            return f64::INFINITY;
        };
        let [x, y, z, w] = pose.orientation;
        let turned = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let angles = true_ns.iter().map(|at_ns| {
            let truth = object.world_from_object(*at_ns).rotation;
            truth.angle_to(&turned)
        });
        angles.fold(f64::INFINITY, f64::min)
    }

    /// The key and the payload of a request.
    ///
    /// # Panics
    /// If a model cannot be encoded.
    #[must_use]
    pub fn request(&self, request: ChangeRequest, keys: &Keys) -> (String, Vec<u8>) {
        let object = |index| ObjectConfig::from(&self.model(index));
        match request {
            ChangeRequest::World(world) => (
                keys.config_rig(),
                encoded(&RigConfig::from(&self.rig(world))),
            ),
            ChangeRequest::Remove(index) => {
                let id = self.object(index);
                (keys.config_object(&id), encoded(&ObjectConfig::removal(id)))
            }
            ChangeRequest::Restore(index) => (
                keys.config_object(&self.object(index)),
                encoded(&object(index)),
            ),
            ChangeRequest::Gain(index, tenths) => {
                let id = self.camera(index);
                let settings = CameraSettings {
                    gain: Some(f64::from(tenths) / 10.0),
                    ..CameraSettings::none(id.clone())
                };
                (keys.config_camera(&id), encoded(&settings))
            }
            ChangeRequest::Both(world, index) => {
                let none = Proposal::none(NodeId::new("client").expect("an id"), 1);
                let rig = ModelPayload::encode(&RigConfig::from(&self.rig(world)));
                let object = ModelPayload::encode(&object(index));
                let proposal = Proposal {
                    rig: rig.ok(),
                    objects: vec![object.expect("an object")],
                    ..none
                };
                (keys.config_models(), encoded(&proposal))
            }
        }
    }
}

/// The files with the names of two cameras exchanged.
fn with_names_exchanged(mut written: Scenario, mistake: Option<SiteMistake>) -> Scenario {
    if let Some(SiteMistake::NamesExchanged(a, b)) = mistake {
        // A rig's names go by position.
        written.cameras.swap(a, b);
    }
    written
}

/// The site with the tags of an object printed at a scale.
fn with_print_scaled(mut scenario: Scenario, mistake: Option<SiteMistake>) -> Scenario {
    if let Some(SiteMistake::PrintScaled(object, ratio)) = mistake {
        for tag in &mut scenario.objects[object].tags {
            tag.print_scale *= ratio;
        }
    }
    scenario
}

/// The site after a camera was moved or turned; none where none was.
fn with_camera_displaced(mut scenario: Scenario, mistake: SiteMistake) -> Option<Scenario> {
    let (camera, step) = match mistake {
        // Sideways, so that most of what it sees stays in its image.
        SiteMistake::CameraMoved(camera, by_m, _) => (camera, Pose::translation(by_m, 0.0, 0.0)),
        SiteMistake::CameraTurned(camera, quarters, _) => {
            let angle = f64::from(quarters) * FRAC_PI_2;
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
            (camera, Pose::from_parts(Vector3::zeros().into(), turn))
        }
        SiteMistake::NamesExchanged(..) | SiteMistake::PrintScaled(..) => return None,
    };
    scenario.cameras[camera].world_from_camera *= step;
    Some(scenario)
}

fn encoded(message: &impl Message) -> Vec<u8> {
    encode(message).expect("a message")
}

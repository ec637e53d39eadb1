//! The rig and the objects in force, and what a change would make of them: whole, or a refusal with its cause.
//!
//! Input: payloads under the site's `config/` keys. Output: the models after the change. Knows no network, no file and
//! no clock.

use crate::camera_settings::SettingsOfCameras;
use crate::refusals::{detail, invalid_camera, invalid_object, undecodable, unusable};
use sextant_estimator::{Fusion, FusionOptions};
use sextant_proto::{
    CameraSettings, KeyRef, Keys, ObjectConfig, Proposal, Refusal, RigConfig, decode, encode,
    limits, models_fingerprint,
};
use sextant_site_model::{CameraId, ObjectId, ObjectModel, Rig};
use sextant_zenoh_bus::Item;
use std::collections::BTreeMap;

/// What the machine works from.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelsInForce {
    /// The cameras.
    pub rig: Rig,
    /// The objects, in the order of their coming.
    pub objects: Vec<ObjectModel>,
    /// Exposure, gain and rate of cameras.
    pub settings: SettingsOfCameras,
}

/// The models as messages: under their keys below the site, the payloads that carry them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Payloads {
    by_key: BTreeMap<String, Vec<u8>>,
    fingerprint: u64,
}

impl Payloads {
    /// Of models in force, which fit into messages.
    #[must_use]
    pub fn encode(models: &ModelsInForce) -> Self {
        let rig = [(
            "config/rig".to_owned(),
            encode(&RigConfig::from(&models.rig)),
        )];
        let objects = models.objects.iter().map(|object| {
            let key = format!("config/object/{}", object.id());
            (key, encode(&ObjectConfig::from(object)))
        });
        let settings = models.settings.iter();
        let settings = settings.map(|(id, one)| (format!("config/camera/{id}"), encode(one)));
        let all = rig.into_iter().chain(objects).chain(settings);
        Self::new(all.filter_map(|(key, payload)| Some((key, payload.ok()?))))
    }

    /// As another node answered them under these keys.
    #[must_use]
    pub fn answered(root: &str, items: &[Item]) -> Self {
        let below = |item: &Item| {
            let below = item.key.strip_prefix(root)?.strip_prefix('/')?;
            Some((below.to_owned(), item.bytes()?.to_vec()))
        };
        Self::new(items.iter().filter_map(below))
    }

    fn new(payloads: impl Iterator<Item = (String, Vec<u8>)>) -> Self {
        let by_key: BTreeMap<String, Vec<u8>> = payloads.collect();
        let each = by_key.iter();
        let fingerprint = models_fingerprint(each.map(|(key, payload)| (key.as_str(), &**payload)));
        Self {
            by_key,
            fingerprint,
        }
    }

    /// The keys and payloads.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &[u8])> {
        let all = self.by_key.iter();
        all.map(|(key, payload)| (key.as_str(), payload.as_slice()))
    }

    /// Tells them from all others.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        self.fingerprint
    }

    /// The models; objects that `own` has too are in its order.
    ///
    /// # Errors
    /// What of them cannot be used.
    pub fn models(&self, own: &ModelsInForce) -> Result<ModelsInForce, Refusal> {
        let (mut cameras, mut objects, mut settings) =
            (None, BTreeMap::new(), SettingsOfCameras::new());
        for (key, payload) in &self.by_key {
            let key = Keys::parse_below_site(key);
            match key.map(|key| Change::read(&key, payload)).transpose()? {
                Some(Change::Rig(rig)) => cameras = Some(rig),
                Some(Change::Object(object)) => drop(objects.insert(object.id().clone(), object)),
                Some(Change::Camera(one)) => drop(settings.insert(one.camera.clone(), one)),
                Some(Change::Removal(_)) | None => {}
            }
        }
        let known = own
            .objects
            .iter()
            .filter_map(|object| objects.remove(object.id()));
        let mut all: Vec<ObjectModel> = known.collect();
        all.extend(objects.into_values());
        let models = ModelsInForce {
            rig: cameras.ok_or(Refusal::NoCamera)?,
            objects: all,
            settings,
        };
        models.check_use()?;
        Ok(models)
    }
}

/// A change of the models.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// Other cameras.
    Rig(Rig),
    /// A new object, or one that is another now.
    Object(ObjectModel),
    /// No such object any more.
    Removal(ObjectId),
    /// Other settings of a camera.
    Camera(CameraSettings),
}

impl Change {
    /// The changes that a payload under a configuration key asks for, to be made together.
    ///
    /// # Errors
    /// Why the payload is no rig, object or proposal.
    pub fn read_all(key: &KeyRef, payload: &[u8]) -> Result<Vec<Self>, Refusal> {
        if *key != KeyRef::ConfigModels {
            return Ok(vec![Self::read(key, payload)?]);
        }
        let proposal: Proposal = decode(payload).map_err(undecodable)?;
        let rig = proposal.rig.iter().map(|one| rig(&one.0).map(Self::Rig));
        let objects = proposal.objects.iter().map(|one| {
            let message: ObjectConfig = decode(&one.0).map_err(undecodable)?;
            object(&message.id, &one.0)
        });
        rig.chain(objects).collect()
    }

    /// The change that a payload under a configuration key asks for.
    ///
    /// # Errors
    /// Why the payload is no rig or object.
    pub fn read(key: &KeyRef, payload: &[u8]) -> Result<Self, Refusal> {
        match key {
            KeyRef::ConfigRig => Ok(Self::Rig(rig(payload)?)),
            KeyRef::ConfigObject(id) => object(id, payload),
            KeyRef::ConfigCamera(id) => camera_settings(id, payload),
            _ => Err(Refusal::Other {
                detail: "not a key of the configuration".to_owned(),
            }),
        }
    }
}

fn rig(payload: &[u8]) -> Result<Rig, Refusal> {
    let message: RigConfig = decode(payload).map_err(undecodable)?;
    let rig = Rig::try_from(&message).map_err(|error| invalid_camera(&error))?;
    if rig.cameras().is_empty() {
        return Err(Refusal::NoCamera);
    }
    Ok(rig)
}

fn object(id: &ObjectId, payload: &[u8]) -> Result<Change, Refusal> {
    let message: ObjectConfig = decode(payload).map_err(undecodable)?;
    if message.id != *id {
        let described = message.id;
        return Err(Refusal::WrongId { described });
    }
    if message.is_removal() {
        return Ok(Change::Removal(message.id));
    }
    let model = ObjectModel::try_from(&message).map_err(|error| invalid_object(&error))?;
    check_tags(&model)?;
    Ok(Change::Object(model))
}

fn camera_settings(id: &CameraId, payload: &[u8]) -> Result<Change, Refusal> {
    let message: CameraSettings = decode(payload).map_err(undecodable)?;
    if message.camera != *id {
        let detail = format!("the payload is about camera {}", message.camera);
        return Err(Refusal::Other { detail });
    }
    Ok(Change::Camera(message))
}

/// Refuses a tag that its family does not have.
fn check_tags(model: &ObjectModel) -> Result<(), Refusal> {
    let n_ids = |tag: &sextant_site_model::TagId| tag.family.data().codes.len();
    let mut tags = model.tags().iter().map(|tag| tag.tag);
    match tags.find(|tag| tag.id as usize >= n_ids(tag)) {
        Some(tag) => Err(Refusal::UnknownTag {
            tag,
            n_ids: n_ids(&tag) as u32,
        }),
        None => Ok(()),
    }
}

impl Change {
    /// Whether both are about the rig, or about the same object or camera.
    #[must_use]
    pub fn is_about_the_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Rig(_), Self::Rig(_)) => true,
            (Self::Camera(one), Self::Camera(other)) => one.camera == other.camera,
            (one, other) => one.object().is_some_and(|id| other.object() == Some(id)),
        }
    }

    fn object(&self) -> Option<&ObjectId> {
        match self {
            Self::Object(model) => Some(model.id()),
            Self::Removal(id) => Some(id),
            Self::Rig(_) | Self::Camera(_) => None,
        }
    }
}

impl ModelsInForce {
    /// The models after these changes, all of them; none where nothing changes.
    ///
    /// # Errors
    /// Why the site cannot work from them.
    pub fn changed(&self, changes: &[Change]) -> Result<Option<Self>, Refusal> {
        let mut after = self.clone();
        for change in changes {
            match change {
                Change::Rig(rig) => after.rig = rig.clone(),
                Change::Object(model) => after.put(model),
                Change::Removal(id) => after.objects.retain(|object| object.id() != id),
                Change::Camera(settings) => after.set(settings)?,
            }
        }
        if *self == after {
            return Ok(None);
        }
        let is_about_models = |change: &Change| !matches!(change, Change::Camera(_));
        if changes.iter().any(is_about_models) {
            after.check_use()?;
        }
        Ok(Some(after))
    }

    /// Whether a change would change nothing.
    #[must_use]
    pub fn has(&self, change: &Change) -> bool {
        match change {
            Change::Rig(rig) => self.rig == *rig,
            Change::Object(model) => self.objects.contains(model),
            Change::Removal(id) => self.objects.iter().all(|object| object.id() != id),
            Change::Camera(settings) if settings.is_none() => {
                !self.settings.contains_key(&settings.camera)
            }
            Change::Camera(settings) => self.settings.get(&settings.camera) == Some(settings),
        }
    }

    /// The changes that make other models of these: removals first, since a tag may move from one object to another.
    #[must_use]
    pub fn changes_to(&self, after: &Self) -> Vec<Change> {
        let removed = |id: &ObjectId| after.objects.iter().all(|object| object.id() != id);
        let removed = self
            .objects
            .iter()
            .map(ObjectModel::id)
            .filter(|id| removed(id));
        let unset = self
            .settings
            .keys()
            .filter(|id| !after.settings.contains_key(*id));
        let is_new = |object: &&ObjectModel| !self.objects.contains(object);
        let is_set = |one: &&CameraSettings| self.settings.get(&one.camera) != Some(*one);
        let rig = (self.rig != after.rig).then(|| Change::Rig(after.rig.clone()));
        let objects = after.objects.iter().filter(is_new).cloned();
        let settings = after.settings.values().filter(is_set).cloned();
        (removed.cloned().map(Change::Removal))
            .chain(
                unset
                    .cloned()
                    .map(|id| Change::Camera(CameraSettings::none(id))),
            )
            .chain(rig)
            .chain(objects.map(Change::Object))
            .chain(settings.map(Change::Camera))
            .collect()
    }

    /// Whether the site can work from the rig and the objects.
    pub fn check_use(&self) -> Result<(), Refusal> {
        if self.objects.len() > limits::MAX_OBJECTS {
            let limit = limits::MAX_OBJECTS as u32;
            return Err(Refusal::TooManyObjects { limit });
        }
        // The estimator's own rules.
        let (rig, objects) = (self.rig.clone(), self.objects.clone());
        Fusion::new(rig, objects, FusionOptions::default()).map_err(unusable)?;
        self.check()
    }

    /// Whether rig and objects fit into messages.
    ///
    /// # Errors
    /// What does not.
    pub fn check(&self) -> Result<(), Refusal> {
        let unpublishable = |what: &str, cause| Refusal::Unpublishable {
            detail: detail(&format!("{what}: {cause}")),
        };
        encode(&RigConfig::from(&self.rig)).map_err(|cause| unpublishable("the rig", cause))?;
        for object in &self.objects {
            encode(&ObjectConfig::from(object))
                .map_err(|cause| unpublishable(&format!("object {}", object.id()), cause))?;
        }
        Ok(())
    }

    /// A camera need not be in the rig: its exposure is set before its lens is calibrated.
    fn set(&mut self, settings: &CameraSettings) -> Result<(), Refusal> {
        let id = &settings.camera;
        if settings.is_none() {
            self.settings.remove(id);
            return Ok(());
        }
        let is_new = !self.settings.contains_key(id);
        if is_new && self.settings.len() >= limits::MAX_CAMERAS {
            let detail = format!(
                "{} cameras have settings already; remove those of a camera that is gone",
                limits::MAX_CAMERAS
            );
            return Err(Refusal::Other { detail });
        }
        self.settings.insert(id.clone(), settings.clone());
        Ok(())
    }

    fn put(&mut self, model: &ObjectModel) {
        match self
            .objects
            .iter_mut()
            .find(|known| known.id() == model.id())
        {
            Some(known) => *known = model.clone(),
            None => self.objects.push(model.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::{Intrinsics, Lens, Pose};
    use sextant_proto::Keys;
    use sextant_site_model::{Camera, CameraId, ObjectTag, PoseSigma, Prior, TagId};
    use sextant_tag_families::Family;

    fn model(id: &str, tags: &[u32]) -> ObjectModel {
        let tag = |id: &u32| {
            ObjectTag::new(
                TagId {
                    family: Family::Tag36h11,
                    id: *id,
                },
                0.04,
                Some(Pose::identity()),
            )
        };
        ObjectModel::new(ObjectId::new(id).unwrap(), tags.iter().map(tag).collect()).unwrap()
    }

    fn cameras(ids: &[&str]) -> Rig {
        let lens = Lens::pinhole(Intrinsics {
            fx: 600.0,
            fy: 600.0,
            cx: 319.5,
            cy: 239.5,
        })
        .unwrap();
        let camera = |id: &&str| Camera::new(CameraId::new(id).unwrap(), [640, 480], lens, None);
        Rig::new(ids.iter().map(camera).collect()).unwrap()
    }

    fn models() -> ModelsInForce {
        ModelsInForce {
            rig: cameras(&["north"]),
            objects: vec![model("cube", &[1, 2]), model("box", &[3])],
            settings: SettingsOfCameras::new(),
        }
    }

    fn after(change: Change) -> Option<ModelsInForce> {
        models().changed(&[change]).unwrap()
    }

    #[test]
    fn a_change_changes_what_it_names_and_nothing_else() {
        let moved = after(Change::Rig(cameras(&["north", "south"]))).unwrap();
        assert_eq!(moved.objects, models().objects);
        let other = after(Change::Object(model("cube", &[2]))).unwrap();
        assert_eq!(other.objects, [model("cube", &[2]), model("box", &[3])]);
        let more = after(Change::Object(model("ball", &[4]))).unwrap();
        assert_eq!(more.objects.len(), 3);
        let fewer = after(Change::Removal(ObjectId::new("cube").unwrap())).unwrap();
        assert_eq!(fewer.objects, [model("box", &[3])]);
    }

    #[test]
    fn a_camera_has_settings_until_they_are_removed() {
        let settings = |id: &str, gain| CameraSettings {
            gain,
            ..CameraSettings::none(CameraId::new(id).unwrap())
        };
        let set = Change::Camera(settings("north", Some(2.0)));
        let with = after(set.clone()).unwrap();
        assert_eq!(with.settings.len(), 1);
        assert_eq!(
            (&with.rig, &with.objects),
            (&models().rig, &models().objects)
        );
        assert_eq!(with.changed(&[set]), Ok(None));
        let taken_back = Change::Camera(settings("north", None));
        assert_eq!(with.changed(&[taken_back]), Ok(Some(models())));
    }

    #[test]
    fn cameras_beyond_the_bound_get_no_settings() {
        let set = |models: &ModelsInForce, n: usize| {
            let id = CameraId::new(&format!("c{n}")).unwrap();
            let gain = Some(2.0);
            let none = CameraSettings::none(id);
            models.changed(&[Change::Camera(CameraSettings { gain, ..none })])
        };
        let full =
            (0..limits::MAX_CAMERAS).fold(models(), |models, n| set(&models, n).unwrap().unwrap());
        assert!(matches!(set(&full, 1000), Err(Refusal::Other { .. })));
        assert_eq!(set(&full, 0), Ok(None));
    }

    #[test]
    fn what_is_in_force_already_changes_nothing() {
        assert_eq!(after(Change::Rig(cameras(&["north"]))), None);
        assert_eq!(after(Change::Object(model("box", &[3]))), None);
        assert_eq!(after(Change::Removal(ObjectId::new("ball").unwrap())), None);
    }

    #[test]
    fn objects_that_contradict_each_other_are_refused() {
        let ball = model("ball", &[3]);
        let refused = models().changed(&[Change::Object(ball.clone())]);
        assert_eq!(
            refused,
            Err(Refusal::SharedTag {
                tag: ball.tags()[0].tag,
                first: models().objects[1].id().clone(),
                second: ball.id().clone(),
            })
        );
    }

    #[test]
    fn a_camera_too_far_away_to_publish_what_it_sees_is_refused() {
        let mut far = cameras(&["north"]).cameras().to_vec();
        far[0].world_from_camera = Some(Pose::translation(0.0, 9.0e5, 0.0));
        let far = Rig::new(far).unwrap();
        let refused = models().changed(&[Change::Rig(far.clone())]).unwrap_err();
        let detail = refused.to_string();
        assert!(matches!(refused, Refusal::Unpublishable { .. }));
        assert!(detail.contains("cameras[].world_from_camera"), "{detail}");
        let models = ModelsInForce {
            rig: far,
            ..models()
        };
        assert_eq!(models.check(), Err(refused));
    }

    /// A message says everything: what it leaves out is not given any more.
    #[test]
    fn what_a_message_leaves_out_is_gone_and_what_is_in_force_is_the_same() {
        let (rig, object) = (cameras(&["north"]), model("cube", &[1, 2]));
        let (mut cameras, mut tags) = (rig.cameras().to_vec(), object.tags().to_vec());
        cameras[0].line_delay_s = Some(2e-5);
        tags[0].pose_prior = Prior::Sigma(PoseSigma {
            position_m: 0.001,
            orientation_rad: 0.002,
        });
        tags[0].size_prior = Prior::Sigma(0.0003);
        let in_force = ModelsInForce {
            rig: Rig::new(cameras).unwrap(),
            objects: vec![ObjectModel::new(object.id().clone(), tags).unwrap()],
            ..models()
        };
        let after = |key: KeyRef, payload: &[u8]| {
            let change = Change::read(&key, payload).unwrap();
            in_force.changed(&[change]).unwrap()
        };
        let of_cube = || KeyRef::ConfigObject(object.id().clone());
        let plain_rig = encode(&RigConfig::from(&rig)).unwrap();
        assert_eq!(after(KeyRef::ConfigRig, &plain_rig).unwrap().rig, rig);
        let plain_object = encode(&ObjectConfig::from(&object)).unwrap();
        let plain = after(of_cube(), &plain_object).unwrap();
        assert_eq!(plain.objects, std::slice::from_ref(&object));
        let rig_back = encode(&RigConfig::from(&in_force.rig)).unwrap();
        assert_eq!(after(KeyRef::ConfigRig, &rig_back), None);
        let object_back = encode(&ObjectConfig::from(&in_force.objects[0])).unwrap();
        assert_eq!(after(of_cube(), &object_back), None);
    }

    #[test]
    fn a_payload_is_read_as_its_key_says() {
        let keys = Keys::new("site").unwrap();
        let read = |key: &str, message: &ObjectConfig| {
            let key = keys.parse(&format!("sextant/v1/site/{key}")).unwrap();
            Change::read(&key, &encode(message).unwrap())
        };
        let cube = ObjectConfig::from(&model("cube", &[1]));
        let gone = ObjectConfig::removal(cube.id.clone());
        let mut foreign = cube.clone();
        foreign.tags[0].id = 100_000;
        let key = "config/object/cube";
        assert_eq!(read(key, &cube), Ok(Change::Object(model("cube", &[1]))));
        assert_eq!(
            read(key, &gone),
            Ok(Change::Removal(ObjectId::new("cube").unwrap()))
        );
        for (key, message, cause) in [
            (key, &foreign, "tag36h11 has no tag 100000"),
            ("config/object/box", &cube, "describes object cube"),
            ("config/rig", &cube, "kind 13 where RigConfig was expected"),
        ] {
            let refused = read(key, message).unwrap_err().to_string();
            assert!(refused.contains(cause), "{refused}");
        }
    }
}

//! The rig and the objects in force, and what a change would make of them: whole, or a refusal with its cause.
//!
//! In: payloads under the site's `config/` keys. Out: the models after the change. Knows no network, no file and no clock.

use sextant_estimator::{Fusion, FusionOptions, ObjectId, ObjectModel, Rig, TagId};
use sextant_proto::{
    ArticulatedConfig, FullObject, FullRig, KeyRef, Message, ObjectConfig, RigConfig,
    RigConfigError, decode, encode, limits,
};

/// What the machine works from.
#[derive(Debug, Clone, PartialEq)]
pub struct Models {
    /// The cameras.
    pub rig: Rig,
    /// The objects, in the order of their coming.
    pub objects: Vec<ObjectModel>,
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
}

impl Change {
    /// The change that a payload asks for. A message that leaves out what files state leaves in force what is stated of all that
    /// stays.
    ///
    /// # Errors
    /// In words, why it is none.
    pub fn read(key: &KeyRef, payload: &[u8], in_force: &Models) -> Result<Self, String> {
        match key {
            KeyRef::ConfigRig => {
                let rig = rig_of::<RigConfig>(payload)?;
                Ok(Self::Rig(rig.holding_on_to(&in_force.rig)))
            }
            KeyRef::FullRig => Ok(Self::Rig(rig_of::<FullRig>(payload)?)),
            KeyRef::ConfigObject(id) => match object(id, payload)? {
                Some(object) => in_force.held(object),
                None => Ok(Self::Removal(id.clone())),
            },
            KeyRef::ConfigArticulated(id) => in_force.held(articulated(id, payload)?),
            KeyRef::FullObject(id) => with_real_tags(full_object(id, payload)?),
            _ => Err("no key of the configuration".to_owned()),
        }
    }
}

fn rig_of<M: Message>(payload: &[u8]) -> Result<Rig, String>
where
    for<'a> Rig: TryFrom<&'a M, Error = RigConfigError>,
{
    let message: M = decode(payload).map_err(|cause| cause.to_string())?;
    let rig = Rig::try_from(&message).map_err(|cause| cause.to_string())?;
    if rig.cameras().is_empty() {
        return Err("the rig has no camera".to_owned());
    }
    Ok(rig)
}

/// `None` where it says that there is no such object.
fn object(id: &ObjectId, payload: &[u8]) -> Result<Option<ObjectModel>, String> {
    let message: ObjectConfig = decode(payload).map_err(|cause| cause.to_string())?;
    named(&message.id, id)?;
    if message.tags.is_empty() {
        return Ok(None);
    }
    let model = ObjectModel::try_from(&message).map_err(|cause| cause.to_string())?;
    Ok(Some(model))
}

fn articulated(id: &ObjectId, payload: &[u8]) -> Result<ObjectModel, String> {
    let message: ArticulatedConfig = decode(payload).map_err(|cause| cause.to_string())?;
    named(&message.id, id)?;
    if message.tags.is_empty() {
        return Err("no link has a tag; objects are removed under config/object".to_owned());
    }
    ObjectModel::try_from(&message).map_err(|cause| cause.to_string())
}

fn full_object(id: &ObjectId, payload: &[u8]) -> Result<ObjectModel, String> {
    let message: FullObject = decode(payload).map_err(|cause| cause.to_string())?;
    named(&message.id, id)?;
    ObjectModel::try_from(&message).map_err(|cause| cause.to_string())
}

fn named(described: &ObjectId, by_key: &ObjectId) -> Result<(), String> {
    if described == by_key {
        Ok(())
    } else {
        Err(format!("it describes object {described}"))
    }
}

/// The object, if its tags are there to be printed.
fn with_real_tags(model: ObjectModel) -> Result<Change, String> {
    for TagId { family, id } in model.tags().iter().map(|tag| tag.tag) {
        let ids = family.data().codes.len();
        if id as usize >= ids {
            let last = ids.saturating_sub(1);
            return Err(format!("{family} has no tag {id}; its ids are 0 to {last}"));
        }
    }
    Ok(Change::Object(model))
}

impl Models {
    /// The change to an object whose message leaves out what is stated of its tags.
    fn held(&self, object: ObjectModel) -> Result<Change, String> {
        let known = self.objects.iter().find(|known| known.id() == object.id());
        with_real_tags(match known {
            Some(known) => object.holding_on_to(known),
            None => object,
        })
    }

    /// The models after a change; none where nothing changes.
    ///
    /// # Errors
    /// In words, why the site can't work from them.
    pub fn changed(&self, change: &Change) -> Result<Option<Self>, String> {
        let mut after = self.clone();
        match change {
            Change::Rig(rig) => after.rig = rig.clone(),
            Change::Object(model) => after.put(model),
            Change::Removal(id) => after.objects.retain(|object| object.id() != id),
        }
        if self.are_said_alike(&after) {
            return Ok(None);
        }
        if after.objects.len() > limits::MAX_OBJECTS {
            return Err(format!(
                "a site has at most {} objects",
                limits::MAX_OBJECTS
            ));
        }
        // The rules are the machine's own.
        Fusion::new(
            after.rig.clone(),
            after.objects.clone(),
            FusionOptions::default(),
        )
        .map_err(|cause| cause.to_string())?;
        after.check()?;
        Ok(Some(after))
    }

    /// Whether the models can be told to others: within the limits of messages.
    ///
    /// # Errors
    /// In words, what is beyond them.
    pub fn check(&self) -> Result<(), String> {
        encode(&FullRig::from(&self.rig)).map_err(|cause| format!("the rig: {cause}"))?;
        for object in &self.objects {
            encode(&FullObject::from(object))
                .map_err(|cause| format!("object {}: {cause}", object.id()))?;
        }
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

    /// As messages: the models' own quaternions may differ in their last bit after the way over the network.
    fn are_said_alike(&self, other: &Self) -> bool {
        let objects = |models: &Self| -> Vec<FullObject> {
            models.objects.iter().map(FullObject::from).collect()
        };
        FullRig::from(&self.rig) == FullRig::from(&other.rig) && objects(self) == objects(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_estimator::{Camera, CameraId, ObjectTag, PoseSigma};
    use sextant_geometry::{Intrinsics, Lens, Pose};
    use sextant_proto::Keys;
    use sextant_tag_families::Family;

    fn model(id: &str, tags: &[u32]) -> ObjectModel {
        let tag = |id: &u32| ObjectTag {
            tag: TagId {
                family: Family::Tag36h11,
                id: *id,
            },
            size_m: 0.04,
            object_from_tag: Some(Pose::identity()),
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
        let camera = |id: &&str| Camera {
            id: CameraId::new(id).unwrap(),
            resolution: [640, 480],
            lens,
            world_from_camera: None,
        };
        Rig::new(ids.iter().map(camera).collect()).unwrap()
    }

    fn models() -> Models {
        Models {
            rig: cameras(&["north"]),
            objects: vec![model("cube", &[1, 2]), model("box", &[3])],
        }
    }

    fn after(change: Change) -> Option<Models> {
        models().changed(&change).unwrap()
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
    fn what_is_in_force_already_changes_nothing() {
        assert_eq!(after(Change::Rig(cameras(&["north"]))), None);
        assert_eq!(after(Change::Object(model("box", &[3]))), None);
        assert_eq!(after(Change::Removal(ObjectId::new("ball").unwrap())), None);
    }

    #[test]
    fn objects_that_contradict_each_other_are_refused() {
        let refused = models().changed(&Change::Object(model("ball", &[3])));
        assert_eq!(
            refused.unwrap_err(),
            "tag tag36h11:3 is on object box and on object ball: print another id for one of them"
        );
    }

    #[test]
    fn a_camera_too_far_away_to_publish_what_it_sees_is_refused() {
        let mut far = cameras(&["north"]).cameras().to_vec();
        far[0].world_from_camera = Some(Pose::translation(0.0, 9.0e5, 0.0));
        let far = Rig::new(far).unwrap();
        let refused = models().changed(&Change::Rig(far.clone())).unwrap_err();
        assert!(refused.contains("cameras[].world_from_camera"), "{refused}");
        let models = Models {
            rig: far,
            ..models()
        };
        assert!(models.check().unwrap_err().starts_with("the rig: "));
    }

    /// What messages leave out stays in force as long as it holds; the full ones say all.
    #[test]
    fn what_is_stated_is_held_where_a_message_leaves_it_out_and_changed_where_it_says() {
        let (rig, object) = (cameras(&["north"]), model("cube", &[1, 2]));
        let north = rig.cameras()[0].id.clone();
        let first = object.tags()[0].tag;
        let sigma = PoseSigma {
            position_m: 0.001,
            orientation_rad: 0.002,
        };
        let stated = Models {
            rig: rig.clone().with_line_delays([(north, 2e-5)]).unwrap(),
            objects: vec![object.clone().with_tag_sigmas([(first, sigma)]).unwrap()],
        };
        let cube = object.id().clone();
        let after = |key: KeyRef, payload: &[u8]| {
            let change = Change::read(&key, payload, &stated).unwrap();
            stated.changed(&change).unwrap()
        };
        let plain_rig = encode(&RigConfig::from(&rig)).unwrap();
        assert_eq!(after(KeyRef::ConfigRig, &plain_rig), None);
        let plain_object = encode(&ObjectConfig::from(&object)).unwrap();
        assert_eq!(
            after(KeyRef::ConfigObject(cube.clone()), &plain_object),
            None
        );

        let full_rig = encode(&FullRig::from(&rig)).unwrap();
        let silent = after(KeyRef::FullRig, &full_rig).unwrap();
        assert_eq!(silent.rig, rig);
        let full_object = encode(&FullObject::from(&object)).unwrap();
        let silent = after(KeyRef::FullObject(cube), &full_object).unwrap();
        assert_eq!(silent.objects, [object]);
        let back = encode(&FullRig::from(&stated.rig)).unwrap();
        assert_eq!(after(KeyRef::FullRig, &back), None);
    }

    #[test]
    fn a_payload_is_read_as_its_key_says() {
        let keys = Keys::new("site").unwrap();
        let read = |key: &str, message: &ObjectConfig| {
            let key = keys.parse(&format!("sextant/v1/site/{key}")).unwrap();
            Change::read(&key, &encode(message).unwrap(), &models())
        };
        let cube = ObjectConfig::from(&model("cube", &[1]));
        let gone = ObjectConfig {
            tags: vec![],
            ..cube.clone()
        };
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
            ("config/object/box", &cube, "it describes object cube"),
            ("config/rig", &cube, "kind 8 where RigConfig was expected"),
        ] {
            let refused = read(key, message).unwrap_err();
            assert!(refused.contains(cause), "{refused}");
        }
    }
}

//! The rig and the objects in force, and what a change would make of them: whole, or a refusal with its cause.
//!
//! In: payloads under the site's `config/` keys. Out: the models after the change. Knows no network, no file and no clock.

use sextant_estimator::{Fusion, FusionOptions, ObjectId, ObjectModel, Rig, TagId};
use sextant_proto::{ArticulatedConfig, KeyRef, ObjectConfig, RigConfig, decode, limits};

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
    /// The change that a payload asks for.
    ///
    /// # Errors
    /// In words, why it is none.
    pub fn read(key: &KeyRef, payload: &[u8]) -> Result<Self, String> {
        match key {
            KeyRef::ConfigRig => rig(payload),
            KeyRef::ConfigObject(id) => object(id, payload),
            KeyRef::ConfigArticulated(id) => articulated(id, payload),
            _ => Err("no key of the configuration".to_owned()),
        }
    }
}

fn rig(payload: &[u8]) -> Result<Change, String> {
    let message: RigConfig = decode(payload).map_err(|cause| cause.to_string())?;
    if message.cameras.is_empty() {
        return Err("the rig has no camera".to_owned());
    }
    let rig = Rig::try_from(&message).map_err(|cause| cause.to_string())?;
    Ok(Change::Rig(rig))
}

fn object(id: &ObjectId, payload: &[u8]) -> Result<Change, String> {
    let message: ObjectConfig = decode(payload).map_err(|cause| cause.to_string())?;
    if message.id != *id {
        return Err(format!("it describes object {}", message.id));
    }
    if message.tags.is_empty() {
        return Ok(Change::Removal(message.id));
    }
    let model = ObjectModel::try_from(&message).map_err(|cause| cause.to_string())?;
    with_real_tags(model)
}

fn articulated(id: &ObjectId, payload: &[u8]) -> Result<Change, String> {
    let message: ArticulatedConfig = decode(payload).map_err(|cause| cause.to_string())?;
    if message.id != *id {
        return Err(format!("it describes object {}", message.id));
    }
    if message.tags.is_empty() {
        return Err("no link has a tag; objects are removed under config/object".to_owned());
    }
    let model = ObjectModel::try_from(&message).map_err(|cause| cause.to_string())?;
    with_real_tags(model)
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
    /// The models after a change; none where nothing changes.
    ///
    /// # Errors
    /// In words, why the site can't work from them.
    pub fn changed(&self, change: &Change) -> Result<Option<Self>, String> {
        let mut after = self.clone();
        match change {
            // The messages say nothing of sigmas and shutters.
            Change::Rig(rig) => after.rig = rig.clone().holding_on_to(&self.rig),
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
        Ok(Some(after))
    }

    fn put(&mut self, model: &ObjectModel) {
        match self
            .objects
            .iter_mut()
            .find(|known| known.id() == model.id())
        {
            Some(known) => *known = model.clone().holding_on_to(known),
            None => self.objects.push(model.clone()),
        }
    }

    /// As messages: the models' own quaternions may differ in their last bit after the way over the network.
    fn are_said_alike(&self, other: &Self) -> bool {
        let objects = |models: &Self| models.objects.iter().map(ObjectConfig::from).collect();
        let (ours, theirs): (Vec<_>, Vec<_>) = (objects(self), objects(other));
        let links = |models: &Self| -> Vec<_> {
            models.objects.iter().map(ArticulatedConfig::of).collect()
        };
        RigConfig::from(&self.rig) == RigConfig::from(&other.rig)
            && ours == theirs
            && links(self) == links(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_estimator::{Camera, CameraId, ObjectTag};
    use sextant_geometry::{Intrinsics, Lens, Pose};
    use sextant_proto::{Keys, encode};
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
    fn a_payload_is_read_as_its_key_says() {
        let keys = Keys::new("site").unwrap();
        let read = |key: &str, message: &ObjectConfig| {
            let key = keys.parse(&format!("sextant/v1/site/{key}")).unwrap();
            Change::read(&key, &encode(message).unwrap())
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

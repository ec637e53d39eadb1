//! What the other fusion nodes of the site work from: a node that joins them, or that is replaced by one of them, takes it over.

use crate::change_handler::{ChangeHandler, Decision};
use crate::models::{Change, Models};
use sextant_proto::{CameraSettings, KeyRef, Keys, limits};
use sextant_zenoh_bus::{Bus, BusError, Item};
use std::collections::BTreeSet;
use std::time::Duration;

/// How long the others may take to answer.
const ANSWER: Duration = Duration::from_millis(500);

/// The changes that make this node's models those of the others; none where there are no others.
///
/// # Errors
/// When the network session has ended.
pub fn changes(bus: &Bus, handler: &ChangeHandler) -> Result<Vec<Change>, BusError> {
    let key = handler.keys().all_config();
    let theirs = bus.latest_of_others(&key, limits::MAX_PAYLOAD_BYTES, ANSWER)?;
    Ok(between(handler.models(), handler.keys(), &theirs))
}

/// Makes such a change at `now_ns`: what is to be put in force, if anything.
pub fn make(handler: &mut ChangeHandler, change: Change, now_ns: u64) -> Option<Change> {
    match handler.make(change, now_ns) {
        Ok(Decision::Take(change, _)) => {
            tracing::info!(what = what(&change), "taken over from another fusion node");
            Some(change)
        }
        Ok(Decision::Same | Decision::Refuse(_)) => None,
        Err(cause) => {
            tracing::warn!("a model of another fusion node cannot be used: {cause}");
            None
        }
    }
}

fn what(change: &Change) -> String {
    match change {
        Change::Rig(_) => "rig".to_owned(),
        Change::Object(object) => format!("object {}", object.id()),
        Change::Removal(id) => format!("removal of object {id}"),
        Change::Camera(settings) => format!("settings of camera {}", settings.camera),
    }
}

/// Removals first, since a tag may have moved from one object to another. Without a rig the answers are not complete and change nothing.
fn between(own: &Models, keys: &Keys, theirs: &[Item]) -> Vec<Change> {
    let read = |item: &Item| {
        let key = keys.parse(&item.key)?;
        let is_model = matches!(
            key,
            KeyRef::ConfigRig | KeyRef::ConfigObject(_) | KeyRef::ConfigCamera(_)
        );
        let bytes = item.bytes().filter(|_| is_model)?;
        Change::read(&key, bytes)
            .inspect_err(|cause| tracing::warn!("{}: {cause}", item.key))
            .ok()
    };
    let theirs: Vec<Change> = theirs.iter().filter_map(read).collect();
    if !theirs.iter().any(|change| matches!(change, Change::Rig(_))) {
        return Vec::new();
    }
    let (mut objects, mut cameras) = (BTreeSet::new(), BTreeSet::new());
    for change in &theirs {
        match change {
            Change::Object(object) => drop(objects.insert(object.id())),
            Change::Camera(settings) => drop(cameras.insert(&settings.camera)),
            Change::Rig(_) | Change::Removal(_) => {}
        }
    }
    let own_objects = own.objects.iter().map(sextant_site_model::ObjectModel::id);
    let gone = own_objects.filter(|id| !objects.contains(id)).cloned();
    let unset = own.settings.keys().filter(|id| !cameras.contains(id));
    let unset = unset.cloned().map(CameraSettings::none);
    let removals: Vec<Change> = gone
        .map(Change::Removal)
        .chain(unset.map(Change::Camera))
        .collect();
    removals.into_iter().chain(theirs).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ObjectConfig, RigConfig, encode};
    use sextant_site_files::{parse_object, parse_rig};
    use sextant_site_model::{ObjectModel, Rig};
    use sextant_zenoh_bus::Payload;
    use std::path::Path;

    fn rig(fx: f64) -> Rig {
        let text = format!(
            "[[camera]]\nid = \"north\"\nresolution = [640, 480]\nlens = {{ model = \"pinhole\", fx = {fx:.1}, fy = 600.0, cx = 319.5, cy = 239.5 }}\n"
        );
        parse_rig(Path::new("r"), &text).unwrap()
    }

    fn object(id: &str, tag: u32) -> ObjectModel {
        let text =
            format!("id = \"{id}\"\n[[tag]]\nfamily = \"tag36h11\"\nid = {tag}\nsize = 0.04\n");
        parse_object(Path::new("o"), &text).unwrap()
    }

    fn settings(camera: &str) -> CameraSettings {
        CameraSettings {
            gain: Some(2.0),
            ..CameraSettings::none(camera.parse().unwrap())
        }
    }

    fn item(key: &str, bytes: Vec<u8>) -> Item {
        Item {
            key: format!("sextant/v1/lab/config/{key}"),
            payload: Payload::Bytes(bytes),
            sender: None,
        }
    }

    fn object_item(object: &ObjectModel) -> Item {
        let bytes = encode(&ObjectConfig::from(object)).unwrap();
        item(&format!("object/{}", object.id()), bytes)
    }

    /// A site whose tag 1 was moved from the cube to a new box while this node was away.
    #[test]
    fn a_node_that_was_away_has_the_models_of_the_others() {
        let objects = vec![object("cube", 1), object("ball", 2)];
        let own_settings = settings("north");
        let own = Models {
            rig: rig(600.0),
            objects,
            settings: [(own_settings.camera.clone(), own_settings)].into(),
        };
        let keys = Keys::new("lab").unwrap();
        let mut theirs = vec![
            object_item(&object("ball", 2)),
            object_item(&object("box", 1)),
            item("camera/south", encode(&settings("south")).unwrap()),
        ];
        assert_eq!(between(&own, &keys, &theirs), [], "no rig: not complete");
        theirs.push(item("rig", encode(&RigConfig::from(&rig(610.0))).unwrap()));
        let mut handler = ChangeHandler::new(keys.clone(), own.clone(), None);
        for change in between(&own, &keys, &theirs) {
            make(&mut handler, change, 1);
        }
        let models = handler.models();
        assert_eq!(models.rig, rig(610.0));
        assert_eq!(models.objects, [object("ball", 2), object("box", 1)]);
        let kept: Vec<_> = models.settings.values().cloned().collect();
        assert_eq!(kept, [settings("south")]);
        assert_eq!(between(&own, &keys, &[]), []);
    }
}

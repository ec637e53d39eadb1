//! The models before the last change of the rig and of each object, to revert it.

use crate::models::{Change, ModelsInForce};
use sextant_proto::{EncodeError, ModelPayload, NodeId, ObjectConfig, Proposal, RigConfig, limits};
use sextant_site_model::{ObjectId, ObjectModel, Rig};
use std::collections::BTreeMap;

/// Changes within this time of the last one, ns, are reverted together: people change several things one after the
/// other.
const TOGETHER_NS: u64 = 10_000_000_000;

/// A model and when it was replaced, ns since the Unix epoch.
#[derive(Debug, Clone, PartialEq)]
pub struct Former<M> {
    /// As it was.
    pub model: M,
    /// When it was replaced.
    pub changed_ns: u64,
}

/// At most one of each.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Formers {
    /// The rig.
    pub rig: Option<Former<Rig>>,
    /// Objects that were changed or removed; those that were added have none.
    pub objects: BTreeMap<ObjectId, Former<ObjectModel>>,
}

impl Formers {
    /// Records the models before a change at `changed_ns`. Beyond the bound the oldest object gives way.
    pub fn note(&mut self, change: &Change, before: &ModelsInForce, changed_ns: u64) {
        let id = match change {
            Change::Rig(_) => {
                let model = before.rig.clone();
                self.rig = Some(Former { model, changed_ns });
                return;
            }
            Change::Object(object) => object.id(),
            Change::Removal(id) => id,
            Change::Camera(_) => return,
        };
        self.objects.remove(id);
        let Some(model) = before.objects.iter().find(|object| object.id() == id) else {
            return;
        };
        if self.objects.len() >= limits::MAX_OBJECTS {
            let oldest = self.objects.iter().min_by_key(|(_, one)| one.changed_ns);
            if let Some(oldest) = oldest.map(|(id, _)| id.clone()) {
                self.objects.remove(&oldest);
            }
        }
        let model = model.clone();
        let former = Former { model, changed_ns };
        self.objects.insert(id.clone(), former);
    }

    /// Forgets what was before a change, which is not known any more.
    pub fn forget(&mut self, change: &Change) {
        match change {
            Change::Rig(_) => self.rig = None,
            Change::Object(object) => drop(self.objects.remove(object.id())),
            Change::Removal(id) => drop(self.objects.remove(id)),
            Change::Camera(_) => {}
        }
    }

    /// The models that revert the last change and those within ten seconds before it.
    ///
    /// # Errors
    /// A model that fits into no message.
    pub fn last(&self, node: &NodeId) -> Result<Proposal, EncodeError> {
        let times = self.objects.values().map(|one| one.changed_ns);
        let times = times.chain(self.rig.as_ref().map(|one| one.changed_ns));
        let Some(last_ns) = times.max() else {
            return Ok(Proposal::none(node.clone(), 0));
        };
        let is_last = |changed_ns: u64| last_ns - changed_ns <= TOGETHER_NS;
        let rig = self.rig.as_ref().filter(|one| is_last(one.changed_ns));
        let objects = self.objects.values().filter(|one| is_last(one.changed_ns));
        let objects = objects.map(|one| ModelPayload::encode(&ObjectConfig::from(&one.model)));
        Ok(Proposal {
            rig: rig
                .map(|one| ModelPayload::encode(&RigConfig::from(&one.model)))
                .transpose()?,
            objects: objects.collect::<Result<_, _>>()?,
            ..Proposal::none(node.clone(), last_ns)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_site_files::{parse_object, parse_rig};
    use std::path::Path;

    const SECOND_NS: u64 = 1_000_000_000;

    fn object(id: &str, tag: u32) -> ObjectModel {
        let text =
            format!("id = \"{id}\"\n[[tag]]\nfamily = \"tag36h11\"\nid = {tag}\nsize = 0.04\n");
        parse_object(Path::new("o"), &text).unwrap()
    }

    fn rig(id: &str) -> Rig {
        let text = format!(
            "[[camera]]\nid = \"{id}\"\nresolution = [640, 480]\n\
             lens = {{ model = \"pinhole\", fx = 600.0, fy = 600.0, cx = 319.5, cy = 239.5 }}\n"
        );
        parse_rig(Path::new("r"), &text).unwrap()
    }

    fn models() -> ModelsInForce {
        ModelsInForce {
            rig: rig("north"),
            objects: vec![object("cube", 1), object("box", 2)],
            settings: Default::default(),
        }
    }

    fn last(formers: &Formers) -> (Option<RigConfig>, Vec<ObjectConfig>) {
        let proposal = formers.last(&NodeId::new("main").unwrap()).unwrap();
        (
            proposal.rig_config().unwrap(),
            proposal.object_configs().unwrap(),
        )
    }

    #[test]
    fn changes_of_one_time_are_taken_back_together_and_earlier_ones_stay() {
        let mut formers = Formers::default();
        assert_eq!(last(&formers), (None, vec![]));
        let before = models();
        let changed = |id, tag| Change::Object(object(id, tag));
        formers.note(&changed("box", 9), &before, SECOND_NS);
        formers.note(&Change::Rig(rig("south")), &before, 60 * SECOND_NS);
        formers.note(&changed("cube", 8), &before, 61 * SECOND_NS);
        let cube = ObjectConfig::from(&before.objects[0]);
        assert_eq!(
            last(&formers),
            (Some(RigConfig::from(&before.rig)), vec![cube])
        );
        let of_box = formers.objects.get(before.objects[1].id()).unwrap();
        assert_eq!(of_box.model, before.objects[1]);
    }

    #[test]
    fn a_removed_object_comes_back_and_an_added_one_has_no_former() {
        let mut formers = Formers::default();
        let before = models();
        let cube = before.objects[0].id().clone();
        formers.note(&Change::Removal(cube), &before, SECOND_NS);
        formers.note(&Change::Object(object("ball", 3)), &before, SECOND_NS);
        assert_eq!(
            last(&formers),
            (None, vec![ObjectConfig::from(&before.objects[0])])
        );
    }

    #[test]
    fn a_flood_of_removed_objects_ends_at_the_bound() {
        let mut formers = Formers::default();
        for n in 0..3 * limits::MAX_OBJECTS as u64 {
            let before = ModelsInForce {
                objects: vec![object(&format!("o{n}"), 1)],
                ..models()
            };
            let gone = Change::Removal(before.objects[0].id().clone());
            formers.note(&gone, &before, n);
            assert!(formers.objects.len() <= limits::MAX_OBJECTS);
        }
        assert!(
            formers
                .objects
                .values()
                .all(|one| one.changed_ns > limits::MAX_OBJECTS as u64)
        );
    }
}

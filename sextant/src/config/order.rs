//! The order in which several objects are set, so that no tag is ever on two of them: fusion nodes refuse that.

use sextant_proto::ObjectConfig;
use sextant_site_model::{ObjectId, ObjectModel, TagId};
use std::collections::{BTreeMap, BTreeSet};

/// Changes one after the other from the objects in force to those wanted. An object that gives a tag to another comes first; where two
/// exchange tags, one is removed meanwhile.
pub fn in_order(
    in_force: &BTreeMap<ObjectId, ObjectConfig>,
    wanted: &[ObjectConfig],
) -> Vec<ObjectConfig> {
    let before: BTreeMap<&ObjectId, BTreeSet<TagId>> = in_force
        .iter()
        .map(|(id, object)| (id, tags(object)))
        .collect();
    let held_elsewhere = |id: &ObjectId, tag: &TagId| {
        let mut others = before.iter().filter(|(other, _)| **other != id);
        others.any(|(_, tags)| tags.contains(tag))
    };
    let taken_elsewhere = |id: &ObjectId, tag: &TagId| {
        let mut others = wanted.iter().filter(|other| other.id != *id);
        others.any(|other| tags(other).contains(tag))
    };
    let (mut first, mut last) = (Vec::new(), Vec::new());
    for object in wanted {
        let after = tags(object);
        let lost = before.get(&object.id).into_iter().flatten();
        let mut lost = lost.filter(|tag| !after.contains(tag));
        let gives = lost.any(|tag| taken_elsewhere(&object.id, tag));
        let takes = after.iter().any(|tag| held_elsewhere(&object.id, tag));
        match (gives, takes) {
            (true, false) => first.push(object.clone()),
            (true, true) => {
                first.push(ObjectConfig::removal(object.id.clone()));
                last.push(object.clone());
            }
            (false, _) => last.push(object.clone()),
        }
    }
    first.extend(last);
    first
}

fn tags(object: &ObjectConfig) -> BTreeSet<TagId> {
    let model = ObjectModel::try_from(object).ok();
    let tags = model.iter().flat_map(ObjectModel::tags);
    tags.map(|tag| tag.tag).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_geometry::Pose;
    use sextant_site_model::ObjectTag;
    use sextant_tag_families::Family;

    fn object(id: &str, ids: &[u32]) -> ObjectConfig {
        let tag = |id: &u32| {
            let tag = TagId {
                family: Family::Tag36h11,
                id: *id,
            };
            ObjectTag::new(tag, 0.04, Some(Pose::identity()))
        };
        let model = ObjectModel::new(id.parse().unwrap(), ids.iter().map(tag).collect());
        ObjectConfig::from(&model.unwrap())
    }

    /// Takes each step as a fusion node does.
    fn applied(in_force: &[ObjectConfig], wanted: &[ObjectConfig]) -> Vec<ObjectConfig> {
        let by_id = |objects: &[ObjectConfig]| -> BTreeMap<ObjectId, ObjectConfig> {
            let pairs = objects
                .iter()
                .map(|object| (object.id.clone(), object.clone()));
            pairs.collect()
        };
        let mut site = by_id(in_force);
        for step in in_order(&site.clone(), wanted) {
            if step.is_removal() {
                site.remove(&step.id);
            } else {
                site.insert(step.id.clone(), step);
            }
            let all: Vec<TagId> = site.values().flat_map(tags).collect();
            let unique: BTreeSet<TagId> = all.iter().copied().collect();
            assert_eq!(all.len(), unique.len(), "a tag is on two objects");
        }
        assert_eq!(site, by_id(wanted));
        site.into_values().collect()
    }

    #[test]
    fn a_tag_leaves_an_object_before_another_has_it() {
        let moved = [object("a", &[1]), object("b", &[2, 3])];
        let former = [object("a", &[1, 3]), object("b", &[2])];
        applied(&moved, &former);
        applied(&former, &moved);
    }

    #[test]
    fn exchanged_tags_and_rings_are_taken_back_too() {
        let now = [object("a", &[1]), object("b", &[2])];
        applied(&now, &[object("a", &[2]), object("b", &[1])]);
        let ring = [object("a", &[1, 9]), object("b", &[2]), object("c", &[3])];
        applied(
            &ring,
            &[object("a", &[3]), object("b", &[1]), object("c", &[2, 9])],
        );
        applied(&now, &[object("a", &[1]), object("b", &[2])]);
    }
}

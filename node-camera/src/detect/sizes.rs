//! Sizes of all tags, by object; bounded.
//!
//! Drop rule: an object that finds no room is refused. The caller then asks for everything anew, which forgets what nobody
//! answers for.

use std::collections::BTreeMap;

use sextant_proto::limits;
use sextant_site_model::{ObjectModel, TagId};

/// Tags of all objects.
const MOST_TAGS: usize = 16_384;

/// Sizes in metres by object, and then by tag: an object that changes takes its own tags along.
#[derive(Debug, Default)]
pub(super) struct Sizes {
    objects: BTreeMap<String, BTreeMap<TagId, f64>>,
}

/// There is no room for another object.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Full;

impl Sizes {
    /// Takes an object's tags in the place of those that it had; tags that their family does not have are left out.
    pub(super) fn take(&mut self, object: &str, model: &ObjectModel) -> Result<(), Full> {
        let is_real = |tag: TagId| (tag.id as usize) < tag.family.data().codes.len();
        let tags = model.tags().iter().filter(|tag| is_real(tag.tag));
        let tags: BTreeMap<TagId, f64> = tags.map(|tag| (tag.tag, tag.size_m)).collect();
        self.objects.remove(object);
        let n_tags: usize = self.objects.values().map(BTreeMap::len).sum();
        if self.objects.len() >= limits::MAX_OBJECTS || n_tags + tags.len() > MOST_TAGS {
            return Err(Full);
        }
        self.objects.insert(object.to_owned(), tags);
        Ok(())
    }

    /// The object is gone.
    pub(super) fn remove(&mut self, object: &str) {
        self.objects.remove(object);
    }

    /// Forgets all objects.
    pub(super) fn clear(&mut self) {
        self.objects.clear();
    }

    /// Edge of a tag's black square in metres. Of two objects that claim a tag the first by name has it.
    pub(super) fn size_m(&self, tag: &TagId) -> Option<f64> {
        self.objects
            .values()
            .find_map(|tags| tags.get(tag))
            .copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_apriltag::Family;
    use sextant_site_model::{ObjectId, ObjectTag};

    const FAMILY: Family = Family::Tag36h11;

    fn model(tags: impl Iterator<Item = u32>) -> ObjectModel {
        let tag = |id| ObjectTag::new(TagId { family: FAMILY, id }, 0.04, None);
        ObjectModel::new(ObjectId::new("cube").unwrap(), tags.map(tag).collect()).unwrap()
    }

    #[test]
    fn a_flood_of_objects_ends_at_the_bound_and_those_that_were_there_stay() {
        let mut sizes = Sizes::default();
        let (real, forged) = (model(3..4), model(4..5));
        sizes.take("real", &real).unwrap();
        let taken =
            (0..10 * limits::MAX_OBJECTS).filter(|n| sizes.take(&format!("x{n}"), &forged).is_ok());
        assert_eq!(taken.count(), limits::MAX_OBJECTS - 1);
        sizes.take("real", &real).unwrap();
        let tag = real.tags()[0].tag;
        assert_eq!(sizes.size_m(&tag), Some(0.04));
    }

    #[test]
    fn a_flood_of_tags_ends_at_the_bound() {
        let mut sizes = Sizes::default();
        let n_real = FAMILY.data().codes.len() as u32;
        let many = model(0..1024);
        let taken = (0..10 * MOST_TAGS as u32 / n_real)
            .filter(|n| sizes.take(&format!("x{n}"), &many).is_ok());
        assert_eq!(taken.count(), MOST_TAGS / n_real as usize);
        let unreal = TagId {
            family: FAMILY,
            id: n_real,
        };
        assert_eq!(sizes.size_m(&unreal), None);
    }
}

//! Which object a tag belongs to, and its size.

use crate::bounded_map::Full;
use crate::limits;
use sextant_proto::ObjectConfig;
use sextant_site_model::{ObjectId, TagId};
use std::collections::BTreeMap;

/// The tags of all objects. Drop rule: an object whose tags find no room is refused.
#[derive(Debug, Clone, Default)]
pub(crate) struct TagIndex {
    /// By tag, the objects that have it and its size, m.
    owners: BTreeMap<TagId, BTreeMap<ObjectId, f64>>,
    /// Tags in all configurations.
    n_tags: usize,
}

impl TagIndex {
    /// Replaces the tags that an object had. Tags that their family does not have are left out.
    pub(crate) fn replace(
        &mut self,
        before: Option<&ObjectConfig>,
        config: &ObjectConfig,
    ) -> Result<(), Full> {
        let n_before = before.map_or(0, |before| before.tags.len());
        if self.n_tags - n_before + config.tags.len() > limits::TAGS {
            return Err(Full);
        }
        if let Some(before) = before {
            self.remove(before);
        }
        self.n_tags += config.tags.len();
        for (tag, size_m) in real_tags(config) {
            let owners = self.owners.entry(tag).or_default();
            owners.insert(config.id.clone(), size_m);
        }
        Ok(())
    }

    /// The object is gone.
    pub(crate) fn remove(&mut self, config: &ObjectConfig) {
        self.n_tags -= config.tags.len();
        for (tag, _) in real_tags(config) {
            if let Some(owners) = self.owners.get_mut(&tag) {
                owners.remove(&config.id);
                if owners.is_empty() {
                    self.owners.remove(&tag);
                }
            }
        }
    }

    /// The object that has a tag and the edge of its black square, m. Of two objects that claim it the first by name
    /// has it.
    pub(crate) fn get(&self, tag: TagId) -> Option<(&ObjectId, f64)> {
        let (object, size_m) = self.owners.get(&tag)?.first_key_value()?;
        Some((object, *size_m))
    }
}

#[cfg(test)]
impl TagIndex {
    pub(crate) fn len(&self) -> usize {
        self.n_tags
    }
}

fn real_tags(config: &ObjectConfig) -> impl Iterator<Item = (TagId, f64)> {
    let tags = config.tags.iter().map(|tag| {
        let (family, id) = (tag.family, tag.id);
        (TagId { family, id }, tag.size_m)
    });
    tags.filter(|(tag, _)| (tag.id as usize) < tag.family.data().codes.len())
}

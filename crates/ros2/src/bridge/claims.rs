//! Who bears which name: ids may differ where topics or frames made of them do not (`pad-2` and `pad_2`), and then the
//! first keeps it.

use std::collections::BTreeMap;

use sextant_site_model::{CameraId, ObjectId};

/// Most names, and most streams: those of the largest site.
pub(super) const MOST: usize = 4096;

/// Who bears a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Owner {
    World,
    Object(ObjectId),
    Camera(CameraId),
}

/// Names of topics and frames by their owner.
#[derive(Debug)]
pub(super) struct Claims {
    owners: BTreeMap<String, Owner>,
}

impl Claims {
    /// Reserves the frame of the world.
    pub(super) fn with_frame(world: &str) -> Self {
        Self {
            owners: BTreeMap::from([(world.to_owned(), Owner::World)]),
        }
    }

    /// Assigns a free name; returns whether the owner has it.
    pub(super) fn take(&mut self, name: &str, owner: &Owner) -> bool {
        match self.owners.get(name) {
            Some(holder) => holder == owner,
            None if self.owners.len() >= MOST => false,
            None => {
                self.owners.insert(name.to_owned(), owner.clone());
                true
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_keeps_a_name() {
        let [a, b] = ["pad-2", "pad_2"].map(|id| Owner::Object(ObjectId::new(id).unwrap()));
        let mut claims = Claims::with_frame("world");
        assert!(claims.take("object/pad_2/pose", &a));
        assert!(claims.take("object/pad_2/pose", &a));
        assert!(!claims.take("object/pad_2/pose", &b));
        assert!(!claims.take("world", &b));
    }

    #[test]
    fn a_flood_of_names_takes_no_more_room_at_the_bound() {
        let owner = Owner::Object(ObjectId::new("x").unwrap());
        let mut claims = Claims::with_frame("world");
        let taken = (0..2 * MOST).filter(|k| claims.take(&k.to_string(), &owner));
        assert_eq!(taken.count(), MOST - 1);
    }
}

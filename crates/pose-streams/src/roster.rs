//! Objects in numbered places, each with its newest pose, for protocols whose frames have all objects.

use sextant_proto::{ObjectPose, limits};
use sextant_site_model::ObjectId;
use sextant_site_report::State;

/// Objects in the order in which they were named, described or seen first; each keeps its place, also while it is
/// removed. Where there is no other place, a new object gets that of a removed one.
#[derive(Debug, Default)]
pub(crate) struct Roster {
    members: Vec<Member>,
}

#[derive(Debug)]
pub(crate) struct Member {
    pub(crate) name: ObjectId,
    pub(crate) pose: Option<ObjectPose>,
    /// Whether the pose is newer than the last frame.
    pub(crate) is_new: bool,
    is_removed: bool,
}

impl Roster {
    pub(crate) fn new(names: &[ObjectId]) -> Self {
        let mut roster = Self::default();
        for name in names {
            roster.add(name);
        }
        roster
    }

    /// Gives an object a place; returns whether it is a new one. Beyond the most objects that a site may have there is
    /// none.
    pub(crate) fn add(&mut self, name: &ObjectId) -> bool {
        let known = self.members.iter_mut().find(|member| member.name == *name);
        if let Some(known) = known {
            return std::mem::take(&mut known.is_removed);
        }
        let member = Member {
            name: name.clone(),
            pose: None,
            is_new: false,
            is_removed: false,
        };
        if self.members.len() < limits::MAX_OBJECTS {
            self.members.push(member);
            return true;
        }
        let removed = self.members.iter_mut().find(|member| member.is_removed);
        removed.map(|removed| *removed = member).is_some()
    }

    /// Leaves an object out until it is added again.
    pub(crate) fn remove(&mut self, name: &ObjectId) {
        if let Some(member) = self.members.iter_mut().find(|member| member.name == *name) {
            (member.pose, member.is_new, member.is_removed) = (None, false, true);
        }
    }

    pub(crate) fn has(&self, name: &ObjectId) -> bool {
        self.members.iter().any(|member| member.name == *name)
    }

    /// Takes a pose; returns whether its object is a new one. A late pose of a removed object means nothing.
    pub(crate) fn take(&mut self, pose: &ObjectPose) -> bool {
        let is_new = !self.has(&pose.object) && self.add(&pose.object);
        let mut members = self.members.iter_mut().filter(|member| !member.is_removed);
        if let Some(member) = members.find(|member| member.name == pose.object) {
            member.pose = Some(pose.clone());
            member.is_new = true;
        }
        is_new
    }

    /// Whether there is a new pose of every object that is tracked.
    pub(crate) fn is_complete(&self) -> bool {
        let mut tracked = self.members.iter().filter(|member| member.is_tracked());
        tracked.all(|member| member.is_new)
    }

    /// A frame was sent.
    pub(crate) fn age(&mut self) {
        for member in &mut self.members {
            member.is_new = false;
        }
    }

    /// The objects with their numbers, from 1 on.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (u16, &Member)> {
        // A site has fewer objects than there are numbers.
        let numbered = (1..).zip(&self.members);
        numbered.filter(|(_, member)| !member.is_removed)
    }

    /// Those of them that have been seen.
    pub(crate) fn seen(&self) -> impl Iterator<Item = (u16, &Member, &ObjectPose)> {
        self.numbered()
            .filter_map(|(number, member)| Some((number, member, member.pose.as_ref()?)))
    }
}

impl Member {
    pub(crate) fn is_tracked(&self) -> bool {
        let state = self.pose.as_ref().map(|pose| pose.state);
        state == Some(State::Tracking)
    }

    /// Whether its pose is new and no prediction.
    pub(crate) fn is_measured(&self) -> bool {
        self.is_new && self.is_tracked()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_of_objects_ends_at_the_bound() {
        let names = (0..2 * limits::MAX_OBJECTS).map(|n| ObjectId::new(&format!("o{n}")).unwrap());
        let roster = Roster::new(&names.collect::<Vec<_>>());
        assert_eq!(roster.numbered().count(), limits::MAX_OBJECTS);
        assert_eq!(roster.seen().count(), 0);
    }

    #[test]
    fn a_full_roster_has_room_in_place_of_a_removed_object() {
        let names = (0..limits::MAX_OBJECTS).map(|n| ObjectId::new(&format!("o{n}")).unwrap());
        let names: Vec<_> = names.collect();
        let mut roster = Roster::new(&names);
        let new = ObjectId::new("new").unwrap();
        assert!(!roster.add(&new));
        roster.remove(&names[7]);
        assert_eq!(roster.numbered().count(), limits::MAX_OBJECTS - 1);
        assert!(roster.add(&new));
        let (_, member) = roster.numbered().nth(7).unwrap();
        assert_eq!(member.name, new);
        assert!(!roster.add(&names[7]));
    }
}

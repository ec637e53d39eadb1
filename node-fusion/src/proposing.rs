//! Refined calibrations of the estimator: as a message, as changes of the site, as a notice, and those on offer, which
//! a request names by number.

use crate::models::Change;
use sextant_estimator::{HeldBack, Proposal};
use sextant_proto::{
    EncodeError, ModelPayload, NodeId, Notice, ObjectConfig, Proposal as Message, Refusal,
    RigConfig,
};
use std::collections::VecDeque;

/// Most proposals on offer: who looks at one may still apply it when newer ones have come. The oldest gives way.
const MOST: usize = 8;

/// The proposals that a node has made since it last had none; all of them are about the models in force.
#[derive(Debug)]
pub struct Proposals {
    node: NodeId,
    /// With their numbers, the newest last.
    offered: VecDeque<(u64, Proposal)>,
    /// The greatest number so far.
    last: u64,
}

impl Proposals {
    /// Begins for a node that has made no proposals.
    #[must_use]
    pub fn new(node: NodeId) -> Self {
        Self {
            node,
            offered: VecDeque::new(),
            last: 0,
        }
    }

    /// The newest proposal that is offered; `None` where none is.
    #[must_use]
    pub fn newest(&self) -> Option<&Proposal> {
        self.offered.back().map(|(_, proposal)| proposal)
    }

    /// Offers another proposal, whose number is its time where that is greater than all before, or withdraws all;
    /// whether that changes anything.
    pub fn offer(&mut self, proposal: Option<Proposal>, now_ns: u64) -> bool {
        if proposal.as_ref() == self.newest() {
            return false;
        }
        let Some(proposal) = proposal else {
            self.offered.clear();
            return true;
        };
        self.last = now_ns.max(self.last + 1);
        if self.offered.len() == MOST {
            self.offered.pop_front();
        }
        self.offered.push_back((self.last, proposal));
        true
    }

    /// The message of the newest; an empty one made at `now_ns` where there is none.
    ///
    /// # Errors
    /// A model that fits into no message.
    pub fn message(&self, now_ns: u64) -> Result<Message, EncodeError> {
        match self.offered.back() {
            Some((number, proposal)) => message(proposal, &self.node, *number),
            None => Ok(Message::none(self.node.clone(), now_ns)),
        }
    }

    /// The changes that put the proposal of this number in force.
    ///
    /// # Errors
    /// It is of another node, or not on offer any more.
    pub fn changes(&self, node: &NodeId, number: u64) -> Result<Vec<Change>, Refusal> {
        let of_number = |offered: &&(u64, Proposal)| offered.0 == number && *node == self.node;
        let found = self.offered.iter().find(of_number);
        let (_, proposal) = found.ok_or_else(|| Refusal::Other {
            detail: format!(
                "fusion node {} does not propose this calibration (any more): look at what is proposed now",
                self.node
            ),
        })?;
        Ok(changes(proposal.clone()).collect())
    }
}

fn message(proposal: &Proposal, node: &NodeId, number: u64) -> Result<Message, EncodeError> {
    let rig = proposal.rig.as_ref().map(RigConfig::from);
    let objects = proposal.objects.iter().map(ObjectConfig::from);
    Ok(Message {
        rig: rig.as_ref().map(ModelPayload::encode).transpose()?,
        objects: objects
            .map(|object| ModelPayload::encode(&object))
            .collect::<Result<_, _>>()?,
        n_images: u32::try_from(proposal.held_back.n_images).unwrap_or(u32::MAX),
        before_px: proposal.held_back.before_px,
        after_px: proposal.held_back.after_px,
        ..Message::none(node.clone(), number)
    })
}

/// The changes that put a proposal in force.
pub fn changes(proposal: Proposal) -> impl Iterator<Item = Change> {
    let rig = proposal.rig.map(Change::Rig);
    rig.into_iter()
        .chain(proposal.objects.into_iter().map(Change::Object))
}

/// What it is worth.
pub fn notice(held_back: &HeldBack) -> Notice {
    Notice::RefinementProposed {
        n_images: u32::try_from(held_back.n_images).unwrap_or(u32::MAX),
        before_px: held_back.before_px,
        after_px: held_back.after_px,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn proposal(n_images: usize) -> Proposal {
        Proposal {
            rig: None,
            objects: Vec::new(),
            held_back: HeldBack {
                n_images,
                before_px: 1.0,
                after_px: 0.5,
            },
        }
    }

    fn node(name: &str) -> NodeId {
        NodeId::new(name).unwrap()
    }

    #[test]
    fn a_proposal_is_found_by_node_and_number_until_all_are_withdrawn() {
        let mut proposals = Proposals::new(node("main"));
        assert!(proposals.offer(Some(proposal(8)), 100));
        assert!(!proposals.offer(Some(proposal(8)), 200));
        assert!(proposals.offer(Some(proposal(9)), 100));
        assert_eq!(proposals.message(7).unwrap().t_ns, 101);
        assert!(proposals.changes(&node("main"), 100).is_ok());
        assert!(proposals.changes(&node("main"), 101).is_ok());
        assert!(proposals.changes(&node("other"), 101).is_err());
        assert!(proposals.changes(&node("main"), 102).is_err());
        assert!(proposals.offer(None, 300));
        assert!(proposals.changes(&node("main"), 101).is_err());
        assert_eq!(proposals.message(7).unwrap().t_ns, 7);
    }

    #[test]
    fn of_many_proposals_the_newest_are_on_offer() {
        let mut proposals = Proposals::new(node("main"));
        (0..3 * MOST).for_each(|n| assert!(proposals.offer(Some(proposal(n)), n as u64)));
        assert_eq!(proposals.offered.len(), MOST);
        assert_eq!(proposals.newest(), Some(&proposal(3 * MOST - 1)));
    }
}

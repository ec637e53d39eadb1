//! What fusion nodes offer to be put in force: a refined calibration, and what was in force before the last change.

use super::publication::Outgoing;
use crate::refusal::Refusal;
use sextant_proto::{NodeId, Proposal};
use std::collections::BTreeMap;

/// Fusion nodes whose offers are kept; those of further ones are passed over.
const MOST_NODES: usize = 16;

/// Which of the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Offer {
    /// A refined calibration.
    Refinement,
    /// What was before the last change.
    Former,
}

/// The newest of each node.
#[derive(Debug, Default)]
pub(crate) struct Offers(BTreeMap<(NodeId, Offer), Proposal>);

impl Offers {
    pub(crate) fn take(&mut self, offer: Offer, proposal: Proposal) {
        let key = (proposal.node.clone(), offer);
        let of_kind = self.0.keys().filter(|(_, kind)| *kind == offer).count();
        if of_kind < MOST_NODES || self.0.contains_key(&key) {
            self.0.insert(key, proposal);
        }
    }

    pub(crate) fn forget(&mut self, node: &NodeId) {
        self.0.retain(|(of, _), _| of != node);
    }

    /// The change that puts an offer in force.
    pub(crate) fn change(&self, node: &NodeId, offer: Offer) -> Result<Outgoing, Refusal> {
        let known = self.0.get(&(node.clone(), offer));
        let Some(proposal) = known.filter(|proposal| !proposal.is_empty()) else {
            let what = match offer {
                Offer::Refinement => "proposes no refined calibration",
                Offer::Former => "knows no change that could be taken back",
            };
            return Err(Refusal::not_now(format!("fusion node {node} {what}")));
        };
        Ok(Outgoing::Models(match offer {
            // The node applies what it has proposed under this number.
            Offer::Refinement => Proposal::none(proposal.node.clone(), proposal.t_ns),
            Offer::Former => proposal.clone(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ModelPayload, RigConfig};

    fn node(name: &str) -> NodeId {
        NodeId::new(name).unwrap()
    }

    fn proposal(name: &str) -> Proposal {
        let rig = RigConfig {
            cameras: vec![],
            scale_sigma: None,
        };
        Proposal {
            rig: Some(ModelPayload::encode(&rig).unwrap()),
            ..Proposal::none(node(name), 1)
        }
    }

    #[test]
    fn what_is_offered_is_put_in_force_until_it_is_withdrawn() {
        let mut offers = Offers::default();
        assert!(offers.change(&node("a"), Offer::Refinement).is_err());
        offers.take(Offer::Refinement, proposal("a"));
        assert_eq!(
            offers.change(&node("a"), Offer::Refinement).ok(),
            Some(Outgoing::Models(Proposal::none(node("a"), 1)))
        );
        assert!(offers.change(&node("a"), Offer::Former).is_err());
        offers.take(Offer::Refinement, Proposal::none(node("a"), 2));
        assert!(offers.change(&node("a"), Offer::Refinement).is_err());
    }

    #[test]
    fn a_flood_of_offers_ends_at_the_bound() {
        let mut offers = Offers::default();
        (0..10 * MOST_NODES).for_each(|n| offers.take(Offer::Former, proposal(&format!("n{n}"))));
        assert_eq!(offers.0.len(), MOST_NODES);
        offers.forget(&node("n0"));
        offers.take(Offer::Former, proposal("real"));
        assert!(offers.change(&node("real"), Offer::Former).is_ok());
    }
}

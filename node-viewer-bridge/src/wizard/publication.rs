//! A result on its way to the running site: published as `sextant config set` does, and what its fusion nodes answer.

use sextant_calibrator::procedure::Product;
use sextant_proto::{
    CameraSettings, ConfigAnswer, NodeId, ObjectConfig, Outcome, RigConfig, encode, fingerprint,
};
use sextant_site_files::{object_toml, rig_toml};
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// How long the nodes may take to answer.
const PATIENCE: Duration = Duration::from_secs(3);

/// Most answers kept of nodes that are not waited for.
const MOST_ANSWERS: usize = 64;

/// A change for the network.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outgoing {
    /// Of the rig.
    Rig(RigConfig),
    /// Of an object.
    Object(ObjectConfig),
    /// Of a camera's exposure, gain and rate.
    Camera(CameraSettings),
}

impl Outgoing {
    /// The message that puts a result into force.
    pub(super) fn of(product: &Product) -> Self {
        match product {
            Product::Rig(rig) => Self::Rig(RigConfig::from(rig)),
            Product::Object(object) => Self::Object(ObjectConfig::from(object)),
        }
    }

    /// The fingerprint that answers carry; the cause where it does not fit into a message.
    fn fingerprint(&self) -> Result<u64, String> {
        let payload = match self {
            Self::Rig(rig) => encode(rig),
            Self::Object(object) => encode(object),
            Self::Camera(settings) => encode(settings),
        };
        let payload = payload.map_err(|error| error.to_string())?;
        Ok(fingerprint(&payload))
    }
}

/// Answers that are waited for.
#[derive(Debug)]
pub(super) struct Publication {
    fingerprint: u64,
    silent: BTreeSet<NodeId>,
    answers: BTreeMap<NodeId, ConfigAnswer>,
    deadline: Instant,
}

/// What the nodes made of it.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answered {
    /// Some have not answered, and there is time left.
    NotYet,
    /// One refused, with the cause; then nothing is kept.
    Refused(String),
    /// It is in force: a sentence for each node.
    Done(Vec<String>),
}

/// Name and text of the file that a person may download.
pub(super) fn file_of(product: &Product) -> (String, String) {
    match product {
        Product::Rig(rig) => ("rig.toml".to_owned(), rig_toml(rig)),
        Product::Object(object) => (format!("{}.toml", object.id()), object_toml(object)),
    }
}

impl Publication {
    /// Waits for these nodes from now on; the cause where the change does not fit into a message.
    pub(super) fn of(
        outgoing: &Outgoing,
        nodes: &BTreeSet<NodeId>,
        now: Instant,
    ) -> Result<Self, String> {
        Ok(Self {
            fingerprint: outgoing.fingerprint()?,
            silent: nodes.clone(),
            answers: BTreeMap::new(),
            deadline: now + PATIENCE,
        })
    }

    pub(super) fn take(&mut self, answer: &ConfigAnswer) {
        let has_room = self.answers.len() < MOST_ANSWERS || self.silent.contains(&answer.node);
        if answer.fingerprint == self.fingerprint && has_room {
            self.silent.remove(&answer.node);
            self.answers.insert(answer.node.clone(), answer.clone());
        }
    }

    pub(super) fn answered(&self, now: Instant) -> Answered {
        let refused = self
            .answers
            .values()
            .find_map(|answer| match &answer.outcome {
                Outcome::Refused(refusal) => Some(format!("{} refused it: {refusal}", answer.node)),
                Outcome::Kept | Outcome::Taken | Outcome::Same => None,
            });
        if let Some(refused) = refused {
            return Answered::Refused(refused);
        }
        if !self.silent.is_empty() && now < self.deadline {
            return Answered::NotYet;
        }
        let silent = self.silent.iter().map(|node| {
            format!(
                "fusion node {node} has not answered for {} s",
                PATIENCE.as_secs()
            )
        });
        Answered::Done(self.answers.values().map(sentence).chain(silent).collect())
    }
}

fn sentence(answer: &ConfigAnswer) -> String {
    let node = &answer.node;
    match &answer.outcome {
        Outcome::Kept => format!("in force on fusion node {node}, which keeps it in its files"),
        Outcome::Taken => format!(
            "in force on fusion node {node} until that ends: `keep_changes` in its file is false"
        ),
        Outcome::Same | Outcome::Refused(_) => format!("fusion node {node} had it already"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::Refusal;

    fn answer(node: &str, fingerprint: u64, outcome: Outcome) -> ConfigAnswer {
        ConfigAnswer {
            node: NodeId::new(node).unwrap(),
            key: "config/rig".to_owned(),
            fingerprint,
            outcome,
        }
    }

    #[test]
    fn every_node_is_waited_for_but_not_for_ever() {
        let outgoing = Outgoing::Rig(RigConfig {
            cameras: vec![],
            scale_sigma: None,
        });
        let number = outgoing.fingerprint().unwrap();
        let nodes = ["a", "b"].map(|node| NodeId::new(node).unwrap());
        let start = Instant::now();
        let mut publication = Publication::of(&outgoing, &BTreeSet::from(nodes), start).unwrap();
        publication.take(&answer("a", number, Outcome::Kept));
        publication.take(&answer("b", number + 1, Outcome::Kept));
        assert_eq!(publication.answered(start), Answered::NotYet);
        let Answered::Done(late) = publication.answered(start + PATIENCE) else {
            panic!("still waiting");
        };
        assert!(late[1].contains("b has not answered"), "{late:?}");
        publication.take(&answer("b", number, Outcome::Refused(Refusal::NoCamera)));
        let refused = publication.answered(start);
        assert_eq!(
            refused,
            Answered::Refused("b refused it: the rig has no camera".to_owned())
        );
    }

    #[test]
    fn a_flood_of_answers_ends_at_the_bound_and_hides_none_that_is_waited_for() {
        let outgoing = Outgoing::Rig(RigConfig {
            cameras: vec![],
            scale_sigma: None,
        });
        let number = outgoing.fingerprint().unwrap();
        let awaited = BTreeSet::from([NodeId::new("real").unwrap()]);
        let start = Instant::now();
        let mut publication = Publication::of(&outgoing, &awaited, start).unwrap();
        for n in 0..10 * MOST_ANSWERS {
            publication.take(&answer(&format!("n{n}"), number, Outcome::Kept));
        }
        assert_eq!(publication.answers.len(), MOST_ANSWERS);
        publication.take(&answer("real", number, Outcome::Kept));
        assert_eq!(publication.answers.len(), MOST_ANSWERS + 1);
    }
}

//! A result on its way to the running site: published as `sextant config set` does, and what the fusion node that
//! publishes the poses answers.

use sextant_calibrator::procedure::Product;
use sextant_proto::{
    CameraSettings, ChangeOutcome, ConfigAnswer, ObjectConfig, Proposal, RigConfig, encode,
    fingerprint,
};
use sextant_site_files::{object_toml, rig_toml};
use std::time::{Duration, Instant};

/// How long the answer may take: the disk of the fusion node may be slow.
const PATIENCE: Duration = Duration::from_secs(15);

/// A change for the network.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outgoing {
    /// Of the rig.
    Rig(RigConfig),
    /// Of an object.
    Object(ObjectConfig),
    /// Of a camera's exposure, gain and rate.
    Camera(CameraSettings),
    /// What a fusion node offers.
    Models(Proposal),
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
            Self::Models(proposal) => encode(proposal),
        };
        let payload = payload.map_err(|error| error.to_string())?;
        Ok(fingerprint(&payload))
    }
}

/// An answer that is waited for.
#[derive(Debug)]
pub(super) struct Publication {
    fingerprint: u64,
    answer: Option<ConfigAnswer>,
    deadline: Instant,
}

/// What became of it.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Answered {
    /// There is no answer, and there is time left.
    NotYet,
    /// It was refused, with the cause; then nothing is kept.
    Refused(String),
    /// It is in force, a sentence for each node; or there was no answer.
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
    /// Waits from now on; the cause where the change does not fit into a message.
    pub(super) fn of(outgoing: &Outgoing, now: Instant) -> Result<Self, String> {
        Ok(Self {
            fingerprint: outgoing.fingerprint()?,
            answer: None,
            deadline: now + PATIENCE,
        })
    }

    pub(super) fn take(&mut self, answer: &ConfigAnswer) {
        if answer.fingerprint == self.fingerprint {
            self.answer = Some(answer.clone());
        }
    }

    pub(super) fn answered(&self, now: Instant) -> Answered {
        let Some(answer) = &self.answer else {
            if now < self.deadline {
                return Answered::NotYet;
            }
            let patience_s = PATIENCE.as_secs();
            let silence = "no fusion node has answered";
            return Answered::Done(vec![format!(
                "{silence} for {patience_s} s: see whether it is in force before you try again"
            )]);
        };
        let node = &answer.node;
        let there = match &answer.outcome {
            ChangeOutcome::Refused(refusal) => {
                return Answered::Refused(format!(
                    "{node} refused it: {refusal}; everything stays as it was"
                ));
            }
            ChangeOutcome::Kept => {
                format!("in force on fusion node {node}, which keeps it in its files")
            }
            ChangeOutcome::Taken => format!(
                "in force on fusion node {node} until that ends: `keep_changes` in its file is false"
            ),
            ChangeOutcome::Same => format!("fusion node {node} had it already"),
        };
        let followers = answer.followers.iter();
        let followers = followers.map(|node| format!("in force on fusion node {node}"));
        let behind = answer.behind.iter();
        let behind = behind.map(|node| format!("fusion node {node} has not taken it over yet"));
        Answered::Done([there].into_iter().chain(followers).chain(behind).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{NodeId, Refusal};

    fn answer(fingerprint: u64, outcome: ChangeOutcome) -> ConfigAnswer {
        ConfigAnswer {
            node: NodeId::new("a").unwrap(),
            key: "config/rig".to_owned(),
            fingerprint,
            outcome,
            followers: vec![NodeId::new("b").unwrap()],
            behind: vec![NodeId::new("c").unwrap()],
        }
    }

    #[test]
    fn the_answer_is_waited_for_but_not_for_ever() {
        let outgoing = Outgoing::Rig(RigConfig {
            cameras: vec![],
            scale_sigma: None,
        });
        let number = outgoing.fingerprint().unwrap();
        let start = Instant::now();
        let mut publication = Publication::of(&outgoing, start).unwrap();
        publication.take(&answer(number + 1, ChangeOutcome::Kept));
        assert_eq!(publication.answered(start), Answered::NotYet);
        let Answered::Done(silence) = publication.answered(start + PATIENCE) else {
            panic!("still waiting");
        };
        assert!(
            silence[0].contains("no fusion node has answered"),
            "{silence:?}"
        );
        publication.take(&answer(number, ChangeOutcome::Kept));
        let Answered::Done(words) = publication.answered(start) else {
            panic!("it is answered");
        };
        assert_eq!(words.len(), 3);
        assert!(
            words[2].contains("c has not taken it over yet"),
            "{words:?}"
        );
        publication.take(&answer(number, ChangeOutcome::Refused(Refusal::NoCamera)));
        let refused = publication.answered(start);
        assert_eq!(
            refused,
            Answered::Refused(
                "a refused it: the rig has no camera; everything stays as it was".to_owned()
            )
        );
    }
}

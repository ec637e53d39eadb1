//! A change on its way to the running site: published as `sextant config set` does, and what the fusion node that
//! publishes the poses answers.

use crate::refusal::{Refusal, RefusalKind};
use sextant_proto::{
    CameraSettings, ChangeOutcome, ConfigAnswer, ObjectConfig, Proposal, Refusal as Cause,
    RigConfig, encode, fingerprint,
};
use std::time::{Duration, Instant};

/// How long the answer may take: the disk of the fusion node may be slow.
const PATIENCE: Duration = Duration::from_secs(15);
/// A change without an answer is published once more after this time.
const REPEAT: Duration = Duration::from_secs(2);

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
pub(crate) struct Publication {
    fingerprint: u64,
    answer: Option<ConfigAnswer>,
    deadline: Instant,
    /// When the change is to be published once more.
    repeat_due: Option<Instant>,
}

/// What became of it.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Answered {
    /// There is no answer, and there is time left.
    NotYet,
    /// It was refused; nothing has changed.
    Refused(Refusal),
    /// It is in force, a sentence for each node.
    Done(Vec<String>),
    /// No fusion node has answered in time, in words.
    Silence(String),
}

impl Publication {
    /// Waits from now on; the cause where the change does not fit into a message.
    pub(crate) fn new(outgoing: &Outgoing, now: Instant) -> Result<Self, String> {
        Ok(Self {
            fingerprint: outgoing.fingerprint()?,
            answer: None,
            deadline: now + PATIENCE,
            repeat_due: Some(now + REPEAT),
        })
    }

    /// When time changes something at the latest.
    pub(crate) fn due(&self) -> Instant {
        self.repeat_due.unwrap_or(self.deadline).min(self.deadline)
    }

    /// Whether the change is to be published again now, once: the fusion node that decides may just have been replaced.
    pub(crate) fn take_repeat(&mut self, now: Instant) -> bool {
        let is_due = self.answer.is_none() && self.repeat_due.is_some_and(|due| now >= due);
        is_due && self.repeat_due.take().is_some()
    }

    pub(crate) fn take(&mut self, answer: &ConfigAnswer) {
        if answer.fingerprint == self.fingerprint {
            self.answer = Some(answer.clone());
        }
    }

    pub(crate) fn answered(&self, now: Instant) -> Answered {
        let Some(answer) = &self.answer else {
            if now < self.deadline {
                return Answered::NotYet;
            }
            let patience_s = PATIENCE.as_secs();
            let silence = "no fusion node has answered";
            return Answered::Silence(format!(
                "{silence} for {patience_s} s: see whether it is in force before you try again"
            ));
        };
        let node = &answer.node;
        let there = match &answer.outcome {
            ChangeOutcome::Refused(cause) => {
                return Answered::Refused(Refusal {
                    kind: RefusalKind::NotNow,
                    field: field_of(cause),
                    cause: format!("{node} refused it: {cause}; everything stays as it was"),
                });
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

/// The field of the form that a fusion node's refusal is about.
fn field_of(cause: &Cause) -> Option<&'static str> {
    match cause {
        Cause::InvalidObject { .. } | Cause::UnknownTag { .. } | Cause::SharedTag { .. } => {
            Some("tags")
        }
        Cause::WrongId { .. } | Cause::TooManyObjects { .. } => Some("id"),
        Cause::Undecodable { .. }
        | Cause::NoCamera
        | Cause::InvalidCamera { .. }
        | Cause::Unpublishable { .. }
        | Cause::NotStored { .. }
        | Cause::Other { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::NodeId;

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
        let mut publication = Publication::new(&outgoing, start).unwrap();
        publication.take(&answer(number + 1, ChangeOutcome::Kept));
        assert_eq!(publication.answered(start), Answered::NotYet);
        let Answered::Silence(silence) = publication.answered(start + PATIENCE) else {
            panic!("still waiting");
        };
        assert!(silence.contains("no fusion node has answered"), "{silence}");
        publication.take(&answer(number, ChangeOutcome::Kept));
        let Answered::Done(words) = publication.answered(start) else {
            panic!("it is answered");
        };
        assert_eq!(words.len(), 3);
        assert!(
            words[2].contains("c has not taken it over yet"),
            "{words:?}"
        );
        publication.take(&answer(number, ChangeOutcome::Refused(Cause::NoCamera)));
        let refused = publication.answered(start);
        assert_eq!(
            refused,
            Answered::Refused(Refusal::not_now(
                "a refused it: the rig has no camera; everything stays as it was"
            ))
        );
    }
}

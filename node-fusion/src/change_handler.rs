//! Changes of the rig and the objects: each is applied whole or refused whole, and answered.

use crate::files::ModelFiles;
use crate::formers::Formers;
use crate::models::{Change, Models};
use crate::pace::Pace;
use crate::refusals::{detail, undecodable};
use sextant_proto::{ANNOUNCED, DecodeError, KeyRef, Keys, Outcome, Refusal, fingerprint};
use sextant_zenoh_bus::{Item, Payload};
use std::time::Instant;

/// Most announcements and other messages that are passed over in one turn.
const PASSED_OVER: usize = 256;

/// Decides on changes and holds the models in force.
pub struct ChangeHandler {
    keys: Keys,
    models: Models,
    files: Option<ModelFiles>,
    formers: Formers,
    /// Keeps a flood of changes from delaying images.
    pace: Pace,
}

/// The decision on one publication under a `config/` key.
#[derive(Debug, PartialEq)]
pub struct Verdict {
    /// The key below the site.
    pub key: String,
    /// What the key stands for.
    pub about: KeyRef,
    /// Of the payload.
    pub fingerprint: u64,
    /// What is to be done.
    pub decision: Decision,
}

/// The decision on a change.
#[derive(Debug, PartialEq)]
pub enum Decision {
    /// To be put in force; the models are changed already.
    Take(Change, Outcome),
    /// In force already.
    Same,
    /// Refused.
    Refuse(Refusal),
}

impl ChangeHandler {
    /// A handler of the models in force; with `files`, changes outlive the process.
    pub fn new(keys: Keys, models: Models, files: Option<ModelFiles>) -> Self {
        Self {
            keys,
            models,
            formers: files
                .as_ref()
                .map_or_else(Formers::default, ModelFiles::formers),
            files,
            pace: Pace::default(),
        }
    }

    /// What is in force.
    pub fn models(&self) -> &Models {
        &self.models
    }

    /// The site's keys.
    pub fn keys(&self) -> &Keys {
        &self.keys
    }

    /// What was in force before.
    pub fn formers(&self) -> &Formers {
        &self.formers
    }

    /// The next publication that is to be decided on, if one is due at `now`; what is no change is passed over. Nothing is taken
    /// from the queue before it is due.
    pub fn next(&self, now: Instant, queue: impl FnMut() -> Option<Item>) -> Option<Item> {
        if !self.pace.is_due(now) {
            return None;
        }
        let mut items = std::iter::from_fn(queue).take(PASSED_OVER);
        items.find(|item| self.change_of(item).is_some())
    }

    /// A change was handled from `begun` to `ended`: the next one waits.
    pub fn rest(&mut self, begun: Instant, ended: Instant) {
        self.pace.rest(begun, ended);
    }

    /// Decides on a publication at `now_ns` since the Unix epoch; none for a key that is no configuration's, and for what a fusion node announces.
    pub fn decide(&mut self, item: &Item, now_ns: u64) -> Option<Verdict> {
        let about = self.change_of(item)?;
        let decision = self.decision(&about, &item.payload, now_ns);
        Some(Verdict {
            key: Keys::below_site(&item.key).to_owned(),
            about,
            fingerprint: item.bytes().map_or(0, fingerprint),
            decision: decision.unwrap_or_else(Decision::Refuse),
        })
    }

    /// What somebody wants changed; none for what is no key of the configuration, and for what a fusion node announces.
    fn change_of(&self, item: &Item) -> Option<KeyRef> {
        let about = self.keys.parse(&item.key)?;
        let is_config = matches!(
            about,
            KeyRef::ConfigRig | KeyRef::ConfigObject(_) | KeyRef::ConfigCamera(_)
        );
        let sender = item.sender.as_deref().unwrap_or_default();
        (is_config && !sender.starts_with(ANNOUNCED)).then_some(about)
    }

    fn decision(
        &mut self,
        about: &KeyRef,
        payload: &Payload,
        now_ns: u64,
    ) -> Result<Decision, Refusal> {
        let bytes = match payload {
            Payload::Bytes(bytes) => bytes,
            Payload::TooLong(length) => return Err(undecodable(DecodeError::TooLong(*length))),
        };
        self.make(Change::read(about, bytes)?, now_ns)
    }

    /// Makes a change at `now_ns`, whole or not at all.
    ///
    /// # Errors
    /// Why it cannot be made.
    pub fn make(&mut self, change: Change, now_ns: u64) -> Result<Decision, Refusal> {
        let Some(after) = self.models.changed(&change)? else {
            return Ok(Decision::Same);
        };
        let outcome = match &mut self.files {
            None => Outcome::Taken,
            Some(files) => {
                let kept = files.keep(&change);
                kept.map_err(|cause| Refusal::NotStored {
                    detail: detail(&cause),
                })?;
                Outcome::Kept
            }
        };
        self.formers.note(&change, &self.models, now_ns);
        self.models = after;
        Ok(Decision::Take(change, outcome))
    }
}

impl Verdict {
    /// What the node answers.
    pub fn outcome(&self) -> Outcome {
        match &self.decision {
            Decision::Take(_, outcome) => outcome.clone(),
            Decision::Same => Outcome::Same,
            Decision::Refuse(refusal) => Outcome::Refused(refusal.clone()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sextant_proto::{ObjectConfig, encode};
    use sextant_site_files::{parse_object, parse_rig};
    use std::path::Path;
    use std::time::Duration;

    const RIG: &str = "[[camera]]\nid = \"north\"\nresolution = [640, 480]\nlens = { model = \"pinhole\", fx = 600.0, fy = 600.0, cx = 319.5, cy = 239.5 }\n";

    fn object(id: &str, tag: u32) -> ObjectConfig {
        let text =
            format!("id = \"{id}\"\n[[tag]]\nfamily = \"tag36h11\"\nid = {tag}\nsize = 0.04\n");
        ObjectConfig::from(&parse_object(Path::new("o"), &text).unwrap())
    }

    fn handler() -> ChangeHandler {
        let rig = parse_rig(Path::new("r"), RIG).unwrap();
        let objects = Vec::new();
        ChangeHandler::new(
            Keys::new("lab").unwrap(),
            Models {
                rig,
                objects,
                settings: Default::default(),
            },
            None,
        )
    }

    fn item(id: &str, message: &ObjectConfig, sender: Option<&str>) -> Item {
        Item {
            key: format!("sextant/v1/lab/config/object/{id}"),
            payload: Payload::Bytes(encode(message).unwrap()),
            sender: sender.map(str::to_owned),
        }
    }

    #[test]
    fn a_change_is_taken_once_and_then_the_same() {
        let mut handler = handler();
        let cube = item("cube", &object("cube", 1), Some("somebody"));
        let verdict = handler.decide(&cube, 1).unwrap();
        assert!(matches!(
            verdict.decision,
            Decision::Take(Change::Object(_), Outcome::Taken)
        ));
        assert_eq!(verdict.key, "config/object/cube");
        assert_eq!(verdict.fingerprint, fingerprint(cube.bytes().unwrap()));
        assert_eq!(handler.decide(&cube, 1).unwrap().decision, Decision::Same);
        assert_eq!(handler.models().objects.len(), 1);
    }

    #[test]
    fn what_is_refused_leaves_everything_as_it_was() {
        let mut handler = handler();
        handler.decide(&item("cube", &object("cube", 1), None), 1);
        let before = handler.models().clone();
        let verdict = handler.decide(&item("ball", &object("ball", 1), None), 1);
        let outcome = verdict.unwrap().outcome();
        assert!(matches!(
            outcome,
            Outcome::Refused(Refusal::SharedTag { .. })
        ));
        let garbage = Item {
            key: "sextant/v1/lab/config/rig".to_owned(),
            payload: Payload::TooLong(1 << 20),
            sender: None,
        };
        let refused = handler.decide(&garbage, 1).unwrap().outcome();
        assert!(matches!(
            refused,
            Outcome::Refused(Refusal::Undecodable { .. })
        ));
        assert_eq!(*handler.models(), before);
    }

    /// Ten times as many changes as the queue holds: one is taken, and the next only after a pause.
    #[test]
    fn a_flood_of_changes_is_taken_one_at_a_time() {
        let mut handler = handler();
        let announced = item("cube", &object("cube", 1), Some("fusion/main"));
        let change = item("cube", &object("cube", 1), Some("somebody"));
        let flood = (0..2560).map(|n| if n % 2 == 0 { &announced } else { &change });
        let mut queue = flood.cloned();
        let start = Instant::now();
        assert_eq!(handler.next(start, || queue.next()), Some(change.clone()));
        assert_eq!(queue.len(), 2558);
        let slow = Duration::from_millis(20);
        handler.rest(start, start + slow);
        assert_eq!(handler.next(start + slow, || queue.next()), None);
        assert_eq!(handler.next(start + 9 * slow, || queue.next()), None);
        assert_eq!(queue.len(), 2558);
        assert!(handler.next(start + 10 * slow, || queue.next()).is_some());
        assert_eq!(queue.len(), 2556);
    }

    #[test]
    fn what_is_no_change_is_passed_over_in_bounded_number() {
        let handler = handler();
        let announced = item("cube", &object("cube", 1), Some("fusion/main"));
        let mut queue = std::iter::repeat_n(announced, 10 * PASSED_OVER);
        assert_eq!(handler.next(Instant::now(), || queue.next()), None);
        assert_eq!(queue.len(), 9 * PASSED_OVER);
    }

    #[test]
    fn announcements_and_other_keys_are_no_changes() {
        let mut handler = handler();
        let announced = item("cube", &object("cube", 1), Some("fusion/other"));
        assert!(handler.decide(&announced, 1).is_none());
        let elsewhere = Item {
            key: "sextant/v1/lab/config/else".to_owned(),
            ..announced
        };
        assert!(handler.decide(&elsewhere, 1).is_none());
    }
}

//! The desk where changes of the rig and the objects are handed in: each is taken whole or refused whole, and answered.

use crate::files::ModelFiles;
use crate::formers::Formers;
use crate::models::{Change, Models};
use crate::pace::Pace;
use sextant_proto::{KeyRef, Keys, Outcome, fingerprint, limits};
use sextant_zenoh_bus::{Item, Payload};
use std::time::Instant;

/// Announcements and other messages that are no changes, passed over in one turn.
const PASSED_OVER: usize = 256;

/// Who decides on changes, and what is in force.
pub struct Desk {
    keys: Keys,
    models: Models,
    files: Option<ModelFiles>,
    formers: Formers,
    /// Floods of changes shall not keep images waiting.
    pace: Pace,
}

/// What becomes of a publication under a `config/` key.
#[derive(Debug, PartialEq)]
pub struct Verdict {
    /// The key below the site.
    pub key: String,
    /// What the key stands for.
    pub about: KeyRef,
    /// Of the payload.
    pub fingerprint: u64,
    /// The outcome; a change that is to be made, or why there is none.
    pub decision: Decision,
}

/// The decision on a change.
#[derive(Debug, PartialEq)]
pub enum Decision {
    /// It is to be put in force; the models are changed already.
    Take(Change, Outcome),
    /// It is in force already.
    Same,
    /// It is not to be put in force.
    Refuse(String),
}

impl Desk {
    /// A desk for the models in force; `files` where changes shall outlive the process.
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
            key: below_site(&item.key).to_owned(),
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
            KeyRef::ConfigRig
                | KeyRef::ConfigObject(_)
                | KeyRef::ConfigArticulated(_)
                | KeyRef::FullRig
                | KeyRef::FullObject(_)
        );
        let sender = item.sender.as_deref().unwrap_or_default();
        (is_config && !sender.starts_with(ANNOUNCED)).then_some(about)
    }

    fn decision(
        &mut self,
        about: &KeyRef,
        payload: &Payload,
        now_ns: u64,
    ) -> Result<Decision, String> {
        let bytes = match payload {
            Payload::Bytes(bytes) => bytes,
            Payload::TooLong(length) => return Err(format!("{length} bytes are too long")),
        };
        self.make(Change::read(about, bytes, &self.models)?, now_ns)
    }

    /// Makes a change at `now_ns`, whole or not at all.
    ///
    /// # Errors
    /// In words, why it can't be made.
    pub fn make(&mut self, change: Change, now_ns: u64) -> Result<Decision, String> {
        let Some(after) = self.models.changed(&change)? else {
            return Ok(Decision::Same);
        };
        let outcome = match &mut self.files {
            None => Outcome::Taken,
            Some(files) => {
                let kept = files.keep(&change);
                kept.map_err(|cause| format!("it cannot be kept: {cause}"))?;
                Outcome::Kept
            }
        };
        self.formers.note(&change, &self.models, now_ns);
        self.models = after;
        Ok(Decision::Take(change, outcome))
    }
}

/// Signature of what fusion nodes announce; their own name follows.
pub const ANNOUNCED: &str = "fusion/";

impl Verdict {
    /// The outcome and its words, as long as an answer may be.
    pub fn outcome(&self) -> (Outcome, String) {
        match &self.decision {
            Decision::Take(_, outcome) => (*outcome, String::new()),
            Decision::Same => (Outcome::Same, String::new()),
            Decision::Refuse(cause) => (
                Outcome::Refused,
                limits::clipped(cause, limits::MAX_SENTENCE_BYTES),
            ),
        }
    }
}

/// A key without `sextant/v1/<site>/`.
fn below_site(key: &str) -> &str {
    key.splitn(4, '/').nth(3).unwrap_or(key)
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

    fn desk() -> Desk {
        let rig = parse_rig(Path::new("r"), RIG).unwrap();
        let objects = Vec::new();
        Desk::new(Keys::new("lab").unwrap(), Models { rig, objects }, None)
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
        let mut desk = desk();
        let cube = item("cube", &object("cube", 1), Some("somebody"));
        let verdict = desk.decide(&cube, 1).unwrap();
        assert!(matches!(
            verdict.decision,
            Decision::Take(Change::Object(_), Outcome::Taken)
        ));
        assert_eq!(verdict.key, "config/object/cube");
        assert_eq!(verdict.fingerprint, fingerprint(cube.bytes().unwrap()));
        assert_eq!(desk.decide(&cube, 1).unwrap().decision, Decision::Same);
        assert_eq!(desk.models().objects.len(), 1);
    }

    #[test]
    fn what_is_refused_leaves_everything_as_it_was() {
        let mut desk = desk();
        desk.decide(&item("cube", &object("cube", 1), None), 1);
        let before = desk.models().clone();
        let verdict = desk.decide(&item("ball", &object("ball", 1), None), 1);
        let (outcome, words) = verdict.unwrap().outcome();
        assert_eq!(outcome, Outcome::Refused);
        assert_eq!(
            words,
            "tag tag36h11:1 is on object cube and on object ball: print another id for one of them"
        );
        let garbage = Item {
            key: "sextant/v1/lab/config/rig".to_owned(),
            payload: Payload::TooLong(1 << 20),
            sender: None,
        };
        let refused = desk.decide(&garbage, 1).unwrap().outcome();
        assert_eq!(refused.0, Outcome::Refused);
        assert_eq!(*desk.models(), before);
    }

    /// Ten times as many changes as the queue holds: one is taken, and the next only after a pause.
    #[test]
    fn a_flood_of_changes_is_taken_one_at_a_time() {
        let mut desk = desk();
        let announced = item("cube", &object("cube", 1), Some("fusion/main"));
        let change = item("cube", &object("cube", 1), Some("somebody"));
        let flood = (0..2560).map(|n| if n % 2 == 0 { &announced } else { &change });
        let mut queue = flood.cloned();
        let start = Instant::now();
        assert_eq!(desk.next(start, || queue.next()), Some(change.clone()));
        assert_eq!(queue.len(), 2558);
        let slow = Duration::from_millis(20);
        desk.rest(start, start + slow);
        assert_eq!(desk.next(start + slow, || queue.next()), None);
        assert_eq!(desk.next(start + 9 * slow, || queue.next()), None);
        assert_eq!(queue.len(), 2558);
        assert!(desk.next(start + 10 * slow, || queue.next()).is_some());
        assert_eq!(queue.len(), 2556);
    }

    #[test]
    fn what_is_no_change_is_passed_over_in_bounded_number() {
        let desk = desk();
        let announced = item("cube", &object("cube", 1), Some("fusion/main"));
        let mut queue = std::iter::repeat_n(announced, 10 * PASSED_OVER);
        assert_eq!(desk.next(Instant::now(), || queue.next()), None);
        assert_eq!(queue.len(), 9 * PASSED_OVER);
    }

    #[test]
    fn announcements_and_other_keys_are_no_changes() {
        let mut desk = desk();
        let announced = item("cube", &object("cube", 1), Some("fusion/other"));
        assert!(desk.decide(&announced, 1).is_none());
        let elsewhere = Item {
            key: "sextant/v1/lab/config/else".to_owned(),
            ..announced
        };
        assert!(desk.decide(&elsewhere, 1).is_none());
    }
}
